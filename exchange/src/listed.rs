//! Nodes, elements and groups of a deck: listed in the model file one by one, or, where they are many, as a mesh in a file of its own.
//!
//! Shells and solids that share section, type, frame and own properties are a part of the mesh; so is a group whose elements they are. What is single
//! (a beam, a shell with an angle of its own) stays in the list. Names are the same in both forms.

use super::names::Taken;
use super::text::{clean, list, map, quoted};
use retune::mesh::{Mesh, MeshNode, MeshSet, Shape, write_gmsh};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write as _;

/// From so many shells and solids on they are a mesh: below, a list is read more easily.
pub(super) const MOST_LISTED: usize = 2000;
/// So many elements of one kind are a part of the mesh.
const LEAST_PART: usize = 20;

/// A mesh in a file beside the model file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshFile {
    /// Its name, as the model file says it.
    pub name: String,
    /// An MSH file of gmsh.
    pub text: String,
}

/// What is written of an entry, above and behind it.
#[derive(Debug, Clone, Default)]
pub(super) struct Remarks {
    pub above: Vec<String>,
    pub behind: String,
}

#[derive(Debug, Clone)]
struct Node {
    name: String,
    value: String,
    remarks: Remarks,
    /// In the unit of the deck; of a node that may be one of a mesh.
    at: Option<[f64; 3]>,
}

#[derive(Debug, Clone)]
enum Element {
    Written { name: String, value: String },
    Cell(Cell),
}

/// A shell or a solid on nodes that have numbers.
#[derive(Debug, Clone)]
struct Cell {
    /// Of [`Listed::kinds`].
    kind: usize,
    id: u64,
    nodes: Vec<u64>,
}

/// What cells of a part share.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Kind {
    element: String,
    /// What stands before the numbers in names of elements, and of their nodes.
    prefixes: [String; 2],
    /// Section, frame, properties.
    items: Vec<(String, String)>,
}

/// Nodes, elements and groups in their order.
#[derive(Debug, Clone, Default)]
pub(super) struct Listed {
    nodes: Vec<Node>,
    elements: Vec<(Element, Remarks)>,
    kinds: Vec<Kind>,
    index: HashMap<Kind, usize>,
    groups: Vec<(String, Vec<String>)>,
}

/// A name that ends in a number, parted before it; numbers that are written otherwise than they are read have no such name.
fn parted(name: &str) -> Option<(&str, u64)> {
    let digits = name.len() - name.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (prefix, number) = name.split_at(name.len() - digits);
    let is_plain = number == "0" || !number.starts_with('0');
    (is_plain && !prefix.is_empty()).then(|| number.parse().ok()).flatten().map(|n| (prefix, n))
}

/// The shape of an element that may stand on a mesh.
fn shape(element: &str) -> Option<Shape> {
    Some(match element {
        "shell3" => Shape::Triangle3,
        "shell4" => Shape::Quadrilateral4,
        "tet4" => Shape::Tetrahedron4,
        "tet10" => Shape::Tetrahedron10,
        "hex8" | "hex8_reduced" => Shape::Hexahedron8,
        "hex20" | "hex20_reduced" => Shape::Hexahedron20,
        "wedge6" => Shape::Wedge6,
        "wedge15" => Shape::Wedge15,
        "pyramid5" => Shape::Pyramid5,
        "pyramid13" => Shape::Pyramid13,
        _ => return None,
    })
}

impl Cell {
    fn name(&self, kinds: &[Kind]) -> String {
        format!("{}{}", kinds[self.kind].prefixes[0], self.id)
    }

    fn value(&self, kinds: &[Kind]) -> String {
        let kind = &kinds[self.kind];
        let nodes: Vec<String> = self.nodes.iter().map(|n| format!("{}{n}", kind.prefixes[1])).collect();
        let mut items = vec![("type", kind.element.clone()), ("nodes", format!("[{}]", nodes.join(", ")))];
        items.extend(kind.items.iter().map(|(k, v)| (k.as_str(), v.clone())));
        map(&items)
    }
}

fn entry(out: &mut String, name: &str, value: &str, remarks: &Remarks) {
    for comment in &remarks.above {
        let _ = writeln!(out, "  # {}", clean(comment));
    }
    let _ = write!(out, "  {name}: {value}");
    if !remarks.behind.is_empty() {
        let _ = write!(out, " # {}", clean(&remarks.behind));
    }
    out.push('\n');
}

impl Listed {
    pub(super) fn has_nodes(&self) -> bool {
        !self.nodes.is_empty()
    }

    /// * `at` - where it is, in the unit of the deck; none for what no mesh has
    pub(super) fn node(&mut self, name: &str, value: &str, at: Option<[f64; 3]>, remarks: Remarks) {
        self.nodes.push(Node { name: name.to_string(), value: value.to_string(), at, remarks });
    }

    pub(super) fn element(&mut self, name: &str, items: &[(String, String)], remarks: Remarks) {
        let element = match self.cell(name, items) {
            Some(cell) => Element::Cell(cell),
            None => Element::Written { name: name.to_string(), value: map(items) },
        };
        self.elements.push((element, remarks));
    }

    fn cell(&mut self, name: &str, items: &[(String, String)]) -> Option<Cell> {
        let (prefix, id) = parted(name)?;
        let [(first, element), (second, nodes), rest @ ..] = items else { return None };
        let shape = shape(element).filter(|_| first == "type" && second == "nodes")?;
        let names: Vec<&str> = nodes.strip_prefix('[')?.strip_suffix(']')?.split(", ").collect();
        let parted: Vec<(&str, u64)> = names.into_iter().map(parted).collect::<Option<_>>()?;
        let of_nodes = parted.first()?.0;
        if parted.len() != shape.n_nodes() || parted.iter().any(|p| p.0 != of_nodes) {
            return None;
        }
        let prefixes = [prefix.to_string(), of_nodes.to_string()];
        let kind = Kind { element: element.clone(), prefixes, items: rest.to_vec() };
        let known = self.index.get(&kind).copied();
        let kind = known.unwrap_or_else(|| {
            self.kinds.push(kind.clone());
            self.index.insert(kind, self.kinds.len() - 1);
            self.kinds.len() - 1
        });
        Some(Cell { kind, id, nodes: parted.into_iter().map(|p| p.1).collect() })
    }

    pub(super) fn group(&mut self, name: &str, members: &[String]) {
        self.groups.push((name.to_string(), members.to_vec()));
    }

    /// The blocks `mesh`, `nodes`, `elements` and `groups` without their headings, and the mesh, where there is one.
    ///
    /// * `file` - what the mesh is to be called
    /// * `unit` - of its coordinates
    /// * `least` - shells and solids that are a mesh
    pub(super) fn finish(&self, file: &str, unit: &str, least: usize) -> ([String; 4], Option<MeshFile>) {
        let meshed = Meshed::of(self, least);
        let mut out: [String; 4] = Default::default();
        let found = meshed.as_ref().map(|m| m.write(self, file, unit));
        for node in self.nodes.iter().filter(|n| meshed.as_ref().is_none_or(|m| m.number(&n.name).is_none())) {
            entry(&mut out[1], &node.name, &node.value, &node.remarks);
        }
        for (i, (element, remarks)) in self.elements.iter().enumerate() {
            match element {
                Element::Written { name, value } => entry(&mut out[2], name, value, remarks),
                Element::Cell(_) if meshed.as_ref().is_some_and(|m| m.part_of[i].is_some()) => {}
                Element::Cell(cell) => {
                    entry(&mut out[2], &cell.name(&self.kinds), &cell.value(&self.kinds), remarks);
                }
            }
        }
        let served = found.as_ref().map_or(&[][..], |f| &f.groups);
        for (i, (name, members)) in self.groups.iter().enumerate() {
            match served.get(i) {
                Some(Served::Whole) => {}
                Some(Served::Part(set)) => {
                    let other = members.iter().filter(|m| !meshed.as_ref().is_some_and(|of| of.cells.contains_key(*m)));
                    let all: Vec<&String> = std::iter::once(set).chain(other).collect();
                    entry(&mut out[3], name, &list(&all), &Remarks::default());
                }
                Some(Served::No) | None => entry(&mut out[3], name, &list(members), &Remarks::default()),
            }
        }
        let file = found.map(|f| {
            out[0] = f.block;
            f.file
        });
        (out, file)
    }
}

/// Which entries are of the mesh.
struct Meshed {
    /// For each element of the list, its kind if it is of the mesh.
    part_of: Vec<Option<usize>>,
    /// Cells of the mesh by the name of the element, as places in the list.
    cells: HashMap<String, usize>,
    /// Their numbers in the mesh.
    nodes: HashSet<u64>,
    numbering: Vec<Numbering>,
}

/// How nodes and elements of an instance of a part are numbered in the mesh.
struct Numbering {
    /// What stands before the number in the name of a node.
    prefix: String,
    /// What is added to numbers of nodes, and of elements.
    offsets: [u64; 2],
}

fn offsets(all: &[Numbering], prefix: &str) -> [u64; 2] {
    all.iter().find(|of| of.prefix == prefix).map_or([0; 2], |of| of.offsets)
}

/// The least number of one digit and zeros that is above another: the next instance begins at what is easily subtracted.
pub(super) fn round_above(n: u64) -> Option<u64> {
    let step = 10_u64.checked_pow(n.max(1).ilog10())?;
    (n / step + 1).checked_mul(step)
}

/// What the mesh holds of a group.
enum Served {
    Whole,
    /// Under a name of its own.
    Part(String),
    No,
}

struct Written {
    block: String,
    groups: Vec<Served>,
    file: MeshFile,
}

impl Meshed {
    fn of(listed: &Listed, least: usize) -> Option<Self> {
        let mut counts = vec![0; listed.kinds.len()];
        // Of each instance of a part, the largest numbers of its nodes and elements.
        let mut largest: BTreeMap<&str, [u64; 2]> = BTreeMap::new();
        for (element, _) in &listed.elements {
            if let Element::Cell(cell) = element {
                counts[cell.kind] += 1;
                let [nodes, elements] = largest.entry(&listed.kinds[cell.kind].prefixes[1]).or_default();
                *nodes = cell.nodes.iter().fold(*nodes, |most, n| most.max(*n));
                *elements = (*elements).max(cell.id);
            }
        }
        let placed: HashSet<&str> = listed.nodes.iter().filter(|n| n.at.is_some()).map(|n| n.name.as_str()).collect();
        let mut numbering = Vec::with_capacity(largest.len());
        let mut next = [0; 2];
        for (prefix, most) in largest {
            numbering.push(Numbering { prefix: prefix.to_string(), offsets: next });
            for (next, most) in next.iter_mut().zip(most) {
                *next = round_above(next.checked_add(most)?)?;
            }
        }
        let mut seen = HashSet::new();
        let is_of_mesh = |cell: &Cell| {
            let prefix = &listed.kinds[cell.kind].prefixes[1];
            counts[cell.kind] >= LEAST_PART
                && cell.nodes.iter().all(|n| placed.contains(format!("{prefix}{n}").as_str()))
        };
        let part_of: Vec<Option<usize>> = listed
            .elements
            .iter()
            .map(|(element, _)| match element {
                // A number that is defined twice is one of the list.
                Element::Cell(cell)
                    if is_of_mesh(cell) && seen.insert((&listed.kinds[cell.kind].prefixes[1], cell.id)) =>
                {
                    Some(cell.kind)
                }
                _ => None,
            })
            .collect();
        if seen.len() < least {
            return None;
        }
        let (mut cells, mut nodes) = (HashMap::with_capacity(seen.len()), HashSet::new());
        for (i, (element, _)) in listed.elements.iter().enumerate() {
            if let (Element::Cell(cell), Some(_)) = (element, part_of[i]) {
                cells.insert(cell.name(&listed.kinds), i);
                let [offset, _] = offsets(&numbering, &listed.kinds[cell.kind].prefixes[1]);
                nodes.extend(cell.nodes.iter().map(|n| n + offset));
            }
        }
        Some(Self { part_of, cells, nodes, numbering })
    }

    /// The number of a node in the mesh, if it is one of it.
    fn number(&self, name: &str) -> Option<u64> {
        let (prefix, id) = parted(name)?;
        let of = self.numbering.iter().find(|of| of.prefix == prefix)?;
        Some(id + of.offsets[0]).filter(|id| self.nodes.contains(id))
    }

    fn write(&self, listed: &Listed, file: &str, unit: &str) -> Written {
        let mut mesh = Mesh::default();
        for node in &listed.nodes {
            if let (Some(id), Some(at)) = (self.number(&node.name), node.at) {
                mesh.add_node(MeshNode { id, at });
            }
        }
        let mut place = vec![None; listed.elements.len()];
        let mut parts: Vec<Vec<usize>> = vec![Vec::new(); listed.kinds.len()];
        for (i, (element, _)) in listed.elements.iter().enumerate() {
            let (Element::Cell(cell), Some(kind)) = (element, self.part_of[i]) else { continue };
            let own = offsets(&self.numbering, &listed.kinds[kind].prefixes[1]);
            let nodes: Option<Vec<usize>> = cell.nodes.iter().map(|n| mesh.node(n + own[0])).collect();
            if let (Some(nodes), Some(shape)) = (nodes, shape(&listed.kinds[kind].element)) {
                place[i] = Some(mesh.cells.len());
                parts[kind].push(mesh.cells.len());
                mesh.add_cell(cell.id + own[1], shape, nodes);
            }
        }
        let mut names = Taken::default();
        listed.groups.iter().for_each(|g| {
            names.unique(&g.0);
        });
        let mut groups = Vec::with_capacity(listed.groups.len());
        for (name, members) in &listed.groups {
            let mut cells: Vec<usize> =
                members.iter().filter_map(|m| self.cells.get(m)).filter_map(|&i| place[i]).collect();
            cells.sort_unstable();
            let served = if cells.is_empty() || cells.len() < LEAST_PART && cells.len() < members.len() {
                groups.push(Served::No);
                continue;
            } else if cells.len() == members.len() {
                Served::Whole
            } else {
                Served::Part(names.unique(&format!("{name}_mesh")))
            };
            let name = if let Served::Part(own) = &served { own.clone() } else { name.clone() };
            groups.push(served);
            mesh.sets.push(MeshSet { name, cells });
        }
        let mut block = String::new();
        for (kind, cells) in listed.kinds.iter().zip(parts).filter(|(_, cells)| !cells.is_empty()) {
            let word = kind.items.iter().find(|(key, _)| key == "section").map_or("part", |s| s.1.as_str());
            // The group of a section is the part.
            let name = match mesh.sets.iter().find(|s| s.cells == cells) {
                Some(set) => set.name.clone(),
                None => {
                    let name = names.unique(&format!("{word}_part"));
                    mesh.sets.push(MeshSet { name: name.clone(), cells });
                    name
                }
            };
            let mut items = Vec::new();
            if kind.element.ends_with("_reduced") {
                items.push(("type", kind.element.clone()));
            }
            items.push(("prefix", kind.prefixes[0].clone()));
            let [_, offset] = offsets(&self.numbering, &kind.prefixes[1]);
            if offset > 0 {
                items.push(("offset", offset.to_string()));
            }
            items.extend(kind.items.iter().map(|(k, v)| (k.as_str(), v.clone())));
            let _ = writeln!(block, "    {name}: {}", map(&items));
        }
        let text = write_gmsh(&mesh);
        let hash = retune::hash::sha256(text.as_bytes());
        let names = match &self.numbering[..] {
            [only] if only.prefix == "n" => String::new(),
            all => {
                let all: Vec<_> = all.iter().map(|of| (&of.prefix, of.offsets[0].to_string())).collect();
                format!("  prefixes: {}\n", map(&all))
            }
        };
        let quoted = quoted(file);
        let block = format!("  file: {quoted}\n  units: {unit}\n  sha256: {hash}\n{names}  parts:\n{block}");
        Written { block, groups, file: MeshFile { name: file.to_string(), text } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use retune::model::{Model, ParametricModel, Registry, load_in};

    const HEAD: &str = "retune: 1
name: a plate with a beam
parameters:
  p: {value: 1, bounds: [0.5, 2]}
sections:
  skin: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, thickness: 2 mm}
  thick: {E: 70 GPa, nu: 0.3, density: 2700 kg/m3, thickness: 3 mm}
  rod: {E: 70 GPa, G: 27 GPa, A: 1 cm2, Iy: 1 cm4, Iz: 1 cm4, J: 2 cm4, density: 2700 kg/m3}
beams:
  stiffener: {nodes: [n1, n80], section: rod, orientation: [0, 0, 1]}
supports:
  root: {nodes: [n0, n10, n20, n30]}
overrides:
  right: {stiffness: p}
  cquad4_107: {scale: {thickness: 1.5}}
";

    /// Nine by seven shells with a triangle, one of them with an angle of its own, in two sections; and the same as another instance.
    fn plates(instances: &[&str]) -> Listed {
        let mut listed = Listed::default();
        for (k, instance) in instances.iter().enumerate() {
            plate(&mut listed, instance, 200.0 * k as f64);
        }
        listed.group("pair", &["cquad4_100".to_string(), "stiffener".to_string()]);
        listed
    }

    fn plate(listed: &mut Listed, instance: &str, z: f64) {
        let own = |key: &str, value: String| (key.to_string(), value);
        for j in 0..8 {
            for i in 0..10 {
                let at = [100.0 / 3.0 * f64::from(i), 40.0 * f64::from(j), z];
                let value = format!("[{} mm, {} mm, {z} mm]", at[0], at[1]);
                listed.node(&format!("{instance}n{}", 10 * j + i), &value, Some(at), Remarks::default());
            }
        }
        let tip = [300.0, 0.0, z + 20.0];
        let value = format!("[300 mm, 0, {} mm]", tip[2]);
        listed.node(&format!("{instance}n80"), &value, Some(tip), Remarks::default());
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for j in 0..7 {
            for i in 0..9 {
                let n = 10 * j + i;
                let name = format!("{instance}cquad4_{}", 100 + 9 * j + i);
                let section = if j > 3 { "thick" } else { "skin" };
                let nodes = [n, n + 1, n + 11, n + 10].map(|n| format!("{instance}n{n}")).join(", ");
                let mut items = vec![
                    own("type", "shell4".to_string()),
                    own("nodes", format!("[{nodes}]")),
                    own("section", section.to_string()),
                ];
                if [i, j] == [4, 1] {
                    items.push(own("properties", "{angle: 0.5 rad}".to_string()));
                }
                listed.element(&name, &items, Remarks::default());
                if i < 5 { left.push(name) } else { right.push(name) }
            }
        }
        let nodes = own("nodes", format!("[{instance}n9, {instance}n19, {instance}n80]"));
        let items = [own("type", "shell3".to_string()), nodes, own("section", "skin".to_string())];
        let triangle = format!("{instance}ctria3_9");
        listed.element(&triangle, &items, Remarks::default());
        left.push(triangle);
        listed.group(&format!("{instance}left"), &left);
        listed.group(&format!("{instance}right"), &right);
    }

    fn model(listed: &Listed, least: usize) -> (Model, String, Option<MeshFile>) {
        let (blocks, mesh) = listed.finish("plate_mesh.msh", "mm", least);
        let mut text = HEAD.to_string();
        if listed.nodes.iter().any(|n| n.name == "b_n0") {
            text = text.replace("supports:\n", "supports:\n  other: {nodes: [b_n0, b_n10, b_n20, b_n30]}\n");
        }
        for (name, block) in ["mesh", "nodes", "elements", "groups"].iter().zip(&blocks) {
            if !block.is_empty() {
                let _ = write!(text, "{name}:\n{block}");
            }
        }
        let bytes = mesh.as_ref().map(|m| m.text.clone().into_bytes()).unwrap_or_default();
        let model = load_in(&text, None, &Registry::builtin(), &mut |file| {
            assert_eq!(file, "plate_mesh.msh");
            Ok(bytes.clone())
        });
        (model.unwrap_or_else(|p| panic!("{p:#?}\n{text}")).0, text, mesh)
    }

    /// A list and a mesh of the same entries are the same model under the same names.
    #[test]
    fn a_mesh_is_the_model_that_was_listed() {
        for instances in [&[""][..], &["", "b_"]] {
            let listed = plates(instances);
            let (first, ..) = model(&listed, usize::MAX);
            let (of_mesh, text, file) = model(&listed, 10);
            let file = file.expect("there is a mesh");
            assert!(text.contains("prefix: cquad4_") && text.contains(&file.name), "{text}");
            assert!(text.contains("cquad4_113: {type: shell4") && text.contains("ctria3_9: {type: shell3"), "{text}");
            assert_eq!(text.contains("prefixes: {b_n: 0, n: 90}"), instances.len() > 1, "{text}");
            let names = |m: &Model| {
                let mut all: Vec<String> = m.elements().iter().map(|e| e.name.clone()).collect();
                all.sort();
                let mut nodes = m.geometry().names.clone();
                nodes.sort();
                (all, nodes)
            };
            assert_eq!(names(&first), names(&of_mesh));
            for group in ["left", "right", "pair"] {
                let members = |m: &Model| {
                    let set = m.element_set(group).unwrap_or_else(|| panic!("no {group}"));
                    let mut all: Vec<String> = set.iter().map(|&e| m.elements()[e].name.clone()).collect();
                    all.sort();
                    all
                };
                assert_eq!(members(&first), members(&of_mesh), "{group}");
            }
            let frequencies = |m: &Model| {
                let options = retune::modal::SolveOptions { n_elastic: 6, shift: None };
                let modes = retune::model::solve_modes(m, &m.parameters().nominal(), options).unwrap();
                modes.elastic().map(|i| modes.frequency_hz(i)).collect::<Vec<_>>()
            };
            for (a, b) in frequencies(&first).into_iter().zip(frequencies(&of_mesh)) {
                assert!((a - b).abs() < 1e-9 * a, "{a} {b}");
            }
            // Fewer than asked for stay in the list.
            assert_eq!(listed.finish("plate_mesh.msh", "mm", 1000).1, None);
        }
    }

    #[test]
    fn numbers_of_the_next_instance_begin_above() {
        let found = [0, 1, 9, 10, 162, 1000, 36_556].map(round_above);
        assert_eq!(found, [1, 2, 10, 20, 200, 2000, 40_000].map(Some));
        assert_eq!(round_above(u64::MAX), None);
    }

    #[test]
    fn names_part_before_their_number() {
        assert_eq!(parted("cquad4_12"), Some(("cquad4_", 12)));
        assert_eq!(parted("n0"), Some(("n", 0)));
        for none in ["n012", "12", "tip", "n99999999999999999999999"] {
            assert_eq!(parted(none), None, "{none}");
        }
    }
}
