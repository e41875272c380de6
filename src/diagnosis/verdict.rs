//! From evidences and [probabilities](super::odds) to ties and a verdict.
//!
//! * Alarm: the calibrated p-value below the level, or a measured mode without partner.
//! * A verdict follows the probabilities: with "nothing" more probable than all else together nothing is named, with
//!   "something else" more probable than all else together, two effects included, the verdict is `unexplained`.
//! * A hypothesis is believed when its ln Bayes factor is above 3 *and* what remains looks like noise: goodness of fit, a
//!   second screening and neighbouring sensors, each at a level of 0.001, and no mode without partner. Among
//!   tied hypotheses the most probable one that passes is taken. An effect that predicts held-out modes worse than the base does may be
//!   an image: one that is tied with it and predicts better stands before it, and two are sought as well and named where they are more
//!   probable.
//! * Else a second hypothesis is sought on top of the best, and each of the two again [beside the other](super::pairs); with a gain above 3, held-out modes predicted better than by the base,
//!   and noise as remainder the verdict is `several-effects`, else `unexplained`.

use super::base::Stage;
use super::evidence::{EACH_REMAINDER, REMAINDER, degrees_of_freedom, goodness_of_fit, held_out, something_else};
use super::fit::Fit;
use super::joint::together;
use super::next_measurement::next_measurements;
use super::noise::whiteness;
use super::odds::{Odds, Probabilities, ln_mean};
use super::pairs::{Pair, pair};
use super::refit::{Refit, Refits, Tried, merge, refit, refit_these};
use super::scene::Scene;
use super::screen::project;
use super::spread::{self, Fitted, Spread};
use super::warnings::{leaves_damping_aside, number, warnings};
use super::{Diagnosis, DiagnosisError, HypothesisResult, Kind, Settings, Verdict, result};
use crate::linalg::{DMatrix, DVector};
use std::collections::BTreeSet;

/// ln of the Bayes factor that is called strong (Kass and Raftery 1995: 20 to 1).
pub(super) const STRONG: f64 = 3.0;
/// Tied hypotheses that are checked for what they leave.
const CHECKED: usize = 3;

/// What the tests say of what remains.
struct Remainder {
    passes: bool,
    /// Whether all modes have partners and the misfit is below the median of what noise gives.
    is_small: bool,
    p_value: f64,
    text: String,
}

impl Remainder {
    /// What is smaller than the stated noise needs no explanation, though a third effect may still be seen in it.
    fn needs_nothing_more(&self) -> bool {
        self.passes || self.is_small
    }
}

/// The diagnosis of what was refitted. Where two are named, each alone is fitted once more from where the two have brought the base, and if
/// that is much better, all is concluded anew: neither may suffice alone because it was fitted in a wrong valley.
pub(super) fn conclude(base: &Stage, refits: &mut Refits, settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    let (diagnosis, pair) = conclude_once(base, refits, settings)?;
    let Some(pair) = pair else { return Ok(diagnosis) };
    let n = base.fit.x.len();
    let ends = [pair.firsts.first(), pair.seconds.first()];
    let starts: Vec<DVector<f64>> = ends.iter().flatten().map(|r| r.fit.x.rows(0, n).into_owned()).collect();
    let tried: Vec<&Tried> = ends.iter().flatten().map(|r| &r.tried).collect();
    let alone = refit_these(base, &tried, &starts)?;
    let known = |r: &Refit| refits.hypotheses.iter().find(|k| k.id(&base.scene) == r.id(&base.scene));
    if alone.iter().any(|r| known(r).is_none_or(|k| r.ln_bayes > k.ln_bayes + STRONG)) {
        merge(base, &mut refits.hypotheses, alone);
        return Ok(conclude_once(base, refits, settings)?.0);
    }
    Ok(diagnosis)
}

fn conclude_once(
    base: &Stage,
    Refits { hypotheses: refits, spreads }: &mut Refits,
    settings: &Settings,
) -> Result<(Diagnosis, Option<Pair>), DiagnosisError> {
    let dof = degrees_of_freedom(&base.fit, &base.q);
    let fits = goodness_of_fit(&base.fit, &base.q);
    let white = whiteness(&base.scene, &base.fit, &base.q, settings.seed.wrapping_add(2));
    let looks_like_noise = is_noise(fits, white, EACH_REMAINDER) && base.fit.unpaired.is_empty();
    // The level is shared with the tests of the remainder, which raise an alarm too.
    let alarm = base.p_value < settings.alarm_level - REMAINDER || !base.fit.unpaired.is_empty();
    let best_bayes = refits.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max);
    let is_tied = |r: &Refit| r.ln_bayes > best_bayes - STRONG && r.ln_bayes > 0.0;
    let ways: Vec<f64> =
        std::iter::once(something_else(&base.residual, dof)).chain(spreads.iter().map(|s| s.spread.ln_bayes)).collect();
    let held_before: f64 = held_out(&base.fit, base.weight)?.iter().sum();
    let odds = Odds::new(base);
    let other = ln_mean(&ways);
    let mut p = odds.probabilities(base, refits, other);
    p.sort(refits);
    let leads = p.each.first().is_some_and(|p| *p > 0.5);
    let strong = best_bayes > STRONG && p.none < 0.5;
    let Answer { verdict, mut chosen, remainder, spread, pair } = if looks_like_noise && !(alarm && strong) {
        Answer { verdict: Verdict::Adequate, ..Answer::default() }
    } else if !alarm || !strong {
        p.deny(if base.fit.unpaired.is_empty() { (2.0 * fits.min(white)).min(1.0) } else { 0.0 });
        Answer { remainder: place_of(&base.scene, &base.fit, &base.q), ..Answer::default() }
    } else {
        let tied: Vec<usize> = (0..refits.len()).filter(|&i| is_tied(&refits[i])).collect();
        let else_ln = odds.of_something_else() + other;
        name(base, refits, &tied, &Else { odds: &odds, ln: else_ln, spreads, held_before }, &mut p, settings)?
    };
    if let Some(pair) = &pair {
        let id = pair.first.id(&base.scene);
        chosen = refits.iter().position(|r| r.id(&base.scene) == id).unwrap_or_else(|| {
            refits.push(pair.first.clone());
            p.each.push(0.0);
            refits.len() - 1
        });
    }
    // The hypothesis that leaves noise stands first, also where another is a little more probable and does not.
    if chosen > 0 {
        refits[..=chosen].rotate_right(1);
        p.each[..=chosen].rotate_right(1);
    }
    let tied_ids = |i: usize| -> Vec<String> {
        if !is_tied(&refits[i]) {
            return Vec::new();
        }
        (0..refits.len()).filter(|&k| k != i && is_tied(&refits[k])).map(|k| refits[k].id(&base.scene)).collect()
    };
    let alone: Vec<HypothesisResult> =
        (0..refits.len()).map(|i| result(base, &refits[i], held_before, p.each[i], tied_ids(i))).collect();
    let hypotheses = match &pair {
        Some(pair) => beside_each_other(pair, &p, alone)?,
        None => alone,
    };
    let next = if alarm && strong && verdict != Verdict::Adequate {
        next_measurements(base, refits, best_bayes - STRONG)?
    } else {
        Vec::new()
    };
    let named: Vec<&Refit> = match (&pair, verdict) {
        (Some(pair), _) => pair.firsts.first().into_iter().chain(pair.seconds.first()).collect(),
        (None, Verdict::Adequate) => Vec::new(),
        (None, _) => refits.first().into_iter().collect(),
    };
    let told = warnings(base, &named);
    let mut sentence = match &pair {
        Some(pair) => sentence_of_two(pair, &hypotheses),
        None if spread.is_some() => format!("no single effect explains the test; {remainder}"),
        None => sentence(verdict, hypotheses.first(), leads, base, &remainder),
    };
    if told.mesh_is_too_coarse && verdict != Verdict::Adequate {
        sentence += "; refine the mesh first: it errs by more than the data do";
    }
    let diagnosis = Diagnosis {
        verdict,
        sentence,
        p_value: base.p_value,
        noise_factor: base.noise_factor(),
        misfit: base.fit.misfit,
        held_out: held_before,
        degrees_of_freedom: dof,
        screened_effects: base.screened.len(),
        visible_effects: base.effects.len(),
        screened_faults: base.faults.len(),
        probability_none: p.none,
        probability_other: p.other,
        hypotheses,
        next_measurements: next,
        spread,
        unpaired_modes: base.fit.unpaired.iter().map(|m| m + 1).collect(),
        foreign_modes: Vec::new(),
        pairs: Vec::new(),
        remainder,
        warnings: told.all,
    };
    Ok((diagnosis, pair))
}

/// What is answered.
struct Answer {
    verdict: Verdict,
    /// The hypothesis that stands first.
    chosen: usize,
    /// What remains, in words.
    remainder: String,
    /// What is spread over the structure, if that is more probable than a single hypothesis.
    spread: Option<Spread>,
    /// The two, if two are named.
    pair: Option<Pair>,
}

impl Default for Answer {
    fn default() -> Self {
        Self { verdict: Verdict::Unexplained, chosen: 0, remainder: String::new(), spread: None, pair: None }
    }
}

/// What is told of two hypotheses: the two, what the data cannot tell from one of them beside the other, and the others alone.
fn beside_each_other(
    pair: &Pair,
    p: &Probabilities,
    alone: Vec<HypothesisResult>,
) -> Result<Vec<HypothesisResult>, DiagnosisError> {
    let tell = |stage: &Stage, list: &[Refit]| -> Result<Vec<HypothesisResult>, DiagnosisError> {
        let held_before: f64 = held_out(&stage.fit, stage.weight)?.iter().sum();
        let best = list.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max);
        let is_tied = |r: &Refit| r.ln_bayes > best - STRONG && r.ln_bayes > 0.0;
        // The member itself, which is the most probable of these, first.
        let mut known = BTreeSet::new();
        let of_pair = list.iter().enumerate().filter(|(k, r)| *k == 0 || is_tied(r)).map(|(_, r)| r);
        let tied: Vec<&Refit> = of_pair.filter(|r| known.insert(r.id(&stage.scene))).collect();
        let ids: Vec<String> = tied.iter().map(|r| r.id(&stage.scene)).collect();
        let one = |(k, r): (usize, &&Refit)| {
            let others = (0..ids.len()).filter(|&i| i != k).map(|i| ids[i].clone()).collect();
            let own = alone.iter().find(|h| h.id == ids[k]).map_or(0.0, |h| h.probability);
            result(stage, r, held_before, (own + p.pairs * pair.share(&ids[k])).min(1.0), others)
        };
        let told: Vec<HypothesisResult> = tied.iter().enumerate().map(one).collect();
        Ok(told)
    };
    let (firsts, seconds) = (tell(&pair.on_second, &pair.firsts)?, tell(&pair.on_first, &pair.seconds)?);
    let (mut firsts, mut seconds) = (firsts.into_iter(), seconds.into_iter());
    let mut out: Vec<HypothesisResult> = firsts.next().into_iter().chain(seconds.next()).collect();
    for h in firsts.chain(seconds).chain(alone) {
        if !out.iter().any(|known| known.id == h.id) {
            out.push(h);
        }
    }
    Ok(out)
}

/// * `hypotheses` - of [`beside_each_other`]
fn sentence_of_two(pair: &Pair, hypotheses: &[HypothesisResult]) -> String {
    let [first, second, ..] = hypotheses else { return String::new() };
    let what = |h: &HypothesisResult| match h.kind {
        Kind::Effect => format!("{} is missing", h.id),
        Kind::Fault => format!("{}: the measurement", h.id),
    };
    let ties = |h: &HypothesisResult| match h.tied_with.len() {
        0 => String::new(),
        1 => format!("; {} cannot be told from {}", h.tied_with[0], h.id),
        n => format!("; {n} others cannot be told from {}", h.id),
    };
    let both = match (first.kind, second.kind) {
        (Kind::Effect, Kind::Effect) => format!("{} and {} are missing together", first.id, second.id),
        (Kind::Fault, Kind::Fault) => format!("{} and {}: the measurement, not the model", first.id, second.id),
        _ => format!("{}, and {}", what(first), what(second)),
    };
    let perhaps = if pair.share(&first.id).min(pair.share(&second.id)) > 0.5 { "" } else { "perhaps " };
    format!("{perhaps}{both}, and neither suffices alone{}{}", ties(first), ties(second))
}

/// What speaks for something else.
struct Else<'a> {
    odds: &'a Odds<'a>,
    /// ln of its odds times its Bayes factor.
    ln: f64,
    spreads: &'a [Fitted],
    /// How badly the base predicts each mode from the others: two effects that are no better only imitate.
    held_before: f64,
}

impl Else<'_> {
    /// The spread that explains the test best, if it is more probable than a hypothesis.
    fn spread(&self, than: &Refit) -> Option<&Spread> {
        let odds = self.odds.of(than) - self.odds.of_something_else();
        let best = spread::best(self.spreads).map(|s| &s.spread);
        best.filter(|s| s.ln_bayes > than.ln_bayes + odds)
    }
}

/// Names one hypothesis, two, or none.
fn name(
    base: &Stage,
    refits: &[Refit],
    tied: &[usize],
    otherwise: &Else<'_>,
    p: &mut Probabilities,
    settings: &Settings,
) -> Result<Answer, DiagnosisError> {
    let mut failed: Vec<(usize, Remainder)> = Vec::new();
    let mut on_first = None;
    let mut doubted = None;
    let may_be_named = p.other < 0.5;
    // What imitates something else fits the modes it was fitted to; the others it predicts worse than the base does.
    let predicts = |r: &Refit| r.held_out < otherwise.held_before;
    for &i in tied.iter().take(if may_be_named { CHECKED } else { 1 }) {
        let (found, stage) = remains(base, &refits[i], settings)?;
        // What needs a mode that the test has overlooked is not put before what is more probable.
        let is_believed = found.passes && (refits[i].overlooked == 0 || i == tied[0]);
        if is_believed && may_be_named {
            let verdict = match refits[i].tried {
                Tried::Effect(_) => Verdict::MissingEffect,
                Tried::Fault(_) => Verdict::MeasurementFault,
            };
            let answer = Answer { verdict, chosen: i, ..Answer::default() };
            if verdict == Verdict::MeasurementFault || predicts(&refits[i]) {
                return Ok(answer);
            }
            doubted.get_or_insert(answer);
        }
        failed.push((i, found));
        on_first.get_or_insert(stage);
    }
    let (Some((chosen, found)), Some(on_first)) = (failed.first(), on_first) else { return Ok(Answer::default()) };
    let (chosen, odds) = (*chosen, otherwise.odds);
    let more = refit(&on_first, true)?.hypotheses;
    let weight = |r: &Refit| odds.of(r) + r.ln_bayes;
    let ln_known = weight(&refits[chosen]) + more.iter().map(weight).fold(f64::NEG_INFINITY, f64::max);
    let bases: Vec<_> = spread::best(otherwise.spreads).map(|s| s.base.clone()).into_iter().collect();
    let (first, on_first, more) =
        together(base, &bases, odds, ln_known, settings)?.unwrap_or((refits[chosen].clone(), on_first, more));
    let best = more.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes));
    if best.is_some_and(|r| r.ln_bayes > STRONG && on_first.p_value < settings.alarm_level && predicts(r)) {
        // Two of some hundreds imitate much: they have to be more probable than something else, and than one that may stand alone, and
        // what they leave has to pass the same tests as what one leaves.
        let least = if doubted.is_some() { otherwise.ln.max(weight(&refits[chosen])) } else { otherwise.ln };
        let ln_two = weight(&first) + odds.of_a_second(&more);
        let two = pair(base, refits, first, (on_first, more), odds, settings)?;
        if let Some(two) = two.filter(|two| two.ln_all > least && predicts(&two.seconds[0]))
            && remains(&two.on_first, &two.seconds[0], settings)?.0.needs_nothing_more()
        {
            p.with_pairs(two.ln_all);
            let ids = [two.first.id(&base.scene), two.seconds[0].id(&base.scene)];
            let remainder = format!("beside {}: {}", ids[0], ids[1]);
            return Ok(Answer { verdict: Verdict::SeveralEffects, remainder, pair: Some(two), ..Answer::default() });
        }
        if doubted.is_none() {
            p.with_a_pair(chosen, ln_two);
        }
    }
    if let Some(answer) = doubted {
        return Ok(answer);
    }
    for (i, r) in refits.iter().enumerate() {
        let left = match failed.iter().find(|f| f.0 == i) {
            Some(f) => f.1.p_value,
            None => r.p_value()?,
        };
        p.doubt(i, left);
    }
    let spread = otherwise.spread(&refits[chosen]);
    let remainder = match spread {
        Some(spread) => spread.to_string(),
        None if found.passes => place_of(&base.scene, &base.fit, &base.q),
        None => found.text.clone(),
    };
    Ok(Answer { chosen, remainder, spread: spread.cloned(), ..Answer::default() })
}

/// Whether a hypothesis that leaves noise explains the test better than noise s2 times as large as stated does:
///
/// ```text
/// ln B(s2) = ½ χ² (1 - 1/s2) - ½ n ln s2 - ½ ln n      for n degrees of freedom, with the prior odds of "nothing is missing"
/// ```
pub(super) fn better_than_noise(base: &Stage, refits: &[Refit]) -> Result<bool, DiagnosisError> {
    let (n, s2) = (degrees_of_freedom(&base.fit, &base.q).max(1.0), base.scatter.s2);
    let chi2 = base.residual.norm_squared();
    let noise = 0.5_f64.ln() + 0.5 * (chi2 * (1.0 - 1.0 / s2) - n * s2.ln() - n.ln());
    let odds = Odds::new(base);
    for r in refits.iter().filter(|r| odds.of(r) + r.ln_bayes > noise) {
        if r.leaves_noise()? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether a remainder looks like noise. Below the median of what noise alone gives, how neighbours go together says nothing:
/// what is smaller than the stated noise needs no explanation.
fn is_noise(fits: f64, white: f64, level: f64) -> bool {
    fits > 0.5 || (fits > level && white > level)
}

/// Screens again with a hypothesis in the base.
fn remains(base: &Stage, r: &Refit, settings: &Settings) -> Result<(Remainder, Stage), DiagnosisError> {
    let second = base.with(r, settings)?;
    let fits = goodness_of_fit(&second.fit, &second.q);
    let white = whiteness(&second.scene, &second.fit, &second.q, settings.seed.wrapping_add(2));
    let passes =
        is_noise(fits, white, EACH_REMAINDER) && second.p_value > EACH_REMAINDER && second.fit.unpaired.is_empty();
    // The smallest of three.
    let p_value =
        if second.fit.unpaired.is_empty() { (3.0 * fits.min(white).min(second.p_value)).min(1.0) } else { 0.0 };
    let text = if passes { String::new() } else { place_of(&second.scene, &second.fit, &second.q) };
    let is_small = fits > 0.5 && second.fit.unpaired.is_empty();
    Ok((Remainder { passes, is_small, p_value, text }, second))
}

/// The modes and sensors that carry the most of a projected residual.
fn place_of(scene: &Scene, fit: &Fit, q: &DMatrix<f64>) -> String {
    let r = project(q, &fit.r);
    let rows = fit.rows;
    let mut modes: Vec<(f64, usize)> = (0..rows.n_modes)
        .map(|m| (fit.mode_rows(m).iter().map(|&i| r[i] * r[i]).sum::<f64>() / fit.mode_rows(m).len() as f64, m))
        .collect();
    modes.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let words: Vec<String> = modes.iter().take(3).map(|(v, m)| format!("{} ({v:.1})", scene.mode_name(*m))).collect();
    let mut out = format!("mean square of what remains: {}", words.join(", "));
    if rows.has_shapes {
        let mut sensors: Vec<(f64, usize)> = (0..rows.n_sensors)
            .map(|s| ((0..rows.n_modes).map(|m| r[rows.shape(m, s)].powi(2)).sum::<f64>() / rows.n_modes as f64, s))
            .collect();
        sensors.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let words: Vec<String> =
            sensors.iter().take(4).map(|(v, s)| format!("{} ({v:.1})", scene.test.sensors[*s].name)).collect();
        out += &format!("; at sensors {}", words.join(", "));
    }
    if !fit.unpaired.is_empty() {
        let modes: Vec<String> = fit.unpaired.iter().map(|&m| scene.mode_name(m)).collect();
        out += &format!("; no partner for {}", modes.join(", "));
    }
    out
}

/// * `leads` - whether the best was more probable than all else before its remainder was tested
fn sentence(verdict: Verdict, best: Option<&HypothesisResult>, leads: bool, base: &Stage, remainder: &str) -> String {
    let id = best.map_or("", |b| b.id.as_str());
    let likely = best.is_some_and(|b| b.probability > 0.5);
    let tie = match best.map_or(&[][..], |b| &b.tied_with) {
        [] => String::new(),
        [other] => format!("; {other} cannot be told from it"),
        others => format!("; {} others cannot be told from it", others.len()),
    };
    let what = if leaves_damping_aside(base) { "the test without its damping" } else { "the test" };
    match verdict {
        Verdict::Adequate if base.noise_factor() > 1.0 => {
            format!("the model explains {what} if its noise is {:.2} times the stated one", base.noise_factor())
        }
        Verdict::Adequate => format!("the model explains {what} at its stated noise"),
        Verdict::MissingEffect if likely => format!("{id} is missing, and what remains looks like noise{tie}"),
        Verdict::MissingEffect => {
            format!("something is missing, perhaps {id}, with which what remains looks like noise{tie}")
        }
        Verdict::MeasurementFault if likely => format!("{id}: the measurement, not the model{tie}"),
        Verdict::MeasurementFault => format!("perhaps {id}: the measurement, not the model{tie}"),
        Verdict::Unexplained | Verdict::SeveralEffects => match best.filter(|b| b.ln_bayes > STRONG && leads) {
            Some(b) => format!(
                "{id} takes the misfit from {} to {} and what remains is in nothing of the catalogue; {remainder}",
                number(b.misfit_before),
                number(b.misfit_after)
            ),
            None => format!("nothing in the catalogue explains the test; {remainder}"),
        },
    }
}
