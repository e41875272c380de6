//! From analyses to [`ReportData`]: the structure, the modes of both sides, the comparison, the update, the diagnosis.

mod diagnosis;
mod disagreement;
mod identification;
mod learning;
mod orthogonality;
mod parameters;
mod posterior;
mod responses;
mod structure;

pub(super) use diagnosis::sentence;
pub use diagnosis::{LearningStep, LearntParameter, diagnosis, learning_steps};
pub use identification::of_identification;
pub use learning::{add_learning, misfit_before_any_fit, of_learning};
pub use parameters::add_parameters;
pub use posterior::of_posterior;
pub(super) use responses::typical_damping;
pub(super) use structure::structure as structure_of;

use super::data::{
    Combination, Comparison, DataItem, Floats, History, LabelledMatrix, Level, MassProperty, Meta, ModelMode, Modes,
    Named, Pair, ReportData, Step, Steps, TestMode, TestRecord, Verdict,
};
use super::text::number;
use parameters::parameter;
use retune::catalogue::counted;
use retune::correlation::{CorrelationError, comac, odds, probability_of_frequency, probability_of_mac};
use retune::data::{FrfSet, Origin, TestData};
use retune::identify::real_shape;
use retune::linalg::{Complex, DMatrix};
use retune::model::{Model, ParametricModel, Target};
use retune::update::{
    Alternative, AssessedPair, Assessment, HowToPair, ParameterChange, ParameterUncertainty, Uncertainty, Update,
    UpdateError, assess, compared, paired_test,
};

/// A model and a test that it was compared with.
#[derive(Debug, Clone, Copy)]
pub struct Case<'a> {
    /// The model as reported.
    pub model: &'a Model,
    /// The test.
    pub test: &'a TestData,
    /// Their comparison.
    pub assessment: &'a Assessment,
}

/// Compares a model at θ with a test as a report shows it, with inferred pairs.
pub fn assess_for_report(model: &Model, theta: &[f64], test: &TestData) -> Result<Assessment, UpdateError> {
    assess_paired(model, theta, test, &HowToPair::default())
}

/// The same, paired as a user asks.
pub fn assess_paired(
    model: &Model,
    theta: &[f64],
    test: &TestData,
    how: &HowToPair,
) -> Result<Assessment, UpdateError> {
    let paired = paired_test(model, Some(theta), test, how)?.test;
    let comparison = compared(model, &paired, how)?;
    assess(&comparison, theta)
}

/// The report of a comparison.
pub fn of_comparison(case: Case<'_>) -> Result<ReportData, CorrelationError> {
    let Case { model, test, assessment } = case;
    let mut structure = structure::structure(model, &assessment.theta, test)?;
    let comac = comac_of(assessment, test);
    let found = disagreement::disagreement(case, &structure)?;
    structure.fields = found.fields;
    let mut data = ReportData {
        meta: meta(case),
        structure: Some(structure),
        modes: modes(case),
        comparison: Some(comparison(case, comac)),
        localization: found.localization,
        ..ReportData::default()
    }
    .with_mass_properties(model, assessment);
    for (mode, shape) in found.expanded {
        data.modes.test[mode].expanded = Some(shape);
    }
    if let (Some(found), Some(c)) = (found.orthogonality, &mut data.comparison) {
        orthogonality::add_orthogonality(c, &found, case);
    }
    let u = data.update.get_or_insert_default();
    u.sensitivities = disagreement::sensitivities(case);
    u.parameters = parameters::values(model, &assessment.theta);
    Ok(data)
}

/// The tests that a report rests on, the first that of its pictures.
pub fn add_tests(data: &mut ReportData, tests: &[&TestData]) {
    data.meta.tests = tests.iter().map(|t| test_record(t)).collect();
}

/// What a report says of a test.
fn test_record(test: &TestData) -> TestRecord {
    let with = |n: usize, what: &str| (n > 0).then(|| counted(n, what));
    let sensors = with(test.sensors.len(), "sensor").map_or_else(String::new, |s| format!(" at {s}"));
    let modes = with(test.modes.len(), "mode").map(|m| m + &sensors);
    let functions = test.frfs.as_ref().and_then(|f| with(f.responses.len() * f.references.len(), "frequency response"));
    let parts = [
        modes,
        functions,
        with(test.static_tests.len(), "static test"),
        with(test.mass_properties.len(), "mass property"),
    ];
    TestRecord {
        name: test.name.clone(),
        date: test.date.map(|d| d.to_string()),
        configuration: test.configuration.clone(),
        content: parts.into_iter().flatten().collect::<Vec<_>>().join(", "),
    }
}

/// What a comparison was before: pairs, MAC, COMAC and mass properties beside those of now.
pub fn add_before(data: &mut ReportData, model: &Model, before: &Assessment, test: &TestData) {
    if let Some(c) = &mut data.comparison {
        c.pairs_before = pairs(before, test);
        c.mac_before = Some(mac(before, test, "MAC before"));
        c.comac_before = comac_of(before, test);
    }
    let u = data.update.get_or_insert_default();
    for (p, value) in u.mass_properties.iter_mut().zip(mass_values(model, before)) {
        p.before = value;
    }
}

/// The report of an update; its comparison is the one at the optimum.
pub fn of_update(model: &Model, test: &TestData, update: &Update) -> Result<ReportData, CorrelationError> {
    let case = Case { model, test, assessment: &update.after };
    let mut data = of_comparison(case)?;
    add_before(&mut data, model, &update.before, test);
    let optimum = &update.optimum;
    let evaluations = optimum.evaluations + optimum.linearizations;
    let u = data.update.get_or_insert_default();
    u.optimizer.clone_from(&optimum.method);
    u.termination = optimum.termination.text().to_string();
    u.evaluations = Some(evaluations);
    u.cost_before = Some(update.cost_before);
    u.cost_after = Some(optimum.cost);
    u.histories = vec![History {
        name: optimum.method.clone(),
        evaluations: optimum.history.iter().map(|h| h.evaluations).collect(),
        best_cost: optimum.history.iter().map(|h| h.cost).collect(),
    }];
    u.parameters = update.parameters.iter().map(parameter).collect();
    add_uncertainty(u, &update.uncertainty);
    data.meta.warnings.extend(update.alternatives.iter().map(|a| alternative(a, optimum.cost)));
    data.steps = Some(steps(&[("initial", &update.before), ("updated", &update.after)], test));
    data.meta.title.clone_from(&test.name);
    data.meta.subtitle = format!(
        "update of: {} ({}, {})",
        model.spec().name,
        optimum.method,
        counted(evaluations as usize, "evaluation")
    );
    if let Some(v) = &mut data.meta.verdict {
        let (before, after) = (&update.before.misfit, &update.after.misfit);
        v.number = format!("{} → {}", number(before.chi_squared), number(after.chi_squared));
        v.number_label = format!("chi-squared before and after the update; noise alone leaves about {}", after.n_data);
    }
    Ok(data)
}

/// A set of parameters that fits as well, in a sentence.
fn alternative(a: &Alternative, best: f64) -> String {
    let value = |p: &ParameterChange| {
        let known = a.uncertainty.parameters.iter().find(|k| k.name == p.name)?;
        let [low, high] = known.interval.map(number);
        Some(format!("{} = {} {} ({low} … {high})", p.name, number(p.after), p.unit))
    };
    let values: Vec<String> = a.parameters.iter().filter_map(value).collect();
    format!(
        "Another set of parameters fits as well, with a squared misfit of {:.2} in place of {:.2}: {}.",
        2.0 * a.cost,
        2.0 * best,
        values.join(", ")
    )
}

/// Intervals, correlations and what the data cannot tell apart.
fn add_uncertainty(u: &mut super::data::Update, found: &Uncertainty) {
    for known in &found.parameters {
        if let Some(p) = u.parameters.iter_mut().find(|p| p.name == known.name) {
            p.interval = Some(known.interval);
            p.interval_label = "90 %".into();
        }
    }
    // What has no correlation is blank, and its name says why.
    let name = |p: &ParameterUncertainty| p.why_no_sd().map_or(p.name.clone(), |why| format!("{}: {why}", p.name));
    let names: Vec<String> = found.parameters.iter().map(name).collect();
    if found.parameters.iter().any(|p| p.sd.is_some()) {
        u.correlation = Some(LabelledMatrix {
            title: "Correlation of the estimates".into(),
            row_axis: "parameter".into(),
            column_axis: "parameter".into(),
            rows: names.clone(),
            columns: names,
            values: disagreement::rounded(&found.correlations),
        });
    }
    u.unidentifiable = found
        .inseparable
        .iter()
        .map(|group| {
            let names = group.parameters.join(", ");
            let mut meaning = match group.n_numbers {
                0 => format!("{names}: no effect on these data"),
                1 => format!("{names} act only through one number"),
                n => format!("{names} act only through {n} numbers"),
            };
            if !group.combinations.is_empty() {
                meaning += &format!(": {}", group.combinations.join("; "));
            }
            if !group.shared.is_empty() {
                meaning += &format!(". Determined all the same: {}", group.shared.join(", "));
            }
            Combination { meaning, ..Combination::default() }
        })
        .collect();
}

/// A diagnosis of several tests names sensors of all; the page draws those of the first.
fn drawn_sensors_only(d: &mut super::data::Diagnosis, data: &ReportData) {
    let drawn = data.structure.as_ref().map_or(0, |s| s.sensors.len());
    d.hypotheses.iter_mut().for_each(|h| h.place.sensors.retain(|&s| s < drawn));
}

/// Adds a diagnosis to a report; its sentence becomes the verdict.
pub fn add_diagnosis(data: &mut ReportData, found: &retune_diagnosis::Diagnosis, model: &Model, test: &TestData) {
    let mut d = diagnosis(found, model, test);
    drawn_sensors_only(&mut d, data);
    data.meta.verdict = Some(diagnosis::verdict(&d));
    data.diagnosis = Some(d);
}

/// Adds measured frequency responses beside those of the model, and of the model before where there was one.
///
/// `origin` is `measured` or `synthetic`. Functions at points that are not sensors of the test are left out, with a
/// warning.
pub fn add_responses(
    data: &mut ReportData,
    case: Case<'_>,
    before: Option<Case<'_>>,
    frfs: &FrfSet,
    origin: &str,
) -> Result<(), CorrelationError> {
    data.frfs = responses::responses(case, before, frfs, origin)?;
    let is_sensor = |c: &&retune::data::Channel| case.test.sensors.iter().any(|s| s.name == c.name);
    let unknown: Vec<&str> =
        frfs.references.iter().chain(&frfs.responses).filter(|c| !is_sensor(c)).map(|c| c.name.as_str()).collect();
    if !unknown.is_empty() {
        let shown = unknown.iter().take(6).copied().collect::<Vec<_>>().join(", ");
        let more = if unknown.len() > 6 { format!(" and {} more", unknown.len() - 6) } else { String::new() };
        data.meta.warnings.push(format!(
            "Frequency responses at {shown}{more} are left out: the test has no sensors of these names."
        ));
    }
    Ok(())
}

/// The misfit of every test mode that has a partner; without one nothing is compared, which is not agreement.
fn misfit_of_paired(a: &Assessment) -> Vec<Option<f64>> {
    let is_paired = |mode: usize| a.pairs.iter().any(|p| p.test_mode == mode);
    a.misfit_per_mode.iter().enumerate().map(|(mode, misfit)| is_paired(mode).then_some(*misfit)).collect()
}

/// The misfit over versions of a model against one test.
pub fn steps(versions: &[(&str, &Assessment)], test: &TestData) -> Steps {
    Steps {
        measure: "chi-squared of frequencies and shapes: squared (model - test)/standard deviation, summed".into(),
        noise_floor: versions.first().map(|v| v.1.misfit.n_data as f64),
        mode_labels: (0..test.modes.len()).map(|i| test_label(test, i)).collect(),
        steps: versions
            .iter()
            .map(|(name, a)| Step {
                name: (*name).to_string(),
                misfit: a.misfit.chi_squared,
                per_mode: misfit_of_paired(a),
                held_out: None,
                note: a.misfit.to_string(),
                ..Step::default()
            })
            .collect(),
    }
}

impl ReportData {
    fn with_mass_properties(mut self, model: &Model, a: &Assessment) -> Self {
        let targets = model.targets();
        let all = std::iter::once(("total mass", "kg", targets.mass))
            .chain((0..3).map(|i| (["cg x", "cg y", "cg z"][i], "m", targets.cg[i])))
            .chain((0..3).map(|i| (["inertia xx", "inertia yy", "inertia zz"][i], "kg m²", targets.inertia[i])));
        let rows =
            all.zip(mass_values(model, a)).map(|((name, unit, target), after)| mass_row(name, unit, target, after));
        self.update.get_or_insert_default().mass_properties = rows.collect();
        self
    }
}

fn mass_row(name: &str, unit: &str, target: Option<Target>, after: Option<f64>) -> MassProperty {
    MassProperty {
        name: name.into(),
        unit: unit.into(),
        target: target.map(|t| t.value),
        tolerance: target.map(|t| t.tolerance),
        before: None,
        after,
        // An active target is met to rounding.
        within: target.zip(after).map(|(t, v)| (v - t.value).abs() <= t.tolerance * (1.0 + 1e-3)),
        source: if target.is_some() { "targets of the model file".into() } else { String::new() },
    }
}

fn mass_values(model: &Model, a: &Assessment) -> [Option<f64>; 7] {
    let p = a.mass_properties.or_else(|| model.mass_properties(&a.theta).ok().flatten());
    let Some(p) = p else { return [None; 7] };
    // Rounding of what symmetry makes zero is not a number to show.
    let shown = |v: f64| Some(if v.abs() < 1e-12 * p.mass { 0.0 } else { v });
    [p.mass, p.cg[0], p.cg[1], p.cg[2], p.inertia[0][0], p.inertia[1][1], p.inertia[2][2]].map(shown)
}

fn meta(case: Case<'_>) -> Meta {
    let Case { model, test, assessment } = case;
    let misfit = &assessment.misfit;
    let explained = misfit.p_value > 0.01 && assessment.unpaired_test.is_empty();
    let sentence = if !assessment.unpaired_test.is_empty() {
        match assessment.unpaired_test.len() {
            1 => "One measured mode has no partner in the model.".to_string(),
            n => format!("{n} measured modes have no partner in the model."),
        }
    } else if explained {
        "The model explains the test to within the stated noise.".to_string()
    } else {
        format!("The model does not explain the test: noise alone leaves this much in {}.", odds(misfit.p_value))
    };
    let mut data_items = Vec::new();
    let mut item = |name: &str, origin: &Origin| {
        let (Origin::Measured(source) | Origin::Synthetic(source)) = origin;
        let item = DataItem { name: name.into(), origin: origin.word().into(), source: source.clone() };
        if !data_items.contains(&item) {
            data_items.push(item);
        }
    };
    for mode in &test.modes {
        item("frequencies and damping", &mode.origin);
    }
    for origin in test.modes.iter().filter_map(|m| m.shape_origin.as_ref()) {
        item("mode shapes", origin);
    }
    for p in &test.mass_properties {
        item("mass properties", &p.origin);
    }
    Meta {
        title: model.spec().name.clone(),
        subtitle: format!("compared with: {}", test.name),
        verdict: Some(Verdict {
            sentence,
            number: number(misfit.chi_squared),
            number_label: format!("chi-squared; noise alone leaves about {}", misfit.n_data),
            level: if explained { Level::Good } else { Level::Bad },
        }),
        versions: vec![Named::new("retune", env!("CARGO_PKG_VERSION"))],
        data_items,
        tests: vec![test_record(test)],
        ..Meta::default()
    }
}

/// Above this many nodes beams are drawn straight between them, to keep the page small.
const LARGEST_WITH_ROTATIONS: usize = 2000;

fn modes(case: Case<'_>) -> Modes {
    let Case { model, test, assessment } = case;
    let prediction = &assessment.prediction;
    let dofs = model.dof_map();
    let at_sensors = &prediction.at_sensors;
    // As many as matter: all paired ones and those below 1.2 times the highest measured frequency.
    let last_paired = assessment.pairs.iter().map(|p| p.model_mode + 1).max().unwrap_or(0);
    let last_near = assessment.unpaired_model.iter().map(|u| u.mode + 1).max().unwrap_or(0);
    let count = last_paired.max(last_near).max(6).min(assessment.model_modes.len());
    let model_modes = (0..count)
        .map(|i| {
            let q = prediction.modes.shapes.column(prediction.modes.n_rigid + i).into_owned();
            let all = dofs.expand(&q);
            let part = |from: usize| {
                Floats::from_f64((0..all.nrows()).flat_map(|n| (from..from + 3).map(move |d| (n, d))).map(|at| all[at]))
            };
            ModelMode {
                label: assessment.model_modes[i].label.clone(),
                frequency_hz: assessment.model_modes[i].frequency_hz,
                displacement: part(0),
                rotation: (dofs.n_nodes() <= LARGEST_WITH_ROTATIONS).then(|| part(3)),
                at_sensors: Some(Floats::from_f64(at_sensors.column(i).iter().copied())),
                ..ModelMode::default()
            }
        })
        .collect();
    let test_modes = test.modes.iter().enumerate().map(|(i, m)| test_mode(m, test_label(test, i))).collect();
    Modes { model: model_modes, test: test_modes }
}

/// A mode of a test as the page has it.
fn test_mode(m: &retune::data::TestMode, label: String) -> TestMode {
    let part = |f: fn(&Complex<f64>) -> f64| m.shape.as_ref().map(|s| Floats::from_f64(s.iter().map(f)));
    let complex = m.shape.as_ref().is_some_and(|s| s.iter().any(|v| v.im != 0.0 && !v.im.is_nan()));
    TestMode {
        label,
        frequency_hz: m.frequency_hz.value,
        frequency_sd: Some(m.frequency_hz.sd),
        damping_ratio: m.damping_ratio.map(|d| d.value),
        origin: m.shape_origin.as_ref().unwrap_or(&m.origin).word().into(),
        at_sensors: part(|v| v.re),
        at_sensors_imag: part(|v| v.im).filter(|_| complex),
        ..TestMode::default()
    }
}

fn test_label(test: &TestData, mode: usize) -> String {
    test.modes[mode].label.clone().unwrap_or_else(|| format!("mode {}", mode + 1))
}

fn comparison(case: Case<'_>, comac: Option<Floats>) -> Comparison {
    let Case { test, assessment, .. } = case;
    Comparison {
        pairs: pairs(assessment, test),
        unpaired_test: assessment.unpaired_test.iter().map(|u| u.mode).collect(),
        unpaired_reasons: assessment.unpaired_test.iter().map(|u| u.reason.clone().unwrap_or_default()).collect(),
        unpaired_model: assessment.unpaired_model.iter().map(|u| u.mode).collect(),
        criteria: "frequency within 5 %, MAC at least 0.9".into(),
        frequency_band: FREQUENCY_TOLERANCE,
        mac: Some(mac(assessment, test, "MAC")),
        comac,
        ..Comparison::default()
    }
}

/// Pass marks of the pairs: largest relative frequency error, smallest MAC (the profile `common-practice`).
const FREQUENCY_TOLERANCE: f64 = 0.05;
const LEAST_MAC: f64 = 0.9;

/// The probability that the true frequency and the true MAC of a pair pass, given the noise of the test.
fn pass_probability(p: &AssessedPair, a: &Assessment, test: &TestData) -> f64 {
    /// A standard error of 0.011 at most.
    const SAMPLES: usize = 2000;
    let mode = &test.modes[p.test_mode];
    let f = mode.frequency_hz;
    let by_frequency = probability_of_frequency((p.model_hz, 0.0), (f.value, f.sd), FREQUENCY_TOLERANCE);
    let (Some(_), Some(shape), Some(sd)) = (p.mac, &mode.shape, &mode.shape_sd) else { return by_frequency };
    let measured = real_shape(shape);
    let model: Vec<f64> = a.prediction.at_sensors.column(p.model_mode).iter().copied().collect();
    let seed = p.test_mode as u64;
    by_frequency * probability_of_mac(&model, measured.as_slice(), sd.as_slice(), LEAST_MAC, SAMPLES, seed)
}

fn pairs(a: &Assessment, test: &TestData) -> Vec<Pair> {
    let pair = |p: &AssessedPair| Pair {
        label: pair_label(p).to_string(),
        test_mode: Some(p.test_mode),
        model_mode: Some(p.model_mode),
        test_hz: p.test_hz,
        model_hz: p.model_hz,
        error: p.error_percent / 100.0,
        mac: p.mac,
        test_damping: test.modes[p.test_mode].damping_ratio.map(|d| d.value),
        passes: Some(p.error_percent.abs() <= 100.0 * FREQUENCY_TOLERANCE && p.mac.is_none_or(|m| m >= LEAST_MAC)),
        pass_probability: Some(pass_probability(p, a, test)),
    };
    a.pairs.iter().map(pair).collect()
}

/// The test's name of a pair, else the model's.
fn pair_label(p: &AssessedPair) -> &str {
    p.test_label.as_deref().unwrap_or(&p.model_label)
}

fn mac(a: &Assessment, test: &TestData, title: &str) -> LabelledMatrix {
    let rows = a.mac.nrows().min(test.modes.len() + 4);
    let frequency = |label: &str, hz: f64| format!("{label} {hz:.2}");
    LabelledMatrix {
        title: title.into(),
        row_axis: "model".into(),
        column_axis: "test".into(),
        rows: a.model_modes[..rows].iter().map(|m| frequency(&m.label, m.frequency_hz)).collect(),
        columns: (0..test.modes.len())
            .map(|i| frequency(&test_label(test, i), test.modes[i].frequency_hz.value))
            .collect(),
        values: (0..rows).map(|i| a.mac.row(i).iter().copied().collect()).collect(),
    }
}

/// COMAC of every sensor over the paired modes that have a shape.
fn comac_of(a: &Assessment, test: &TestData) -> Option<Floats> {
    let paired: Vec<&AssessedPair> = a.pairs.iter().filter(|p| p.mac.is_some()).collect();
    if paired.is_empty() {
        return None;
    }
    let n = test.sensors.len();
    let analytical = DMatrix::from_fn(n, paired.len(), |k, j| a.prediction.at_sensors[(k, paired[j].model_mode)]);
    let experimental = DMatrix::from_fn(n, paired.len(), |k, j| {
        test.modes[paired[j].test_mode].shape.as_ref().map_or(f64::NAN, |s| s[k].re)
    });
    let values = comac(&analytical, &experimental);
    Some(Floats::from_f64(values.into_iter().map(|v| v.unwrap_or(f64::NAN))))
}

#[cfg(test)]
mod tests;
