//! A sensor at another place: at a neighbour's, at the nearest node, or on the other side of its own.

use super::bench::{ONE_PLACE, distance};
use super::{AboutFault, At, Bench, Fault, Tests};
use crate::data::{Place, Sensor};
use crate::model::{AXES, minus, plus};

/// Neighbours at whose places a sensor is tried.
const NEIGHBOURS: usize = 4;

/// See [`Fault::about`].
#[derive(Debug)]
pub struct SensorPosition;

impl Fault for SensorPosition {
    fn name(&self) -> &'static str {
        "sensor-position"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A sensor sits at another place than the test says: where one of its neighbours sits, on the nearest node, or on the other side of its own.",
            signature: "It reads what the model has there.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        let Some(at) = &bench.positions else { return Vec::new() };
        bench.channels().flat_map(|s| of_sensor(bench, at, s)).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        let At::Place { sensor, name, .. } = at else { return String::new() };
        let sensor = tests.sensor(*sensor);
        match name.strip_prefix("mirrored ") {
            Some(axis) => format!("sensor {sensor} sits on the other side of its node along {axis}"),
            None => format!("sensor {sensor} sits at {name}"),
        }
    }

    fn sensors(&self, at: &At, _: f64, sensors: &mut [Sensor]) {
        let At::Place { sensor, place, offset, .. } = at else { return };
        let moved = &mut sensors[*sensor];
        moved.place.clone_from(place);
        moved.offset = *offset;
    }
}

/// The places of the nearest other sensors and of the nearest node of the file, and the other sides of its own node; each place once.
fn of_sensor(bench: &Bench<'_>, at: &[[f64; 3]], s: usize) -> Vec<At> {
    let (sensors, here) = (bench.sensors(), at[s]);
    let mut near: Vec<(f64, usize)> = (0..at.len())
        .filter(|&o| o != s && bench.are_together(s, o))
        .map(|o| (distance(here, at[o]), o))
        .filter(|(d, _)| *d > 0.0)
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut known: Vec<[f64; 3]> = Vec::new();
    near.retain(|&(_, o)| known.len() < NEIGHBOURS && is_new(&mut known, at[o]));
    let of_neighbour = |&(_, o): &(f64, usize)| {
        let Sensor { name, place, offset, .. } = sensors[o].clone();
        At::Place { sensor: s, place, offset, name }
    };
    let mut out: Vec<At> = near.iter().map(of_neighbour).collect();
    let nearest = bench
        .nodes
        .iter()
        .map(|(name, p)| (distance(here, *p), name, *p))
        .filter(|(d, ..)| *d > ONE_PLACE)
        .min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((_, name, _)) = nearest.filter(|&(.., p)| is_new(&mut known, p)) {
        let place = Place::Node { node: name.clone(), position: None };
        out.push(At::Place { sensor: s, place, offset: None, name: name.clone() });
    }
    out.extend(mirrored(bench, s).into_iter().filter(|&(_, p)| is_new(&mut known, p)).map(|(there, _)| there));
    out
}

/// Whether a place is none of those that are known; then it is one of them.
fn is_new(known: &mut Vec<[f64; 3]>, place: [f64; 3]) -> bool {
    let is_new = known.iter().all(|k| distance(*k, place) > ONE_PLACE);
    known.extend(is_new.then_some(place));
    is_new
}

/// A sensor on the other side of its node, in each direction in which it stands beside it: the slip of a sign. With the place there.
fn mirrored(bench: &Bench<'_>, s: usize) -> Vec<(At, [f64; 3])> {
    let sensor = &bench.sensors()[s];
    let Place::Node { node, position } = &sensor.place else { return Vec::new() };
    let Some(&(_, at)) = bench.nodes.iter().find(|(name, _)| name == node) else { return Vec::new() };
    let arm = match (position, sensor.offset) {
        (Some(p), _) => minus(*p, at),
        (None, offset) => offset.unwrap_or_default(),
    };
    let on_the_other_side = |axis: usize| {
        let mut offset = arm;
        offset[axis] = -offset[axis];
        let place = Place::Node { node: node.clone(), position: None };
        let name = format!("mirrored {}", AXES[axis]);
        (At::Place { sensor: s, place, offset: Some(offset), name }, plus(at, 1.0, offset))
    };
    (0..3).filter(|&axis| arm[axis].abs() > ONE_PLACE).map(on_the_other_side).collect()
}
