//! Full refits of the best hypotheses: base parameters and size together.

use super::hypothesis::{Refit, Tried};
use super::nested::leave_out_wider;
use super::run::{Job, NEAR, best_and_of_every_kind, merge, run};
use super::short_fit::shortest;
use super::spread::{self, Fitted, spreads};
use super::wider::{beyond_the_best, in_all_axes, may_be_wider, on_wider_places};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::problem::evidence::{REMAINDER, STRONG, goodness_of_fit, ln_evidence};
use crate::diagnosis::problem::scene::box_starts;
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::diagnosis::screen::traces::FaultScore;
use crate::linalg::DVector;
use std::collections::{BTreeMap, BTreeSet};

/// Effects that are refitted in full, at most, before one of each further kind with half the best score.
const BEST: usize = 12;
/// Effects that are fitted with a few steps where the best refits leave more than noise.
const SHORT_FITS: usize = 200;
/// Faults of every kind that are refitted then, and how many members a kind may have to be refitted whole.
const FAULTS_OF_A_KIND: usize = 4;
const FEW_OF_A_KIND: usize = 16;
/// Faults that are refitted.
const BEST_FAULTS: usize = 4;
/// Below this score a fault is not worth a refit: two standard deviations.
const FAINT: f64 = 4.0;
/// Rounds of looking around the best effect, and how many effects like it are tried with a few steps.
const ROUNDS: usize = 3;
/// Hypotheses whose base is a start of a spread.
const SPREAD_FROM: usize = 3;
/// Hypotheses that are polished: the best, and of as many kinds the best.
const POLISHED: usize = 3;
const POLISHED_KINDS: usize = 6;
/// What was refitted.
pub(crate) struct Refits {
    /// By descending evidence.
    pub(crate) hypotheses: Vec<Refit>,
    /// Changes of every element; none where the base looks right.
    pub(crate) spreads: Vec<Fitted>,
}

/// Which effects deserve a refit: the best, one of every other kind that comes near, and stores where a mode is unpaired.
pub(crate) fn chosen_effects(stage: &Stage, limit: usize) -> Vec<Score> {
    let kind = |s: &Score| stage.screened[s.index].candidate.effect.name();
    let mut out: Vec<Score> = stage.effects.iter().take(limit).copied().collect();
    let best = stage.effects.first().map_or(0.0, |s| s.t);
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    for s in &out {
        *seen.entry(kind(s)).or_default() += 1;
    }
    for s in stage.effects.iter().skip(limit) {
        let store = !stage.fit.unpaired.is_empty() && !stage.screened[s.index].candidate.parameters[0].grid.is_empty();
        let store = store
            || (!stage.fit.unpaired.is_empty()
                && stage.screened[s.index].candidate.parameters.iter().any(|p| !p.grid.is_empty()));
        let count = seen.entry(kind(s)).or_default();
        if (*count == 0 && s.t > 0.5 * best) || (store && *count < 4) {
            *count += 1;
            out.push(*s);
        }
    }
    // What the data can hardly tell from the best is refitted with it, so that ties are complete.
    let best: Vec<(usize, usize)> = out.iter().take(3).map(|s| (s.index, s.column)).collect();
    let mut more = 0;
    for index in stage.directions.alike(&best) {
        if more < limit && !out.iter().any(|s| s.index == index) {
            out.extend(stage.effects.iter().find(|s| s.index == index));
            more += 1;
        }
    }
    out
}

/// Refits the best effects and faults of a stage, in parallel, in a fixed order; what cannot be fitted is left out.
///
/// First-order scores mislead where an effect is large or the base has been pulled far. So:
/// * Where none of them leaves noise, every other effect is fitted with a few steps, and the best of those in full, with the
///   best of every kind; and the best few of every kind of fault.
/// * What is like the best, in kind or place, is fitted once more from where the best has brought the base, until nothing
///   better comes; what leaves nearly the trace of the best is fitted too, so that ties are complete.
pub(crate) fn refit(stage: &Stage, few: bool) -> Result<Refits, DiagnosisError> {
    let base = ln_evidence(&stage.fit)?;
    let limit = if few { BEST / 2 } else { BEST };
    let mut bases = vec![stage.fit.x.clone(), stage.scene.start()];
    let scores = chosen_effects(stage, limit);
    let faults = chosen_faults(stage);
    let jobs: Vec<Job<'_>> =
        scores.iter().map(|s| Job::Effect(s, &bases)).chain(faults.iter().map(|&f| Job::Fault(f, &bases))).collect();
    let mut done = run(stage, &jobs, base);
    done.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let is_poor = goodness_of_fit(&stage.fit, &stage.q) < REMAINDER;
    let is_strong = done.first().is_some_and(|r| r.ln_bayes > STRONG);
    if few || !(is_poor || is_strong) {
        leave_out_wider(stage, &mut done);
        return Ok(Refits { hypotheses: done, spreads: Vec::new() });
    }
    let n = stage.fit.x.len();
    let best = done.iter().take(SPREAD_FROM).map(|r| r.fit.x.rows(0, n).into_owned());
    let spreads = spreads(stage, &bases.iter().cloned().chain(best).collect::<Vec<_>>())?;
    if is_poor && !leaves_noise(&done)? {
        // A spread can follow most changes of a structure, and brings the base near its truth.
        bases.extend(spread::best(&spreads).map(|s| s.base.clone()));
        let all: Vec<&Score> = stage.effects.iter().take(SHORT_FITS).collect();
        let near = best_and_of_every_kind(stage, shortest(stage, &all, &bases), limit);
        let mut more: Vec<Job<'_>> = near.into_iter().map(|s| Job::Effect(s, &bases)).collect();
        let further = further_faults(stage, &faults);
        more.extend(further.iter().map(|f| Job::Fault(f, &bases)));
        merge(stage, &mut done, run(stage, &more, base));
    }
    if is_poor && !leaves_noise(&done)? && may_be_wider(stage, &spreads, &done) {
        let found = on_wider_places(stage, &bases, limit, base);
        merge(stage, &mut done, found);
    }
    around_the_best(stage, &mut done, base)?;
    let found = beyond_the_best(stage, &done, base);
    merge(stage, &mut done, found);
    let found = in_all_axes(stage, &done, base);
    merge(stage, &mut done, found);
    if !leaves_noise(&done)? {
        polish(stage, &mut done, base)?;
    }
    complete_ties(stage, &mut done, base);
    leave_out_wider(stage, &mut done);
    done.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    Ok(Refits { hypotheses: done, spreads })
}

/// Refits what leaves nearly the trace of the best hypotheses and was not chosen: a tie that is not shown is a wrong answer.
fn complete_ties(stage: &Stage, done: &mut Vec<Refit>, base: f64) {
    let Some(best) = done.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) else { return };
    let bases = [best.fit.x.rows(0, stage.fit.x.len()).into_owned(), stage.fit.x.clone()];
    let score_of = |r: &Refit| match &r.tried {
        Tried::Effect(c) => stage.effects.iter().find(|s| stage.id(s) == c.id()),
        Tried::Fault(_) => None,
    };
    let tied: Vec<(usize, usize)> = done
        .iter()
        .filter(|r| r.ln_bayes > best.ln_bayes - STRONG)
        .filter_map(score_of)
        .map(|s| (s.index, s.column))
        .collect();
    let known: BTreeSet<usize> = done.iter().filter_map(score_of).map(|s| s.index).collect();
    let alike = stage.directions.alike(&tied).into_iter().filter(|i| !known.contains(i));
    let jobs: Vec<Job<'_>> = alike
        .filter_map(|index| stage.effects.iter().find(|s| s.index == index))
        .take(NEAR)
        .map(|s| Job::Effect(s, &bases))
        .collect();
    done.extend(run(stage, &jobs, base));
}

/// Faults that deserve a refit: the best, and one of every other kind that comes near.
fn chosen_faults(stage: &Stage) -> Vec<&FaultScore> {
    let best = stage.fault_scores.first().map_or(0.0, |f| f.t);
    let mut out: Vec<&FaultScore> = Vec::new();
    for f in stage.fault_scores.iter().filter(|f| f.t > FAINT) {
        let kind = stage.faults[f.index].name();
        let new = !out.iter().any(|g| stage.faults[g.index].name() == kind);
        if out.len() < BEST_FAULTS || (new && f.t > 0.5 * best) {
            out.push(f);
        }
    }
    out
}

/// All other faults of the kinds that have few, also those without a first-order score; the best of every other kind.
fn further_faults(stage: &Stage, but: &[&FaultScore]) -> Vec<FaultScore> {
    let mut members: BTreeMap<&str, usize> = BTreeMap::new();
    for f in &stage.faults {
        *members.entry(f.name()).or_default() += 1;
    }
    let few = |index: usize| members[stage.faults[index].name()] <= FEW_OF_A_KIND;
    let mut taken: BTreeMap<&str, usize> = BTreeMap::new();
    let mut out = Vec::new();
    for f in stage.fault_scores.iter().filter(|f| !but.contains(f)) {
        let count = taken.entry(stage.faults[f.index].name()).or_default();
        *count += 1;
        if few(f.index) || *count <= FAULTS_OF_A_KIND {
            out.push(*f);
        }
    }
    let unscored = |i: &usize| few(*i) && !stage.fault_scores.iter().any(|f| f.index == *i);
    out.extend((0..stage.faults.len()).filter(unscored).map(FaultScore::unscored));
    out
}

/// Whether any hypothesis that is better than the base leaves no more than noise.
fn leaves_noise(done: &[Refit]) -> Result<bool, DiagnosisError> {
    for r in done.iter().filter(|r| r.ln_bayes > 0.0) {
        if r.leaves_noise()? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Fits what is like the best effect, in kind or place, from where the best has brought the base.
fn around_the_best(stage: &Stage, done: &mut Vec<Refit>, base: f64) -> Result<(), DiagnosisError> {
    for _ in 0..ROUNDS {
        let Some(best) = done.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) else { return Ok(()) };
        let (Tried::Effect(found), before) = (&best.tried, best.ln_bayes) else { return Ok(()) };
        if before < STRONG {
            return Ok(());
        }
        let bases = [best.fit.x.rows(0, stage.fit.x.len()).into_owned()];
        let like = |s: &&Score| {
            let c = &stage.screened[s.index].candidate;
            let is_found = c.id() == found.id();
            !is_found && (c.effect.name() == found.effect.name() || c.location.shares_name(&found.location))
        };
        let near: Vec<&Score> = stage.effects.iter().filter(like).take(NEAR).collect();
        let near = shortest(stage, &near, &bases);
        let jobs: Vec<Job<'_>> = near.into_iter().take(BEST).map(|s| Job::Effect(s, &bases)).collect();
        merge(stage, done, run(stage, &jobs, base));
        let after = done.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max);
        if after < before + STRONG {
            return Ok(());
        }
    }
    Ok(())
}

/// Fits the best few once more from where every other hypothesis has brought the base, and from points of the box: with the
/// wrong basin none would leave noise.
fn polish(stage: &Stage, done: &mut Vec<Refit>, base: f64) -> Result<(), DiagnosisError> {
    done.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let n = stage.fit.x.len();
    let mut bases: Vec<DVector<f64>> = done.iter().take(BEST).map(|r| r.fit.x.rows(0, n).into_owned()).collect();
    bases.extend(box_starts(&stage.scene, BEST, 0));
    let faults: Vec<FaultScore> = (0..stage.faults.len()).map(FaultScore::unscored).collect();
    let mut kinds: Vec<&str> = Vec::new();
    let mut is_polished = |(k, r): &(usize, &Refit)| {
        let is_new = !kinds.contains(&r.name()) && kinds.len() < POLISHED_KINDS;
        if is_new {
            kinds.push(r.name());
        }
        is_new || *k < POLISHED
    };
    let jobs: Vec<Job<'_>> = done
        .iter()
        .enumerate()
        .filter(|r| is_polished(r))
        .filter_map(|(_, r)| match &r.tried {
            Tried::Effect(c) => {
                let score = stage.effects.iter().find(|s| stage.id(s) == c.id())?;
                Some(Job::Effect(score, &bases))
            }
            Tried::Fault(f) => Some(Job::Fault(&faults[stage.faults.iter().position(|g| g == f)?], &bases)),
        })
        .collect();
    let found = run(stage, &jobs, base);
    merge(stage, done, found);
    Ok(())
}
