//! From comparisons and settings to the objective of a fit.

use super::{Cost, Settings};
use crate::objective::{Comparison, Objective, PaperCost, Scaling, Stacked};

/// The costs of all comparisons, added; what belongs to the parameters counts once.
///
/// * `scaling` - from the unit box to the parameters of all
pub(super) fn stack<'a>(
    comparisons: &'a [Comparison<'a>],
    settings: &Settings,
    scaling: &Scaling,
    cost: Cost,
) -> Stacked<'a> {
    let has_targets = |c: &Comparison<'_>| c.model().targets() != crate::model::Targets::default();
    let owner = comparisons.iter().position(has_targets).unwrap_or(0);
    let part = |(k, c): (usize, &'a Comparison<'a>)| -> Box<dyn Objective + 'a> {
        match cost {
            Cost::Paper => Box::new(PaperCost::new(c).with_scaling(scaling.clone())),
            Cost::Frequencies => Box::new(PaperCost::frequencies_only(c).with_scaling(scaling.clone())),
            Cost::LeastSquares => Box::new(settings.objective.least_squares(c, scaling, k == owner)),
        }
    };
    Stacked::of(comparisons.iter().enumerate().map(part).collect())
}
