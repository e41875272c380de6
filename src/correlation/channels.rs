//! From channels of frequency response functions to sensors.

use super::{CorrelationError, observation_matrix};
use crate::catalogue::did_you_mean;
use crate::data::{Channel, Correction, FrfSet, Place, Sensor, TestData};
use crate::linalg::Complex;
use crate::model::ParametricModel;
use crate::yaml::Problem;

/// Cosine of two directions above which they are one, up to the sign.
const PARALLEL: f64 = 1.0 - 1e-6;

/// The sensor that a channel is: of its name (`p3` of a channel is also the sensor `p3.z`), else on a node of its name; turned into the
/// channel's direction.
pub fn channel_sensor(channel: &Channel, sensors: &[Sensor]) -> Option<Sensor> {
    let on_axis = |s: &Sensor| channel.direction.is_none_or(|d| cosine(d, s.direction).abs() > PARALLEL);
    let is_named = |s: &Sensor| {
        let base = s.name.strip_suffix(".x").or(s.name.strip_suffix(".y")).or(s.name.strip_suffix(".z"));
        s.name == channel.name || base == Some(channel.name.as_str())
    };
    let stands_there = |s: &Sensor| matches!(&s.place, Place::Node { node, .. } if *node == channel.name);
    let candidates = || sensors.iter().filter(|s| !s.is_rotation);
    let found = candidates()
        .find(|s| is_named(s) && on_axis(s))
        .or_else(|| candidates().find(|s| is_named(s)))
        .or_else(|| candidates().find(|s| stands_there(s)))?;
    Some(Sensor { direction: channel.direction.unwrap_or(found.direction), ..found.clone() })
}

/// Functions without the faults that have been taken out of a test, in the order in which they were.
///
/// * `sensors` - of the corrected test
pub fn corrected_functions(mut set: FrfSet, sensors: &[Sensor], corrections: &[Correction]) -> FrfSet {
    for correction in corrections {
        let is_of = |c: &Channel, name: &str| channel_sensor(c, sensors).is_some_and(|s| s.name == name);
        let all = |list: &[Channel], name: &str| -> Vec<usize> {
            (0..list.len()).filter(|&k| is_of(&list[k], name)).collect()
        };
        let mut own = all(&set.responses, &correction.sensor);
        if let Some((stated, k)) = correction.stated.zip(sensors.iter().position(|s| s.name == correction.sensor)) {
            let mut as_stated = sensors.to_vec();
            as_stated[k].direction = stated;
            let is_own = |c: &Channel| channel_sensor(c, &as_stated).is_some_and(|s| s.name == correction.sensor);
            own = (0..set.responses.len()).filter(|&i| is_own(&set.responses[i])).collect();
            for i in &own {
                let channel = &mut set.responses[*i];
                let along = channel.direction.map(|d| cosine(d, stated));
                if let Some(sign) = along.filter(|c| c.abs() > PARALLEL).map(f64::signum) {
                    channel.direction = Some(sensors[k].direction.map(|v| sign * v));
                }
            }
        }
        if let Some(other) = &correction.exchanged_with {
            let others = all(&set.responses, other);
            for (&a, &b) in own.iter().zip(&others) {
                for line in 0..set.n_lines() {
                    for reference in 0..set.references.len() {
                        let (i, j) = (set.index(line, reference, a), set.index(line, reference, b));
                        set.h.swap(i, j);
                        if let Some(coherence) = &mut set.coherence {
                            coherence.swap(i, j);
                        }
                    }
                }
            }
        }
        if let Some(there) = correction.acted_at.as_ref().and_then(|name| sensors.iter().find(|s| s.name == *name)) {
            for k in all(&set.references, &correction.sensor) {
                set.references[k] = Channel { name: there.name.clone(), direction: Some(there.direction) };
            }
        }
        let every = |k: usize, set: &mut FrfSet, change: &dyn Fn(&mut Complex<f64>)| {
            for line in 0..set.n_lines() {
                for reference in 0..set.references.len() {
                    let i = set.index(line, reference, k);
                    change(&mut set.h[i]);
                }
            }
        };
        for k in own {
            if let Some(factor) = correction.factor {
                every(k, &mut set, &|h| *h /= factor);
            }
            if correction.reads_nothing {
                every(k, &mut set, &|h| *h = Complex::new(f64::NAN, f64::NAN));
            }
        }
    }
    set
}

/// The same for a channel that enters a fit, which must be somewhere: without a sensor it is the node of its name, along its direction.
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
                    "the functions have a channel `{name}`, which is no sensor of the test and no node of the model{suggestion}"
                );
                problems.push(Problem::error(PATH, text));
            }
            Err(e) => problems.push(Problem::error(PATH, e)),
        }
    }
    problems
}

fn cosine(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// "+z" or "[0.6, 0, 0.8]".
fn axis(d: [f64; 3]) -> String {
    let along = (0..3).find(|&i| d[i].abs() > PARALLEL);
    along.map_or_else(
        || format!("[{:.3}, {:.3}, {:.3}]", d[0], d[1], d[2]),
        |i| format!("{}{}", if d[i] < 0.0 { '-' } else { '+' }, ['x', 'y', 'z'][i]),
    )
}
