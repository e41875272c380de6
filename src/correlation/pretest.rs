//! Before the test: where to measure, where to excite, what the next sensor would tell.
//!
//! All rankings use the model's own modes, so they are as good as the model. Candidates are rows of a matrix of shapes.

use super::{CorrelationError, auto_mac};
use crate::linalg::{DMatrix, DVector, thin_svd};
use nalgebra::Cholesky;

/// A choice of sensors, the order in which it was made, and what it is worth.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct SensorChoice {
    /// Chosen candidates, ascending.
    pub kept: Vec<usize>,
    /// Candidates in the order of removal (or of choice, where a method adds), with the value that decided.
    pub steps: Vec<(usize, f64)>,
    /// Largest MAC off the diagonal of the target modes at the chosen sensors.
    pub largest_off_diagonal: f64,
    /// ln det of the Fisher information ΦᵀΦ of the target modes at the chosen sensors; -∞ when they are dependent.
    pub ln_det_information: f64,
}

impl SensorChoice {
    fn new(phi: &DMatrix<f64>, mut kept: Vec<usize>, steps: Vec<(usize, f64)>) -> Self {
        kept.sort_unstable();
        let chosen = phi.select_rows(&kept);
        let gram = chosen.transpose() * &chosen;
        let ln_det = Cholesky::new(gram).map_or(f64::NEG_INFINITY, |c| 2.0 * c.l().diagonal().map(f64::ln).sum());
        Self { largest_off_diagonal: off_diagonal(&chosen), ln_det_information: ln_det, kept, steps }
    }
}

/// Largest MAC off the diagonal.
fn off_diagonal(phi: &DMatrix<f64>) -> f64 {
    let mac = auto_mac(phi);
    let pairs = (0..mac.nrows()).flat_map(|i| (0..i).map(move |j| (i, j)));
    pairs.map(|at| mac[at]).fold(0.0, f64::max)
}

/// Effective independence: takes away the sensor that adds least to the independence of the target modes.
///
/// ```text
/// E_D = diag(Φ (ΦᵀΦ)⁻¹ Φᵀ),   Σ E_D = n_modes;   the smallest goes, again and again
/// ```
///
/// * `phi` - target modes at the candidates, (n_candidate x n_modes); weighted by √mass for the kinetic-energy variant
/// * `n_keep` - sensors to keep, at least n_modes
///
/// Maximises det ΦᵀΦ step by step: the target modal coordinates come out with the least noise. Tends to crowd sensors
/// in pairs where the structure moves most, and ignores modes that are not targets. Equal values: the last one goes.
///
/// # Source
/// D. C. Kammer, Sensor placement for on-orbit modal identification and correlation of large space structures, Journal of
/// Guidance, Control, and Dynamics 14 (1991) 251-259.
pub fn effective_independence(phi: &DMatrix<f64>, n_keep: usize) -> Result<SensorChoice, CorrelationError> {
    let (n, n_modes) = phi.shape();
    if n_keep < n_modes || n_keep > n {
        return Err(CorrelationError::Count {
            what: "number of sensors to keep",
            value: n_keep,
            expected: format!("at least {n_modes}, as there are target modes, and at most {n}, as there are places"),
        });
    }
    let mut kept: Vec<usize> = (0..n).collect();
    let mut steps = Vec::new();
    while kept.len() > n_keep {
        let svd = thin_svd(&phi.select_rows(&kept))?;
        let u = svd.left.columns(0, svd.rank(1e-10));
        let contribution: Vec<f64> = u.row_iter().map(|row| row.norm_squared()).collect();
        let Some(weakest) = (0..kept.len()).rev().min_by(|&a, &b| contribution[a].total_cmp(&contribution[b])) else {
            break;
        };
        steps.push((kept.remove(weakest), contribution[weakest]));
    }
    Ok(SensorChoice::new(phi, kept, steps))
}

/// Chooses sensors one by one so that the target modes can be told apart by MAC.
///
/// ```text
/// next = argmin_i  max_{r≠s} MAC_rs(chosen + i)
/// ```
///
/// * `phi` - target modes at the candidates, (n_candidate x n_modes)
/// * `start` - sensors that are set already; may be empty, then the largest motion over all modes begins
/// * `n_keep` - sensors to choose in all
///
/// Equal values are decided by the larger motion of the candidate. Good for pairing, blind to noise.
///
/// # Source
/// T. G. Carne, C. R. Dohrmann, A modal test design strategy for model correlation, Proc. 13th IMAC, 1995, 927-933.
pub fn sensors_by_auto_mac(
    phi: &DMatrix<f64>,
    start: &[usize],
    n_keep: usize,
) -> Result<SensorChoice, CorrelationError> {
    let n = phi.nrows();
    if n_keep > n || start.iter().any(|&i| i >= n) {
        return Err(CorrelationError::Count {
            what: "number of sensors to keep",
            value: n_keep,
            expected: format!("at most {n}, as there are places, and the first ones among these"),
        });
    }
    // Modes count equally whatever their scale.
    let lengths: Vec<f64> = phi.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    let unit = DMatrix::from_fn(n, phi.ncols(), |i, r| phi[(i, r)] / lengths[r]);
    let motion: Vec<f64> = unit.row_iter().map(|row| row.norm_squared()).collect();
    let mut kept = start.to_vec();
    kept.sort_unstable();
    kept.dedup();
    let mut steps = Vec::new();
    while kept.len() < n_keep {
        let mut best: Option<(usize, f64)> = None;
        for candidate in (0..n).filter(|i| !kept.contains(i)) {
            let rows: Vec<usize> = kept.iter().copied().chain([candidate]).collect();
            let value = off_diagonal(&unit.select_rows(&rows));
            let is_better = best.is_none_or(|(index, least)| {
                // MACs carry about 1e-15 of rounding noise; 1e-12 apart is a tie.
                value < least - 1e-12 || (value < least + 1e-12 && motion[candidate] > motion[index])
            });
            if is_better {
                best = Some((candidate, value));
            }
        }
        let Some((candidate, value)) = best else { break };
        kept.push(candidate);
        steps.push((candidate, value));
    }
    Ok(SensorChoice::new(phi, kept, steps))
}

/// Share of every dof in the kinetic energy of every mode.
///
/// ```text
/// KE[i,r] = φ[i,r] (M φ)[i,r] / φ_rᵀ M φ_r      (n x n_modes), every column adds to 1
/// ```
///
/// * `phi` - modes at all dofs; `inertia` - M times them, (n x n_modes)
///
/// A dof without sensors that holds much kinetic energy of a target mode should have one. Shares of coupled masses may be
/// slightly negative.
///
/// # Panics
/// If the sizes differ.
///
/// # Source
/// D. C. Kammer, R. D. Triller, Selection of component modes for Craig-Bampton substructure representations, ASME Journal
/// of Vibration and Acoustics 118 (1996) 264-270; common in pretest analysis.
pub fn kinetic_energy_shares(phi: &DMatrix<f64>, inertia: &DMatrix<f64>) -> DMatrix<f64> {
    let total: Vec<f64> = (0..phi.ncols()).map(|r| phi.column(r).dot(&inertia.column(r))).collect();
    DMatrix::from_fn(phi.nrows(), phi.ncols(), |i, r| {
        if total[r] > 0.0 { phi[(i, r)] * inertia[(i, r)] / total[r] } else { 0.0 }
    })
}

/// The candidates with the largest kinetic energy over all target modes.
///
/// * `shares` - from [`kinetic_energy_shares`], rows of the candidates
/// * `n_keep` - how many
pub fn sensors_by_kinetic_energy(phi: &DMatrix<f64>, shares: &DMatrix<f64>, n_keep: usize) -> SensorChoice {
    let mut order: Vec<(usize, f64)> = shares.row_iter().map(|row| row.sum()).enumerate().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    order.truncate(n_keep);
    SensorChoice::new(phi, order.iter().map(|(i, _)| *i).collect(), order)
}

/// How suitable a dof is to drive the target modes.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct DrivingPoint {
    /// The candidate.
    pub candidate: usize,
    /// Optimum driving point, Π_r |φ_ir| relative to each mode's largest entry: 0 on a node line of any mode.
    pub optimum: f64,
    /// The smallest of these relative entries: how close the worst mode is to a node line.
    pub smallest: f64,
    /// Average driving-dof displacement, Σ_r φ_ir²/ω_r², m²/(kg rad²/s²): large where a shaker's own mass and stroke matter.
    pub displacement: f64,
    /// Average driving-dof acceleration, Σ_r φ_ir²: large where a hammer or shaker is efficient but suffers from its mass.
    pub acceleration: f64,
}

/// Ranks exciter places by how well they drive all target modes.
///
/// ```text
/// ODP_i = Π_r |φ_ir|/max|φ_r|,   ADDOFD_i = Σ_r φ_ir²/ω_r²,   ADDOFA_i = Σ_r φ_ir²
/// ```
///
/// * `phi` - mass-normalised target modes at the candidates, (n_candidate x n_modes)
/// * `omega_squared` - ω² of the modes; modes at zero do not count in the displacement
///
/// Sorted by the smallest relative entry, then by the product: an exciter must not stand on any node line. One exciter
/// may not do for all modes of a symmetric structure; rank each family by itself then.
///
/// # Source
/// N. Imamovic, Validation of Large Structural Dynamics Models Using Modal Test Data, PhD thesis, Imperial College
/// London, 1998, chapter 3.
pub fn rank_driving_points(phi: &DMatrix<f64>, omega_squared: &[f64]) -> Vec<DrivingPoint> {
    let largest: Vec<f64> = phi.column_iter().map(|c| c.amax()).collect();
    let mut points: Vec<DrivingPoint> = (0..phi.nrows())
        .map(|candidate| {
            let row = phi.row(candidate);
            let relative = row.iter().zip(&largest).map(|(v, m)| if *m > 0.0 { v.abs() / m } else { 0.0 });
            let compliance = row.iter().zip(omega_squared).filter(|(_, w)| **w > 0.0);
            DrivingPoint {
                candidate,
                optimum: relative.clone().product(),
                smallest: relative.fold(1.0, f64::min),
                displacement: compliance.map(|(v, w)| v * v / w).sum(),
                acceleration: row.norm_squared(),
            }
        })
        .collect();
    points.sort_by(|a, b| b.smallest.total_cmp(&a.smallest).then(b.optimum.total_cmp(&a.optimum)));
    points
}

/// Effective masses of modes for given rigid-body motions.
///
/// ```text
/// L = Φᵀ M R,   m_eff[r,d] = L[r,d]² / (φ_rᵀ M φ_r)        Σ_r over all modes = diag(Rᵀ M R)
/// ```
///
/// * `phi` - modes of the held structure at all dofs, any scale, (n x n_modes)
/// * `inertia` - M times `phi`, (n x n_modes)
/// * `rigid` - motions of all dofs under unit translations (or rotations) of the base, (n x n_directions)
///
/// kg (kg m² for rotations), (n_modes x n_directions). Modes of large effective mass load the base and are targets; modes
/// of a free structure have none.
///
/// # Panics
/// If the sizes differ.
///
/// # Source
/// A. Girard, N. Roy, Structural Dynamics in Industry, 2008, chapter 4.
pub fn effective_masses(phi: &DMatrix<f64>, inertia: &DMatrix<f64>, rigid: &DMatrix<f64>) -> DMatrix<f64> {
    let participation = inertia.transpose() * rigid;
    DMatrix::from_fn(phi.ncols(), rigid.ncols(), |r, d| {
        let modal_mass = phi.column(r).dot(&inertia.column(r));
        if modal_mass > 0.0 { participation[(r, d)].powi(2) / modal_mass } else { 0.0 }
    })
}

/// What one more measurement would tell.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Gain {
    /// The candidate, its place in the list given.
    pub candidate: usize,
    /// Information gained on all parameters together, nats: ½ ln det(I + G F⁻¹ Gᵀ).
    pub nats: f64,
    /// Standard deviation of each parameter after it, over the one before.
    pub sd_ratio: Vec<f64>,
}

/// Ranks candidate measurements by the information they add about the parameters.
///
/// ```text
/// F = JᵀJ + diag(1/prior²),    gain = ½ ln det(I + G F⁻¹ Gᵀ),    after: (F + GᵀG)⁻¹
/// ```
///
/// * `jacobian` - residuals of the test so far in standard deviations, ∂r/∂x, (n_data x n_par); no rows before a test
/// * `prior_sd` - standard deviation of each x before the data; a third of its interval is a common choice
/// * `candidates` - G of each: rows ∂(reading/σ)/∂x, (n_readings x n_par); a sensor reads one shape entry in every mode
///
/// Sorted by the gain, best first; equal ones in the order given. Linear at the point where the Jacobians were taken. The
/// gain of two sensors together is not the sum of their gains: choose one, add its rows to `jacobian`, ask again.
///
/// # Source
/// D-optimal design, gain in Shannon information: D. V. Lindley, Annals of Mathematical Statistics 27 (1956) 986-1005;
/// C. Papadimitriou, Optimal sensor placement methodology for parametric identification of structural systems, Journal of
/// Sound and Vibration 278 (2004) 923-947.
pub fn rank_next_measurements(
    jacobian: &DMatrix<f64>,
    prior_sd: &[f64],
    candidates: &[DMatrix<f64>],
) -> Result<Vec<Gain>, CorrelationError> {
    let n = prior_sd.len();
    let widths = std::iter::once(("Jacobian", jacobian)).chain(candidates.iter().map(|g| ("candidate's rows", g)));
    for (what, a) in widths {
        if a.ncols() != n {
            let expected = format!("{n} columns, one a parameter");
            return Err(CorrelationError::Shape { what, rows: a.nrows(), columns: a.ncols(), expected });
        }
    }
    if let Some(&value) = prior_sd.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
        let what = "prior standard deviation";
        return Err(CorrelationError::Range { what, value, expected: "positive and finite" });
    }
    // In units of the prior, F = I + JᵀJ is safely positive definite.
    let prior = DMatrix::from_diagonal(&DVector::from_column_slice(prior_sd));
    let scaled = jacobian * &prior;
    let fisher = DMatrix::identity(n, n) + scaled.tr_mul(&scaled);
    let not_finite = || CorrelationError::Range {
        what: "information of the data",
        value: f64::NAN,
        expected: "finite; look for sensitivities without a value",
    };
    let inverse = Cholesky::new(fisher).ok_or_else(not_finite)?.inverse();
    let mut gains = Vec::with_capacity(candidates.len());
    for (candidate, rows) in candidates.iter().enumerate() {
        let g = rows * &prior;
        let spread = &inverse * g.transpose();
        let information = DMatrix::identity(g.nrows(), g.nrows()) + &g * &spread;
        let cholesky = Cholesky::new(information).ok_or_else(not_finite)?;
        let reduction = &spread * cholesky.solve(&spread.transpose());
        let ratio = |j: usize| (1.0 - reduction[(j, j)] / inverse[(j, j)]).max(0.0).sqrt();
        gains.push(Gain {
            candidate,
            nats: cholesky.l().diagonal().map(f64::ln).sum(),
            sd_ratio: (0..n).map(ratio).collect(),
        });
    }
    gains.sort_by(|a, b| b.nats.total_cmp(&a.nats));
    Ok(gains)
}

#[cfg(test)]
mod tests;
