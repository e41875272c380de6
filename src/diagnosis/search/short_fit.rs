//! Short fits: which of many effects deserve a full one.

use super::starts::{effort, starts};
use crate::diagnosis::problem::changed::with_effect;
use crate::diagnosis::problem::race::{Entry, Keep, Pick, Round, race};
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::linalg::DVector;
use rayon::prelude::*;

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
    let entries: Vec<_> = effects.par_iter().map(entry).collect();
    let work = stage.settings.listener.work("looking at further effects", effects.len());
    let may_run = || {
        work.step();
        stage.may_fit()
    };
    let ranked = race(entries.into_iter().flatten().collect(), &[Keep::HalfAhead, Keep::All], stage.weight, may_run);
    ranked.into_iter().map(|entry| entry.of).collect()
}
