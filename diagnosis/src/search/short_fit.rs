//! Short fits: which of many effects deserve a full one.

use super::hypothesis::Refit;
use super::run::{Job, run};
use super::starts::{effort, starts};
use crate::problem::changed::with_effect;
use crate::problem::race::{Entry, Keep, Pick, Round, race};
use crate::screen::effects::Score;
use crate::screen::stage::Stage;
use rayon::prelude::*;
use retune::linalg::DVector;

/// Of a large mesh so many race at once: each has static shapes of its own, thirty megabytes of 10⁵ dofs.
const AT_ONCE: usize = 16;

/// Full fits of the best effects of a stage, chosen by a few steps where there are many.
///
/// * `base` - ln evidence of the base
pub(crate) fn the_best_of(stage: &Stage, bases: &[DVector<f64>], base: f64) -> Vec<Refit> {
    let near: Vec<&Score> = stage.effects.iter().take(stage.effort().near).collect();
    let near = if near.len() > stage.effort().around { shortest(stage, &near, bases) } else { near };
    let jobs: Vec<Job<'_>> = near.into_iter().take(stage.effort().around).map(|s| Job::Effect(s, bases)).collect();
    run(stage, &jobs, base)
}

/// Effects by what a few steps leave: two for each, the rest for the better half; those that cannot be fitted left out.
pub(crate) fn shortest<'a>(stage: &Stage, effects: &[&'a Score], bases: &[DVector<f64>]) -> Vec<&'a Score> {
    let tried = stage.effort();
    let entry = |&score: &&'a Score| {
        let candidate = &stage.screened[score.index].candidate;
        let scene = with_effect(&stage.scene, candidate).ok()?;
        let of_size = effort(candidate);
        let rounds = vec![
            Round { pick: Pick::Lowest(tried.short_starts * of_size), steps: tried.short_first_steps * of_size },
            Round { pick: Pick::Lowest(1), steps: tried.short_further_steps * of_size },
        ];
        Some(Entry::new(score, scene, &[starts(stage, score, bases).concat()], rounds))
    };
    stage.place(effects.iter().copied());
    let work = stage.settings.listener.work("looking at further effects", effects.len());
    let may_run = || {
        work.step();
        stage.may_fit()
    };
    let mut ranked: Vec<(f64, &Score)> = Vec::new();
    for some in effects.chunks(if stage.scene.is_huge() { AT_ONCE } else { usize::MAX }) {
        let entries: Vec<_> = some.par_iter().map(entry).collect();
        let entries = entries.into_iter().flatten().collect();
        let done = race(entries, &[Keep::HalfAhead, Keep::All], stage.weight, may_run);
        ranked.extend(done.into_iter().map(|entry| (entry.phi(), entry.of)));
    }
    // Stable: of equal ones the first stays first.
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked.into_iter().map(|(_, of)| of).collect()
}
