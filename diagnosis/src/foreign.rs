//! Measured modes that are not of the structure.
//!
//! They are decided at the base, once, so that all hypotheses are compared on the same data. There the model may lack an effect of any
//! size: what it misses is taken for model form, and its true modes stay. A mode that one cause explains together with all
//! others, to the stated noise (a body on a spring brings one, a sensor turned over changes one), is not a foreign one: then the diagnosis with all
//! modes is the answer, as one cause is more probable than two. Such a cause is looked for before the others decide without the mode, and
//! after: what they name may give the mode its partner. Where the best of that search gives such modes their partners and does not explain
//! everything, several things are wrong, and these modes stay, unless fewer things are wrong with them foreign.

use super::answer::{Investigation, investigate_these};
use super::damping;
use super::error::DiagnosisError;
use super::problem::evidence::degrees_of_freedom;
use super::problem::scene::Scene;
use super::result::{ForeignMode, Verdict};
use super::screen::stage::{placed, stage_begun};
use super::search::basin::in_the_lowest_basin;
use super::search::hypothesis::{Refit, Tried};
use super::search::one_cause::{OneCause, one_cause_of};
use super::search::singles::refit;
use super::settings::Settings;
use super::verdict::decide::conclude;
use super::verdict::pairs::pairs_of;
use super::verdict::so_far::so_far;
use crate::thresholds::{BY_CHANCE, MISREAD, STRONG};
use retune::catalogue::did_you_mean;
use retune::data::{Standing, TestData};
use retune::effect::{Context, Effect, Structure};
use retune::fault::Tests;
use retune::linalg::DVector;
use retune::update::slip_of_unit;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// The scene with the standing of every mode, and where the parameters have come with the pairs.
fn settled(scene: &Scene, settings: &Settings) -> Result<(Scene, Option<DVector<f64>>), DiagnosisError> {
    let given = scene.as_given();
    let comparisons = given.comparisons()?;
    let settled = settings.pairing.settle(&comparisons, &given.start(), MISREAD)?;
    let decided = given.with_modes(settled.tests).with_contradicted(&settled.contradicted);
    Ok((decided, settings.pairing.infers().then_some(settled.x)))
}

/// The same with the modes that are of the structure.
fn with_modes_of_the_structure(
    mut scene: Scene,
    starts: &[DVector<f64>],
    weight: Option<f64>,
    settings: &Settings,
) -> Result<Investigation, DiagnosisError> {
    scene.how = settings.pairing;
    let (decided, x) = settled(&scene, settings)?;
    let foreign: Vec<usize> =
        (0..decided.test.modes.len()).filter(|&m| is_foreign(&decided.test.modes[m].standing)).collect();
    // Shapes tell whether a hypothesis explains a mode; a frequency alone can be had from any.
    let has_shape = foreign.iter().any(|&m| scene.test.modes[m].shape.is_some());
    let may_be_had = || has_shape && !settings.until.is_over();
    let cause = match &x {
        _ if !may_be_had() => OneCause::None,
        Some(x) => one_cause_of(&decided, x, &foreign, settings)?,
        None => OneCause::Any,
    };
    let with_all = match cause {
        OneCause::None => None,
        // What no effect of this place and size could make needs no fit: among thousands the right one may never get one.
        OneCause::These(sought) => Some(scene.as_given().with_only(Some(sought))),
        OneCause::Any => Some(scene.as_given()),
    };
    let is_tried = with_all.is_some();
    // The modes that looked foreign, with partners by what explains most and not all.
    let mut kept = None;
    if let Some(with_all) = with_all {
        match by_one_cause(with_all, starts, weight, settings)? {
            Asked::Explained(found) => return named(*found, settings),
            // The best of what does not suffice alone may still give such modes their partners: then several things are wrong, and these modes stay,
            // unless fewer are with them foreign.
            Asked::Best(found) => {
                if let Some(best) = found.first()
                    && let Some(freed) = with_partners_by(&scene, best, &foreign, settings)?
                {
                    let begun = best.fit.x.rows(0, best.fit.x.len() - best.estimates.len()).into_owned();
                    let known: Vec<&Tried> = found.iter().map(|r| &r.tried).collect();
                    kept = Some(investigate_these(freed, (starts, Some(&begun)), &known, weight, settings)?);
                }
            }
        }
    }
    if let Some(kept) = kept.take_if(|kept| settings.until.is_over() || wrong(kept) <= 1) {
        return named(kept, settings);
    }
    let found = investigate_these(decided, (starts, x.as_ref()), &[], weight, settings)?;
    if let Some(kept) = kept {
        return named(if wrong(&found) < wrong(&kept) { found } else { kept }, settings);
    }
    if may_be_had()
        && let Some(refit) = the_named(&found)
        && let Some(freed) = with_partners_by(&scene, refit, &foreign, settings)?
        // All modes together have been tried before.
        && (!is_tried || freed.test.modes.iter().any(|mode| is_foreign(&mode.standing)))
        && let Asked::Explained(with_them) = by_one_cause(freed, starts, weight, settings)?
    {
        return named(*with_them, settings);
    }
    named(found, settings)
}

/// How many things are wrong by a diagnosis, a mode that is not of the structure and larger noise among them; of one that explains nothing more than of any other.
fn wrong(found: &Investigation) -> usize {
    let foreign = found.base.scene.test.modes.iter().filter(|m| is_foreign(&m.standing)).count();
    let named = match found.diagnosis.verdict {
        Verdict::Adequate => 0,
        Verdict::MissingEffect | Verdict::MeasurementFault => 1,
        Verdict::SeveralEffects => found.diagnosis.together.as_ref().map_or(2, |t| t.ids.len().max(2)),
        Verdict::NoiseOrModel | Verdict::Unexplained => return usize::MAX,
    };
    named + foreign + usize::from(found.diagnosis.noise_factor > 1.0)
}

/// The effect that a diagnosis names.
fn the_named(found: &Investigation) -> Option<&Refit> {
    let first = found.diagnosis.hypotheses.first().filter(|_| found.diagnosis.verdict == Verdict::MissingEffect)?;
    found.refits.iter().find(|r| r.id(&found.base.scene) == first.id)
}

/// The scene with the modes that looked foreign at the base and have a partner where an effect is in the model; `None` where none has.
///
/// The look for one cause before asks the model with an effect of a few sizes; here the size and the parameters are fitted.
fn with_partners_by(
    scene: &Scene,
    refit: &Refit,
    foreign: &[usize],
    settings: &Settings,
) -> Result<Option<Scene>, DiagnosisError> {
    let given = refit.scene.as_given();
    let settled = settings.pairing.settle(&given.comparisons()?, &refit.fit.x, MISREAD)?;
    let with_the_named = given.with_modes(settled.tests);
    let still = |m: &usize| is_foreign(&with_the_named.test.modes[*m].standing);
    let kept: Vec<usize> = foreign.iter().copied().filter(still).collect();
    if kept.len() == foreign.len() {
        return Ok(None);
    }
    let all = scene.as_given();
    let mut tests: Vec<TestData> = all.cases.iter().map(|c| (*c.test).clone()).collect();
    for (case, test) in scene.cases.iter().zip(&mut tests) {
        for &m in kept.iter().filter(|m| case.modes().contains(m)) {
            test.modes[m - case.first_mode].standing = with_the_named.test.modes[m].standing.clone();
        }
    }
    Ok(Some(all.with_modes(tests).with_contradicted(&settled.contradicted)))
}

fn is_foreign(standing: &Standing) -> bool {
    matches!(standing, Standing::Aside { foreign: Some(_), .. })
}

/// What a search for one cause of all modes found.
enum Asked {
    /// The diagnosis, where one cause explains them to the stated noise.
    Explained(Box<Investigation>),
    /// The effects that explain most, and not all, the best first; none where nothing does.
    Best(Vec<Refit>),
}

/// The diagnosis with all modes, where one cause explains them to the stated noise: several changes and larger noise explain anything.
fn by_one_cause(
    scene: Scene,
    starts: &[DVector<f64>],
    weight: Option<f64>,
    settings: &Settings,
) -> Result<Asked, DiagnosisError> {
    let base = stage_begun(scene, starts, None, weight.unwrap_or(1.0), settings)?;
    let refits = refit(&base, false)?;
    let (base, mut refits) = in_the_lowest_basin(base, refits, settings)?;
    let spare = degrees_of_freedom(&base.fit, &base.q).max(1.0);
    let noise = ChiSquared::new(spare).ok();
    let explains = |misfit: f64| noise.is_some_and(|c| 1.0 - c.cdf(misfit) > BY_CHANCE);
    let strong = refits.hypotheses.iter().filter(|r| r.missed == 0 && r.ln_bayes > STRONG);
    let mut best: Vec<Refit> = strong.filter(|r| matches!(r.tried, Tried::Effect(_))).cloned().collect();
    best.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    best.truncate(settings.effort.best);
    if !refits.hypotheses.iter().any(|r| r.missed == 0 && explains(r.misfit)) {
        return Ok(Asked::Best(best));
    }
    let diagnosis = conclude(&base, &mut refits, settings)?;
    let is_one = matches!(diagnosis.verdict, Verdict::MissingEffect | Verdict::MeasurementFault);
    let is_explained = is_one && diagnosis.hypotheses.first().is_some_and(|h| explains(h.misfit_after));
    Ok(if is_explained {
        Asked::Explained(Box::new(Investigation { diagnosis, base, refits: refits.hypotheses }))
    } else {
        Asked::Best(best)
    })
}

/// With what has no partner named.
fn named(mut found: Investigation, settings: &Settings) -> Result<Investigation, DiagnosisError> {
    let scene = &found.base.scene;
    let mut foreign = Vec::new();
    for (m, mode) in scene.test.modes.iter().enumerate() {
        let Some(reason) = mode.standing.reason() else { continue };
        let probability = match mode.standing {
            Standing::Aside { foreign, .. } => foreign,
            _ => None,
        };
        let (frequency_hz, label) = (mode.frequency_hz.value, mode.label.clone());
        foreign.push(ForeignMode { mode: m + 1, frequency_hz, label, probability, reason });
    }
    let of_inference: Vec<String> = foreign
        .iter()
        .filter(|f| f.probability.is_some())
        .map(|f| format!("{} at {:.4} Hz is {}", scene.mode(f.mode - 1), f.frequency_hz, f.reason))
        .collect();
    if !of_inference.is_empty() {
        found.diagnosis.sentence += &format!("; {}", of_inference.join("; "));
        if settings.is_narrowed() {
            found.diagnosis.warnings.push(
                "which modes are of the structure depends on the effects and places that are tried: an effect that was not may explain a mode that \
                 is left out here, and misfits of a search over all of them may then be of more modes than these"
                    .to_string(),
            );
        }
    }
    let comparisons = scene.comparisons()?;
    let theta = &found.base.fit.theta;
    found.diagnosis.pairs = comparisons.iter().map(|c| pairs_of(c, theta)).collect::<Result<_, _>>()?;
    drop(comparisons);
    found.diagnosis.foreign_modes = foreign;
    Ok(found)
}

/// The whole investigation: units first, then the standing of every mode, then what is missing.
///
/// * `starts` - of the fit beside the estimates and points of the box
/// * `weight` - 1 over the factor on the stated standard deviations; sought where there is none
pub(super) fn investigate(
    scene: Scene,
    starts: &[DVector<f64>],
    weight: Option<f64>,
    settings: &Settings,
) -> Result<Investigation, DiagnosisError> {
    if scene.cases.iter().all(|c| c.test.has_nothing()) {
        return Err(DiagnosisError::NoData);
    }
    for case in &scene.cases {
        if let Some(slip) = slip_of_unit(&*case.model, &case.test)? {
            return Err(DiagnosisError::Unit { slip });
        }
    }
    let scene = scene.in_full(starts.first())?.with_only(None);
    check_places(&scene, settings)?;
    let (work, before) = (scene.work.clone(), scene.work.so_far());
    let mut found = with_modes_of_the_structure(scene, starts, weight, settings)?;
    if !settings.until.is_over() {
        found.diagnosis.damping = damping::read(&found.base)?;
    }
    found.diagnosis.work = work.so_far().since(before);
    if settings.until.was_cut() {
        found.diagnosis.is_partial = true;
        let so_far = so_far(&found.base, &found.refits, &found.diagnosis)?;
        found.diagnosis.sentence = format!("the search was stopped before its end; {so_far}");
    }
    Ok(found)
}

/// Effects that are named one by one where none of them has a place, fewer than these.
const MANY: usize = 6;

/// Whether the structure has every place that effects are to be tried at, and the effects that were chosen one of these.
fn check_places(scene: &Scene, settings: &Settings) -> Result<(), DiagnosisError> {
    let context = Context::default();
    let structures: Vec<Structure<'_>> = scene.cases.iter().map(|c| Structure::new(&c.model, &context)).collect();
    for name in &settings.places {
        if !structures.iter().any(|s| s.has_place(name)) {
            let known = structures.iter().flat_map(Structure::place_names);
            return Err(DiagnosisError::Place { suggestion: did_you_mean(name, known), name: name.clone() });
        }
    }
    let effects: Vec<&str> = settings.effects.iter().map(Effect::name).collect();
    if settings.is_narrowed() && !effects.is_empty() && placed(scene, settings).is_empty() {
        let listed = |names: &[&str]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
        let places: Vec<&str> = settings.places.iter().map(String::as_str).collect();
        let where_to = if places.is_empty() { "on this model".to_string() } else { format!("at {}", listed(&places)) };
        let have_no_place = match effects.as_slice() {
            [one] => format!("the effect `{one}` has no place {where_to}"),
            some if some.len() < MANY => format!("the effects {} have no place {where_to}", listed(some)),
            _ => format!("no effect has a place {where_to}"),
        };
        return Err(DiagnosisError::NoEffect { have_no_place });
    }
    Ok(())
}
