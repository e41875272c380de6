//! Where model and test disagree, as colours on the structure and as a ranking.

use super::super::data::{Carrier, Field, Floats, Localization, Place, Scale, Structure, Suspect};
use super::Case;
use super::structure::{drawn, group};
use crate::correlation::{
    CorrelationError, ElementMatrix, ExpandedMode, Expander, MODEL_ERROR, by_group, element_energies, group_matrices,
    localize, observation_matrix, odds, sensor_misfits, shape_residual,
};
use crate::linalg::{DMatrix, DVector};
use crate::model::{Model, ModelError, ParametricModel};

/// Expansion solves the dense eigenproblem of the whole model; above this many dofs a page would wait for it.
const LARGEST: usize = 1200;
/// Modes whose strain energy is shown.
const MOST_ENERGIES: usize = 12;
/// Places in the ranking.
const RANKED: usize = 12;
/// A family of p-values below this stands out.
const SIGNIFICANT: f64 = 0.01;

/// Stiffness of every element on the dofs of the model.
fn stiffnesses(model: &Model, theta: &[f64]) -> Result<Vec<ElementMatrix>, ModelError> {
    let matrices = |(i, e): (usize, &crate::model::PlacedElement)| {
        let (rows, motion) = model.element_motion(i);
        let local = model.element_matrices(i, theta)?.stiffness.to_dense();
        Ok(ElementMatrix {
            name: e.name.clone(),
            group: Some(group(e).to_string()),
            dofs: rows.to_vec(),
            matrix: motion.transpose() * local * motion,
        })
    };
    model.elements().iter().enumerate().map(matrices).collect()
}

/// Fields that colour the structure, and the ranking of places where a ranking is possible.
pub(super) fn disagreement(
    case: Case<'_>,
    structure: &Structure,
) -> Result<(Vec<Field>, Option<Localization>), CorrelationError> {
    let Case { model, assessment, .. } = case;
    let mut fields = Vec::new();
    let mut found = None;
    if model.dof_map().n_dof() <= LARGEST {
        let elements = stiffnesses(model, &assessment.theta).map_err(|e| CorrelationError::Model(e.to_string()))?;
        let index = drawn(model);
        // A model that resists expansion still has its other colours.
        if let Ok(Some((list, localization))) = localization(case, &elements, structure, &index) {
            fields.extend(list);
            found = Some(localization);
        }
        fields.extend(energies(case, &elements, structure, &index)?);
    }
    fields.extend(sensor_field(case)?);
    Ok((fields, found))
}

fn localization(
    case: Case<'_>,
    elements: &[ElementMatrix],
    structure: &Structure,
    index: &[Option<usize>],
) -> Result<Option<([Field; 2], Localization)>, CorrelationError> {
    let Case { model, test, assessment } = case;
    let p = &assessment.prediction;
    let observed = observation_matrix(model, &test.sensors)?;
    let Some(&first) = p.frequencies_hz.first().filter(|f| **f > 0.0) else { return Ok(None) };
    let shift = 0.5 * (std::f64::consts::TAU * first).powi(2);
    let expander = Expander::new(&p.system.stiffness, &p.system.mass, &observed, shift)?;
    let mut expanded = Vec::new();
    for pair in assessment.pairs.iter().filter(|p| p.mac.is_some()) {
        let mode = &test.modes[pair.test_mode];
        let Some(shape) = &mode.shape else { continue };
        let y = shape.map(|v| v.re);
        let sd = mode.shape_sd.clone().unwrap_or_else(|| {
            let largest = y.iter().copied().filter(|v| v.is_finite()).fold(0.0_f64, |a, v| a.max(v.abs()));
            DVector::from_element(y.len(), crate::data::DEFAULT_SHAPE_SD * largest)
        });
        // The modal mass of the test's shape, by its scale against the mass-normalised shape of the model.
        let own = p.at_sensors.column(pair.model_mode);
        let measured = || (0..y.len()).filter(|&i| y[i].is_finite());
        let size: f64 = measured().map(|i| own[i] * own[i]).sum();
        let scale = measured().map(|i| own[i] * y[i]).sum::<f64>() / size;
        if !(scale.is_finite() && scale != 0.0) {
            continue;
        }
        let (mass, omega2) = (scale * scale, (std::f64::consts::TAU * pair.test_hz).powi(2));
        let weight = expander.weight(MODEL_ERROR, omega2, mass);
        expanded.push((expander.expand(&y, &sd, omega2, weight)?, sd, 1.0 / (omega2 * mass)));
    }
    if expanded.is_empty() {
        return Ok(None);
    }
    let modes: Vec<ExpandedMode<'_>> =
        expanded.iter().map(|(expanded, sd, weight)| ExpandedMode { expanded, sd, weight: *weight }).collect();
    // Point masses and other elements without stiffness have no energy to show.
    let stiff: Vec<ElementMatrix> = elements.iter().filter(|e| e.matrix.amax() > 0.0).cloned().collect();
    let by_element = localize(&modes, &stiff)?;
    let groups = group_matrices(&stiff);
    let by_group = localize(&modes, &groups)?;
    let members = |name: &str| -> Vec<usize> {
        let is_member = |i: &usize| elements[*i].group.as_deref() == Some(name);
        (0..elements.len()).filter(is_member).filter_map(|i| index[i]).collect()
    };
    let alone = |name: &str| -> Vec<usize> {
        elements.iter().position(|e| e.name == name).and_then(|i| index[i]).into_iter().collect()
    };
    let suspect = |p: &crate::correlation::Place, elements: Vec<usize>| Suspect {
        place: Place { text: p.name.clone(), elements, ..Place::default() },
        above_noise: (p.noise_quantile > 0.0).then(|| p.energy / p.noise_quantile),
        relative_energy: Some(p.relative_energy),
        p_value: Some(p.p_value),
    };
    let on_elements: Vec<Suspect> = by_element.places.iter().map(|p| suspect(p, alone(&p.name))).collect();
    let on_groups: Vec<Suspect> = by_group.places.iter().map(|p| suspect(p, members(&p.name))).collect();
    let field = |name: &str, about: &str, list: &[Suspect]| {
        let mut values = vec![f64::NAN; structure.elements.len()];
        for s in list {
            for &i in &s.place.elements {
                values[i] = s.above_noise.unwrap_or(f64::NAN);
            }
        }
        Field {
            name: name.into(),
            unit: String::new(),
            on: Carrier::Elements,
            scale: Scale::Sequential,
            about: about.into(),
            values: Floats::from_f64(values),
        }
    };
    let fields = [
        field(
            "disagreement by element",
            "Energy of the model error in each element over what noise alone exceeds in 5 % of tests: above 1 stands out.",
            &on_elements,
        ),
        field(
            "disagreement by group",
            "Energy of the model error in each group over what noise alone exceeds in 5 % of tests: above 1 stands out.",
            &on_groups,
        ),
    ];
    let stands_out = by_element.stands_out(SIGNIFICANT);
    let sentence = match by_element.places.first() {
        Some(worst) if stands_out => format!(
            "{} stands out most: noise alone gives any element as much in {}. It points at errors of the model as it is; \
             a fit could absorb some of them.",
            worst.name,
            odds(by_element.p_family)
        ),
        _ => format!("Nothing stands out: noise alone gives any element as much in {}.", odds(by_element.p_family)),
    };
    let first = |mut list: Vec<Suspect>| {
        list.truncate(RANKED);
        list
    };
    let localization = Localization {
        sentence,
        stands_out,
        p_family: Some(by_element.p_family),
        elements: first(on_elements),
        groups: if groups.len() > 1 { first(on_groups) } else { Vec::new() },
    };
    Ok(Some((fields, localization)))
}

/// Shares of strain energy of the paired modes.
fn energies(
    case: Case<'_>,
    elements: &[ElementMatrix],
    structure: &Structure,
    index: &[Option<usize>],
) -> Result<Vec<Field>, CorrelationError> {
    let assessment = case.assessment;
    let modes = &assessment.prediction.modes;
    let mut shown: Vec<usize> = assessment.pairs.iter().map(|p| p.model_mode).collect();
    shown.sort_unstable();
    shown.truncate(MOST_ENERGIES);
    let mut fields = Vec::new();
    for mode in shown {
        let shape = modes.shapes.column(modes.n_rigid + mode).into_owned();
        let energy = element_energies(&shape, elements, 1.0)?;
        let total: f64 = by_group(elements, &energy).values().sum();
        if total <= 0.0 {
            continue;
        }
        let mut values = vec![f64::NAN; structure.elements.len()];
        for (e, at) in energy.iter().zip(index) {
            if let Some(i) = at {
                values[*i] = 100.0 * e / total;
            }
        }
        let label = &assessment.model_modes[mode].label;
        fields.push(Field {
            name: format!("strain energy, {label}"),
            unit: "%".into(),
            on: Carrier::Elements,
            scale: Scale::Sequential,
            about: "Share of the strain energy of this mode: where it is large, the frequency depends on the element."
                .into(),
            values: Floats::from_f64(values),
        });
    }
    Ok(fields)
}

/// Misfit of every sensor over the paired modes, per degree of freedom.
fn sensor_field(case: Case<'_>) -> Result<Option<Field>, CorrelationError> {
    let Case { test, assessment, .. } = case;
    let mut residuals = Vec::new();
    for pair in assessment.pairs.iter().filter(|p| p.mac.is_some()) {
        let mode = &test.modes[pair.test_mode];
        let (Some(shape), Some(sd)) = (&mode.shape, &mode.shape_sd) else { continue };
        let own: DVector<f64> = assessment.prediction.at_sensors.column(pair.model_mode).into_owned();
        let measured: DVector<f64> = shape.map(|v| v.re);
        if let Ok(r) = shape_residual(own.as_slice(), measured.as_slice(), sd.as_slice()) {
            residuals.push(r);
        }
    }
    if residuals.is_empty() {
        return Ok(None);
    }
    let misfits = sensor_misfits(&residuals)?;
    Ok(Some(Field {
        name: "misfit of the sensors".into(),
        unit: String::new(),
        on: Carrier::Sensors,
        scale: Scale::Sequential,
        about: "Mean of ((model - test)/standard deviation)² over the paired shapes: noise alone leaves about 1."
            .into(),
        values: Floats::from_f64(misfits.iter().map(|m| m.chi_squared / (m.n_data as f64))),
    }))
}

/// How the frequencies and shapes of the paired modes move with the free parameters.
///
/// Each column for a tenth of the range between the bounds; the part of ∂φ along φ is a change of scale and left out.
pub(super) fn sensitivities(case: Case<'_>) -> Vec<super::super::data::LabelledMatrix> {
    use super::super::data::LabelledMatrix;
    let Case { model, test, assessment } = case;
    let parameters = model.parameters();
    let free = parameters.free();
    if free.is_empty() || free.len() > 60 || model.dof_map().n_dof() > LARGEST || assessment.pairs.is_empty() {
        return Vec::new();
    }
    let options = crate::correlation::PairingOptions::default();
    let Ok(comparison) = crate::objective::Comparison::new(model, test, options) else { return Vec::new() };
    // A double mode has no shape derivative; the page then goes without.
    let Ok(d) = comparison.differentiate(&assessment.theta, &assessment.prediction, &free) else { return Vec::new() };
    let tenth: Vec<f64> = free.iter().map(|&j| parameters.get(j).bounds.map_or(0.0, |[l, u]| 0.1 * (u - l))).collect();
    let (mut rows, mut frequencies, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
    for pair in &assessment.pairs {
        let Some((df, dphi)) = &d.modes[pair.model_mode] else { continue };
        rows.push(format!("{} {:.2}", super::pair_label(pair), pair.model_hz));
        frequencies.push((0..free.len()).map(|j| 100.0 * df[j] * tenth[j] / pair.model_hz).collect::<Vec<f64>>());
        let phi = assessment.prediction.at_sensors.column(pair.model_mode).into_owned();
        let norm = phi.norm();
        let turn = |j: usize| {
            let change: DVector<f64> = dphi.column(j) * tenth[j];
            let across = &change - &phi * (phi.dot(&change) / (norm * norm));
            100.0 * across.norm() / norm
        };
        shapes.push((0..free.len()).map(turn).collect::<Vec<f64>>());
    }
    let columns: Vec<String> = free.iter().map(|&j| parameters.get(j).name.clone()).collect();
    let matrix = |title: &str, values: Vec<Vec<f64>>| LabelledMatrix {
        title: title.into(),
        row_axis: "mode".into(),
        column_axis: "parameter".into(),
        rows: rows.clone(),
        columns: columns.clone(),
        values,
    };
    let mut out = vec![matrix("Change of the frequency, %", frequencies)];
    if assessment.pairs.iter().any(|p| p.mac.is_some()) && shapes.iter().flatten().all(|v| v.is_finite()) {
        out.push(matrix("Change of the shape, % of its size", shapes));
    }
    out
}

/// A matrix with three digits a value: enough to colour, small to send.
pub(super) fn rounded(values: &DMatrix<f64>) -> Vec<Vec<f64>> {
    values.row_iter().map(|r| r.iter().map(|v| (v * 1000.0).round() / 1000.0).collect()).collect()
}
