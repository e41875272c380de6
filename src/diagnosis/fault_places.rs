//! Which faults a test could show: those of every sensor, of pairs of sensors, of modes, and of frequency responses.

use super::faults::{AXES, Change, FREQUENCY_SD, Fault, across, response_of};
use super::scene::Scene;
use crate::correlation::channel_sensor;
use crate::data::Place;
use crate::model::{dot, minus, plus};

/// Frequencies of a test from which one may be told wrong.
const FEWEST_FREQUENCIES: usize = 3;
/// Places nearer to each other than this are one, m.
const ONE_PLACE: f64 = 1e-9;
/// Directions whose cosine is less are perpendicular.
const PERPENDICULAR: f64 = 1e-9;
/// A sensor is along a direction if the cosine between them is more.
const ALONG: f64 = 0.9;
/// Neighbours at whose places a sensor is tried.
const NEIGHBOURS: usize = 4;

/// Every fault that these data could show.
///
/// What takes a reading out of the data must leave most of them: a sensor that is dead among sensors of which more than half read, a
/// frequency that is mistyped among frequencies of which more than half are right. With more such faults the data say nothing that a model
/// could be wrong about.
pub(super) fn faults(scene: &Scene) -> Vec<Fault> {
    let test = &scene.test;
    let n = test.sensors.len();
    let mut out = Vec::new();
    let add = |out: &mut Vec<Fault>, sensor, change| out.push(Fault::of(sensor, change));
    // A single reading of a channel in one mode is no channel.
    if test.modes.iter().filter(|m| m.shape.is_some()).count() >= 1 && n >= 3 {
        let reads = |s: usize| test.modes.iter().any(|m| m.shape.as_ref().is_some_and(|v| !v[s].re.is_nan()));
        let may_be_dead = leaves_most((0..n).filter(|&s| reads(s)).count(), n);
        for s in 0..n {
            for change in [Change::Sign, Change::Gain, Change::Dead, Change::Noisy] {
                if change != Change::Dead || may_be_dead {
                    add(&mut out, s, change);
                }
            }
        }
        for s in 0..n {
            for other in (s + 1..n).filter(|&o| scene.are_together(s, o)) {
                add(&mut out, s, Change::Swap(other));
            }
        }
        for s in 0..n {
            let d = test.sensors[s].direction;
            for axis in 0..3 {
                if d[axis].abs() < ALONG {
                    add(&mut out, s, Change::Axis(axis));
                }
            }
        }
        if let Ok(at) = scene.sensor_positions() {
            turned(scene, &at, &mut out);
            tilted(scene, &at, &mut out);
            positions(scene, &at, &mut out);
        }
        out.extend(in_one_test(scene, &out));
    }
    for case in &scene.cases {
        for a in case.modes().skip(1) {
            add(&mut out, a - 1, Change::Order(a - 1, a));
        }
        // One that is known worse than a slip would make it says nothing.
        let is_known = |m: &usize| {
            let f = test.modes[*m].frequency_hz;
            f.sd < FREQUENCY_SD * f.value
        };
        let known: Vec<usize> = case.modes().filter(is_known).collect();
        if known.len() >= FEWEST_FREQUENCIES && leaves_most(known.len(), case.modes().len()) {
            for m in known {
                add(&mut out, m, Change::Frequency(m));
            }
        }
    }
    for (case, tested) in scene.cases.iter().enumerate() {
        let Some(set) = tested.test.frfs.as_ref().filter(|_| tested.test.frf_fit.is_some()) else { continue };
        let sensors = &tested.test.sensors;
        for (own, &s) in tested.sensors.iter().enumerate() {
            if response_of(set, sensors, own).is_some() {
                out.push(Fault { only: (scene.cases.len() > 1).then_some(case), ..Fault::of(s, Change::FunctionGain) });
            }
        }
        for (reference, channel) in set.references.iter().enumerate() {
            let stated = channel_sensor(channel, sensors).map_or_else(|| channel.name.clone(), |s| s.name);
            let others = sensors.iter().zip(&tested.sensors);
            for (_, &s) in others.filter(|(o, _)| o.name != stated && !o.is_rotation) {
                add(&mut out, s, Change::DrivingPoint { case, reference });
            }
        }
    }
    out
}

/// Whether more than half of all readings are left when one of those that count is taken out.
fn leaves_most(counting: usize, all: usize) -> bool {
    2 * (counting - counting.min(1)) > all
}

/// The same faults in one test alone, where several tests have the sensor: cables are plugged anew for each.
fn in_one_test(scene: &Scene, faults: &[Fault]) -> Vec<Fault> {
    let has = |case: usize, s: usize| scene.cases[case].sensors.contains(&s);
    let of = |fault: &Fault| -> Vec<Fault> {
        let other = if let Change::Swap(o) | Change::Turned(o) = fault.change { o } else { fault.sensor };
        let cases: Vec<usize> = (0..scene.cases.len()).filter(|&c| has(c, fault.sensor) && has(c, other)).collect();
        let alone = |&case: &usize| Fault { only: Some(case), ..fault.clone() };
        if cases.len() > 1 { cases.iter().map(alone).collect() } else { Vec::new() }
    };
    faults.iter().flat_map(of).collect()
}

/// Pairs of perpendicular sensors at one place.
fn turned(scene: &Scene, at: &[[f64; 3]], out: &mut Vec<Fault>) {
    let sensors = &scene.test.sensors;
    for s in 0..sensors.len() {
        for other in (s + 1..sensors.len()).filter(|&o| share_a_place(scene, at, s, o)) {
            if dot(sensors[s].direction, sensors[other].direction).abs() < PERPENDICULAR {
                out.push(Fault::of(s, Change::Turned(other)));
            }
        }
    }
}

/// Sensors that no other at their place is turned with, towards every global axis across them.
fn tilted(scene: &Scene, at: &[[f64; 3]], out: &mut Vec<Fault>) {
    let sensors = &scene.test.sensors;
    for (s, sensor) in sensors.iter().enumerate() {
        for axis in (0..3).filter(|&axis| sensor.direction[axis].abs() < ALONG) {
            let e = across(sensor.direction, axis);
            let turns_with = |o: usize| dot(sensors[o].direction, e).abs() > ALONG && share_a_place(scene, at, s, o);
            if !(0..sensors.len()).any(|o| o != s && turns_with(o)) {
                out.push(Fault::of(s, Change::Tilted(axis)));
            }
        }
    }
}

/// Whether two sensors of one test read the same kind of motion at one place.
fn share_a_place(scene: &Scene, at: &[[f64; 3]], a: usize, b: usize) -> bool {
    let sensors = &scene.test.sensors;
    scene.are_together(a, b) && sensors[a].is_rotation == sensors[b].is_rotation && distance(at[a], at[b]) < ONE_PLACE
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = minus(a, b);
    dot(d, d).sqrt()
}

/// The places of the nearest other sensors and of the nearest node of the file, and the other sides of its own node.
fn positions(scene: &Scene, at: &[[f64; 3]], out: &mut Vec<Fault>) {
    let sensors = &scene.test.sensors;
    // Nodes stand at the same places in every configuration.
    let nodes: Vec<(String, [f64; 3])> = {
        let g = scene.model().geometry();
        let positions = g.positions.iter().map(|p| [p[0], p[1], p[2]]);
        g.names.iter().cloned().zip(positions).take(scene.model().spec().nodes.len()).collect()
    };
    for (s, &here) in at.iter().enumerate() {
        let mut near: Vec<(f64, usize)> = (0..at.len())
            .filter(|&o| o != s && scene.are_together(s, o))
            .map(|o| (distance(here, at[o]), o))
            .filter(|(d, _)| *d > 0.0)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        // Several sensors at one place are one place.
        let mut known: Vec<[f64; 3]> = Vec::new();
        near.retain(|&(_, o)| known.len() < NEIGHBOURS && is_new(&mut known, at[o]));
        for &(_, o) in &near {
            let name = sensors[o].name.clone();
            out.push(Fault::of(
                s,
                Change::Position { place: sensors[o].place.clone(), offset: sensors[o].offset, name },
            ));
        }
        let nearest = nodes
            .iter()
            .map(|(name, p)| (distance(here, *p), name, *p))
            .filter(|(d, ..)| *d > ONE_PLACE)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, name, _)) = nearest.filter(|&(.., p)| is_new(&mut known, p)) {
            let place = Place::Node { node: name.clone(), position: None };
            out.push(Fault::of(s, Change::Position { place, offset: None, name: name.clone() }));
        }
        let mirrored = mirrored(scene, s).into_iter();
        out.extend(mirrored.filter(|&(_, p)| is_new(&mut known, p)).map(|(fault, _)| fault));
    }
}

/// Whether a place is none of those that are known; then it is one of them.
fn is_new(known: &mut Vec<[f64; 3]>, place: [f64; 3]) -> bool {
    let is_new = known.iter().all(|k| distance(*k, place) > ONE_PLACE);
    known.extend(is_new.then_some(place));
    is_new
}

/// A sensor on the other side of its node, in each direction in which it stands beside it: the slip of a sign. With the place there.
fn mirrored(scene: &Scene, s: usize) -> Vec<(Fault, [f64; 3])> {
    let sensor = &scene.test.sensors[s];
    let Place::Node { node, position } = &sensor.place else { return Vec::new() };
    let geometry = scene.model().geometry();
    let Some(at) = geometry.node(node).map(|n| geometry.positions[n]) else { return Vec::new() };
    let arm = match (position, sensor.offset) {
        (Some(p), _) => minus(*p, at),
        (None, offset) => offset.unwrap_or_default(),
    };
    let on_the_other_side = |axis: usize| {
        let mut offset = arm;
        offset[axis] = -offset[axis];
        let name = format!("mirrored {}", AXES[axis]);
        let place = Place::Node { node: node.clone(), position: None };
        (Fault::of(s, Change::Position { place, offset: Some(offset), name }), plus(at, 1.0, offset))
    };
    (0..3).filter(|&axis| arm[axis].abs() > ONE_PLACE).map(on_the_other_side).collect()
}
