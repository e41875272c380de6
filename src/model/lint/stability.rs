//! Preloads against what makes a structure buckle.

use super::Soundness;
use crate::model::compile::Model;
use crate::model::dependence::interior_point;
use crate::model::value::quantity;
use crate::model::{ModelError, ParametricModel};
use crate::yaml::Problem;

/// Halvings of the way to a bound.
const HALVINGS: usize = 16;

/// How far a structure is from buckling, and which bounds reach it.
pub(super) fn stability(model: &Model, s: &mut Soundness) -> Result<(), ModelError> {
    if !model.is_preloaded() || model.dof_map().n_dof() == 0 {
        return Ok(());
    }
    let theta = interior_point(model.parameters());
    s.buckling_factor = model.critical_preload(&theta)?.map(|c| c.factor);
    // That the estimates themselves are beyond is an error of its own.
    if s.buckling_factor.is_some_and(|f| f <= 1.0) || !model.is_stable(&theta)? {
        return Ok(());
    }
    for j in model.parameters().free() {
        let p = model.parameters().get(j);
        let Some(bounds) = p.bounds else { continue };
        for (side, bound) in ["lower", "upper"].into_iter().zip(bounds) {
            let at = |fraction: f64| {
                let mut moved = theta.clone();
                moved[j] += fraction * (bound - theta[j]);
                moved
            };
            // A bound at which an element has no matrices is complained of elsewhere.
            if model.is_stable(&at(1.0)).unwrap_or(true) {
                continue;
            }
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if model.is_stable(&at(middle))? { low = middle } else { high = middle }
            }
            let shown = |value: f64| quantity(p.display(value), &p.unit).trim_end().to_string();
            s.warnings.push(Problem::warning(
                format!("parameters.{}.bounds", p.name),
                format_args!(
                    "the structure buckles where `{}` is {}, before its {side} bound {}: an update cannot go beyond; move the bound",
                    p.name,
                    shown(at(low)[j]),
                    shown(bound)
                ),
            ));
        }
    }
    Ok(())
}
