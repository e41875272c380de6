//! Expansion of shapes measured at sensors to all dofs.
//!
//! [`Expander`] minimises a stated sum of model error and sensor misfit (minimum dynamic residual). The expansions that
//! force the sensors or a basis of modes are the transformations of [`crate::modal::reduction`]: `serep` and
//! `dynamic_reduction`; multiply them with the test shape.

use super::CorrelationError;
use crate::linalg::{DMatrix, DVector, LinalgError, ShiftedPencil};
use nalgebra::Cholesky;

/// Minimum dynamic residual expansion for one model and one set of sensors.
///
/// ```text
/// minimise over u:   rᵀ (K + a M) r  +  w Σ_i ((S u - y)_i / σ_i)²,     (K + a M) r = (K - ω² M) u
/// ```
///
/// u is the shape at all dofs; r the displacement that the residual force (K - ω² M) u causes; a > 0 makes the energy a
/// norm when the structure is free. The weight w, in J, states how much model error one standard deviation of one sensor
/// is worth: see [`Expander::weight`]. Small w trusts the sensors little; w → ∞ forces them.
///
/// All is done in the modes of the pencil (M, K + a M), in which the energy matrix is the identity and the residual is
/// diagonal, r_k = (1 - (ω² + a) θ_k) q_k; massless dofs (θ = 0) and rigid bodies (θ = 1/a) are not a special case.
///
/// # Source
/// E. Balmès, Review and evaluation of shape expansion methods, Proc. 18th IMAC, 2000, 555-561; the modified
/// constitutive-relation error of P. Ladevèze, D. Nedjar, M. Reynier, Updating of finite element models using vibration
/// tests, AIAA Journal 32 (1994) 1485-1491.
#[derive(Debug, Clone)]
pub struct Expander {
    /// Vectors with Xᵀ (K + a M) X = I, (n x n).
    vectors: DMatrix<f64>,
    /// S X, (n_sensor x n).
    observed: DMatrix<f64>,
    /// θ of M x = θ (K + a M) x, descending.
    theta: DVector<f64>,
    shift: f64,
}

/// A shape at all dofs and what its fit has cost.
#[derive(Debug, Clone, PartialEq)]
pub struct ExpandedShape {
    /// u, in the scale of the test shape, (n).
    pub shape: DVector<f64>,
    /// r, the displacement of the residual force, (n).
    pub residual: DVector<f64>,
    /// rᵀ (K + a M) r, twice the energy of the model error, J.
    pub residual_energy: f64,
    /// (S u - y)/σ at the sensors, NaN where not measured, (n_sensor).
    pub sensor_misfit: DVector<f64>,
    /// ∂r/∂y, (n x n_sensor): the expansion is linear in y, so noise goes through; zero columns where not measured.
    pub residual_sensitivity: DMatrix<f64>,
    /// ∂r/∂ω² where r is zero, (n): -(K + a M)⁻¹ M u, so that the noise of the frequency goes through too.
    pub frequency_sensitivity: DVector<f64>,
    /// ∂q/∂y in the modes of the expander, see [`Expander::shape_sensitivity`], (n x n_sensor).
    pub coefficients: DMatrix<f64>,
}

impl Expander {
    /// Prepares a model: one symmetric eigenproblem, reused for every mode of the test.
    ///
    /// * `k`, `m` - symmetric, positive semidefinite, (n x n)
    /// * `s` - observation rows, (n_sensor x n)
    /// * `shift` - a > 0, rad²/s²; a value between the rigid-body modes and the first elastic ω²; any for a held structure
    pub fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, s: &DMatrix<f64>, shift: f64) -> Result<Self, CorrelationError> {
        let n = k.nrows();
        for (what, a, is_fit, expected) in [
            ("stiffness matrix", k, k.ncols() == n, "square"),
            ("mass matrix", m, m.shape() == (n, n), "the size of the stiffness matrix"),
            ("observation matrix", s, s.ncols() == n, "a column for every dof"),
        ] {
            if !is_fit {
                let expected = expected.to_owned();
                return Err(CorrelationError::Shape { what, rows: a.nrows(), columns: a.ncols(), expected });
            }
        }
        Self::check_shift(shift)?;
        Self::of_basis(ShiftedPencil::new(k, m, shift)?, s)
    }

    fn check_shift(shift: f64) -> Result<(), CorrelationError> {
        if shift > 0.0 && shift.is_finite() {
            return Ok(());
        }
        Err(CorrelationError::Range { what: "shift", value: shift, expected: "positive and finite" })
    }

    /// [`Self::new`] for a model whose complete basis is at hand, with any shift of its own.
    pub fn from_basis(basis: &ShiftedPencil, s: &DMatrix<f64>, shift: f64) -> Result<Self, CorrelationError> {
        let n = basis.vectors.nrows();
        if s.ncols() != n {
            let (rows, columns, expected) = (s.nrows(), s.ncols(), format!("{n} columns, one for every dof"));
            return Err(CorrelationError::Shape { what: "observation matrix", rows, columns, expected });
        }
        Self::check_shift(shift)?;
        Self::of_basis(basis.shifted_to(shift), s)
    }

    fn of_basis(
        ShiftedPencil { theta, vectors, shift }: ShiftedPencil,
        s: &DMatrix<f64>,
    ) -> Result<Self, CorrelationError> {
        if let Some(at) = s.iter().position(|v| !v.is_finite()) {
            return Err(LinalgError::NotFinite { matrix: "observation", row: at % s.nrows() }.into());
        }
        Ok(Self { observed: s * &vectors, vectors, theta, shift })
    }

    /// The model error ε of [`Self::weight`] when one of `n_elements` has a stiffness that is wrong by a share s.
    ///
    /// ```text
    /// E[rᵀ (K + a M) r] = n τ²  for r of equal expected energy in each of the n modes of the pencil that have mass
    ///                   = s² (ω² + a) m / n_elements        the strain energy in an element of mean share, times s²
    /// w = τ²   makes the minimum the most probable u;       ε² = s² / (n n_elements)
    /// ```
    ///
    /// * `relative_error` - s, for example 0.1
    pub fn model_error(&self, relative_error: f64, n_elements: usize) -> f64 {
        let n = self.theta.iter().filter(|t| **t > 0.0).count().max(1);
        relative_error / ((n * n_elements.max(1)) as f64).sqrt()
    }

    /// A weight from a relative model error: w = ε² (ω² + a) m, J.
    ///
    /// * `model_error` - ε: the size of r against u that is worth one standard deviation of one sensor, see
    ///   [`Self::model_error`]
    /// * `omega_squared` - ω² of the mode, rad²/s²
    /// * `modal_mass` - uᵀ M u in the scale of the test shape, kg times its unit squared
    pub fn weight(&self, model_error: f64, omega_squared: f64, modal_mass: f64) -> f64 {
        model_error * model_error * (omega_squared + self.shift) * modal_mass
    }

    /// Expands one test shape.
    ///
    /// * `y` - shape at the sensors, NaN where not measured, (n_sensor); complex shapes: the real and the imaginary part,
    ///   one after the other, or turned to be as real as they get
    /// * `sd` - its standard deviations, positive, (n_sensor)
    /// * `omega_squared` - measured ω², rad²/s²
    /// * `weight` - w, J
    ///
    /// Linear in y. With exact y of the same model the shape is exact and the residual zero, as far as the sensors tell
    /// modes near ω apart from everything else.
    pub fn expand(
        &self,
        y: &DVector<f64>,
        sd: &DVector<f64>,
        omega_squared: f64,
        weight: f64,
    ) -> Result<ExpandedShape, CorrelationError> {
        let (n_sensors, n) = self.observed.shape();
        for (what, length) in [("test shape", y.len()), ("standard deviations", sd.len())] {
            if length != n_sensors {
                let expected = format!("{n_sensors} entries, one a sensor");
                return Err(CorrelationError::Shape { what, rows: length, columns: 1, expected });
            }
        }
        for (what, value, is_fit, expected) in [
            ("squared frequency", omega_squared, omega_squared >= 0.0, "not negative"),
            ("weight of the sensors", weight, weight > 0.0, "positive"),
        ] {
            if !(is_fit && value.is_finite()) {
                return Err(CorrelationError::Range { what, value, expected });
            }
        }
        let used: Vec<usize> = (0..n_sensors).filter(|&i| y[i].is_finite()).collect();
        if let Some(&i) = used.iter().find(|&&i| !(sd[i] > 0.0 && sd[i].is_finite())) {
            let what = "standard deviation of a shape entry";
            return Err(CorrelationError::Range { what, value: sd[i], expected: "positive and finite" });
        }
        let gap = self.gap(omega_squared);
        let root = weight.sqrt();
        let b = DMatrix::from_fn(used.len(), n, |i, k| root / sd[used[i]] * self.observed[(used[i], k)]);
        let solved = self.solve(&b, &gap)?;
        let mut coefficients = DMatrix::zeros(n, n_sensors);
        for (row, &i) in used.iter().enumerate() {
            let factor = root / sd[i];
            coefficients.column_mut(i).zip_apply(&solved.row(row).transpose(), |to, v| *to = v * factor);
        }
        let measured = DVector::from_fn(n_sensors, |i, _| if y[i].is_finite() { y[i] } else { 0.0 });
        let q = &coefficients * &measured;
        let residual_q = q.component_mul(&gap);
        let predicted = &self.observed * &q;
        let mut residual_coefficients = coefficients.clone();
        for mut column in residual_coefficients.column_iter_mut() {
            column.component_mul_assign(&gap);
        }
        Ok(ExpandedShape {
            shape: &self.vectors * &q,
            residual: &self.vectors * &residual_q,
            residual_energy: residual_q.norm_squared(),
            frequency_sensitivity: -(&self.vectors * q.component_mul(&self.theta)),
            sensor_misfit: DVector::from_fn(n_sensors, |i, _| (predicted[i] - y[i]) / sd[i]),
            residual_sensitivity: &self.vectors * residual_coefficients,
            coefficients,
        })
    }

    /// 1 - (ω² + a) θ of every mode: Xᵀ (K - ω² M) X.
    fn gap(&self, omega_squared: f64) -> DVector<f64> {
        self.theta.map(|theta| 1.0 - (omega_squared + self.shift) * theta)
    }

    /// What forces that stand for changes of stiffness do to a mode of this model, at the sensors.
    ///
    /// ```text
    /// (K - λM) φ' = λ' M φ - ∂K φ,   φᵀ M φ' = 0:    S φ' = - Σ_{k ≠ j} S x_k (x_kᵀ ∂K φ) / (1 - (λ + a) θ_k)
    /// ```
    ///
    /// * `lambda` - λ of the mode, not near another one
    /// * `forces` - ∂K φ as columns, (n x changes)
    ///
    /// (n_sensor x changes). Exact, because the basis of the expander is complete; `None` where λ is double.
    ///
    /// # Source
    /// R. L. Fox, M. P. Kapoor, Rates of change of eigenvalues and eigenvectors, AIAA Journal 6 (1968) 2426-2429.
    pub fn mode_change(&self, lambda: f64, forces: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let gap = self.gap(lambda);
        let own = gap.iamin();
        let mut q = self.vectors.transpose() * forces;
        for mut column in q.column_iter_mut() {
            column.zip_apply(&gap, |q, gap| *q /= -gap);
            column[own] = 0.0;
        }
        let change = &self.observed * q;
        change.iter().all(|v| v.is_finite()).then_some(change)
    }

    /// ∂u/∂y of an expansion by this expander, (n x n_sensor): the covariance of u is (∂u/∂y) diag(σ²) (∂u/∂y)ᵀ.
    pub fn shape_sensitivity(&self, expanded: &ExpandedShape) -> DMatrix<f64> {
        &self.vectors * &expanded.coefficients
    }

    /// B (gap² + BᵀB)⁻¹, (sensors x n), with B = √w Σ⁻¹ S X.
    ///
    /// Modes away from resonance are eliminated through the sensors, which are fewer:
    ///
    /// ```text
    /// A = I + B_f gap_f⁻² B_fᵀ,   q_n = (gap_n² + B_nᵀ A⁻¹ B_n)⁻¹ B_nᵀ A⁻¹ b,   q_f = gap_f⁻² B_fᵀ A⁻¹ (b - B_n q_n)
    /// ```
    ///
    /// for near (n) and far (f) modes. Near ones, gap² < 10⁻⁴, are few and solved for directly: gap = 0 is not a problem.
    fn solve(&self, b: &DMatrix<f64>, gap: &DVector<f64>) -> Result<DMatrix<f64>, CorrelationError> {
        /// gap² below which a mode is near resonance; far ones lose at most four digits by the elimination.
        const NEAR: f64 = 1e-4;
        let singular = || LinalgError::NotPositiveDefinite { row: 0, shift: self.shift };
        let near: Vec<usize> = (0..gap.len()).filter(|&k| gap[k] * gap[k] < NEAR).collect();
        let b_near = b.select_columns(&near);
        // B_f/gap_f; the columns of the near modes are zero.
        let mut far = b.clone();
        for (mut column, gap) in far.column_iter_mut().zip(gap.iter()) {
            if gap * gap < NEAR {
                column.fill(0.0);
            } else {
                column.unscale_mut(*gap);
            }
        }
        let sensors = DMatrix::identity(b.nrows(), b.nrows()) + &far * far.transpose();
        // A⁻¹ = L⁻ᵀ L⁻¹.
        let mut half = DMatrix::identity(b.nrows(), b.nrows());
        if !Cholesky::new(sensors).ok_or_else(singular)?.l_dirty().solve_lower_triangular_mut(&mut half) {
            return Err(singular().into());
        }
        let inverse = half.transpose() * &half;
        let weighted = &inverse * &b_near;
        let mut normal = b_near.tr_mul(&weighted);
        // A direction that neither the model nor a sensor holds (exactly at resonance, unseen) stays at zero.
        let ridge = 1e-14 * normal.diagonal().iter().fold(1.0, |m: f64, v| m.max(*v));
        for (i, &k) in near.iter().enumerate() {
            normal[(i, i)] += gap[k] * gap[k] + ridge;
        }
        let q_near = Cholesky::new(normal).ok_or_else(singular)?.solve(&weighted.transpose());
        let mut q = (inverse - &weighted * &q_near).transpose() * &far;
        for (mut column, gap) in q.column_iter_mut().zip(gap.iter()) {
            if gap * gap >= NEAR {
                column.unscale_mut(*gap);
            }
        }
        for (i, &k) in near.iter().enumerate() {
            q.set_column(k, &q_near.row(i).transpose());
        }
        Ok(q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::lowest_modes;
    use crate::modal::reduction::{dynamic_reduction, selection};

    fn chain(n: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let k = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 1000.0 * if i == n - 1 { 1.0 } else { 2.0 },
            1 => -1000.0,
            _ => 0.0,
        });
        (k, DMatrix::identity(n, n))
    }

    /// Two dofs by hand: K = [2 -1; -1 1], M = I, a = 1, sensor on dof 1, ω² = 0, w = 1, σ = 1, y = 1.
    /// u minimises (K u)ᵀ (K + I)⁻¹ (K u) + (u₁ - 1)²; with H = K (K + I)⁻¹ K, (H + e₁e₁ᵀ) u = e₁.
    #[test]
    fn the_minimum_by_normal_equations() {
        let k = DMatrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 1.0]);
        let m = DMatrix::identity(2, 2);
        let s = selection(2, &[0]).unwrap();
        let one = nalgebra::dvector![1.0];
        let expander = Expander::new(&k, &m, &s, 1.0).unwrap();
        let found = expander.expand(&one, &one, 0.0, 1.0).unwrap();
        let energy = (&k + &m).try_inverse().unwrap();
        let h = &k * &energy * &k + DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]);
        let u = h.lu().solve(&nalgebra::dvector![1.0, 0.0]).unwrap();
        let r = energy * &k * &u;
        assert!((&found.shape - &u).abs().max() < 1e-13);
        assert!((&found.residual - &r).abs().max() < 1e-13);
        assert!((found.residual_energy - r.dot(&((k + m) * &r))).abs() < 1e-13);
        assert!((found.sensor_misfit[0] - (u[0] - 1.0)).abs() < 1e-13);
        assert!((expander.shape_sensitivity(&found).column(0) - u).abs().max() < 1e-13);
        assert!((found.residual_sensitivity.column(0) - r).abs().max() < 1e-13);
    }

    /// Two springs of a chain, against Nelson's method.
    #[test]
    fn a_mode_changes_as_its_derivative_says() {
        use crate::modal::mode_derivative_of_forces;
        let (k, m) = chain(9);
        let s = selection(9, &[0, 3, 8]).unwrap();
        let expander = Expander::new(&k, &m, &s, 20.0).unwrap();
        let modes = lowest_modes(&k, &m, 4, 1.0).unwrap();
        for j in 0..4 {
            let phi = modes.vectors.column(j).into_owned();
            let mut forces = DMatrix::zeros(9, 2);
            for (column, at) in [2, 6].into_iter().enumerate() {
                let stretch = phi[at] - phi[at - 1];
                (forces[(at, column)], forces[(at - 1, column)]) = (1000.0 * stretch, -1000.0 * stretch);
            }
            let exact = mode_derivative_of_forces(&k, &m, modes.values[j], &phi, &forces, &DVector::zeros(2)).unwrap();
            let found = expander.mode_change(modes.values[j], &forces).unwrap();
            assert!((&s * exact.shape - found).amax() < 1e-11, "mode {j}");
        }
    }

    #[test]
    fn a_mode_of_the_model_is_expanded_exactly_and_without_residual() {
        let (k, m) = chain(12);
        let modes = lowest_modes(&k, &m, 3, 1.0).unwrap();
        let s = selection(12, &[2, 5, 8, 11]).unwrap();
        let expander = Expander::new(&k, &m, &s, 10.0).unwrap();
        for j in 0..3 {
            let phi = modes.vectors.column(j).into_owned();
            let mut y = &s * &phi;
            y[1] = f64::NAN;
            let sd = DVector::from_element(4, 0.01);
            let weight = expander.weight(0.02, modes.values[j], 1.0);
            let found = expander.expand(&y, &sd, modes.values[j], weight).unwrap();
            assert!((found.shape - phi).abs().max() < 1e-9);
            assert!(found.residual_energy < 1e-15 * modes.values[j]);
            assert!(found.sensor_misfit[1].is_nan());
        }
    }

    /// As w grows the sensors are forced, and with it the shape tends to the one of least residual among all that fit;
    /// dynamic expansion fits as well and cannot have less.
    #[test]
    fn a_large_weight_forces_the_sensors_at_the_least_residual() {
        let (k, m) = chain(8);
        let s = selection(8, &[1, 4, 7]).unwrap();
        let y = nalgebra::dvector![0.3, 0.9, 0.8];
        let (omega_squared, shift) = (300.0, 5.0);
        let expander = Expander::new(&k, &m, &s, shift).unwrap();
        let found = expander.expand(&y, &DVector::from_element(3, 1.0), omega_squared, 1e11).unwrap();
        assert!(found.sensor_misfit.abs().max() < 1e-6);
        let dynamic = dynamic_reduction(&k, &m, &s, omega_squared).unwrap().transformation * y;
        let force = (&k - &m * omega_squared) * dynamic;
        let energy = force.dot(&(&k + &m * shift).lu().solve(&force).unwrap());
        assert!(found.residual_energy <= energy * (1.0 + 1e-6));
    }

    #[test]
    fn free_structures_and_massless_dofs_are_no_special_case() {
        let k = DMatrix::from_row_slice(3, 3, &[1.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]);
        let m = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 0.0, 1.0]);
        let s = selection(3, &[0, 2]).unwrap();
        // Elastic mode: the middle stands still, ω² = 1; (1, 0, -1).
        let expander = Expander::new(&k, &m, &s, 0.5).unwrap();
        let found = expander.expand(&nalgebra::dvector![1.0, -1.0], &nalgebra::dvector![0.1, 0.1], 1.0, 1e-4).unwrap();
        assert!((found.shape - nalgebra::dvector![1.0, 0.0, -1.0]).abs().max() < 1e-10);
    }

    #[test]
    fn wrong_input_is_refused() {
        let (k, m) = chain(3);
        let s = selection(3, &[0]).unwrap();
        assert!(Expander::new(&k, &m, &s, 0.0).is_err());
        assert!(Expander::new(&k, &DMatrix::identity(2, 2), &s, 1.0).is_err());
        assert!(Expander::new(&(&k * f64::NAN), &m, &s, 1.0).is_err());
        let expander = Expander::new(&k, &m, &s, 1.0).unwrap();
        let one = nalgebra::dvector![1.0];
        assert!(expander.expand(&nalgebra::dvector![1.0, 2.0], &one, 1.0, 1.0).is_err());
        assert!(expander.expand(&one, &nalgebra::dvector![0.0], 1.0, 1.0).is_err());
        assert!(expander.expand(&one, &one, -1.0, 1.0).is_err());
        // Nothing measured: nothing said.
        assert_eq!(expander.expand(&(one.clone() * f64::NAN), &one, 1.0, 1.0).unwrap().shape.norm(), 0.0);
    }
}
