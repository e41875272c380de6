//! Measured mass, centre of gravity and inertia.

use super::super::comparison::Comparison;
use super::super::prediction::PredictionDerivative;
use super::{Point, Residual};
use crate::data::MassQuantity;
use crate::linalg::DMatrix;
use crate::model::MassProperties;

/// r = (model - test)/σ for every mass property of the test file.
#[derive(Debug, Clone, Copy)]
pub struct MassPropertyResidual;

/// The model's value of a quantity.
pub(crate) fn value(p: &MassProperties, quantity: MassQuantity) -> f64 {
    match quantity {
        MassQuantity::Mass => p.mass,
        MassQuantity::Cg(i) => p.cg[i],
        // Products of inertia are ∫ x y dm; the tensor carries them with a minus sign.
        MassQuantity::Inertia(i, j) => p.inertia[i][j] * if i == j { 1.0 } else { -1.0 },
    }
}

/// Fills the columns of `out` with derivatives of a function of the mass properties, by differences: they are rational
/// functions of θ, and a step of 1e-6 of the interval leaves an error of about 1e-9.
pub(super) fn difference(at: &Point<'_>, out: &mut DMatrix<f64>, rows: impl Fn(&MassProperties, &mut [f64])) {
    let model = at.comparison.model();
    let n = out.nrows();
    if n == 0 {
        return;
    }
    out.fill(0.0);
    let slopes = at.scaling.slopes(at.theta);
    let moved = at.scaling.free().iter().zip(slopes).enumerate().filter(|(_, (j, _))| model.has_mass_of(**j));
    let steps: Vec<(usize, usize, f64)> = moved.map(|(column, (&j, width))| (column, j, 1e-6 * width)).collect();
    let both = |&(_, j, step): &(usize, usize, f64)| [at.theta[j] + step, at.theta[j] - step].map(|value| (j, value));
    let others: Vec<(usize, f64)> = steps.iter().flat_map(both).collect();
    let properties = model.mass_properties_beside(at.theta, &others);
    let [mut above, mut below] = [vec![0.0; n], vec![0.0; n]];
    for (&(column, _, step), beside) in steps.iter().zip(properties.chunks_exact(2)) {
        let [Some(p), Some(q)] = beside else { continue };
        rows(p, &mut above);
        rows(q, &mut below);
        for i in 0..n {
            out[(i, column)] = (above[i] - below[i]) / (2.0 * step);
        }
    }
}

fn rows(comparison: &Comparison<'_>, p: &MassProperties, out: &mut [f64]) {
    for (r, m) in out.iter_mut().zip(&comparison.test().mass_properties) {
        *r = (value(p, m.quantity) - m.measured.value) / m.measured.sd;
    }
}

impl Residual for MassPropertyResidual {
    fn name(&self) -> &'static str {
        "mass-properties"
    }

    fn summary(&self) -> &'static str {
        "measured mass, centre of gravity and inertia, each over its standard deviation"
    }

    fn len(&self, comparison: &Comparison<'_>) -> usize {
        comparison.test().mass_properties.len()
    }

    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String {
        comparison.test().mass_properties[row].quantity.word().to_string()
    }

    fn needs_system(&self) -> bool {
        false
    }

    fn needs_shapes(&self) -> bool {
        false
    }

    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]) {
        out.fill(0.0);
        if let Some(p) = &at.prediction.mass_properties {
            rows(at.comparison, p, out);
        }
    }

    fn differentiate(&self, at: &Point<'_>, _: &PredictionDerivative, out: &mut DMatrix<f64>) {
        difference(at, out, |p, r| rows(at.comparison, p, r));
    }
}
