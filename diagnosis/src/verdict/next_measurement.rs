//! The measurement that would best separate hypotheses that are tied.
//!
//! ```text
//! expected ln B = ½ dᵀ S⁻¹ d,    d = g_a - g_b,    S = diag(σ²) + G_a C_a G_aᵀ + G_b C_b G_bᵀ
//! ```
//!
//! g are the predictions of a measurement by the two refitted hypotheses, G their derivatives and C the covariances of the
//! parameters: what a refit could adapt does not separate. Measurements are ranked by the pair they separate worst.

use super::words::number;
use crate::error::DiagnosisError;
use crate::problem::scene::Case;
use crate::result::NextMeasurement;
use crate::screen::stage::Stage;
use crate::search::hypothesis::{Refit, Tried};
use rayon::prelude::*;
use retune::data::{Place, TestData};
use retune::element::Dof;
use retune::linalg::{DMatrix, DVector};
use retune::model::{AXES, Model, ParametricModel};
use retune::objective::{Comparison, Scaling};
use retune::units::four_digits;

/// Modes above the measured ones that a longer sweep would show.
const NEXT_MODES: usize = 3;
/// A known mass for a second test, as a share of the total.
const ADDED_MASS: f64 = 0.02;
/// A spring to ground for a second test: its stiffness as a share of total mass times the square of the lowest measured
/// frequency.
const ADDED_SPRING: f64 = 0.1;
/// Uncertainties of what is not measured yet.
const FREQUENCY_SD: f64 = 0.003;
const SHAPE_SD: f64 = 0.02;
const MASS_SD: f64 = 0.005;
const INERTIA_SD: f64 = 0.01;

/// A measurement: rows of the prediction vector.
struct Proposal {
    what: String,
    place: String,
    rows: Vec<usize>,
}

/// Proposals for the hypotheses above a threshold of ln Bayes factors, best first.
pub(crate) fn next_measurements(
    base: &Stage,
    refits: &[Refit],
    threshold: f64,
) -> Result<Vec<NextMeasurement>, DiagnosisError> {
    let tied: Vec<&Refit> = refits
        .iter()
        .filter(|r| r.ln_bayes > threshold && r.fit.unpaired.is_empty() && matches!(r.tried, Tried::Effect(_)))
        .take(base.effort().compared)
        .collect();
    if tied.len() < 2 {
        return Ok(Vec::new());
    }
    let (proposals, sd) = proposals(base);
    let views: Vec<Option<(DVector<f64>, DMatrix<f64>)>> =
        tied.par_iter().map(|r| view(base, r, sd.len()).ok()).collect();
    let views: Vec<(DVector<f64>, DMatrix<f64>)> = views.into_iter().flatten().collect();
    if views.len() < 2 {
        return Ok(Vec::new());
    }
    let mut out: Vec<NextMeasurement> = proposals
        .into_iter()
        .map(|p| {
            let mut worst = f64::INFINITY;
            for a in 0..views.len() {
                for b in a + 1..views.len() {
                    worst = worst.min(separation(&views[a], &views[b], &p.rows, &sd));
                }
            }
            NextMeasurement { what: p.what, place: p.place, expected_ln_bayes: worst }
        })
        // What is less than half a tenth says nothing, and would be shown as zero.
        .filter(|p| p.expected_ln_bayes.is_finite() && p.expected_ln_bayes >= 0.05)
        .collect();
    out.sort_by(|a, b| b.expected_ln_bayes.total_cmp(&a.expected_ln_bayes));
    out.truncate(10);
    Ok(out)
}

fn separation(a: &(DVector<f64>, DMatrix<f64>), b: &(DVector<f64>, DMatrix<f64>), rows: &[usize], sd: &[f64]) -> f64 {
    let d = DVector::from_iterator(rows.len(), rows.iter().map(|&i| a.0[i] - b.0[i]));
    let (ga, gb) = (a.1.select_rows(rows), b.1.select_rows(rows));
    let mut s = &ga * ga.transpose() + &gb * gb.transpose();
    for (k, &i) in rows.iter().enumerate() {
        s[(k, k)] += sd[i] * sd[i];
    }
    match s.cholesky() {
        Some(c) if d.iter().all(|v| v.is_finite()) => 0.5 * d.dot(&c.solve(&d)),
        _ => f64::NAN,
    }
}

/// Nodes and directions where a sensor could stand.
fn places(model: &Model, most: usize) -> Vec<(usize, usize)> {
    let dofs = model.dof_map();
    let n = model.spec().nodes.len();
    (0..n)
        .step_by(n.div_ceil(most).max(1))
        .flat_map(|node| (0..3).map(move |axis| (node, axis)))
        .filter(|&(node, axis)| !dofs.express(node, Dof::ALL[axis]).is_empty())
        .collect()
}

/// Cosine from which on a sensor reads along an axis.
const ALONG: f64 = 0.95;

/// Whether a sensor of the test reads a node along an axis.
fn has_sensor(test: &TestData, node: &str, axis: usize) -> bool {
    let is_at = |place: &Place| matches!(place, Place::Node { node: name, .. } if name == node);
    test.sensors.iter().any(|s| !s.is_rotation && is_at(&s.place) && s.direction[axis].abs() > ALONG)
}

/// All proposals with the standard deviations of the prediction vector, test after test:
/// sensors (per place: one entry a mode), next frequencies, added masses and added supports (per place: one a mode), mass,
/// cg, inertia.
fn proposals(base: &Stage) -> (Vec<Proposal>, Vec<f64>) {
    let (mut out, mut sd) = (Vec::new(), Vec::new());
    for case in &base.scene.cases {
        let names = &case.model.geometry().names;
        let m = case.modes().len();
        let places = places(&case.model, base.effort().next_nodes);
        let of = if base.scene.cases.len() > 1 { format!(" ({})", case.test.name) } else { String::new() };
        // Without modes there is none to see with one more sensor, mass or spring.
        // The entries of what is measured already stand in the vector too.
        let mut add = |what: Option<String>, place: &str, sds: Vec<f64>| {
            let rows: Vec<usize> = (sd.len()..sd.len() + sds.len()).collect();
            sd.extend(sds);
            if let Some(what) = what.filter(|_| !rows.is_empty()) {
                out.push(Proposal { what: what + &of, place: place.to_string(), rows });
            }
        };
        let mass = added_mass(base, case);
        let spring = added_spring(base, case);
        for &(node, k) in &places {
            let what = format!("one more accelerometer at {} along {}", names[node], AXES[k]);
            let is_new = !has_sensor(&case.test, &names[node], k);
            add(is_new.then_some(what), &names[node], vec![SHAPE_SD; m]);
        }
        let which = if m > 0 { "next" } else { "first" };
        add(Some(format!("the frequencies of the {which} {NEXT_MODES} modes")), "", vec![FREQUENCY_SD; NEXT_MODES]);
        for &(node, k) in &places {
            let (name, along) = (&names[node], AXES[k]);
            let what = format!("the same modes with {} kg added at {name} (seen along {along})", number(mass));
            add(Some(what), name, vec![FREQUENCY_SD; m]);
        }
        for &(node, k) in &places {
            let (name, along) = (&names[node], AXES[k]);
            let spring = four_digits(spring);
            let what = format!("the same modes with a spring of {spring} N/m to ground at {name} along {along}");
            add(Some(what), name, vec![FREQUENCY_SD; m]);
        }
        add(Some("total mass and centre of gravity on scales".to_string()), "", vec![MASS_SD; 4]);
        add(Some("moments of inertia by swinging".to_string()), "", vec![INERTIA_SD; 3]);
    }
    (out, sd)
}

fn total_mass(base: &Stage, case: &Case) -> f64 {
    case.model.mass_properties(&base.fit.theta).ok().flatten().map_or(0.0, |p| p.mass)
}

fn added_mass(base: &Stage, case: &Case) -> f64 {
    ADDED_MASS * total_mass(base, case)
}

fn added_spring(base: &Stage, case: &Case) -> f64 {
    let lowest = case.test.modes.iter().map(|m| m.frequency_hz.value).fold(f64::INFINITY, f64::min);
    let omega = if lowest.is_finite() { std::f64::consts::TAU * lowest } else { 0.0 };
    ADDED_SPRING * total_mass(base, case) * omega.powi(2)
}

/// The prediction vector of a hypothesis and its derivative times the root of the covariance.
fn view(base: &Stage, r: &Refit, n: usize) -> Result<(DVector<f64>, DMatrix<f64>), DiagnosisError> {
    let comparisons = r.scene.comparisons()?;
    let scaling = Scaling::new(r.scene.solved());
    let at = |x: &DVector<f64>| predict(base, r, &comparisons, &scaling.theta(x), n);
    let g = at(&r.fit.x)?;
    let (_, covariance) = r.fit.hessian()?;
    let mut derivative = DMatrix::zeros(n, r.fit.x.len());
    for j in 0..r.fit.x.len() {
        // A tenth of the posterior scatter: small against it, large against rounding.
        let step = 0.1 * covariance[(j, j)].sqrt().min(1.0);
        let step = if r.fit.x[j] + step > 1.0 { -step } else { step };
        let mut x = r.fit.x.clone();
        x[j] += step;
        derivative.set_column(j, &((at(&x)? - &g) / step));
    }
    let root = covariance.cholesky().ok_or(DiagnosisError::Singular)?.l();
    Ok((g, derivative * root))
}

fn predict(
    base: &Stage,
    r: &Refit,
    comparisons: &[Comparison<'_>],
    theta: &[f64],
    n: usize,
) -> Result<DVector<f64>, DiagnosisError> {
    let mut out = Vec::with_capacity(n);
    for (k, comparison) in comparisons.iter().enumerate() {
        predict_case(base, k, r, comparison, theta, &mut out)?;
    }
    Ok(DVector::from_vec(out))
}

/// The predictions of one test.
fn predict_case(
    base: &Stage,
    case: usize,
    r: &Refit,
    comparison: &Comparison<'_>,
    theta: &[f64],
    out: &mut Vec<f64>,
) -> Result<(), DiagnosisError> {
    let p = comparison.predict(theta)?;
    let (case, solved, fit) = (&base.scene.cases[case], &r.scene.cases[case], &r.fit);
    let base_names = &case.model.geometry().names;
    let n_modes = case.test.modes.len();
    let partners: Vec<usize> = (0..n_modes).map(|m| p.partner(m).unwrap_or(0)).collect();
    let motion = |node: &str, axis: usize, elastic: usize| -> f64 {
        let Some(row) = solved.rows_of(node, Dof::ALL[axis]) else { return f64::NAN };
        row.iter().map(|&(i, f)| f * p.modes.shapes[(i, p.modes.n_rigid + elastic)]).sum()
    };
    // Shapes in the scale of the test: largest reading 1, sign by the base of this hypothesis.
    let scale: Vec<f64> = (0..n_modes)
        .map(|m| {
            let now = p.at_sensors.column(partners[m]);
            let mode = case.first_mode + m;
            let largest = fit.shapes.column(mode).amax();
            let along: f64 =
                case.sensors.iter().zip(now.iter()).map(|(&s, v)| v * base.fit.test_shapes[(s, mode)]).sum();
            let sign = if along < 0.0 { -1.0 } else { 1.0 };
            if largest > 0.0 { sign / now.amax().max(f64::MIN_POSITIVE) } else { sign }
        })
        .collect();
    let places = places(&case.model, base.effort().next_nodes);
    for &(node, axis) in &places {
        for m in 0..n_modes {
            out.push(scale[m] * motion(&base_names[node], axis, partners[m]));
        }
    }
    let first = partners.iter().copied().max().map_or(0, |highest| highest + 1);
    for k in first..first + NEXT_MODES {
        out.push(p.frequencies_hz.get(k).map_or(0.0, |f| f.ln()));
    }
    let added = added_mass(base, case);
    for &(node, axis) in &places {
        for &partner in &partners {
            let phi = motion(&base_names[node], axis, partner);
            // Rayleigh's quotient of the modified structure, to first order in the mass.
            out.push(-0.5 * (added * phi * phi).ln_1p());
        }
    }
    let spring = added_spring(base, case);
    for &(node, axis) in &places {
        for &partner in &partners {
            let phi = motion(&base_names[node], axis, partner);
            let omega2 = (std::f64::consts::TAU * p.frequencies_hz[partner]).powi(2);
            out.push(0.5 * (spring * phi * phi / omega2).ln_1p());
        }
    }
    let extent = |i: f64, mass: f64| (i.max(0.0) / mass.max(f64::MIN_POSITIVE)).sqrt();
    match p.mass_properties.as_ref() {
        Some(m) => {
            let length = (0..3).map(|i| extent(m.inertia[i][i], m.mass)).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
            out.push(m.mass.ln());
            out.extend((0..3).map(|i| m.cg[i] / length));
            out.extend((0..3).map(|i| m.inertia[i][i].max(1e-12).ln()));
        }
        None => out.extend([0.0; 7]),
    }
    Ok(())
}
