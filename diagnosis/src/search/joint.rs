//! Two effects at once. The best alone need not be one of two that are missing together: what imitates both may explain more than either.
//!
//! With u, v two unit columns of the [screening](crate::screen::effects), everything that a refit absorbs projected out, g their cosine and
//! a = u·r', b = v·r':
//!
//! ```text
//! T(u, v) = (a² - 2 g a b + b²)/(1 - g²)     the drop of |r|² that both and a refit of the base would bring, to first order
//! ```
//!
//! All pairs are ranked by it, at the base and where a [spread](super::spread) has brought its parameters, because two large effects pull
//! the base far; the best are fitted, first with a few steps.

use super::hypothesis::{Refit, Tried};
use super::prior::Odds;
use super::run::{refit_these, stage_with};
use super::singles::refit;
use crate::error::DiagnosisError;
use crate::problem::changed::with_effect;
use crate::problem::evidence::{ln_evidence, missed_more};
use crate::problem::fit::Fit;
use crate::problem::race::{Entry, Keep, Pick, Round, STEPS, race};
use crate::problem::scene::Scene;
use crate::screen::effects::Score;
use crate::screen::stage::Stage;
use crate::settings::Settings;
use crate::thresholds::VISIBLE;
use rayon::prelude::*;
use retune::effect::NewParameter;
use retune::linalg::DVector;
use std::collections::BTreeMap;

/// Sizes of a start, as multiples of the typical ones.
const SIZES: [f64; 2] = [0.4, 1.0];

/// Two effects by their scores, fitted together.
struct Joint {
    scores: [Score; 2],
    scene: Scene,
    fit: Fit,
}

/// The better of two on the base, with it in the base, and what was refitted on top of it, the other among them.
pub(crate) type WithFirst = (Refit, Stage, Vec<Refit>);

/// The two effects that explain the test best together, where they are more probable than another pair.
///
/// * `bases` - values of the base where they are sought, beside its own
/// * `ln_known` - ln of odds times Bayes factor of the other pair
pub(crate) fn together(
    base: &Stage,
    bases: &[DVector<f64>],
    odds: &Odds<'_>,
    ln_known: f64,
    settings: &Settings,
) -> Result<Option<WithFirst>, DiagnosisError> {
    if base.settings.until.is_over() {
        return Ok(None);
    }
    let ln_base = ln_evidence(&base.fit)?;
    let candidate = |s: &Score| &base.screened[s.index].candidate;
    let ln = |j: &Joint| {
        let each =
            |s: &Score| odds.of_kind(candidate(s).effect.name()) + j.scene.ln_size_priors(&candidate(s).parameters);
        Some(
            ln_evidence(&j.fit).ok()? - ln_base
                + missed_more(&base.fit, &j.fit).1
                + j.scores.iter().map(each).sum::<f64>(),
        )
    };
    let fitted = fitted(base, bases);
    let ranked = fitted.iter().filter_map(|j| Some((ln(j)?, j)));
    let best = ranked.reduce(|best, next| if next.0 > best.0 { next } else { best });
    let Some((_, joint)) = best.filter(|(ln, _)| *ln > ln_known) else { return Ok(None) };
    let [a, b] = joint.scores.map(|s| Tried::Effect(candidate(&s).clone()));
    let n = base.fit.x.len();
    let starts = [joint.fit.x.rows(0, n).into_owned(), base.fit.x.clone()];
    let Some(first) = refit_these(base, &[&a], &starts)?.pop() else { return Ok(None) };
    let on_first = stage_with(base, &first, settings)?;
    let mut seconds = refit(&on_first, true)?.hypotheses;
    let starts = [joint.fit.x.rows(0, on_first.fit.x.len()).into_owned(), on_first.fit.x.clone()];
    let second = refit_these(&on_first, &[&b], &starts)?;
    seconds.retain(|r| second.iter().all(|s| s.id(&base.scene) != r.id(&base.scene)));
    seconds.extend(second);
    Ok(Some((first, on_first, seconds)))
}

/// The best pairs, fitted in full, by what they leave.
fn fitted(stage: &Stage, bases: &[DVector<f64>]) -> Vec<Joint> {
    let elsewhere: Vec<Stage> = bases.iter().filter_map(|x| stage.seen_from(x).ok()).collect();
    let mut pairs: Vec<(&Stage, [Score; 2])> = Vec::new();
    for seen in std::iter::once(stage).chain(&elsewhere) {
        let is_new = |pair: &[Score; 2]| !pairs.iter().any(|(_, known)| members(known) == members(pair));
        let new: Vec<[Score; 2]> = ranked(seen).into_iter().filter(is_new).collect();
        pairs.extend(new.into_iter().map(|pair| (seen, pair)));
    }
    let work = stage.settings.listener.work("looking at two effects together", pairs.len());
    let tried = stage.effort();
    let entry = |(seen, scores): &(&Stage, [Score; 2])| {
        let add = |scene: Scene, s: &Score| with_effect(&scene, &stage.screened[s.index].candidate);
        let scene = scores.iter().try_fold(stage.scene.clone(), add).ok()?;
        let rounds = vec![
            Round { pick: Pick::Lowest(tried.pair_starts), steps: tried.pair_first_steps },
            Round { pick: Pick::Lowest(1), steps: tried.pair_further_steps },
            Round { pick: Pick::Lowest(1), steps: STEPS },
        ];
        Some(Entry::new(*scores, scene, &[starts(seen, scores)], rounds))
    };
    let entries: Vec<_> = pairs.par_iter().map(entry).collect();
    let may_run = || {
        work.step();
        stage.may_fit()
    };
    let keep = [Keep::Half, Keep::Best(tried.pair_full_fits), Keep::All];
    let ranked = race(entries.into_iter().flatten().collect(), &keep, stage.weight, may_run);
    let joint = |e: Entry<[Score; 2]>| Some(Joint { fit: e.fit(stage.weight).ok()?, scores: e.of, scene: e.scene });
    ranked.into_iter().filter_map(joint).collect()
}

/// Whatever their order.
fn members(pair: &[Score; 2]) -> [usize; 2] {
    let [a, b] = pair.map(|s| s.index);
    [a.min(b), a.max(b)]
}

/// Pairs of effects by T, each effect in a few of them, the better one of the two first.
fn ranked(stage: &Stage) -> Vec<[Score; 2]> {
    let d = &stage.directions;
    let along = d.unit.tr_mul(&stage.residual);
    let mut columns: Vec<usize> = (0..d.owner.len()).collect();
    columns.sort_by(|&i, &j| along[j].abs().total_cmp(&along[i].abs()).then(i.cmp(&j)));
    columns.truncate(stage.effort().pair_columns);
    columns.sort_unstable();
    let unit = d.unit.select_columns(&columns);
    let gram = unit.tr_mul(&unit);
    let score = |c: usize, t: f64, multiple: f64| {
        let (index, column) = d.owner[c];
        Score { index, t, column, factor: -multiple / d.length[c] }
    };
    let mut best: BTreeMap<(usize, usize), (f64, [Score; 2])> = BTreeMap::new();
    for (i, &u) in columns.iter().enumerate() {
        for (j, &v) in columns.iter().enumerate().skip(i + 1) {
            let (a, b, g) = (along[u], along[v], gram[(i, j)]);
            let left = 1.0 - g * g;
            if d.owner[u].0 == d.owner[v].0 || left < VISIBLE * VISIBLE {
                continue;
            }
            let (one, other) = ((a - g * b) / left, (b - g * a) / left);
            // The sign of a multiple is that of -a, as for one effect.
            if d.one_sided[u] && one > 0.0 || d.one_sided[v] && other > 0.0 {
                continue;
            }
            let t = a * one + b * other;
            let pair = [score(u, a * a, one), score(v, b * b, other)];
            let known = best.entry((d.owner[u].0, d.owner[v].0)).or_insert((t, pair));
            if t > known.0 {
                *known = (t, pair);
            }
        }
    }
    let mut all: Vec<(f64, [Score; 2])> = best.into_values().collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken: BTreeMap<usize, usize> = BTreeMap::new();
    let mut out = Vec::new();
    for (_, mut pair) in all {
        if out.len() == stage.effort().pair_short_fits
            || pair.iter().any(|s| taken.get(&s.index).is_some_and(|n| *n >= stage.effort().pairs_of_one))
        {
            continue;
        }
        for s in &pair {
            *taken.entry(s.index).or_default() += 1;
        }
        pair.sort_by(|a, b| b.t.total_cmp(&a.t));
        out.push(pair);
    }
    out
}

/// Where a fit of two may start: as the screening says, and with typical sizes of its signs.
fn starts(stage: &Stage, scores: &[Score; 2]) -> Vec<DVector<f64>> {
    let own = [stage.fit.x.clone(), stage.scene.start()];
    let sizes = |multiple: Option<f64>| -> Vec<f64> {
        let of_one = |s: &Score| {
            let screened = &stage.screened[s.index];
            let at = &screened.columns[s.column].values;
            let p = &screened.candidate.parameters;
            let scaled = move |(v, p): (&f64, &NewParameter)| {
                let value = match multiple {
                    Some(multiple) => {
                        p.neutral
                            + multiple * s.factor.signum() * (p.typical - p.neutral).abs() * (v - p.neutral).signum()
                    }
                    None if p.grid.is_empty() => p.neutral + s.factor * (v - p.neutral),
                    None => *v,
                };
                p.in_box(value.clamp(p.bounds[0], p.bounds[1]))
            };
            at.iter().zip(p).map(scaled).collect::<Vec<f64>>()
        };
        scores.iter().flat_map(of_one).collect()
    };
    let all: Vec<Vec<f64>> = std::iter::once(None).chain(SIZES.map(Some)).map(sizes).collect();
    let join = |x: &DVector<f64>, sizes: &Vec<f64>| {
        DVector::from_iterator(x.len() + sizes.len(), x.iter().chain(sizes).copied())
    };
    own.iter().flat_map(|x| all.iter().map(move |s| join(x, s))).collect()
}
