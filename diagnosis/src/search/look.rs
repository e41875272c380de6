//! A look at effects at several sizes each, before any of them is fitted.
//!
//! Slopes mislead where an effect is large: a mass of a fifth of the structure, or a joint that has hardly any stiffness left, moves modes far from
//! where their slopes point, and stands behind hundreds of others in the ranking. What it leaves of the residual at a size that it may have tells.

use super::starts::start_sizes;
use crate::error::DiagnosisError;
use crate::problem::changed::with_effect;
use crate::problem::fit::project;
use crate::problem::prior::Prior;
use crate::problem::rows::Posed;
use crate::problem::scene::Scene;
use crate::screen::effects::{Score, Screened, is_small, steps};
use crate::screen::stage::Stage;
use rayon::prelude::*;
use retune::linalg::DVector;
use std::collections::BTreeMap;

/// Effects by what they leave at the best of their sizes. What stands in for a large model is evaluated at each size; of a small one the screening has
/// done so at the typical sizes. On a mesh of more dofs than matrices are dense for, where every change takes solutions of its own, the best by their
/// slopes alone are looked at.
pub(super) fn by_size(stage: &Stage) -> Vec<&Score> {
    let most = if stage.scene.is_huge() { stage.effort().near } else { usize::MAX };
    let all = &stage.effects[..stage.effects.len().min(most)];
    let left: Vec<Option<f64>> = if stage.scene.is_large() { evaluated(stage, all) } else { screened(stage, all) };
    let mut ranked: Vec<(f64, &Score)> = left.into_iter().zip(all).filter_map(|(left, s)| Some((left?, s))).collect();
    // Stable: of equal ones that with the higher score stays first.
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().map(|(_, s)| s).collect()
}

/// What effects leave at the sizes from which they would be fitted.
fn evaluated(stage: &Stage, all: &[Score]) -> Vec<Option<f64>> {
    let work = stage.settings.listener.work("looking at effects of several sizes", all.len());
    let scene = stage.scene.at_one_point(&stage.fit.theta);
    let look = |s: &Score| {
        let left = if stage.settings.until.is_over() { None } else { least_left(&scene, stage, s).ok().flatten() };
        work.step();
        left
    };
    all.par_iter().map(look).collect()
}

/// What effects leave at the sizes at which they were screened, the small ones, which tell slopes, left out: |r' + Δr'|².
fn screened(stage: &Stage, all: &[Score]) -> Vec<Option<f64>> {
    let seen = &stage.directions;
    let along = seen.unit.tr_mul(&stage.residual);
    let whole = stage.residual.norm_squared();
    let mut least: BTreeMap<usize, f64> = BTreeMap::new();
    for (c, &(index, column)) in seen.owner.iter().enumerate() {
        let Screened { candidate, columns } = &stage.screened[index];
        if !is_small(candidate, &columns[column].values) {
            let left = whole + seen.length[c] * (2.0 * along[c] + seen.length[c]);
            let known = least.entry(index).or_insert(left);
            *known = known.min(left);
        }
    }
    all.iter().map(|s| least.get(&s.index).copied()).collect()
}

/// The least that an effect leaves of the projected residual at any of the sizes from which it is fitted.
///
/// * `scene` - at the point of the fit
fn least_left(scene: &Scene, stage: &Stage, score: &Score) -> Result<Option<f64>, DiagnosisError> {
    let screened = &stage.screened[score.index];
    let scene = with_effect(scene, &screened.candidate)?;
    let comparisons = scene.comparisons()?;
    let priors = vec![Prior::NONE; scene.solved().parameters().free().len()];
    let posed = Posed::new(&scene, &comparisons, priors, stage.weight);
    let fit = &stage.fit;
    let cut = fit.rows.measured + fit.rows.targets;
    let left = |sizes: Vec<f64>| {
        let r = posed.data_rows(&[&fit.theta, &sizes[..]].concat()).ok()?;
        let rows = DVector::from_fn(fit.r.len(), |i, _| if i < cut { r[i] } else { fit.r[i] });
        Some(project(&stage.q, &rows).norm_squared()).filter(|left| left.is_finite())
    };
    Ok(sizes(screened, score).into_iter().filter_map(left).min_by(f64::total_cmp))
}

/// Sizes at which an effect is looked at: of those from which it is fitted the one that slopes say and the large ones, for which they say nothing; of a body
/// on a spring its typical mass alone.
fn sizes(screened: &Screened, score: &Score) -> Vec<Vec<f64>> {
    let candidate = &screened.candidate;
    if !candidate.parameters.iter().all(|p| p.grid.is_empty()) {
        return steps(candidate).into_iter().map(|(values, _)| values).collect();
    }
    let is_large = |values: &Vec<f64>| {
        let mut sizes = values.iter().zip(&candidate.parameters);
        sizes.any(|(v, p)| (v - p.neutral).abs() > 0.9 * (p.typical - p.neutral).abs())
    };
    let all = start_sizes(candidate, screened, Some(score)).into_iter().enumerate();
    all.filter(|(k, values)| *k == 0 || is_large(values)).map(|(_, values)| values).collect()
}
