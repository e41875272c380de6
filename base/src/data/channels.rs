//! Channels of frequency response functions as sensors, and functions without the faults of their channels.

use super::{Channel, Correction, FrfSet, Place, Sensor};
use retune_linalg::Complex;
use std::collections::BTreeSet;

/// Cosine of two directions above which they are one, up to the sign.
pub const PARALLEL: f64 = 1.0 - 1e-6;

/// Characters of a name that a universal file has room for (dataset 58, record 6).
const ROOM: usize = 10;

/// The sensor that a channel is: of its name (`p3` of a channel is also the sensor `p3.z`), else on a node of its name; turned into the
/// channel's direction. A name that a universal file has cut is the one node or sensor that begins with it.
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
        .or_else(|| candidates().find(|s| stands_there(s)))
        .or_else(|| {
            let is_cut = |name: &str| channel.name.chars().count() == ROOM && name.starts_with(&channel.name);
            let on_nodes = |s: &Sensor| match &s.place {
                Place::Node { node, .. } if is_cut(node) => Some(node.clone()),
                _ => None,
            };
            let of_names = |s: &Sensor| is_cut(&s.name).then(|| s.name.clone());
            let the_one = |of: &dyn Fn(&Sensor) -> Option<String>| {
                let whole: BTreeSet<String> = candidates().filter_map(of).collect();
                let own = || candidates().filter(|s| of(s).is_some());
                own().find(|s| on_axis(s)).or_else(|| own().next()).filter(|_| whole.len() == 1)
            };
            the_one(&on_nodes).or_else(|| the_one(&of_names))
        })?;
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

#[cfg(test)]
mod tests {
    use super::super::read_test;
    use super::*;

    #[test]
    fn a_name_that_a_universal_file_has_cut_is_the_one_that_begins_so() {
        let text = "retune_test: 1\nname: t\nsensors:\n\
                    \x20 corner_left.ux: {node: corner_left, direction: +x}\n\
                    \x20 corner_left.uz: {node: corner_left, direction: +z}\n\
                    \x20 quarter_left.uz: {node: quarter_left, direction: +z}\n\
                    \x20 quarter_lean.uz: {node: quarter_lean, direction: +z}\n\
                    \x20 accelerometer_7: {node: a, direction: +y}\n\
                    sources: {made: {kind: synthetic, text: by hand}}\n\
                    modes: [{frequency: 5 Hz, frequency_sd: 0.1 Hz, source: made}]\n";
        let sensors = read_test(text).unwrap().0.sensors;
        let found = |name: &str, direction: [f64; 3]| {
            let channel = Channel { name: name.to_string(), direction: Some(direction) };
            channel_sensor(&channel, &sensors).map(|s| s.name)
        };
        assert_eq!(found("corner_lef", [0.0, 0.0, 1.0]).as_deref(), Some("corner_left.uz"));
        assert_eq!(found("accelerome", [0.0, 1.0, 0.0]).as_deref(), Some("accelerometer_7"));
        // Two begin so, and a shorter name was not cut.
        assert_eq!(found("quarter_le", [0.0, 0.0, 1.0]), None);
        assert_eq!(found("corner", [1.0, 0.0, 0.0]), None);
    }
}
