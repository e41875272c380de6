//! Which effects and faults of a screening deserve a fit.

use crate::screen::effects::Score;
use crate::screen::stage::{Stage, highest};
use crate::screen::traces::FaultScore;
use crate::thresholds::FAINT;
use std::collections::BTreeMap;

/// Which effects deserve a refit: the best, one of every other kind that comes near, and stores where a mode is unpaired.
pub(super) fn chosen_effects(stage: &Stage, limit: usize) -> Vec<Score> {
    let kind = |s: &Score| stage.screened[s.index].candidate.effect.name();
    let mut out: Vec<Score> = stage.effects.iter().take(limit).copied().collect();
    let best = highest(&stage.effects);
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

/// Faults that deserve a refit: the best, and one of every other kind that comes near.
pub(super) fn chosen_faults(stage: &Stage) -> Vec<&FaultScore> {
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
pub(super) fn further_faults(stage: &Stage, but: &[&FaultScore]) -> Vec<FaultScore> {
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
