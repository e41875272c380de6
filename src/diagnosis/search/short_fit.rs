//! Short fits: which of many effects deserve a full one.

use super::starts::{effort, starts};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::problem::changed::with_effect;
use crate::diagnosis::problem::fit::fit_from;
use crate::diagnosis::problem::scene::Scene;
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::linalg::DVector;
use rayon::prelude::*;

/// Effects by what a few steps leave: two for each, the rest for the better half; those that cannot be fitted left out.
pub(crate) fn shortest<'a>(stage: &Stage, effects: &[&'a Score], bases: &[DVector<f64>]) -> Vec<&'a Score> {
    let work = stage.settings.listener.work("looking at further effects", effects.len());
    let begin = |&score: &&'a Score| {
        let begun = if stage.may_fit() { ShortFit::begin(stage, score, bases).ok() } else { None };
        work.step();
        begun
    };
    let begun: Vec<Option<ShortFit<'a>>> = effects.par_iter().map(begin).collect();
    let mut ranked: Vec<ShortFit<'a>> = begun.into_iter().flatten().filter(|s| s.phi.is_finite()).collect();
    // Stable: equal ones stay in the order of the screening.
    ranked.sort_by(|a, b| a.phi.total_cmp(&b.phi));
    let half = ranked.len().div_ceil(2);
    ranked[..half].par_iter_mut().for_each(|s| s.go_on(stage));
    ranked[..half].sort_by(|a, b| a.phi.total_cmp(&b.phi));
    ranked.into_iter().map(|s| s.score).collect()
}

/// A fit of an effect that may stop early.
struct ShortFit<'a> {
    score: &'a Score,
    scene: Scene,
    x: DVector<f64>,
    phi: f64,
}

impl<'a> ShortFit<'a> {
    /// The first steps, from the best starts.
    fn begin(stage: &Stage, score: &'a Score, bases: &[DVector<f64>]) -> Result<Self, DiagnosisError> {
        let candidate = &stage.screened[score.index].candidate;
        let scene = with_effect(&stage.scene, candidate)?;
        let (per_size, tried) = (effort(candidate), stage.effort());
        let starts = starts(stage, score, bases).concat();
        let fit =
            fit_from(&scene, &starts, stage.weight, tried.short_starts * per_size, tried.short_first_steps * per_size)?;
        Ok(Self { score, scene, x: fit.x, phi: fit.phi })
    }

    /// The other steps.
    fn go_on(&mut self, stage: &Stage) {
        let steps = stage.effort().short_further_steps * effort(&stage.screened[self.score.index].candidate);
        if let Ok(fit) = fit_from(&self.scene, std::slice::from_ref(&self.x), stage.weight, 1, steps) {
            (self.x, self.phi) = (fit.x, fit.phi);
        }
    }
}
