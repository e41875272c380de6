//! Places of nodes and axes of frames: from the rules of the file to global coordinates.

use super::spec::{FrameSpec, LineSpec, ModelSpec, NodeSpec, OneOrThree};
use crate::catalogue::did_you_mean;
use crate::units::{Scalar, ScalarError};
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashMap};

/// A vector in global axes, m.
pub(crate) type Vector = [f64; 3];

/// Rows are unit axes in global coordinates.
pub(crate) type Rotation = [[f64; 3]; 3];

/// Global axes.
pub(crate) const GLOBAL: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// a - b.
pub(crate) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a + s b.
pub(crate) fn plus(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// a · b.
pub(crate) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a scaled to unit length; `None` for a zero vector.
pub(crate) fn unit(a: Vector) -> Option<Vector> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|v| v / length))
}

/// x along `along`, z as near as possible to `near_z`, y completing the right-handed frame.
pub(crate) fn axes_along(along: Vector, near_z: Vector) -> Option<Rotation> {
    let x = unit(along)?;
    let near = unit(near_z)?;
    let y = cross(near, x);
    // Sine of the angle between them: below 1e-6 the direction of y is rounding noise.
    let y = (dot(y, y) > 1e-12).then(|| unit(y)).flatten()?;
    Some([x, y, cross(x, y)])
}

/// A frame of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin, global, m.
    pub origin: Vector,
    /// Axes.
    pub axes: Rotation,
}

impl Frame {
    /// Global coordinates of a position in the frame.
    pub fn to_global(&self, p: Vector) -> Vector {
        (0..3).fold(self.origin, |sum, i| plus(sum, p[i], self.axes[i]))
    }
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
}

impl Geometry {
    /// Index of a node.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }

    /// The mirror image of a point in the symmetry plane.
    pub fn mirrored(&self, p: Vector) -> Option<Vector> {
        let (axis, at) = self.mirror?;
        let mut image = p;
        image[axis] = 2.0 * at - p[axis];
        Some(image)
    }
}

/// Which of some points stands at the mirror image of each: of several at one place, the first has the first at the mirrored place,
/// and so on. Points nearer than 1e-6 of the largest coordinate are at one place.
///
/// * `mirrored` - the image of a point
pub(crate) fn images(points: &[Vector], mirrored: impl Fn(Vector) -> Option<Vector>) -> Vec<Option<usize>> {
    let near = 1e-6 * points.iter().flatten().map(|c| c.abs()).fold(0.0, f64::max);
    let width = if near > 0.0 { 8.0 * near } else { 1.0 };
    let cell = |p: Vector| p.map(|c| (c / width).floor() as i64);
    let mut in_cell: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    for (i, &p) in points.iter().enumerate() {
        in_cell.entry(cell(p)).or_default().push(i);
    }
    let at = |place: Vector| {
        let (low, high) = (cell(place.map(|c| c - near)), cell(place.map(|c| c + near)));
        let mut found = Vec::new();
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    found.extend(in_cell.get(&[x, y, z]).into_iter().flatten().copied());
                }
            }
        }
        found.retain(|&i| points[i].iter().zip(place).all(|(a, b)| (a - b).abs() <= near));
        found.sort_unstable();
        found
    };
    let image = |i: usize| {
        let rank = at(points[i]).iter().position(|&j| j == i)?;
        at(mirrored(points[i])?).get(rank).copied()
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
pub(super) fn resolve(spec: &ModelSpec, problems: &mut Vec<Problem>) -> Geometry {
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
    let resolver = Resolver { spec, lines, geometry: &geometry };
    let mut placed: BTreeMap<String, Option<Vector>> = BTreeMap::new();
    let mut positions = Vec::new();
    for name in spec.nodes.keys() {
        let mut visiting = Vec::new();
        let Some(position) = resolver.place(name, &mut placed, &mut visiting, problems) else {
            positions.push([f64::NAN; 3]);
            continue;
        };
        if let Some(far) = position.iter().find(|v| v.abs().partial_cmp(&FARTHEST) != Some(std::cmp::Ordering::Less)) {
            problems.push(Problem::error(
                child("nodes", name),
                format_args!(
                    "a coordinate of node `{name}` is {far:e} m; it must be within {FARTHEST:e} m: is its unit right?"
                ),
            ));
        }
        positions.push(position.map(|v| v.clamp(-FARTHEST, FARTHEST)));
    }
    geometry.names = spec.nodes.keys().cloned().collect();
    geometry.positions = positions;
    geometry
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

struct Resolver<'a> {
    spec: &'a ModelSpec,
    lines: BTreeMap<&'a str, (Vector, Vector)>,
    geometry: &'a Geometry,
}

impl Resolver<'_> {
    /// The place of a node, found once: a node without one is complained of once.
    fn place(
        &self,
        name: &str,
        placed: &mut BTreeMap<String, Option<Vector>>,
        visiting: &mut Vec<String>,
        problems: &mut Vec<Problem>,
    ) -> Option<Vector> {
        if let Some(p) = placed.get(name) {
            return *p;
        }
        let position = self.follow(name, placed, visiting, problems);
        placed.insert(name.to_string(), position);
        position
    }

    /// Follows the rule of a node.
    fn follow(
        &self,
        name: &str,
        placed: &mut BTreeMap<String, Option<Vector>>,
        visiting: &mut Vec<String>,
        problems: &mut Vec<Problem>,
    ) -> Option<Vector> {
        let path = child("nodes", name);
        let position = match self.spec.nodes.get(name)? {
            NodeSpec::At(position) => vector(position, "m", &path, problems),
            NodeSpec::Rule(rule) => {
                let rules = [
                    rule.line.is_some(),
                    rule.frame.is_some(),
                    rule.mirror.is_some(),
                    rule.from.is_some(),
                    rule.between.is_some(),
                ];
                if rules.iter().filter(|r| **r).count() != 1 {
                    problems.push(Problem::error(
                        &path,
                        "give exactly one of `line`, `frame`, `mirror`, `from`, `between`, or a position `[x, y, z]`",
                    ));
                    return None;
                }
                let uses_at = rule.line.is_some() || rule.frame.is_some();
                for (given, word, owner) in [
                    (rule.at.is_some() && !uses_at, "at", "`line` or `frame`"),
                    (rule.offset.is_some() && rule.from.is_none(), "offset", "`from`"),
                    (rule.fraction.is_some() && rule.between.is_none(), "fraction", "`between`"),
                ] {
                    if given {
                        problems.push(Problem::error(child(&path, word), format_args!("`{word}` goes with {owner}")));
                    }
                }
                if visiting.iter().any(|n| n == name) {
                    let chain = visiting.join("` -> `");
                    problems.push(Problem::error(
                        &path,
                        format_args!("its place depends on itself: `{chain}` -> `{name}`"),
                    ));
                    return None;
                }
                visiting.push(name.to_string());
                let mut other = |key: &str, other: &str, problems: &mut Vec<Problem>| {
                    if self.spec.nodes.contains_key(other) {
                        self.place(other, placed, visiting, problems)
                    } else {
                        problems.push(unknown(&child(&path, key), "node", other, self.spec.nodes.keys()));
                        None
                    }
                };
                match rule {
                    r if r.line.is_some() => {
                        let line = r.line.as_deref().unwrap_or_default();
                        let Some((from, direction)) = self.lines.get(line) else {
                            if !self.spec.lines.contains_key(line) {
                                problems.push(unknown(&child(&path, "line"), "line", line, self.spec.lines.keys()));
                            }
                            return None;
                        };
                        let Some(OneOrThree::One(at)) = &r.at else {
                            problems.push(Problem::error(&path, "a node on a line needs its distance, `at: 0.4 m`"));
                            return None;
                        };
                        plus(*from, constant(at, "m", &child(&path, "at"), problems), *direction)
                    }
                    r if r.frame.is_some() => {
                        let name = r.frame.as_deref().unwrap_or_default();
                        let Some(frame) = self.geometry.frames.get(name) else {
                            if !self.spec.frames.contains_key(name) {
                                problems.push(unknown(&child(&path, "frame"), "frame", name, self.spec.frames.keys()));
                            }
                            return None;
                        };
                        let Some(OneOrThree::Three(at)) = &r.at else {
                            problems
                                .push(Problem::error(&path, "a node in a frame needs its position, `at: [x, y, z]`"));
                            return None;
                        };
                        frame.to_global(vector(at, "m", &child(&path, "at"), problems))
                    }
                    r if r.mirror.is_some() => {
                        let p = other("mirror", r.mirror.as_deref().unwrap_or_default(), problems)?;
                        let Some(image) = self.geometry.mirrored(p) else {
                            problems.push(Problem::error(
                                child(&path, "mirror"),
                                "a mirrored node needs the plane: write `symmetry: {normal: y}` at the top of the file",
                            ));
                            return None;
                        };
                        image
                    }
                    r if r.from.is_some() => {
                        let p = other("from", r.from.as_deref().unwrap_or_default(), problems)?;
                        let Some(offset) = &r.offset else {
                            problems.push(Problem::error(&path, "a node beside another needs `offset: [x, y, z]`"));
                            return None;
                        };
                        plus(p, 1.0, vector(offset, "m", &child(&path, "offset"), problems))
                    }
                    r => {
                        let [first, second] = r.between.clone().unwrap_or_default();
                        let a = other("between[0]", &first, problems);
                        let b = other("between[1]", &second, problems);
                        let (a, b) = (a?, b?);
                        let f =
                            r.fraction.as_ref().map_or(0.5, |f| constant(f, "1", &child(&path, "fraction"), problems));
                        plus(a, f, minus(b, a))
                    }
                }
            }
        };
        Some(position)
    }
}

/// "node `n6a` is not defined; did you mean `n6`?"
pub(super) fn unknown<'a>(path: &str, what: &str, name: &str, known: impl IntoIterator<Item = &'a String>) -> Problem {
    let suggestion = did_you_mean(name, known.into_iter().map(String::as_str));
    Problem::error(path, format_args!("{what} `{name}` is not defined{suggestion}"))
}
