//! What is decided once per model: the blocks, their supports, order and sparse lists.
//!
//! A block is one family of shapes (all dofs, or the symmetric or the antisymmetric ones). Its rigid-body modes are
//! removed exactly: r statically determinate supports hold the structure, and an elastic mode is the supported
//! deformation ψ plus the rigid motion that makes it M-orthogonal to all rigid motions,
//!
//! ```text
//! φ = [ψ; 0] + R c,  c = -(Rᵀ M R)⁻¹ Rᵀ M [ψ; 0]      =>      K_ff ψ = λ (M_ff - W Wᵀ) ψ,  W = (M R)_f L_G⁻ᵀ
//! ```
//!
//! with R the rigid motions that move one support by one each and L_G L_Gᵀ = Rᵀ M R. K_ff is regular, and the
//! supports stand where the structure is stiffest, so that the inverse stays accurate.

use std::collections::{BTreeMap, BTreeSet};

use super::mirror::{Family, Terms};
use super::pencil::AffinePencil;
use crate::envelope::{Envelope, reverse_cuthill_mckee};
use crate::{DMatrix, DVectorView};

/// Entries affine in θ: `constant[s] + Σ coefficient * θ[parameter]`, the terms of slot s being start[s] .. start[s+1].
#[derive(Debug, Clone, Default)]
pub(super) struct SlotList {
    pub(super) constant: Vec<f64>,
    pub(super) start: Vec<usize>,
    pub(super) parameter: Vec<u32>,
    pub(super) coefficient: Vec<f64>,
}

impl SlotList {
    fn new(slots: &[Terms], scale: f64) -> Self {
        let mut list = Self { start: vec![0], ..Self::default() };
        for terms in slots {
            let mut constant = 0.0;
            for &(parameter, coefficient) in terms {
                match parameter {
                    None => constant += coefficient * scale,
                    Some(p) => {
                        list.parameter.push(p as u32);
                        list.coefficient.push(coefficient * scale);
                    }
                }
            }
            list.constant.push(constant);
            list.start.push(list.parameter.len());
        }
        list
    }
}

/// Rows of an observation matrix over the coordinates of a block: row s is Σ coefficient * φ[coordinate].
#[derive(Debug, Clone)]
pub(super) struct Observation {
    pub(super) start: Vec<usize>,
    pub(super) coordinate: Vec<u32>,
    pub(super) coefficient: Vec<f64>,
}

impl Default for Observation {
    /// Without rows.
    fn default() -> Self {
        Self { start: vec![0], coordinate: Vec::new(), coefficient: Vec::new() }
    }
}

impl Observation {
    fn push(&mut self, row: impl IntoIterator<Item = (u32, f64)>) {
        for (coordinate, coefficient) in row {
            self.coordinate.push(coordinate);
            self.coefficient.push(coefficient);
        }
        self.start.push(self.coordinate.len());
    }

    fn rows(&self) -> impl Iterator<Item = (&[u32], &[f64])> {
        self.start.windows(2).map(|w| (&self.coordinate[w[0]..w[1]], &self.coefficient[w[0]..w[1]]))
    }
}

/// What gives products of the shapes at the sensors from the coordinates: with u = S φ and references r,
/// rᵀ u = (Sᵀ r)ᵀ φ and uᵀ u = |S' φ|², S' being S with one row, longer, for all rows that are parallel (both sides of a plane of
/// symmetry, several sensors on one body).
#[derive(Debug, Clone, Default)]
pub(super) struct Products {
    /// Sᵀ r, reference by reference (references x m + r).
    pub(super) references: Vec<f64>,
    /// S'.
    pub(super) squares: Observation,
}

impl Products {
    /// * `references` - row by row (sensors x references)
    fn new(observation: &Observation, coordinates: usize, references: &[f64]) -> Self {
        let sensors = observation.start.len() - 1;
        let n = references.len() / sensors.max(1);
        let mut products = Self { references: vec![0.0; coordinates * n], ..Self::default() };
        let mut lengths: Vec<f64> = Vec::new();
        let mut distinct: Vec<(&[u32], &[f64])> = Vec::new();
        for (s, (at, row)) in observation.rows().enumerate() {
            for (&c, &factor) in at.iter().zip(row) {
                for (k, value) in references[s * n..(s + 1) * n].iter().enumerate() {
                    products.references[k * coordinates + c as usize] += factor * value;
                }
            }
            if row.is_empty() {
                continue;
            }
            let ratio = |other: &[f64]| {
                let ratio = row[0] / other[0];
                // To rounding of the coefficients.
                row.iter().zip(other).all(|(a, b)| (a - ratio * b).abs() <= 1e-15 * a.abs()).then_some(ratio)
            };
            match distinct.iter().enumerate().find_map(|(k, d)| (d.0 == at).then(|| Some((k, ratio(d.1)?)))?) {
                Some((k, ratio)) => lengths[k] += ratio * ratio,
                None => {
                    distinct.push((at, row));
                    lengths.push(1.0);
                }
            }
        }
        for ((at, row), length) in distinct.into_iter().zip(lengths) {
            products.squares.push(at.iter().copied().zip(row.iter().map(|c| length.sqrt() * c)));
        }
        products
    }
}

/// One half problem (or the whole one), compiled.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// That of its family of shapes.
    pub(super) parity: i8,
    /// Number of coordinates without the supports.
    pub(super) m: usize,
    /// Number of rigid-body modes, and so of supports.
    pub(super) r: usize,
    /// Shared by K_ff and M_ff.
    pub(super) envelope: Envelope,
    pub(super) stiffness: SlotList,
    pub(super) mass: SlotList,
    /// (M R)_f, m x r row by row.
    pub(super) mass_rigid: SlotList,
    /// Rᵀ M R, lower triangle row by row.
    pub(super) rigid_gram: SlotList,
    /// R_f, m x r row by row; at the supports R is the identity.
    pub(super) rigid: Vec<f64>,
    /// Sensors over the coordinates: first the m free ones, then the r supports.
    pub(super) observation: Observation,
    /// Where products with references are wanted.
    pub(super) products: Option<Products>,
}

/// Compiles one family of shapes.
///
/// * `rigid` - exact null space of K (n x r), all of it
/// * `nominal` - diagonal of K at the nominal parameters, for the choice of supports
/// * `mass_scale` - factor of all masses, a power of four
/// * `sensors` - observation rows (n_rows x n)
/// * `references` - at the sensors, row by row
/// * `shifted` - whether K + a M is factored: without its rigid motions M is full
pub(super) fn compile(
    pencil: &AffinePencil,
    family: &Family,
    rigid: &DMatrix<f64>,
    nominal: &[f64],
    mass_scale: f64,
    (sensors, references): (&DMatrix<f64>, Option<&[f64]>),
    shifted: bool,
) -> Block {
    let nb = family.pairs.len();
    let stiffness = family.project(pencil.n, &pencil.stiffness);
    let mass = family.project(pencil.n, &pencil.mass);
    // The part of the rigid motions in this family, in its coordinates.
    let motions = DMatrix::from_fn(nb, rigid.ncols(), |c, j| match family.pairs[c] {
        (i, Some((partner, sign))) => 0.5 * (rigid[(i, j)] + sign * rigid[(partner, j)]),
        (i, None) => rigid[(i, j)],
    });
    let weights: Vec<f64> = family.pairs.iter().map(|&(i, _)| nominal[i].max(0.0).sqrt()).collect();
    // A motion that the other family has alone is here at rounding level.
    let whole =
        |column: DVectorView<'_, f64>| column.iter().zip(nominal).map(|(v, k)| k.max(0.0) * v * v).sum::<f64>().sqrt();
    let sizes: Vec<f64> = rigid.column_iter().map(whole).collect();
    let supports = supports(&motions, &weights, &sizes);
    let r = supports.len();
    let free: Vec<usize> = (0..nb).filter(|c| !supports.contains(c)).collect();
    let free = ordered(&free, &stiffness, &mass);
    let m = free.len();
    let rigid = unit_motions(&motions, &supports);

    let mut position = vec![None; nb];
    for (new, &c) in free.iter().enumerate() {
        position[c] = Some(new);
    }
    let mut first: Vec<usize> = if shifted && r > 0 { vec![0; m] } else { (0..m).collect() };
    for &(c, d) in stiffness.keys().chain(mass.keys()) {
        if let (Some(i), Some(j)) = (position[c], position[d]) {
            first[i.max(j)] = first[i.max(j)].min(i.min(j));
        }
    }
    let envelope = Envelope::new(first);
    let in_envelope = |entries: &BTreeMap<(usize, usize), Terms>, scale: f64| {
        let mut slots = vec![Terms::new(); envelope.len()];
        for (&(c, d), terms) in entries {
            if let (Some(i), Some(j)) = (position[c], position[d]) {
                slots[envelope.at(i.max(j), i.min(j))].clone_from(terms);
            }
        }
        SlotList::new(&slots, scale)
    };
    // M R per parameter, then its rows at the free coordinates and Rᵀ M R.
    let mut product: Vec<BTreeMap<Option<usize>, f64>> = vec![BTreeMap::new(); nb * r];
    for (&(c, d), terms) in &mass {
        for &(parameter, value) in terms {
            for k in 0..r {
                *product[c * r + k].entry(parameter).or_default() += value * rigid[(d, k)];
                if c != d {
                    *product[d * r + k].entry(parameter).or_default() += value * rigid[(c, k)];
                }
            }
        }
    }
    let terms = |map: &BTreeMap<Option<usize>, f64>| map.iter().map(|(&p, &v)| (p, v)).collect::<Terms>();
    let mass_rigid: Vec<Terms> =
        free.iter().flat_map(|&c| (0..r).map(move |k| c * r + k)).map(|at| terms(&product[at])).collect();
    let mut gram = Vec::new();
    for k in 0..r {
        for l in 0..=k {
            let mut sum: BTreeMap<Option<usize>, f64> = BTreeMap::new();
            for c in 0..nb {
                for (&p, &v) in &product[c * r + l] {
                    *sum.entry(p).or_default() += v * rigid[(c, k)];
                }
            }
            gram.push(terms(&sum));
        }
    }
    let column = |c: usize| position[c].unwrap_or_else(|| m + supports.iter().position(|&s| s == c).unwrap_or(0));
    let mut observation = Observation::default();
    for row in sensors.row_iter() {
        let values = family.pairs.iter().map(|&(i, partner)| row[i] + partner.map_or(0.0, |(j, sign)| sign * row[j]));
        let seen = values.enumerate().filter(|(_, value)| *value != 0.0);
        observation.push(seen.map(|(c, value)| (column(c) as u32, value)));
    }
    Block {
        parity: family.parity,
        m,
        r,
        stiffness: in_envelope(&stiffness, 1.0),
        mass: in_envelope(&mass, mass_scale),
        mass_rigid: SlotList::new(&mass_rigid, mass_scale),
        rigid_gram: SlotList::new(&gram, mass_scale),
        rigid: free.iter().flat_map(|&c| (0..r).map(move |k| (c, k))).map(|at| rigid[at]).collect(),
        products: references.map(|r| Products::new(&observation, m + supports.len(), r)),
        observation,
        envelope,
    }
}

/// Reverse Cuthill-McKee order of the free coordinates.
fn ordered(
    free: &[usize],
    stiffness: &BTreeMap<(usize, usize), Terms>,
    mass: &BTreeMap<(usize, usize), Terms>,
) -> Vec<usize> {
    let index: BTreeMap<usize, usize> = free.iter().enumerate().map(|(new, &c)| (c, new)).collect();
    let mut neighbours = vec![BTreeSet::new(); free.len()];
    for (c, d) in stiffness.keys().chain(mass.keys()).filter(|(c, d)| c != d) {
        if let (Some(&i), Some(&j)) = (index.get(c), index.get(d)) {
            neighbours[i].insert(j);
            neighbours[j].insert(i);
        }
    }
    reverse_cuthill_mckee(&neighbours).into_iter().map(|new| free[new]).collect()
}

/// Coordinates that hold all rigid motions of the block, one per motion: the rows of D R that a Gram-Schmidt with
/// pivoting picks, D = sqrt(diag K). They do not depend on the units of the dofs, and they are the stiffest ones.
fn supports(motions: &DMatrix<f64>, weights: &[f64], sizes: &[f64]) -> Vec<usize> {
    let (nb, columns) = (motions.nrows(), motions.ncols());
    let weighted = DMatrix::from_fn(nb, columns, |c, j| weights[c] * motions[(c, j)]);
    // An orthonormal basis of the columns, the longest one first; what is left at rounding level is not motion.
    let mut left = weighted;
    for (mut column, size) in left.column_iter_mut().zip(sizes) {
        let norm = column.norm();
        if norm > 1e-8 * size {
            column /= norm;
        } else {
            column.fill(0.0);
        }
    }
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for _ in 0..columns.min(nb) {
        let longest = (0..columns).max_by(|&a, &b| left.column(a).norm().total_cmp(&left.column(b).norm()));
        let Some(q) = longest.map(|j| left.column(j).clone_owned()).filter(|q| q.norm() > 1e-8) else { break };
        let q = &q / q.norm();
        for mut column in left.column_iter_mut() {
            for _ in 0..2 {
                let dot = q.dot(&column);
                column.axpy(-dot, &q, 1.0);
            }
        }
        basis.push(q.as_slice().to_vec());
    }
    let mut rows: Vec<Vec<f64>> = (0..nb).map(|c| basis.iter().map(|q| q[c]).collect()).collect();
    let mut picked = Vec::new();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    for _ in 0..basis.len() {
        let Some(best) = (0..nb).max_by(|&a, &b| dot(&rows[a], &rows[a]).total_cmp(&dot(&rows[b], &rows[b]))) else {
            break;
        };
        let norm2 = dot(&rows[best], &rows[best]);
        let chosen = rows[best].clone();
        for row in &mut rows {
            let factor = dot(row, &chosen) / norm2;
            row.iter_mut().zip(&chosen).for_each(|(x, y)| *x -= factor * y);
        }
        picked.push(best);
    }
    picked.sort_unstable();
    picked
}

/// The rigid motions that move one support by one and leave the other ones at rest (nb x r).
fn unit_motions(motions: &DMatrix<f64>, supports: &[usize]) -> DMatrix<f64> {
    let r = supports.len();
    if r == 0 {
        return DMatrix::zeros(motions.nrows(), 0);
    }
    // R = Q X with (Q X) at the supports equal to the identity: least squares over the (possibly dependent) columns.
    let at_supports = DMatrix::from_fn(r, motions.ncols(), |k, j| motions[(supports[k], j)]);
    let svd = at_supports.svd(true, true);
    let tolerance = 1e-9 * svd.singular_values.max();
    let inverse = svd.pseudo_inverse(tolerance).unwrap_or_else(|_| DMatrix::zeros(motions.ncols(), r));
    motions * inverse
}
