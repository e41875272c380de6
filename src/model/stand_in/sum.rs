//! Terms of K, M and C on few coordinates, as they are summed.

use crate::linalg::{DMatrix, SymMatrix, tall_tr_mul};
use crate::model::assembly::{AffineMass, AffinePart, Basis};
use crate::model::connection::{Connection, place};
use crate::model::dependence::Monomial;
use crate::model::entry::lower_entries;
use crate::model::system::System;
use crate::model::{ElementMatrices, Model, ParametricModel};
use std::collections::BTreeMap;

/// Number of the rigid vectors of a basis, coordinates of the six rigid motions, (n_basis x 6), and those vectors as sums of the motions, (6 x
/// n_rigid): by least squares, as products with X lose digits of motions that K does not strain.
///
/// * `about` - the coordinates to some digits; zero for what is not a motion of the structure
pub(super) fn rigid(model: &Model, basis: &DMatrix<f64>, about: &DMatrix<f64>) -> (usize, DMatrix<f64>, DMatrix<f64>) {
    const ROUNDING: f64 = 1e-12;
    let n_rigid = about.row_iter().take_while(|row| row.amax() > 0.0).count();
    let (mut coordinates, none) = (DMatrix::zeros(basis.ncols(), 6), DMatrix::zeros(6, n_rigid));
    if n_rigid == 0 {
        return (0, coordinates, none);
    }
    let v = basis.columns(0, n_rigid).into_owned();
    let motions = model.dof_map().rigid_motions();
    let Some(inverse) = v.tr_mul(&v).try_inverse() else { return (n_rigid, about.clone(), none) };
    let all = inverse * v.tr_mul(&motions);
    let left = &motions - &v * &all;
    for k in (0..6).filter(|&k| left.column(k).amax() <= 1e-6 * motions.column(k).amax()) {
        coordinates.view_mut((0, k), (n_rigid, 1)).copy_from(&all.column(k));
    }
    let own = coordinates.rows(0, n_rigid).into_owned();
    let least = 1e-9 * own.amax();
    let mut parts = if least > 0.0 { own.pseudo_inverse(least).unwrap_or(none) } else { none };
    // What rounding has left of one motion in another would strain what the other does not.
    let norms: Vec<f64> = motions.column_iter().map(|m| m.norm()).collect();
    for mut column in parts.column_iter_mut() {
        let largest = column.iter().zip(&norms).map(|(part, norm)| part.abs() * norm).fold(0.0, f64::max);
        let small = |(part, norm): &(&mut f64, &f64)| part.abs() * **norm < ROUNDING * largest;
        column.iter_mut().zip(&norms).filter(small).for_each(|(part, _)| *part = 0.0);
    }
    (n_rigid, coordinates, parts)
}

/// One term as it is summed: lower triangles of K, M and C, and Rᵀ M R of the six rigid motions.
#[derive(Clone)]
pub(super) struct Summed {
    pub(super) matrices: [DMatrix<f64>; 3],
    pub(super) rigid: SymMatrix,
}

impl Summed {
    fn zeros(size: usize) -> Self {
        Self { matrices: [(); 3].map(|()| DMatrix::zeros(size, size)), rigid: SymMatrix::zeros(6) }
    }
}

/// The terms of a model and of its changes as they are summed.
pub(super) struct Sum {
    size: usize,
    pub(super) constant: Summed,
    parameters: Vec<Option<Summed>>,
    products: BTreeMap<Monomial, Summed>,
}

impl Sum {
    pub(super) fn new(size: usize, n_parameters: usize) -> Self {
        let parameters = vec![None; n_parameters];
        Self { size, constant: Summed::zeros(size), parameters, products: BTreeMap::new() }
    }

    pub(super) fn parameter(&mut self, j: usize) -> &mut Summed {
        self.parameters[j].get_or_insert_with(|| Summed::zeros(self.size))
    }

    pub(super) fn product(&mut self, monomial: &Monomial) -> &mut Summed {
        self.products.entry(monomial.clone()).or_insert_with(|| Summed::zeros(self.size))
    }

    /// The term of a monomial; of a parameter alone its own.
    pub(super) fn term(&mut self, monomial: &Monomial) -> &mut Summed {
        match monomial.powers.as_slice() {
            [] => &mut self.constant,
            [(j, 1)] => self.parameter(*j),
            _ => self.product(monomial),
        }
    }

    /// The matrices, and the masses of the rigid motions, by term.
    pub(super) fn into_affine(self) -> (AffinePart, AffineMass) {
        let basis = |summed: &Summed| {
            let [stiffness, mass, damping] = summed.matrices.each_ref().map(lower_entries);
            Basis { stiffness, mass, damping }
        };
        let rigid = |summed: &Option<Summed>| summed.as_ref().map_or_else(|| SymMatrix::zeros(6), |s| s.rigid.clone());
        let linear = std::iter::once(self.constant.rigid.clone()).chain(self.parameters.iter().map(rigid)).collect();
        let mass = AffineMass { linear, products: self.products.values().map(|s| s.rigid.clone()).collect() };
        let affine = AffinePart {
            constant: basis(&self.constant),
            parameters: self.parameters.iter().map(|p| p.as_ref().map_or_else(Basis::default, basis)).collect(),
            products: self.products.iter().map(|(monomial, all)| (monomial.clone(), basis(all))).collect(),
        };
        (affine, mass)
    }
}

/// K, M and C of a system, to be added to.
pub(super) fn of_system(system: &mut System) -> [Option<&mut DMatrix<f64>>; 3] {
    [Some(&mut system.stiffness), Some(&mut system.mass), system.damping.as_mut()]
}

/// Adds K, M and C that are on the coordinates.
pub(super) fn add(into: &mut Summed, matrices: &ElementMatrices) {
    for (target, a) in into.matrices.iter_mut().zip([&matrices.stiffness, &matrices.mass, &matrices.damping]) {
        if !a.is_zero() {
            *target += a.to_dense();
        }
    }
}

/// Σ Bᵀ a B of elements on coordinates that move the rows they hang on:
///
/// ```text
/// MᵀF,    F = Σ_e B_eᵀ a_e B_e M
/// ```
///
/// so that what grows with the square of the number of coordinates is done once for all elements. Bᵀ a B is smaller than a where rotations
/// hang on nothing, as those of solids.
pub(super) struct Projection<'a> {
    rows: &'a [usize],
    motion: &'a Motion,
    n_rigid: usize,
    /// Fᵀ of K, M and C, (coordinates x rows).
    forces: [Option<DMatrix<f64>>; 3],
}

/// How rows move with the coordinates.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// M, (rows x coordinates).
    pub(super) of_rows: DMatrix<f64>,
    /// Mᵀ: what one row moves by stands together.
    transposed: DMatrix<f64>,
}

impl Motion {
    pub(super) fn new(of_rows: DMatrix<f64>) -> Self {
        let transposed = of_rows.transpose();
        Self { of_rows, transposed }
    }
}

impl<'a> Projection<'a> {
    /// * `rows` - all rows that elements hang on, ascending
    /// * `n_rigid` - the first so many coordinates are rigid motions
    pub(super) fn new(rows: &'a [usize], motion: &'a Motion, n_rigid: usize) -> Self {
        Self { rows, motion, n_rigid, forces: [const { None }; 3] }
    }

    /// Takes in an element whose dofs follow as B q\[rows\].
    ///
    /// A rigid motion that it does not strain meets no force: what is left is rounding.
    pub(super) fn take(&mut self, connection: &Connection, matrices: &ElementMatrices) {
        const ROUNDING: f64 = 1e-9;
        let places: Vec<usize> = connection.rows.iter().map(|&row| place(self.rows, row)).collect();
        let motion = &self.motion.transposed;
        let parts = [(&matrices.stiffness, self.n_rigid), (&matrices.mass, 0), (&matrices.damping, self.n_rigid)];
        for (sum, (a, n_rigid)) in self.forces.iter_mut().zip(parts) {
            if a.is_zero() {
                continue;
            }
            let a = connection.reduce(a);
            let sum = sum.get_or_insert_with(|| DMatrix::zeros(motion.nrows(), motion.ncols()));
            // By rigid motion: the largest force of this element, and the largest that does not cancel.
            let (mut largest, mut whole) = ([0.0_f64; 6], [0.0_f64; 6]);
            let mut rigid = DMatrix::<f64>::zeros(n_rigid, places.len());
            for (i, &to) in places.iter().enumerate() {
                let mut size = [0.0; 6];
                let mut force = sum.column_mut(to);
                let mut strained = force.rows_mut(n_rigid, motion.nrows() - n_rigid);
                for (j, &from) in places.iter().enumerate().filter(|&(j, _)| a[(i, j)] != 0.0) {
                    let (value, moves) = (a[(i, j)], motion.column(from));
                    strained.axpy(value, &moves.rows(n_rigid, motion.nrows() - n_rigid), 1.0);
                    for k in 0..n_rigid {
                        rigid[(k, i)] += value * moves[k];
                        size[k] += (value * moves[k]).abs();
                    }
                }
                for k in 0..n_rigid {
                    largest[k] = largest[k].max(rigid[(k, i)].abs());
                    whole[k] = whole[k].max(size[k]);
                }
            }
            for k in (0..n_rigid).filter(|&k| largest[k] > ROUNDING * whole[k]) {
                places.iter().enumerate().for_each(|(i, &to)| sum[(k, to)] += rigid[(k, i)]);
            }
        }
    }

    /// Adds MᵀF of K, M and C.
    pub(super) fn add_to(self, into: [Option<&mut DMatrix<f64>>; 3]) {
        for ((target, forces), n_rigid) in into.into_iter().zip(self.forces).zip([self.n_rigid, 0, self.n_rigid]) {
            let (Some(target), Some(forces)) = (target, forces) else { continue };
            let mut own = tall_tr_mul(&self.motion.of_rows, &forces.transpose());
            // Without a force on it a rigid motion has no part in those of the others either.
            for j in (0..n_rigid).filter(|&j| forces.row(j).amax() == 0.0) {
                own.row_mut(j).fill(0.0);
            }
            *target += own;
        }
    }
}
