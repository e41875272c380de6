//! Places of nodes and axes of frames: from the rules of the file to global coordinates.

mod nodes;

use super::affine::Affine;
use super::known::Known;
pub(super) use super::known::unknown;
use super::spec::{FrameSpec, LineSpec, ModelSpec, NodeRule, NodeSpec, SuperelementSpec};
pub(crate) use crate::linalg::vector3::{Vector3, cross, dot, minus, plus, unit};
use crate::units::{Scalar, ScalarError};
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashMap};

/// A vector in global axes, m.
pub type Vector = Vector3;

/// Rows are unit axes in global coordinates.
pub(crate) type Rotation = [[f64; 3]; 3];

/// Global axes.
pub const GLOBAL: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Global coordinates as functions of θ, m.
pub(super) type Place = [Affine; 3];

/// A place that no parameter moves.
pub(super) fn still(position: Vector) -> Place {
    position.map(Affine::constant)
}

/// Where a place is at θ.
pub(super) fn at(place: &Place, theta: &[f64]) -> Vector {
    [0, 1, 2].map(|i| place[i].at(theta))
}

/// a + f (b - a).
fn between(a: &Place, b: &Place, f: f64) -> Place {
    [0, 1, 2].map(|i| a[i].plus(f, &b[i].plus(-1.0, &a[i])))
}

/// A place and a step from it.
fn shifted(place: &Place, by: Vector) -> Place {
    [0, 1, 2].map(|i| place[i].plus(1.0, &Affine::constant(by[i])))
}

/// Names of the global axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// x along `along`, z as near as possible to `near_z`, y completing the right-handed frame.
pub(crate) fn axes_along(along: Vector, near_z: Vector) -> Option<Rotation> {
    let x = unit(along)?;
    let near = unit(near_z)?;
    let y = cross(near, x);
    // Sine of the angle between them: below 1e-6 the direction of y is rounding noise.
    let y = (dot(y, y) > 1e-12).then(|| unit(y)).flatten()?;
    Some([x, y, cross(x, y)])
}

/// Axes turned about their x by an angle, rad.
pub(super) fn turned(axes: Rotation, angle: f64) -> Rotation {
    if angle == 0.0 {
        return axes;
    }
    let [x, y, z] = axes;
    let (sin, cos) = angle.sin_cos();
    [x, plus(y.map(|v| v * cos), sin, z), plus(z.map(|v| v * cos), -sin, y)]
}

/// A frame of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin, global, m.
    pub origin: Vector,
    /// Axes.
    pub axes: Rotation,
}

/// Where a superelement stands: mirrored across an axis of its own, then turned and moved.
pub(super) struct Stand {
    frame: Frame,
    mirror: Option<usize>,
}

impl Stand {
    /// `None` where its frame is not known.
    pub(super) fn of(entry: &SuperelementSpec, frames: &BTreeMap<String, Frame>) -> Option<Self> {
        let global = Frame { origin: [0.0; 3], axes: GLOBAL };
        let frame = entry.frame.as_ref().map_or(Some(global), |name| frames.get(name).copied())?;
        Some(Self { frame, mirror: entry.mirror.map(|axis| axis as usize) })
    }

    pub(super) fn is_mirrored(&self) -> bool {
        self.mirror.is_some()
    }

    /// A direction of its own in global axes.
    pub(super) fn direction(&self, mut v: Vector) -> Vector {
        if let Some(normal) = self.mirror {
            v[normal] = -v[normal];
        }
        (0..3).fold([0.0; 3], |sum, i| plus(sum, v[i], self.frame.axes[i]))
    }

    /// A place of its own in global coordinates.
    pub(super) fn place(&self, p: Vector) -> Vector {
        plus(self.direction(p), 1.0, self.frame.origin)
    }
}

/// The place of a node of a superelement, `wing.12`.
fn on_superelement(spec: &ModelSpec, geometry: &Geometry, name: &str) -> Option<Vector> {
    spec.superelements.iter().find_map(|(own, entry)| {
        let label = name.strip_prefix(own.as_str())?.strip_prefix('.')?;
        let exported = entry.loaded.0.as_ref()?;
        let position = exported.nodes.iter().find(|n| n.name == label)?.position?;
        Some(Stand::of(entry, &geometry.frames)?.place(position))
    })
}

/// Everything that has a place.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Geometry {
    /// Names of nodes, in file order.
    pub names: Vec<String>,
    /// Their global coordinates, m.
    pub positions: Vec<Vector>,
    /// Frames by name.
    pub frames: BTreeMap<String, Frame>,
    /// Mirror plane: axis index and coordinate.
    pub mirror: Option<(usize, f64)>,
    index: HashMap<String, usize>,
    other_names: BTreeMap<String, usize>,
    /// Those that are not points but coordinates, sorted.
    coordinates: Vec<usize>,
    /// Where nodes stand whose coordinates name parameters.
    moving: BTreeMap<usize, Place>,
}

impl Geometry {
    /// Index of a node.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// Adds a node, and returns its index; of several of one name the first is the one that is found.
    pub(super) fn add(&mut self, name: String, position: Vector) -> usize {
        let index = self.names.len();
        self.index.entry(name.clone()).or_insert(index);
        self.names.push(name);
        self.positions.push(position);
        index
    }

    /// Where a node stands for any θ, if parameters move it.
    pub(super) fn moving(&self, node: usize) -> Option<&Place> {
        self.moving.get(&node)
    }

    /// Nodes that parameters move.
    pub fn moving_nodes(&self) -> impl Iterator<Item = usize> + '_ {
        self.moving.keys().copied()
    }

    /// Lets a node stand between two others, at a fraction, wherever these stand.
    pub(super) fn keep_between(&mut self, node: usize, [a, b]: [usize; 2], fraction: f64) {
        if self.moving.contains_key(&a) || self.moving.contains_key(&b) {
            // Arms at the ends do not move.
            let nominal = [a, b].map(|n| self.positions[n]);
            let straight = plus(nominal[0], fraction, minus(nominal[1], nominal[0]));
            let off = minus(self.positions[node], straight);
            let place = [a, b].map(|n| self.moving.get(&n).cloned().unwrap_or_else(|| still(self.positions[n])));
            let place = shifted(&between(&place[0], &place[1], fraction), off);
            self.moving.insert(node, place);
        }
    }

    /// Calls a node by one more name; its own stays the one that is written.
    pub(super) fn call(&mut self, name: String, node: usize) {
        self.index.entry(name.clone()).or_insert(node);
        self.other_names.entry(name).or_insert(node);
    }

    /// Names that nodes have beside those of [`Self::names`].
    pub(super) fn other_names(&self) -> &BTreeMap<String, usize> {
        &self.other_names
    }

    /// Adds a coordinate that is not a motion of a point, as a node of which the first dof is meant.
    pub(super) fn add_coordinate(&mut self, name: String, near: Vector) -> usize {
        let index = self.add(name, near);
        self.coordinates.push(index);
        index
    }

    /// Whether a node is not a point but a coordinate of a superelement.
    pub fn is_coordinate(&self, node: usize) -> bool {
        self.coordinates.binary_search(&node).is_ok()
    }

    /// The largest dimension of the structure, m.
    pub fn size(&self) -> f64 {
        extent(&self.positions)
    }

    /// The mirror image of a point in the symmetry plane.
    pub fn mirrored(&self, p: Vector) -> Option<Vector> {
        let (axis, at) = self.mirror?;
        let mut image = p;
        image[axis] = 2.0 * at - p[axis];
        Some(image)
    }
}

/// The largest dimension of a set of points, m; zero of none.
pub fn extent(positions: &[Vector]) -> f64 {
    (0..3)
        .map(|i| {
            let (low, high) =
                positions.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[i]), h.max(p[i])));
            high - low
        })
        .fold(0.0, f64::max)
}

/// Points in cells, to find those near a place.
#[derive(Debug)]
pub struct Near<'a> {
    points: &'a [Vector],
    width: f64,
    cells: HashMap<[i64; 3], Vec<usize>>,
}

impl<'a> Near<'a> {
    /// * `distance` - about how far will be looked
    pub(crate) fn new(points: &'a [Vector], distance: f64) -> Self {
        let width = if distance > 0.0 { 8.0 * distance } else { 1.0 };
        let mut near = Self { points, width, cells: HashMap::new() };
        for (i, &p) in points.iter().enumerate() {
            near.cells.entry(near.cell(p)).or_default().push(i);
        }
        near
    }

    fn cell(&self, p: Vector) -> [i64; 3] {
        p.map(|c| (c / self.width).floor() as i64)
    }

    /// The points whose coordinates are all within a distance of a place, by index.
    pub(crate) fn within(&self, place: Vector, distance: f64) -> Vec<usize> {
        let (low, high) = (self.cell(place.map(|c| c - distance)), self.cell(place.map(|c| c + distance)));
        let mut found = Vec::new();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    found.extend(self.cells.get(&[x, y, z]).into_iter().flatten().copied());
                }
            }
        }
        found.retain(|&i| self.points[i].iter().zip(place).all(|(a, b)| (a - b).abs() <= distance));
        found.sort_unstable();
        found
    }
}

/// How far from the mirror image of a point its partner may stand, of the size of the structure.
pub(crate) const NEAR_IMAGE: f64 = 1e-4;

/// Some of a list of points, each next one the farthest from those chosen before it; in ascending order.
///
/// * `own` - indices of the points
pub fn spread(positions: &[Vector], own: &[usize], most: usize) -> Vec<usize> {
    if own.len() <= most {
        return own.to_vec();
    }
    let mut far = vec![f64::INFINITY; own.len()];
    let mut chosen = Vec::with_capacity(most);
    let mut next = 0;
    for _ in 0..most {
        chosen.push(own[next]);
        let place = positions[own[next]];
        for (far, &n) in far.iter_mut().zip(own) {
            let d = minus(positions[n], place);
            *far = far.min(dot(d, d));
        }
        next = (0..own.len()).max_by(|&a, &b| far[a].total_cmp(&far[b]).then(b.cmp(&a))).unwrap_or(0);
    }
    chosen.sort_unstable();
    chosen
}

/// Which of some points stands at the mirror image of each: the nearest within 1e-4 of the size; of several at one place, the first
/// has the first at the mirrored place, and so on. Points nearer than 1e-6 of the size are at one place.
///
/// * `mirrored` - the image of a point
pub fn images(points: &[Vector], mirrored: impl Fn(Vector) -> Option<Vector>) -> Vec<Option<usize>> {
    let size = extent(points);
    let (near, same) = (NEAR_IMAGE * size, 1e-6 * size);
    let grid = Near::new(points, near);
    let image = |i: usize| {
        let place = mirrored(points[i])?;
        let distance = |j: &usize| dot(minus(points[*j], place), minus(points[*j], place)).sqrt();
        let found = grid.within(place, near);
        let least = found.iter().map(distance).fold(f64::INFINITY, f64::min);
        let rank = grid.within(points[i], same).iter().position(|&j| j == i)?;
        found.into_iter().filter(|j| distance(j) <= least + same).nth(rank)
    };
    (0..points.len()).map(image).collect()
}

/// A vector of constants with a unit, or the problems of its entries.
pub(super) fn vector(v: &[Scalar; 3], unit: &str, path: &str, problems: &mut Vec<Problem>) -> Vector {
    let mut out = [0.0; 3];
    for (i, s) in v.iter().enumerate() {
        out[i] = constant(s, unit, &format!("{path}[{i}]"), problems);
    }
    out
}

/// A constant with a unit, or its problem (then zero).
pub(super) fn constant(s: &Scalar, unit: &str, path: &str, problems: &mut Vec<Problem>) -> f64 {
    s.constant_in(unit).unwrap_or_else(|e: ScalarError| {
        problems.push(Problem::error(path, e));
        0.0
    })
}

/// No structure is larger than the Earth; beyond it squares of lengths lose their digits.
const FARTHEST: f64 = 1e7;

/// Resolves all places; problems are reported together, and a node without a place stands at NaN.
///
/// * `known` - the parameters, which coordinates of nodes may name
pub(super) fn resolve(spec: &ModelSpec, known: &Known<'_>, problems: &mut Vec<Problem>) -> Geometry {
    let mut geometry = Geometry::default();
    if let Some(s) = &spec.symmetry {
        let at = s.at.as_ref().map_or(0.0, |at| constant(at, "m", "symmetry.at", problems));
        geometry.mirror = Some((s.normal as usize, at));
    }
    for (name, frame) in &spec.frames {
        if let Some(f) = resolve_frame(frame, &child("frames", name), problems) {
            geometry.frames.insert(name.clone(), f);
        }
    }
    let mut lines = BTreeMap::new();
    for (name, line) in &spec.lines {
        if let Some(l) = resolve_line(line, &child("lines", name), problems) {
            lines.insert(name.as_str(), l);
        }
    }
    let nominal = known.parameters.nominal();
    let places = nodes::places(spec, &lines, &geometry, known, problems);
    for ((name, node), place) in spec.nodes.iter().zip(places) {
        let position = place.as_ref().map_or([f64::NAN; 3], |p| at(p, &nominal));
        if let Some(far) = position.iter().find(|v| !v.is_nan() && v.abs() >= FARTHEST) {
            problems.push(Problem::error(
                child("nodes", name),
                format_args!(
                    "a coordinate of node `{name}` is {far:e} m; it must be within {FARTHEST:e} m: is its unit right?"
                ),
            ));
        }
        let position = position.map(|v| v.clamp(-FARTHEST, FARTHEST));
        let index = match node {
            NodeSpec::Rule(NodeRule { coordinate: Some(_), .. }) => geometry.add_coordinate(name.clone(), position),
            _ => geometry.add(name.clone(), position),
        };
        if let Some(place) = place.filter(|p| p.iter().any(|c| !c.terms.is_empty())) {
            geometry.moving.insert(index, place);
        }
    }
    geometry
}

/// The axes of the frames of a file that are sound.
pub(super) fn axes_of_frames(spec: &ModelSpec) -> BTreeMap<String, Rotation> {
    let resolved = |(name, frame): (&String, _)| Some((name.clone(), resolve_frame(frame, "", &mut Vec::new())?.axes));
    spec.frames.iter().filter_map(resolved).collect()
}

fn resolve_frame(frame: &FrameSpec, path: &str, problems: &mut Vec<Problem>) -> Option<Frame> {
    let origin = frame.origin.as_ref().map_or([0.0; 3], |o| vector(o, "m", &child(path, "origin"), problems));
    let axes = match (&frame.rotate, frame.x, frame.xy) {
        (None, None, None) => GLOBAL,
        (Some(rotate), None, None) => {
            let mut axes = GLOBAL;
            for (i, angle) in [&rotate.x, &rotate.y, &rotate.z].into_iter().enumerate() {
                if let Some(angle) = angle {
                    let a = constant(angle, "rad", &format!("{path}.rotate.{}", ["x", "y", "z"][i]), problems);
                    axes = axes.map(|v| turn(v, i, a));
                }
            }
            axes
        }
        (None, Some(x), Some(xy)) => {
            let axes = unit(x).and_then(|x| unit(cross(x, xy)).map(|z| [x, cross(z, x), z]));
            if axes.is_none() {
                problems.push(Problem::error(path, "`x` and `xy` must be two different directions"));
            }
            axes?
        }
        _ => {
            problems.push(Problem::error(path, "give either `rotate`, or `x` and `xy`"));
            return None;
        }
    };
    Some(Frame { origin, axes })
}

/// Turns a vector about a global axis by an angle, right-handed.
fn turn(v: Vector, axis: usize, angle: f64) -> Vector {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (sin, cos) = angle.sin_cos();
    let mut out = v;
    out[i] = cos * v[i] - sin * v[j];
    out[j] = sin * v[i] + cos * v[j];
    out
}

fn resolve_line(line: &LineSpec, path: &str, problems: &mut Vec<Problem>) -> Option<(Vector, Vector)> {
    let from = vector(&line.from, "m", &child(path, "from"), problems);
    let along = line.direction.vector();
    let direction = match (line.toward, &line.angle) {
        (None, None) => along,
        (Some(toward), Some(angle)) => {
            let toward = toward.vector();
            if dot(along, toward) != 0.0 {
                problems.push(Problem::error(child(path, "toward"), "it must be another axis than `direction`"));
                return None;
            }
            let (sin, cos) = constant(angle, "rad", &child(path, "angle"), problems).sin_cos();
            plus(along.map(|v| v * cos), sin, toward)
        }
        _ => {
            problems.push(Problem::error(path, "`toward` and `angle` belong together"));
            return None;
        }
    };
    Some((from, direction))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[Vector]) -> Vec<Option<usize>> {
        images(points, |[x, y, z]| Some([x, -y, z]))
    }

    /// Halves that differ by half of a ten thousandth of the size belong together, by twice of it they do not.
    #[test]
    fn images_are_found_within_a_ten_thousandth_of_the_size() {
        let wing = |off: f64| of(&[[0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [off, 1.0, 0.0]]);
        assert_eq!(wing(1e-4), [Some(2), Some(1), Some(0)]);
        assert_eq!(wing(4e-4), [None, Some(1), None]);
    }

    /// A mesh finer than that still has the nearest as its image, and nodes at one place their own order.
    #[test]
    fn the_nearest_of_several_is_the_image() {
        let n = 20_000;
        let fine: Vec<Vector> = (0..=n).map(|i| [0.0, f64::from(i - n / 2) / f64::from(n), 0.0]).collect();
        assert!(of(&fine).iter().enumerate().all(|(i, image)| *image == Some(n as usize - i)));
        let joints = [[0.0, -1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 1e-5], [0.0, 1.0, 1e-5]];
        assert_eq!(of(&joints), [Some(2), Some(3), Some(0), Some(1)]);
    }
}
