//! Where the data allow less than one might think.

use super::DiagnosisError;
use super::base::Stage;
use super::fit::ON_BOUND;
use super::mesh::{FINER, functions_moved, mesh_errors, modes, refined};
use super::refit::{Refit, Tried};
use super::scene::Case;
use crate::model::{Model, ParametricModel};
use crate::objective::Scaling;

/// Whether the test has damping ratios and the model no damping to compare them with.
pub(super) fn leaves_damping_aside(base: &Stage) -> bool {
    !base.scene.is_damped && base.scene.test.modes.iter().any(|m| m.damping_ratio.is_some())
}

/// To three digits.
pub(super) fn number(value: f64) -> String {
    let digits = (2.0 - value.abs().max(1.0).log10().floor()).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// What the mesh falsifies: modes by more than a third of their standard deviation, functions by more than one.
struct MeshError {
    text: String,
    /// More than a standard deviation of a mode, or three of all that the functions say: physics that is named may be the mesh.
    is_serious: bool,
}

fn mesh_error(base: &Stage) -> Option<MeshError> {
    let theta = &base.fit.theta;
    let (mut bad, mut moved) = (Vec::new(), 0.0_f64);
    for case in &base.scene.cases {
        let Ok(fine) = refined(&case.model, theta, FINER) else { continue };
        bad.extend(falsified(base, case, &fine).unwrap_or_default());
        moved = moved.max(functions_moved(&case.model, &fine, theta, &case.test).unwrap_or(0.0));
    }
    let mut words = Vec::new();
    if !bad.is_empty() {
        let each: Vec<&str> = bad.iter().map(|(text, _)| text.as_str()).collect();
        words.push(format!("frequencies are too high: {}", each.join(", ")));
    }
    // One standard deviation of all that the functions say.
    if moved > 1.0 {
        words.push(format!("it moves the functions by {} standard deviations, taken together", number(moved)));
    }
    (!words.is_empty()).then(|| MeshError {
        text: format!("the mesh is too coarse, {}; subdivide the beams", words.join(", and ")),
        is_serious: moved > 3.0 || bad.iter().any(|(_, deviations)| *deviations > 1.0),
    })
}

/// Those of one test, in words and in standard deviations.
fn falsified(base: &Stage, case: &Case, fine: &Model) -> Result<Vec<(String, f64)>, DiagnosisError> {
    let n = case.modes().len();
    let errors = mesh_errors(&case.model, fine, &base.fit.theta, 2 * n)?;
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
        let deviations = error * measured.value / measured.sd;
        (deviations > 1.0 / 3.0).then(|| (format!("{name} by {:.2} %", 100.0 * error), deviations))
    };
    Ok(case.modes().filter_map(in_words).collect())
}

/// What is to be known before an answer is trusted.
pub(super) struct Warnings {
    pub(super) all: Vec<String>,
    /// Whether the mesh errs by more than the data do.
    pub(super) mesh_is_too_coarse: bool,
}

/// * `named` - the hypotheses that are named
pub(super) fn warnings(base: &Stage, named: &[&Refit]) -> Warnings {
    // What is missing may take modes away, or the base may be in a wrong valley: it stands first.
    let mut out: Vec<String> = unseen_modes(base).into_iter().collect();
    let (serious, slight) = match mesh_error(base) {
        Some(mesh) if mesh.is_serious => (Some(mesh.text), None),
        Some(mesh) => (None, Some(mesh.text)),
        None => (None, None),
    };
    let mesh_is_too_coarse = serious.is_some();
    out.extend(serious);
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
    if leaves_damping_aside(base) {
        out.push(
            "damping ratios are not used: the model has no damping; give members `stiffness_damping` or `mass_damping` under `overrides`"
                .to_string(),
        );
    }
    out.extend(slight);
    out.extend(named.iter().filter_map(|r| more_than_doubled(base, r)));
    out.extend(
        named
            .iter()
            .filter(|r| !r.limit_of.is_empty())
            .map(|r| format!("{} says the same as {} with fewer numbers", r.id(&base.scene), r.limit_of.join(", "))),
    );
    out.extend(named.iter().flat_map(|r| beyond_bounds(base, r)));
    let model = base.scene.model();
    let on_bounds: Vec<&str> = Scaling::new(model)
        .free()
        .iter()
        .zip(base.fit.x.iter())
        .filter(|(_, x)| **x < ON_BOUND || **x > 1.0 - ON_BOUND)
        .map(|(&i, _)| model.parameters().get(i).name.as_str())
        .collect();
    match on_bounds.as_slice() {
        [] => {}
        [one] => out.push(format!("a parameter of the fitted base sits on a bound: {one}")),
        many => out.push(format!("{} parameters of the fitted base sit on a bound: {}", many.len(), many.join(", "))),
    }
    Warnings { all: out, mesh_is_too_coarse }
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
    let in_words = |(_, e): (_, &super::Estimate)| {
        format!(
            "the estimate of {} sits on its bound, {} {}: the data ask for more than is thought possible",
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
            "{} is {:.1} times as stiff as the file says: perhaps a brace or a second load path that the model lacks",
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
    let unseen: Vec<String> = base.fit.overlooked.iter().zip(&base.scene.cases).flat_map(in_band).collect();
    let (what, verb) = match unseen.len() {
        0 => return None,
        1 => ("a mode", "has"),
        _ => ("modes", "have"),
    };
    Some(format!(
        "the fitted model has {what} inside the tested band that {verb} no partner in the test: {}; overlooked there, or not as the model has it",
        unseen.join(", ")
    ))
}
