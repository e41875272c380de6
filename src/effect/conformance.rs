//! The contract of effects, checked over a catalogue on any model: for the built-in ones and for a user's own.

use super::candidate::{Candidate, Patched};
use super::patch::Patch;
use super::structure::Context;
use super::{About, Effect, Effects, candidates};
use crate::linalg::DMatrix;
use crate::model::{Model, ModelSpec, ParametricModel, Registry, System};
use crate::units::Unit;
use crate::yaml;

/// Rounding of sums of some dozen terms, against the largest entry of a matrix.
const ROUNDING: f64 = 1e-14;

/// Checks every candidate of the effects on a model, and returns what violates the contract, one sentence each:
///
/// * *about*: the texts are there, the confusable effects exist
/// * *places*: what is offered, at wider places too, is a candidate with at least one parameter
/// * *names*: parameters are `<effect>.<place>.<quantity>`, with a unit, bounds around the neutral value and a typical size
///   inside
/// * *pure*: the same model gives the same candidates in the same order
/// * *neutral*: at the neutral values K, M and C are those of the unchanged model to 1e-14; where the patch adds massless
///   dofs, those of the model that is left when they are condensed
/// * *alive*: at the typical size K, M or C differ
/// * *round trip*: the edited text reads as the edited model, and undoing it gives the text back byte for byte; the patch
///   reads back from its own YAML
/// * *composes*: with the next candidate of the list it gives a model; of one effect, every fourth is tried
pub fn check(effects: &Effects, text: &str, registry: &Registry, context: &Context) -> Vec<String> {
    let model = match crate::model::load(text, registry) {
        Ok((model, _, _)) => model,
        Err(problems) => return problems.iter().map(ToString::to_string).collect(),
    };
    check_on(effects, &model, text, registry, context)
}

/// [`check_on`], of which only some candidates are built and read back: so many of every effect, evenly among its places.
#[cfg(test)]
pub(crate) fn check_some(
    effects: &Effects,
    (model, text): (&Model, &str),
    registry: &Registry,
    context: &Context,
    of_each: usize,
) -> Vec<String> {
    let all = candidates(model, effects, context);
    let count = |name: &str| all.iter().filter(|c| c.effect.name() == name).count();
    let counts: Vec<usize> = effects.iter().map(|e| count(e.name())).collect();
    let mut met = vec![0; counts.len()];
    check_where(effects, model, text, registry, context, &mut |c| {
        let Some(k) = effects.iter().position(|e| e.name() == c.effect.name()) else { return true };
        met[k] += 1;
        // The last of each of so many equal parts.
        let parts = of_each.min(counts[k]);
        met[k] * parts / counts[k] > (met[k] - 1) * parts / counts[k]
    })
}

/// [`check`] of a model that was read from files too: with superelements.
///
/// * `text` - of the model file
pub fn check_on(effects: &Effects, model: &Model, text: &str, registry: &Registry, context: &Context) -> Vec<String> {
    check_where(effects, model, text, registry, context, &mut |_| true)
}

/// * `is_tried` - asked of every candidate in turn
fn check_where(
    effects: &Effects,
    model: &Model,
    text: &str,
    registry: &Registry,
    context: &Context,
    is_tried: &mut dyn FnMut(&Candidate) -> bool,
) -> Vec<String> {
    let mut failures: Vec<String> = effects.iter().flat_map(|e| about(e, effects)).collect();
    let all = candidates(model, effects, context);
    let again = candidates(model, effects, context);
    if all.len() != again.len() || all.iter().zip(&again).any(|(a, b)| a.id() != b.id() || a.patch != b.patch) {
        failures.push("the candidates of one model differ between two calls".to_string());
    }
    let structure = super::Structure::new(model, context);
    let wider = structure.clone().on_wider_places();
    for (effect, structure) in effects.iter().flat_map(|effect| [(effect, &structure), (effect, &wider)]) {
        for at in effect.locations(structure) {
            match Candidate::new(effect, structure, &at) {
                Ok(candidate) if candidate.parameters.is_empty() => {
                    failures.push(format!("{}: it has no parameter", candidate.id()));
                }
                Ok(_) => {}
                Err(e) => failures.push(format!("{}@{at}: offered and then refused: {e}", effect.name())),
            }
        }
    }
    let theta = structure.theta().to_vec();
    let Ok(base) = model.assemble(&theta) else { return vec!["the model has no matrices".to_string()] };
    for (i, candidate) in all.iter().enumerate() {
        if !is_tried(candidate) {
            continue;
        }
        let mut fail = |what: String| failures.push(format!("{}: {what}", candidate.id()));
        names(candidate, &mut fail);
        match candidate.build(model, registry) {
            Err(e) => fail(e.to_string()),
            Ok(patched) => {
                let damps = candidate.effect.damps();
                matrices(&base, model, &patched, (&theta, damps), &mut fail);
            }
        }
        round_trip(candidate, text, model.spec(), &mut fail);
        let next = &all[(i + 1) % all.len()];
        let sampled = i % 4 == 0 || next.effect.name() != candidate.effect.name();
        if sampled && next.id() != candidate.id() {
            let both = candidate.patch.apply(model.spec()).and_then(|s| next.patch.apply(&s));
            match both.map(|spec| Model::new(spec, registry)) {
                Ok(Ok(_)) => {}
                Ok(Err(problems)) => fail(format!("with {}: {problems:?}", next.id())),
                Err(e) => fail(format!("with {}: {e}", next.id())),
            }
        }
    }
    failures
}

fn about(effect: &dyn Effect, effects: &Effects) -> Vec<String> {
    let About { summary, signature, formulation, confusable, references } = effect.about();
    let mut failures = Vec::new();
    let name = effect.name();
    for (what, text) in [("summary", summary), ("signature", signature), ("formulation", formulation)] {
        if text.len() < 20 || !text.ends_with('.') {
            failures.push(format!("{name}: its {what} is not a sentence"));
        }
    }
    if references.is_empty() || references.iter().any(|r| r.len() < 20) {
        failures.push(format!("{name}: it has no source"));
    }
    let builtin = Effects::builtin();
    for other in confusable {
        if *other == name || (effects.find(other).is_none() && builtin.find(other).is_none()) {
            failures.push(format!("{name}: confusable with `{other}`, which is no other effect"));
        }
    }
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_lowercase() || c == '-') {
        failures.push(format!("{name}: the name is not kebab-case"));
    }
    failures
}

fn names(candidate: &Candidate, fail: &mut impl FnMut(String)) {
    let prefix = format!("{}.", candidate.effect.name().replace('-', "_"));
    for p in &candidate.parameters {
        let [lower, upper] = p.bounds;
        if !p.name.starts_with(&prefix) || p.name.matches('.').count() < 2 {
            fail(format!("the name `{}` is not <effect>.<place>.<quantity>", p.name));
        }
        if p.unit.is_empty() || Unit::parse(&p.unit).is_err() {
            fail(format!("the unit `{}` cannot be read", p.unit));
        }
        if p.description.is_empty() {
            fail(format!("`{}` is not described", p.name));
        }
        let inside = |x: f64| x.is_finite() && lower <= x && x <= upper;
        if !inside(p.neutral) || !inside(p.typical) || lower >= upper || !p.grid.iter().all(|x| inside(*x)) {
            fail(format!("neutral {}, typical {} and bounds {lower} .. {upper} do not fit", p.neutral, p.typical));
        }
    }
    if candidate.parameters.iter().all(|p| p.typical == p.neutral) {
        fail("its typical size is its neutral one".to_string());
    }
}

fn matrices(
    base: &System,
    model: &Model,
    patched: &Patched,
    (theta, damps): (&[f64], bool),
    fail: &mut impl FnMut(String),
) {
    let at = |values: &[f64]| patched.model.assemble(&patched.theta(theta, values));
    let (neutral, typical) = match (at(&patched.neutral), at(&patched.typical)) {
        (Ok(n), Ok(t)) => (n, t),
        (Err(e), _) | (_, Err(e)) => return fail(e.to_string()),
    };
    let kept: Vec<Option<usize>> = model
        .dof_map()
        .rows()
        .iter()
        .map(|&(node, dof)| {
            let name = &model.geometry().names[node];
            let node = patched.model.geometry().node(name)?;
            patched.model.dof_map().rows().iter().position(|r| *r == (node, dof))
        })
        .collect();
    let Some(kept) = kept.into_iter().collect::<Option<Vec<usize>>>() else {
        return fail("dofs of the model are gone".to_string());
    };
    for (what, before, now) in [
        ("K", &base.stiffness, condense(&neutral, &kept)),
        ("M", &base.mass, Some(neutral.mass.select_rows(&kept).select_columns(&kept))),
    ] {
        let difference = now.map_or(f64::NAN, |now| (now - before).amax());
        if difference.is_nan() || difference > ROUNDING * before.amax() {
            fail(format!("at the neutral value {what} differs by {difference:e} of {:e}", before.amax()));
        }
    }
    let damping = |s: &System| s.damping.clone().unwrap_or_else(|| DMatrix::zeros(s.mass.nrows(), s.mass.nrows()));
    let c = damping(base);
    let difference = (damping(&neutral).select_rows(&kept).select_columns(&kept) - &c).amax();
    if difference > ROUNDING * c.amax() {
        fail(format!("at the neutral value C differs by {difference:e}"));
    }
    let moved = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() > 1e-10 * a.amax().max(b.amax());
    let alive = moved(&typical.stiffness, &neutral.stiffness)
        || moved(&typical.mass, &neutral.mass)
        || moved(&damping(&typical), &damping(&neutral));
    if !alive {
        fail("at its typical size nothing changes".to_string());
    }
    let is_only_damping = !moved(&typical.stiffness, &neutral.stiffness) && !moved(&typical.mass, &neutral.mass);
    if alive && is_only_damping != damps {
        let what = if is_only_damping { "C alone" } else { "K or M" };
        fail(format!("`damps` is {damps}, and it changes {what}"));
    }
}

/// K on the kept rows; the others, which must be massless, follow statically.
fn condense(system: &System, kept: &[usize]) -> Option<DMatrix<f64>> {
    let added: Vec<usize> = (0..system.stiffness.nrows()).filter(|i| !kept.contains(i)).collect();
    let block = |rows: &[usize], columns: &[usize]| system.stiffness.select_rows(rows).select_columns(columns);
    let own = block(kept, kept);
    if added.is_empty() {
        return Some(own);
    }
    if added.iter().any(|&i| system.mass.row(i).amax() > 0.0) {
        return None;
    }
    let inverse = block(&added, &added).try_inverse()?;
    Some(own - block(kept, &added) * inverse * block(&added, kept))
}

fn round_trip(candidate: &Candidate, text: &str, spec: &ModelSpec, fail: &mut impl FnMut(String)) {
    match Patch::from_yaml(&candidate.patch.to_yaml()) {
        Ok(patch) if patch == candidate.patch => {}
        Ok(_) => fail("its patch reads back differently from its own YAML".to_string()),
        Err(e) => fail(format!("its patch: {e}")),
    }
    let Ok(wanted) = candidate.patch.apply(spec) else { return };
    match yaml::read::<ModelSpec>(&yaml::write(&wanted)) {
        Ok((back, _)) if back.parameters.len() == wanted.parameters.len() => {}
        Ok(_) => fail("the edited model reads back differently".to_string()),
        Err(e) => fail(format!("the edited model: {e:?}")),
    }
    match candidate.patch.add_to_text(text, &candidate.id(), "a reason: with a colon, and a comma") {
        Err(e) => fail(format!("its text: {e}")),
        Ok(edited) => match super::undo(&edited) {
            Ok(undone) if undone.text == text => {}
            Ok(undone) => fail(format!("undoing it leaves another text: {:?}", first_difference(text, &undone.text))),
            Err(e) => fail(e.to_string()),
        },
    }
}

fn first_difference(a: &str, b: &str) -> Option<(String, String)> {
    let pair = a.lines().zip(b.lines()).find(|(a, b)| a != b);
    pair.map(|(a, b)| (a.to_string(), b.to_string()))
}
