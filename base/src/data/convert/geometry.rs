//! Nodes, coordinate systems, trace lines and elements to geometry, and back.

use super::ConvertError;
use super::frame::{Frame, LocalAxes, PlacedNode, frames};
use super::neighbours::{edges, weigh};
use super::units::{UnitsFrom, note, plain_system, units_at};
use crate::catalogue::counted;
use crate::data::uff::{Dataset, Header, Level, Node, Note, Part, PartSystem, TraceLine, Units, UniversalFile};
use crate::data::{Geometry, Line, Point};
use std::collections::BTreeMap;

/// The nodes of files by label; the last of several with one label counts. A system that no dataset defines is the global one:
/// programs number it 1 and do not write it.
pub(super) fn placed_nodes(
    files: &[&UniversalFile],
    local_axes: Option<LocalAxes>,
    notes: &mut Vec<Note>,
) -> BTreeMap<i64, PlacedNode> {
    let frames = frames(files, local_axes);
    let mut placed = BTreeMap::new();
    let (mut repeated, mut lost_axes, mut lost_places, mut exported) = (0, 0, 0, 0);
    for dataset in files.iter().flat_map(|f| &f.datasets) {
        let (nodes, is_local) = match dataset {
            Dataset::Nodes15(nodes) => (nodes, true),
            Dataset::Nodes2411(nodes) => (nodes, false),
            _ => continue,
        };
        for node in nodes {
            // Dataset 15 gives coordinates in the definition system, dataset 2411 in that of the part.
            let frame = if is_local { frames.get(&node.definition_cs) } else { Some(&Frame::GLOBAL) };
            lost_places += usize::from(frame.is_none());
            let is_moved = |f: &Frame| *f != Frame::GLOBAL;
            exported += usize::from(!is_local && frames.get(&node.definition_cs).is_some_and(is_moved));
            let position = frame.unwrap_or(&Frame::GLOBAL).position(node.position);
            let own = frames.get(&node.displacement_cs);
            lost_axes += usize::from(own.is_none());
            let axes = own.unwrap_or(&Frame::GLOBAL).axes_at(position);
            repeated += usize::from(placed.insert(node.label, PlacedNode { position, axes }).is_some());
        }
    }
    for (count, seen, assumed) in [
        (repeated, "nodes whose label was there before", "the last one counts"),
        (lost_places, "nodes in a definition system that is not in the file", "their coordinates count as global"),
        (
            exported,
            "nodes of dataset 2411 with an export system of their own",
            "their coordinates are those of the part",
        ),
        (
            lost_axes,
            "nodes with a displacement system that no dataset defines (18, 2420)",
            "it counts as the global one",
        ),
    ] {
        if count > 0 {
            notes.push(note(Level::Warning, 2411, format!("{count} {seen}"), assumed));
        }
    }
    weigh(files, local_axes, &placed, notes);
    placed
}

/// Reads the geometry of universal files.
///
/// * `files` - files that share labels of nodes
/// * `units` - where the unit of length comes from
/// * `local_axes` - how matrices of local axes are read; by the program that wrote them when absent
///
/// Points are sorted by label. Trace lines become lines, cut where the pen is lifted; elements become lines along their
/// edges.
///
/// # Errors
/// [`ConvertError::Nothing`] without nodes, [`ConvertError::Questions`] without unit.
pub fn geometry(
    files: &[&UniversalFile],
    units: &UnitsFrom,
    local_axes: Option<LocalAxes>,
) -> Result<(Geometry, Vec<Note>), ConvertError> {
    let mut notes = Vec::new();
    let placed = placed_nodes(files, local_axes, &mut notes);
    if placed.is_empty() {
        return Err(ConvertError::Nothing { what: "nodes (datasets 15, 2411)", found: found(files) });
    }
    let has_nodes = |d: &Dataset| matches!(d, Dataset::Nodes15(_) | Dataset::Nodes2411(_));
    let stated = files.iter().find_map(|f| units_at(f, f.datasets.iter().position(has_nodes)?));
    let system = plain_system(stated, units, "the positions of nodes").map_err(|q| ConvertError::Questions(vec![q]))?;
    let index: BTreeMap<i64, usize> = placed.keys().enumerate().map(|(i, label)| (*label, i)).collect();
    let points = placed
        .iter()
        .map(|(label, node)| Point {
            name: label.to_string(),
            position_m: node.position.map(|x| x * system.length),
            axes: node.axes,
        })
        .collect();
    let mut lines = Vec::new();
    let mut unknown = 0;
    let mut push = |name: &str, labels: &[i64], lines: &mut Vec<Line>| {
        let points: Vec<usize> = labels.iter().filter_map(|l| index.get(l).copied()).collect();
        unknown += labels.len() - points.len();
        if points.len() > 1 {
            lines.push(Line { name: name.to_owned(), points });
        }
    };
    for dataset in files.iter().flat_map(|f| &f.datasets) {
        match dataset {
            Dataset::TraceLine(line) => {
                line.nodes.split(|n| *n == 0).for_each(|piece| push(&line.name, piece, &mut lines));
            }
            Dataset::Elements(elements) => {
                for e in elements {
                    for edge in edges(e.descriptor, &e.nodes) {
                        push(&format!("element {}", e.label), &edge, &mut lines);
                    }
                }
            }
            _ => {}
        }
    }
    if unknown > 0 {
        let seen = format!("{} of lines and elements not defined", counted(unknown, "node"));
        notes.push(note(Level::Warning, 82, seen, "the lines go on without them"));
    }
    Ok((Geometry { points, lines }, notes))
}

/// What datasets there are, for messages.
pub(super) fn found(files: &[&UniversalFile]) -> String {
    let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
    for dataset in files.iter().flat_map(|f| &f.datasets) {
        *counts.entry(dataset.number()).or_default() += 1;
    }
    let list: Vec<String> = counts.iter().map(|(number, count)| format!("{count} of dataset {number}")).collect();
    if list.is_empty() { "no datasets".to_owned() } else { list.join(", ") }
}

/// Dataset 164 for SI.
pub(super) fn si() -> Dataset {
    Dataset::Units(Units {
        code: 1,
        description: "SI".to_owned(),
        temperature_mode: 2,
        length: 1.0,
        force: 1.0,
        temperature: 1.0,
        temperature_offset: 273.15,
    })
}

/// Labels for names: the number a name is, else the smallest free one.
pub(super) fn labels<'a>(names: impl Iterator<Item = &'a str> + Clone) -> BTreeMap<&'a str, i64> {
    const LARGEST: i64 = 9_999_999_999;
    let number = |name: &str| name.parse::<i64>().ok().filter(|n| (1..=LARGEST).contains(n) && n.to_string() == name);
    let mut labels: BTreeMap<&str, i64> = names.clone().filter_map(|n| Some((n, number(n)?))).collect();
    let taken: std::collections::BTreeSet<i64> = labels.values().copied().collect();
    let mut free = (1..).filter(|n| !taken.contains(n));
    for name in names {
        if !labels.contains_key(name)
            && let Some(label) = free.next()
        {
            labels.insert(name, label);
        }
    }
    labels
}

/// Writes geometry as datasets 164, 151, 2420, 2411 and 82, in SI.
///
/// A name that is a number is the label of its node; others get free labels, in the order of the points.
pub fn geometry_file(geometry: &Geometry) -> UniversalFile {
    let labels = labels(geometry.points.iter().map(|p| p.name.as_str()));
    let mut systems: Vec<PartSystem> = Vec::new();
    let mut nodes = Vec::new();
    for point in &geometry.points {
        let displacement_cs = if point.axes == Point::GLOBAL {
            0
        } else {
            let known = systems.iter().find(|s| s.rows[..3] == point.axes).map(|s| s.label);
            known.unwrap_or_else(|| {
                let label = systems.len() as i64 + 1;
                let [x, y, z] = point.axes;
                let rows = [x, y, z, [0.0; 3]];
                systems.push(PartSystem { label, kind: 0, color: 8, name: format!("CS{label}"), rows });
                label
            })
        };
        nodes.push(Node {
            label: labels[point.name.as_str()],
            definition_cs: 0,
            displacement_cs,
            color: 8,
            position: point.position_m,
        });
    }
    let mut datasets = vec![si()];
    if !systems.is_empty() {
        // Who wrote the file says that rows are axes.
        datasets.push(Dataset::Header(Header { program: "retune".to_owned(), ..Header::default() }));
        datasets.push(Dataset::Part(Part { uid: 1, name: "test".to_owned(), systems }));
    }
    let names: Vec<i64> = nodes.iter().map(|n| n.label).collect();
    datasets.push(Dataset::Nodes2411(nodes));
    datasets.extend(geometry.lines.iter().zip(1..).map(|(line, number)| {
        let nodes = line.points.iter().filter_map(|i| names.get(*i).copied()).collect();
        let name = if line.name.is_empty() { "NONE".to_owned() } else { line.name.clone() };
        Dataset::TraceLine(TraceLine { number, color: 8, name, nodes })
    }));
    UniversalFile { datasets }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geometry_comes_back_from_a_universal_file() {
        let tilted = [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]];
        let point = |name: &str, x: f64, axes| Point { name: name.to_owned(), position_m: [x, 0.1, -2.0], axes };
        let points = vec![point("1", 0.1, Point::GLOBAL), point("2", 0.2, tilted), point("30", 1.0 / 3.0, tilted)];
        let lines = vec![Line { name: "spar".to_owned(), points: vec![0, 2, 1] }];
        let ours = Geometry { points, lines };
        let bytes = crate::data::uff::write(&geometry_file(&ours)).unwrap().0;
        let file = crate::data::uff::read(&bytes).unwrap().0;
        let (back, notes) = geometry(&[&file], &UnitsFrom::File, None).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(back.lines, ours.lines);
        for (a, b) in back.points.iter().zip(&ours.points) {
            assert_eq!((&a.name, a.position_m), (&b.name, b.position_m));
            // The axes are made unit vectors again, which may cost the last bit.
            let error = a.axes.as_flattened().iter().zip(b.axes.as_flattened()).map(|(x, y)| (x - y).abs());
            assert!(error.fold(0.0, f64::max) <= f64::EPSILON);
        }
    }

    #[test]
    fn a_geometry_without_unit_is_a_question() {
        let Some(folder) = crate::data::shared_data("uff_samples") else { return };
        let open = |name: &str| crate::data::uff::read(&std::fs::read(folder.join(name)).unwrap()).unwrap().0;
        let oros = open("mesh_Oros-modal_uff15_uff2412.uff");
        let error = geometry(&[&oros], &UnitsFrom::File, None).unwrap_err();
        assert!(matches!(&error, ConvertError::Questions(q) if q[0].option == "units"), "{error}");
        let mm = super::super::UnitSystem::from_name("mm-N-s").unwrap();
        let (g, _) = geometry(&[&oros], &UnitsFrom::System(mm), None).unwrap();
        let p = g.point("7").unwrap();
        assert!((p.position_m[0] + 0.051619).abs() < 1.0e-15);

        // LMS Test.Lab: user-defined units with factors 1; every node has a system of its own with x along -x.
        let lms = open("TestLab 161 164 18 15 82.uff");
        let (g, notes) = geometry(&[&lms], &UnitsFrom::File, None).unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!((g.points.len(), g.point("1").unwrap().position_m), (36, [-2.4, -0.95, 0.0]));
        // Six digits in the file.
        assert!((g.point("1").unwrap().axes[0][0] + 1.0).abs() < 1.0e-6);
        assert_eq!(g.lines[0].points, [1, 4, 5, 2, 3, 0, 1, 2]);
    }
}
