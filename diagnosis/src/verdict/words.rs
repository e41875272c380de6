//! The answer of a diagnosis in a sentence.

use crate::result::{HypothesisResult, Kind, Together, Verdict};
use crate::screen::noise::WorstShape;
use crate::screen::stage::Stage;
use crate::search::pairs::Pair;
use crate::search::several::Chain;
use crate::thresholds::{BY_CHANCE, MOST_NOISE, REMAINDER, STRONG};
use retune::fault::Tests;

/// `; the data cannot tell it from 3 others`
fn tie(name: &str, tied: &[String]) -> String {
    match tied {
        [] => String::new(),
        [other] => format!("; the data cannot tell {name} from {other}"),
        others => format!("; the data cannot tell {name} from {} others", others.len()),
    }
}

/// Where one hypothesis is named, or none.
///
/// * `leads` - whether the best was more probable than all else before its remainder was tested
/// * `left` - the probability that noise alone leaves as much as the best does
pub(crate) fn of_one(
    verdict: Verdict,
    best: Option<&HypothesisResult>,
    (leads, left): (bool, f64),
    base: &Stage,
    remainder: &str,
) -> String {
    let id = best.map_or("", |b| b.id.as_str());
    let likely = best.is_some_and(|b| b.probability > 0.5);
    let tie = tie("it", best.map_or(&[], |b| &b.tied_with));
    // A search that was cut short has not asked the whole catalogue.
    let nothing = if base.settings.until.was_cut() { "nothing that was tried" } else { "nothing in the catalogue" };
    match verdict {
        Verdict::Adequate | Verdict::NoiseOrModel => {
            let explained = if base.noise_factor() > 1.0 {
                format!(
                    "the model explains the test if the noise is {:.2} times as large as stated",
                    base.noise_factor()
                )
            } else {
                explained_at_its_noise(base)
            } + without_damping(base);
            match best.filter(|b| b.probability > 0.5) {
                Some(b) => format!(
                    "{explained}; {} would explain more of it (P {:.0} %), but no more than chance does",
                    b.id,
                    100.0 * b.probability
                ),
                None => explained,
            }
        }
        Verdict::MissingEffect => {
            let perhaps = if likely { "" } else { "perhaps " };
            let rest = if left < REMAINDER {
                format!("though noise alone leaves as much in only 1 of {:.0} tests", 1.0 / left.max(BY_CHANCE))
            } else {
                "and the rest looks like noise".to_string()
            };
            format!("{perhaps}{id} explains the test, {rest}{tie}")
        }
        Verdict::MeasurementFault => {
            let perhaps = if likely { "" } else { "perhaps " };
            // Beside noise that is not believable the model may be wrong as well.
            let alone = if base.noise_factor() > MOST_NOISE { "" } else { ", not the model" };
            match best.and_then(|b| noun_of(base, b)) {
                Some(noun) => format!("{perhaps}the model explains the test but for {noun}: {id}{tie}"),
                None => format!("{perhaps}the measurement is at fault{alone}: {id}{tie}"),
            }
        }
        Verdict::Unexplained | Verdict::SeveralEffects => match best.filter(|b| b.ln_bayes > STRONG && leads) {
            Some(b) => format!(
                "{id} reduces the misfit from {} to {}, but {nothing} explains the rest; {remainder}",
                number(b.misfit_before),
                number(b.misfit_after)
            ),
            None => format!("{nothing} explains the test; {remainder}"),
        },
    }
}

/// What a fault is, where nothing is wrong with the measurement.
fn noun_of(base: &Stage, fault: &HypothesisResult) -> Option<&'static str> {
    base.settings.faults.find(&fault.name)?.noun()
}

/// What a fault is.
fn fault_of(base: &Stage, fault: &HypothesisResult) -> &'static str {
    noun_of(base, fault).unwrap_or("a fault of the measurement")
}

fn explained_at_its_noise(base: &Stage) -> String {
    let modes = &base.scene.test.modes;
    let is_stated = modes.is_empty() || modes.iter().any(|m| !m.frequency_hz.sd_is_default);
    let noise = if is_stated { "at its stated noise" } else { "at the noise that is assumed where a test states none" };
    format!("the model explains the test {noise}")
}

fn without_damping(base: &Stage) -> &'static str {
    if leaves_damping_aside(base) { ", damping aside, as the model has none" } else { "" }
}

/// Where the model would explain the test with noise that is not believable.
pub(crate) fn of_noise_or_model(base: &Stage, shape: Option<&WorstShape>) -> String {
    let (damping, factor) = (without_damping(base), base.noise_factor());
    let agreement = shape.map(|s| {
        let mode = base.scene.mode(s.mode);
        // Shapes that agree well differ in the digits after the nines.
        let [mac, least] = [s.mac, s.least].map(|v| if v > 0.98 { format!("{v:.4}") } else { format!("{v:.2}") });
        (format!("{mode} has a MAC of {mac}"), format!("gives {least} or more"), s.mac < s.least)
    });
    let reason = match agreement {
        _ if factor <= 1.0 && shape.is_none() => explained_at_its_noise(base),
        Some((mac, least, _)) if factor <= 1.0 => {
            format!("{mac}, where noise of the stated size {least}")
        }
        Some((mac, least, true)) => format!(
            "the model explains the test only if the noise is {factor:.1} times as large as stated, and even then {mac}, where such noise {least}"
        ),
        Some((mac, least, false)) => format!(
            "the model explains the test only if the noise is {factor:.1} times as large as stated; {mac}, and such noise {least}"
        ),
        None => format!("the model explains the test only if the noise is {factor:.1} times as large as stated"),
    };
    format!(
        "the stated noise or the model is wrong: {reason}{damping}; check the standard deviations of the test, and if they are right, the model lacks \
         something that is not in the catalogue"
    )
}

/// Where two are named.
pub(crate) fn of_two(base: &Stage, pair: &Pair, hypotheses: &[HypothesisResult]) -> String {
    let [first, second, ..] = hypotheses else { return String::new() };
    let perhaps = if pair.share(&first.id).min(pair.share(&second.id)) > 0.5 { "" } else { "perhaps " };
    let both = match (first.kind, second.kind) {
        (Kind::Effect, Kind::Effect) => format!("{perhaps}{} and {} explain the test together", first.id, second.id),
        (Kind::Fault, Kind::Fault) if [first, second].iter().any(|h| noun_of(base, h).is_some()) => {
            let [a, b] = [first, second].map(|h| format!("{}, {}", fault_of(base, h), h.id));
            format!("{perhaps}the model explains the test but for {a}, and {b}")
        }
        (Kind::Fault, Kind::Fault) => {
            format!("{perhaps}the measurement is at fault twice, not the model: {} and {}", first.id, second.id)
        }
        (Kind::Effect, Kind::Fault) => {
            format!("{perhaps}{} explains the test with {}, {}", first.id, fault_of(base, second), second.id)
        }
        (Kind::Fault, Kind::Effect) => {
            format!("{perhaps}{} explains the test with {}, {}", second.id, fault_of(base, first), first.id)
        }
    };
    let ties = [first, second].map(|h| tie(&h.id, &h.tied_with)).concat();
    format!("{both}; neither suffices alone{ties}")
}

/// Where several things of the catalogue are more probable than all else, and no few of them leave noise.
pub(crate) fn of_nearly(base: &Stage, together: Option<&Together>) -> String {
    let several = "several things are wrong at once";
    match together.and_then(|t| Some((t.best.as_slice(), t.misfit_after?))) {
        Some(([first, second], left)) => format!(
            "{several}: {first} and {second} explain most of the test: they take the misfit from {} to {}, but what they leave is more than noise; \
             put right what is certain and diagnose again",
            number(base.fit.misfit),
            number(left)
        ),
        _ => format!("{several}, and none of those that were tried explain the test"),
    }
}

/// Where more than two are wrong.
pub(crate) fn of_several(base: &Stage, chain: &Chain, hypotheses: &[HypothesisResult]) -> String {
    let ids = chain.ids();
    let (first, rest) = ids.split_first().map_or(("", &[][..]), |(f, r)| (f.as_str(), r));
    let rest = match rest {
        [] => String::new(),
        [one] => one.clone(),
        [some @ .., last] => format!("{} and {last}", some.join(", ")),
    };
    let tie = tie(first, hypotheses.first().map_or(&[], |h| &h.tied_with));
    let what = match hypotheses.first() {
        Some(h) if h.kind == Kind::Fault => fault_of(base, h),
        _ => "missing from the model",
    };
    format!(
        "several things are wrong; first {first} ({what}); with {rest} beside it the rest looks like noise, and `retune learn` goes on, one at a \
         time{tie}"
    )
}

/// Whether the test has damping ratios and the model no damping to compare them with.
pub(crate) fn leaves_damping_aside(base: &Stage) -> bool {
    !base.scene.is_damped && base.scene.test.modes.iter().any(|m| m.damping_ratio.is_some())
}

/// To three digits.
pub(crate) fn number(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1.0).log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}
