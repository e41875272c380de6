//! Checks of shapes with the positions of the sensors.

use super::codes;
use super::hypotheses::{Accepted, Edit, Prior, search};
use super::{Finding, Level};
use crate::identify::IdentifyError;
use retune_linalg::vector3::dot;
use retune_linalg::{DMatrix, symmetric_eigen, thin_qr};

/// Where a sensor sits and what it reads, for checks of shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorGeometry {
    /// Its name.
    pub name: String,
    /// Position in global axes, m.
    pub position: [f64; 3],
    /// Signed unit direction in global axes.
    pub direction: [f64; 3],
}

/// Least number of sensors of one direction for a judgement by smoothness.
const LEAST_SENSORS: usize = 8;

/// An entry below this share of the shape's rms is as good as zero.
const ZERO_ENTRY: f64 = 1e-2;

/// Checks shapes for sensors that do not fit their neighbours: sign, gain, swap, dead or misplaced.
///
/// The prior is a smooth field over the positions of all sensors of one direction: a Gaussian process with the cubic
/// kernel r³ and a free linear part, its noise level chosen by likelihood (see `hypotheses` for the decision). Structures
/// whose shapes are rougher than the sensors resolve (few sensors, high modes, joints) give no decision; the sensors whose
/// sign could not have been judged are named in a finding of their own.
///
/// * `shapes` - real normal shapes (sensors x modes), any scale; rows with NaN are left out
///
/// # Errors
/// A number of rows other than that of the sensors.
///
/// # Source
/// The kernel: J. Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev spaces, 1977.
pub fn check_geometry(sensors: &[SensorGeometry], shapes: &DMatrix<f64>) -> Result<Vec<Finding>, IdentifyError> {
    check_rows(sensors, shapes)?;
    let mut findings = zero_entries(sensors, shapes);
    let mut undecided: Vec<usize> = Vec::new();
    let mut judged = vec![false; sensors.len()];
    for k in 0..sensors.len() {
        if judged[k] || !is_usable(sensors, shapes, k) {
            continue;
        }
        // All sensors along the same line, with the sign that turns them the same way.
        let cosine = |j: usize| dot(sensors[k].direction, sensors[j].direction);
        let group: Vec<usize> = (k..sensors.len())
            .filter(|&j| !judged[j] && is_usable(sensors, shapes, j) && cosine(j).abs() > 0.99)
            .collect();
        for &j in &group {
            judged[j] = true;
        }
        let phi =
            DMatrix::from_fn(group.len(), shapes.ncols(), |i, m| cosine(group[i]).signum() * shapes[(group[i], m)]);
        let positions: Vec<[f64; 3]> = group.iter().map(|&j| sensors[j].position).collect();
        let priors = if group.len() >= LEAST_SENSORS { smooth_priors(&positions) } else { Vec::new() };
        if priors.is_empty() || phi.ncols() == 0 {
            undecided.extend(&group);
            continue;
        }
        let (accepted, is_visible) = search(&priors, &phi);
        findings.extend(accepted.iter().map(|a| describe(a, sensors, &group, "the smooth shape of its neighbours")));
        undecided.extend((0..group.len()).filter(|&i| !is_visible[i]).map(|i| group[i]));
    }
    if !undecided.is_empty() {
        findings.push(not_decided(sensors, &mut undecided));
    }
    Ok(findings)
}

/// Checks shapes that should be rigid-body motions, where the truth is known exactly: u = t + θ × p, read along d.
///
/// ```text
/// φ_k = d_k · t + (p_k × d_k) · θ        six unknowns per shape
/// ```
/// Finds sign, gain, swap and dead sensors, and sensors that read another axis than they should: entry k is compared with
/// what the motion of the others gives along x, y and z.
///
/// * `shapes` - real rigid-body shapes (sensors x shapes), any scale
///
/// # Errors
/// A number of rows other than that of the sensors.
pub fn check_rigid_body(sensors: &[SensorGeometry], shapes: &DMatrix<f64>) -> Result<Vec<Finding>, IdentifyError> {
    check_rows(sensors, shapes)?;
    let group: Vec<usize> = (0..sensors.len()).filter(|&k| is_usable(sensors, shapes, k)).collect();
    if group.is_empty() {
        return Ok(Vec::new());
    }
    let motions =
        DMatrix::from_fn(group.len(), 6, |i, j| rigid_row(&sensors[group[i]], sensors[group[i]].direction)[j]);
    let svd = motions.clone().svd(true, false);
    let largest = svd.singular_values.iter().copied().fold(0.0, f64::max);
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&j| svd.singular_values[j] > 1e-8 * largest).collect();
    let (Some(u), rank) = (svd.u, kept.len()) else { return Ok(Vec::new()) };
    if group.len() < rank + 2 || shapes.ncols() == 0 {
        let mut all = group.clone();
        return Ok(vec![not_decided(sensors, &mut all)]);
    }
    let basis = DMatrix::from_fn(group.len(), rank, |i, j| u[(i, kept[j])]);
    let b = DMatrix::identity(group.len(), group.len()) - &basis * basis.transpose();
    let phi = DMatrix::from_fn(group.len(), shapes.ncols(), |i, m| shapes[(group[i], m)]);
    let (accepted, is_visible) = search(&[Prior { b, ln_det: 0.0, rank: group.len() - rank }], &phi);
    let faulty = |i: usize| {
        accepted.iter().any(|a| matches!(a.edit, Edit::Flip(k) | Edit::Scale(k, _) | Edit::Drop(k) if k == i))
    };
    let mut findings = Vec::new();
    for a in &accepted {
        let axis = match a.edit {
            Edit::Drop(i) | Edit::Scale(i, _) => wrong_axis(sensors, &group, &phi, i, &faulty),
            _ => None,
        };
        findings.push(match (axis, a.edit) {
            (Some((name, misfit)), Edit::Drop(i) | Edit::Scale(i, _)) => Finding {
                level: Level::Fault,
                code: codes::SENSOR_AXIS,
                subject: sensors[group[i]].name.clone(),
                evidence: vec![
                    ("relative misfit along that axis", misfit),
                    ("log evidence", a.evidence),
                    ("needed", a.threshold),
                ],
                text: format!(
                    "sensor {} reads the rigid-body motion along {name}, not along its direction",
                    sensors[group[i]].name
                ),
                remedy: "correct the direction of the sensor in the test file",
            },
            _ => describe(a, sensors, &group, "the rigid-body motion of the others"),
        });
    }
    let mut undecided: Vec<usize> = (0..group.len()).filter(|&i| !is_visible[i]).map(|i| group[i]).collect();
    if !undecided.is_empty() {
        findings.push(not_decided(sensors, &mut undecided));
    }
    Ok(findings)
}

fn check_rows(sensors: &[SensorGeometry], shapes: &DMatrix<f64>) -> Result<(), IdentifyError> {
    if shapes.nrows() == sensors.len() {
        Ok(())
    } else {
        Err(IdentifyError::Length { what: "the list of sensors", expected: shapes.nrows(), found: sensors.len() })
    }
}

fn is_usable(sensors: &[SensorGeometry], shapes: &DMatrix<f64>, k: usize) -> bool {
    let s = &sensors[k];
    s.position.iter().chain(&s.direction).all(|x| x.is_finite()) && shapes.row(k).iter().all(|x| x.is_finite())
}

/// Row of the rigid-body matrix for a reading along `d`.
fn rigid_row(s: &SensorGeometry, d: [f64; 3]) -> [f64; 6] {
    let p = s.position;
    [d[0], d[1], d[2], p[1] * d[2] - p[2] * d[1], p[2] * d[0] - p[0] * d[2], p[0] * d[1] - p[1] * d[0]]
}

/// The axis along which the motion of the healthy sensors gives entry `i`, with the misfit, if one fits within 20 % and
/// the own direction does not.
fn wrong_axis(
    sensors: &[SensorGeometry],
    group: &[usize],
    phi: &DMatrix<f64>,
    i: usize,
    is_faulty: &dyn Fn(usize) -> bool,
) -> Option<(&'static str, f64)> {
    let others: Vec<usize> = (0..group.len()).filter(|&j| j != i && !is_faulty(j)).collect();
    let d = DMatrix::from_fn(others.len(), 6, |r, c| {
        rigid_row(&sensors[group[others[r]]], sensors[group[others[r]]].direction)[c]
    });
    let y = DMatrix::from_fn(others.len(), phi.ncols(), |r, c| phi[(others[r], c)]);
    let x = d.svd(true, true).solve(&y, 1e-8).ok()?;
    let own = phi.row(i);
    let misfit = |e: [f64; 3]| {
        let row = rigid_row(&sensors[group[i]], e);
        let predicted: Vec<f64> = (0..phi.ncols()).map(|m| (0..6).map(|c| row[c] * x[(c, m)]).sum()).collect();
        let miss: f64 = predicted.iter().zip(own.iter()).map(|(p, o)| (p - o).powi(2)).sum();
        (miss / own.norm_squared().max(f64::MIN_POSITIVE)).sqrt()
    };
    let axes = [
        ("+x", [1.0, 0.0, 0.0]),
        ("-x", [-1.0, 0.0, 0.0]),
        ("+y", [0.0, 1.0, 0.0]),
        ("-y", [0.0, -1.0, 0.0]),
        ("+z", [0.0, 0.0, 1.0]),
        ("-z", [0.0, 0.0, -1.0]),
    ];
    let declared = sensors[group[i]].direction;
    let (name, best) = axes
        .into_iter()
        .filter(|(_, e)| dot(*e, declared).abs() < 0.9)
        .map(|(name, e)| (name, misfit(e)))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    (best < 0.2).then_some((name, best))
}

/// The smooth prior over positions at a range of noise levels; none when the positions cannot carry it.
fn smooth_priors(positions: &[[f64; 3]]) -> Vec<Prior> {
    let n = positions.len();
    if n < LEAST_SENSORS {
        return Vec::new();
    }
    let mean: Vec<f64> = (0..3).map(|c| positions.iter().map(|p| p[c]).sum::<f64>() / n as f64).collect();
    let centred = DMatrix::from_fn(n, 3, |i, c| positions[i][c] - mean[c]);
    let svd = centred.clone().svd(false, true);
    let (Some(v), largest) = (svd.v_t, svd.singular_values.max()) else { return Vec::new() };
    if largest.is_nan() || largest <= 0.0 {
        return Vec::new();
    }
    // Directions with less than a thousandth of the extent do not carry a linear part.
    let axes: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&a| svd.singular_values[a] > 1e-3 * largest).collect();
    let size = largest / (n as f64).sqrt();
    let x =
        DMatrix::from_fn(n, axes.len(), |i, a| (0..3).map(|c| centred[(i, c)] * v[(axes[a], c)]).sum::<f64>() / size);
    let linear = DMatrix::from_fn(n, 1 + axes.len(), |i, a| if a == 0 { 1.0 } else { x[(i, a - 1)] });
    let rank = n - linear.ncols();
    // Orthonormal complement of the linear part: the last columns of a full Q.
    let Ok(qr) = thin_qr(&linear) else { return Vec::new() };
    let projector = DMatrix::identity(n, n) - &qr.q * qr.q.transpose();
    let Ok(eigen) = symmetric_eigen(&projector) else { return Vec::new() };
    let columns: Vec<usize> = (0..n).filter(|&j| eigen.values[j] > 0.5).collect();
    if columns.len() != rank {
        return Vec::new();
    }
    let q2 = DMatrix::from_fn(n, rank, |i, j| eigen.vectors[(i, columns[j])]);
    let kernel = DMatrix::from_fn(n, n, |i, j| (x.row(i) - x.row(j)).norm().powi(3));
    let covariance = q2.tr_mul(&kernel) * &q2;
    let scale = covariance.trace() / rank as f64;
    let Ok(eigen) = symmetric_eigen(&covariance) else { return Vec::new() };
    [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]
        .iter()
        .map(|level| {
            let values = eigen.values.map(|e| (e / scale).max(0.0) + level);
            let root = &q2 * &eigen.vectors;
            let weighted = DMatrix::from_fn(n, rank, |i, j| root[(i, j)] / values[j]);
            Prior { b: weighted * root.transpose(), ln_det: values.iter().map(|v| v.ln()).sum(), rank }
        })
        .collect()
}

/// Sensors whose entry is zero in several shapes while their neighbours move.
///
/// One entry below 1e-2 of the rms is common: a node line. Two in one sensor, each amid four nearest neighbours of its
/// direction of which three move one way by more than a tenth of the rms, are not: a smooth field has its zero between
/// neighbours of both signs. The sensor must stand among its neighbours (their mean offset below 0.7 of their mean
/// distance), since at the end of an array it may be clamped.
fn zero_entries(sensors: &[SensorGeometry], shapes: &DMatrix<f64>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for k in 0..sensors.len() {
        if !is_usable(sensors, shapes, k) {
            continue;
        }
        let mut near: Vec<(f64, usize)> = (0..sensors.len())
            .filter(|&j| {
                j != k && is_usable(sensors, shapes, j) && dot(sensors[j].direction, sensors[k].direction).abs() > 0.99
            })
            .map(|j| ((0..3).map(|c| (sensors[j].position[c] - sensors[k].position[c]).powi(2)).sum(), j))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(4);
        let offset = |c: usize| near.iter().map(|(_, j)| sensors[*j].position[c] - sensors[k].position[c]).sum::<f64>();
        let offset = (0..3).map(|c| offset(c).powi(2)).sum::<f64>().sqrt();
        if near.len() < 4 || offset > 0.7 * near.iter().map(|(d, _)| d.sqrt()).sum::<f64>() {
            continue;
        }
        let (mut dead, mut smallest) = (0, f64::INFINITY);
        for m in 0..shapes.ncols() {
            let finite: Vec<f64> = shapes.column(m).iter().copied().filter(|x| x.is_finite()).collect();
            let rms = (finite.iter().map(|x| x * x).sum::<f64>() / finite.len() as f64).sqrt();
            let entry = shapes[(k, m)].abs() / rms;
            let towards = |sign: f64| {
                let reads = |j: usize| sign * shapes[(j, m)] * dot(sensors[j].direction, sensors[k].direction).signum();
                near.iter().filter(|(_, j)| reads(*j) > 0.1 * rms).count()
            };
            if entry < ZERO_ENTRY && towards(1.0).max(towards(-1.0)) >= 3 {
                dead += 1;
                smallest = smallest.min(entry);
            }
        }
        if dead >= 2 {
            findings.push(Finding {
                level: Level::Fault,
                code: codes::SENSOR_DEAD,
                subject: sensors[k].name.clone(),
                evidence: vec![("shapes with a zero entry", f64::from(dead)), ("smallest entry over rms", smallest)],
                text: format!(
                    "sensor {} reads nothing in {dead} of {} shapes although all its neighbours move one way",
                    sensors[k].name,
                    shapes.ncols()
                ),
                remedy: "leave the sensor out of these shapes",
            });
        }
    }
    findings
}

fn describe(a: &Accepted, sensors: &[SensorGeometry], group: &[usize], against: &str) -> Finding {
    let name = |i: usize| sensors[group[i]].name.clone();
    let mut evidence = vec![("log evidence", a.evidence), ("needed", a.threshold)];
    let (code, subject, mut text, remedy) = match a.edit {
        Edit::Flip(k) => {
            let text = format!("sensor {} has the wrong sign: turned around it fits {against}", name(k));
            (
                codes::SENSOR_SIGN,
                name(k),
                text,
                "have it decided by a model with `--model`, or push the structure by hand beside it: if the first swing is against its direction, reverse \
             the direction in the test file",
            )
        }
        Edit::Swap(k, l) => {
            let text = format!("sensors {} and {} are swapped: exchanged they fit {against}", name(l), name(k));
            (
                codes::SENSOR_SWAP,
                format!("{} / {}", name(l), name(k)),
                text,
                "have it decided by a model with `--model`, or follow the two cables; exchange the channels if they are crossed",
            )
        }
        Edit::Scale(k, s) => {
            evidence.push(("factor that would fit", s));
            let text = format!("sensor {} has the wrong gain: multiplied by {s:.3} it fits {against}", name(k));
            (
                codes::SENSOR_GAIN,
                name(k),
                text,
                "compare sensitivity and range of the channel with its calibration sheet, and correct the one that is off",
            )
        }
        Edit::Drop(k) => {
            let text =
                format!("sensor {} does not fit {against}, and no other sign or gain is clearly better", name(k));
            (
                "does-not-fit",
                name(k),
                text,
                "look at place, axis and cable of the sensor; leave it out of the test if they are as stated",
            )
        }
    };
    if !a.rivals.is_empty() {
        let one = |e: &Edit| match *e {
            Edit::Flip(k) => format!("{} is turned over", name(k)),
            Edit::Swap(k, l) => format!("{} and {} are swapped", name(l), name(k)),
            Edit::Scale(k, _) => format!("{} has the wrong gain", name(k)),
            Edit::Drop(k) => format!("{} does not fit", name(k)),
        };
        let list: Vec<String> = a.rivals.iter().map(one).collect();
        text += &format!("; the data fit nearly as well if {}", list.join(", or if "));
    }
    Finding { level: Level::Warning, code, subject, evidence, text, remedy }
}

fn not_decided(sensors: &[SensorGeometry], which: &mut [usize]) -> Finding {
    which.sort_unstable();
    let names: Vec<&str> = which.iter().map(|&k| sensors[k].name.as_str()).collect();
    Finding {
        level: Level::Info,
        code: "sign-not-decidable",
        subject: format!("{} sensors", names.len()),
        evidence: vec![("sensors", names.len() as f64)],
        text: format!("a wrong sign could not be seen without a model at: {}", names.join(", ")),
        remedy: "give the model with `--model`, which may decide; without one, push the structure by hand beside each of them: the first swing must \
                 have the sign of its direction",
    }
}
