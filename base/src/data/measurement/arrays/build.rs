//! From the variables that were recognised to functions and modes.

use super::names::{Says, says};
use super::pick::{Functions, Modes, Source};
use super::{MeasurementError, MeasurementOptions, ModeTable, Variable};
use crate::catalogue::{Choice, counted};
use crate::data::convert::{ConvertError, Question, UnitSystem, UnitsFrom};
use crate::data::{Channel, FrfQuantity, FrfSet, npy};
use retune_linalg::Complex;
use std::borrow::Cow;
use std::f64::consts::TAU;

fn unusable(variable: &Variable, why: String) -> MeasurementError {
    ConvertError::Unusable { what: format!("variable {}", variable.label()), why }.into()
}

/// Frequencies in Hz: by the stated unit, else by the one that the name says; NaN where it must be asked for.
fn hertz(
    variable: &Variable,
    options: &MeasurementOptions,
    notes: &mut Vec<String>,
    questions: &mut Vec<Question>,
) -> Vec<f64> {
    let name = variable.name.escape_debug();
    let (one, unit) = match (&options.frf.frequency_unit, says(&variable.name)) {
        (Some(unit), _) => (unit.hertz, unit.name.clone()),
        (None, Says::Frequency(hertz)) => {
            let unit = [(1.0, "Hz"), (1e3, "kHz"), (1.0 / TAU, "rad/s"), (1.0 / 360.0, "deg/s"), (1.0 / 60.0, "rpm")];
            (hertz, unit.iter().find(|u| u.0 == hertz).map_or("Hz", |u| u.1).to_string())
        }
        _ => {
            questions.push(Question {
                option: "frequency-unit",
                text: format!("`{name}` does not say its unit of frequency"),
                answers: ["Hz", "rad/s", "kHz", "rpm"].map(String::from).to_vec(),
            });
            (f64::NAN, String::new())
        }
    };
    if options.frf.frequency_unit.is_none() && one.is_finite() {
        notes.push(format!("variable `{name}` is taken for frequencies in {unit}; `--frequency-unit` says otherwise"));
    }
    variable.vector().unwrap_or_default().iter().map(|f| f * one).collect()
}

/// Offset of an index along some axes in values with the last axis fastest.
fn strides(axes: &[usize]) -> Vec<usize> {
    let mut strides = vec![1; axes.len()];
    for a in (0..axes.len().saturating_sub(1)).rev() {
        strides[a] = strides[a + 1] * axes[a + 1];
    }
    strides
}

/// Functions in SI; `None` where a question is left.
pub(super) fn functions(
    list: &[Cow<'_, Variable>],
    picked: &Functions,
    options: &MeasurementOptions,
    notes: &mut Vec<String>,
    questions: &mut Vec<Question>,
) -> Result<Option<FrfSet>, MeasurementError> {
    let variable = &list[picked.values];
    let frequencies_hz = hertz(&list[picked.frequency], options, notes, questions);
    notes.push(format!("variable `{}` is taken for its functions", variable.name.escape_debug()));
    notes.extend(picked.notes.iter().cloned());
    let system = match &options.frf.units {
        UnitsFrom::System(system) => Some(system),
        _ => {
            questions.push(Question {
                option: "units",
                text: "an array has no units".to_string(),
                answers: UnitSystem::NAMES.map(String::from).to_vec(),
            });
            None
        }
    };
    if options.frf.quantity.is_none() {
        questions.push(Question {
            option: "quantity",
            text: "an array does not say what was measured".to_string(),
            answers: FrfQuantity::ALL.iter().map(|(_, word, _)| (*word).to_string()).collect(),
        });
    }
    let (Some(system), Some(quantity), true) = (system, options.frf.quantity, questions.is_empty()) else {
        return Ok(None);
    };
    if let Some(line) = (1..frequencies_hz.len()).find(|&l| {
        frequencies_hz[l].is_nan() || frequencies_hz[l - 1].is_nan() || frequencies_hz[l] <= frequencies_hz[l - 1]
    }) {
        let function = list[picked.frequency].name.clone();
        return Err(ConvertError::NotAscending { function, line }.into());
    }
    let axes = variable.axes();
    let steps = strides(&axes);
    let length = |axis: Option<usize>| axis.map_or(1, |a| axes[a]);
    let step = |axis: Option<usize>| axis.map_or(0, |a| steps[a]);
    let (n_references, n_points, n_components) =
        (length(picked.references), length(picked.responses), length(picked.components));
    let n_responses = n_points * n_components;
    let order: Vec<usize> = (0..frequencies_hz.len())
        .flat_map(|line| (0..n_references).map(move |a| (line, a)))
        .flat_map(|(line, a)| (0..n_responses).map(move |b| (line, a, b)))
        .map(|(line, a, b)| {
            let (point, component) = (b / n_components, b % n_components);
            line * steps[picked.lines]
                + a * step(picked.references)
                + point * step(picked.responses)
                + component * step(picked.components)
        })
        .collect();
    let scale = system.response(quantity) / system.force;
    let channels = |prefix: &str, n: usize| {
        (0..n).map(|k| Channel { name: format!("{prefix}{}", k + 1), direction: None }).collect::<Vec<_>>()
    };
    Ok(Some(FrfSet {
        quantity,
        references: channels("force", n_references),
        responses: if picked.components.is_some() {
            (0..n_responses)
                .map(|b| {
                    let axis = b % n_components;
                    let direction = Some([0, 1, 2].map(|k| if k == axis { 1.0 } else { 0.0 }));
                    Channel { name: format!("p{}", b / n_components + 1), direction }
                })
                .collect()
        } else {
            channels("p", n_responses)
        },
        h: order.iter().map(|k| variable.at(*k) * scale).collect(),
        coherence: picked.coherence.map(|c| order.iter().map(|k| list[c].at(*k).re).collect()),
        frequencies_hz,
        n_averages: None,
    }))
}

/// Frequencies and damping ratios of eigenvalues, with the index of each: poles λ in 1/s, |λ| = ω, ζ = -Re λ/|λ|; real ones are
/// ω² in rad²/s². Of a pair of conjugate poles the one with the positive imaginary part counts.
fn of_eigenvalues(
    variable: &Variable,
    notes: &mut Vec<String>,
) -> Result<Vec<(usize, f64, Option<f64>)>, MeasurementError> {
    let name = variable.name.escape_debug();
    match &variable.array.values {
        npy::Values::Real(list) => {
            notes.push(format!("variable `{name}` is taken for ω² in rad²/s²"));
            if let Some(value) = list.iter().find(|v| v.is_nan() || **v < 0.0) {
                return Err(unusable(variable, format!("{value} is not a square of a frequency")));
            }
            Ok(list.iter().enumerate().map(|(i, v)| (i, v.sqrt() / TAU, None)).collect())
        }
        npy::Values::Complex(list) => {
            const SAME: f64 = 1e-6;
            notes.push(format!("variable `{name}` is taken for poles in 1/s"));
            let has_partner = |z: &Complex<f64>| list.iter().any(|w| (w.conj() - z).norm() <= SAME * z.norm());
            let is_kept = |z: &Complex<f64>| z.im >= 0.0 || !has_partner(z);
            let kept: Vec<(usize, &Complex<f64>)> = list.iter().enumerate().filter(|(_, z)| is_kept(z)).collect();
            if kept.len() < list.len() {
                notes.push(format!(
                    "{} of `{name}` left out: conjugates of others",
                    counted(list.len() - kept.len(), "pole")
                ));
            }
            // Of a pole that grows it is negative, which the checks of the modes tell.
            let damping = |z: &Complex<f64>| Some(-z.re / z.norm()).filter(|d| d.is_finite());
            Ok(kept.into_iter().map(|(i, z)| (i, z.norm() / TAU, damping(z))).collect())
        }
    }
}

/// Modes; `None` where a question is left.
pub(super) fn modes(
    list: &[Cow<'_, Variable>],
    picked: &Modes,
    options: &MeasurementOptions,
    notes: &mut Vec<String>,
    questions: &mut Vec<Question>,
) -> Result<Option<ModeTable>, MeasurementError> {
    let variable = &list[picked.shapes];
    let before = questions.len();
    let mut modes = match picked.source {
        Source::Eigenvalues(i) => of_eigenvalues(&list[i], notes)?,
        Source::Frequencies(i) => {
            hertz(&list[i], options, notes, questions).into_iter().enumerate().map(|(i, hz)| (i, hz, None)).collect()
        }
    };
    notes.push(format!("variable `{}` is taken for their shapes", variable.name.escape_debug()));
    notes.extend(picked.notes.iter().cloned());
    if questions.len() > before {
        return Ok(None);
    }
    if let Some((i, hz, _)) = modes.iter().find(|m| !(m.1 >= 0.0 && m.1.is_finite())) {
        return Err(unusable(
            &list[picked.source.variable()],
            format!("value {} is {hz}, which is not a frequency", i + 1),
        ));
    }
    let n_rigid = modes.iter().filter(|m| m.1 == 0.0).count();
    if n_rigid > 0 {
        notes.push(format!("{} at 0 Hz left out: rigid bodies", counted(n_rigid, "mode")));
        modes.retain(|m| m.1 > 0.0);
    }
    if let Some(i) = picked.damping {
        let one = match says(&list[i].name) {
            Says::Damping(one) => one,
            _ => 1.0,
        };
        let ratios: Vec<f64> = list[i].vector().unwrap_or_default().iter().map(|d| d * one).collect();
        let name = list[i].name.escape_debug();
        if ratios.iter().all(|d| (0.0..1.0).contains(d)) {
            notes.push(format!("variable `{name}` is taken for their damping ratios"));
            for mode in &mut modes {
                mode.2 = ratios.get(mode.0).copied();
            }
        } else {
            notes.push(format!("variable `{name}` is left out: its values are not damping ratios between 0 and 1"));
        }
    }
    let axes = variable.axes();
    let steps = strides(&axes);
    let n_points = axes[picked.point_axis];
    let components = picked.component_axis.map_or(1, |a| axes[a]);
    let at = |mode: usize, k: usize| {
        let (point, component) = (k / components, k % components);
        let offset = picked.mode_axis.map_or(0, |a| mode * steps[a]) + point * steps[picked.point_axis];
        variable.at(offset + picked.component_axis.map_or(0, |a| component * steps[a]))
    };
    let shape = |mode: usize| (0..n_points * components).map(|k| at(mode, k)).collect::<Vec<_>>();
    let table = modes.iter().map(|(i, hz, damping)| (*hz, *damping, shape(*i))).collect();
    if let Some((k, _)) =
        modes.iter().enumerate().find(|(_, m)| shape(m.0).iter().all(|v| v.norm() == 0.0 || !v.is_finite()))
    {
        return Err(unusable(variable, format!("the shape of mode {} is zero at every point", k + 1)));
    }
    let numbered = || (1..=n_points).map(|k| k.to_string()).collect::<Vec<_>>();
    let points = picked.points.map(|i| list[i].vector().unwrap_or_default()).map_or_else(numbered, |labels| {
        let names: Vec<String> = labels.iter().map(f64::to_string).collect();
        let is_distinct = names.iter().collect::<std::collections::BTreeSet<_>>().len() == names.len();
        if is_distinct && labels.iter().all(|l| l.fract() == 0.0) { names } else { numbered() }
    });
    Ok(Some(ModeTable { modes: table, points, has_components: picked.component_axis.is_some() }))
}
