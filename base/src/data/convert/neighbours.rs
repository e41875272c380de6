//! What the geometry says about local axes: an axis of a node that was laid on a surface is its normal, one on a spar its tangent.
//!
//! ```text
//! a(R) = max_j |r_j · v|     v the normal of the neighbours of a node, or their direction where they stand in a line
//! ```
//!
//! r_j are the axes of a reading R (rows or columns of the matrix). A node votes for the reading with the larger a where that one fits
//! and the other does not. Votes are reported; they decide nothing, for a sensor may stand as it likes.

use super::frame::{Frame, LocalAxes, PlacedNode, Reading, Vector, Why, reading};
use super::units::note;
use crate::catalogue::Choice;
use crate::catalogue::counted;
use crate::data::uff::{Dataset, Level, Node, Note, PartSystem, UniversalFile};
use retune_linalg::vector3::{cross, dot, minus, unit};
use std::collections::{BTreeMap, BTreeSet};

/// Most nodes that are asked, and fewest in a large file.
const MOST_NODES: usize = 200;
const FEWEST_NODES: usize = 8;
/// Distances that are computed without anybody waiting for it.
const MOST_DISTANCES: usize = 20_000_000;
/// Neighbours of a node without lines.
const NEAREST: usize = 6;
/// Least alignment of an axis that lies along a normal or a tangent.
const ALIGNED: f64 = 0.97;
/// Least difference of two alignments that counts.
const DIFFERENT: f64 = 0.02;
/// Sine of the angle between two edges below which they are one line.
const STRAIGHT: f64 = 0.05;
/// Sine of the angle between two edges from which on they span a surface.
const SPREAD: f64 = 0.3;
/// Largest cosine of an edge against the normal of a surface.
const FLAT: f64 = 0.2;

/// Says how local axes of dataset 2420 were read, where it matters, and what the geometry says to it.
pub(super) fn weigh(
    files: &[&UniversalFile],
    option: Option<LocalAxes>,
    placed: &BTreeMap<i64, PlacedNode>,
    notes: &mut Vec<Note>,
) {
    let mut systems: BTreeMap<i64, (&PartSystem, Reading)> = BTreeMap::new();
    for file in files {
        let own = reading(file, option);
        for dataset in &file.datasets {
            if let Dataset::Part(part) = dataset {
                systems.extend(part.systems.iter().map(|s| (s.label, (s, own))));
            }
        }
    }
    let matters = |s: &PartSystem| {
        let both = [LocalAxes::Rows, LocalAxes::Columns].map(|r| Frame::of_matrix(s, r).map(|f| f.axes));
        both[0] != both[1]
    };
    let mut nodes: Vec<(i64, &PartSystem, Reading)> = Vec::new();
    for dataset in files.iter().flat_map(|f| &f.datasets) {
        let (Dataset::Nodes15(list) | Dataset::Nodes2411(list)) = dataset else { continue };
        let used =
            |n: &Node| systems.get(&n.displacement_cs).filter(|(s, _)| matters(s)).map(|(s, r)| (n.label, *s, *r));
        nodes.extend(list.iter().filter_map(used));
    }
    let Some((.., reading)) = nodes.first().copied() else { return };
    let lines = lines(files);
    // Each asked node may look at all others.
    let most = (MOST_DISTANCES / placed.len().max(1)).clamp(FEWEST_NODES, MOST_NODES);
    let step = nodes.len().div_ceil(most);
    let (mut taken, mut other) = (0, 0);
    for (label, system, reading) in nodes.iter().step_by(step) {
        let Some(at) = placed.get(label) else { continue };
        let Some(direction) = direction(*label, at.position, &lines, placed) else { continue };
        let fit = |axes: LocalAxes| {
            let frame = Frame::of_matrix(system, axes)?;
            Some(frame.axes_at(at.position).iter().map(|a| dot(*a, direction).abs()).fold(0.0, f64::max))
        };
        let (Some(own), Some(opposite)) = (fit(reading.axes), fit(reading.axes.other())) else { continue };
        if (own - opposite).abs() > DIFFERENT && own.max(opposite) > ALIGNED {
            *(if own > opposite { &mut taken } else { &mut other }) += 1;
        }
    }
    let (word, opposite) = (reading.axes.word(), reading.axes.other().word());
    let is_contradicted = other > taken;
    // A file that says what it means, and whose geometry does not object, needs no words.
    if !is_contradicted
        && (reading.why == Why::Option || (reading.why == Why::Program && reading.axes == LocalAxes::Rows))
    {
        return;
    }
    let why = match reading.why {
        Why::Option => "as the option says",
        Why::Program => "as the program of dataset 151 writes them",
        Why::Default => "as most programs write them",
    };
    let votes = taken + other;
    let evidence = if votes == 0 {
        "the positions of neighbours do not tell".to_owned()
    } else if is_contradicted {
        format!("the neighbours of {other} of {votes} nodes speak for {opposite}")
    } else {
        format!("the neighbours of {taken} of {votes} nodes agree")
    };
    let seen = format!("{} with local axes", counted(nodes.len(), "node"));
    let assumed = format!(
        "the {word} of their matrices were read as axes, {why}; {evidence}; `--local-axes {opposite}` reads the {opposite}"
    );
    notes.push(note(if is_contradicted { Level::Warning } else { Level::Info }, 2420, seen, assumed));
}

/// The neighbours of each node along trace lines and edges of elements.
fn lines(files: &[&UniversalFile]) -> BTreeMap<i64, BTreeSet<i64>> {
    let mut found: BTreeMap<i64, BTreeSet<i64>> = BTreeMap::new();
    let mut join = |path: &[i64]| {
        for pair in path.windows(2).filter(|p| p[0] != p[1] && p[0] != 0 && p[1] != 0) {
            found.entry(pair[0]).or_default().insert(pair[1]);
            found.entry(pair[1]).or_default().insert(pair[0]);
        }
    };
    for dataset in files.iter().flat_map(|f| &f.datasets) {
        match dataset {
            Dataset::TraceLine(line) => join(&line.nodes),
            Dataset::Elements(list) => {
                list.iter().flat_map(|e| edges(e.descriptor, &e.nodes)).for_each(|path| join(&path));
            }
            _ => {}
        }
    }
    found
}

/// The normal of the neighbours of a node where they lie in a plane with it, their direction where they lie in a line.
fn direction(
    label: i64,
    at: Vector,
    lines: &BTreeMap<i64, BTreeSet<i64>>,
    placed: &BTreeMap<i64, PlacedNode>,
) -> Option<Vector> {
    let along = |other: &i64| placed.get(other).and_then(|n| unit(minus(n.position, at)));
    let mut edges: Vec<Vector> = lines.get(&label).into_iter().flatten().filter_map(along).collect();
    if edges.is_empty() {
        let square = |p: Vector| dot(minus(p, at), minus(p, at));
        let mut near: Vec<(f64, Vector)> =
            placed.iter().filter(|(l, _)| **l != label).map(|(_, n)| (square(n.position), n.position)).collect();
        let nearest = NEAREST.min(near.len().saturating_sub(1));
        if !near.is_empty() {
            near.select_nth_unstable_by(nearest, |a, b| a.0.total_cmp(&b.0));
        }
        edges = near.iter().take(NEAREST).filter_map(|(_, p)| unit(minus(*p, at))).collect();
    }
    let pairs = edges.iter().enumerate().flat_map(|(i, a)| edges[..i].iter().map(move |b| cross(*a, *b)));
    let widest = pairs.max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)));
    let first = *edges.first()?;
    let sine = widest.map_or(0.0, |w| dot(w, w).sqrt());
    if sine < STRAIGHT {
        return Some(first);
    }
    let normal = widest.filter(|_| sine > SPREAD).and_then(unit)?;
    edges.iter().all(|e| dot(*e, normal).abs() < FLAT).then_some(normal)
}

/// The edges of an element as polylines; its corner nodes only, for the linear kinds.
pub(super) fn edges(descriptor: i64, nodes: &[i64]) -> Vec<Vec<i64>> {
    let paths: &[&[usize]] = match (descriptor, nodes.len()) {
        (111, 4) => &[&[0, 1, 2, 0, 3, 1], &[3, 2]],
        (112, 6) => &[&[0, 1, 2, 0, 3, 4, 5, 3], &[1, 4], &[2, 5]],
        (115, 8) => &[&[0, 1, 2, 3, 0, 4, 5, 6, 7, 4], &[1, 5], &[2, 6], &[3, 7]],
        (_, 2) => &[&[0, 1]],
        (_, 3) => &[&[0, 1, 2, 0]],
        (_, 4) => &[&[0, 1, 2, 3, 0]],
        _ => return vec![nodes.to_vec()],
    };
    paths.iter().map(|path| path.iter().map(|i| nodes[*i]).collect()).collect()
}
