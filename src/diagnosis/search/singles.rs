//! The search for one cause: full fits of the best hypotheses, base parameters and size together.

use super::board::{Board, Refits};
use super::hypothesis::{Refit, Tried};
use super::nested::leave_out_wider;
use super::run::{Job, best_and_of_every_kind, run};
use super::short_fit::shortest;
use super::spread::{self, spreads};
use super::wider::{beyond_the_best, in_all_axes, may_be_wider, on_wider_places};
use crate::diagnosis::error::DiagnosisError;
use crate::diagnosis::problem::scene::box_starts;
use crate::diagnosis::screen::effects::Score;
use crate::diagnosis::screen::stage::Stage;
use crate::diagnosis::screen::traces::FaultScore;
use crate::diagnosis::thresholds::{FAINT, STRONG};
use crate::linalg::DVector;
use std::collections::{BTreeMap, BTreeSet};

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
        let has_grid = stage.screened[s.index].candidate.parameters.iter().any(|p| !p.grid.is_empty());
        let store = has_grid && !stage.fit.unpaired.is_empty();
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

/// A step of the search for one cause.
pub(crate) struct Step {
    /// What it does, as a trace tells it.
    name: &'static str,
    /// Whether it is worth taking with what has been found.
    when: fn(&Board<'_>) -> Result<bool, DiagnosisError>,
    /// Finds more.
    take: fn(&mut Board<'_>) -> Result<(), DiagnosisError>,
}

/// The search for one cause, step by step.
///
/// First-order scores mislead where an effect is large or the base has been pulled far. So where none of the best leaves noise, every other effect is
/// fitted with a few steps, and the best of those in full, with the best of every kind. What is like the best, in kind or place, is fitted once
/// more from where the best has brought the base; what leaves nearly its trace is fitted too, so that ties are complete.
pub(crate) const SEARCH: &[Step] = &[
    Step { name: "the best of the screening", when: always, take: screened },
    Step { name: "every part a little", when: is_worth_more, take: every_part },
    Step { name: "every other effect and fault", when: is_poor_and_unexplained, take: every_other },
    Step { name: "extended places", when: extended_may_explain, take: extended },
    Step { name: "like the best", when: is_worth_more, take: like_the_best },
    Step { name: "beyond the place of the best", when: is_worth_more, take: beyond_the_place },
    Step { name: "about all axes", when: is_worth_more, take: about_all_axes },
    Step { name: "the best from other basins", when: is_unexplained, take: from_other_basins },
    Step { name: "what is tied with the best", when: is_worth_more, take: complete_ties },
];

/// Searches a stage; what cannot be fitted is left out.
///
/// * `few` - the best of the screening alone, and fewer of them
pub(crate) fn refit(stage: &Stage, few: bool) -> Result<Refits, DiagnosisError> {
    let mut board = Board::new(stage, if few { stage.effort().best / 2 } else { stage.effort().best }, few)?;
    for step in SEARCH {
        if !stage.settings.until.is_over() && (step.when)(&board)? {
            let before = board.work();
            (step.take)(&mut board)?;
            stage.settings.listener.took(&board.told(step.name, before));
        }
    }
    let mut done = board.found;
    leave_out_wider(stage, &mut done.hypotheses);
    done.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    Ok(done)
}

#[expect(clippy::unnecessary_wraps, reason = "as the other conditions")]
fn always(_: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(true)
}

/// The base leaves more than noise, or something is strong.
#[expect(clippy::unnecessary_wraps, reason = "as the other conditions")]
fn is_worth_more(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(!board.few && (board.is_poor() || board.best().is_some_and(|r| r.ln_bayes > STRONG)))
}

fn is_unexplained(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(is_worth_more(board)? && !board.leaves_noise()?)
}

fn is_poor_and_unexplained(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(board.is_poor() && is_unexplained(board)?)
}

fn extended_may_explain(board: &Board<'_>) -> Result<bool, DiagnosisError> {
    Ok(is_poor_and_unexplained(board)? && may_be_wider(board.stage, &board.found.spreads, &board.found.hypotheses))
}

/// Fits the effects and faults that the screening puts first.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn screened(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let (scores, faults) = (chosen_effects(stage, board.most), chosen_faults(stage));
    let effects = scores.iter().map(|s| Job::Effect(s, &board.bases));
    let jobs: Vec<Job<'_>> = effects.chain(faults.iter().map(|&f| Job::Fault(f, &board.bases))).collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    board.found.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    Ok(())
}

/// Fits a change of every part. It can follow most changes of a structure, and brings the base near its truth.
fn every_part(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let best: Vec<DVector<f64>> =
        board.found.hypotheses.iter().take(board.stage.effort().spread_from).map(|r| board.base_of(r)).collect();
    board.found.spreads = spreads(board.stage, &[board.bases.clone(), best].concat())?;
    Ok(())
}

/// Fits every other effect with a few steps, the best of these and of every kind in full; and the faults that were left.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn every_other(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    board.bases.extend(spread::best(&board.found.spreads).map(|s| s.base.clone()));
    let all: Vec<&Score> = stage.effects.iter().take(stage.effort().short_fits).collect();
    let near = best_and_of_every_kind(stage, shortest(stage, &all, &board.bases), board.most);
    let further = further_faults(stage, &chosen_faults(stage));
    let effects = near.into_iter().map(|s| Job::Effect(s, &board.bases));
    let jobs: Vec<Job<'_>> = effects.chain(further.iter().map(|f| Job::Fault(f, &board.bases))).collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}

/// Fits effects at extended places.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn extended(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let found = on_wider_places(board.stage, &board.bases, board.most, board.ln_base);
    board.add(found);
    Ok(())
}

/// Fits the leading effect on neighbouring spans.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn beyond_the_place(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let found = beyond_the_best(board.stage, &board.found.hypotheses, board.ln_base);
    board.add(found);
    Ok(())
}

/// Fits what acts about one axis and explains much about all of its place.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn about_all_axes(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let found = in_all_axes(board.stage, &board.found.hypotheses, board.ln_base);
    board.add(found);
    Ok(())
}

/// Fits what leaves nearly the trace of the best hypotheses and was not chosen: a tie that is not shown is a wrong answer.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn complete_ties(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    let Some(best) = board.best() else { return Ok(()) };
    let bases = [board.base_of(best), stage.fit.x.clone()];
    let score_of = |r: &Refit| match &r.tried {
        Tried::Effect(c) => stage.effects.iter().find(|s| stage.id(s) == c.id()),
        Tried::Fault(_) => None,
    };
    let hypotheses = &board.found.hypotheses;
    let tied: Vec<(usize, usize)> = hypotheses
        .iter()
        .filter(|r| r.ln_bayes > best.ln_bayes - STRONG)
        .filter_map(score_of)
        .map(|s| (s.index, s.column))
        .collect();
    let known: BTreeSet<usize> = hypotheses.iter().filter_map(score_of).map(|s| s.index).collect();
    let alike = stage.directions.alike(&tied).into_iter().filter(|i| !known.contains(i));
    let jobs: Vec<Job<'_>> = alike
        .filter_map(|index| stage.effects.iter().find(|s| s.index == index))
        .take(stage.effort().near)
        .map(|s| Job::Effect(s, &bases))
        .collect();
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}

/// Faults that deserve a refit: the best, and one of every other kind that comes near.
fn chosen_faults(stage: &Stage) -> Vec<&FaultScore> {
    let best = stage.fault_scores.first().map_or(0.0, |f| f.t);
    let mut out: Vec<&FaultScore> = Vec::new();
    for f in stage.fault_scores.iter().filter(|f| f.t > FAINT) {
        let kind = stage.faults[f.index].name();
        let new = !out.iter().any(|g| stage.faults[g.index].name() == kind);
        if out.len() < stage.effort().best_faults || (new && f.t > 0.5 * best) {
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
    let few = |index: usize| members[stage.faults[index].name()] <= stage.effort().few_of_a_kind;
    let mut taken: BTreeMap<&str, usize> = BTreeMap::new();
    let mut out = Vec::new();
    for f in stage.fault_scores.iter().filter(|f| !but.contains(f)) {
        let count = taken.entry(stage.faults[f.index].name()).or_default();
        *count += 1;
        if few(f.index) || *count <= stage.effort().faults_of_a_kind {
            out.push(*f);
        }
    }
    let unscored = |i: &usize| few(*i) && !stage.fault_scores.iter().any(|f| f.index == *i);
    out.extend((0..stage.faults.len()).filter(unscored).map(FaultScore::unscored));
    out
}

/// Fits what is like the best effect, in kind or place, from where the best has brought the base, until nothing better comes.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn like_the_best(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    for _ in 0..stage.effort().rounds {
        let Some(best) = board.best() else { return Ok(()) };
        let (Tried::Effect(found), before) = (&best.tried, best.ln_bayes) else { return Ok(()) };
        if before < STRONG {
            return Ok(());
        }
        let bases = [board.base_of(best)];
        let like = |s: &&Score| {
            let c = &stage.screened[s.index].candidate;
            let is_found = c.id() == found.id();
            !is_found && (c.effect.name() == found.effect.name() || c.location.shares_name(&found.location))
        };
        let near: Vec<&Score> = stage.effects.iter().filter(like).take(stage.effort().near).collect();
        let near = shortest(stage, &near, &bases);
        let jobs: Vec<Job<'_>> = near.into_iter().take(stage.effort().best).map(|s| Job::Effect(s, &bases)).collect();
        let found = run(stage, &jobs, board.ln_base);
        board.add(found);
        if board.best().is_none_or(|best| best.ln_bayes < before + STRONG) {
            return Ok(());
        }
    }
    Ok(())
}

/// Fits the best few once more from where every other hypothesis has brought the base, and from points of the box: in the wrong basin none would
/// leave noise.
#[expect(clippy::unnecessary_wraps, reason = "as the other steps")]
fn from_other_basins(board: &mut Board<'_>) -> Result<(), DiagnosisError> {
    let stage = board.stage;
    board.found.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    let hypotheses = &board.found.hypotheses;
    let mut bases: Vec<DVector<f64>> = hypotheses.iter().take(stage.effort().best).map(|r| board.base_of(r)).collect();
    bases.extend(box_starts(&stage.scene, stage.effort().best, 0));
    let faults: Vec<FaultScore> = (0..stage.faults.len()).map(FaultScore::unscored).collect();
    let mut kinds: Vec<&str> = Vec::new();
    let mut is_polished = |(k, r): &(usize, &Refit)| {
        let is_new = !kinds.contains(&r.name()) && kinds.len() < stage.effort().polished_kinds;
        if is_new {
            kinds.push(r.name());
        }
        is_new || *k < stage.effort().polished
    };
    let jobs: Vec<Job<'_>> = hypotheses
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
    let found = run(stage, &jobs, board.ln_base);
    board.add(found);
    Ok(())
}
