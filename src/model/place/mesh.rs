//! The elements that stand on a mesh, its sets, and the patches of its parts.

use super::{Entry, Placer};
use crate::catalogue::did_you_mean;
use crate::element::Element;
use crate::mesh::{Mesh, Shape};
use crate::model::geometry::{Vector, plus, spread};
use crate::model::loaded_mesh::{ALL, PlacedMesh};
use crate::model::outwards::Outwards;
use crate::model::placed_element::PlacedElement;
use crate::model::spec::MeshPartSpec;
use crate::yaml::child;

/// Nodes at which effects are looked for, of a mesh or of a large superelement.
pub(in crate::model) const MOST_SITES: usize = 100;
/// Patches of a part, where the file does not say.
const PATCHES: usize = 24;
/// A patch has about as many elements at least.
const LEAST_PATCH: usize = 4;

/// The usual element of a shape.
fn usual(shape: Shape) -> Option<&'static str> {
    Some(match shape {
        Shape::Line2 => "beam",
        Shape::Triangle3 => "shell3",
        Shape::Quadrilateral4 => "shell4",
        Shape::Tetrahedron4 => "tet4",
        Shape::Tetrahedron10 => "tet10",
        Shape::Hexahedron8 => "hex8",
        Shape::Hexahedron20 => "hex20",
        Shape::Wedge6 => "wedge6",
        Shape::Wedge15 => "wedge15",
        Shape::Pyramid5 => "pyramid5",
        Shape::Pyramid13 => "pyramid13",
        _ => return None,
    })
}

impl Placer<'_> {
    pub(super) fn mesh(&mut self) {
        let Some(spec) = &self.spec.mesh else { return };
        let Some(loaded) = spec.loaded.0.clone() else { return };
        let first_node = self.geometry.names.len();
        let nodes = self.mesh_nodes(&loaded);
        let mesh = &loaded.mesh;
        let mut element_of: Vec<Option<usize>> = vec![None; mesh.cells.len()];
        let mut part_of: Vec<Option<&str>> = vec![None; mesh.cells.len()];
        // What no other part has is known last.
        let parts = spec.parts.iter().filter(|(n, _)| *n != ALL).chain(spec.parts.get_key_value(ALL));
        for (name, part) in parts {
            let cells = self.cells_of(name, mesh, &mut part_of);
            if !cells.is_empty() {
                self.part(name, part, &cells, mesh, &nodes, &mut element_of);
            }
        }
        for set in mesh.sets.iter().filter(|s| !spec.parts.contains_key(&s.name)) {
            let mut elements: Vec<usize> = set.cells.iter().filter_map(|&c| element_of[c]).collect();
            elements.sort_unstable();
            if !elements.is_empty() && self.claim(&set.name, &child("mesh.parts", &set.name)) {
                self.sets.insert(set.name.clone(), elements);
            }
        }
        let wanted = spec.patches.map_or(PATCHES, |n| n as usize);
        for name in spec.parts.keys() {
            self.patches_of(name, wanted, &child("mesh.parts", name));
        }
        self.mesh_parts.extend(spec.parts.keys().cloned());
        let own = self.corners(|_| true, |node| node >= first_node);
        self.sites.extend(spread(&self.geometry.positions, &own, MOST_SITES));
    }

    /// Shells and solids that the file lists one by one, as a deck has them: where they have many nodes they are a mesh as well, with its sites and the
    /// patches of its parts, which are groups of the file.
    ///
    /// A node at which something else stands too is a site whatever their number.
    pub(super) fn listed_mesh(&mut self) {
        let n_listed = self.spec.nodes.len();
        let mut stands: Vec<[bool; 2]> = vec![[false; 2]; n_listed];
        for e in &self.elements {
            for &node in e.nodes.iter().filter(|n| **n < n_listed) {
                stands[node][usize::from(!e.is_of_mesh())] = true;
            }
        }
        let corners = self.corners(PlacedElement::is_of_mesh, |node| node < n_listed);
        let is_inner = |node: usize| stands[node] == [true, false];
        if self.spec.mesh.is_some() || corners.len() <= MOST_SITES {
            self.sites.extend(0..n_listed);
            return;
        }
        let spread = spread(&self.geometry.positions, &corners, MOST_SITES);
        self.sites.extend((0..n_listed).filter(|&n| !is_inner(n) || spread.binary_search(&n).is_ok()));
        let mut is_free: Vec<bool> = self.elements.iter().map(PlacedElement::is_of_mesh).collect();
        for name in self.spec.groups.keys() {
            let Some(elements) = self.sets.get(name) else { continue };
            if elements.len() >= 2 * LEAST_PATCH && elements.iter().all(|&e| is_free[e]) {
                for &e in elements {
                    is_free[e] = false;
                }
                self.mesh_parts.push(name.clone());
            }
        }
        for name in self.mesh_parts.clone() {
            self.patches_of(&name, PATCHES, &child("groups", &name));
        }
    }

    /// Nodes at corners of elements: what acts on the middle of an edge acts at a corner beside it.
    fn corners(&self, of: impl Fn(&PlacedElement) -> bool, accept: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut is_corner = vec![false; self.geometry.names.len()];
        for element in self.elements.iter().filter(|e| of(e)) {
            element.nodes.iter().take(element.n_corners()).for_each(|&n| is_corner[n] = true);
        }
        (0..is_corner.len()).filter(|&n| is_corner[n] && accept(n)).collect()
    }

    /// The node of the model for each node of the mesh that some cell has.
    fn mesh_nodes(&mut self, loaded: &PlacedMesh) -> Vec<Option<usize>> {
        let mesh = &loaded.mesh;
        let mut of = vec![None; mesh.nodes.len()];
        for (name, i) in &loaded.named {
            of[*i] = self.geometry.node(name);
        }
        let mut used = vec![false; mesh.nodes.len()];
        (0..mesh.cells.len()).flat_map(|c| mesh.nodes_of(c)).for_each(|&n| used[n] = true);
        for (i, node) in mesh.nodes.iter().enumerate().filter(|(i, _)| used[*i]) {
            let name = loaded.name(i);
            if let Some(known) = self.geometry.node(&name).filter(|k| of[i] != Some(*k)) {
                let other = self.geometry.names[known].clone();
                self.error(
                    child("nodes", &other),
                    format_args!("the mesh has a node of its own that is called `{other}`; give this one another name"),
                );
            }
            match of[i] {
                Some(known) => self.geometry.call(name, known),
                None => of[i] = Some(self.geometry.add(name, node.at)),
            }
        }
        of
    }

    /// The cells of a part: those of the largest dimension in its set, which no other part has.
    fn cells_of<'m>(&mut self, name: &'m str, mesh: &Mesh, part_of: &mut [Option<&'m str>]) -> Vec<usize> {
        let all: Vec<usize>;
        let cells: &[usize] = match mesh.set(name) {
            Some(set) => &set.cells,
            None if name == ALL => {
                all = (0..mesh.cells.len()).filter(|&c| part_of[c].is_none()).collect();
                &all
            }
            None => return Vec::new(),
        };
        let dimension = |c: &usize| mesh.cells[*c].shape.dimension();
        let most = if mesh.set(name).is_none() {
            // Edges of what others have are not elements of their own.
            mesh.cells.iter().map(|c| c.shape.dimension()).max()
        } else {
            cells.iter().map(dimension).max()
        };
        let most = most.unwrap_or(0);
        let path = child("mesh.parts", name);
        if most == 0 {
            self.error(
                path,
                format_args!(
                    "the set `{name}` consists of points, on which no element stands; name it in `masses` or `supports`"
                ),
            );
            return Vec::new();
        }
        let own: Vec<usize> = cells.iter().copied().filter(|c| dimension(c) == most).collect();
        for &c in &own {
            if let Some(other) = part_of[c].replace(name) {
                let id = mesh.cells[c].id;
                self.error(&path, format_args!("cell {id} is in the part `{other}` too; an element has one section"));
                return Vec::new();
            }
        }
        own
    }

    fn part(
        &mut self,
        name: &str,
        part: &MeshPartSpec,
        cells: &[usize],
        mesh: &Mesh,
        nodes: &[Option<usize>],
        element_of: &mut [Option<usize>],
    ) {
        let path = child("mesh.parts", name);
        if !self.claim(name, &path) {
            return;
        }
        let Some(kinds) = self.kinds(part, cells, mesh, &path) else { return };
        if self.elements.len() + cells.len() > super::MOST_ELEMENTS {
            self.error(&path, format_args!("with this the model has more than {} elements", super::MOST_ELEMENTS));
            return;
        }
        let mut entries: Vec<(Shape, Entry<'_>)> = Vec::new();
        for (shape, kind) in kinds {
            let mut entry = self.entry(&path, kind, part.section.as_deref(), &part.properties);
            entry.orientation = part.orientation;
            entry.frame = part.frame.as_deref();
            entries.push((shape, entry));
        }
        let mut made = Vec::with_capacity(cells.len());
        let prefix = part.prefix.as_deref().unwrap_or("e");
        for &c in cells {
            let cell = mesh.cells[c];
            let Some((_, entry)) = entries.iter().find(|(shape, _)| *shape == cell.shape) else { continue };
            let own: Option<Vec<usize>> = mesh.nodes_of(c).iter().map(|&n| nodes[n]).collect();
            let element = format!("{prefix}{}", cell.id.saturating_sub(part.offset.unwrap_or(0)));
            if self.sets.contains_key(&element) {
                self.error(
                    &path,
                    format_args!(
                        "the name `{element}` of an element of the mesh is taken by another element, chain or mass"
                    ),
                );
                return;
            }
            element_of[c] = own.and_then(|own| self.add(element, entry, own));
            made.extend(element_of[c]);
        }
        self.sets.insert(name.to_string(), made);
    }

    /// The element of each shape among some cells.
    fn kinds(
        &mut self,
        part: &MeshPartSpec,
        cells: &[usize],
        mesh: &Mesh,
        path: &str,
    ) -> Option<Vec<(Shape, &'static dyn Element)>> {
        let mut shapes: Vec<Shape> = cells.iter().map(|&c| mesh.cells[c].shape).collect();
        shapes.sort_unstable();
        shapes.dedup();
        let stated = match &part.kind {
            None => None,
            Some(word) => {
                let found = self.registry.find(word);
                let fits = found.is_some_and(|k| shapes.iter().any(|s| s.n_nodes() == k.nodes().len()));
                if !fits {
                    let names = self.registry.elements().map(Element::name);
                    let suggestion = if found.is_some() { String::new() } else { did_you_mean(word, names) };
                    let has: Vec<&str> = shapes.iter().map(|s| s.name()).collect();
                    let has = has.join(", ");
                    self.error(
                        child(path, "type"),
                        format_args!("`{word}` is not an element for what the part has ({has}){suggestion}"),
                    );
                    return None;
                }
                found
            }
        };
        let mut kinds = Vec::new();
        for shape in shapes {
            let own = stated.filter(|k| k.nodes().len() == shape.n_nodes());
            let Some(kind) = own.or_else(|| usual(shape).and_then(|word| self.registry.find(word))) else {
                self.error(path, format_args!("there is no element of the shape {} among those of retune; mesh the part at first order, or solids at second order without nodes in faces", shape.name()));
                return None;
            };
            kinds.push((shape, kind));
        }
        Some(kinds)
    }

    /// Cuts a part into patches of neighbouring elements, `skin.p1`, ...: their middles far from each other, each element with the middle
    /// that is nearest over elements that touch.
    fn patches_of(&mut self, name: &str, wanted: usize, path: &str) {
        let elements = self.sets.get(name).cloned().unwrap_or_default();
        let n = wanted.min(elements.len() / LEAST_PATCH);
        if n < 2 {
            return;
        }
        let positions = &self.geometry.positions;
        let middle = |&e: &usize| {
            let nodes = &self.elements[e].nodes;
            nodes.iter().fold([0.0; 3], |sum, &k| plus(sum, 1.0 / nodes.len() as f64, positions[k]))
        };
        let middles: Vec<Vector> = elements.iter().map(middle).collect();
        let all: Vec<usize> = (0..elements.len()).collect();
        let seeds = spread(&middles, &all, n);
        let neighbours = self.neighbours(&elements);
        let owner = nearest_seed(&middles, &neighbours, &seeds);
        for (k, _) in seeds.iter().enumerate() {
            let own: Vec<usize> = all.iter().filter(|&&i| owner[i] == Some(k)).map(|&i| elements[i]).collect();
            let patch = format!("{name}.p{}", k + 1);
            if !own.is_empty() && self.claim(&patch, path) {
                self.sets.insert(patch.clone(), own);
                self.patches.push(patch);
            }
        }
    }

    /// Of some elements, those that share a node with each, as places in the list.
    fn neighbours(&self, elements: &[usize]) -> Vec<Vec<usize>> {
        let mut at: Vec<Vec<usize>> = vec![Vec::new(); self.geometry.names.len()];
        for (i, &e) in elements.iter().enumerate() {
            self.elements[e].nodes.iter().for_each(|&n| at[n].push(i));
        }
        let of = |&e: &usize| self.elements[e].nodes.iter().flat_map(|&n| at[n].iter().copied()).collect::<Vec<_>>();
        elements.iter().map(of).collect()
    }
}

/// For each point the seed that is nearest along neighbours; none where no seed reaches it.
fn nearest_seed(points: &[Vector], neighbours: &[Vec<usize>], seeds: &[usize]) -> Vec<Option<usize>> {
    let mut owner = vec![None; points.len()];
    for reached in Outwards::new(seeds, |i| points[i], |i| neighbours[i].iter().copied()) {
        owner[reached.at] = Some(reached.seed);
    }
    owner
}
