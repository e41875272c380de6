//! From dofs to sensors: every sensor is a row of the observation matrix.

use super::CorrelationError;
use crate::catalogue::did_you_mean;
use crate::data::{Place, Sensor};
use crate::element::Dof;
use crate::linalg::DMatrix;
use crate::linalg::vector3::cross;
use crate::model::{ModelError, ParametricModel, PointMotion, extent};
use crate::yaml::Problem;

/// Most entries of an observation matrix: 1 GB.
const MOST_ENTRIES: usize = 125_000_000;

/// The observation matrix S: readings = S q.
///
/// ```text
/// reading = d · (u_P + θ_P × (p - P))       displacement along d at p, rigidly joined to the point P
/// reading = d · θ_P                         rotation about d
///
/// (n_sensor) = (n_sensor x n_dof) (n_dof)
/// ```
///
/// P is a node or a point of an element, by its shape functions (of a surface or a volume the point nearest to p); where they depend on θ, in the middle of the bounds. A node of a
/// support that gives stands still here and moves in [`observation_matrix_at`].
///
/// Errors: a sensor names a node or element that the model does not have.
pub fn observation_matrix(model: &dyn ParametricModel, sensors: &[Sensor]) -> Result<DMatrix<f64>, CorrelationError> {
    observe(model, sensors, None)
}

/// [`observation_matrix`] at θ.
pub fn observation_matrix_at(
    model: &dyn ParametricModel,
    sensors: &[Sensor],
    theta: &[f64],
) -> Result<DMatrix<f64>, CorrelationError> {
    observe(model, sensors, Some(theta))
}

/// The sensors whose rows of the observation matrix depend on θ: those inside an element whose shape functions do, and
/// those that a support moves that gives.
pub fn varying_sensors(model: &dyn ParametricModel, sensors: &[Sensor], theta: &[f64]) -> Vec<usize> {
    let varies = |sensor: &Sensor| match &sensor.place {
        Place::Element { position: Some(place), element, .. }
            if matches!(model.point_near(element, *place), Ok(Some(_))) =>
        {
            false
        }
        Place::Element { element, fraction, .. } => matches!(model.point_at(element, *fraction, theta), Ok(Some(_))),
        Place::Node { node, .. } => {
            let node = model.dofs_of_nodes().node(node);
            node.is_some_and(|n| matches!(model.node_at(n, theta), Ok(Some(_))))
        }
    };
    (0..sensors.len()).filter(|&i| varies(&sensors[i])).collect()
}

fn observe(
    model: &dyn ParametricModel,
    sensors: &[Sensor],
    theta: Option<&[f64]>,
) -> Result<DMatrix<f64>, CorrelationError> {
    let n_dof = model.dof_map().n_dof();
    if sensors.len().saturating_mul(n_dof) > MOST_ENTRIES {
        return Err(CorrelationError::Model(format!(
            "{} sensors on a model of {} dofs are too many: choose at most {} sensors",
            sensors.len(),
            n_dof,
            MOST_ENTRIES / n_dof
        )));
    }
    let rows = rows(model, sensors, theta)?;
    if let Some(stand_in) = model.stand_in() {
        return Ok(stand_in.observed(&rows));
    }
    let mut s = DMatrix::zeros(sensors.len(), n_dof);
    for (i, row) in rows.into_iter().enumerate() {
        for (column, factor) in row {
            s[(i, column)] += factor;
        }
    }
    Ok(s)
}

/// The rows of [`observation_matrix`] as sums, (column, factor) of each entry; a column may come several times. Those of a stand-in are on the rows of
/// the model that it stands for.
///
/// # Errors
/// As [`observation_matrix`].
pub fn observation_rows(
    model: &dyn ParametricModel,
    sensors: &[Sensor],
) -> Result<Vec<Vec<(usize, f64)>>, CorrelationError> {
    rows(model, sensors, None)
}

/// What rows of [`observation_rows`] read of vectors, (rows x vectors).
pub fn read_rows(rows: &[Vec<(usize, f64)>], vectors: &DMatrix<f64>) -> DMatrix<f64> {
    let read = |row: &[(usize, f64)], k: usize| row.iter().map(|&(dof, factor)| factor * vectors[(dof, k)]).sum();
    DMatrix::from_fn(rows.len(), vectors.ncols(), |i, k| read(&rows[i], k))
}

fn rows(
    model: &dyn ParametricModel,
    sensors: &[Sensor],
    theta: Option<&[f64]>,
) -> Result<Vec<Vec<(usize, f64)>>, CorrelationError> {
    let mut all = Vec::with_capacity(sensors.len());
    for sensor in sensors {
        let (point, position) = locate(model, sensor, theta)?;
        let arm = position.map_or(sensor.offset.unwrap_or([0.0; 3]), |p| [0, 1, 2].map(|k| p[k] - point.position[k]));
        let d = sensor.direction;
        let weights = if sensor.is_rotation {
            [0.0, 0.0, 0.0, d[0], d[1], d[2]]
        } else {
            // d · (θ × a) = θ · (a × d)
            let about = cross(arm, d);
            [d[0], d[1], d[2], about[0], about[1], about[2]]
        };
        let of = |(list, weight): (&Vec<(usize, f64)>, f64)| -> Vec<(usize, f64)> {
            list.iter().map(|&(row, factor)| (row, weight * factor)).collect()
        };
        all.push(point.rows.iter().zip(weights).flat_map(of).collect());
    }
    Ok(all)
}

/// Checks the sensors of a test against a model: all problems at once, with their paths in the test file.
///
/// An error where a sensor sits on nothing that the model has; a warning where it sits on something that cannot move
/// in its direction, so that every shape of the model is zero there.
pub fn check_sensors(model: &dyn ParametricModel, sensors: &[Sensor]) -> Vec<Problem> {
    let (mut problems, theta) = (Vec::new(), model.parameters().nominal());
    if let Some(text) = of_another_model(model, sensors) {
        return vec![Problem::error("sensors", text)];
    }
    for sensor in sensors {
        let path = format!("sensors.{}", sensor.name);
        match observation_matrix(model, std::slice::from_ref(sensor)) {
            Ok(row) if row.amax() == 0.0 && varying_sensors(model, std::slice::from_ref(sensor), &theta).is_empty() => problems.push(Problem::warning(
                path,
                format_args!(
                    "sensor `{}` reads no motion of the model: what it sits on is supported in its direction, or that dof is not active",
                    sensor.name
                ),
            )),
            Ok(_) => problems.extend(far_away(model, sensor).map(|text| Problem::warning(path, text))),
            Err(CorrelationError::UnknownPlace { what, name, suggestion, .. }) => problems.push(Problem::error(
                format!("{path}.{what}"),
                format_args!("the model has no {what} `{name}`{suggestion}"),
            )),
            Err(e) => problems.push(Problem::error(path, e)),
        }
    }
    problems.extend(close_together(model, sensors).map(|text| Problem::warning("sensors", text)));
    problems
}

/// A word about many sensors of which none has its place in the model: one for all of them.
fn of_another_model(model: &dyn ParametricModel, sensors: &[Sensor]) -> Option<String> {
    const MANY: usize = 4;
    let unknown = |s: &Sensor| match locate(model, s, None) {
        Err(CorrelationError::UnknownPlace { what, name, suggestion, .. }) => Some((what, name, suggestion)),
        _ => None,
    };
    let (what, name, suggestion) = unknown(sensors.first().filter(|_| sensors.len() >= MANY)?)?;
    sensors.iter().all(|s| unknown(s).is_some()).then(|| {
        format!(
            "none of the {} sensors has its place in the model: the model has no {what} `{name}`{suggestion}; is this the test of another model?",
            sensors.len()
        )
    })
}

/// Sensors that stand in a smaller part of the structure than this are in another unit of length.
const CLOSE: f64 = 0.02;

/// A word about sensors with positions of their own that all stand at what is one place on the structure.
fn close_together(model: &dyn ParametricModel, sensors: &[Sensor]) -> Option<String> {
    let mut stated: Vec<[f64; 3]> = sensors.iter().filter_map(|s| s.place.position()).collect();
    stated.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    stated.dedup();
    let (span, size) = (extent(&stated), extent(model.dof_map().positions()));
    (stated.len() > 2 && span < CLOSE * size).then(|| {
        format!(
            "the positions of the sensors span {span:.2e} m, and the structure is {size:.3} m large: were they read in another unit of length than they \
             are in?"
        )
    })
}

/// A word about a sensor that stands farther from the structure than the structure is large.
fn far_away(model: &dyn ParametricModel, sensor: &Sensor) -> Option<String> {
    let (point, _) = locate(model, sensor, None).ok()?;
    let at = sensor_position(model, sensor).ok()?;
    let arm = (0..3).map(|k| (at[k] - point.position[k]).powi(2)).sum::<f64>().sqrt();
    let size = extent(model.dof_map().positions());
    let text = format!(
        "sensor `{}` stands {arm:.3} m from what it sits on, and the structure is {size:.3} m large: is a unit missing?",
        sensor.name
    );
    (size > 0.0 && arm > size).then_some(text)
}

/// Where a sensor is, in global axes, m.
pub fn sensor_position(model: &dyn ParametricModel, sensor: &Sensor) -> Result<[f64; 3], CorrelationError> {
    let (point, position) = locate(model, sensor, None)?;
    let offset = sensor.offset.unwrap_or([0.0; 3]);
    Ok(position.unwrap_or_else(|| [0, 1, 2].map(|k| point.position[k] + offset[k])))
}

pub(super) fn locate(
    model: &dyn ParametricModel,
    sensor: &Sensor,
    theta: Option<&[f64]>,
) -> Result<(PointMotion, Option<[f64; 3]>), CorrelationError> {
    let dofs = model.dofs_of_nodes();
    let failed = |e: ModelError| CorrelationError::Model(e.to_string());
    match &sensor.place {
        Place::Node { node, position } => {
            let index = dofs.node(node).ok_or_else(|| CorrelationError::UnknownPlace {
                sensor: sensor.name.clone(),
                what: "node",
                name: node.clone(),
                suggestion: did_you_mean(node, dofs.node_names().iter().map(String::as_str)),
            })?;
            let varying = theta.map(|t| model.node_at(index, t)).transpose().map_err(failed)?.flatten();
            let fixed = || {
                let rows = Dof::ALL.map(|d| dofs.express(index, d).to_vec());
                PointMotion { rows, position: dofs.positions()[index] }
            };
            Ok((varying.unwrap_or_else(fixed), *position))
        }
        Place::Element { element, fraction, position } => {
            if let Some(place) = position
                && let Some(point) = model.point_near(element, *place).map_err(failed)?
            {
                return Ok((point, *position));
            }
            let varying = theta.map(|t| model.point_at(element, *fraction, t)).transpose().map_err(failed)?.flatten();
            let point = if varying.is_some() { varying } else { model.point(element, *fraction).map_err(failed)? };
            let point = point.ok_or_else(|| CorrelationError::UnknownPlace {
                sensor: sensor.name.clone(),
                what: "element",
                name: element.clone(),
                suggestion: did_you_mean(element, model.element_names()),
            })?;
            Ok((point, *position))
        }
    }
}
