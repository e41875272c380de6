//! The objective of a fit, for a search of the caller's own.

use super::{Cost, Regularization, Settings, Settled, TestCase, UpdateError, compare_all, objective, regularization};
use crate::linalg::DVector;
use crate::objective::{Augmented, Objective, Scaling};

/// Poses the fit of [`super::update_to_tests`] and hands its objective over: pairs settled, terms, loss, regularisation and limits as in the
/// settings. What a search of one's own finds has the cost that an update would give it.
///
/// * `search` - told the objective over the unit box, from there to the parameters, and where a fit would begin
///
/// # Errors
/// As [`super::update_to_tests`] before its search.
pub fn with_objective<R>(
    cases: &[TestCase<'_>],
    settings: &Settings,
    search: impl FnOnce(&dyn Objective, &Scaling, &DVector<f64>) -> R,
) -> Result<R, UpdateError> {
    let settled = Settled::new(cases, settings)?;
    let cases = &settled.cases(cases)[..];
    let comparisons = compare_all(cases, settings)?;
    let model = comparisons[0].model();
    let scaling = Scaling::for_search(model);
    let start = scaling.x(&crate::objective::starting_point(model));
    let data = objective::stack(&comparisons, settings, &scaling, settings.cost);
    let walls = settings.objective.walls(model, &scaling).map_err(UpdateError::Limits)?;
    let pull = match settings.cost {
        Cost::LeastSquares => settings.objective.regularization,
        Cost::Paper | Cost::Frequencies => Regularization::None,
    };
    let weight = regularization::weight(pull, &data, &start, &walls)?;
    let objective = Augmented::new(&data, weight, start.clone(), walls);
    let near = settled.theta.as_ref().map(|theta| scaling.x(theta));
    let begin = match &near {
        Some(x) if objective.cost(x)? < objective.cost(&start)? => x,
        _ => &start,
    };
    Ok(search(&objective, &scaling, begin))
}
