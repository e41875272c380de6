//! MSH files of gmsh: versions 4.1 and 2.2, text and binary.
//!
//! Source: C. Geuzaine, J.-F. Remacle, Gmsh reference manual, section on file formats. Physical groups are the sets; curves, surfaces and
//! volumes without one are none. The middles of edges stand in another order than in the elements of retune, and are put into theirs.

use super::MeshReader;
use super::cell::{Mesh, MeshNode, MeshSet, Shape};
use super::cursor::{Cursor, MeshError};
use std::collections::{BTreeMap, HashMap};

#[doc = "MSH files of gmsh, versions 4.1 and 2.2."]
#[derive(Debug, Clone, Copy)]
pub struct Gmsh;

impl MeshReader for Gmsh {
    fn name(&self) -> &'static str {
        "gmsh"
    }

    fn summary(&self) -> &'static str {
        "MSH files of gmsh, versions 4.1 and 2.2, text or binary, with physical groups as sets; meshio writes them too."
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        let start = bytes.iter().position(|c| !c.is_ascii_whitespace()).unwrap_or(bytes.len());
        bytes[start..].starts_with(b"$MeshFormat") || bytes[start..].starts_with(b"$Comments")
    }

    fn read(&self, bytes: &[u8]) -> Result<Mesh, MeshError> {
        let mut file = File { cursor: Cursor::new(bytes), ..File::empty() };
        file.sections()?;
        file.finish()
    }
}

/// Shape, and for each of our nodes its place among those of gmsh.
fn shape(kind: i64) -> Option<(Shape, &'static [usize])> {
    const TET10: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
    const HEX20: [usize; 20] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15];
    const WEDGE15: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11];
    const PYRAMID13: [usize; 13] = [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12];
    Some(match kind {
        15 => (Shape::Point, &[]),
        1 => (Shape::Line2, &[]),
        8 => (Shape::Line3, &[]),
        2 => (Shape::Triangle3, &[]),
        9 => (Shape::Triangle6, &[]),
        3 => (Shape::Quadrilateral4, &[]),
        16 => (Shape::Quadrilateral8, &[]),
        10 => (Shape::Quadrilateral9, &[]),
        4 => (Shape::Tetrahedron4, &[]),
        11 => (Shape::Tetrahedron10, &TET10),
        5 => (Shape::Hexahedron8, &[]),
        17 => (Shape::Hexahedron20, &HEX20),
        12 => (Shape::Hexahedron27, &[]),
        6 => (Shape::Wedge6, &[]),
        18 => (Shape::Wedge15, &WEDGE15),
        13 => (Shape::Wedge18, &[]),
        7 => (Shape::Pyramid5, &[]),
        19 => (Shape::Pyramid13, &PYRAMID13),
        14 => (Shape::Pyramid14, &[]),
        _ => return None,
    })
}

/// The number of gmsh for a shape.
pub(super) fn kind_of(of: Shape) -> i64 {
    (1..=LAST_KIND).find(|&kind| shape(kind).is_some_and(|s| s.0 == of)).unwrap_or_default()
}

/// For each place of a cell in gmsh, which of our nodes stands there.
pub(super) fn order_of(of: Shape, n_nodes: usize) -> impl Iterator<Item = usize> {
    let order = shape(kind_of(of)).map_or(&[][..], |s| s.1);
    (0..n_nodes).map(|k| if order.is_empty() { k } else { order.iter().position(|&at| at == k).unwrap_or(k) })
}

/// The largest number of a type of elements that is read.
const LAST_KIND: i64 = 19;

const DIMENSIONS: [&str; 4] = ["point", "line", "surface", "volume"];

/// A physical group: dimension and number.
type Group = (usize, i64);

struct File<'a> {
    cursor: Cursor<'a>,
    version: f64,
    mesh: Mesh,
    names: HashMap<Group, String>,
    /// Physical groups of geometric entities, by dimension and number; of version 4.
    entities: HashMap<(i64, i64), Vec<i64>>,
    /// Cells of groups, by dimension and number.
    groups: BTreeMap<Group, Vec<usize>>,
}

impl File<'_> {
    fn empty() -> File<'static> {
        File {
            cursor: Cursor::new(&[]),
            version: 0.0,
            mesh: Mesh::default(),
            names: HashMap::new(),
            entities: HashMap::new(),
            groups: BTreeMap::new(),
        }
    }

    fn sections(&mut self) -> Result<(), MeshError> {
        let mut seen = Vec::new();
        while let Some(line) = self.cursor.next_line() {
            let Some(section) = line.strip_prefix('$') else {
                return Err(self
                    .cursor
                    .error(format_args!("a section such as `$Nodes` was expected, not `{line:.40}`")));
            };
            if self.version == 0.0 && section != "MeshFormat" && section != "Comments" {
                return Err(self.cursor.error("`$MeshFormat` was expected first"));
            }
            let is_binary = self.cursor.is_binary;
            match section {
                "MeshFormat" => self.format()?,
                "PhysicalNames" => {
                    self.cursor.is_binary = false;
                    self.physical_names()?;
                    self.cursor.is_binary = is_binary;
                }
                "Entities" if self.version > 4.0 => self.entities()?,
                "Nodes" if self.version > 4.0 => self.nodes()?,
                "Nodes" => self.nodes_of_2()?,
                "Elements" if self.version > 4.0 => self.elements()?,
                "Elements" => self.elements_of_2()?,
                "PartitionedEntities" => {
                    return Err(self
                        .cursor
                        .error("the mesh is in partitions; save it as one (in gmsh: Tools > Partition > Delete)"));
                }
                _ => {}
            }
            self.cursor.skip_past(&format!("$End{section}"))?;
            seen.push(section.to_string());
        }
        for needed in ["MeshFormat", "Nodes", "Elements"] {
            if !seen.iter().any(|s| s == needed) {
                return Err(self.cursor.error(format_args!("the file has no section `${needed}`")));
            }
        }
        Ok(())
    }

    fn format(&mut self) -> Result<(), MeshError> {
        let version = self.cursor.word("the version")?.to_string();
        self.version = match version.as_str() {
            "4.1" => 4.1,
            "2" | "2.1" | "2.2" => 2.2,
            _ => {
                let text = format!("version {version} of MSH is not read; save the mesh in version 4.1 (or 2.2)");
                return Err(self.cursor.error(text));
            }
        };
        let kind = self.cursor.int("the type of the file, 0 or 1")?;
        let size = self.cursor.int("the size of a number, 8")?;
        if size != 8 || !(0..=1).contains(&kind) {
            return Err(self.cursor.error(format_args!("`{kind} {size}`: type 0 or 1 and size 8 were expected")));
        }
        self.cursor.text_line();
        self.cursor.is_binary = kind == 1;
        if kind == 1 && self.cursor.int("the number one")? != 1 {
            return Err(self
                .cursor
                .error("the numbers have their larger end first; save the mesh on this kind of machine, or as text"));
        }
        Ok(())
    }

    fn physical_names(&mut self) -> Result<(), MeshError> {
        let n = self.cursor.size("the number of physical names")?;
        for _ in 0..self.cursor.count(n, 6, "names")? {
            let dimension = self.cursor.size("a dimension, 0 to 3")?;
            let number = self.cursor.int("the number of a physical group")?;
            let name = self.cursor.text_line();
            let name = name.strip_prefix('"').and_then(|n| n.strip_suffix('"'));
            match (name, usize::try_from(dimension).ok().filter(|d| *d <= 3)) {
                (Some(name), Some(dimension)) => self.names.insert((dimension, number), name.to_string()),
                _ => return Err(self.cursor.error("`DIMENSION NUMBER \"NAME\"` was expected")),
            };
        }
        Ok(())
    }

    fn entities(&mut self) -> Result<(), MeshError> {
        let c = &mut self.cursor;
        let mut counts = [0; 4];
        for (count, what) in counts.iter_mut().zip(DIMENSIONS) {
            let n = c.size("a number of entities")?;
            *count = c.count(n, 8, &format!("{what}s"))?;
        }
        for (dimension, count) in (0..).zip(counts) {
            for _ in 0..count {
                let number = c.int("the number of an entity")?;
                for _ in 0..if dimension == 0 { 3 } else { 6 } {
                    c.real("a coordinate")?;
                }
                let n = c.size("a number of physical groups")?;
                let mut groups = Vec::new();
                for _ in 0..c.count(n, 2, "physical groups")? {
                    groups.push(c.int("a physical group")?);
                }
                self.entities.insert((dimension, number), groups);
                if dimension > 0 {
                    let n = c.size("a number of bounding entities")?;
                    for _ in 0..c.count(n, 2, "bounding entities")? {
                        c.int("a bounding entity")?;
                    }
                }
            }
        }
        Ok(())
    }

    fn node(&mut self, id: u64, at: [f64; 3]) -> Result<(), MeshError> {
        if self.mesh.add_node(MeshNode { id, at }) {
            Ok(())
        } else {
            Err(self.cursor.error(format_args!("node {id} is defined twice")))
        }
    }

    fn point(&mut self) -> Result<[f64; 3], MeshError> {
        let mut at = [0.0; 3];
        for x in &mut at {
            *x = self.cursor.real("a coordinate")?;
        }
        Ok(at)
    }

    fn nodes(&mut self) -> Result<(), MeshError> {
        let blocks = self.cursor.size("the number of blocks of nodes")?;
        for what in ["the number of nodes", "the least node", "the largest node"] {
            self.cursor.size(what)?;
        }
        for _ in 0..self.cursor.count(blocks, 8, "blocks")? {
            let dimension = self.cursor.int("a dimension")?;
            self.cursor.int("an entity")?;
            let is_parametric = self.cursor.int("0 or 1")? != 0;
            let n = self.cursor.size("the number of nodes of a block")?;
            let n = self.cursor.count(n, 8, "nodes")?;
            let mut ids = Vec::with_capacity(n);
            for _ in 0..n {
                ids.push(self.cursor.size("the number of a node")?);
            }
            for id in ids {
                let at = self.point()?;
                for _ in 0..if is_parametric { dimension.clamp(0, 3) } else { 0 } {
                    self.cursor.real("a parametric coordinate")?;
                }
                self.node(id, at)?;
            }
        }
        Ok(())
    }

    fn nodes_of_2(&mut self) -> Result<(), MeshError> {
        let n = self.count_of_2("the number of nodes")?;
        for _ in 0..self.cursor.count(n, 8, "nodes")? {
            let id = self.cursor.int("the number of a node")?.unsigned_abs();
            let at = self.point()?;
            self.node(id, at)?;
        }
        Ok(())
    }

    /// A count of version 2, which is text in binary files as well.
    fn count_of_2(&mut self, what: &str) -> Result<u64, MeshError> {
        let is_binary = std::mem::take(&mut self.cursor.is_binary);
        let n = self.cursor.size(what)?;
        self.cursor.text_line();
        self.cursor.is_binary = is_binary;
        Ok(n)
    }

    fn cell(&mut self, id: u64, kind: i64, groups: &[Group], wide: bool) -> Result<(), MeshError> {
        let Some((shape, order)) = shape(kind) else {
            let known = "first-order cells, and of second order lines, triangles, quadrilaterals, tetrahedra, hexahedra, wedges and pyramids";
            return Err(self
                .cursor
                .error(format_args!("element {id} is of type {kind} of gmsh, which is not read; known are {known}")));
        };
        let mut nodes = [0; 27];
        let nodes = &mut nodes[..shape.n_nodes()];
        for node in nodes.iter_mut() {
            let number = if wide { self.cursor.size("a node")? } else { self.cursor.int("a node")?.unsigned_abs() };
            *node = self.mesh.node(number).ok_or_else(|| {
                self.cursor.error(format_args!("element {id} is on node {number}, which the file does not have"))
            })?;
        }
        let cell = self.mesh.cells.len();
        if order.is_empty() {
            self.mesh.add_cell(id, shape, nodes.iter().copied());
        } else {
            self.mesh.add_cell(id, shape, order.iter().map(|&k| nodes[k]));
        }
        for &group in groups {
            self.groups.entry(group).or_default().push(cell);
        }
        Ok(())
    }

    fn elements(&mut self) -> Result<(), MeshError> {
        let blocks = self.cursor.size("the number of blocks of elements")?;
        for what in ["the number of elements", "the least element", "the largest element"] {
            self.cursor.size(what)?;
        }
        for _ in 0..self.cursor.count(blocks, 8, "blocks")? {
            let dimension = self.cursor.int("a dimension")?;
            let entity = self.cursor.int("an entity")?;
            let kind = self.cursor.int("a type of elements")?;
            let n = self.cursor.size("the number of elements of a block")?;
            let of = self.entities.get(&(dimension, entity));
            let own = usize::try_from(dimension).unwrap_or_default();
            let groups: Vec<Group> = of.into_iter().flatten().map(|g| (own, g.abs())).collect();
            for _ in 0..self.cursor.count(n, 4, "elements")? {
                let id = self.cursor.size("the number of an element")?;
                self.cell(id, kind, &groups, true)?;
            }
        }
        Ok(())
    }

    fn elements_of_2(&mut self) -> Result<(), MeshError> {
        let n = self.count_of_2("the number of elements")?;
        let mut left = self.cursor.count(n, 4, "elements")?;
        while left > 0 {
            // Text has an element a line, bytes several of one type behind one head.
            let first = self.cursor.int("an element")?;
            let (kind, together, n_tags, mut id) = if self.cursor.is_binary {
                let together = self.cursor.int("a number of elements")?;
                (first, together, self.cursor.int("a number of tags")?, None)
            } else {
                (self.cursor.int("a type of elements")?, 1, self.cursor.int("a number of tags")?, Some(first))
            };
            let together = usize::try_from(together).ok().filter(|t| (1..=left).contains(t));
            let together = together.ok_or_else(|| self.cursor.error("more elements follow than were announced"))?;
            let dimension = shape(kind).map_or(0, |(s, _)| s.dimension());
            for _ in 0..together {
                let id = match id.take() {
                    Some(id) => id,
                    None => self.cursor.int("the number of an element")?,
                };
                let mut tags = Vec::new();
                for _ in 0..self.cursor.count(n_tags.unsigned_abs(), 1, "tags")? {
                    tags.push(self.cursor.int("a tag")?);
                }
                let groups: Vec<Group> =
                    tags.first().filter(|t| **t != 0).map(|t| (dimension, t.abs())).into_iter().collect();
                self.cell(id.unsigned_abs(), kind, &groups, false)?;
            }
            left -= together;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Mesh, MeshError> {
        for ((dimension, number), cells) in self.groups {
            let name = self.names.remove(&(dimension, number));
            let name = name.unwrap_or_else(|| format!("{}_{number}", DIMENSIONS[dimension.min(3)]));
            match self.mesh.sets.iter_mut().find(|s| s.name == name) {
                // One name may be given in several dimensions: a skin with its edge.
                Some(set) => set.cells.extend(cells),
                None => self.mesh.sets.push(MeshSet { name, cells }),
            }
        }
        self.mesh.sets.iter_mut().for_each(|s| s.cells.sort_unstable());
        Ok(self.mesh)
    }
}
