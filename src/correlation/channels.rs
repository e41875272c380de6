//! From channels of frequency response functions to sensors.

use super::{CorrelationError, observation_matrix};
use crate::catalogue::did_you_mean;
use crate::data::{Channel, PARALLEL, Place, Sensor, TestData, channel_sensor, cosine};
use crate::model::ParametricModel;
use crate::yaml::Problem;

/// The sensor that a channel is which enters a fit, and so must be somewhere: without a sensor it is the node of its name, along its direction.
///
/// # Errors
/// Neither a sensor nor a direction.
pub fn fitted_channel(channel: &Channel, test: &TestData) -> Result<Sensor, CorrelationError> {
    if let Some(sensor) = channel_sensor(channel, &test.sensors) {
        return Ok(sensor);
    }
    let direction = channel.direction.ok_or_else(|| {
        let names = test.sensors.iter().map(|s| s.name.as_str());
        let suggestion = did_you_mean(&channel.name, names);
        CorrelationError::Model(format!(
            "the functions have a channel `{}` without a direction, and the test has no sensor of that name{suggestion}",
            channel.name
        ))
    })?;
    let place = Place::Node { node: channel.name.clone(), position: None };
    Ok(Sensor { name: channel.name.clone(), place, offset: None, direction, is_rotation: false, mass: None })
}

/// Checks the functions that enter a fit against a model: all problems at once, with their path in the test file.
///
/// An error where there is no line, none in a band, or a channel is neither a sensor nor a node; a warning where values are missing, where a channel reads no motion of the model, or measures along another
/// axis than the sensor of its name.
pub fn check_functions(model: &dyn ParametricModel, test: &TestData) -> Vec<Problem> {
    const PATH: &str = "frfs.files";
    let (Some(set), Some(fit)) = (&test.frfs, &test.frf_fit) else { return Vec::new() };
    let mut problems = Vec::new();
    let (Some(first), Some(last)) = (set.frequencies_hz.first(), set.frequencies_hz.last()) else {
        return vec![Problem::error(PATH, "these functions have no line")];
    };
    for (i, [low, high]) in fit.bands_hz.iter().enumerate() {
        if !set.frequencies_hz.iter().any(|f| (*low..=*high).contains(f)) {
            let text = format!(
                "no line of the functions lies in {low} Hz to {high} Hz; they reach from {first} Hz to {last} Hz"
            );
            problems.push(Problem::error(format!("frfs.bands[{i}]"), text));
        }
    }
    let (missing, all) = set.missing();
    if missing > 0 {
        let text = format!("{missing} of {all} values left out: empty or no numbers");
        problems.push(Problem::warning(PATH, text));
    }
    let mut channels: Vec<&Channel> = Vec::new();
    for channel in set.references.iter().chain(&set.responses) {
        if !channels.contains(&channel) {
            channels.push(channel);
        }
    }
    for channel in channels {
        let sensor = match fitted_channel(channel, test) {
            Ok(sensor) => sensor,
            Err(CorrelationError::Model(text)) => {
                problems.push(Problem::error(PATH, text));
                continue;
            }
            Err(e) => {
                problems.push(Problem::error(PATH, e));
                continue;
            }
        };
        let name = &channel.name;
        match observation_matrix(model, std::slice::from_ref(&sensor)) {
            Ok(row) if row.amax() == 0.0 => problems.push(Problem::warning(
                PATH,
                format_args!(
                    "channel `{name}` along {} reads no motion of the model; it is left out",
                    axis(sensor.direction)
                ),
            )),
            Ok(_) => {
                let own = test.sensors.iter().find(|s| s.name == sensor.name);
                if let Some(own) = own.filter(|s| cosine(s.direction, sensor.direction).abs() <= PARALLEL) {
                    let (here, there) = (axis(sensor.direction), axis(own.direction));
                    let text = format!(
                        "channel `{name}` of the functions measures along {here}, the sensor `{}` along {there}: the former counts here",
                        own.name
                    );
                    problems.push(Problem::warning(PATH, text));
                }
            }
            Err(CorrelationError::UnknownPlace { .. }) => {
                let names = test.sensors.iter().map(|s| s.name.as_str());
                let suggestion =
                    did_you_mean(name, names.chain(model.dof_map().node_names().iter().map(String::as_str)));
                let text = format!(
                    "the functions have a channel `{name}`, which is neither a sensor of the test nor a node of the model{suggestion}"
                );
                problems.push(Problem::error(PATH, text));
            }
            Err(e) => problems.push(Problem::error(PATH, e)),
        }
    }
    problems
}

/// "+z" or "[0.6, 0, 0.8]".
fn axis(d: [f64; 3]) -> String {
    let along = (0..3).find(|&i| d[i].abs() > PARALLEL);
    along.map_or_else(
        || format!("[{:.3}, {:.3}, {:.3}]", d[0], d[1], d[2]),
        |i| format!("{}{}", if d[i] < 0.0 { '-' } else { '+' }, ['x', 'y', 'z'][i]),
    )
}
