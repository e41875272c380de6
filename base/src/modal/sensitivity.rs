//! Derivatives of eigenvalues and shapes with respect to parameters.

use retune_linalg::{DMatrix, DVector, ShiftedPencil};

/// Derivatives of one mode with respect to every parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeDerivative {
    /// ∂λ/∂θ_j.
    pub lambda: DVector<f64>,
    /// ∂φ/∂θ_j as columns, (n_dof x n_parameters), of the mass-normalised shape.
    pub shape: DMatrix<f64>,
}

/// ∂K/∂θ_j and ∂M/∂θ_j.
#[derive(Debug, Clone, Copy)]
pub struct MatrixDerivative<'a> {
    /// ∂K/∂θ_j.
    pub stiffness: &'a DMatrix<f64>,
    /// ∂M/∂θ_j.
    pub mass: &'a DMatrix<f64>,
}

/// ∂λ/∂θ_j of a mass-normalised mode.
///
/// ```text
/// ∂λ = φᵀ (∂K - λ ∂M) φ
/// ```
///
/// # Source
/// R. L. Fox, M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA Journal 6(12), 1968.
pub fn eigenvalue_derivative(lambda: f64, shape: &DVector<f64>, d: &MatrixDerivative<'_>) -> f64 {
    (shape.transpose() * (d.stiffness * shape - d.mass * shape * lambda))[(0, 0)]
}

/// Derivatives of a mode with a simple eigenvalue, exact whatever number of other modes is known.
///
/// ```text
/// [ K - λM   Mφ ] [ ∂φ ]   [ -(∂K - λ∂M) φ      ]
/// [ (Mφ)ᵀ    0  ] [ -∂λ] = [ -½ φᵀ ∂M φ         ]
/// ```
///
/// The bordered matrix is regular for a simple λ, also where K is singular (a free structure) or M is (massless dofs).
/// At a double λ single shapes have no derivative; use the subspace of both. `None` then, when the factorisation fails.
///
/// # Source
/// The bordered form of R. B. Nelson's method: M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in
/// Structural Dynamics, 1995; I. W. Lee, G. H. Jung, An efficient algebraic method for the computation of natural
/// frequency and mode shape sensitivities, Computers & Structures 62(3), 1997.
pub fn mode_derivative(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    lambda: f64,
    shape: &DVector<f64>,
    derivatives: &[MatrixDerivative<'_>],
) -> Option<ModeDerivative> {
    let n = shape.len();
    let mut forces = DMatrix::zeros(n, derivatives.len());
    let mut growth = DVector::zeros(derivatives.len());
    for (j, d) in derivatives.iter().enumerate() {
        let dm_phi = d.mass * shape;
        forces.set_column(j, &(d.stiffness * shape - &dm_phi * lambda));
        growth[j] = shape.dot(&dm_phi);
    }
    mode_derivative_of_forces(stiffness, mass, lambda, shape, &forces, &growth)
}

/// [`mode_derivative`] from what the changes do to the mode, for sparse changes that need no matrices of their own.
///
/// * `forces` - (∂K_j - λ ∂M_j) φ as columns, (n_dof x n_parameters)
/// * `growth` - φᵀ ∂M_j φ, (n_parameters)
pub fn mode_derivative_of_forces(
    stiffness: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    lambda: f64,
    shape: &DVector<f64>,
    forces: &DMatrix<f64>,
    growth: &DVector<f64>,
) -> Option<ModeDerivative> {
    let n = shape.len();
    // Symmetric scaling to comparable rows: dofs by their diagonal, the border by the norm of Mφ.
    let scale: Vec<f64> = (0..n)
        .map(|i| {
            let d = stiffness[(i, i)].abs() + lambda.abs() * mass[(i, i)].abs();
            if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }
        })
        .collect();
    let m_phi = mass * shape;
    let border_size = (0..n).map(|i| (m_phi[i] * scale[i]).abs()).fold(0.0, f64::max);
    if border_size == 0.0 {
        return None;
    }
    let border = 1.0 / border_size;
    let mut a = DMatrix::zeros(n + 1, n + 1);
    for j in 0..n {
        for i in 0..n {
            a[(i, j)] = (stiffness[(i, j)] - lambda * mass[(i, j)]) * scale[i] * scale[j];
        }
        a[(n, j)] = m_phi[j] * scale[j] * border;
        a[(j, n)] = a[(n, j)];
    }
    let columns = forces.ncols();
    let mut right = DMatrix::zeros(n + 1, columns);
    for j in 0..columns {
        for i in 0..n {
            right[(i, j)] = -forces[(i, j)] * scale[i];
        }
        right[(n, j)] = -0.5 * growth[j] * border;
    }
    let solution = a.lu().solve(&right)?;
    let shape = DMatrix::from_fn(n, columns, |i, j| solution[(i, j)] * scale[i]);
    let lambda = DVector::from_fn(columns, |j, _| -solution[(n, j)] * border);
    (shape.iter().all(|v| v.is_finite()) && lambda.iter().all(|v| v.is_finite()))
        .then_some(ModeDerivative { lambda, shape })
}

/// Part of λ + a by which the value of a basis vector differs from that of a mode that it does not belong to.
const APART: f64 = 1e-9;

/// Derivatives of modes by the complete basis that they are of; each mode may be one of a cluster of equal or nearly equal λ, whose shapes are
/// any basis of the space that they span: then the part outside that space, which is all that is determined.
///
/// ```text
/// f = (∂K - λ ∂M) φ,   ∂λ = φᵀ f,   ∂φ = -Σ x (xᵀ f)/(1 - (λ + a) θ) - ½ (φᵀ ∂M φ) φ
/// ```
///
/// over the vectors x of the basis that are not of the cluster. `None` where one of these has the λ of the mode.
///
/// * `basis` - of the same K and M, (n)
/// * `lambda`, `shapes` - of all modes, mass-normalised shapes as columns
/// * `of` - the cluster of each mode, indices into these, and the number of the mode in it
///
/// # Source
/// R. L. Fox, M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA Journal 6(12), 1968, in the vectors of the shifted pencil, so
/// that massless dofs have their part.
pub fn derivatives_on_basis(
    basis: &ShiftedPencil,
    (lambda, shapes): (&DVector<f64>, &DMatrix<f64>),
    of: &[(Vec<usize>, usize)],
    derivatives: &[MatrixDerivative<'_>],
) -> Vec<Option<ModeDerivative>> {
    let n = shapes.nrows();
    let modes: Vec<usize> = of.iter().map(|(cluster, own)| cluster[*own]).collect();
    let phi = shapes.select_columns(&modes);
    let by_lambda = DMatrix::from_fn(n, modes.len(), |i, j| phi[(i, j)] * lambda[modes[j]]);
    let shifted = DVector::from_fn(modes.len(), |j, _| lambda[modes[j]] + basis.shift);
    // -1/(1 - (λ + a) θ) of every vector, zero for those of the cluster.
    let mut is_apart = vec![true; modes.len()];
    let weights = DMatrix::from_columns(
        &of.iter()
            .enumerate()
            .map(|(j, (cluster, _))| {
                let own = of_values(basis, cluster.iter().map(|&mode| lambda[mode]));
                let gap = |k: usize| 1.0 - shifted[j] * basis.theta[k];
                is_apart[j] = (0..n).all(|k| own.contains(&k) || gap(k).abs() > APART);
                DVector::from_fn(n, |k, _| if own.contains(&k) { 0.0 } else { -1.0 / gap(k) })
            })
            .collect::<Vec<_>>(),
    );
    let mut found: Vec<ModeDerivative> = modes
        .iter()
        .map(|_| ModeDerivative {
            lambda: DVector::zeros(derivatives.len()),
            shape: DMatrix::zeros(n, derivatives.len()),
        })
        .collect();
    for (p, d) in derivatives.iter().enumerate() {
        let grown = d.mass * &phi;
        let mut forces = d.stiffness * &phi;
        forces -= d.mass * &by_lambda;
        let moved = &basis.vectors * basis.vectors.tr_mul(&forces).component_mul(&weights);
        for (j, out) in found.iter_mut().enumerate() {
            out.lambda[p] = phi.column(j).dot(&forces.column(j));
            let mut shape = out.shape.column_mut(p);
            shape.copy_from(&moved.column(j));
            shape.axpy(-0.5 * phi.column(j).dot(&grown.column(j)), &phi.column(j), 1.0);
        }
    }
    found.into_iter().zip(is_apart).map(|(d, is_apart)| is_apart.then_some(d)).collect()
}

/// The vectors of a basis whose λ are nearest to these, a different one for each.
fn of_values(basis: &ShiftedPencil, lambda: impl Iterator<Item = f64>) -> Vec<usize> {
    let mut own: Vec<usize> = Vec::new();
    for lambda in lambda {
        let gap = |k: usize| (1.0 - (lambda + basis.shift) * basis.theta[k]).abs();
        let others = (0..basis.theta.len()).filter(|k| !own.contains(k));
        own.extend(others.min_by(|&a, &b| gap(a).total_cmp(&gap(b))));
    }
    own
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::modal::{SolveOptions, solve};

    /// Two equal chains side by side: what is known of one, in any combination of both.
    #[test]
    fn a_double_mode_moves_as_each_of_its_parts() {
        let one = |s: f64| DMatrix::from_row_slice(2, 2, &[s + 2.0, -2.0, -2.0, 2.0]);
        let (k, m) = (one(3.0), DMatrix::from_diagonal(&DVector::from_row_slice(&[1.0, 2.0])));
        let d = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]);
        let none = DMatrix::zeros(2, 2);
        let twice =
            |a: &DMatrix<f64>| DMatrix::from_fn(4, 4, |i, j| if i / 2 == j / 2 { a[(i % 2, j % 2)] } else { 0.0 });
        let options = SolveOptions { n_elastic: 2, shift: Some(1.0) };
        let modes = solve(&k, &m, &DMatrix::zeros(2, 0), options).unwrap();
        let (lambda, phi) = (modes.lambda[0], modes.shapes.column(0).into_owned());
        let simple = mode_derivative(&k, &m, lambda, &phi, &[MatrixDerivative { stiffness: &d, mass: &none }]).unwrap();
        let (s, c) = 0.6_f64.sin_cos();
        let side = |v: &[f64], a: f64, b: f64| DVector::from_row_slice(&[a * v[0], a * v[1], b * v[0], b * v[1]]);
        let cluster = DMatrix::from_columns(&[side(phi.as_slice(), c, s), side(phi.as_slice(), -s, c)]);
        let (dd, zero) = (twice(&d), twice(&none));
        let change = [MatrixDerivative { stiffness: &dd, mass: &zero }];
        let basis = ShiftedPencil::new(&twice(&k), &twice(&m), 1.0).unwrap();
        let lambda = DVector::from_element(2, lambda);
        let both =
            derivatives_on_basis(&basis, (&lambda, &cluster), &[(vec![0, 1], 0)], &change).pop().unwrap().unwrap();
        let alone = derivatives_on_basis(&basis, (&lambda, &cluster), &[(vec![0], 0)], &change).pop().unwrap();
        assert!(alone.is_none(), "a double mode beside its twin has no derivative");
        assert!((both.lambda[0] - simple.lambda[0]).abs() < 1e-12);
        let expected = side(simple.shape.column(0).into_owned().as_slice(), c, s);
        assert!((both.shape.column(0) - expected).amax() < 1e-12);
    }

    /// A free chain of unequal masses; derivative by springs and masses against central differences.
    #[test]
    fn derivatives_agree_with_differences() {
        let build = |theta: &[f64]| {
            let n = 5;
            let mut k = DMatrix::zeros(n, n);
            for i in 0..n - 1 {
                let s = if i == 1 { theta[0] } else { 100.0 + 10.0 * i as f64 };
                k[(i, i)] += s;
                k[(i + 1, i + 1)] += s;
                k[(i, i + 1)] -= s;
                k[(i + 1, i)] -= s;
            }
            let m = DMatrix::from_diagonal(&DVector::from_fn(
                n,
                |i, _| if i == 3 { theta[1] } else { 1.0 + 0.3 * i as f64 },
            ));
            (k, m)
        };
        let theta = [120.0, 2.5];
        let (k, m) = build(&theta);
        let motions = DMatrix::from_fn(5, 6, |_, j| f64::from(u8::from(j == 0)));
        let modes_at = |theta: &[f64]| {
            let (k, m) = build(theta);
            solve(&k, &m, &motions, SolveOptions { n_elastic: 4, shift: None }).unwrap()
        };
        let modes = modes_at(&theta);
        assert_eq!(modes.n_rigid, 1);
        let unit = |j: usize| {
            let mut t = [0.0; 2];
            t[j] = 1.0;
            let (k1, m1) = build(&[theta[0] + t[0], theta[1] + t[1]]);
            (k1 - &k, m1 - &m)
        };
        let d: Vec<_> = (0..2).map(unit).collect();
        let derivatives: Vec<_> = d.iter().map(|(k, m)| MatrixDerivative { stiffness: k, mass: m }).collect();
        for mode in 1..5 {
            let phi = modes.shapes.column(mode).into_owned();
            let exact = mode_derivative(&k, &m, modes.lambda[mode], &phi, &derivatives).unwrap();
            let basis = modes.basis.as_ref().unwrap();
            let on_basis =
                derivatives_on_basis(basis, (&modes.lambda, &modes.shapes), &[(vec![mode], 0)], &derivatives);
            let on_basis = on_basis[0].as_ref().unwrap();
            assert!((&on_basis.lambda - &exact.lambda).amax() < 1e-12 * modes.lambda[mode]);
            assert!((&on_basis.shape - &exact.shape).amax() < 1e-12);
            for j in 0..2 {
                let h = 1e-5 * theta[j];
                let at = |s: f64| {
                    let mut t = theta;
                    t[j] += s * h;
                    let modes = modes_at(&t);
                    let mut shape = modes.shapes.column(mode).into_owned();
                    if shape.dot(&phi) < 0.0 {
                        shape = -shape;
                    }
                    (modes.lambda[mode], shape)
                };
                let (above, below) = (at(1.0), at(-1.0));
                let lambda = (above.0 - below.0) / (2.0 * h);
                let shape = (above.1 - below.1) / (2.0 * h);
                // Central differences: h² truncation and eps/h rounding, both about 1e-9 relative here.
                assert!((lambda - exact.lambda[j]).abs() < 1e-7 * modes.lambda[mode]);
                assert!((shape - exact.shape.column(j)).amax() < 1e-7);
                assert!(
                    (eigenvalue_derivative(modes.lambda[mode], &phi, &derivatives[j]) - exact.lambda[j]).abs()
                        < 1e-9 * modes.lambda[mode]
                );
            }
        }
    }
}
