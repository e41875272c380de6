//! Modes just outside the band: poles of the fit that are not a result.
//!
//! The series of the residual terms converge slowly where a mode lies a few percent beyond an end of the band, and what they
//! leave bends the shapes inside. So where the band itself ends, one pole on each side is tried beside the terms:
//!
//! ```text
//! ω = ω_end d  or  ω_end/d,   d = 1.02, 1.06, 1.12, 1.25, 1.5,   ζ = 2 %
//! ```
//! The start that leaves least is refined with all other poles, and stays when the Bayesian information criterion says so.
//!
//! Source of the idea: W. Heylen, S. Lammens, P. Sas, Modal Analysis Theory and Testing, 1997 (computational poles beside
//! upper and lower residuals); of the criterion: G. Schwarz, Estimating the dimension of a model, Ann. Statist. 6, 1978.

use super::IdentifyError;
use super::band::Band;
use super::fit::merit_at;
use super::fitted::Fit;
use super::plscf::Pole;
use super::poles::Poles;
use super::scan::participation;
use retune_linalg::Complex;

/// Distances of the starts from an end of the band: each is within reach of its neighbours for Gauss-Newton at 2 % damping.
const DISTANCES: [f64; 5] = [1.02, 1.06, 1.12, 1.25, 1.5];

/// Damping ratio of the starts.
const DAMPING: f64 = 0.02;

/// An end of the band.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Below,
    Above,
}

/// The start on one side that leaves least of the functions beside the poles `beside`; `remainder` tells its participation.
pub(super) fn start(
    band: &Band,
    remainder: &Band,
    beside: (&[Pole], &[Pole]),
    fit: &Fit,
    side: Side,
) -> Result<Option<Pole>, IdentifyError> {
    let line = if side == Side::Below { 0 } else { band.n_lines() - 1 };
    let participation = participation(remainder, line);
    let mut best: Option<(f64, Pole)> = None;
    for d in DISTANCES {
        let omega = if side == Side::Below { band.omega[line] / d } else { band.omega[line] * d };
        let value = Complex::new(-DAMPING, (1.0 - DAMPING * DAMPING).sqrt()) * omega;
        let pole = Pole { value, participation: participation.clone() };
        let poles = Poles::new(beside.0.iter().chain([&pole]), beside.1);
        let merit = match merit_at(band, &poles, fit.terms) {
            Ok(merit) => merit,
            Err(IdentifyError::Singular { .. } | IdentifyError::TooFewLines { .. }) => continue,
            Err(e) => return Err(e),
        };
        if best.as_ref().is_none_or(|b| merit < b.0) {
            best = Some((merit, pole));
        }
    }
    Ok(best.map(|b| b.1))
}
