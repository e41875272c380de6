//! From analyses to [`ReportData`]: the structure, the modes of both sides, the comparison, the update.

use super::data::{
    Bound, Comparison, DataItem, Element, Floats, History, LabelledMatrix, Level, MassProperty, Meta, ModelMode, Modes,
    Named, Node, Pair, Parameter, PointMass, Property, ReportData, RigidLink, Sensor, Step, Steps, Structure, Support,
    TestMode, Verdict,
};
use crate::correlation::{CorrelationError, comac, odds, sensor_position};
use crate::data::{Origin, TestData};
use crate::element::{Axes, Dof};
use crate::linalg::{Complex, DMatrix};
use crate::model::{Model, ParametricModel, Target};
use crate::update::{AssessedPair, Assessment, ParameterChange, Update};

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

/// The report of a comparison.
pub fn of_comparison(case: Case<'_>) -> Result<ReportData, CorrelationError> {
    let Case { model, test, assessment } = case;
    Ok(ReportData {
        meta: meta(case),
        structure: Some(structure(model, test)?),
        modes: modes(case),
        comparison: Some(comparison(case)),
        ..ReportData::default()
    }
    .with_mass_properties(model, assessment))
}

/// The report of an update; `case.assessment` is taken from it.
pub fn of_update(model: &Model, test: &TestData, update: &Update) -> Result<ReportData, CorrelationError> {
    let case = Case { model, test, assessment: &update.after };
    let mut data = of_comparison(case)?;
    if let Some(c) = &mut data.comparison {
        c.pairs_before = pairs(&update.before);
        c.mac_before = Some(mac(&update.before, test, "MAC before the update"));
        c.comac_before = comac_of(&update.before, test);
    }
    let optimum = &update.optimum;
    let u = data.update.get_or_insert_with(Default::default);
    u.optimizer.clone_from(&optimum.method);
    u.termination = optimum.termination.text().to_string();
    u.evaluations = Some(optimum.evaluations + optimum.linearizations);
    u.cost_before = Some(update.cost_before);
    u.cost_after = Some(optimum.cost);
    u.histories = vec![History {
        name: optimum.method.clone(),
        evaluations: optimum.history.iter().map(|h| h.evaluations).collect(),
        best_cost: optimum.history.iter().map(|h| h.cost).collect(),
    }];
    u.parameters = update.parameters.iter().map(parameter).collect();
    for (p, before) in u.mass_properties.iter_mut().zip(mass_values(model, &update.before)) {
        p.before = before;
    }
    data.steps = Some(steps(&[("initial", &update.before), ("updated", &update.after)], test));
    Ok(data)
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
                per_mode: a.misfit_per_mode.iter().map(|m| Some(*m)).collect(),
                held_out: None,
                note: a.misfit.to_string(),
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
        self.update.get_or_insert_with(Default::default).mass_properties = rows.collect();
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
    [p.mass, p.cg[0], p.cg[1], p.cg[2], p.inertia[0][0], p.inertia[1][1], p.inertia[2][2]].map(Some)
}

fn meta(case: Case<'_>) -> Meta {
    let Case { model, test, assessment } = case;
    let misfit = &assessment.misfit;
    let explained = misfit.p_value > 0.01 && assessment.unpaired_test.is_empty();
    let sentence = if !assessment.unpaired_test.is_empty() {
        format!("{} measured modes have no partner in the model.", assessment.unpaired_test.len())
    } else if explained {
        "The model explains the test: noise of the stated size leaves as much.".to_string()
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
            number: format!("{:.0} for {} data", misfit.chi_squared, misfit.n_data),
            number_label: "chi-squared".into(),
            level: if explained { Level::Good } else { Level::Bad },
        }),
        versions: vec![Named::new("retune", env!("CARGO_PKG_VERSION"))],
        data_items,
        ..Meta::default()
    }
}

fn structure(model: &Model, test: &TestData) -> Result<Structure, CorrelationError> {
    let geometry = model.geometry();
    let spec = model.spec();
    let theta = model.parameters().nominal();
    let names: Vec<&str> = model.parameters().names().collect();
    let mut elements = Vec::new();
    let mut masses = Vec::new();
    for e in model.elements() {
        let mut properties = Vec::new();
        let mut parameters: Vec<String> = Vec::new();
        for (p, v) in e.kind.properties().iter().zip(&e.values) {
            let Some(v) = v else { continue };
            properties.push(Property::new(p.name, format!("{} {}", super::text::number(v.at(&theta)), p.unit)));
            for i in v.parameters() {
                if !parameters.iter().any(|n| n == names[i]) {
                    parameters.push(names[i].to_string());
                }
            }
        }
        let value = |name: &str| {
            let i = e.kind.properties().iter().position(|p| p.name == name)?;
            e.values[i].as_ref().map(|v| v.at(&theta))
        };
        if e.nodes.len() == 1 && value("mass").is_some() {
            let offset = ["offset_x", "offset_y", "offset_z"].map(|n| value(n).unwrap_or(0.0));
            masses.push(PointMass {
                name: e.name.clone(),
                node: e.nodes[0],
                mass: value("mass"),
                offset: (offset != [0.0; 3]).then_some(offset),
                parameters,
                properties,
            });
        } else {
            let group = e.path.split('.').nth(1).unwrap_or_default().to_string();
            let kind = if e.kind.axes() == Axes::AlongNodes { "beam".into() } else { e.kind.name().to_string() };
            elements.push(Element {
                name: e.name.clone(),
                kind,
                nodes: e.nodes.clone(),
                group,
                parameters,
                property_set: None,
                properties,
            });
        }
    }
    let node = |name: &String| geometry.node(name);
    let rigid_links = spec
        .rigid_links
        .iter()
        .filter_map(|(name, l)| {
            let slaves = l.slaves.iter().filter_map(node).collect();
            Some(RigidLink { name: name.clone(), master: node(&l.master)?, slaves })
        })
        .collect();
    let mut supports = Vec::new();
    for s in spec.supports.values() {
        let dofs = match &s.fixed {
            None => "all".to_string(),
            Some(list) => list.iter().map(|d| Dof::from(*d).name()).collect::<Vec<_>>().join(" "),
        };
        for n in s.node.iter().chain(s.nodes.iter().flatten()).filter_map(node) {
            supports.push(Support { node: n, dofs: dofs.clone() });
        }
    }
    let sensors = test
        .sensors
        .iter()
        .map(|s| {
            let attached_to = match &s.place {
                crate::data::Place::Node { node, .. } => node.clone(),
                crate::data::Place::Element { element, fraction, .. } => format!("{element} at {fraction}"),
            };
            Ok(Sensor {
                name: s.name.clone(),
                position: sensor_position(model, s)?,
                direction: s.direction,
                is_rotation: s.is_rotation,
                attached_to,
            })
        })
        .collect::<Result<Vec<_>, CorrelationError>>()?;
    Ok(Structure {
        up: Some(2),
        nodes: geometry
            .names
            .iter()
            .zip(&geometry.positions)
            .map(|(name, position)| Node { name: name.clone(), position: *position })
            .collect(),
        elements,
        rigid_links,
        masses,
        supports,
        sensors,
        ..Structure::default()
    })
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
    let test_modes = test
        .modes
        .iter()
        .enumerate()
        .map(|(i, m)| {
            let part = |f: fn(&Complex<f64>) -> f64| m.shape.as_ref().map(|s| Floats::from_f64(s.iter().map(f)));
            let complex = m.shape.as_ref().is_some_and(|s| s.iter().any(|v| v.im != 0.0 && !v.im.is_nan()));
            TestMode {
                label: test_label(test, i),
                frequency_hz: m.frequency_hz.value,
                frequency_sd: Some(m.frequency_hz.sd),
                damping_ratio: m.damping_ratio.map(|d| d.value),
                origin: m.shape_origin.as_ref().unwrap_or(&m.origin).word().into(),
                at_sensors: part(|v| v.re),
                at_sensors_imag: part(|v| v.im).filter(|_| complex),
                expanded: None,
            }
        })
        .collect();
    Modes { model: model_modes, test: test_modes }
}

fn test_label(test: &TestData, mode: usize) -> String {
    test.modes[mode].label.clone().unwrap_or_else(|| format!("mode {}", mode + 1))
}

fn comparison(case: Case<'_>) -> Comparison {
    let Case { test, assessment, .. } = case;
    Comparison {
        pairs: pairs(assessment),
        unpaired_test: assessment.unpaired_test.iter().map(|u| u.mode).collect(),
        unpaired_model: assessment.unpaired_model.iter().map(|u| u.mode).collect(),
        criteria: "frequency within 5 %, MAC at least 0.9".into(),
        frequency_band: 0.05,
        mac: Some(mac(assessment, test, "MAC")),
        comac: comac_of(assessment, test),
        ..Comparison::default()
    }
}

fn pairs(a: &Assessment) -> Vec<Pair> {
    let pair = |p: &AssessedPair| Pair {
        label: p.test_label.clone().unwrap_or_else(|| p.model_label.clone()),
        test_mode: Some(p.test_mode),
        model_mode: Some(p.model_mode),
        test_hz: p.test_hz,
        model_hz: p.model_hz,
        error: p.error_percent / 100.0,
        mac: p.mac,
        test_damping: None,
        passes: Some(p.error_percent.abs() <= 5.0 && p.mac.is_none_or(|m| m >= 0.9)),
        pass_probability: None,
    };
    a.pairs.iter().map(pair).collect()
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

fn parameter(p: &ParameterChange) -> Parameter {
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
