//! Screening: what every placed effect would do to the residual, with everything that a refit absorbs projected out.
//!
//! ```text
//! Δr = r(base, size) - r(base, neutral),   Δr' = (I - QQᵀ) Δr,   r' = (I - QQᵀ) r
//! T = (Δr'·r')²/(Δr'·Δr')       the drop of |r|² that the effect and a refit of the base would bring, to first order
//! ```
//!
//! Q spans the columns of the Jacobian of the base (with its priors) and of the scales of the shapes. A small step shows
//! the slope; the typical size shows effects that are even or large. Where the size has one sign, or the step is large,
//! only Δr'·r' < 0 counts.

use crate::problem::changed::with_effect;
use crate::problem::fit::{Fit, mac, project};
use crate::problem::prior::Prior;
use crate::problem::rows::Posed;
use crate::problem::scene::Scene;
use crate::settings::Settings;
use crate::thresholds::{ALIKE, NEAR, SMALL_STEP, VISIBLE};
use rayon::prelude::*;
use retune::effect::{Candidate, NewParameter};
use retune::linalg::{DMatrix, DVector};
use std::collections::BTreeMap;

/// One direction of the residual that a hypothesis could explain.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    /// Δr, unprojected, priors zero.
    pub(crate) delta: DVector<f64>,
    /// Whether only a positive multiple makes sense.
    pub(crate) one_sided: bool,
    /// The sizes that belong to Δr.
    pub(crate) values: Vec<f64>,
}

/// An effect in its place with its columns.
#[derive(Debug, Clone)]
pub(crate) struct Screened {
    pub(crate) candidate: Candidate,
    pub(crate) columns: Vec<Column>,
}

/// The score of a hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score {
    /// Index of the hypothesis.
    pub(crate) index: usize,
    /// T.
    pub(crate) t: f64,
    /// Index of its best column.
    pub(crate) column: usize,
    /// The multiple of that column.
    pub(crate) factor: f64,
}

/// Every so many of the candidates are evaluated before the next of them: a search that is cut short has seen a part of every kind and place.
const STRIDE: usize = 16;

/// Evaluates every candidate around a fit, in parallel, in the order of the candidates; those that the model refuses or
/// that leave no trace have no columns, nor have those for which there was no time.
pub(crate) fn screen(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    candidates: Vec<Candidate>,
    settings: &Settings,
) -> Vec<Screened> {
    let work = settings.listener.work("screening effects", candidates.len());
    let mut out: Vec<Screened> =
        candidates.into_iter().map(|candidate| Screened { candidate, columns: Vec::new() }).collect();
    let stride = if out.len() < STRIDE * STRIDE { 1 } else { STRIDE };
    for first in 0..stride {
        if settings.until.is_over() {
            break;
        }
        out.par_iter_mut().skip(first).step_by(stride).for_each(|Screened { candidate, columns: seen }| {
            if !settings.until.is_over()
                && scene.tells_of(candidate)
                && let Ok(changed) = with_effect(scene, candidate)
            {
                *seen = columns(&changed, fit, weight, candidate).unwrap_or_default();
            }
            work.step();
        });
    }
    out
}

/// What another stage has seen of its candidates, for a stage that only differs in what is fitted.
pub(crate) struct Seen<'a> {
    pub(crate) screened: &'a [Screened],
    pub(crate) fit: &'a Fit,
    pub(crate) weight: f64,
}

impl Seen<'_> {
    /// Whether the modes of a fit are hardly others than those at which the columns were found: slopes change as much as modes do.
    pub(crate) fn is_near(&self, fit: &Fit) -> bool {
        let is_near = |(mode, (now, before)): (usize, (&f64, &f64))| {
            let pairs = (0..fit.rows.n_sensors).map(|s| (fit.shapes[(s, mode)], self.fit.shapes[(s, mode)]));
            (now / before - 1.0).abs() < NEAR && (!fit.rows.has_shapes || mac(pairs) > 1.0 - NEAR)
        };
        let mut both = fit.frequencies.iter().zip(&self.fit.frequencies).enumerate();
        both.all(|pair| pair.1.0.is_nan() && pair.1.1.is_nan() || is_near(pair))
    }

    /// Candidates with the columns that are known, and which have none.
    ///
    /// # Errors
    /// The candidates, where the columns are not of the same data.
    pub(crate) fn carried(
        &self,
        scene: &Scene,
        fit: &Fit,
        weight: f64,
        candidates: Vec<Candidate>,
    ) -> Result<(Vec<Screened>, Vec<usize>), Vec<Candidate>> {
        let (rows, before) = (fit.rows, self.fit.rows);
        let is_alike = (rows.n_modes, rows.n_sensors, rows.measured, rows.targets)
            == (before.n_modes, before.n_sensors, before.measured, before.targets);
        if !is_alike || scene.has_functions() || !fit.unpaired.is_empty() || !self.fit.unpaired.is_empty() {
            return Err(candidates);
        }
        let noisy = fit.noisy_rows();
        let cut = rows.measured + rows.targets;
        let factor = weight / self.weight;
        let carry = |column: &Column| {
            let carried = |i: usize| if i < cut && noisy[i] { factor * column.delta[i] } else { 0.0 };
            let (delta, values) = (DVector::from_fn(rows.len(), |i, _| carried(i)), column.values.clone());
            Column { delta, one_sided: column.one_sided, values }
        };
        let known: BTreeMap<String, &Screened> = self.screened.iter().map(|s| (s.candidate.id(), s)).collect();
        let is_known = |c: &Candidate| {
            let added = |p: &NewParameter| scene.added.iter().any(|a| a.name == p.name);
            known.get(&c.id()).filter(|k| k.candidate.parameters == c.parameters && !c.parameters.iter().any(added))
        };
        let mut unknown = Vec::new();
        let with_columns = |(i, candidate): (usize, Candidate)| {
            let columns = is_known(&candidate).map(|k| k.columns.iter().map(carry).collect());
            if columns.is_none() {
                unknown.push(i);
            }
            Screened { candidate, columns: columns.unwrap_or_default() }
        };
        let screened = candidates.into_iter().enumerate().map(with_columns).collect();
        Ok((screened, unknown))
    }
}

/// [`screen`] where another stage has seen the same candidates: their columns change little from there, so that only those which then
/// score best, and the best few of every kind, are evaluated anew.
///
/// * `q` - basis of what a refit absorbs
pub(crate) fn screen_again(
    scene: &Scene,
    fit: &Fit,
    q: &DMatrix<f64>,
    weight: f64,
    candidates: Vec<Candidate>,
    seen: &Seen<'_>,
    settings: &Settings,
) -> Vec<Screened> {
    let (mut out, mut anew) = match seen.carried(scene, fit, weight, candidates) {
        Ok(carried) => carried,
        Err(candidates) => return screen(scene, fit, weight, candidates, settings),
    };
    anew.extend(worth_more(&out, fit, q, settings.effort.anew, settings.effort.anew_of_a_kind));
    evaluate_anew(scene, fit, weight, &mut out, anew, settings);
    out
}

/// Candidates that score best by the columns that are known, and the best few of every kind.
pub(super) fn worth_more(known: &[Screened], fit: &Fit, q: &DMatrix<f64>, best: usize, of_a_kind: usize) -> Vec<usize> {
    let ranked = Directions::new(known, q, fit.r.len()).rank(&project(q, &fit.r));
    let mut of_kind: BTreeMap<&str, usize> = BTreeMap::new();
    let mut is_worth_more = |&(k, score): &(usize, Score)| {
        let count = of_kind.entry(known[score.index].candidate.effect.name()).or_default();
        *count += 1;
        k < best || *count <= of_a_kind
    };
    ranked.into_iter().enumerate().filter(|ranked| is_worth_more(ranked)).map(|(_, score)| score.index).collect()
}

/// Replaces the columns of some candidates by those of an evaluation.
pub(super) fn evaluate_anew(
    scene: &Scene,
    fit: &Fit,
    weight: f64,
    known: &mut [Screened],
    these: Vec<usize>,
    settings: &Settings,
) {
    let again = these.iter().map(|&i| known[i].candidate.clone()).collect();
    for (i, screened) in these.into_iter().zip(screen(scene, fit, weight, again, settings)) {
        // What is known stays where there was no time for better.
        if !(screened.columns.is_empty() && settings.until.was_cut()) {
            known[i] = screened;
        }
    }
}

/// The sizes at which a candidate is tried: (values, whether only this sign).
pub(crate) fn steps(candidate: &Candidate) -> Vec<(Vec<f64>, bool)> {
    let p = &candidate.parameters;
    let mut out = Vec::new();
    // Several springs of one body are tuned alike.
    if let Some(gridded) = p.iter().find(|p| !p.grid.is_empty()) {
        let at = |i: usize| p.iter().map(|p| p.grid.get(i).copied().unwrap_or(p.typical)).collect();
        return (0..gridded.grid.len()).map(|i| (at(i), true)).collect();
    }
    let along = |k: Option<usize>, t: f64| -> Vec<f64> {
        p.iter()
            .enumerate()
            .map(|(i, p)| {
                let moved = k.is_none_or(|k| k == i);
                (p.neutral + if moved { t * (p.typical - p.neutral) } else { 0.0 }).clamp(p.bounds[0], p.bounds[1])
            })
            .collect()
    };
    let directions: Vec<Option<usize>> = if p.len() == 1 { vec![None] } else { (0..p.len()).map(Some).collect() };
    for k in directions {
        let one = p.iter().enumerate().any(|(i, p)| k.is_none_or(|k| k == i) && p.one_sided());
        out.push((along(k, SMALL_STEP), one));
        out.push((along(k, 1.0), true));
        if !one {
            out.push((along(k, -1.0), true));
        }
    }
    out
}

/// `scene` has the candidate in it.
fn columns(scene: &Scene, fit: &Fit, weight: f64, candidate: &Candidate) -> Option<Vec<Column>> {
    let comparisons = scene.comparisons().ok()?;
    let priors = vec![Prior::NONE; scene.solved().parameters().free().len()];
    let posed = Posed::new(scene, &comparisons, priors, weight);
    let theta = |values: &[f64]| [&fit.theta, values].concat();
    let (n, rows) = (fit.r.len(), fit.rows);
    let cut = rows.measured + rows.targets;
    let mut out = Vec::new();
    for (values, one_sided) in steps(candidate) {
        let Ok(r) = posed.data_rows(&theta(&values)) else { continue };
        let mut delta = DVector::zeros(n);
        for i in 0..cut {
            // A target that is met is not a datum; how far an effect may push it is decided by the refit.
            let inactive = i >= rows.measured && fit.r[i] == 0.0;
            // At its neutral value the effect changes nothing: the rows are those of the fit.
            delta[i] = if inactive { 0.0 } else { r[i] - fit.r[i] };
        }
        out.push(Column { delta, one_sided, values });
    }
    Some(out)
}

/// The columns of all candidates, projected and of unit length, with their owner and number; columns without a trace left
/// out.
#[derive(Clone)]
pub(crate) struct Directions {
    pub(crate) unit: DMatrix<f64>,
    pub(crate) owner: Vec<(usize, usize)>,
    pub(crate) length: Vec<f64>,
    pub(crate) one_sided: Vec<bool>,
}

impl Directions {
    pub(crate) fn new(screened: &[Screened], q: &DMatrix<f64>, n_rows: usize) -> Self {
        let all: Vec<(usize, usize)> =
            screened.iter().enumerate().flat_map(|(i, s)| (0..s.columns.len()).map(move |k| (i, k))).collect();
        let projected: Vec<DVector<f64>> =
            all.par_iter().map(|&(i, k)| project(q, &screened[i].columns[k].delta)).collect();
        let (mut unit, mut owner, mut length, mut one_sided) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for ((i, k), v) in all.into_iter().zip(projected) {
            let norm = v.norm();
            // The small step is judged as if at the typical size.
            let column = &screened[i].columns[k];
            let visible = if is_small(&screened[i].candidate, &column.values) { norm / SMALL_STEP } else { norm };
            // What projection leaves of a column that the base can imitate is rounding.
            if visible < VISIBLE || norm < 1e-6 * column.delta.norm() {
                continue;
            }
            unit.push(v / norm);
            owner.push((i, k));
            length.push(norm);
            one_sided.push(column.one_sided);
        }
        let unit = if unit.is_empty() { DMatrix::zeros(n_rows, 0) } else { DMatrix::from_columns(&unit) };
        Self { unit, owner, length, one_sided }
    }

    /// T of every column for a projected residual: zero where the sign is wrong.
    pub(crate) fn scores(&self, r: &DVector<f64>) -> Vec<f64> {
        let along = self.unit.tr_mul(r);
        along.iter().zip(&self.one_sided).map(|(a, one)| if *one && *a > 0.0 { 0.0 } else { a * a }).collect()
    }

    /// The best column of every candidate that has a trace, by descending score; ties by index.
    pub(crate) fn rank(&self, r: &DVector<f64>) -> Vec<Score> {
        let scores = self.scores(r);
        let along = self.unit.tr_mul(r);
        let mut best: BTreeMap<usize, Score> = BTreeMap::new();
        for (c, &(index, column)) in self.owner.iter().enumerate() {
            let score = Score { index, t: scores[c], column, factor: -along[c] / self.length[c] };
            let entry = best.entry(index).or_insert(score);
            if score.t > entry.t {
                *entry = score;
            }
        }
        let mut out: Vec<Score> = best.into_values().collect();
        out.sort_by(|a, b| b.t.total_cmp(&a.t).then(a.index.cmp(&b.index)));
        out
    }
}

impl Directions {
    /// Candidates that leave nearly the trace of one of these columns (cosine above 0.98), nearest first.
    pub(crate) fn alike(&self, to: &[(usize, usize)]) -> Vec<usize> {
        let mut best: BTreeMap<usize, f64> = BTreeMap::new();
        for owner in to {
            let Some(c) = self.owner.iter().position(|o| o == owner) else { continue };
            let cosines = self.unit.tr_mul(&self.unit.column(c));
            for (k, cosine) in cosines.iter().enumerate().filter(|(_, v)| v.abs() > ALIKE) {
                let entry = best.entry(self.owner[k].0).or_default();
                *entry = entry.max(cosine.abs());
            }
        }
        let mut out: Vec<(usize, f64)> = best.into_iter().collect();
        out.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        out.into_iter().map(|(i, _)| i).collect()
    }
}

/// Whether sizes are those of the small step, which tells a slope.
pub(crate) fn is_small(candidate: &Candidate, values: &[f64]) -> bool {
    candidate.parameters.iter().all(|p| p.grid.is_empty())
        && candidate
            .parameters
            .iter()
            .zip(values)
            .all(|(p, v)| (v - p.neutral).abs() <= 1.5 * SMALL_STEP * (p.typical - p.neutral).abs())
}
