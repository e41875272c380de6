//! Where a mesh ends: free edges of shells, boundaries that lie on each other without being joined, holes, elements that stand twice.

use super::mesh::{corners, edges, is_of_mesh, is_surface};
use crate::catalogue::counted;
use crate::model::compile::Model;
use crate::model::geometry::{Near, Vector, dot, minus};
use crate::model::placed_element::PlacedElement;
use crate::yaml::Problem;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A hole of so few edges, one of each element around it, is as large as an element.
const SMALL_HOLE: usize = 4;
/// Elements of a part below which every hole is as large as it.
const FEW_ELEMENTS: usize = 16;
/// How far from a free edge a node may stand that is meant to be on it, of the edge's length.
const ON_EDGE: f64 = 1e-3;

/// Free edges of the shells of a part: those of one shell only.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeEdges {
    /// The part of the mesh.
    pub part: String,
    /// Number of them.
    pub n_edges: usize,
    /// Lines that they make; one is the rim of a sheet, none are of a closed skin.
    pub n_lines: usize,
    /// Their length together, m.
    pub length: f64,
    /// How many of them a tie holds by both nodes.
    pub n_tied: usize,
}

/// What was found.
pub(super) struct Boundary {
    pub(super) free: Vec<FreeEdges>,
    pub(super) problems: Vec<Problem>,
    /// Nodes at one place that the problems speak of.
    pub(super) told: BTreeSet<usize>,
}

/// An edge of one shell only.
struct Free {
    nodes: [usize; 2],
    element: usize,
    part: usize,
}

/// The boundaries of the parts of a mesh; nothing where there is none.
///
/// * `unjoined` - pairs of nodes that stand at one place and are not joined
pub(super) fn boundary(model: &Model, unjoined: &[[usize; 2]]) -> Boundary {
    let mut out = Boundary { free: Vec::new(), problems: Vec::new(), told: BTreeSet::new() };
    let parts: Vec<&String> = model.mesh_parts().iter().collect();
    if parts.is_empty() {
        return out;
    }
    let free = free_edges(model, &parts);
    let tied: BTreeSet<usize> =
        model.spec().ties.values().flat_map(|t| &t.nodes).filter_map(|n| model.geometry().node(n)).collect();
    for (k, part) in parts.iter().enumerate() {
        let own: Vec<&Free> = free.iter().filter(|f| f.part == k).collect();
        let elements = model.element_set(part).unwrap_or_default();
        if elements.iter().any(|&e| is_surface(&model.elements()[e])) {
            out.free.push(counted_edges(model, part, &own, &tied));
            out.problems.extend(holes(model, part, &own, elements.len()));
        }
        out.problems.extend(doubled(model, part, elements));
    }
    let representative: HashMap<usize, usize> = unjoined.iter().map(|[first, second]| (*second, *first)).collect();
    seams(model, &parts, &free, &representative, &mut out);
    interfaces(model, &parts, &representative, &mut out);
    out.problems.extend(beside(model, &parts, &free, &tied));
    out
}

fn free_edges(model: &Model, parts: &[&String]) -> Vec<Free> {
    let mut part_of: HashMap<usize, usize> = HashMap::new();
    for (k, part) in parts.iter().enumerate() {
        part_of.extend(model.element_set(part).unwrap_or_default().iter().map(|&e| (e, k)));
    }
    let mut of: BTreeMap<[usize; 2], (usize, usize)> = BTreeMap::new();
    for (i, e) in model.elements().iter().enumerate().filter(|(_, e)| is_surface(e)) {
        for [a, b] in edges(e.nodes.len()) {
            let (a, b) = (e.nodes[*a], e.nodes[*b]);
            of.entry([a.min(b), a.max(b)]).or_insert((i, 0)).1 += 1;
        }
    }
    let of_one = of.into_iter().filter(|(_, (_, count))| *count == 1);
    of_one.filter_map(|(nodes, (element, _))| Some(Free { nodes, element, part: *part_of.get(&element)? })).collect()
}

fn length(model: &Model, [a, b]: [usize; 2]) -> f64 {
    let d = minus(model.geometry().positions[a], model.geometry().positions[b]);
    dot(d, d).sqrt()
}

/// Edges that hang together by their nodes.
fn lines<'a>(own: &[&'a Free]) -> Vec<Vec<&'a Free>> {
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (i, f) in own.iter().enumerate() {
        f.nodes.iter().for_each(|&n| at.entry(n).or_default().push(i));
    }
    let mut seen = vec![false; own.len()];
    let mut all = Vec::new();
    for start in 0..own.len() {
        let (mut open, mut line) = (vec![start], Vec::new());
        while let Some(i) = open.pop() {
            if !std::mem::replace(&mut seen[i], true) {
                line.push(own[i]);
                open.extend(own[i].nodes.iter().flat_map(|n| &at[n]).copied());
            }
        }
        if !line.is_empty() {
            all.push(line);
        }
    }
    all
}

fn counted_edges(model: &Model, part: &str, own: &[&Free], tied: &BTreeSet<usize>) -> FreeEdges {
    FreeEdges {
        part: part.to_string(),
        n_edges: own.len(),
        n_lines: lines(own).len(),
        length: own.iter().map(|f| length(model, f.nodes)).sum(),
        n_tied: own.iter().filter(|f| f.nodes.iter().all(|n| tied.contains(n))).count(),
    }
}

/// Closed lines of a few free edges within a part: an element is missing there.
fn holes(model: &Model, part: &str, own: &[&Free], n_elements: usize) -> Option<Problem> {
    if n_elements < FEW_ELEMENTS {
        return None;
    }
    let is_hole = |line: &Vec<&Free>| {
        let mut nodes: Vec<usize> = line.iter().flat_map(|f| f.nodes).collect();
        nodes.sort_unstable();
        let closed = nodes.chunks(2).all(|pair| pair.len() == 2 && pair[0] == pair[1]);
        let around: BTreeSet<usize> = line.iter().map(|f| f.element).collect();
        (3..=SMALL_HOLE).contains(&line.len()) && closed && around.len() == line.len()
    };
    let holes: Vec<Vec<&Free>> = lines(own).into_iter().filter(is_hole).collect();
    let first = holes.first()?.first()?;
    let names = &model.geometry().names;
    Some(Problem::warning(
        model.path_of_part(part),
        format_args!(
            "it has {} no larger than an element, between `{}` and `{}` first: is an element missing from its set?",
            counted(holes.len(), "hole"),
            names[first.nodes[0]],
            names[first.nodes[1]]
        ),
    ))
}

/// Elements that stand on the same nodes as another of their part.
fn doubled(model: &Model, part: &str, elements: &[usize]) -> Option<Problem> {
    let mut on: HashMap<Vec<usize>, usize> = HashMap::new();
    let mut twice = Vec::new();
    for &e in elements {
        let mut nodes = model.elements()[e].nodes.clone();
        nodes.sort_unstable();
        if let Some(&first) = on.get(&nodes) {
            twice.push([first, e]);
        } else {
            on.insert(nodes, e);
        }
    }
    let [first, second] = twice.first()?.map(|e| &model.elements()[e].name);
    let stand = if twice.len() == 1 { "stands" } else { "stand" };
    Some(Problem::warning(
        model.path_of_part(part),
        format_args!(
            "{} of it {stand} on the nodes of another one, `{second}` on those of `{first}` first: what stands there counts twice",
            counted(twice.len(), "element")
        ),
    ))
}

/// What lies on each other, pair of parts by pair of parts: how many, and the first two elements.
type Coincident = BTreeMap<[usize; 2], (usize, [usize; 2])>;

fn add(found: &mut Coincident, [a, b]: [(usize, usize); 2]) {
    let [first, second] = if a.0 <= b.0 { [a, b] } else { [b, a] };
    found.entry([first.0, second.0]).or_insert((0, [first.1, second.1])).0 += 1;
}

fn tell(model: &Model, parts: &[&String], found: &Coincident, what: &str, out: &mut Boundary) {
    for ([first, second], (count, [e, f])) in found {
        let (e, f) = (&model.elements()[*e].name, &model.elements()[*f].name);
        let other = if first == second { "others of it".into() } else { format!("those of `{}`", parts[*second]) };
        let lie = if *count == 1 { "lies" } else { "lie" };
        out.problems.push(Problem::warning(
            model.path_of_part(parts[*first]),
            format_args!(
                "{} {lie} on {other}, of `{e}` and `{f}` first, and their nodes are not joined: merge the nodes in the mesher, or tie one side to the other by `ties`",
                counted(*count, what)
            ),
        ));
    }
}

/// Free edges that lie on each other with nodes of their own.
fn seams(model: &Model, parts: &[&String], free: &[Free], representative: &HashMap<usize, usize>, out: &mut Boundary) {
    let mut at: BTreeMap<[usize; 2], Vec<&Free>> = BTreeMap::new();
    for f in free {
        let [a, b] = f.nodes.map(|n| representative.get(&n).copied().unwrap_or(n));
        at.entry([a.min(b), a.max(b)]).or_default().push(f);
    }
    let mut found = Coincident::new();
    for here in at.values().filter(|here| here.len() > 1) {
        add(&mut found, [(here[0].part, here[0].element), (here[1].part, here[1].element)]);
        out.told.extend(here.iter().flat_map(|f| f.nodes));
    }
    tell(model, parts, &found, "free edge", out);
}

/// Faces of solids by their corners.
fn faces(e: &PlacedElement) -> &'static [&'static [usize]] {
    match corners(e).0 {
        4 => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        5 => &[&[0, 1, 2, 3], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]],
        6 => &[&[0, 1, 2], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]],
        _ => &[&[0, 1, 2, 3], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]],
    }
}

/// A face of a solid.
struct Face {
    part: usize,
    element: usize,
    nodes: Vec<usize>,
}

/// Faces of solids that lie on each other with nodes of their own.
fn interfaces(model: &Model, parts: &[&String], representative: &HashMap<usize, usize>, out: &mut Boundary) {
    if representative.is_empty() {
        return;
    }
    let of_seam: BTreeSet<usize> = representative.iter().flat_map(|(a, b)| [*a, *b]).collect();
    let mut at: BTreeMap<Vec<usize>, Vec<Face>> = BTreeMap::new();
    for (k, part) in parts.iter().enumerate() {
        for &i in model.element_set(part).unwrap_or_default() {
            let e = &model.elements()[i];
            if e.nodes.len() < 4 || is_surface(e) {
                continue;
            }
            for face in faces(e) {
                let own: Vec<usize> = face.iter().map(|&n| e.nodes[n]).collect();
                if own.iter().any(|n| !of_seam.contains(n)) {
                    continue;
                }
                let mut place: Vec<usize> = own.iter().map(|n| representative.get(n).copied().unwrap_or(*n)).collect();
                place.sort_unstable();
                at.entry(place).or_default().push(Face { part: k, element: i, nodes: own });
            }
        }
    }
    let mut found = Coincident::new();
    for here in at.values().filter(|here| here.len() > 1) {
        add(&mut found, [(here[0].part, here[0].element), (here[1].part, here[1].element)]);
        out.told.extend(here.iter().flat_map(|f| &f.nodes));
    }
    tell(model, parts, &found, "free face", out);
}

/// Nodes of free edges that stand on another free edge, between its nodes, and are not joined to it.
fn beside(model: &Model, parts: &[&String], free: &[Free], tied: &BTreeSet<usize>) -> Vec<Problem> {
    let mut part_of: BTreeMap<usize, usize> = BTreeMap::new();
    for f in free {
        for n in f.nodes {
            part_of.entry(n).or_insert(f.part);
        }
    }
    let is_loose = |n: usize| !tied.contains(&n) && is_of_mesh(model, n);
    let nodes: Vec<usize> = part_of.keys().copied().filter(|&n| is_loose(n)).collect();
    let positions: Vec<Vector> = nodes.iter().map(|&n| model.geometry().positions[n]).collect();
    let longest = free.iter().map(|f| length(model, f.nodes)).fold(0.0, f64::max);
    let grid = Near::new(&positions, 0.125 * longest);
    let mut found: BTreeMap<[usize; 2], BTreeSet<usize>> = BTreeMap::new();
    for f in free.iter().filter(|f| f.nodes.iter().all(|n| !tied.contains(n))) {
        let [a, b] = f.nodes.map(|n| model.geometry().positions[n]);
        let along = minus(b, a);
        let squared = dot(along, along);
        let middle: Vector = std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
        for k in grid.within(middle, 0.5 * squared.sqrt()) {
            if f.nodes.contains(&nodes[k]) {
                continue;
            }
            let from = minus(positions[k], a);
            let share = dot(from, along) / squared;
            let off = minus(from, along.map(|v| share * v));
            // A node at an end is one at the place of another.
            if (0.01..=0.99).contains(&share) && dot(off, off) <= ON_EDGE * ON_EDGE * squared {
                found.entry([part_of[&nodes[k]], f.part]).or_default().insert(nodes[k]);
            }
        }
    }
    let tell = |([first, second], standing): (&[usize; 2], &BTreeSet<usize>)| {
        let name = standing.first().map_or("", |&n| &model.geometry().names[n]);
        let stand = if standing.len() == 1 { "stands" } else { "stand" };
        Problem::warning(
            model.path_of_part(parts[*first]),
            format_args!(
                "{} of its free edges, `{name}` first, {stand} on free edges of `{}` between the nodes of these, and nothing joins them: mesh both sides alike, or tie these nodes by `ties`",
                counted(standing.len(), "node"),
                parts[*second]
            ),
        )
    };
    found.iter().map(tell).collect()
}
