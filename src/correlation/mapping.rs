//! Places in a model for the points of a test.
//!
//! ```text
//! node      |p - P_node| <= tolerance
//! element   P = P_1 + s (P_2 - P_1),  s = clamp((p - P_1)·(P_2 - P_1)/|P_2 - P_1|²),  rigid arm p - P
//! ```
//! Of all places the nearest counts; a point whose nearest place is an end of an element belongs to that node, with a rigid
//! arm. A point further than `reach` from everything is left over. So are nodes that no point is near to: the
//! test cannot see them.

use crate::data::{Place, Sensor, TestData};
use crate::element::Dof;
use crate::model::{Model, ParametricModel};

/// How far is near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MappingOptions {
    /// A point this near to a node sits on it, m.
    pub tolerance: f64,
    /// Longest rigid arm, m; a tenth of the diagonal of the model when absent.
    pub reach: Option<f64>,
}

impl Default for MappingOptions {
    /// 5 mm: the care with which accelerometers are placed by hand.
    fn default() -> Self {
        Self { tolerance: 5.0e-3, reach: None }
    }
}

/// What kind of place was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceKind {
    /// On a node within the tolerance.
    OnNode,
    /// By a rigid arm from a node.
    ArmFromNode,
    /// On an element within the tolerance.
    OnElement,
    /// By a rigid arm from an element.
    ArmFromElement,
}

impl PlaceKind {
    /// In words.
    pub fn word(self) -> &'static str {
        match self {
            PlaceKind::OnNode => "on node",
            PlaceKind::ArmFromNode => "arm from node",
            PlaceKind::OnElement => "on element",
            PlaceKind::ArmFromElement => "arm from element",
        }
    }
}

/// A point with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct MappedPoint {
    /// Its name.
    pub name: String,
    /// Its position, m.
    pub position: [f64; 3],
    /// Its place in the model, with the position of the point.
    pub place: Place,
    /// What kind of place.
    pub kind: PlaceKind,
    /// Length of the arm, m.
    pub distance: f64,
}

/// Something without partner, and its distance to the nearest of the other side.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Its name.
    pub name: String,
    /// Name of the nearest node or element (of a point), of the nearest point (of a node).
    pub nearest: Option<String>,
    /// How far that is, m.
    pub distance: f64,
}

/// Proposed places.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping {
    /// Points with places, in their order.
    pub points: Vec<MappedPoint>,
    /// Points without.
    pub points_left: Vec<Leftover>,
    /// Nodes that no point sits on or near to, in file order.
    pub nodes_left: Vec<Leftover>,
    /// Longest arm that was allowed, m.
    pub reach: f64,
}

/// Proposes the nearest place in a model for each point.
///
/// * `points` - name and position in the model's global axes, m
pub fn map_points(model: &Model, points: &[(String, [f64; 3])], options: MappingOptions) -> Mapping {
    let geometry = model.geometry();
    let reach = options.reach.unwrap_or_else(|| 0.1 * diagonal(&geometry.positions));
    let segments = segments(model);
    let (dofs, n) = (model.dof_map(), geometry.positions.len());
    let moves: Vec<bool> = (0..n).map(|i| Dof::ALL.iter().any(|d| !dofs.express(i, *d).is_empty())).collect();
    let mut mapping = Mapping { points: Vec::new(), points_left: Vec::new(), nodes_left: Vec::new(), reach };
    for (name, position) in points {
        let to = |i: usize| distance(*position, geometry.positions[i]);
        let node = nearest((0..n).map(to));
        // What cannot move is the place of a point that sits there, and of no other.
        let node = match node {
            Some((k, d)) if d > options.tolerance && !moves[k] => {
                nearest((0..n).map(|i| if moves[i] { to(i) } else { f64::INFINITY }))
            }
            node => node,
        };
        let on_element = nearest(segments.iter().map(|s| {
            let (at, distance) = s.foot(*position);
            let end = s.end(at).is_some_and(|k| !moves[k]);
            if end && distance > options.tolerance { f64::INFINITY } else { distance }
        }));
        let Some((node, to_node)) = node else {
            mapping.points_left.push(Leftover { name: name.clone(), nearest: None, distance: f64::INFINITY });
            continue;
        };
        // The end of an element is a node: an element wins only where its inside is nearer.
        let inside = on_element.filter(|(_, d)| to_node > options.tolerance && *d < to_node - 1e-9);
        let (place, kind, distance, near) = match inside {
            Some((k, distance)) => {
                let segment = &segments[k];
                let fraction = segment.fraction(segment.foot(*position).0);
                let place = Place::Element { element: segment.name.clone(), fraction, position: Some(*position) };
                let is_on = distance <= options.tolerance;
                let kind = if is_on { PlaceKind::OnElement } else { PlaceKind::ArmFromElement };
                (place, kind, distance, segment.name.clone())
            }
            None => {
                let name = geometry.names[node].clone();
                // Rounding of a file's coordinates is not an arm.
                let position = (to_node > 1e-9).then_some(*position);
                let kind = if to_node <= options.tolerance { PlaceKind::OnNode } else { PlaceKind::ArmFromNode };
                (Place::Node { node: name.clone(), position }, kind, to_node, name)
            }
        };
        if distance > reach.max(options.tolerance) {
            mapping.points_left.push(Leftover { name: name.clone(), nearest: Some(near), distance });
        } else {
            mapping.points.push(MappedPoint { name: name.clone(), position: *position, place, kind, distance });
        }
    }
    for (name, position) in geometry.names.iter().zip(&geometry.positions) {
        let near = nearest(points.iter().map(|(_, p)| distance(*p, *position)));
        let is_used = mapping.points.iter().any(|p| matches!(&p.place, Place::Node { node, .. } if node == name));
        if !is_used && near.is_none_or(|(_, d)| d > options.tolerance) {
            mapping.nodes_left.push(Leftover {
                name: name.clone(),
                nearest: near.map(|(k, _)| points[k].0.clone()),
                distance: near.map_or(f64::INFINITY, |(_, d)| d),
            });
        }
    }
    mapping
}

/// The test with its sensors at the proposed places; sensors without a position stay where they are.
///
/// Returns the names of the sensors that were left out, with their rows of every shape, because they have no place.
pub fn place_sensors(test: &mut TestData, mapping: &Mapping) -> Vec<String> {
    let is_left = |s: &Sensor| mapping.points_left.iter().any(|p| p.name == s.name);
    let keep: Vec<usize> = (0..test.sensors.len()).filter(|&i| !is_left(&test.sensors[i])).collect();
    let gone = test.sensors.iter().filter(|s| is_left(s)).map(|s| s.name.clone()).collect();
    test.sensors = keep.iter().map(|&i| test.sensors[i].clone()).collect();
    for mode in &mut test.modes {
        let kept = |k: usize| keep.iter().position(|i| *i == k);
        mode.components = mode.components.iter().filter_map(|c| c.renumbered(kept)).collect();
        mode.shape = mode.shape.as_ref().map(|s| s.select_rows(&keep));
        mode.shape_sd = mode.shape_sd.as_ref().map(|s| s.select_rows(&keep));
    }
    for sensor in &mut test.sensors {
        if let Some(found) = mapping.points.iter().find(|p| p.name == sensor.name) {
            sensor.place = found.place.clone();
            sensor.offset = None;
        }
    }
    gone
}

/// An element between two nodes, or a part of one.
struct Segment {
    name: String,
    ends: [[f64; 3]; 2],
    /// The nodes there.
    nodes: [usize; 2],
    /// Which part of how many.
    part: (usize, usize),
}

impl Segment {
    /// Where on the segment a point projects to, 0 to 1, and how far it is from there.
    fn foot(&self, p: [f64; 3]) -> (f64, f64) {
        let [a, b] = self.ends;
        let along: [f64; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let length = along.iter().map(|v| v * v).sum::<f64>();
        let dot: f64 = (0..3).map(|i| (p[i] - a[i]) * along[i]).sum();
        let s = if length > 0.0 { (dot / length).clamp(0.0, 1.0) } else { 0.0 };
        (s, distance(p, std::array::from_fn(|i| a[i] + s * along[i])))
    }

    /// The node where a point of the segment is one of its ends.
    fn end(&self, s: f64) -> Option<usize> {
        if s <= 0.0 {
            Some(self.nodes[0])
        } else if s >= 1.0 {
            Some(self.nodes[1])
        } else {
            None
        }
    }

    fn fraction(&self, s: f64) -> f64 {
        (self.part.0 as f64 + s) / self.part.1 as f64
    }
}

/// The elements on which a point can sit.
fn segments(model: &Model) -> Vec<Segment> {
    let geometry = model.geometry();
    let mut out = Vec::new();
    for (index, element) in model.elements().iter().enumerate() {
        let [a, b] = element.nodes[..] else { continue };
        // `wing.2/0.5..0.75` is a part of `wing.2`, which is the name for people.
        let whole = element.name.rsplit_once('/').map_or(element.name.as_str(), |(name, _)| name);
        let Some(parts) = model.element_set(whole) else { continue };
        let Some(part) = parts.iter().position(|&k| k == index) else { continue };
        if !matches!(model.point(whole, 0.5), Ok(Some(_))) {
            continue;
        }
        let ends = [geometry.positions[a], geometry.positions[b]];
        out.push(Segment { name: whole.to_string(), ends, nodes: [a, b], part: (part, parts.len()) });
    }
    out
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

fn nearest(distances: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    distances.enumerate().filter(|d| d.1.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
}

fn diagonal(points: &[[f64; 3]]) -> f64 {
    let size = |i: usize| {
        let (low, high) =
            points.iter().fold((f64::MAX, f64::MIN), |(low, high): (f64, f64), p| (low.min(p[i]), high.max(p[i])));
        if low <= high { high - low } else { 0.0 }
    };
    (0..3).map(|i| size(i).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Registry, load};

    const TEXT: &str = "
retune: 1
name: beam
nodes: {a: [0, 0, 0], b: [1, 0, 0], c: [2, 0, 0]}
sections: {s: {E: 1 GPa, G: 0.4 GPa, mass_per_length: 0.1 kg/m, shape: {rectangle: {width: 1 cm, height: 1 cm}}}}
beams:
  span: {chain: [a, b, c], section: s, subdivide: 2}
supports: {left: {node: a}}
";

    fn mapped(points: &[(&str, [f64; 3])]) -> Mapping {
        let (model, _, _) = load(TEXT, &Registry::builtin()).unwrap();
        let points: Vec<(String, [f64; 3])> = points.iter().map(|(n, p)| ((*n).to_string(), *p)).collect();
        map_points(&model, &points, MappingOptions::default())
    }

    #[test]
    fn nodes_before_elements_and_leftovers_both_ways() {
        let m = mapped(&[
            ("on", [1.004, 0.0, 0.0]),
            ("inside", [1.7, 0.0, 0.0]),
            ("arm", [1.7, 0.1, 0.0]),
            ("beyond", [2.1, 0.0, 0.0]),
            ("far", [1.0, 3.0, 0.0]),
        ]);
        let kinds: Vec<PlaceKind> = m.points.iter().map(|p| p.kind).collect();
        use PlaceKind::{ArmFromElement, ArmFromNode, OnElement, OnNode};
        assert_eq!(kinds, [OnNode, OnElement, ArmFromElement, ArmFromNode]);
        let Place::Element { element, fraction, position } = &m.points[2].place else { panic!() };
        assert_eq!((element.as_str(), *position), ("span.2", Some([1.7, 0.1, 0.0])));
        assert!((fraction - 0.7).abs() < 1e-12 && (m.points[2].distance - 0.1).abs() < 1e-12);
        assert_eq!(m.points_left.iter().map(|p| p.name.as_str()).collect::<Vec<_>>(), ["far"]);
        assert!(m.nodes_left.iter().any(|n| n.name == "a"));
        assert!(!m.nodes_left.iter().any(|n| n.name == "c"));
    }

    /// A point beside the clamped node reads the nearest place that moves, and the node only where it sits on it.
    #[test]
    fn what_cannot_move_is_the_place_of_what_sits_on_it_alone() {
        let m = mapped(&[("on", [0.0, 0.0, 0.0]), ("beside", [-0.02, 0.0, 0.0]), ("above", [0.01, 0.05, 0.0])]);
        let place = |k: usize| m.points[k].place.clone();
        assert_eq!(place(0), Place::Node { node: "a".into(), position: None });
        let Place::Element { element, .. } = place(1) else { panic!("{:?}", m.points_left) };
        assert_eq!((m.points.len(), element.as_str()), (2, "span.1"));
        assert_eq!(m.points_left.len(), 1);
    }
}
