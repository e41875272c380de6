//! Where the data allow less than one might think.

use super::words::{leaves_damping_aside, number};
use crate::error::{DiagnosisError, unsolvable};
use crate::problem::fit::Fit;
use crate::problem::mesh::{FINER, functions_moved, mesh_errors, modes, refined};
use crate::problem::race::{Pick, Round, fit_by};
use crate::problem::scene::{Case, Scene};
use crate::screen::stage::Stage;
use crate::search::hypothesis::{Estimate, Refit, Tried};
use crate::thresholds::{ON_BOUND, STRONG};
use retune::data::TestData;
use retune::effect::{Context, LocationKind, Structure};
use retune::fault::Tests;
use retune::model::{Model, PlacedElement};
use retune::objective::Scaling;
use std::collections::BTreeSet;

/// What the mesh falsifies: modes by more than a third of their standard deviation, functions by more than one.
struct MeshError {
    text: String,
    /// More than a standard deviation of a mode, or three of all that the functions say: physics that is named may be the mesh.
    is_serious: bool,
}

/// Of the model of a scene at a fit.
fn mesh_error(scene: &Scene, fit: &Fit) -> Option<MeshError> {
    let (mut bad, mut moved) = (Vec::new(), 0.0_f64);
    for case in &scene.cases {
        // Of a large model there is no finer one.
        let fine = case.stand_in.is_none().then(|| refined(&case.model, &fit.theta, FINER).ok()).flatten();
        bad.extend(falsified(scene, fit, case, fine.as_ref()).unwrap_or_default());
        let functions = fine.map(|fine| functions_moved(&case.model, &fine, &fit.theta, &case.test).unwrap_or(0.0));
        moved = moved.max(functions.unwrap_or(0.0));
    }
    let mut words = Vec::new();
    if !bad.is_empty() {
        let each: Vec<&str> = bad.iter().map(|(text, _)| text.as_str()).collect();
        words.push(format!("raises the frequencies of {}", each.join(", ")));
    }
    // One standard deviation of all that the functions say.
    if moved > 1.0 {
        words.push(format!("moves the functions by {} standard deviations, taken together", number(moved)));
    }
    (!words.is_empty()).then(|| MeshError {
        text: format!("the mesh is coarse: it {}; {}", words.join(" and "), remedy(scene)),
        is_serious: moved > 3.0 || bad.iter().any(|(_, deviations)| *deviations > 1.0),
    })
}

/// What makes it finer.
fn remedy(scene: &Scene) -> &'static str {
    let has_mesh = scene.cases.iter().any(|c| c.model.elements().iter().any(PlacedElement::is_of_mesh));
    match (has_mesh, scene.file.beams.is_empty()) {
        (false, _) => "subdivide the beams",
        (true, false) => "subdivide the beams and mesh the shells and solids more finely",
        (true, true) => "mesh the shells and solids more finely",
    }
}

/// Those of one test, in words and in standard deviations.
///
/// * `fine` - its model with finer beams, where there is one
fn falsified(
    scene: &Scene,
    fit: &Fit,
    case: &Case,
    fine: Option<&Model>,
) -> Result<Vec<(String, f64)>, DiagnosisError> {
    let n = case.modes().len();
    let has_beams = !case.model.spec().beams.is_empty();
    let mut errors = match fine.filter(|_| has_beams) {
        Some(fine) => mesh_errors(&case.model, fine, &fit.theta, 2 * n)?,
        None => vec![0.0; 2 * n],
    };
    let frequencies = modes(&case.model, &fit.theta, 2 * n)?;
    let all: Vec<usize> = frequencies.elastic().collect();
    for of_mesh in case.model.mesh_errors(&fit.theta, &frequencies, &all).map_err(unsolvable)? {
        if let Some(error) = errors.get_mut(of_mesh.mode - frequencies.n_rigid) {
            *error += of_mesh.relative;
        }
    }
    let hz: Vec<f64> = frequencies.elastic().map(|i| frequencies.frequency_hz(i)).collect();
    let in_words = |m: usize| {
        if fit.frequencies[m].is_nan() {
            return None;
        }
        let partner = (0..hz.len()).min_by(|&a, &b| {
            let d = |i: usize| (hz[i] - fit.frequencies[m]).abs();
            d(a).total_cmp(&d(b))
        })?;
        let measured = &scene.test.modes[m].frequency_hz;
        let error = *errors.get(partner)?;
        let name = scene.mode(m);
        let deviations = error * measured.value / measured.sd;
        (deviations > 1.0 / 3.0).then(|| (format!("{name} by {:.2} %", 100.0 * error), deviations))
    };
    Ok(case.modes().filter_map(in_words).collect())
}

/// What is to be known before an answer is trusted.
pub(crate) struct Warnings {
    pub(crate) all: Vec<String>,
    /// What a finer mesh does for the misfit, where it explains the test better: then the mesh comes first.
    pub(crate) finer_mesh: Option<String>,
}

/// How many lines of functions are compared, where those between are left out.
fn fewer_lines(test: &TestData) -> Option<String> {
    let (set, fit) = (test.frfs.as_ref()?, test.frf_fit.as_ref()?);
    let chosen = fit.lines_hz.as_ref()?.len();
    let all = set.frequencies_hz.iter().filter(|hz| fit.is_in_bands(**hz)).count();
    Some(format!(
        "of the functions of {} the search compares {chosen} of {all} lines, about the modes and between them; `update` and `compare` use all",
        test.name
    ))
}

/// Groups of what is named that the file has no name for.
fn shown_groups(base: &Stage, named: &[&Refit]) -> Vec<String> {
    let places = named.iter().filter_map(|r| match &r.tried {
        Tried::Effect(c) if c.location.kind == LocationKind::Group => Some(&c.location.names),
        _ => None,
    });
    let names: BTreeSet<&String> = places.flatten().collect();
    if names.is_empty() {
        return Vec::new();
    }
    let structure = Structure::new(base.scene.model(), Context::nothing());
    names.into_iter().filter_map(|name| structure.shown(name)).collect()
}

/// * `named` - the hypotheses that are named
/// * `best` - what explains the test best with all that is named in it, if anything is: there the mesh is judged
pub(crate) fn warnings(base: &Stage, named: &[&Refit], best: Option<&Refit>) -> Warnings {
    // What is missing may take modes away, or the base may be in a wrong basin: it stands first.
    let mut out: Vec<String> = unseen_modes(base).into_iter().collect();
    let (scene, fit) = best.map_or((&base.scene, &base.fit), |r| (&r.scene, &r.fit));
    let (mut slight, mut finer_mesh) = (None, None);
    if let Some(mesh) = mesh_error(scene, fit) {
        if mesh.is_serious {
            finer_mesh = finer_mesh_explains(scene, fit, base.weight);
            out.push(mesh.text);
        } else {
            slight = Some(mesh.text);
        }
    }
    if base.fit.rows.n_modes > 0 && !base.fit.rows.has_shapes {
        out.push(
            "frequencies alone rarely tell which effect is missing; measure shapes or frequency responses".to_string(),
        );
    }
    if base.noise_factor() > 1.0 {
        out.push(format!(
            "the residuals scatter {:.2} times as much as the standard deviations of the test say; check these",
            base.noise_factor()
        ));
    }
    if base.scene.cases.iter().any(|c| c.test.frfs.is_some() && c.test.frf_fit.is_none()) {
        out.push(
            "frequency responses are not used, because the test has no `frfs` block that says how; add one".to_string(),
        );
    }
    out.extend(base.scene.cases.iter().filter_map(|case| fewer_lines(&case.test)));
    if leaves_damping_aside(base) {
        out.push(
            "damping ratios take no part in the search, because the model has no damping; give it `modal_damping`, or members `stiffness_damping` or \
             `mass_damping` under `overrides`"
                .to_string(),
        );
    }
    out.extend(slight);
    out.extend(shown_groups(base, named));
    out.extend(named.iter().filter_map(|r| more_than_doubled(base, r)));
    out.extend(named.iter().filter(|r| !r.limit_of.is_empty()).map(|r| {
        format!("{} explains the test as well as {}, with no more numbers", r.id(&base.scene), r.limit_of.join(", "))
    }));
    out.extend(named.iter().flat_map(|r| beyond_bounds(base, r)));
    let model = base.scene.solved();
    let on_bounds: Vec<&str> = Scaling::new(model)
        .free()
        .iter()
        .zip(base.fit.x.iter())
        .filter(|(_, x)| **x < ON_BOUND || **x > 1.0 - ON_BOUND)
        .map(|(&i, _)| model.parameters().get(i).name.as_str())
        .collect();
    match on_bounds.as_slice() {
        [] => {}
        [one] => out.push(format!("parameter {one} of the fitted model sits on its bound")),
        many => {
            out.push(format!("{} parameters of the fitted model sit on their bounds: {}", many.len(), many.join(", ")));
        }
    }
    Warnings { all: out, finer_mesh }
}

/// Whether a finer mesh explains the test better, by more than 3 in ln evidence, in words.
fn finer_mesh_explains(scene: &Scene, fit: &Fit, weight: f64) -> Option<String> {
    /// Steps of the fit: the mesh moves an optimum little.
    const STEPS: usize = 12;
    let scene = scene.by_itself().ok()??;
    let mut file = (*scene.file).clone();
    for case in &scene.cases {
        let fine = refined(&case.model, &fit.theta, FINER).ok()?;
        for (name, member) in &fine.spec().beams {
            if let Some(own) = file.beams.get_mut(name) {
                own.subdivide = member.subdivide;
            }
        }
    }
    let fine = scene.with_file(file, scene.added.clone()).ok()?;
    let round = Round { pick: Pick::Lowest(1), steps: STEPS };
    let found = fit_by(&fine, &[vec![fit.x.clone()]], vec![round], weight).ok()?;
    (found.phi < fit.phi - STRONG).then(|| {
        format!(
            "with {FINER} elements for each the misfit is {} instead of {}",
            number(found.misfit),
            number(fit.misfit)
        )
    })
}

/// Sizes of a hypothesis that the data press against their bounds, though these leave room for what is physical.
fn beyond_bounds(base: &Stage, r: &Refit) -> Vec<String> {
    let Tried::Effect(candidate) = &r.tried else { return Vec::new() };
    let sizes = candidate.parameters.iter().zip(&r.estimates);
    let on_bound = sizes.filter(|(p, e)| {
        let [lower, upper] = p.bounds;
        let near = |bound: f64| (e.value - bound).abs() < 1e-6 * (upper - lower);
        let [is_least, is_most] = [lower, upper].map(near);
        // Nothing of an effect, and all of a part gone, is what an effect may mean.
        let is_gone = p.unit == "1" && (0.98..=1.0).contains(&e.value.abs());
        (is_least && lower != p.neutral || is_most) && !is_gone
    });
    let in_words = |(_, e): (_, &Estimate)| {
        format!(
            "the estimate of {} sits on its bound, {} {}: the data call for a value beyond it",
            r.id(&base.scene),
            number(e.value),
            e.unit
        )
    };
    on_bound.map(in_words).collect()
}

/// Parts whose stiffness the data more than double: hardly the part itself.
fn more_than_doubled(base: &Stage, r: &Refit) -> Option<String> {
    let Tried::Effect(candidate) = &r.tried else { return None };
    let is_change = candidate.effect.name().ends_with("stiffness-change");
    let largest = r.estimates.iter().filter(|_| is_change).map(|e| e.value).fold(0.0, f64::max);
    (largest > 1.0).then(|| {
        format!(
            "{} makes the part {:.1} times as stiff as the file says: perhaps the model lacks a brace or a second load path there",
            r.id(&base.scene),
            1.0 + largest
        )
    })
}

/// Modes of the fitted base inside the tested band that the sensors see well and no measured mode is paired with.
fn unseen_modes(base: &Stage) -> Option<String> {
    let in_band = |(all, case): (&Vec<f64>, &Case)| {
        let tested = case.test.modes.iter().map(|m| m.frequency_hz.value);
        let lowest = tested.fold(f64::INFINITY, f64::min);
        all.iter().filter(move |hz| **hz > lowest).map(|hz| format!("{hz:.4} Hz")).collect::<Vec<_>>()
    };
    let unseen: Vec<String> = base.fit.missed.iter().zip(&base.scene.cases).flat_map(in_band).collect();
    let (what, them) = match unseen.len() {
        0 => return None,
        1 => ("a mode", "it"),
        _ => ("modes", "them"),
    };
    Some(format!(
        "the fitted model has {what} inside the tested band that the test lacks, at {}: the test missed {them}, or the model is wrong about {them}",
        unseen.join(", ")
    ))
}
