//! From evidences to probabilities, ties and a verdict.
//!
//! * Prior odds: half for "nothing is missing"; the other half in equal shares for every kind that could have been seen
//!   and for "something else", and inside a kind in equal shares for its places.
//! * Alarm: the calibrated p-value below the level, or a measured mode without partner.
//! * A verdict follows the probabilities: with "nothing" more probable than all else together nothing is named, with
//!   "something else" more probable than all else together the verdict is `unexplained`.
//! * A hypothesis is believed when its ln Bayes factor is above 3 *and* what remains looks like noise: goodness of fit, a
//!   second screening and neighbouring sensors, at a level of 0.01 for the three together, and no mode without partner. Among
//!   tied hypotheses the most probable one that passes is taken.
//! * Else a second hypothesis is sought on top of the best; with a gain above 3 and noise as remainder the verdict is
//!   `several-effects`, else `unexplained`.
//! * Stated probabilities obey the tests: "nothing" is not less probable than the p-value of the alarm allows, and what a
//!   hypothesis leaves that does not look like noise speaks for "something else", see [`most_against`].

use super::base::{Stage, stage};
use super::evidence::{EACH_REMAINDER, REMAINDER, degrees_of_freedom, goodness_of_fit, held_out, something_else};
use super::fit::Fit;
use super::mesh::{mesh_errors, modes};
use super::next_measurement::next_measurements;
use super::noise::{DRAWS, whiteness};
use super::refit::{Refit, Tried, refit};
use super::scene::{Case, Scene};
use super::screen::project;
use super::{Diagnosis, DiagnosisError, HypothesisResult, Settings, Verdict, result};
use crate::linalg::DMatrix;
use std::collections::BTreeMap;

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
    second: Stage,
}

impl Remainder {
    /// What is smaller than the stated noise needs no explanation, though a third effect may still be seen in it.
    fn needs_nothing_more(&self) -> bool {
        self.passes || self.is_small
    }
}

pub(super) fn conclude(
    base: &Stage,
    refits: &mut Vec<Refit>,
    settings: &Settings,
) -> Result<Diagnosis, DiagnosisError> {
    let dof = degrees_of_freedom(&base.fit, &base.q);
    let other = something_else(&base.residual, dof);
    let (p_none, mut p_other, probabilities) = probabilities(base, refits, other);
    let mut order: Vec<usize> = (0..refits.len()).collect();
    order.sort_by(|&a, &b| probabilities[b].total_cmp(&probabilities[a]).then(a.cmp(&b)));
    let sorted: Vec<Refit> = order.iter().map(|&i| refits[i].clone()).collect();
    let mut sorted_p: Vec<f64> = order.iter().map(|&i| probabilities[i]).collect();
    let leads = sorted_p.first().is_some_and(|p| *p > 0.5);
    *refits = sorted;
    let best_bayes = refits.iter().map(|r| r.ln_bayes).fold(f64::NEG_INFINITY, f64::max);
    let tied: Vec<usize> =
        (0..refits.len()).filter(|&i| refits[i].ln_bayes > best_bayes - STRONG && refits[i].ln_bayes > 0.0).collect();

    let fits = goodness_of_fit(&base.fit, &base.q);
    let white = whiteness(&base.scene, &base.fit, &base.q, settings.seed.wrapping_add(2));
    let looks_like_noise = is_noise(fits, white) && base.fit.unpaired.is_empty();
    // The level is shared with the tests of the remainder, which raise an alarm too.
    let alarm = base.p_value < settings.alarm_level - REMAINDER || !base.fit.unpaired.is_empty();
    let strong = best_bayes > STRONG && p_none < 0.5;
    let mut remainder = String::new();
    let mut chosen = 0;
    let verdict = if looks_like_noise && !(alarm && strong) {
        Verdict::Adequate
    } else if !alarm || !strong || p_other > 0.5 {
        remainder = place_of(&base.scene, &base.fit, &base.q);
        Verdict::Unexplained
    } else {
        let mut first: Option<Remainder> = None;
        let mut believed = None;
        let mut failed: Vec<(usize, f64)> = Vec::new();
        for &i in tied.iter().take(CHECKED) {
            let found = remains(base, &refits[i], settings)?;
            if found.passes {
                believed = Some(i);
                break;
            }
            failed.push((i, found.p_value));
            if first.is_none() {
                chosen = i;
                first = Some(found);
            }
        }
        match (believed, first) {
            (Some(i), _) => {
                chosen = i;
                match refits[i].tried {
                    Tried::Effect(_) => Verdict::MissingEffect,
                    Tried::Fault(_) => Verdict::MeasurementFault,
                }
            }
            (None, Some(found)) => {
                let more = refit(&found.second, true)?;
                let best = more.iter().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes));
                let is_clear = |r: &&Refit| r.ln_bayes > STRONG && found.second.p_value < settings.alarm_level;
                match best.filter(is_clear) {
                    // Two of some hundreds imitate much: what they leave has to pass the same tests as what one leaves.
                    Some(second) if remains(&found.second, second, settings)?.needs_nothing_more() => {
                        remainder =
                            format!("beside {}: {}", refits[chosen].id(&base.scene), second.id(&found.second.scene));
                        Verdict::SeveralEffects
                    }
                    _ => {
                        remainder = found.text;
                        // It may be there beside something else, or be its image: even odds.
                        for (i, r) in refits.iter().enumerate() {
                            let p = match failed.iter().find(|f| f.0 == i) {
                                Some(f) => f.1,
                                None => r.p_value()?,
                            };
                            let lost = 0.5 * sorted_p[i] * (1.0 - most_against(p));
                            sorted_p[i] -= lost;
                            p_other += lost;
                        }
                        Verdict::Unexplained
                    }
                }
            }
            (None, None) => Verdict::Unexplained,
        }
    };
    if chosen > 0 {
        // The hypothesis that leaves noise stands first, also where another is a little more probable and does not.
        refits[..=chosen].rotate_right(1);
        sorted_p[..=chosen].rotate_right(1);
    }
    let held_before: f64 = held_out(&base.fit, base.weight)?.iter().sum();
    let tied_ids = |i: usize| -> Vec<String> {
        let is_tied = |r: &Refit| r.ln_bayes > best_bayes - STRONG && r.ln_bayes > 0.0;
        if !is_tied(&refits[i]) {
            return Vec::new();
        }
        (0..refits.len()).filter(|&k| k != i && is_tied(&refits[k])).map(|k| refits[k].id(&base.scene)).collect()
    };
    let hypotheses: Vec<HypothesisResult> =
        (0..refits.len()).map(|i| result(base, &refits[i], held_before, sorted_p[i], tied_ids(i))).collect();
    let next = if alarm && strong && verdict != Verdict::Adequate {
        next_measurements(base, refits, best_bayes - STRONG)?
    } else {
        Vec::new()
    };
    Ok(Diagnosis {
        verdict,
        sentence: sentence(verdict, hypotheses.first(), leads, base, &remainder),
        p_value: base.p_value,
        noise_factor: base.noise_factor(),
        misfit: base.fit.misfit,
        degrees_of_freedom: dof,
        screened_effects: base.screened.len(),
        visible_effects: base.effects.len(),
        screened_faults: base.faults.len(),
        probability_none: p_none,
        probability_other: p_other,
        hypotheses,
        next_measurements: next,
        unpaired_modes: base.fit.unpaired.iter().map(|m| m + 1).collect(),
        remainder,
        warnings: warnings(base),
    })
}

/// ln of the prior odds of every hypothesis of a kind, and of "something else".
struct Odds<'a> {
    places: BTreeMap<&'a str, usize>,
}

impl<'a> Odds<'a> {
    /// Places of every kind that could have been seen.
    fn new(base: &'a Stage) -> Self {
        let mut places: BTreeMap<&str, usize> = BTreeMap::new();
        for s in &base.effects {
            *places.entry(base.screened[s.index].candidate.effect.name()).or_default() += 1;
        }
        for f in &base.fault_scores {
            *places.entry(base.faults[f.index].name()).or_default() += 1;
        }
        Self { places }
    }

    fn of_something_else(&self) -> f64 {
        0.5_f64.ln() - ((self.places.len() + 1) as f64).ln()
    }

    fn of(&self, name: &str) -> f64 {
        self.of_something_else() - (self.places.get(name).copied().unwrap_or(1).max(1) as f64).ln()
    }
}

/// Probabilities of "none", of "something else" and of every refitted hypothesis.
fn probabilities(base: &Stage, refits: &[Refit], other: f64) -> (f64, f64, Vec<f64>) {
    let odds = Odds::new(base);
    let mut ln = vec![0.5_f64.ln(), odds.of_something_else() + other];
    ln.extend(refits.iter().map(|r| odds.of(r.name()) + r.ln_bayes));
    let top = ln.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = ln.iter().map(|l| (l - top).exp()).collect();
    let rest: f64 = weights[1..].iter().sum();
    // A p-value without a draw beyond the observed one is only a bound of itself.
    let least = if base.p_value > 1.0 / DRAWS as f64 { most_against(base.p_value) } else { 0.0 };
    let none = weights[0].max(least * rest);
    let sum = none + rest;
    (none / sum, weights[1] / sum, weights[2..].iter().map(|w| w / sum).collect())
}

/// The smallest Bayes factor, for over against, that a p-value of a hypothesis can mean, whatever the alternative:
///
/// ```text
/// B(p) = -e p ln p   for p < 1/e, else 1
/// ```
///
/// # Source
/// T. Sellke, M. J. Bayarri, J. O. Berger, Calibration of p values for testing precise null hypotheses, The American Statistician
/// 55 (2001) 62-71.
fn most_against(p: f64) -> f64 {
    if p < 1.0 / std::f64::consts::E { -std::f64::consts::E * p * p.max(f64::MIN_POSITIVE).ln() } else { 1.0 }
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
    for r in refits.iter().filter(|r| odds.of(r.name()) + r.ln_bayes > noise) {
        if r.leaves_noise()? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Whether a remainder looks like noise. Below the median of what noise alone gives, how neighbours go together says nothing:
/// what is smaller than the stated noise needs no explanation.
fn is_noise(fits: f64, white: f64) -> bool {
    fits > 0.5 || (fits > EACH_REMAINDER && white > EACH_REMAINDER)
}

/// Screens again with a hypothesis in the base.
fn remains(base: &Stage, r: &Refit, settings: &Settings) -> Result<Remainder, DiagnosisError> {
    let second = stage(r.scene.clone(), std::slice::from_ref(&r.fit.x), base.weight, settings)?;
    let fits = goodness_of_fit(&second.fit, &second.q);
    let white = whiteness(&second.scene, &second.fit, &second.q, settings.seed.wrapping_add(2));
    let passes = is_noise(fits, white) && second.p_value > EACH_REMAINDER && second.fit.unpaired.is_empty();
    // The smallest of three.
    let p_value =
        if second.fit.unpaired.is_empty() { (3.0 * fits.min(white).min(second.p_value)).min(1.0) } else { 0.0 };
    let text = if passes { String::new() } else { place_of(&second.scene, &second.fit, &second.q) };
    let is_small = fits > 0.5 && second.fit.unpaired.is_empty();
    Ok(Remainder { passes, is_small, p_value, text, second })
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
    let ties = best.map_or(0, |b| b.tied_with.len());
    let tie = if ties > 0 {
        format!("; {ties} other{} cannot be told from it", if ties > 1 { "s" } else { "" })
    } else {
        String::new()
    };
    match verdict {
        Verdict::Adequate if base.noise_factor() > 1.0 => {
            format!("the model explains the test if its noise is {:.2} times the stated one", base.noise_factor())
        }
        Verdict::Adequate => "the model explains the test at its stated noise".to_string(),
        Verdict::MissingEffect => format!("{id} is missing, and what remains looks like noise{tie}"),
        Verdict::MeasurementFault => format!("{id}: the measurement, not the model{tie}"),
        Verdict::SeveralEffects => format!("{id} is missing and does not suffice; {remainder}"),
        Verdict::Unexplained => match best.filter(|b| b.ln_bayes > STRONG && leads) {
            Some(b) => format!(
                "{id} takes the misfit from {} to {} and what remains is in nothing of the catalogue; {remainder}",
                number(b.misfit_before),
                number(b.misfit_after)
            ),
            None => format!("nothing in the catalogue explains the test; {remainder}"),
        },
    }
}

/// To three digits.
fn number(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1.0).log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// Modes whose frequency the mesh falsifies by more than a third of its standard deviation.
fn mesh_warning(base: &Stage) -> Option<String> {
    let bad: Vec<String> = base.scene.cases.iter().filter_map(|case| falsified(base, case).ok()).flatten().collect();
    (!bad.is_empty())
        .then(|| format!("the mesh is too coarse, frequencies are too high: {}; subdivide the beams", bad.join(", ")))
}

/// Those of one test, in words.
fn falsified(base: &Stage, case: &Case) -> Result<Vec<String>, DiagnosisError> {
    let n = case.modes().len();
    let errors = mesh_errors(&case.model, &base.fit.theta, 2 * n)?;
    let frequencies = modes(&case.model, &base.fit.theta, 2 * n)?;
    let hz: Vec<f64> = frequencies.elastic().map(|i| frequencies.frequency_hz(i)).collect();
    let in_words = |m: usize| {
        let partner = (0..hz.len()).min_by(|&a, &b| {
            let d = |i: usize| (hz[i] - base.fit.frequencies[m]).abs();
            d(a).total_cmp(&d(b))
        })?;
        let measured = &base.scene.test.modes[m].frequency_hz;
        let error = *errors.get(partner)?;
        let name = base.scene.mode_name(m);
        (error > measured.sd / measured.value / 3.0).then(|| format!("{name} by {:.2} %", 100.0 * error))
    };
    Ok(case.modes().filter_map(in_words).collect())
}

fn warnings(base: &Stage) -> Vec<String> {
    let mut out = Vec::new();
    if !base.fit.rows.has_shapes {
        out.push(
            "frequencies alone rarely tell which effect is missing; measure shapes or frequency responses".to_string(),
        );
    }
    if base.noise_factor() > 1.0 {
        out.push(format!("the scatter is {:.2} times the stated standard deviations", base.noise_factor()));
    }
    if base.scene.cases.iter().any(|c| c.test.frfs.is_some() && c.test.frf_fit.is_none()) {
        out.push("frequency responses are not used: the test has no `frfs` block that says how".to_string());
    }
    if !base.scene.is_damped && base.scene.test.modes.iter().any(|m| m.damping_ratio.is_some()) {
        out.push("damping ratios are not used: the model has no damping".to_string());
    }
    out.extend(mesh_warning(base));
    let bounds = base.fit.x.iter().filter(|x| **x < 1e-6 || **x > 1.0 - 1e-6).count();
    if bounds > 0 {
        out.push(format!("{bounds} parameters of the fitted base sit on a bound"));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::most_against;

    /// Table 1 of Sellke, Bayarri and Berger (2001).
    #[test]
    fn p_values_speak_as_published() {
        for (p, bayes) in [(0.1, 0.625), (0.05, 0.407), (0.01, 0.125), (0.005, 0.072), (0.001, 0.0188)] {
            assert!((most_against(p) / bayes - 1.0).abs() < 5e-3, "{p}: {}", most_against(p));
        }
        assert_eq!((most_against(0.0), most_against(0.5), most_against(1.0)), (0.0, 1.0, 1.0));
    }
}
