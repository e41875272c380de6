//! What a mesh consists of.

use std::collections::HashMap;

/// The shape of a cell by its nodes, corners first, then the middles of edges in the order of the elements of the same name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names say it")]
pub enum Shape {
    Point,
    Line2,
    Line3,
    Triangle3,
    Triangle6,
    Quadrilateral4,
    Quadrilateral8,
    Quadrilateral9,
    Tetrahedron4,
    Tetrahedron10,
    Hexahedron8,
    Hexahedron20,
    Hexahedron27,
    Wedge6,
    Wedge15,
    Wedge18,
    Pyramid5,
    Pyramid13,
    Pyramid14,
}

impl Shape {
    /// Number of nodes.
    pub fn n_nodes(self) -> usize {
        match self {
            Shape::Point => 1,
            Shape::Line2 => 2,
            Shape::Line3 | Shape::Triangle3 => 3,
            Shape::Quadrilateral4 | Shape::Tetrahedron4 => 4,
            Shape::Pyramid5 => 5,
            Shape::Triangle6 | Shape::Wedge6 => 6,
            Shape::Quadrilateral8 | Shape::Hexahedron8 => 8,
            Shape::Quadrilateral9 => 9,
            Shape::Tetrahedron10 => 10,
            Shape::Pyramid13 => 13,
            Shape::Pyramid14 => 14,
            Shape::Wedge15 => 15,
            Shape::Wedge18 => 18,
            Shape::Hexahedron20 => 20,
            Shape::Hexahedron27 => 27,
        }
    }

    /// Dimension of what it fills: 0 a point, 1 a curve, 2 a surface, 3 a volume.
    pub fn dimension(self) -> usize {
        match self {
            Shape::Point => 0,
            Shape::Line2 | Shape::Line3 => 1,
            Shape::Triangle3
            | Shape::Triangle6
            | Shape::Quadrilateral4
            | Shape::Quadrilateral8
            | Shape::Quadrilateral9 => 2,
            _ => 3,
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Shape::Point => "point",
            Shape::Line2 => "line of 2 nodes",
            Shape::Line3 => "line of 3 nodes",
            Shape::Triangle3 => "triangle of 3 nodes",
            Shape::Triangle6 => "triangle of 6 nodes",
            Shape::Quadrilateral4 => "quadrilateral of 4 nodes",
            Shape::Quadrilateral8 => "quadrilateral of 8 nodes",
            Shape::Quadrilateral9 => "quadrilateral of 9 nodes",
            Shape::Tetrahedron4 => "tetrahedron of 4 nodes",
            Shape::Tetrahedron10 => "tetrahedron of 10 nodes",
            Shape::Hexahedron8 => "hexahedron of 8 nodes",
            Shape::Hexahedron20 => "hexahedron of 20 nodes",
            Shape::Hexahedron27 => "hexahedron of 27 nodes",
            Shape::Wedge6 => "wedge of 6 nodes",
            Shape::Wedge15 => "wedge of 15 nodes",
            Shape::Wedge18 => "wedge of 18 nodes",
            Shape::Pyramid5 => "pyramid of 5 nodes",
            Shape::Pyramid13 => "pyramid of 13 nodes",
            Shape::Pyramid14 => "pyramid of 14 nodes",
        }
    }
}

/// A node of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshNode {
    /// Its number in the file.
    pub id: u64,
    /// Where it is, in the unit of the file.
    pub at: [f64; 3],
}

/// A cell of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    /// Its number in the file.
    pub id: u64,
    /// Its shape.
    pub shape: Shape,
    /// Where its nodes begin in the list of the mesh.
    first: usize,
}

/// A named set of cells, or of nodes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshSet {
    /// Its name in the file, or one made of its dimension and its number: `surface_3`.
    pub name: String,
    /// Its cells, as indices, ascending.
    pub cells: Vec<usize>,
}

/// Nodes, cells and sets.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// In the order of the file.
    pub nodes: Vec<MeshNode>,
    /// In the order of the file.
    pub cells: Vec<Cell>,
    /// By dimension and number.
    pub sets: Vec<MeshSet>,
    connectivity: Vec<usize>,
    index: HashMap<u64, usize>,
}

impl Mesh {
    /// Adds a node; whether its number was free.
    pub fn add_node(&mut self, node: MeshNode) -> bool {
        let index = self.nodes.len();
        self.nodes.push(node);
        self.index.insert(node.id, index).is_none()
    }

    /// Adds a cell on nodes, as indices.
    pub fn add_cell(&mut self, id: u64, shape: Shape, nodes: impl IntoIterator<Item = usize>) {
        let first = self.connectivity.len();
        self.connectivity.extend(nodes);
        self.cells.push(Cell { id, shape, first });
    }

    /// Index of the node of a number.
    pub fn node(&self, id: u64) -> Option<usize> {
        self.index.get(&id).copied()
    }

    /// Nodes of a cell, as indices.
    pub fn nodes_of(&self, cell: usize) -> &[usize] {
        let Cell { shape, first, .. } = self.cells[cell];
        &self.connectivity[first..first + shape.n_nodes()]
    }

    /// The set of a name.
    pub fn set(&self, name: &str) -> Option<&MeshSet> {
        self.sets.iter().find(|s| s.name == name)
    }

    /// Nodes of a set, as indices, each once, in the order of its cells.
    pub fn nodes_of_set(&self, set: &MeshSet) -> Vec<usize> {
        let mut seen = vec![false; self.nodes.len()];
        let all = set.cells.iter().flat_map(|&c| self.nodes_of(c)).copied();
        all.filter(|&n| !std::mem::replace(&mut seen[n], true)).collect()
    }
}
