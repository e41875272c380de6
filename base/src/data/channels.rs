//! Channels of frequency response functions as sensors, and functions without the faults of their channels.

use super::{Channel, Correction, FrfSet, Place, Sensor};
use retune_linalg::Complex;

/// Cosine of two directions above which they are one, up to the sign.
pub const PARALLEL: f64 = 1.0 - 1e-6;

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
            let is_stated = |c: &Channel| is_of(c, &correction.sensor) || c.name == correction.sensor;
            for k in (0..set.references.len()).filter(|&k| is_stated(&set.references[k])).collect::<Vec<_>>() {
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

/// a · b of two directions.
pub fn cosine(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}
