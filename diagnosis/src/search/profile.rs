//! Intervals of sizes that the data know badly: not by the curvature at the optimum, but by where the test would still be explained.
//!
//! A joint that gives more and more becomes a hinge, and a spring that grows becomes a support: from some size on nothing changes, and the
//! interval has no end but the bound. With r(v) the rows at a size v, and the columns of all other parameters and free scales projected out of them:
//!
//! ```text
//! |r'(v)|² - |r'(v̂)|² ≤ 2.71        (90 % of χ² with one degree of freedom)
//! ```
//!
//! # Source
//! D. J. Venzon, S. H. Moolgavkar, A method for computing profile-likelihood-based confidence intervals, Applied Statistics 37, 1988.

use super::hypothesis::Estimate;
use crate::error::DiagnosisError;
use crate::problem::fit::{Fit, project};
use crate::problem::rows::Posed;
use crate::problem::scene::Scene;
use retune::effect::NewParameter;
use retune::linalg::DVector;
use retune::objective::Objective;

/// 90 % of χ² with one degree of freedom.
const NINETY_OF_ONE: f64 = 2.706;
/// Half an interval above this share of the value is not trusted to the curvature.
const POOR: f64 = 0.3;
/// Steps on the ladder of doubled sizes.
const LADDER: usize = 40;
/// Halvings between the last size inside and the first outside, on a scale of logarithms.
const HALVINGS: usize = 4;

/// Puts the intervals right of sizes that may reach far and that the data know badly.
///
/// * `of` - the parameters that the effect brought, which stand last in the fit, in the order of the estimates
pub(super) fn widen(
    scene: &Scene,
    fit: &Fit,
    of: &[NewParameter],
    weight: f64,
    estimates: &mut [Estimate],
) -> Result<(), DiagnosisError> {
    let first = fit.x.len() - of.len();
    let is_poor = |e: &Estimate| e.value > 0.0 && e.interval[1] - e.value > POOR * e.value;
    // Of a spring that is tuned to a mode, too, all that is stiff is alike.
    let is_tuned = |p: &NewParameter| !p.grid.is_empty() && p.bounds[0] > 0.0;
    let reaches_far = |p: &NewParameter| p.spans_decades() && p.neutral == 0.0 || is_tuned(p);
    let wanted = |k: &usize| reaches_far(&of[*k]) && is_poor(&estimates[*k]);
    let wanted: Vec<usize> = (0..of.len().min(estimates.len())).filter(wanted).collect();
    if wanted.is_empty() {
        return Ok(());
    }
    let comparisons = scene.comparisons()?;
    let posed = Posed::new(scene, &comparisons, scene.priors(), weight);
    for k in wanted {
        let others =
            Fit { j: fit.j.clone().remove_column(first + k), x: fit.x.clone().remove_row(first + k), ..fit.clone() };
        let q = others.basis()?;
        let [low, high] = of[k].bounds;
        let left = |value: f64| {
            let mut x: DVector<f64> = fit.x.clone();
            x[first + k] = of[k].in_box(value);
            posed.residuals(&x).map_or(f64::INFINITY, |r| project(&q, &r).norm_squared())
        };
        let value = estimates[k].value;
        let least = left(value);
        let is_inside = |v: f64| left(v) - least <= NINETY_OF_ONE;
        let interval = &mut estimates[k].interval;
        interval[1] = end(value, high, 2.0, is_inside);
        interval[0] = end(value, low.max(0.0), 0.5, is_inside);
    }
    Ok(())
}

/// The end of an interval from a value towards a bound.
fn end(value: f64, bound: f64, factor: f64, is_inside: impl Fn(f64) -> bool) -> f64 {
    let is_past = |v: f64| if factor > 1.0 { v >= bound } else { v <= bound.max(1e-6 * value) };
    let (mut inside, mut outside) = (value, None);
    for _ in 0..LADDER {
        let next = inside * factor;
        if is_past(next) {
            if is_inside(bound) {
                return bound;
            }
            outside = Some(bound.max(1e-6 * value));
            break;
        }
        if !is_inside(next) {
            outside = Some(next);
            break;
        }
        inside = next;
    }
    let Some(mut outside) = outside else { return inside };
    for _ in 0..HALVINGS {
        let middle = (inside * outside).sqrt();
        if is_inside(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    inside
}

#[cfg(test)]
mod tests {
    use super::end;

    /// The end of an interval is where the misfit says, or the bound where it never does.
    #[test]
    fn the_end_of_an_interval_is_found_or_is_the_bound() {
        let up_to = |most: f64| move |v: f64| v <= most;
        assert!((end(1.0, 1e6, 2.0, up_to(37.0)) / 37.0 - 1.0).abs() < 0.05);
        assert_eq!(end(1.0, 50.0, 2.0, |_| true), 50.0);
        assert!((end(1.0, 0.0, 0.5, |v| v >= 0.02) / 0.02 - 1.0).abs() < 0.05);
        assert_eq!(end(1.0, 0.0, 0.5, |_| true), 0.0);
    }
}
