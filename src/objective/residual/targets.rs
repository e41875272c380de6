//! Mass properties that the model file asks an update to respect.

use super::super::prediction::{Comparison, PredictionDerivative};
use super::mass_properties::difference;
use super::{Point, Residual};
use crate::linalg::DMatrix;
use crate::model::{MassProperties, Targets};

/// r = max(0, |value - target|/tolerance - 1)/0.001 for every target of the model file: zero inside the tolerance.
///
/// The factor makes a violation by a thousandth of the tolerance weigh one standard deviation.
#[derive(Debug, Clone, Copy)]
pub struct TargetResidual;

const MARGIN: f64 = 0.001;

/// How far each target is missed, in tolerances beyond the accepted range: mass, centre of gravity, inertia.
pub(crate) fn violations(targets: &Targets, p: &MassProperties) -> [f64; 7] {
    let mut out = [0.0; 7];
    let pairs = std::iter::once((targets.mass, p.mass))
        .chain((0..3).map(|i| (targets.cg[i], p.cg[i])))
        .chain((0..3).map(|i| (targets.inertia[i], p.inertia[i][i])));
    for (v, (target, value)) in out.iter_mut().zip(pairs) {
        *v = target.map_or(0.0, |t| ((value - t.value).abs() / t.tolerance - 1.0).max(0.0));
    }
    out
}

impl Residual for TargetResidual {
    fn name(&self) -> &'static str {
        "targets"
    }

    fn summary(&self) -> &'static str {
        "mass-property targets of the model file: zero inside their tolerance, steep outside"
    }

    fn len(&self, _: &Comparison<'_>) -> usize {
        7
    }

    fn row_name(&self, _: &Comparison<'_>, row: usize) -> String {
        let names = ["total_mass", "cg.x", "cg.y", "cg.z", "inertia.xx", "inertia.yy", "inertia.zz"];
        format!("target {}", names[row])
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        out.fill(0.0);
        if let Some(p) = &at.prediction.mass_properties {
            for (r, v) in out.iter_mut().zip(violations(&at.comparison.model().targets(), p)) {
                *r = v / MARGIN;
            }
        }
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        let targets = at.comparison.model().targets();
        difference(at, out, |p, r| r.iter_mut().zip(violations(&targets, p)).for_each(|(r, v)| *r = v / MARGIN));
    }
}
