//! What has been found at a stage.

use super::hypothesis::{Refit, leaving_noise};
use super::look::by_size;
use super::spread::Fitted;
use crate::error::DiagnosisError;
use crate::listener::StepTaken;
use crate::problem::evidence::{goodness_of_fit, ln_evidence};
use crate::problem::work::WorkDone;
use crate::screen::effects::Score;
use crate::screen::stage::Stage;
use crate::thresholds::REMAINDER;
use retune::linalg::DVector;
use retune::once::Once;
use std::sync::atomic::Ordering;

/// What was refitted.
pub(crate) struct Refits {
    /// By descending evidence.
    pub(crate) hypotheses: Vec<Refit>,
    /// Changes of every element; none where the base looks right.
    pub(crate) spreads: Vec<Fitted>,
}

/// The search of a stage as far as it has come.
pub(crate) struct Board<'a> {
    pub(crate) stage: &'a Stage,
    /// ln evidence of the base.
    pub(crate) ln_base: f64,
    /// Effects that a step fits in full, at most, beside one of each further kind.
    pub(crate) most: usize,
    /// Whether the screening decides alone.
    pub(crate) few: bool,
    /// Values of the base from which fits start.
    pub(crate) bases: Vec<DVector<f64>>,
    pub(crate) found: Refits,
    /// Effects by what they leave at the best of their sizes.
    by_size: Once<Vec<&'a Score>>,
}

impl<'a> Board<'a> {
    /// Nothing found yet.
    pub(crate) fn new(stage: &'a Stage, most: usize, few: bool) -> Result<Self, DiagnosisError> {
        let found = Refits { hypotheses: Vec::new(), spreads: Vec::new() };
        let bases = vec![stage.fit.x.clone(), stage.scene.start()];
        Ok(Self { stage, ln_base: ln_evidence(&stage.fit)?, most, few, bases, found, by_size: Once::new() })
    }

    /// Takes over what is new or better.
    pub(crate) fn add(&mut self, found: Vec<Refit>) {
        merge(self.stage, &mut self.found.hypotheses, found);
    }

    /// Effects by what they leave at the best of their sizes, looked at when this is first asked.
    pub(crate) fn by_size(&self) -> &[&'a Score] {
        self.by_size.get_or_find(|| by_size(self.stage))
    }

    /// The hypothesis with the largest evidence.
    pub(crate) fn best(&self) -> Option<&Refit> {
        self.found.hypotheses.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes))
    }

    /// Where a hypothesis has brought the parameters of the base.
    pub(crate) fn base_of(&self, r: &Refit) -> DVector<f64> {
        r.fit.x.rows(0, self.stage.fit.x.len()).into_owned()
    }

    /// Whether the base leaves more than noise.
    pub(crate) fn is_poor(&self) -> bool {
        goodness_of_fit(&self.stage.fit, &self.stage.q) < REMAINDER
    }

    /// Whether any hypothesis that is better than the base leaves no more than noise.
    pub(crate) fn leaves_noise(&self) -> Result<bool, DiagnosisError> {
        Ok(leaving_noise(self.found.hypotheses.iter().filter(|r| r.ln_bayes > 0.0))?.is_some())
    }

    /// How many hypotheses were fitted so far, and what that took.
    pub(crate) fn work(&self) -> (usize, WorkDone) {
        (self.stage.fitted.load(Ordering::Relaxed), self.stage.scene.work.so_far())
    }

    /// What a step did, for a trace.
    ///
    /// * `before` - the work before it
    pub(crate) fn told(&self, step: &'static str, before: (usize, WorkDone)) -> StepTaken {
        let (fitted, work) = self.work();
        let base: Vec<String> = self.stage.scene.added.iter().map(|p| p.name.clone()).collect();
        StepTaken {
            step,
            beside: base,
            fitted: fitted - before.0,
            work: work.since(before.1),
            known: self.found.hypotheses.len(),
            best: self.best().map(|r| (r.id(&self.stage.scene), r.ln_bayes, r.misfit)),
        }
    }
}

/// Takes over what is new or better. What leaves the model without a mode that it has for a measured one explains nothing: it has lost data.
pub(crate) fn merge(stage: &Stage, done: &mut Vec<Refit>, found: Vec<Refit>) {
    let keeps_modes = |r: &Refit| r.fit.unpaired.iter().all(|mode| stage.fit.unpaired.contains(mode));
    for r in found.into_iter().filter(keeps_modes) {
        match done.iter_mut().find(|d| d.id(&stage.scene) == r.id(&stage.scene)) {
            Some(d) if r.ln_bayes > d.ln_bayes => *d = r,
            Some(_) => {}
            None => done.push(r),
        }
    }
}
