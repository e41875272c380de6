//! What a diagnosis or a history of learning found, in the report's terms.

use super::super::data::{
    Category, DampedMode, Damping, Diagnosis, Estimate, Hypothesis, Level, Measurement, Outcome, Step, Steps, Verdict,
};
use super::super::text::number;
use super::structure::Places;
use retune::correlation::odds;
use retune::data::TestData;
use retune::effect::Effects;
use retune::model::{Model, ParametricModel};
use retune_diagnosis::{HypothesisResult, Kind};
use serde::{Deserialize, Serialize};

/// The measure of [`diagnosis`], in words.
pub(super) const MEASURE: &str =
    "sum of ((model - test)/standard deviation)²; held out: every mode predicted from the others";

/// Parts of a spread that are listed with their factors.
const LISTED: usize = 10;

/// A diagnosis in the report's terms.
///
/// Places are looked up by name in `model`; what it does not have has no place.
pub fn diagnosis(found: &retune_diagnosis::Diagnosis, model: &Model, test: &TestData) -> Diagnosis {
    let places = Places::new(model, test);
    let effects = Effects::builtin();
    let mut hypotheses: Vec<Hypothesis> =
        found.hypotheses.iter().map(|h| hypothesis(h, found, &places, &effects)).collect();
    let rest = |category: Category, id: &str, kind: &str, summary: &str, probability: f64| Hypothesis {
        id: id.into(),
        category,
        kind: kind.into(),
        summary: summary.into(),
        probability: Some(probability),
        misfit_before: Some(found.misfit),
        held_out_before: Some(found.held_out),
        ..Hypothesis::default()
    };
    hypotheses.push(rest(
        Category::None,
        "none",
        "nothing is missing",
        "The model is complete, and its misfit is chance.",
        found.probability_none,
    ));
    if let Some(none) = hypotheses.last_mut() {
        none.log_bayes_factor = Some(found.ln_bayes_none);
        if found.noise_factor > 1.0 {
            none.kind = format!("nothing is missing, with noise {:.1} times as large as stated", found.noise_factor);
        }
    }
    // A search that was stopped has not asked the whole catalogue.
    let [kind, summary] = if found.is_partial {
        [
            "something that was not tried",
            "Something that was not tried by then, of the catalogue or outside it, alone or beside one of these hypotheses.",
        ]
    } else {
        [
            "something outside the catalogue",
            "Something that the catalogue does not have, alone or beside one of these hypotheses.",
        ]
    };
    let mut other = rest(Category::Other, "other", kind, summary, found.probability_other);
    other.log_bayes_factor = Some(found.ln_bayes_other);
    if let Some(spread) = &found.spread {
        let what: Vec<String> = spread.properties().iter().map(ToString::to_string).collect();
        other.kind = format!("no single effect: {} of many parts", what.join(" and "));
        other.summary = sentence(&spread.to_string());
        other.misfit_after = Some(spread.misfit);
        let mut parts: Vec<&str> = spread.clear().map(|f| f.part.as_str()).collect();
        parts.sort_unstable();
        parts.dedup();
        other.place = places.on_structure(&parts.join("+"));
        other.estimates = spread
            .clear()
            .take(LISTED)
            .map(|f| Estimate {
                quantity: format!("factor on the {} of {}", f.property, f.part),
                value: f.factor,
                unit: String::new(),
                interval: Some(f.interval),
                interval_label: "90 %".into(),
            })
            .collect();
    }
    let remainder_place = found.spread.is_some().then(|| other.place.clone());
    hypotheses.push(other);
    if let Some(all) = &found.together {
        let (kind, summary) = match (all.ids.as_slice(), all.best.as_slice()) {
            ([], []) => ("several of the catalogue together".to_string(), "Two or more of these hypotheses at once."),
            ([], best) => {
                (format!("several together, best {}", best.join(" + ")), "Two or more of these hypotheses at once.")
            }
            (ids, _) => (format!("{} together", ids.join(" + ")), "All of these, at once."),
        };
        let mut together = rest(Category::Other, "together", &kind, summary, all.probability);
        together.log_bayes_factor = Some(all.ln_bayes);
        together.misfit_after = all.misfit_after;
        hypotheses.push(together);
    }
    // The hypothesis that the verdict is about stays first, even where a tied one is a little more probable.
    // Of two both, of more the first.
    let n_named = if found.together.as_ref().is_some_and(|t| t.ids.len() == 2) { 2 } else { 1 };
    let split = if found.verdict.names_hypotheses() { n_named.min(found.hypotheses.len()) } else { 0 };
    hypotheses[split..].sort_by(|a, b| b.probability.unwrap_or(0.0).total_cmp(&a.probability.unwrap_or(0.0)));
    let tied: Vec<String> = found
        .hypotheses
        .first()
        .filter(|h| !h.tied_with.is_empty())
        .map(|h| std::iter::once(h.id.clone()).chain(h.tied_with.iter().cloned()).collect())
        .unwrap_or_default();
    let next_measurements = found
        .next_measurements
        .iter()
        .map(|m| Measurement {
            what: m.what.clone(),
            why: String::new(),
            separates: tied.clone(),
            expected_log_bayes_factor: Some(m.expected_ln_bayes),
            place: (!m.place.is_empty()).then(|| places.on_structure(&m.place)),
        })
        .collect();
    Diagnosis {
        title: String::new(),
        outcome: outcome(found),
        sentence: found.sentence.clone(),
        p_value: Some(found.p_value),
        alarm_level: None,
        screened: Some((found.screened_effects + found.screened_faults) as u64),
        tried: format!(
            "{} effects in their places, {} of them with a trace in these data; {} faults of the measurement",
            found.screened_effects, found.visible_effects, found.screened_faults
        ),
        misfit: Some(found.misfit),
        degrees_of_freedom: Some(found.degrees_of_freedom),
        noise_factor: Some(found.noise_factor),
        hypotheses,
        next_measurements,
        remainder: found.remainder.clone(),
        remainder_place,
        damping: found.damping.as_ref().map(|d| damping(d, &places)),
        warnings: found.warnings.clone(),
    }
}

/// Laws of damping as hypotheses on the structure.
fn damping(found: &retune_diagnosis::DampingReading, places: &Places<'_>) -> Damping {
    let estimate = |t: &retune_diagnosis::DampingTerm| {
        let is_ratio = t.is_ratio();
        Estimate {
            quantity: match t.alike.as_slice() {
                _ if is_ratio => "ratio of all modes".into(),
                [] => t.id.clone(),
                [other] => format!("{} (or {other})", t.id),
                [other, rest @ ..] => format!("{} (or {other}, or {} more)", t.id, rest.len()),
            },
            value: if is_ratio { 100.0 * t.value } else { t.value },
            unit: if is_ratio { "%".into() } else { t.unit.clone() },
            interval: Some(if is_ratio { t.interval.map(|v| 100.0 * v) } else { t.interval }),
            interval_label: "90 %".into(),
        }
    };
    let law = |law: &retune_diagnosis::DampingLaw| {
        let at: Vec<&str> = law.terms.iter().filter_map(|t| t.id.split_once('@')).map(|(_, place)| place).collect();
        Hypothesis {
            id: law.id.clone(),
            kind: law.id.clone(),
            place: places.on_structure(&at.join("+")),
            probability: Some(law.probability),
            log_bayes_factor: Some(law.ln_bayes),
            misfit_after: Some(law.misfit),
            estimates: law.terms.iter().map(estimate).collect(),
            ..Hypothesis::default()
        }
    };
    let mode = |m: &retune_diagnosis::DampedMode| DampedMode {
        mode: m.mode as u64,
        frequency_hz: m.frequency_hz,
        ratio: m.ratio,
        sd: m.sd,
        by_law: m.by_law,
    };
    Damping {
        sentence: sentence(&found.sentence),
        laws: found.laws.iter().map(law).collect(),
        modes: found.modes.iter().map(mode).collect(),
    }
}

fn outcome(found: &retune_diagnosis::Diagnosis) -> Outcome {
    use retune_diagnosis::Verdict;
    let is_tied = found.hypotheses.first().is_some_and(|h| !h.tied_with.is_empty());
    match found.verdict {
        Verdict::Adequate => Outcome::Adequate,
        Verdict::MissingEffect | Verdict::MeasurementFault if is_tied => Outcome::Tied,
        Verdict::MissingEffect => Outcome::MissingEffect,
        Verdict::MeasurementFault => Outcome::MeasurementFault,
        Verdict::SeveralEffects => Outcome::SeveralEffects,
        Verdict::Unexplained => Outcome::Unexplained,
        Verdict::NoiseOrModel => Outcome::NoiseOrModel,
    }
}

fn hypothesis(
    h: &HypothesisResult,
    found: &retune_diagnosis::Diagnosis,
    places: &Places<'_>,
    effects: &Effects,
) -> Hypothesis {
    let (category, place, summary) = match h.kind {
        Kind::Effect => {
            let about = effects.find(&h.name).map_or("", |e| e.about().summary);
            (Category::Effect, places.on_structure(&h.location), about.to_string())
        }
        Kind::Fault => (Category::Measurement, places.on_test(&h.location), sentence(&h.patch)),
    };
    let estimate = |e: &retune_diagnosis::Estimate| Estimate {
        quantity: e.parameter.rsplit('.').next().unwrap_or_default().replace('_', " "),
        value: e.value,
        unit: if e.unit == "1" { String::new() } else { e.unit.clone() },
        interval: Some(e.interval),
        interval_label: "90 %".into(),
    };
    let (evidence_for, evidence_against) = evidence(h, found);
    Hypothesis {
        id: h.id.clone(),
        category,
        kind: h.name.clone(),
        summary,
        place,
        probability: Some(h.probability),
        log_bayes_factor: Some(h.ln_bayes),
        misfit_before: Some(h.misfit_before),
        misfit_after: Some(h.misfit_after),
        held_out_before: Some(h.held_out_before),
        held_out_after: Some(h.held_out_after),
        estimates: h.estimates.iter().map(estimate).collect(),
        tied_with: h.tied_with.clone(),
        evidence_for,
        evidence_against,
        patch: h.patch.clone(),
    }
}

/// Words that begin small, such as a remedy or an error, as a sentence.
pub(crate) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    // Names that somebody types keep their case.
    let is_name = text.split_whitespace().next().is_some_and(|w| w.contains('@'));
    match letters.next() {
        Some(c) if !is_name => c.to_uppercase().collect::<String>() + letters.as_str() + ".",
        Some(_) => format!("{text}."),
        None => String::new(),
    }
}

/// What the numbers say, for and against.
///
/// The words for Bayes factors are those of R. E. Kass, A. E. Raftery, Bayes factors, Journal of the American Statistical
/// Association 90 (1995) 773-795: ln B above 1 positive, above 3 strong, above 5 very strong.
fn evidence(h: &HypothesisResult, found: &retune_diagnosis::Diagnosis) -> (Vec<String>, Vec<String>) {
    let (mut pro, mut con) = (Vec::new(), Vec::new());
    let dof = found.degrees_of_freedom;
    let excess = h.misfit_before - dof;
    if h.misfit_after < h.misfit_before && excess > 0.0 {
        let share = (100.0 * (h.misfit_before - h.misfit_after) / excess).min(100.0);
        pro.push(format!(
            "the misfit falls from {} to {}: {share:.0} % of what noise does not explain",
            number(h.misfit_before),
            number(h.misfit_after)
        ));
    }
    if h.ln_bayes > 1.0 {
        let word = if h.ln_bayes > 5.0 {
            "very strong"
        } else if h.ln_bayes > 3.0 {
            "strong"
        } else {
            "positive"
        };
        pro.push(format!("{word} evidence against the model as it is: ln Bayes factor {:.1}", h.ln_bayes));
    } else {
        con.push(format!(
            "it explains no more than its own freedom could by chance: ln Bayes factor {:.1}",
            h.ln_bayes
        ));
    }
    let held = format!("from {} to {}", number(h.held_out_before), number(h.held_out_after));
    if h.held_out_after < h.held_out_before {
        pro.push(format!("modes that the fit did not see are predicted better: squared error {held}"));
    } else {
        con.push(format!("modes that the fit did not see are predicted no better: squared error {held}"));
    }
    // Three standard deviations of chi-squared above its mean.
    if h.misfit_after > dof + 3.0 * (2.0 * dof.max(0.0)).sqrt() {
        con.push(format!("it leaves {}, where noise alone would leave about {}", number(h.misfit_after), number(dof)));
    }
    if let Some(e) = h.estimates.iter().find(|e| e.interval[0] <= 0.0 && e.interval[1] >= 0.0) {
        con.push(format!(
            "the 90 % interval of its {} includes zero",
            e.parameter.rsplit('.').next().unwrap_or_default()
        ));
    }
    match h.tied_with.len() {
        0 => {}
        1 => con.push(format!("the data cannot tell it from {}", h.tied_with[0])),
        n => con.push(format!("the data cannot tell it from {n} others")),
    }
    (pro, con)
}

/// A step of learning as a file keeps it; what `retune learn --json` writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearningStep {
    /// Σ ((model - test)/σ)² after the fit.
    pub misfit: f64,
    /// The same per mode.
    pub misfit_per_mode: Vec<f64>,
    /// Squared error of every mode predicted from the others.
    pub held_out_per_mode: Vec<f64>,
    /// Id of the effect that was added after it.
    pub added: Option<String>,
    /// Id of the fault that was taken out of the data after it.
    pub corrected: Option<String>,
    /// Ids that the data could not tell from what was added.
    pub tied_with: Vec<String>,
    /// Ids of effects that had become unnecessary before it.
    pub dropped: Vec<String>,
    /// The free parameters of its model.
    #[serde(default)]
    pub parameters: Vec<LearntParameter>,
    /// What was diagnosed.
    pub diagnosis: retune_diagnosis::Diagnosis,
}

/// A free parameter in a step of learning, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LearntParameter {
    /// Its name.
    pub name: String,
    /// Its value in the file that was learned from; of the size of an effect that which leaves the model as it is.
    pub before: f64,
    /// The fitted value.
    pub value: f64,
    /// 90 % interval.
    pub interval: [f64; 2],
}

impl From<&retune_diagnosis::Step> for LearningStep {
    fn from(s: &retune_diagnosis::Step) -> Self {
        Self {
            misfit: s.misfit,
            misfit_per_mode: s.misfit_per_mode.clone(),
            held_out_per_mode: s.held_out.clone(),
            added: s.added.as_ref().map(retune::effect::Candidate::id),
            corrected: s.corrected.clone(),
            tied_with: s.tie.clone(),
            dropped: s.dropped.clone(),
            parameters: learnt(s),
            diagnosis: s.diagnosis.clone(),
        }
    }
}

fn learnt(s: &retune_diagnosis::Step) -> Vec<LearntParameter> {
    let all = s.model.parameters();
    let one = |e: &retune_diagnosis::Estimate| {
        let before = all.get(all.index_of(&e.parameter)?).value;
        Some(LearntParameter { name: e.parameter.clone(), before, value: e.value, interval: e.interval })
    };
    s.parameters.iter().filter_map(one).collect()
}

/// Names of the steps: what each model has that the one before had not.
fn step_names(steps: &[LearningStep]) -> Vec<String> {
    let mut names = vec!["refitted".to_string()];
    for (before, now) in steps.iter().zip(steps.iter().skip(1)) {
        let mut name = match (&before.added, &before.corrected) {
            (Some(id), _) => format!("+ {id}"),
            (None, Some(id)) => format!("data corrected: {id}"),
            (None, None) => "refitted".into(),
        };
        for id in &now.dropped {
            name += &format!(", - {id}");
        }
        names.push(name);
    }
    names
}

/// The error over the steps of learning; `initial` is the misfit of the model before any fit, in total and per mode.
pub fn learning_steps(steps: &[LearningStep], initial: Option<(f64, &[Option<f64>])>, test: &TestData) -> Steps {
    // Of what has no partner nothing is compared, which is not agreement.
    let per_mode = |s: &LearningStep, v: &[f64]| {
        let d = &s.diagnosis;
        let is_alone = |mode: usize| d.unpaired_modes.contains(&mode) || d.foreign_modes.iter().any(|f| f.mode == mode);
        v.iter().zip(1..).map(|(misfit, mode)| (!is_alone(mode)).then_some(*misfit)).collect::<Vec<_>>()
    };
    let mut out: Vec<Step> = Vec::new();
    if let Some((misfit, modes)) = initial {
        out.push(Step {
            name: "initial".into(),
            misfit,
            per_mode: modes.to_vec(),
            note: "the values of the file, nothing fitted".into(),
            ..Step::default()
        });
    }
    for (name, s) in step_names(steps).into_iter().zip(steps) {
        out.push(Step {
            name,
            misfit: s.misfit,
            per_mode: per_mode(s, &s.misfit_per_mode),
            held_out: Some(s.held_out_per_mode.iter().sum()),
            held_out_per_mode: per_mode(s, &s.held_out_per_mode),
            note: s.diagnosis.sentence.clone(),
        });
    }
    // Fits of a history that another test made have other modes.
    let n = test.modes.len();
    for step in &mut out {
        if step.per_mode.len() != n {
            step.per_mode.clear();
        }
        if step.held_out_per_mode.len() != n {
            step.held_out_per_mode.clear();
        }
    }
    Steps {
        measure: MEASURE.into(),
        noise_floor: steps.last().map(|s| s.diagnosis.degrees_of_freedom),
        mode_labels: (0..n).map(|i| super::test_label(test, i)).collect(),
        steps: out,
    }
}

/// The diagnoses of a history, the last one apart.
pub(super) fn diagnoses(steps: &[LearningStep], model: &Model, test: &TestData) -> (Vec<Diagnosis>, Option<Diagnosis>) {
    let titles = step_names(steps);
    let mut all: Vec<Diagnosis> = steps.iter().map(|s| diagnosis(&s.diagnosis, model, test)).collect();
    if all.len() > 1 {
        for (d, title) in all.iter_mut().zip(titles) {
            d.title = title;
        }
    }
    let last = all.pop();
    (all, last)
}

/// The answer of a diagnosis, with the misfit before and after what it proposes.
pub(super) fn verdict(d: &Diagnosis) -> Verdict {
    let floor = d.degrees_of_freedom.map_or_else(String::new, |f| format!("; noise alone leaves about {}", number(f)));
    let best = d.hypotheses.first().filter(|_| !matches!(d.outcome, Outcome::Adequate | Outcome::NoiseOrModel));
    let pair = best.and_then(|h| Some((h, h.misfit_before?, h.misfit_after?)));
    let (value, label) = match (pair, d.misfit) {
        // Of two, each has what it adds to the other.
        (Some((_, _, after)), Some(base)) if d.outcome == Outcome::SeveralEffects => (
            format!("{} → {}", number(base), number(after)),
            format!("misfit without and with all that are named{floor}"),
        ),
        (Some((h, before, after)), _) => {
            (format!("{} → {}", number(before), number(after)), format!("misfit without and with {}{floor}", h.id))
        }
        (None, Some(m)) => (number(m), format!("misfit of the fitted model{floor}")),
        (None, None) => (String::new(), String::new()),
    };
    let chance = d.p_value.filter(|_| !matches!(d.outcome, Outcome::Adequate | Outcome::NoiseOrModel));
    let chance = chance.map_or_else(String::new, |p| format!(" Chance alone does as well in {}.", odds(p)));
    Verdict {
        sentence: sentence(&d.sentence) + &chance,
        number: value,
        number_label: label,
        level: match d.outcome {
            Outcome::Adequate => Level::Good,
            Outcome::MissingEffect | Outcome::MeasurementFault | Outcome::Tied => Level::Warning,
            Outcome::SeveralEffects | Outcome::Unexplained | Outcome::NoiseOrModel => Level::Bad,
        },
    }
}

/// [`verdict`] on the last model of a history of learning, which is not the one that was given.
pub(super) fn verdict_of_learning(d: &Diagnosis, steps: &[LearningStep]) -> Verdict {
    let mut verdict = verdict(d);
    let found = found(steps);
    let ([one, rest @ ..], Some(first), Some(last)) = (found.as_slice(), steps.first(), steps.last()) else {
        return verdict;
    };
    verdict.number = format!("{} → {}", number(first.misfit), number(last.misfit));
    let all = if rest.is_empty() { (*one).to_string() } else { format!("all {} that were found", found.len()) };
    verdict.number_label = format!(
        "misfit of the fitted model without and with {all}; noise alone leaves about {}",
        number(last.diagnosis.degrees_of_freedom)
    );
    let all = found.join(" and ");
    verdict.sentence = match d.outcome {
        Outcome::Adequate => format!("With {all}, {}.", d.sentence),
        _ => format!("{} In this model already: {all}.", verdict.sentence),
    };
    verdict
}

/// What learning has put into the model or taken out of the data, and kept.
pub(super) fn found(steps: &[LearningStep]) -> Vec<&str> {
    let all = steps.iter().flat_map(|s| s.added.iter().chain(&s.corrected));
    all.filter(|id| !steps.iter().any(|s| s.dropped.contains(id))).map(String::as_str).collect()
}
