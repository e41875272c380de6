//! Mass properties that the model file asks an update to respect.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::mass_properties::difference;
use super::{Point, Residual};
use crate::linalg::DMatrix;
use crate::model::{MassProperties, Targets};

/// r = ln(1 + exp(u/w)), u = |value - target|/tolerance - 1, w = 0.01, for every target of the model file.
///
/// A soft wall at the edge of the tolerance: r is 0.007 where 5 % of the tolerance are left, 0.7 on the edge, and grows
/// by one standard deviation with every hundredth of the tolerance beyond it. Its slope shows before the edge, so that a
/// gradient method slows down instead of bouncing back and forth over a kink.
#[derive(Debug, Clone, Copy)]
pub struct TargetResidual;

/// Width of the wall, in tolerances.
pub(crate) const WIDTH: f64 = 0.01;

/// |value - target|/tolerance - 1 for each target: mass, centre of gravity, inertia; -∞ where there is none.
fn excess(targets: &Targets, p: &MassProperties) -> [f64; 7] {
    let mut out = [f64::NEG_INFINITY; 7];
    let pairs = std::iter::once((targets.mass, p.mass))
        .chain((0..3).map(|i| (targets.cg[i], p.cg[i])))
        .chain((0..3).map(|i| (targets.inertia[i], p.inertia[i][i])));
    for (v, (target, value)) in out.iter_mut().zip(pairs) {
        *v = target.map_or(f64::NEG_INFINITY, |t| (value - t.value).abs() / t.tolerance - 1.0);
    }
    out
}

/// How far each target is missed, in tolerances beyond the accepted range: mass, centre of gravity, inertia.
pub(crate) fn violations(targets: &Targets, p: &MassProperties) -> [f64; 7] {
    excess(targets, p).map(|u| u.max(0.0))
}

/// ln(1 + eᵗ) without overflow.
fn soft_plus(t: f64) -> f64 {
    t.max(0.0) + (-t.abs()).exp().ln_1p()
}

fn rows(targets: &Targets, p: &MassProperties, out: &mut [f64]) {
    out.iter_mut().zip(excess(targets, p)).for_each(|(r, u)| *r = soft_plus(u / WIDTH));
}

impl Residual for TargetResidual {
    fn name(&self) -> &'static str {
        "targets"
    }

    fn summary(&self) -> &'static str {
        "mass-property targets of the model file: a soft wall at the edge of their tolerance"
    }

    fn is_data(&self) -> bool {
        false
    }

    fn len(&self, _: &Comparison<'_>) -> usize {
        7
    }

    fn row_name(&self, _: &Comparison<'_>, row: usize) -> String {
        let names = ["total_mass", "cg.x", "cg.y", "cg.z", "inertia.xx", "inertia.yy", "inertia.zz"];
        format!("target {}", names[row])
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn needs_shapes(&self) -> bool {
        false
    }

    fn is_wall(&self) -> bool {
        true
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        out.fill(0.0);
        if let Some(p) = &at.prediction.mass_properties {
            rows(&at.comparison.model().targets(), p, out);
        }
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        let targets = at.comparison.model().targets();
        difference(at, out, |p, r| rows(&targets, p, r));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_wall_is_soft_before_the_edge_and_steep_behind_it() {
        for (u, r) in [(-0.05, 0.00672), (0.0, std::f64::consts::LN_2), (0.1, 10.00005)] {
            assert!((soft_plus(u / WIDTH) - r).abs() < 1e-5);
        }
        assert_eq!(soft_plus(f64::NEG_INFINITY), 0.0);
        assert_eq!(soft_plus(1e300), 1e300);
    }
}
