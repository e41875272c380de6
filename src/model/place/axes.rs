//! Axes of elements along their nodes where the file does not state them, and where that default is arbitrary.

use crate::element::Axes;
use crate::linalg::SymMatrix;
use crate::model::dependence::{element_matrices, interior_point, step};
use crate::model::geometry::{Rotation, Vector, axes_along, cross, dot, plus};
use crate::model::parameter::ParameterSet;
use crate::model::placed_element::PlacedElement;
use crate::yaml::{Problem, child};
use std::collections::HashSet;

/// Sine of the angle to global z up to which an element is vertical: what is left of it is rounding of coordinates.
const VERTICAL: f64 = 1e-4;
/// Sine of the angle to global z from which the plane of an element and global z is clear: 2.9 degrees.
const INCLINED: f64 = 0.05;
/// Relative difference of stiffness or mass that matters: a frequency moves by half of it.
const ALIKE: f64 = 1e-3;
/// A section that turns about its member by more than this from one element of a chain to the next is turned over, rad.
const TURNED_OVER: f64 = 2.4;

/// A direction near the z axis of an element along `x` that states none: global z, or global y for a vertical element.
pub(super) fn default_near_z(x: Vector) -> Vector {
    if is_vertical(x) { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] }
}

fn is_vertical(x: Vector) -> bool {
    x[0].hypot(x[1]) <= VERTICAL
}

/// Refuses default axes that are arbitrary, and remarks on those that change within a chain; only where the section is not the same
/// about both.
///
/// Near global z no default can be continuous in all directions, so that a hair of inclination would decide how the section lies.
pub(super) fn check(elements: &[PlacedElement], parameters: &ParameterSet, problems: &mut Vec<Problem>) {
    let thetas = probes(parameters);
    let mut said: HashSet<&str> = HashSet::new();
    for e in elements.iter().filter(|e| e.kind.axes() == Axes::AlongNodes && e.orientation.is_none()) {
        let x = e.axes[0];
        let sine = x[0].hypot(x[1]);
        if !(VERTICAL..INCLINED).contains(&sine) || said.contains(e.path.as_str()) {
            continue;
        }
        // A section that is turned to its principal axes is so either way.
        let both = axes_along(x, default_near_z(x)).zip(axes_along(x, [0.0, 1.0, 0.0]));
        let Some((default, other)) = both else { continue };
        if differs(e, angle(&default, &other), &thetas) {
            said.insert(&e.path);
            problems.push(Problem::error(
                child(&e.path, "orientation"),
                format_args!(
                    "element `{}` is {:.2} degrees off global z, where the default direction of its section is arbitrary: global y for a vertical element, global z for an inclined one; the section is not the same both ways, so state the direction of its z axis, such as `orientation: [0, 1, 0]`",
                    e.name,
                    sine.asin().to_degrees()
                ),
            ));
        }
    }
    for pair in elements.windows(2) {
        let [e, f] = pair else { continue };
        let is_chain = e.path == f.path && e.nodes.len() == 2 && e.nodes.get(1) == f.nodes.first();
        if !is_chain || e.kind.axes() != Axes::AlongNodes || said.contains(e.path.as_str()) {
            continue;
        }
        let Some(carried) = carried(&e.axes, f.axes[0]) else { continue };
        let turn = angle(&f.axes, &carried);
        let changes_rule = e.orientation.is_none() && is_vertical(e.axes[0]) != is_vertical(f.axes[0]);
        if (changes_rule || turn.abs() > TURNED_OVER) && differs(f, turn, &thetas) {
            said.insert(&e.path);
            let why = if changes_rule {
                " (its default z axis is near global y where it is vertical, near global z elsewhere)"
            } else {
                ""
            };
            problems.push(Problem::warning(
                &e.path,
                format_args!(
                    "between elements `{}` and `{}` of this chain the section turns by {:.0} degrees about the member{why}; is that meant? `orientation: [x, y, z]` states the direction of the z axis, and one across the plane of the chain serves all of it",
                    e.name,
                    f.name,
                    turn.abs().to_degrees()
                ),
            ));
        }
    }
}

/// The estimates, and a point with every parameter moved.
fn probes(parameters: &ParameterSet) -> [Vec<f64>; 2] {
    let base = interior_point(parameters);
    let moved = base.iter().enumerate().map(|(i, v)| v + step(parameters, i, *v) / (2.0 + i as f64)).collect();
    [base, moved]
}

/// Axes carried along a chain to an element along `x` without turning about the member; `None` where the chain folds back.
fn carried(axes: &Rotation, x: Vector) -> Option<Rotation> {
    let (w, c) = (cross(axes[0], x), dot(axes[0], x));
    // v + w × v + w × (w × v)/(1 + c), the rotation from one direction to the other.
    (c > -0.999).then(|| axes.map(|v| plus(plus(v, 1.0, cross(w, v)), 1.0 / (1.0 + c), cross(w, cross(w, v)))))
}

/// The angle about x from some axes to others.
fn angle(from: &Rotation, to: &Rotation) -> f64 {
    dot(to[1], from[2]).atan2(dot(to[1], from[1]))
}

/// Whether the matrices of an element are others when its section is turned about x.
fn differs(element: &PlacedElement, turn: f64, thetas: &[Vec<f64>]) -> bool {
    thetas
        .iter()
        .filter_map(|theta| element_matrices(element, theta).ok())
        .any(|m| [&m.stiffness, &m.mass].into_iter().any(|a| is_changed(a, turn)))
}

fn is_changed(a: &SymMatrix, turn: f64) -> bool {
    let n = a.n();
    let (sin, cos) = turn.sin_cos();
    let mut rotation = crate::linalg::DMatrix::identity(n, n);
    for first in (0..n).step_by(3) {
        let (y, z) = (first + 1, first + 2);
        (rotation[(y, y)], rotation[(y, z)], rotation[(z, y)], rotation[(z, z)]) = (cos, sin, -sin, cos);
    }
    let dense = a.to_dense();
    let turned = rotation.transpose() * &dense * &rotation;
    let size = |i: usize| {
        let group = i - i % 3;
        let of = |k: usize| dense[(k, k)].abs().max(turned[(k, k)].abs());
        if i.is_multiple_of(3) { of(i) } else { of(group + 1).max(of(group + 2)) }
    };
    (0..n).any(|i| (0..=i).any(|j| (dense[(i, j)] - turned[(i, j)]).abs() > ALIKE * (size(i) * size(j)).sqrt()))
}
