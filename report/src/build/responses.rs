//! Measured frequency responses against those of the model.

use super::super::data::Floats;
use super::super::data::{Band, Channel, Frfs, LabelledMatrix, Spectrum};
use super::disagreement::rounded;
use super::{Case, test_label};
use retune::correlation::{CorrelationError, fdac, frac, observation_matrix, signatures};
use retune::data::{FrfQuantity, FrfSet, Sensor, TestData};
use retune::linalg::Complex;
use retune::modal::{ModalDamping, SolveOptions, synthesize};
use retune::model::{ParametricModel, solve_modes};

/// Elastic modes in the sum.
const MOST_MODES: usize = 400;
/// Damping ratio of a mode that no measured mode belongs to, where nothing was measured.
const DEFAULT_DAMPING: f64 = 0.01;
/// Bands of the criteria.
const MOST_BANDS: usize = 8;
/// Lines of the FDAC picture.
const FDAC_LINES: usize = 60;

/// The functions whose points are sensors of the test, and those sensors: references, responses.
fn known(set: &FrfSet, test: &TestData) -> (FrfSet, Vec<Sensor>, Vec<Sensor>) {
    let sensor = |c: &retune::data::Channel| {
        let mut found = test.sensors.iter().find(|s| s.name == c.name)?.clone();
        if let Some(direction) = c.direction {
            found.direction = direction;
        }
        Some(found)
    };
    let pick = |list: &[retune::data::Channel]| -> (Vec<usize>, Vec<Sensor>) {
        list.iter().enumerate().filter_map(|(i, c)| Some((i, sensor(c)?))).unzip()
    };
    let ((rows, references), (columns, responses)) = (pick(&set.references), pick(&set.responses));
    // A free structure has no receptance at rest.
    let lines: Vec<usize> = (0..set.n_lines()).filter(|&l| set.frequencies_hz[l] > 0.0).collect();
    (part(set, &lines, &rows, &columns), references, responses)
}

/// A set with some of its lines, references and responses.
fn part(set: &FrfSet, lines: &[usize], references: &[usize], responses: &[usize]) -> FrfSet {
    let indices = || {
        lines.iter().flat_map(move |&l| {
            references.iter().flat_map(move |&r| responses.iter().map(move |&s| set.index(l, r, s)))
        })
    };
    FrfSet {
        quantity: set.quantity,
        frequencies_hz: lines.iter().map(|&l| set.frequencies_hz[l]).collect(),
        references: references.iter().map(|&r| set.references[r].clone()).collect(),
        responses: responses.iter().map(|&s| set.responses[s].clone()).collect(),
        h: indices().map(|i| set.h[i]).collect(),
        coherence: set.coherence.as_ref().map(|c| indices().map(|i| c[i]).collect()),
        n_averages: set.n_averages,
    }
}

/// The same functions of the model.
fn of_model(
    case: Case<'_>,
    set: &FrfSet,
    references: &[Sensor],
    responses: &[Sensor],
) -> Result<FrfSet, CorrelationError> {
    let Case { model, test, assessment } = case;
    let options = SolveOptions { n_elastic: MOST_MODES.min(model.dof_map().n_dof()), shift: None };
    let modes = solve_modes(model, &assessment.theta, options).map_err(|e| CorrelationError::Model(e.to_string()))?;
    let typical = typical_damping(test);
    let mut damping = ModalDamping::uniform(modes.len(), typical);
    for pair in &assessment.pairs {
        if let Some(zeta) = &test.modes[pair.test_mode].damping_ratio
            && let Some(ratio) = damping.ratios.get_mut(modes.n_rigid + pair.model_mode)
        {
            *ratio = zeta.value;
        }
    }
    let at_references = observation_matrix(model, references)?;
    let at_responses = observation_matrix(model, responses)?;
    let order = set.quantity.order();
    let h = synthesize(&modes, &damping, &at_responses, &at_references, &set.frequencies_hz, order);
    Ok(FrfSet { h, coherence: None, n_averages: None, ..set.clone() })
}

/// Median of the measured damping ratios, or a usual one.
pub(crate) fn typical_damping(test: &TestData) -> f64 {
    let mut all: Vec<f64> = test.modes.iter().filter_map(|m| m.damping_ratio.as_ref()).map(|d| d.value).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(DEFAULT_DAMPING)
}

/// Bands with a measured mode in the middle of each, neighbours together where there are many; thirds without modes.
fn bands(set: &FrfSet, test: &TestData) -> Vec<Band> {
    let (Some(&low), Some(&high)) = (set.frequencies_hz.first(), set.frequencies_hz.last()) else { return Vec::new() };
    let inside: Vec<usize> =
        (0..test.modes.len()).filter(|&i| (low..=high).contains(&test.modes[i].frequency_hz.value)).collect();
    let hz = |i: usize| test.modes[i].frequency_hz.value;
    let groups: Vec<&[usize]> = inside.chunks(inside.len().div_ceil(MOST_BANDS).max(1)).collect();
    if groups.is_empty() {
        let third = (high - low) / 3.0;
        let names = ["low", "middle", "high"];
        return (0..3)
            .map(|k| Band {
                name: names[k].into(),
                from_hz: low + third * k as f64,
                to_hz: low + third * (k + 1) as f64,
                ..Band::default()
            })
            .collect();
    }
    let middle = |k: usize| f64::midpoint(hz(groups[k][groups[k].len() - 1]), hz(groups[k + 1][0]));
    (0..groups.len())
        .map(|k| {
            let g = groups[k];
            let name = match g {
                [one] => test_label(test, *one),
                _ => format!("{} … {}", test_label(test, g[0]), test_label(test, g[g.len() - 1])),
            };
            let from_hz = if k == 0 { low } else { middle(k - 1) };
            let to_hz = if k + 1 == groups.len() { high } else { middle(k) };
            Band { name, from_hz, to_hz, ..Band::default() }
        })
        .collect()
}

/// FRAC of every channel in every band: `[channel][band]`.
fn fracs(model: &FrfSet, measured: &FrfSet, lines: &[Vec<usize>]) -> Result<Vec<Vec<Option<f64>>>, CorrelationError> {
    let (r, s) = all(measured);
    let mut out = vec![Vec::new(); r.len() * s.len()];
    for lines in lines {
        let values = frac(&part(model, lines, &r, &s), &part(measured, lines, &r, &s))?;
        for (list, v) in out.iter_mut().zip(values) {
            list.push(v);
        }
    }
    Ok(out)
}

fn all(set: &FrfSet) -> (Vec<usize>, Vec<usize>) {
    ((0..set.references.len()).collect(), (0..set.responses.len()).collect())
}

/// FDAC of every reference on a coarse grid of lines.
fn fdacs(model: &FrfSet, measured: &FrfSet) -> Result<Vec<LabelledMatrix>, CorrelationError> {
    let n = measured.n_lines();
    let step = n.div_ceil(FDAC_LINES).max(1);
    let lines: Vec<usize> = (0..n).step_by(step).collect();
    let (r, s) = all(measured);
    // A pattern needs several responses: with one, everything correlates with everything.
    if s.len() < 2 {
        return Ok(Vec::new());
    }
    let (a, x) = (part(model, &lines, &r, &s), part(measured, &lines, &r, &s));
    let names: Vec<String> = x.frequencies_hz.iter().map(|f| format!("{f:.2} Hz")).collect();
    (0..r.len())
        .map(|reference| {
            Ok(LabelledMatrix {
                title: format!("FDAC, force at {}", measured.references[reference].name),
                row_axis: "model".into(),
                column_axis: "test".into(),
                rows: names.clone(),
                columns: names.clone(),
                values: rounded(&fdac(&a, &x, reference)?),
            })
        })
        .collect()
}

/// Measured functions beside those of the model, and of the model before an update.
///
/// Functions at points that are not sensors of the test are left out; without any, there is nothing to show.
pub(super) fn responses(
    case: Case<'_>,
    before: Option<Case<'_>>,
    set: &FrfSet,
    origin: &str,
) -> Result<Option<Frfs>, CorrelationError> {
    let (measured, references, responses) = known(set, case.test);
    if references.is_empty() || responses.is_empty() || measured.n_lines() == 0 {
        return Ok(None);
    }
    let model = of_model(case, &measured, &references, &responses)?;
    let earlier = before.map(|b| of_model(b, &measured, &references, &responses)).transpose()?;
    let mut bands = bands(&measured, case.test);
    let lines: Vec<Vec<usize>> = bands
        .iter()
        .map(|b| {
            let is_inside = |l: &usize| (b.from_hz..=b.to_hz).contains(&measured.frequencies_hz[*l]);
            (0..measured.n_lines()).filter(is_inside).collect()
        })
        .collect();
    let frac = fracs(&model, &measured, &lines)?;
    let frac_before = earlier.as_ref().map(|m| fracs(m, &measured, &lines)).transpose()?;
    let by_line = signatures(&model, &measured)?;
    let mean = |list: &[usize], of: &dyn Fn(usize) -> Option<f64>| {
        let known: Vec<f64> = list.iter().filter_map(|&l| of(l)).collect();
        (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
    };
    for (band, list) in bands.iter_mut().zip(&lines) {
        band.csac = mean(list, &|l| by_line[l].shape);
        band.csf = mean(list, &|l| by_line[l].scale);
    }
    let n_responses = responses.len();
    let spectrum = |set: &FrfSet, r: usize, s: usize| {
        let value = |l: usize| -> Complex<f64> { set.at(l, r, s) };
        Spectrum::from_f64((0..set.n_lines()).map(|l| (value(l).re, value(l).im)))
    };
    let sensor = |own: &Sensor| case.test.sensors.iter().position(|x| x.name == own.name);
    let sign = |own: &Sensor| {
        let with = sensor(own).map(|k| case.test.sensors[k].direction)?;
        let cosine: f64 = own.direction.iter().zip(with).map(|(a, b)| a * b).sum();
        (cosine.abs() > 1.0 - 1e-9).then_some(cosine.signum())
    };
    let mut channels = Vec::with_capacity(references.len() * n_responses);
    for r in 0..references.len() {
        for s in 0..n_responses {
            let k = r * n_responses + s;
            let lines = 0..measured.n_lines();
            channels.push(Channel {
                response: responses[s].name.clone(),
                reference: references[r].name.clone(),
                sensor: sensor(&responses[s]),
                exciter: sensor(&references[r]),
                sign: sign(&responses[s]).zip(sign(&references[r])).map(|(a, b)| a * b),
                measured: Some(spectrum(&measured, r, s)),
                model: Some(spectrum(&model, r, s)),
                before: earlier.as_ref().map(|m| spectrum(m, r, s)),
                coherence: measured
                    .coherence
                    .as_ref()
                    .map(|c| Floats::from_f64(lines.map(|l| c[measured.index(l, r, s)]))),
                frac: frac[k].clone(),
                frac_before: frac_before.as_ref().map_or_else(Vec::new, |f| f[k].clone()),
            });
        }
    }
    let (quantity, unit) = match measured.quantity {
        FrfQuantity::Receptance => ("receptance", "m/N"),
        FrfQuantity::Mobility => ("mobility", "(m/s)/N"),
        FrfQuantity::Accelerance => ("accelerance", "(m/s²)/N"),
    };
    Ok(Some(Frfs {
        quantity: quantity.into(),
        unit: unit.into(),
        origin: origin.into(),
        note: format!(
            "model: sum of its modes with the measured damping of paired modes and {:.2} % for all others",
            100.0 * typical_damping(case.test)
        ),
        frequency_hz: Floats::from_f64(measured.frequencies_hz.iter().copied()),
        bands,
        channels,
        fdac: fdacs(&model, &measured)?,
        fdac_before: earlier.as_ref().map(|m| fdacs(m, &measured)).transpose()?.unwrap_or_default(),
    }))
}
