//! Modes of a large structure, and their derivatives: the sparse twins of [`super::solve`] and [`super::mode_derivative`].

use super::ModeDerivative;
use super::modes::{ModalError, Modes};
use super::solve::{SolveOptions, Symmetric, rigid_body_modes};
use super::stability::{check_stable, unstable_or};
use retune_linalg::sparse::{
    PencilFactor, SparseOptions, SparsePlan, SparseSym, lowest_sparse_modes, solve_across_modes, solve_beside_modes,
};
use retune_linalg::{DMatrix, DMatrixView, DVector, LinalgError};
use std::sync::Arc;

impl Symmetric for SparseSym {
    fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        self.mul(x)
    }

    fn absolute(&self) -> Self {
        self.abs()
    }
}

/// Bound of the relative error of the first frequency by rounding above which there is no result: a tenth of what a good test
/// can measure would be lost in it.
const MOST_UNCERTAIN: f64 = 2e-3;

/// Residual at which a mode has converged: λ is right to its square, and the shape, which the last step improves once more, to
/// about that over the distance to the next mode.
const RESIDUAL: f64 = 1e-8;

/// A neighbouring structure that was solved: it saves time, and changes the modes by no more than their tolerance.
#[derive(Debug, Clone, Copy)]
pub struct Neighbour<'a> {
    /// Shapes to begin with, (n x any number).
    pub shapes: &'a DMatrix<f64>,
    /// Steps that it took.
    pub steps: usize,
}

/// What a solution took.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// The shift.
    pub shift: f64,
    /// Steps of the iteration.
    pub steps: usize,
}

/// [`super::solve`] for sparse matrices, and what it took.
///
/// * `plan` - the elimination order of a pattern that covers both matrices
/// * `near` - a neighbouring structure
///
/// The modes are counted by the inertia of K - σM, so none is missing.
///
/// Entries of K carry a rounding of ε|K| each, which a mesh n times as fine feels n⁴ times as much in bending:
///
/// ```text
/// δf/f ≤ ½ ε |φ|ᵀ|K||φ| / λ          of the first elastic mode: every rounding in the worst direction
/// ```
///
/// # Errors
/// [`ModalError::TooFine`] where that is above 0.002; [`ModalError::Unstable`] where a λ is negative; those of [`super::solve`].
pub fn solve_sparse(
    plan: &SparsePlan,
    stiffness: &SparseSym,
    mass: &SparseSym,
    rigid_motions: &DMatrix<f64>,
    options: SolveOptions,
    near: Option<Neighbour<'_>>,
) -> Result<(Modes, Effort), ModalError> {
    let n = stiffness.n();
    if n == 0 {
        return Err(ModalError::NoDof);
    }
    for (matrix, a) in [("stiffness", stiffness), ("mass", mass)] {
        // Products of two entries must not overflow either.
        if let Some((row, ..)) = a.entries().find(|e| e.2.is_nan() || e.2.abs() > 1e150) {
            return Err(LinalgError::NotFinite { matrix, row }.into());
        }
    }
    if (0..n).all(|i| mass.diagonal(i) <= 0.0) {
        return Err(ModalError::NoMass);
    }
    let rigid = rigid_body_modes(stiffness, mass, rigid_motions)?;
    let n_rigid = rigid.ncols();
    let sparse = SparseOptions {
        n_modes: options.n_elastic,
        shift: options.shift,
        tolerance: RESIDUAL,
        // From good shapes it takes a step less.
        first_look: near.map_or(0, |n| n.steps.saturating_sub(1)),
        ..SparseOptions::default()
    };
    let start = near.map(|n| n.shapes).filter(|s| s.ncols() > 0);
    let found = lowest_sparse_modes(plan, stiffness, mass, &rigid, start, &sparse)
        .map_err(|e| rounding_or(e, plan, stiffness, mass))?;
    let count = n_rigid + found.values.len();
    let mut lambda = DVector::zeros(count);
    let mut shapes = DMatrix::zeros(n, count);
    shapes.columns_mut(0, n_rigid).copy_from(&rigid);
    shapes.columns_mut(n_rigid, found.values.len()).copy_from(&found.vectors);
    let mut n_mechanism = 0;
    for (k, value) in found.values.iter().enumerate() {
        // Far below the shift, which is about the first elastic λ, a value is rounding noise.
        if value.abs() < 1e-9 * found.shift {
            n_mechanism += 1;
        } else {
            lambda[n_rigid + k] = *value;
        }
    }
    // The lowest vector against the first λ that is not zero: a mode may be lost in rounding altogether.
    if let Some(first) = lambda.iter().copied().find(|l| *l != 0.0) {
        let phi = shapes.columns(n_rigid, 1).abs();
        let uncertainty = 0.5 * f64::EPSILON * phi.dot(&stiffness.abs().mul(&phi)) / first.abs();
        if uncertainty > MOST_UNCERTAIN {
            return Err(ModalError::TooFine { n, uncertainty });
        }
    }
    let modes = Modes { lambda, shapes, n_rigid, n_mechanism, basis: None };
    check_stable(&modes, |x| stiffness.abs().mul(x))?;
    Ok((modes, Effort { shift: found.shift, steps: found.steps }))
}

/// A failure to factor or to count that rounding explains, with ε of the largest K/M above the shift, or an instability.
fn rounding_or(error: LinalgError, plan: &SparsePlan, stiffness: &SparseSym, mass: &SparseSym) -> ModalError {
    let n = stiffness.n();
    let (LinalgError::NotPositiveDefinite { shift: scale, .. } | LinalgError::MissedModes { below: scale, .. }) = error
    else {
        return error.into();
    };
    let massive = (0..n).filter(|&i| mass.diagonal(i) > 0.0);
    let stiffest = massive.map(|i| stiffness.diagonal(i) / mass.diagonal(i)).fold(0.0, f64::max);
    let uncertainty = f64::EPSILON * stiffest / scale.abs();
    match unstable_or(error.into(), plan, stiffness) {
        ModalError::Linalg(_) if uncertainty > MOST_UNCERTAIN => ModalError::TooFine { n, uncertainty },
        error => error,
    }
}

/// [`super::mode_derivative`] for sparse matrices, of one mode of a cluster too.
///
/// ```text
/// (K - λM) z = -(∂K - λ∂M - ∂λ M) φ,   ∂φ = z - ½ φᵀ ∂M φ φ,   z M-orthogonal to the cluster
/// ```
///
/// * `cluster` - mass-normalised shapes of equal or nearly equal λ as columns, (n x size); of a simple λ the mode alone
/// * `own` - the column of the mode
/// * `derivatives` - ∂K and ∂M of every parameter
///
/// `None` where a mode beside the cluster has this λ.
///
/// # Source
/// R. B. Nelson, Simplified calculation of eigenvector derivatives, AIAA Journal 14(9), 1976.
pub fn mode_derivative_sparse(
    plan: &SparsePlan,
    (stiffness, mass): (&SparseSym, &SparseSym),
    lambda: f64,
    cluster: &DMatrix<f64>,
    own: usize,
    derivatives: &[(&SparseSym, &SparseSym)],
) -> Result<Option<ModeDerivative>, ModalError> {
    let phi = cluster.columns(own, 1).into_owned();
    let mut slopes = DVector::zeros(derivatives.len());
    let mut forces = DMatrix::zeros(phi.nrows(), derivatives.len());
    let mut growth = Vec::with_capacity(derivatives.len());
    for (j, (dk, dm)) in derivatives.iter().enumerate() {
        let dm_phi = dm.mul(&phi);
        let force = &dm_phi * lambda - dk.mul(&phi);
        slopes[j] = -phi.dot(&force);
        growth.push(phi.dot(&dm_phi));
        forces.set_column(j, &force.column(0));
    }
    let found = solve_beside_modes(plan, stiffness, mass, lambda, cluster, &forces)?;
    Ok(found.map(|mut shape| {
        for (mut z, growth) in shape.column_iter_mut().zip(growth) {
            z.axpy(-0.5 * growth, &phi.column(0), 1.0);
        }
        ModeDerivative { lambda: slopes, shape }
    }))
}

/// Vectors that are solved for at once.
const COLUMNS: usize = 32;
/// What may be left of a force, as a part of it.
const LEFT: f64 = 1e-11;
/// Values of λ that are equal up to this part are one, double.
const SAME: f64 = 1e-9;

/// What the derivatives of one mode have across all modes that are known.
#[derive(Debug)]
pub struct Across<'a> {
    /// The mode.
    pub mode: usize,
    /// f = -(∂K - λ ∂M) φ of every parameter, (n x parameters).
    pub forces: DMatrixView<'a, f64>,
    /// φᵀ ∂M φ of every parameter.
    pub growth: &'a [f64],
    /// w, (n x parameters).
    pub shapes: DMatrixView<'a, f64>,
    /// Whether all of w is as near as was asked for.
    pub is_solved: bool,
}

/// Derivatives of modes across all modes that are known, mode by mode, by [`solve_across_modes`]; a few modes are solved for at once.
///
/// * `factor` - of K + aM, or of a neighbour's
/// * `modes` - all modes up to the highest of those wanted, and as many more as there are
/// * `of` - which modes are wanted
/// * `derivatives` - ∂K and ∂M of every parameter
/// * `tolerance` - part of the forces that may be left
/// * `take` - gets each in the order of `of`
///
/// # Errors
/// Those of `take`.
pub fn derivatives_across_modes(
    factor: &PencilFactor,
    (k, m): (&SparseSym, &SparseSym),
    modes: &Modes,
    of: &[usize],
    derivatives: &[(&SparseSym, &SparseSym)],
    tolerance: f64,
    mut take: impl FnMut(Across<'_>) -> Result<(), ModalError>,
) -> Result<(), ModalError> {
    let n_parameters = derivatives.len();
    for some in of.chunks((COLUMNS / n_parameters.max(1)).max(1)) {
        let mut forces = DMatrix::zeros(k.n(), some.len() * n_parameters);
        let (mut lambda, mut growth) = (Vec::new(), Vec::new());
        for &mode in some {
            let phi = modes.shapes.columns(mode, 1).into_owned();
            for (dk, dm) in derivatives {
                let dm_phi = dm.mul(&phi);
                growth.push(phi.dot(&dm_phi));
                forces.set_column(lambda.len(), &(dm_phi * modes.lambda[mode] - dk.mul(&phi)).column(0));
                lambda.push(modes.lambda[mode]);
            }
        }
        let (shapes, is_solved) = solve_across_modes(factor, k, m, &modes.shapes, &lambda, &forces, tolerance);
        for (at, &mode) in some.iter().enumerate() {
            let first = at * n_parameters;
            let own = first..first + n_parameters;
            take(Across {
                mode,
                forces: forces.columns(first, n_parameters),
                growth: &growth[own.clone()],
                shapes: shapes.columns(first, n_parameters),
                is_solved: is_solved[own].iter().all(|s| *s),
            })?;
        }
    }
    Ok(())
}

/// [`mode_derivative_sparse`] of several modes of a large pencil, with one factorisation for all of them:
///
/// ```text
/// ∂φ_j = Σ_{i≠j} φ_i φ_iᵀ f_j / (λ_i - λ_j) - ½ φ_jᵀ ∂M φ_j φ_j + w_j,    f_j = -(∂K - λ_j ∂M) φ_j
/// ```
/// over the modes i that are known, and [w_j across them](derivatives_across_modes). A mode for which these do not arrive, as where the next one that is not
/// known is near, has a factorisation of its own.
///
/// * `shift` - the shift a > 0 of that factorisation, near the first λ
/// * `modes`, `of` - as for [`derivatives_across_modes`]
pub fn mode_derivatives_sparse(
    plan: &Arc<SparsePlan>,
    (k, m): (&SparseSym, &SparseSym),
    shift: f64,
    modes: &Modes,
    of: &[usize],
    derivatives: &[(&SparseSym, &SparseSym)],
) -> Result<Vec<Option<ModeDerivative>>, ModalError> {
    let mut out = Vec::with_capacity(of.len());
    if of.is_empty() {
        return Ok(out);
    }
    let factor = PencilFactor::new(plan.clone(), k, m, shift)?;
    let (phi, lambda) = (&modes.shapes, &modes.lambda);
    derivatives_across_modes(&factor, (k, m), modes, of, derivatives, LEFT, |across| {
        let own = across.mode;
        let is_same = |i: usize| i != own && (lambda[i] - lambda[own]).abs() <= SAME * lambda[own].abs();
        if !across.is_solved || (0..modes.len()).any(is_same) {
            let shape = phi.columns(own, 1).into_owned();
            out.push(mode_derivative_sparse(plan, (k, m), lambda[own], &shape, 0, derivatives)?);
            return Ok(());
        }
        // Parts along the modes that are known.
        let mut along = phi.tr_mul(&across.forces);
        let slopes = -along.row(own).transpose();
        for (i, mut row) in along.row_iter_mut().enumerate().filter(|(i, _)| *i != own) {
            row /= lambda[i] - lambda[own];
        }
        for (part, growth) in along.row_mut(own).iter_mut().zip(across.growth) {
            *part = -0.5 * growth;
        }
        out.push(Some(ModeDerivative { lambda: slopes, shape: across.shapes + phi * along }));
        Ok(())
    })?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::{MatrixDerivative, mode_derivative, solve};

    /// A free grid of masses with springs of two kinds: modes and derivatives equal those of the dense path.
    #[test]
    fn modes_and_derivatives_are_those_of_the_dense_path() {
        let (p, q) = (14, 9);
        let n = p * q;
        let build = |soft: f64, heavy: f64| {
            let mut k = DMatrix::zeros(n, n);
            let mut spring = |a: usize, b: usize, s: f64| {
                k[(a, a)] += s;
                k[(b, b)] += s;
                k[(a, b)] -= s;
                k[(b, a)] -= s;
            };
            for i in 0..p {
                for j in 0..q {
                    if i + 1 < p {
                        spring(i * q + j, (i + 1) * q + j, if j < 3 { soft } else { 150.0 });
                    }
                    if j + 1 < q {
                        spring(i * q + j, i * q + j + 1, 90.0);
                    }
                }
            }
            (k, DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| if i % 5 == 0 { heavy } else { 1.0 })))
        };
        let (k, m) = build(100.0, 2.0);
        let motions = DMatrix::from_fn(n, 6, |_, j| f64::from(u8::from(j == 0)));
        let dense = solve(&k, &m, &motions, SolveOptions { n_elastic: 8, shift: None }).unwrap();
        let (sk, sm) = (SparseSym::from_dense(&k), SparseSym::from_dense(&m));
        let plan = Arc::new(SparsePlan::new(&sk, &sm, &(0..n).collect::<Vec<_>>()).unwrap());
        let options = SolveOptions { n_elastic: 8, shift: None };
        let (sparse, Effort { shift, .. }) = solve_sparse(&plan, &sk, &sm, &motions, options, None).unwrap();
        assert_eq!((sparse.n_rigid, sparse.n_mechanism, sparse.len()), (1, 0, 9));
        assert!(shift > 0.0);
        let unit = [(build(101.0, 2.0).0 - &k, &m * 0.0), (&k * 0.0, build(100.0, 3.0).1 - &m)];
        let sparse_unit: Vec<_> =
            unit.iter().map(|(k, m)| (SparseSym::from_dense(k), SparseSym::from_dense(m))).collect();
        let of_dense: Vec<_> = unit.iter().map(|(k, m)| MatrixDerivative { stiffness: k, mass: m }).collect();
        let of_sparse: Vec<_> = sparse_unit.iter().map(|(k, m)| (k, m)).collect();
        let wanted: Vec<usize> = (1..9).collect();
        let at_once = mode_derivatives_sparse(&plan, (&sk, &sm), shift, &dense, &wanted, &of_sparse).unwrap();
        for mode in 1..9 {
            assert!((sparse.lambda[mode] / dense.lambda[mode] - 1.0).abs() < 1e-11, "{mode}");
            let shape = dense.shapes.column(mode).into_owned();
            let agreement = shape.dot(&(&m * sparse.shapes.column(mode)));
            assert!((agreement.abs() - 1.0).abs() < 1e-12, "{mode}: {agreement}");
            let exact = mode_derivative(&k, &m, dense.lambda[mode], &shape, &of_dense).unwrap();
            let alone = DMatrix::from_columns(&[shape]);
            let ours = mode_derivative_sparse(&plan, (&sk, &sm), dense.lambda[mode], &alone, 0, &of_sparse);
            let ours = ours.unwrap().unwrap();
            let all = at_once[mode - 1].as_ref().unwrap();
            for ours in [&ours, all] {
                assert!((&ours.lambda - &exact.lambda).amax() < 1e-11 * exact.lambda.amax(), "{mode}");
                assert!((&ours.shape - &exact.shape).amax() < 1e-8 * exact.shape.amax(), "{mode}");
            }
        }
    }

    #[test]
    fn a_double_mode_has_no_shape_derivative() {
        // Two equal oscillators.
        let k = SparseSym::from_dense(&DMatrix::from_diagonal(&nalgebra::dvector![4.0, 4.0, 9.0]));
        let m = SparseSym::from_dense(&DMatrix::identity(3, 3));
        let plan = SparsePlan::new(&k, &m, &[0, 1, 2]).unwrap();
        let change =
            SparseSym::from_dense(&DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        let none = SparseSym::from_triplets(3, std::iter::empty());
        let shape = nalgebra::dvector![1.0, 0.0, 0.0];
        let of = |lambda: f64, shape: &DVector<f64>| {
            let shape = DMatrix::from_columns(std::slice::from_ref(shape));
            mode_derivative_sparse(&plan, (&k, &m), lambda, &shape, 0, &[(&change, &none)]).unwrap()
        };
        assert!(of(4.0, &shape).is_none());
        assert!(of(9.0, &nalgebra::dvector![0.0, 0.0, 1.0]).is_some());
    }
}
