//! Reduction of K and M to the sensors: static (Guyan), dynamic, improved (IRS), iterated IRS and SEREP.
//!
//! Every method gives a transformation T from the sensors to all dofs, u = T y, and with it Tᵀ K T and Tᵀ M T. Sensors
//! are rows S of an observation matrix, y = S u, so that a sensor need not sit on a dof; [`selection`] makes the rows
//! of classical master dofs. T always interpolates: S T = I (SEREP: on the span of the kept modes).
//!
//! Sources: R. J. Guyan, Reduction of stiffness and mass matrices, AIAA Journal 3 (1965) 380; J. O'Callahan, A procedure
//! for an improved reduced system (IRS) model, Proc. 7th IMAC, 1989; J. O'Callahan, P. Avitabile, R. Riemer, System
//! equivalent reduction expansion process (SEREP), Proc. 7th IMAC, 1989; M. I. Friswell, S. D. Garvey, J. E. T. Penny,
//! Model reduction using dynamic and iterated IRS techniques, Journal of Sound and Vibration 186 (1995) 311-323.

use retune_linalg::{DMatrix, LinalgError, thin_svd};

/// A reduced model and the way back.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// T, from the sensors to all dofs, (n x n_sensor).
    pub transformation: DMatrix<f64>,
    /// Tᵀ K T, (n_sensor x n_sensor).
    pub stiffness: DMatrix<f64>,
    /// Tᵀ M T, (n_sensor x n_sensor).
    pub mass: DMatrix<f64>,
}

impl Reduction {
    fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, transformation: DMatrix<f64>) -> Self {
        let congruent = |a: &DMatrix<f64>| {
            let reduced = transformation.transpose() * (a * &transformation);
            (&reduced + reduced.transpose()) * 0.5
        };
        Self { stiffness: congruent(k), mass: congruent(m), transformation }
    }
}

/// Why a model cannot be reduced.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReductionError {
    /// A matrix has the wrong shape.
    #[error("the {matrix} matrix is {rows} x {columns}; expected {expected}")]
    Shape {
        /// Which matrix.
        matrix: &'static str,
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// What fits.
        expected: String,
    },
    /// A master dof does not exist.
    #[error("master dof {dof} does not exist; the model has {n_dof} dofs, counted from 0")]
    NoSuchDof {
        /// The dof.
        dof: usize,
        /// Number of dofs.
        n_dof: usize,
    },
    /// The sensors do not hold the structure, or two of them read the same.
    #[error(
        "with the sensors held the stiffness at {frequency_hz:.4} Hz is singular: two sensors read the same motion, or a part of the structure moves freely, or that is a natural frequency of the held structure; leave out a sensor, add one, or choose another frequency"
    )]
    Singular {
        /// Frequency of the dynamic stiffness, 0 for the static one, Hz.
        frequency_hz: f64,
    },
    /// The reduced mass cannot be inverted.
    #[error(
        "the mass reduced to the sensors is singular: a sensor sees no mass; use the static reduction, or leave out that sensor"
    )]
    MasslessSensor,
    /// The modes cannot be told apart at the sensors.
    #[error(
        "the {n_modes} modes have rank {rank} at the {n_sensors} sensors; keep fewer modes or add sensors that tell them apart"
    )]
    DependentModes {
        /// Number of modes.
        n_modes: usize,
        /// Number of sensors.
        n_sensors: usize,
        /// Their rank there.
        rank: usize,
    },
    /// A kernel failed.
    #[error("the reduction has no result")]
    Linalg(#[from] LinalgError),
}

/// Rows of the observation matrix that pick dofs: row i has a 1 in column `dofs[i]`, (dofs x n).
pub fn selection(n_dof: usize, dofs: &[usize]) -> Result<DMatrix<f64>, ReductionError> {
    let mut s = DMatrix::zeros(dofs.len(), n_dof);
    for (row, &dof) in dofs.iter().enumerate() {
        if dof >= n_dof {
            return Err(ReductionError::NoSuchDof { dof, n_dof });
        }
        s[(row, dof)] = 1.0;
    }
    Ok(s)
}

/// Static reduction (Guyan).
///
/// ```text
/// u = T y   minimises uᵀ K u   with   S u = y
/// [K  Sᵀ] [T]   [0]
/// [S  0 ] [Λ] = [I]         for masters and slaves:  T = [I; -K_ss⁻¹ K_sm]
/// ```
///
/// * `k`, `m` - symmetric, (n x n); K may be singular as long as the sensors hold the structure
/// * `s` - observation rows, (n_sensor x n)
///
/// Exact for static loads at the sensors and for massless hidden dofs. Hidden inertia is lumped along static shapes, so
/// reduced frequencies lie above the true ones, the more the higher.
pub fn guyan(k: &DMatrix<f64>, m: &DMatrix<f64>, s: &DMatrix<f64>) -> Result<Reduction, ReductionError> {
    dynamic_reduction(k, m, s, 0.0)
}

/// Dynamic reduction: exact at one frequency.
///
/// ```text
/// as the static reduction, with D = K - ω² M in the place of K
/// ```
///
/// * `omega_squared` - ω², (rad/s)²
///
/// Exact at ω: a mode of the full model at that frequency is a mode of the reduced one. Fails at the natural frequencies
/// of the structure with its sensors held, and is poor near them.
///
/// # Source
/// A. Y. T. Leung, An accurate method of dynamic condensation in structural analysis, International Journal for
/// Numerical Methods in Engineering 12 (1978) 1705-1715.
pub fn dynamic_reduction(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    s: &DMatrix<f64>,
    omega_squared: f64,
) -> Result<Reduction, ReductionError> {
    check_shapes(k, m, s)?;
    let held = Held::new(k, m, s, omega_squared)?;
    Ok(Reduction::new(k, m, held.interpolate()))
}

/// Improved reduced system, once or iterated.
///
/// ```text
/// T₀ = Guyan,   T_{i+1} = T₀ + Δ,   [K Sᵀ; S 0] [Δ; Λ] = [M T_i (T_iᵀ M T_i)⁻¹ (T_iᵀ K T_i); 0]
/// ```
///
/// * `iterations` - 1 for the classical IRS; more converge to a reduced model with exact lowest modes
///
/// First order in the hidden inertia: much closer than Guyan, but frequencies may fall below the true ones and the
/// reduced matrices are more sensitive to modelling errors. Convergence is fastest for the lowest modes and needs the
/// reduced frequencies to lie well below those of the structure with held sensors. With several sensors without mass
/// of their own (T_iᵀ M T_i singular) it has no result.
///
/// # Source
/// O'Callahan 1989 and Friswell, Garvey, Penny 1995 (see the module).
pub fn irs(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    s: &DMatrix<f64>,
    iterations: usize,
) -> Result<Reduction, ReductionError> {
    guyan_and_irs(k, m, s, iterations)?.1
}

/// [`guyan`] and [`irs`], which starts from it, at the cost of the second.
///
/// Fails where neither exists.
pub fn guyan_and_irs(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    s: &DMatrix<f64>,
    iterations: usize,
) -> Result<(Reduction, Result<Reduction, ReductionError>), ReductionError> {
    check_shapes(k, m, s)?;
    let held = Held::new(k, m, s, 0.0)?;
    let fixed = Reduction::new(k, m, held.interpolate());
    let improve = |mut reduction: Reduction| {
        for _ in 0..iterations {
            let cholesky = nalgebra::Cholesky::new(reduction.mass.clone()).ok_or(ReductionError::MasslessSensor)?;
            // Pivots at rounding level: the factor exists by chance.
            let pivots = cholesky.l().diagonal().map(|v| v * v);
            if pivots.len() > 1 && pivots.min() <= 1e-14 * pivots.max() {
                return Err(ReductionError::MasslessSensor);
            }
            let inertia = m * (&reduction.transformation * cholesky.solve(&reduction.stiffness));
            reduction = Reduction::new(k, m, &fixed.transformation + held.respond(&inertia));
        }
        Ok(reduction)
    };
    let improved = improve(fixed.clone());
    Ok((fixed, improved))
}

/// System equivalent reduction expansion process: exact in the kept modes.
///
/// ```text
/// T = Φ (S Φ)⁺        T (S Φ) = Φ
/// ```
///
/// * `phi` - kept modes at all dofs, (n x n_modes)
/// * `s` - observation rows, (n_sensor x n), at least as many as modes; there may be more of them than dofs
///
/// The reduced model has the kept frequencies and shapes exactly, whatever the sensors, as long as these tell the modes
/// apart. With more sensors than modes the reduced matrices are singular (rank n_modes), and anything outside the span
/// of the kept modes, such as noise, is projected away: cross-orthogonality then looks better than the test is.
///
/// # Source
/// O'Callahan, Avitabile, Riemer 1989 (see the module).
pub fn serep(
    k: &DMatrix<f64>,
    m: &DMatrix<f64>,
    s: &DMatrix<f64>,
    phi: &DMatrix<f64>,
) -> Result<Reduction, ReductionError> {
    check_matrices(k, m, s)?;
    if phi.nrows() != k.nrows() {
        let (rows, columns) = phi.shape();
        let expected = format!("{} rows", k.nrows());
        return Err(ReductionError::Shape { matrix: "mode shape", rows, columns, expected });
    }
    Ok(Reduction::new(k, m, serep_transformation(phi, &(s * phi))?))
}

/// T of [`serep`] from the modes at all dofs (n x n_modes) and at the sensors (n_sensor x n_modes).
pub fn serep_transformation(phi: &DMatrix<f64>, observed: &DMatrix<f64>) -> Result<DMatrix<f64>, ReductionError> {
    /// Relative singular value below which two modes count as equal at the sensors: noise would grow 10⁸ times.
    const INDISTINGUISHABLE: f64 = 1e-8;
    let (n_sensors, n_modes) = observed.shape();
    if phi.ncols() != n_modes {
        let expected = format!("{} columns", phi.ncols());
        return Err(ReductionError::Shape { matrix: "observed shape", rows: n_sensors, columns: n_modes, expected });
    }
    // Columns of unit length at the sensors: the rank does not depend on how the modes are scaled.
    let lengths: Vec<f64> = observed.column_iter().map(|c| c.norm()).collect();
    let unit =
        DMatrix::from_fn(n_sensors, n_modes, |i, j| if lengths[j] > 0.0 { observed[(i, j)] / lengths[j] } else { 0.0 });
    let svd = thin_svd(&unit)?;
    let rank = svd.rank(INDISTINGUISHABLE);
    if rank < n_modes {
        return Err(ReductionError::DependentModes { n_modes, n_sensors, rank });
    }
    let mut scaled = phi.clone();
    for (mut column, length) in scaled.column_iter_mut().zip(&lengths) {
        column.unscale_mut(*length);
    }
    Ok(scaled * svd.pseudo_inverse(INDISTINGUISHABLE))
}

/// For transformations that interpolate the sensors, S T = I: more of them than dofs cannot all be independent.
fn check_shapes(k: &DMatrix<f64>, m: &DMatrix<f64>, s: &DMatrix<f64>) -> Result<(), ReductionError> {
    check_matrices(k, m, s)?;
    let (n, (rows, columns)) = (k.nrows(), s.shape());
    if rows > n {
        let expected =
            format!("at most {n} rows: more sensors than dofs cannot all be masters (SEREP takes any number)");
        return Err(ReductionError::Shape { matrix: "observation", rows, columns, expected });
    }
    Ok(())
}

fn check_matrices(k: &DMatrix<f64>, m: &DMatrix<f64>, s: &DMatrix<f64>) -> Result<(), ReductionError> {
    let n = k.nrows();
    let fits = |matrix, a: &DMatrix<f64>, is_fit: bool, expected: String| {
        let (rows, columns) = a.shape();
        if is_fit { Ok(()) } else { Err(ReductionError::Shape { matrix, rows, columns, expected }) }
    };
    fits("stiffness", k, k.ncols() == n, format!("{n} x {n}"))?;
    fits("mass", m, m.shape() == (n, n), format!("{n} x {n}"))?;
    fits("observation", s, s.ncols() == n, format!("{n} columns"))?;
    for (matrix, a) in [("stiffness", k), ("mass", m), ("observation", s)] {
        if let Some(at) = a.iter().position(|v| !v.is_finite()) {
            return Err(LinalgError::NotFinite { matrix, row: at % a.nrows() }.into());
        }
    }
    Ok(())
}

/// The structure with its sensors held: the factorised matrix [D Sᵀ; S 0], equilibrated.
struct Held {
    lu: nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>,
    /// Column and row scales of the n dofs and of the multipliers.
    scale: Vec<f64>,
    n_dof: usize,
}

impl Held {
    fn new(k: &DMatrix<f64>, m: &DMatrix<f64>, s: &DMatrix<f64>, omega_squared: f64) -> Result<Self, ReductionError> {
        let (n_dof, n_sensors) = (k.nrows(), s.nrows());
        let d = k - m * omega_squared;
        // Unit diagonal of K + ω²M makes dofs of different units comparable; then unit rows of S.
        let size = |i: usize| k[(i, i)].abs() + omega_squared.abs() * m[(i, i)].abs();
        let mut scale: Vec<f64> = (0..n_dof).map(|i| if size(i) > 0.0 { 1.0 / size(i).sqrt() } else { 1.0 }).collect();
        for row in s.row_iter() {
            let norm = row.iter().zip(&scale).map(|(v, c)| (v * c).powi(2)).sum::<f64>().sqrt();
            scale.push(if norm > 0.0 { 1.0 / norm } else { 1.0 });
        }
        let size = n_dof + n_sensors;
        let saddle = DMatrix::from_fn(size, size, |i, j| {
            let entry = match (i < n_dof, j < n_dof) {
                (true, true) => d[(i, j)],
                (true, false) => s[(j - n_dof, i)],
                (false, true) => s[(i - n_dof, j)],
                (false, false) => 0.0,
            };
            entry * scale[i] * scale[j]
        });
        let lu = saddle.lu();
        let pivots = lu.u().diagonal().abs();
        // Equilibrated entries are of order one; a pivot at rounding level is a zero.
        if size > 0 && pivots.min() <= 1e-14 * size as f64 * pivots.max() {
            let frequency_hz = omega_squared.max(0.0).sqrt() / std::f64::consts::TAU;
            return Err(ReductionError::Singular { frequency_hz });
        }
        Ok(Self { lu, scale, n_dof })
    }

    /// T with S T = I and no forces outside the sensors.
    fn interpolate(&self) -> DMatrix<f64> {
        let n_sensors = self.scale.len() - self.n_dof;
        let rhs = DMatrix::from_fn(self.scale.len(), n_sensors, |i, j| f64::from(u8::from(i == self.n_dof + j)));
        self.solve(rhs)
    }

    /// Displacements under forces (n x columns) with the sensors held at zero.
    fn respond(&self, forces: &DMatrix<f64>) -> DMatrix<f64> {
        let rhs = DMatrix::from_fn(
            self.scale.len(),
            forces.ncols(),
            |i, j| {
                if i < self.n_dof { forces[(i, j)] } else { 0.0 }
            },
        );
        self.solve(rhs)
    }

    fn solve(&self, mut rhs: DMatrix<f64>) -> DMatrix<f64> {
        let apply_scale = |a: &mut DMatrix<f64>| {
            for (mut row, scale) in a.row_iter_mut().zip(&self.scale) {
                row *= *scale;
            }
        };
        apply_scale(&mut rhs);
        // The pivots are checked: the system is solvable.
        self.lu.solve_mut(&mut rhs);
        apply_scale(&mut rhs);
        rhs.rows(0, self.n_dof).into_owned()
    }
}

#[cfg(test)]
mod tests;
