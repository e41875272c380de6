//! Lowest modes of a structure, free or supported.

use super::modes::{ModalError, Modes};
use super::stability::{check_stable, dense_unstable_or};
use retune_linalg::{DMatrix, DVector, Eigenpairs, LinalgError, ShiftedPencil, lowest_values, symmetric_eigen};
use std::sync::Arc;

/// How to solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveOptions {
    /// Number of elastic modes wanted; fewer come out of a small model.
    pub n_elastic: usize,
    /// Shift a of the inverse problem, rad²/s²: about the first elastic λ; found when absent.
    pub shift: Option<f64>,
}

/// The lowest modes of K φ = ω² M φ.
///
/// * `stiffness`, `mass` - K and M (n x n), symmetric; the lower triangles are read
/// * `rigid_motions` - the values of the dofs for the six rigid motions (n x 6); which of their combinations are
///   rigid-body modes of this structure is found from their strain energy
///
/// Rigid-body modes come out with λ = 0 exactly and the geometric shape; elastic shapes are M-orthogonal to them. The complete basis comes
/// with them: the decomposition has found it anyway.
///
/// # Errors
/// [`ModalError::Unstable`] where a λ is negative, as of a buckled structure; the others of [`ModalError`].
pub fn solve(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    rigid_motions: &DMatrix<f64>,
    options: SolveOptions,
) -> Result<Modes, ModalError> {
    let solved = || {
        let (rigid, shift) = prepare(stiffness, mass, rigid_motions, options)?;
        let pencil = ShiftedPencil::new(stiffness, mass, shift)?;
        let pairs = Eigenpairs::lowest_of(&pencil, rigid.ncols() + options.n_elastic);
        Ok(Modes { basis: Some(Arc::new(pencil)), ..sorted(stiffness, mass, &rigid, &pairs, shift)? })
    };
    solved().map_err(|e| dense_unstable_or(e, stiffness))
}

/// Rigid-body modes and the shift.
fn prepare(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    rigid_motions: &DMatrix<f64>,
    options: SolveOptions,
) -> Result<(DMatrix<f64>, f64), ModalError> {
    if stiffness.nrows() == 0 {
        return Err(ModalError::NoDof);
    }
    check_finite(stiffness, mass)?;
    let rigid = rigid_body_modes(stiffness, mass, rigid_motions)?;
    let shift = match options.shift {
        Some(shift) => shift,
        None => typical_shift(stiffness, mass, rigid_motions)?,
    };
    Ok((rigid, shift))
}

/// The modes among eigenpairs: rigid-body modes as given, and what is left of the others across them.
fn sorted(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    rigid: &DMatrix<f64>,
    pairs: &Eigenpairs,
    shift: f64,
) -> Result<Modes, ModalError> {
    let n_rigid = rigid.ncols();
    // How much of each vector is a rigid motion, in the mass norm: the n_rigid largest are the rigid-body modes.
    let along = (mass * rigid).transpose() * &pairs.vectors;
    let mut order: Vec<usize> = (0..pairs.values.len()).collect();
    order.sort_by(|&a, &b| along.column(b).norm_squared().total_cmp(&along.column(a).norm_squared()).then(a.cmp(&b)));
    let mut elastic: Vec<usize> = order.split_off(n_rigid.min(order.len()));
    elastic.sort_unstable();
    let count = n_rigid + elastic.len();
    let mut lambda = DVector::zeros(count);
    let mut shapes = DMatrix::zeros(mass.nrows(), count);
    shapes.columns_mut(0, n_rigid).copy_from(rigid);
    let mut n_mechanism = 0;
    let clean = pairs.vectors.select_columns(&elastic) - rigid * along.select_columns(&elastic);
    let weighted = mass * &clean;
    for (k, &j) in elastic.iter().enumerate() {
        let norm = clean.column(k).dot(&weighted.column(k)).sqrt();
        shapes.set_column(n_rigid + k, &clean.column(k).unscale(norm));
        // Far below the shift, which is about the first elastic λ, a value is rounding noise.
        let value = pairs.values[j];
        if value.abs() < 1e-9 * shift {
            n_mechanism += 1;
        } else {
            lambda[n_rigid + k] = value;
        }
    }
    let modes = Modes { lambda, shapes, n_rigid, n_mechanism, basis: None };
    check_stable(&modes, |x| stiffness.abs() * x)?;
    Ok(modes)
}

/// Refuses NaN and infinity before they reach an iteration that would never end.
fn check_finite(stiffness: &DMatrix<f64>, mass: &DMatrix<f64>) -> Result<(), ModalError> {
    for (matrix, a) in [("stiffness", stiffness), ("mass", mass)] {
        // Products of two entries must not overflow either.
        if let Some(k) = a.iter().position(|v| v.is_nan() || v.abs() > 1e150) {
            return Err(LinalgError::NotFinite { matrix, row: k % a.nrows() }.into());
        }
    }
    Ok(())
}

/// What [`rigid_body_modes`] asks of a symmetric matrix, dense or sparse.
pub(super) trait Symmetric {
    /// A X.
    fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64>;
    /// |A|, entry by entry.
    fn absolute(&self) -> Self;
}

impl Symmetric for DMatrix<f64> {
    fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        self * x
    }

    fn absolute(&self) -> Self {
        self.abs()
    }
}

/// Force on a dof, of its terms, that is not rounding: a support beside it holds the motion.
const LEAST_SUPPORT: f64 = 1e-6;

/// M-orthonormal rigid-body modes: the combinations of rigid motions that cost no strain energy and move mass.
///
/// The energy of a motion r is judged against |r|ᵀ|K||r|, what its terms would sum to without cancelling, and every force
/// of K r against its terms: of a long chain of elements with one support the energy alone is little.
pub(super) fn rigid_body_modes<A: Symmetric>(
    k: &A,
    m: &A,
    motions: &DMatrix<f64>,
) -> Result<DMatrix<f64>, LinalgError> {
    let n = motions.nrows();
    let absolute = k.absolute();
    // Motions in comparable units: each scaled to unit absolute energy; those that no dof takes part in are dropped.
    let mut scaled: Vec<DVector<f64>> = Vec::new();
    for j in 0..motions.ncols() {
        let r: DMatrix<f64> = motions.columns(j, 1).into_owned();
        if r.amax() == 0.0 {
            continue;
        }
        let a = r.abs();
        let size = a.dot(&absolute.times(&a));
        let size = if size > 0.0 { size } else { r.dot(&m.times(&r)).max(f64::MIN_POSITIVE) };
        scaled.push((r / size.sqrt()).column(0).into_owned());
    }
    if scaled.is_empty() {
        return Ok(DMatrix::zeros(n, 0));
    }
    let motions = DMatrix::from_columns(&scaled);
    let energy = motions.transpose() * k.times(&motions);
    let eigen = symmetric_eigen(&(0.5 * (&energy + energy.transpose())))?;
    // Rounding of the sums is some 1e-15 of the absolute energy; the softest suspension that can matter is far above.
    let free: Vec<DVector<f64>> = (0..energy.nrows())
        .filter(|&i| eigen.values[i].abs() < 1e-12)
        .filter_map(|i| {
            // What rounding has left of other motions would load dofs that nothing else loads.
            let weights = eigen.vectors.column(i).map(|w| if w.abs() < 1e-13 { 0.0 } else { w });
            let combination = &motions * &weights;
            // Where few dofs are left, some combinations of motions move none of them: what remains is rounding.
            let size = motions.abs() * weights.abs();
            let column = |v: &DVector<f64>| DMatrix::from_columns(std::slice::from_ref(v));
            let (force, terms) = (k.times(&column(&combination)), absolute.times(&column(&size)));
            let is_free = force.iter().zip(&terms).all(|(f, t)| f.abs() <= LEAST_SUPPORT * t);
            (is_free && combination.norm() > 1e-9 * size.norm()).then_some(combination)
        })
        .collect();
    if free.is_empty() {
        return Ok(DMatrix::zeros(n, 0));
    }
    let free = DMatrix::from_columns(&free);
    // Combinations that move mass and differ from each other.
    let gram = free.transpose() * m.times(&free);
    let diagonal: Vec<f64> = (0..gram.nrows()).map(|i| gram[(i, i)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let unit = DMatrix::from_fn(gram.nrows(), gram.ncols(), |i, j| gram[(i, j)] / (diagonal[i] * diagonal[j]));
    let eigen = symmetric_eigen(&(0.5 * (&unit + unit.transpose())))?;
    let columns: Vec<DVector<f64>> = (0..unit.nrows())
        .filter(|&i| eigen.values[i] > 1e-10)
        .map(|i| {
            let weights = DVector::from_fn(unit.nrows(), |j, _| eigen.vectors[(j, i)] / diagonal[j]);
            &free * weights / eigen.values[i].sqrt()
        })
        .collect();
    Ok(if columns.is_empty() { DMatrix::zeros(n, 0) } else { DMatrix::from_columns(&columns) })
}

/// A shift for the inverse problem: about the first elastic λ of the structure.
///
/// Rounding in λ is about ε (λ + a)²/a for a shift a, so a shift near the first elastic λ keeps the low modes exact and
/// costs the high ones little.
pub fn typical_shift(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    rigid_motions: &DMatrix<f64>,
) -> Result<f64, ModalError> {
    shift_by_search(stiffness, mass, rigid_motions).map_err(|e| dense_unstable_or(e, stiffness))
}

fn shift_by_search(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    rigid_motions: &DMatrix<f64>,
) -> Result<f64, ModalError> {
    let n = stiffness.nrows();
    check_finite(stiffness, mass)?;
    let n_rigid = rigid_body_modes(stiffness, mass, rigid_motions)?.ncols();
    // A dof's own K/M is above the first λ (Rayleigh), usually by a few decades.
    let ratios = (0..n).filter(|&i| mass[(i, i)] > 0.0 && stiffness[(i, i)] > 0.0);
    let least = ratios.map(|i| stiffness[(i, i)] / mass[(i, i)]).fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        if (0..n).all(|i| mass[(i, i)] <= 0.0) {
            return Err(ModalError::NoMass);
        }
        return Ok(1.0);
    }
    let mut shift = 1e-3 * least;
    for _ in 0..3 {
        let values = lowest_values(stiffness, mass, n_rigid + 12, shift)?;
        let mut values: Vec<f64> = values.iter().copied().collect();
        values.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        // The first λ beyond the rigid ones that is not rounding noise of the shift.
        let Some(first) = values.into_iter().skip(n_rigid).find(|v| *v > 1e-9 * shift) else { return Ok(shift) };
        let ratio = first / shift;
        shift = first;
        if (0.1..10.0).contains(&ratio) {
            break;
        }
    }
    Ok(shift)
}
