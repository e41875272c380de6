//! Refits of many hypotheses, in parallel and in a fixed order.

use super::fault_number::refit_fault;
use super::hypothesis::{Refit, Tried, estimates};
use super::profile::widen;
use super::starts::{effort, starts};
use crate::error::DiagnosisError;
use crate::problem::changed::with_effect;
use crate::problem::evidence::{held_out_in_all, ln_evidence, missed_more};
use crate::problem::fit::Fit;
use crate::problem::race::{fit, fit_by, in_full};
use crate::problem::scene::Scene;
use crate::screen::effects::Score;
use crate::screen::stage::Stage;
use crate::screen::traces::FaultScore;
use crate::settings::Settings;
use rayon::prelude::*;
use retune::effect::Candidate;
use retune::linalg::DVector;
use std::collections::BTreeMap;

/// What is refitted: an effect with the values of the base from which it starts, or a fault.
#[derive(Clone, Copy)]
pub(crate) enum Job<'a> {
    Effect(&'a Score, &'a [DVector<f64>]),
    /// The same with one more start, sizes included; with no values of the base from that start alone.
    Begun(&'a Score, &'a [DVector<f64>], &'a DVector<f64>),
    Fault(&'a FaultScore, &'a [DVector<f64>]),
}

impl<'a> Job<'a> {
    fn of(score: &'a Score, bases: &'a [DVector<f64>], begun: Option<&'a DVector<f64>>) -> Self {
        begun.map_or(Job::Effect(score, bases), |start| Job::Begun(score, bases, start))
    }
}

pub(crate) fn run(stage: &Stage, jobs: &[Job<'_>], base: f64) -> Vec<Refit> {
    let work = stage.settings.listener.work("refitting the best hypotheses", jobs.len());
    let effects = jobs.iter().filter_map(|job| match job {
        Job::Effect(score, _) | Job::Begun(score, ..) => Some(*score),
        Job::Fault(..) => None,
    });
    stage.place(effects);
    let done: Vec<Option<Refit>> = jobs
        .par_iter()
        .map(|job| {
            if !stage.may_fit() {
                return None;
            }
            let found = match job {
                Job::Effect(score, bases) => refit_effect(stage, score, &starts(stage, score, bases), base).ok(),
                Job::Begun(score, bases, start) => {
                    let further = if bases.is_empty() { Vec::new() } else { starts(stage, score, bases) };
                    let groups = [vec![vec![(*start).clone()]], further].concat();
                    refit_effect(stage, score, &groups, base).ok()
                }
                Job::Fault(score, bases) => refit_fault(stage, score, bases, base).ok(),
            };
            work.step();
            found
        })
        .collect();
    done.into_iter().flatten().collect()
}

fn refit_effect(
    stage: &Stage,
    score: &Score,
    starts: &[Vec<DVector<f64>>],
    base: f64,
) -> Result<Refit, DiagnosisError> {
    let candidate = &stage.screened[score.index].candidate;
    let scene = with_effect(&stage.scene, candidate)?;
    let rounds = in_full(starts.len(), effort(candidate), stage.effort());
    let fit = fit_by(&scene, starts, rounds, stage.weight)?;
    weighed(stage, candidate, (scene, fit), base)
}

/// An effect as it was fitted on a stage.
///
/// * `fitted` - the scene with it, and its optimum
/// * `base` - ln evidence of the base
fn weighed(
    stage: &Stage,
    candidate: &Candidate,
    (scene, fit): (Scene, Fit),
    base: f64,
) -> Result<Refit, DiagnosisError> {
    let evidence = ln_evidence(&fit)? + scene.ln_size_priors(&candidate.parameters) + candidate.of_place;
    let mut estimates = estimates(&scene, &fit, &candidate.parameters)?;
    widen(&scene, &fit, &candidate.parameters, stage.weight, &mut estimates)?;
    let held_out = held_out_in_all(&fit, stage.weight)?;
    let misfit = fit.misfit;
    let (missed, ln_missed) = missed_more(&stage.fit, &fit);
    Ok(Refit {
        tried: Tried::Effect(candidate.clone()),
        scene,
        fit,
        ln_bayes: evidence - base + ln_missed,
        estimates,
        held_out,
        misfit,
        missed,
        ln_odds: 0.0,
        limit_of: Vec::new(),
    })
}

/// The same hypothesis on stand-ins that are made for its sizes.
pub(crate) fn on_its_own_stand_ins(stage: &Stage, r: &Refit, base: f64) -> Result<Refit, DiagnosisError> {
    let Tried::Effect(candidate) = &r.tried else { return Ok(r.clone()) };
    let scene = r.scene.clone().in_full(Some(&r.fit.x))?;
    let fit = fit(&scene, std::slice::from_ref(&r.fit.x), stage.weight)?;
    weighed(stage, candidate, (scene, fit), base)
}

/// Refits hypotheses on another stage; those that cannot be fitted there are left out.
pub(crate) fn refit_these(
    stage: &Stage,
    these: &[&Tried],
    bases: &[DVector<f64>],
) -> Result<Vec<Refit>, DiagnosisError> {
    refit_begun(stage, &these.iter().map(|tried| (*tried, None)).collect::<Vec<_>>(), bases)
}

/// The same with one more start for some of them, sizes included: where an effect was found without what the stage has in its base, say. Without values
/// of the base they start there alone.
pub(crate) fn refit_begun(
    stage: &Stage,
    these: &[(&Tried, Option<DVector<f64>>)],
    bases: &[DVector<f64>],
) -> Result<Vec<Refit>, DiagnosisError> {
    let base = ln_evidence(&stage.fit)?;
    let score_of = |stage: &Stage, c: &Candidate| stage.effects.iter().find(|s| stage.id(s) == c.id()).copied();
    let (mut scores, mut faults, mut elsewhere) = (Vec::new(), Vec::new(), Vec::new());
    for (tried, begun) in these {
        match tried {
            // What acts at a wider place is screened only where it is sought.
            Tried::Effect(c) => match score_of(stage, c) {
                Some(score) => scores.push((score, begun)),
                None => elsewhere.push((c, begun)),
            },
            Tried::Fault(f) => {
                let Some(i) = stage.faults.iter().position(|g| g == f) else { continue };
                let known = stage.fault_scores.iter().find(|f| f.index == i).copied();
                let own: Vec<DVector<f64>> = begun.iter().chain(bases).cloned().collect();
                faults.push((known.unwrap_or(FaultScore::unscored(i)), own));
            }
        }
    }
    let effects = scores.iter().map(|(s, begun)| Job::of(s, bases, begun.as_ref()));
    let jobs: Vec<Job<'_>> = effects.chain(faults.iter().map(|(f, own)| Job::Fault(f, own))).collect();
    let mut done = run(stage, &jobs, base);
    if !elsewhere.is_empty() {
        let stage = stage.on_wider(elsewhere.iter().map(|(c, _)| (*c).clone()).collect())?;
        let begun =
            |s: &Score| elsewhere.iter().find(|(c, _)| c.id() == stage.id(s)).and_then(|(_, begun)| begun.as_ref());
        let jobs: Vec<Job<'_>> = stage.effects.iter().map(|s| Job::of(s, bases, begun(s))).collect();
        done.extend(run(&stage, &jobs, base));
    }
    Ok(done)
}

/// The first few of a ranking, and the first two of every other kind: a kind with many places, and two sizes at each, would take all; and of
/// a place and its mirror image on a nearly symmetric structure a few steps do not tell which is right.
pub(crate) fn best_and_of_every_kind<'a>(stage: &Stage, ranked: Vec<&'a Score>, few: usize) -> Vec<&'a Score> {
    let mut seen: BTreeMap<&str, usize> = BTreeMap::new();
    let mut is_wanted = |&(k, s): &(usize, &Score)| {
        let count = seen.entry(stage.screened[s.index].candidate.effect.name()).or_default();
        *count += 1;
        k < few || *count <= stage.effort().of_every_kind
    };
    ranked.into_iter().enumerate().filter(|r| is_wanted(r)).map(|(_, s)| s).collect()
}

/// A stage with a hypothesis in its scene, fitted and screened.
pub(crate) fn stage_with(base: &Stage, r: &Refit, settings: &Settings) -> Result<Stage, DiagnosisError> {
    base.with_on_top(r.scene.clone(), &r.fit.x, base.weight, settings)
}
