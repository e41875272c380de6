//! Where model and test disagree, as colours on the structure and as a ranking.

use super::super::data::{Carrier, Field, Floats, Localization, Place, Scale, Structure, Suspect};
use super::Case;
use retune::correlation::{CorrelationError, PairingOptions, element_energies, odds, sensor_misfits, shape_residual};
use retune::identify::real_shape;
use retune::linalg::{DMatrix, DVector};
use retune::model::{Model, ParametricModel};
use retune::update::{MassReduction, Orthogonality, PlacesOptions, member_stiffnesses, orthogonality, places};

/// Expansion solves the dense eigenproblem of the whole model; above this many dofs a page would wait for it.
const LARGEST: usize = 1200;
/// Modes whose strain energy is shown.
const MOST_ENERGIES: usize = 12;
/// Places in the ranking.
const RANKED: usize = 12;
/// A family of p-values below this stands out.
const SIGNIFICANT: f64 = 0.01;

/// What is known of where model and test disagree.
#[derive(Default)]
pub(super) struct Disagreement {
    /// Fields that colour the structure.
    pub(super) fields: Vec<Field>,
    /// The ranking of places, where a ranking is possible.
    pub(super) localization: Option<Localization>,
    /// Test modes with their shapes at all nodes, (ux, uy, uz) node after node, on the scale of the real test shape.
    pub(super) expanded: Vec<(usize, Floats)>,
    /// Orthogonality of the paired shapes.
    pub(super) orthogonality: Option<Orthogonality>,
}

/// Looks for it.
pub(super) fn disagreement(case: Case<'_>, structure: &Structure) -> Result<Disagreement, CorrelationError> {
    let mut out = Disagreement::default();
    if case.model.dof_map().n_dof() <= LARGEST {
        // A model that resists expansion still has its other colours.
        if let Ok(comparison) = retune::objective::Comparison::new(case.model, case.test, PairingOptions::default()) {
            if let Some((list, localization, expanded)) = localization(case, &comparison, structure) {
                out.fields.extend(list);
                out.localization = Some(localization);
                out.expanded = expanded;
            }
            // A mass that no reduction brings to these sensors tells nothing.
            out.orthogonality = orthogonality(&comparison, case.assessment, MassReduction::Auto).ok().flatten();
        }
        out.fields.extend(energies(case, structure)?);
    }
    out.fields.extend(thickness(case.model, &case.assessment.theta));
    out.fields.extend(sensor_field(case)?);
    Ok(out)
}

/// The thickness of plates and shells.
fn thickness(model: &Model, theta: &[f64]) -> Option<Field> {
    let of = |e: &retune::model::PlacedElement| {
        let i = e.kind.properties().iter().position(|p| p.name == "thickness")?;
        e.values[i].as_ref().map(|v| v.at(theta))
    };
    let values: Vec<f64> =
        super::structure::drawn_elements(model).map(|e| of(e).map_or(f64::NAN, |t| 1e3 * t)).collect();
    values.iter().any(|v| v.is_finite()).then(|| Field {
        name: "thickness".into(),
        unit: "mm".into(),
        on: Carrier::Elements,
        scale: Scale::Sequential,
        anchor: None,
        about: "Thickness of the plates and shells.".into(),
        values: Floats::from_f64(values),
    })
}

/// The drawn elements of a member of the file: itself, or the parts that it was divided into.
fn parts(structure: &Structure, member: &str) -> Vec<usize> {
    let is_part = |name: &str| name.strip_prefix(member).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    (0..structure.elements.len()).filter(|&i| is_part(&structure.elements[i].name)).collect()
}

/// Two colours, the ranking, and the expanded shapes that both rest on.
type Localized = ([Field; 2], Localization, Vec<(usize, Floats)>);

fn localization(
    case: Case<'_>,
    comparison: &retune::objective::Comparison<'_>,
    structure: &Structure,
) -> Option<Localized> {
    let Case { model, assessment, .. } = case;
    let found = places(model, comparison, assessment, PlacesOptions::default()).ok()?;
    let dofs = model.dof_map();
    let at_nodes = |(mode, q): &(usize, DVector<f64>)| {
        let all = dofs.expand(q);
        (*mode, Floats::from_f64((0..all.nrows()).flat_map(|n| (0..3).map(move |d| (n, d))).map(|at| all[at])))
    };
    let expanded = found.expanded.iter().map(at_nodes).collect();
    let (by_element, by_group) = (found.by_element, found.by_group);
    let members = |name: &str| -> Vec<usize> {
        (0..structure.elements.len()).filter(|&i| structure.elements[i].group == name).collect()
    };
    let suspect = |p: &retune::correlation::Place, elements: Vec<usize>| Suspect {
        place: Place { text: p.name.clone(), elements, ..Place::default() },
        above_noise: (p.noise_quantile > 0.0).then(|| p.energy / p.noise_quantile),
        relative_energy: Some(p.relative_energy),
        p_value: Some(p.p_value),
    };
    let on_elements: Vec<Suspect> = by_element.places.iter().map(|p| suspect(p, parts(structure, &p.name))).collect();
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
            anchor: Some(1.0),
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
        groups: if on_groups.len() > 1 { first(on_groups) } else { Vec::new() },
    };
    Some((fields, localization, expanded))
}

/// Shares of strain energy of the paired modes.
fn energies(case: Case<'_>, structure: &Structure) -> Result<Vec<Field>, CorrelationError> {
    let Case { model, assessment, .. } = case;
    let elements = member_stiffnesses(model, &assessment.theta).map_err(|e| CorrelationError::Model(e.to_string()))?;
    let drawn: Vec<Vec<usize>> = elements.iter().map(|e| parts(structure, &e.name)).collect();
    let modes = &assessment.prediction.modes;
    let mut shown: Vec<usize> = assessment.pairs.iter().map(|p| p.model_mode).collect();
    shown.sort_unstable();
    shown.truncate(MOST_ENERGIES);
    let mut fields = Vec::new();
    for mode in shown {
        let shape = modes.shapes.column(modes.n_rigid + mode).into_owned();
        let energy = element_energies(&shape, &elements, 1.0)?;
        let total: f64 = energy.iter().sum();
        if total <= 0.0 {
            continue;
        }
        let mut values = vec![f64::NAN; structure.elements.len()];
        // The parts of a divided member share its energy.
        for (e, list) in energy.iter().zip(&drawn) {
            for &i in list {
                values[i] = 100.0 * e / total / list.len() as f64;
            }
        }
        let label = &assessment.model_modes[mode].label;
        fields.push(Field {
            name: format!("strain energy, {label}"),
            unit: "%".into(),
            on: Carrier::Elements,
            scale: Scale::Sequential,
            anchor: None,
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
        let measured = real_shape(shape);
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
        anchor: Some(1.0),
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
    let options = PairingOptions::default();
    let Ok(comparison) = retune::objective::Comparison::new(model, test, options) else { return Vec::new() };
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
