//! The parameters of a model beside those of an earlier version.

use super::super::data::{Bound, Parameter, ReportData};
use super::LearntParameter;
use retune::model::{Model, ParametricModel};
use retune::update::ParameterChange;

/// What the parameters were in the first version of a model that has them and what they are now, where no update has told it.
///
/// A parameter that no earlier version has counts as unchanged.
pub fn add_parameters(data: &mut ReportData, earlier: &[&Model], now: &Model) {
    let u = data.update.get_or_insert_default();
    if u.has_moved() {
        return;
    }
    let in_version = |model: &&Model, name: &str| model.parameters().iter().find(|p| p.name == name).map(|p| p.value);
    u.parameters = now
        .parameters()
        .iter()
        .map(|p| {
            let was = earlier.iter().find_map(|model| in_version(model, &p.name)).unwrap_or(p.value);
            parameter(&ParameterChange {
                name: p.name.clone(),
                unit: p.unit.clone(),
                before: p.display(was),
                after: p.display(p.value),
                lower: p.bounds.map(|b| p.display(b[0])),
                upper: p.bounds.map(|b| p.display(b[1])),
                at_bound: p.at_bound(p.value),
                after_si: p.value,
            })
        })
        .collect();
}

/// What learning has made of the free parameters, where nothing else has told it: values before, intervals.
pub(super) fn add_learnt(data: &mut ReportData, now: &Model, learnt: &[LearntParameter]) {
    let u = data.update.get_or_insert_default();
    let all = now.parameters();
    if u.has_moved() {
        return;
    }
    for shown in &mut u.parameters {
        let found = learnt.iter().find(|l| l.name == shown.name).zip(all.index_of(&shown.name));
        let Some((l, p)) = found.map(|(l, i)| (l, all.get(i))) else { continue };
        (shown.before, shown.after) = (p.display(l.before), Some(p.display(p.value)));
        shown.interval = Some(l.interval.map(|v| p.display(v)));
        shown.interval_label = "90 %".into();
    }
}

/// The free parameters of a model where nothing has changed them.
pub(super) fn values(model: &Model, theta: &[f64]) -> Vec<Parameter> {
    let all = model.parameters();
    let shown = |(p, value): (&retune::model::Parameter, &f64)| {
        let [lower, upper] = p.bounds?.map(|b| p.display(b));
        let change = ParameterChange {
            name: p.name.clone(),
            unit: p.unit.clone(),
            before: p.display(*value),
            after: p.display(*value),
            lower: Some(lower),
            upper: Some(upper),
            at_bound: p.at_bound(*value),
            after_si: *value,
        };
        Some(Parameter { after: None, ..parameter(&change) })
    };
    all.iter().zip(theta).filter_map(shown).collect()
}

/// A parameter as tables show it.
pub(super) fn parameter(p: &ParameterChange) -> Parameter {
    let at_bound = p
        .lower
        .zip(p.upper)
        .filter(|_| p.at_bound)
        .map(|(lower, upper)| if p.after - lower < upper - p.after { Bound::Lower } else { Bound::Upper });
    Parameter {
        name: p.name.clone(),
        unit: p.unit.clone(),
        before: p.before,
        after: Some(p.after),
        lower: p.lower,
        upper: p.upper,
        at_bound,
        ..Parameter::default()
    }
}
