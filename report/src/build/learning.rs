//! The report of learning: what was added step by step, and how the error fell.

use super::super::data::ReportData;
use super::diagnosis::{self, LearningStep, learning_steps};
use super::parameters::{self, parameter};
use super::{Case, add_before, assess_for_report, drawn_sensors_only, of_comparison};
use retune::data::{TestData, joined};
use retune::model::{Model, ParametricModel};
use retune::update::{ParameterChange, UpdateError};
use retune_diagnosis::Learned;

/// The report of learning: the last model against the test, the error over all steps, every diagnosis.
///
/// `cases` are the tests as they were given, each with the model in its configuration; shapes and pairs are those of the first.
/// Where a step took a fault out of the data, the last model is compared with the corrected data, and the model before with the
/// data as measured; the report says so.
pub fn of_learning(cases: &[(&Model, &TestData)], learned: &Learned) -> Result<ReportData, UpdateError> {
    let Some(&(model, test)) = cases.first() else { return Err(UpdateError::NoData) };
    let tests: Vec<&TestData> = cases.iter().map(|c| c.1).collect();
    let Some(last) = learned.steps.last() else {
        let assessment = assess_for_report(model, &model.parameters().nominal(), test)?;
        return Ok(of_comparison(Case { model, test, assessment: &assessment })?);
    };
    let before = assess_for_report(model, &model.parameters().nominal(), test)?;
    let corrected = learned.tests.first().unwrap_or(test);
    let after = assess_for_report(&last.model, &last.theta, corrected)?;
    let mut data = of_comparison(Case { model: &last.model, test: corrected, assessment: &after })?;
    add_before(&mut data, model, &before, test);
    let initial = model.parameters();
    let value_before = |name: &str, now: f64| initial.index_of(name).map_or(now, |i| initial.get(i).value);
    let u = data.update.get_or_insert_default();
    u.objective = "weighted least squares with priors".into();
    u.parameters = last
        .model
        .parameters()
        .iter()
        .zip(&last.theta)
        .map(|(p, &value)| {
            let mut shown = parameter(&ParameterChange {
                name: p.name.clone(),
                unit: p.unit.clone(),
                before: p.display(value_before(&p.name, p.value)),
                after: p.display(value),
                lower: p.bounds.map(|b| p.display(b[0])),
                upper: p.bounds.map(|b| p.display(b[1])),
                at_bound: p.at_bound(value),
                after_si: value,
            });
            if let Some(e) = last.parameters.iter().find(|e| e.parameter == p.name) {
                shown.interval = Some(e.interval.map(|v| p.display(v)));
                shown.interval_label = "90 %".into();
            }
            shown
        })
        .collect();
    let records: Vec<LearningStep> = learned.steps.iter().map(LearningStep::from).collect();
    add_learning(&mut data, &last.model, &joined(&tests).test, &records, misfit_before_any_fit(cases)?);
    for id in learned.steps.iter().filter_map(|s| s.corrected.as_ref()) {
        data.meta.warnings.push(format!(
            "The data were corrected for {id}: the last model is compared with corrected data, the one before with those measured."
        ));
    }
    data.meta.title.clone_from(&test.name);
    let name = &model.spec().name;
    data.meta.subtitle = match diagnosis::found(&records).as_slice() {
        [] => format!("what {name} lacks: nothing found"),
        all => format!("what {name} lacks: {}", all.join(", ")),
    };
    Ok(data)
}

/// Misfit of the values of the file, in total and per mode through all tests; none of a mode without a partner.
pub fn misfit_before_any_fit(cases: &[(&Model, &TestData)]) -> Result<(f64, Vec<Option<f64>>), UpdateError> {
    let (mut total, mut per_mode) = (0.0, Vec::new());
    for &(model, test) in cases {
        let a = assess_for_report(model, &retune::objective::starting_point(model), test)?;
        total += a.misfit.chi_squared;
        per_mode.extend(super::misfit_of_paired(&a));
    }
    Ok((total, per_mode))
}

/// Adds the steps of learning and their diagnoses to a report.
pub fn add_learning(
    data: &mut ReportData,
    model: &Model,
    test: &TestData,
    steps: &[LearningStep],
    (initial, per_mode): (f64, Vec<Option<f64>>),
) {
    data.steps = Some(learning_steps(steps, Some((initial, &per_mode)), test));
    let (mut earlier, mut last) = diagnosis::diagnoses(steps, model, test);
    earlier.iter_mut().chain(&mut last).for_each(|d| drawn_sensors_only(d, data));
    (data.earlier_diagnoses, data.diagnosis) = (earlier, last);
    parameters::add_learnt(data, model, steps.last().map_or(&[], |s| &s.parameters));
    data.meta.verdict = data.diagnosis.as_ref().map(|d| diagnosis::verdict_of_learning(d, steps));
}
