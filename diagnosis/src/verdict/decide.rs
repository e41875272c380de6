//! From evidences and [probabilities](super::posterior) to ties and a verdict.
//!
//! * Alarm: the calibrated p-value below the level, or a measured mode without partner.
//! * A verdict follows the probabilities: with "nothing" more probable than all else together nothing is named, with
//!   "something else" more probable than all else together, two effects included, the verdict is `unexplained`.
//! * A hypothesis is believed when its ln Bayes factor is above 3 *and* what remains looks like noise: goodness of fit, a
//!   second screening and neighbouring sensors, each at a level of 0.001, and no mode without partner. Slopes that stand out in the second screening count where a fit
//!   beside the hypothesis confirms them, with ln B above 3. Among tied hypotheses the most probable one that passes is taken. An effect that predicts held-out modes worse than the base does may be
//!   an image: one that is tied with it and predicts better stands before it, and two are sought as well and named where they are more
//!   probable.
//! * Else a second hypothesis is sought on top of the best, and each of the two again [beside the other](crate::search::pairs); with a gain above 3, held-out modes predicted better than by the base,
//!   and noise as remainder the verdict is `several-effects`. Where two do not suffice either, [more](crate::search::several) are added one by one. If
//!   these leave no noise, or are not clearly more probable than something outside the catalogue, the verdict is `unexplained`.
//! * What is called adequate needs noise of at most twice the stated size, and shapes that agree as well as shapes with such noise do; else
//!   the stated noise or the model is wrong, and the verdict is `noise-or-model`.

use super::next_measurement::next_measurements;
use super::pairs::pairs_of;
use super::posterior::Probabilities;
use super::warnings::warnings;
use super::words::{of_nearly, of_noise_or_model, of_one, of_several, of_two};
use crate::error::DiagnosisError;
use crate::problem::evidence::{degrees_of_freedom, goodness_of_fit, held_out_in_all, ln_mean, something_else};
use crate::problem::fit::project;
use crate::problem::work::WorkDone;
use crate::result::{Diagnosis, HypothesisResult, Kind, Together, Verdict};
use crate::screen::noise::{whiteness, worst_shape};
use crate::screen::stage::Stage;
use crate::search::board::{Refits, merge};
use crate::search::fault_first::fault_first;
use crate::search::hypothesis::{Refit, Tried, leaving_noise, without_between};
use crate::search::joint::{WithFirst, together};
use crate::search::pairs::{Pair, pair};
use crate::search::prior::{Odds, ln_odds_of_noise, ln_odds_of_none};
use crate::search::remainder::{Remainder, is_noise, place_of, remains};
use crate::search::run::refit_begun;
use crate::search::several::{Chain, chain};
use crate::search::singles::refit;
use crate::search::spread::{self, Fitted, Spread};
use crate::settings::Settings;
use crate::thresholds::{DOUBT, DRAWS, EACH_REMAINDER, MOST_NOISE, REMAINDER, STRONG, WORTH_A_TRY};
use retune::linalg::DVector;
use std::collections::BTreeSet;

/// The diagnosis of what was refitted. Where two are named, each alone is fitted once more from where the two have brought the base, and if
/// that is much better, all is concluded anew: neither may suffice alone because it was fitted in a wrong basin.
pub(crate) fn conclude(base: &Stage, refits: &mut Refits, settings: &Settings) -> Result<Diagnosis, DiagnosisError> {
    let (diagnosis, pair) = conclude_once(base, refits, settings)?;
    let Some(pair) = pair else { return Ok(diagnosis) };
    let n = base.fit.x.len();
    let ends = [pair.firsts.first(), pair.seconds.first()];
    let starts: Vec<DVector<f64>> = ends.iter().flatten().map(|r| r.fit.x.rows(0, n).into_owned()).collect();
    // With its own sizes as they are beside the other.
    let begun = |r: &Refit| {
        let own = r.own_sizes().filter(|sizes| !sizes.is_empty())?;
        Some(without_between(&r.fit.x, n, own.len()))
    };
    let tried: Vec<_> = ends.iter().flatten().map(|r| (&r.tried, begun(r))).collect();
    let alone = refit_begun(base, &tried, &starts)?;
    let known = |r: &Refit| refits.hypotheses.iter().find(|k| k.id(&base.scene) == r.id(&base.scene));
    // One that stays far below the best alone changes nothing that is concluded.
    let best = refits.hypotheses.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max);
    let is_better = |r: &Refit| known(r).is_none_or(|k| r.ln_bayes > k.ln_bayes + STRONG);
    if alone.iter().any(|r| is_better(r) && r.ln_bayes > best - STRONG) {
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
    let mut ways: Vec<f64> =
        std::iter::once(something_else(&base.residual, dof)).chain(spreads.iter().map(|s| s.spread.ln_bayes)).collect();
    // A random vector at the stated noise makes the same residuals as larger noise does, without its odds.
    ways.extend((base.noise_factor() > 1.0).then(|| -ln_odds_of_noise(base.noise_factor())));
    let held_before = held_out_in_all(&base.fit, base.weight)?;
    let odds = Odds::new(base);
    // By the data alone, or with the odds.
    let weight = |r: &Refit| odds.weight(r);
    let best_weight = refits.iter().map(weight).fold(f64::NEG_INFINITY, f64::max);
    let is_tied =
        |r: &Refit| (r.ln_bayes > best_bayes - STRONG || weight(r) > best_weight - STRONG) && r.ln_bayes > 0.0;
    let other = ln_mean(&ways);
    let mut p = Probabilities::new(&odds, base, refits, other);
    p.sort(refits);
    let leads = !refits.is_empty() && p.each(0) > 0.5;
    // What is named is more probable than nothing, it or what the data cannot tell from it.
    let of_the_tied: f64 = (0..refits.len()).filter(|&i| is_tied(&refits[i])).map(|i| p.each(i)).sum();
    let strong = best_bayes > STRONG && p.none() < of_the_tied.max(p.other());
    let shape = worst_shape(&base.fit, base.weight, settings.seed.wrapping_add(3));
    let Answer { verdict, mut chosen, remainder, spread, pair, chain, best_two } =
        if looks_like_noise && !(alarm && strong) {
            let is_poor = shape.as_ref().is_some_and(|s| s.p_value < EACH_REMAINDER);
            if is_poor {
                p.deny(1.0 / DRAWS as f64);
            }
            let is_believed = !is_poor && base.noise_factor() <= MOST_NOISE;
            let verdict = if is_believed { Verdict::Adequate } else { Verdict::NoiseOrModel };
            Answer { verdict, ..Answer::default() }
        } else if !alarm || !strong {
            p.deny(if base.fit.unpaired.is_empty() { (2.0 * fits.min(white)).min(1.0) } else { 0.0 });
            Answer { remainder: place_of(&base.scene, &base.fit, &base.q), ..Answer::default() }
        } else {
            let tied: Vec<usize> = (0..refits.len()).filter(|&i| is_tied(&refits[i])).collect();
            let else_ln = odds.of_something_else() + other;
            name(base, refits, &tied, &Else { odds: &odds, ln: else_ln, spreads, held_before }, &mut p, settings)?
        };
    let first = pair.as_ref().map(|pair| &pair.first).or(chain.as_ref().map(Chain::first));
    if let Some(first) = first {
        let id = first.id(&base.scene);
        chosen = refits.iter().position(|r| r.id(&base.scene) == id).unwrap_or_else(|| {
            p.push(odds.weight(first));
            refits.push(first.clone());
            refits.len() - 1
        });
    }
    // The hypothesis that leaves noise stands first, also where another is a little more probable and does not.
    if chosen > 0 {
        refits[..=chosen].rotate_right(1);
        p.put_first(chosen);
    }
    let tied_ids = |i: usize| -> Vec<String> {
        if !is_tied(&refits[i]) {
            return Vec::new();
        }
        (0..refits.len()).filter(|&k| k != i && is_tied(&refits[k])).map(|k| refits[k].id(&base.scene)).collect()
    };
    let alone: Vec<HypothesisResult> = (0..refits.len())
        .map(|i| result(base, &refits[i], odds.of(&refits[i]), held_before, p.each(i), tied_ids(i)))
        .collect();
    let hypotheses = match (&pair, &chain) {
        (Some(pair), _) => beside_each_other(pair, &odds, &p, alone)?,
        (None, Some(_)) => first_of_several(&p, alone),
        (None, None) => alone,
    };
    let together = together_of(base, &p, &odds, (pair.as_ref(), chain.as_ref()), best_two.as_ref());
    let next = if alarm && strong && !verdict.is_about_noise() {
        next_measurements(base, refits, best_bayes - STRONG)?
    } else {
        Vec::new()
    };
    let named: Vec<&Refit> = match (&pair, &chain, verdict) {
        (Some(pair), ..) => pair.firsts.first().into_iter().chain(pair.seconds.first()).collect(),
        (None, Some(chain), _) => chain.members.iter().map(|m| &m.1).collect(),
        (None, None, Verdict::Adequate | Verdict::NoiseOrModel) => Vec::new(),
        (None, None, _) => refits.first().into_iter().collect(),
    };
    // What explains the test best, with all that is named in it.
    let best = match (&pair, &chain) {
        (Some(pair), _) => pair.seconds.first(),
        (None, Some(chain)) => Some(chain.last()),
        (None, None) => named.first().copied().filter(|r| r.ln_bayes > STRONG),
    };
    let pairs_with = match best.filter(|_| verdict.names_hypotheses()) {
        Some(r) => r.scene.comparisons()?.iter().map(|c| pairs_of(c, &r.fit.theta)).collect::<Result<_, _>>()?,
        None => Vec::new(),
    };
    let told = warnings(base, &named, best);
    let mut sentence = match (&pair, &chain, verdict) {
        (Some(pair), ..) => of_two(base, pair, &hypotheses),
        (None, Some(chain), _) => of_several(base, chain, &hypotheses),
        (None, None, Verdict::NoiseOrModel) => of_noise_or_model(base, shape.as_ref()),
        (None, None, Verdict::Unexplained) if spread.is_none() && p.several() > 0.5 => {
            of_nearly(base, together.as_ref())
        }
        (None, None, _) if spread.is_some() => match leaving_noise(refits.iter().filter(|r| r.ln_bayes > STRONG))? {
            Some(r) => format!(
                "{} leaves no more than noise; among so many places something that acts everywhere is more probable: {remainder}",
                r.id(&base.scene)
            ),
            None => format!("no single effect explains the test; {remainder}"),
        },
        (None, None, _) => {
            let left = named.first().map_or(Ok(1.0), |r| r.p_value())?;
            of_one(verdict, hypotheses.first(), (leads, left), base, &remainder)
        }
    };
    let factor = base.noise_factor();
    if factor > MOST_NOISE && !verdict.is_about_noise() {
        sentence += &format!(
            "; all this with noise {factor:.1} times as large as stated, so that the stated noise is wrong as well, or more is missing"
        );
    } else if factor > 1.0 && verdict.names_hypotheses() {
        sentence += &format!("; with noise {factor:.2} times as large as stated");
    }
    if verdict.names_hypotheses() && p.none() > DOUBT {
        sentence += &format!("; that nothing is missing has a probability of {:.0} %", 100.0 * p.none());
    }
    let contradicted = base.scene.contradicted();
    if verdict == Verdict::Unexplained && !contradicted.is_empty() {
        let models = base.scene.cases.iter();
        let is_held = models.map(|case| &case.model).any(|m| !m.spec().supports.is_empty());
        let unless = if is_held { "unless a support gives" } else { "whatever the stiffness" };
        sentence += &format!(
            "; {unless}, the motions of the model contradict the shapes at {}: `retune health --model` says how, and that is to be \
             put right first",
            contradicted.join(", ")
        );
    }
    if let Some(better) = &told.finer_mesh {
        sentence += &format!("; refine the mesh first: {better}");
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
        probability_none: p.none(),
        ln_bayes_none: p.ln_bayes_of_none(),
        ln_odds_none: ln_odds_of_none(),
        probability_other: p.other(),
        ln_bayes_other: p.ln_bayes_of_other(),
        ln_odds_other: odds.of_something_else(),
        probability_only_other: p.only_other(),
        together,
        hypotheses,
        next_measurements: next,
        spread,
        unpaired_modes: base.fit.unpaired.iter().map(|m| m + 1).collect(),
        damping: None,
        foreign_modes: Vec::new(),
        pairs: Vec::new(),
        pairs_with,
        remainder,
        warnings: told.all,
        work: WorkDone::default(),
        is_partial: false,
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
    /// All, if more than two are named.
    chain: Option<Chain>,
    /// The two that explain most where none are named, and what they leave.
    best_two: Option<([String; 2], f64)>,
}

impl Default for Answer {
    fn default() -> Self {
        Self {
            verdict: Verdict::Unexplained,
            chosen: 0,
            remainder: String::new(),
            spread: None,
            pair: None,
            chain: None,
            best_two: None,
        }
    }
}

/// What is told of two hypotheses: the two, what the data cannot tell from one of them beside the other, and the others alone.
fn beside_each_other(
    pair: &Pair,
    odds: &Odds<'_>,
    p: &Probabilities,
    alone: Vec<HypothesisResult>,
) -> Result<Vec<HypothesisResult>, DiagnosisError> {
    let tell = |stage: &Stage, list: &[Refit]| -> Result<Vec<HypothesisResult>, DiagnosisError> {
        let held_before = held_out_in_all(&stage.fit, stage.weight)?;
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
            result(stage, r, odds.of(r), held_before, (own + p.several() * pair.share(&ids[k])).min(1.0), others)
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

/// What is told of a chain: the first is one of those that are wrong. What was found on top of it is not sought again beside the others, so
/// that it is no more probable than alone.
fn first_of_several(p: &Probabilities, mut alone: Vec<HypothesisResult>) -> Vec<HypothesisResult> {
    if let Some(first) = alone.first_mut() {
        first.probability = (first.probability + p.several()).min(1.0);
    }
    alone
}

/// What several hypotheses of the catalogue say together, if any were looked at.
fn together_of(
    base: &Stage,
    p: &Probabilities,
    odds: &Odds<'_>,
    (pair, chain): (Option<&Pair>, Option<&Chain>),
    best_two: Option<&([String; 2], f64)>,
) -> Option<Together> {
    if p.ln_several() == f64::NEG_INFINITY {
        return None;
    }
    let members: Vec<&Refit> = match (pair, chain) {
        (Some(pair), _) => std::iter::once(&pair.first).chain(pair.seconds.first()).collect(),
        (None, Some(chain)) => chain.members.iter().map(|m| &m.1).collect(),
        (None, None) => Vec::new(),
    };
    let ln_odds =
        if members.is_empty() { 2.0 * odds.of_something_else() } else { members.iter().map(|r| odds.of(r)).sum() };
    Some(Together {
        ids: chain.map_or_else(|| members.iter().map(|r| r.id(&base.scene)).collect(), Chain::ids),
        probability: p.several(),
        ln_odds,
        ln_bayes: p.ln_several() - ln_odds,
        misfit_after: members.last().map(|r| r.misfit).or(best_two.map(|(_, misfit)| *misfit)),
        best: best_two.map_or_else(Vec::new, |(ids, _)| ids.to_vec()),
    })
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

/// One hypothesis is named.
///
/// * `chosen` - its rank
fn named(chosen: usize, r: &Refit) -> Answer {
    let verdict = match r.tried {
        Tried::Effect(_) => Verdict::MissingEffect,
        Tried::Fault(_) => Verdict::MeasurementFault,
    };
    Answer { verdict, chosen, ..Answer::default() }
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
    let may_be_named = p.other() < 0.5;
    // What imitates something else fits the modes it was fitted to; the others it predicts worse than the base does.
    let predicts = |r: &Refit| r.held_out < otherwise.held_before;
    for &i in tied.iter().take(if may_be_named { settings.effort.checked } else { 1 }) {
        let (found, stage) = remains(base, &refits[i], settings)?;
        // What needs a mode that the test has missed is not put before what is more probable.
        let is_believed = found.passes && (refits[i].missed == 0 || i == tied[0]);
        if is_believed && may_be_named {
            let answer = named(i, &refits[i]);
            if answer.verdict == Verdict::MeasurementFault || predicts(&refits[i]) {
                return Ok(answer);
            }
            doubted.get_or_insert(answer);
        }
        failed.push((i, found));
        on_first.get_or_insert(stage);
    }
    let (Some((chosen, found)), Some(on_first)) = (failed.first(), on_first) else { return Ok(Answer::default()) };
    let (chosen, odds) = (*chosen, otherwise.odds);
    let more = beside(&on_first, &refits[chosen])?;
    // An alarm of slopes that no fit confirms is one of their nonlinearity.
    if may_be_named && found.looks_like_noise && more.iter().all(|r| r.ln_bayes <= STRONG) {
        let answer = named(chosen, &refits[chosen]);
        if answer.verdict == Verdict::MeasurementFault || predicts(&refits[chosen]) {
            return Ok(answer);
        }
        doubted.get_or_insert(answer);
    }
    let weight = |r: &Refit| odds.weight(r);
    let ln_of =
        |(first, _, more): &WithFirst| weight(first) + more.iter().map(weight).fold(f64::NEG_INFINITY, f64::max);
    let mut two = (refits[chosen].clone(), on_first, more);
    two = fault_first(base, refits, &two.0, odds, ln_of(&two), settings)?.unwrap_or(two);
    let bases: Vec<_> = spread::best(otherwise.spreads).map(|s| s.base.clone()).into_iter().collect();
    let (first, on_first, more) = together(base, &bases, odds, ln_of(&two), settings)?.unwrap_or(two);
    let best = more.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes));
    let mut best_two = best.map(|r| ([first.id(&base.scene), r.id(&base.scene)], r.misfit));
    if best.is_some_and(|r| r.ln_bayes > STRONG && on_first.p_value < settings.alarm_level && predicts(r)) {
        // Two of some hundreds imitate much: they have to be more probable than something else, and than one that may stand alone, and
        // what they leave has to pass the same tests as what one leaves.
        let least = if doubted.is_some() { otherwise.ln.max(weight(&refits[chosen])) } else { otherwise.ln };
        let ln_two = weight(&first) + odds.of_a_second(&more);
        let two = pair(base, refits, first, (on_first, more), odds, settings)?;
        let is_probable = two.as_ref().is_some_and(|two| two.ln_all > least && predicts(&two.seconds[0]));
        let leaves_noise = match two.as_ref().filter(|_| is_probable) {
            Some(two) => remains(&two.on_first, &two.seconds[0], settings)?.0.needs_nothing_more(),
            None => false,
        };
        // Of two of which one brings nothing beside the other, that one suffices, but for slopes of a second screening, which no fit confirms.
        let of_alone = |r: &Refit| refits.iter().position(|known| known.id(&base.scene) == r.id(&base.scene));
        let alone = two.as_ref().and_then(Pair::alone).and_then(of_alone);
        if let Some(alone) = alone.filter(|_| leaves_noise)
            && remains(base, &refits[alone], settings)?.0.looks_like_noise
        {
            return Ok(named(alone, &refits[alone]));
        }
        if leaves_noise
            && alone.is_none()
            && let Some(two) = two
        {
            p.with_several(two.ln_all);
            let ids = [two.first.id(&base.scene), two.seconds[0].id(&base.scene)];
            let remainder = format!("beside {}: {}", ids[0], ids[1]);
            return Ok(Answer { verdict: Verdict::SeveralEffects, remainder, pair: Some(two), ..Answer::default() });
        }
        if let Some((a, b)) = two.as_ref().and_then(|two| Some((&two.first, two.seconds.first()?))) {
            best_two = Some(([a.id(&base.scene), b.id(&base.scene)], b.misfit));
        }
        if doubted.is_none() && alone.is_none() {
            p.with_several(ln_two);
            let found = two.map(|two| longer((base, refits), two, odds, otherwise.ln, settings)).transpose()?.flatten();
            if let Some(found) = found {
                p.with_several(found.ln_all);
                return Ok(Answer { verdict: Verdict::SeveralEffects, chain: Some(found), ..Answer::default() });
            }
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
        let q = r.fit.basis()?;
        p.doubt(i, left, something_else(&project(&q, &r.fit.r), degrees_of_freedom(&r.fit, &q)));
    }
    let spread = otherwise.spread(&refits[chosen]);
    let place = if found.passes { place_of(&base.scene, &base.fit, &base.q) } else { found.text.clone() };
    let remainder = spread.map_or_else(|| place.clone(), |spread| format!("{spread}; {place}"));
    Ok(Answer { chosen, remainder, spread: spread.cloned(), best_two, ..Answer::default() })
}

/// What is wrong beside a hypothesis. A fault of the measurement is no image of what else is wrong: where the screening does not tell that, the search
/// begins anew.
fn beside(on_first: &Stage, first: &Refit) -> Result<Vec<Refit>, DiagnosisError> {
    let more = refit(on_first, true)?.hypotheses;
    if matches!(first.tried, Tried::Effect(_)) {
        return Ok(more);
    }
    let is_explained = leaving_noise(more.iter().filter(|r| r.ln_bayes > STRONG))?.is_some();
    if is_explained { Ok(more) } else { Ok(refit(on_first, false)?.hypotheses) }
}

/// A chain that goes on from two hypotheses that do not suffice, where these take away much: else they are images of what is spread. With noise that is
/// not believable three explain anything.
fn longer(
    (base, alone): (&Stage, &[Refit]),
    two: Pair,
    odds: &Odds<'_>,
    ln_else: f64,
    settings: &Settings,
) -> Result<Option<Chain>, DiagnosisError> {
    let Pair { first, on_first, seconds, .. } = two;
    let Some(second) = seconds.into_iter().next() else { return Ok(None) };
    let excess = base.fit.misfit - degrees_of_freedom(&base.fit, &base.q) / (base.weight * base.weight);
    if base.fit.misfit - second.misfit < WORTH_A_TRY * excess || base.noise_factor() > MOST_NOISE {
        return Ok(None);
    }
    chain(vec![(base.clone(), first), (on_first, second)], alone, odds, ln_else, settings)
}

/// Whether a hypothesis that leaves noise explains the test better than noise s2 times as large as stated does:
///
/// ```text
/// ln B(s2) = ½ χ² (1 - 1/s2) - ½ n ln s2 - ½ ln n      for n degrees of freedom, with the prior odds of "nothing is missing"
///                                                        and those of noise that is so much larger
/// ```
pub(crate) fn better_than_noise(base: &Stage, refits: &[Refit]) -> Result<bool, DiagnosisError> {
    let (n, s2) = (degrees_of_freedom(&base.fit, &base.q).max(1.0), base.scatter.s2);
    let chi2 = base.residual.norm_squared();
    let odds_of_noise = ln_odds_of_none() + ln_odds_of_noise(s2.sqrt());
    let noise = odds_of_noise + 0.5 * (chi2 * (1.0 - 1.0 / s2) - n * s2.ln() - n.ln());
    let odds = Odds::new(base);
    Ok(leaving_noise(refits.iter().filter(|r| odds.weight(r) > noise))?.is_some())
}

/// The result of one refitted hypothesis, ties and probability to be filled in.
fn result(
    base: &Stage,
    r: &Refit,
    ln_odds: f64,
    held_out_before: f64,
    probability: f64,
    tied: Vec<String>,
) -> HypothesisResult {
    let (kind, location, patch) = match &r.tried {
        Tried::Effect(c) => (Kind::Effect, c.location.to_string(), c.patch.to_yaml()),
        Tried::Fault(f) => (Kind::Fault, f.location(&base.scene), f.remedy(&base.scene)),
    };
    let first = r.estimates.first();
    HypothesisResult {
        id: r.id(&base.scene),
        kind,
        name: r.name().to_string(),
        location,
        probability,
        ln_odds,
        ln_bayes: r.ln_bayes,
        misfit_before: base.fit.misfit,
        misfit_after: r.misfit,
        estimate: first.map(|e| e.value),
        interval: first.map(|e| e.interval),
        unit: first.map(|e| e.unit.clone()),
        estimates: r.estimates.clone(),
        held_out_before,
        held_out_after: r.held_out,
        tied_with: tied,
        limit_of: r.limit_of.clone(),
        patch,
    }
}
