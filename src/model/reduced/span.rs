//! Vectors that are orthonormal in X = K + aM, each of one family of a symmetry.

use crate::linalg::sparse::SparseSym;
use crate::linalg::{DMatrix, DVector, symmetric_eigen, tall_take, tall_tr_mul};
use crate::model::{ModelError, ParametricModel};

/// The span of some vectors.
#[derive(Debug)]
pub(super) struct Span<'a> {
    model: &'a dyn ParametricModel,
    stiffness: SparseSym,
    mass: SparseSym,
    shift: f64,
    vectors: Vec<DVector<f64>>,
    /// X times the vectors.
    images: Vec<DVector<f64>>,
    /// 1 for a vector that is its own mirror image, -1 for one that is its negative, 0 without a symmetry.
    signs: Vec<f64>,
}

impl<'a> Span<'a> {
    /// Nothing yet, with the X of a model at θ.
    pub(super) fn new(model: &'a dyn ParametricModel, theta: &[f64], shift: f64) -> Result<Self, ModelError> {
        let system = model.assemble_sparse(theta)?;
        Ok(Self {
            model,
            stiffness: system.stiffness,
            mass: system.mass,
            shift,
            vectors: Vec::new(),
            images: Vec::new(),
            signs: Vec::new(),
        })
    }

    pub(super) fn len(&self) -> usize {
        self.vectors.len()
    }

    /// The vectors as columns.
    pub(super) fn vectors(&self) -> DMatrix<f64> {
        let n = self.model.dof_map().n_dof();
        if self.vectors.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(&self.vectors) }
    }

    /// The sign of every vector under the mirror, where the model has one.
    pub(super) fn signs(&self) -> Option<Vec<f64>> {
        self.model.mirror().is_some().then(|| self.signs.clone())
    }

    fn image(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        self.stiffness.mul(x) + self.mass.mul(x) * self.shift
    }

    /// √(vᵀ X v).
    pub(super) fn norm(&self, v: &DVector<f64>) -> f64 {
        let v = DMatrix::from_columns(std::slice::from_ref(v));
        v.dot(&self.image(&v)).max(0.0).sqrt()
    }

    /// The same vectors with √(vᵀ X v) = 1; without those of no norm.
    pub(super) fn of_unit_norm(&self, vectors: &DMatrix<f64>) -> DMatrix<f64> {
        let image = self.image(vectors);
        let norm = |j: usize| vectors.column(j).dot(&image.column(j)).max(0.0).sqrt();
        let kept: Vec<(usize, f64)> = (0..vectors.ncols()).map(|j| (j, norm(j))).filter(|n| n.1 > 0.0).collect();
        DMatrix::from_fn(vectors.nrows(), kept.len(), |i, c| vectors[(i, kept[c].0)] / kept[c].1)
    }

    /// The six rigid motions, in coordinates; zero where they are not modes of the structure.
    pub(super) fn coordinates_of_rigid_motions(&self, n_rigid: usize) -> DMatrix<f64> {
        let motions = self.model.dof_map().rigid_motions();
        let rows = self.images.iter().enumerate();
        let mut out = DMatrix::zeros(self.len(), motions.ncols());
        for (i, image) in rows.filter(|(i, _)| *i < n_rigid) {
            out.row_mut(i).copy_from(&motions.tr_mul(image).transpose());
        }
        out
    }

    /// Adds rigid-body modes, as motions along and about the axes as far as they can be, one after the other: a change that strains some of them then
    /// leaves the others alone to the last digit.
    pub(super) fn add_rigid(&mut self, modes: &DMatrix<f64>) {
        // A motion that others hold, or that has another sign under the mirror, is rounding.
        const LEAST: f64 = 1e-8;
        let pure = self.of_unit_norm(&self.pure(modes));
        for motion in pure.column_iter() {
            self.add(&DMatrix::from_columns(&[motion]), LEAST);
        }
    }

    /// Vectors that span the same as rigid-body modes do, each of as few of the six rigid motions as it can be.
    fn pure(&self, modes: &DMatrix<f64>) -> DMatrix<f64> {
        const ROUNDING: f64 = 1e-10;
        let motions = self.model.dof_map().rigid_motions();
        let norms: Vec<f64> = motions.column_iter().map(|m| m.norm()).collect();
        let moving: Vec<usize> = (0..motions.ncols()).filter(|&k| norms[k] > 0.0).collect();
        let motions =
            DMatrix::from_fn(motions.nrows(), moving.len(), |i, k| motions[(i, moving[k])] / norms[moving[k]]);
        if modes.ncols() >= moving.len() {
            return motions;
        }
        let Ok(inverse) = motions.clone().pseudo_inverse(ROUNDING) else { return modes.clone() };
        // Rows are modes as sums of motions; each is freed of the motion that another has most of.
        let mut sums = (inverse * modes).transpose();
        for row in 0..sums.nrows() {
            let (mut most, mut pivot) = (0.0, (row, 0));
            for at in (row..sums.nrows()).flat_map(|i| (0..sums.ncols()).map(move |k| (i, k))) {
                if sums[at].abs() > most {
                    (most, pivot) = (sums[at].abs(), at);
                }
            }
            if most == 0.0 {
                return modes.clone();
            }
            sums.swap_rows(row, pivot.0);
            let own = sums.row(row) / sums[(row, pivot.1)];
            sums.set_row(row, &own);
            for other in (0..sums.nrows()).filter(|&i| i != row) {
                let rest = sums.row(other) - &own * sums[(other, pivot.1)];
                sums.set_row(other, &rest);
            }
        }
        let largest = sums.amax();
        motions * sums.map(|s| if s.abs() < ROUNDING * largest { 0.0 } else { s }).transpose()
    }

    /// Adds vectors, all but those of a norm below `least` across those that are there.
    pub(super) fn add(&mut self, candidates: &DMatrix<f64>, least: f64) -> usize {
        self.add_best(candidates, least, candidates.ncols())
    }

    /// Adds the leading directions of some vectors, at most `most`: those whose singular value across what is there is at least
    /// `least`. The number of them.
    pub(super) fn add_best(&mut self, candidates: &DMatrix<f64>, least: f64, most: usize) -> usize {
        let mut found: Vec<(f64, f64, DVector<f64>)> = Vec::new();
        for (sign, part) in self.families(candidates) {
            let part = self.across(part, sign);
            let gram = tall_tr_mul(&part, &self.image(&part));
            let Ok(eigen) = symmetric_eigen(&gram) else { continue };
            for (value, u) in eigen.values.iter().zip(eigen.vectors.column_iter()) {
                let size = value.max(0.0).sqrt();
                if size > least {
                    found.push((size, sign, &part * u / size));
                }
            }
        }
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.truncate(most);
        let before = self.len();
        // Once more across what is there, and across each other.
        let mut new: Vec<(usize, f64, DVector<f64>, DVector<f64>)> = Vec::new();
        for sign in [1.0, -1.0, 0.0] {
            let of_sign: Vec<usize> = (0..found.len()).filter(|&i| found[i].1 == sign).collect();
            if of_sign.is_empty() {
                continue;
            }
            let columns: Vec<_> = of_sign.iter().map(|&i| found[i].2.column(0)).collect();
            let block = self.across(DMatrix::from_columns(&columns), sign);
            let images = self.image(&block);
            let first = new.len();
            for (k, &place) in of_sign.iter().enumerate() {
                let (mut v, mut image) = (block.column(k).into_owned(), images.column(k).into_owned());
                for _ in 0..2 {
                    for (_, _, other, other_image) in &new[first..] {
                        let along = v.dot(other_image);
                        v.axpy(-along, other, 1.0);
                        image.axpy(-along, other_image, 1.0);
                    }
                }
                let norm = v.dot(&image).max(0.0).sqrt();
                // What rounding has left of a vector of unit norm is not a direction.
                if norm > 1e-3 {
                    new.push((place, sign, v / norm, image / norm));
                }
            }
        }
        new.sort_by_key(|n| n.0);
        for (_, sign, vector, image) in new {
            self.vectors.push(vector);
            self.images.push(image);
            self.signs.push(sign);
        }
        self.len() - before
    }

    /// The symmetric and the antisymmetric part of vectors.
    fn families(&self, vectors: &DMatrix<f64>) -> Vec<(f64, DMatrix<f64>)> {
        let Some(mirror) = self.model.mirror() else { return vec![(0.0, vectors.clone())] };
        let image = |i: usize, j: usize| mirror[i].1 * vectors[(mirror[i].0, j)];
        let part = |sign: f64| {
            let (n, count) = vectors.shape();
            (sign, DMatrix::from_fn(n, count, |i, j| 0.5 * (vectors[(i, j)] + sign * image(i, j))))
        };
        vec![part(1.0), part(-1.0)]
    }

    /// What vectors of a family have across those that are there.
    fn across(&self, mut x: DMatrix<f64>, sign: f64) -> DMatrix<f64> {
        let of_family: Vec<usize> = (0..self.len()).filter(|&i| self.signs[i] == sign).collect();
        if of_family.is_empty() {
            return x;
        }
        let columns = |all: &[DVector<f64>]| {
            DMatrix::from_columns(&of_family.iter().map(|&i| all[i].column(0)).collect::<Vec<_>>())
        };
        let (vectors, images) = (columns(&self.vectors), columns(&self.images));
        for _ in 0..2 {
            let along = tall_tr_mul(&images, &x);
            tall_take(&mut x, &vectors, &along);
        }
        x
    }
}
