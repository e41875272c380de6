//! Rows of K and M, and how every dof of every node follows from them.

use crate::element::Dof;
use crate::linalg::{DMatrix, DVector};
use std::collections::BTreeMap;

/// Combination of dofs: (dof, factor), sorted by dof.
pub(super) type Combination = Vec<(usize, f64)>;

/// The independent dofs q and the map u = T q to all dofs of all nodes; it does not depend on θ.
#[derive(Debug, Clone, PartialEq)]
pub struct DofMap {
    node_names: Vec<String>,
    positions: Vec<[f64; 3]>,
    /// Row -> (node, dof).
    rows: Vec<(usize, Dof)>,
    /// 6 node + dof -> combination of rows.
    full: Vec<Combination>,
    /// Rigid motions, where the rows are not dofs of nodes.
    motions: Option<DMatrix<f64>>,
    /// Nodes that are not points but coordinates of superelements, sorted.
    coordinates: Vec<usize>,
    /// Names that nodes have beside those above.
    other_names: BTreeMap<String, usize>,
}

impl DofMap {
    pub(super) fn new(
        node_names: Vec<String>,
        positions: Vec<[f64; 3]>,
        rows: Vec<(usize, Dof)>,
        full: Vec<Combination>,
    ) -> Self {
        Self { node_names, positions, rows, full, motions: None, coordinates: Vec::new(), other_names: BTreeMap::new() }
    }

    /// With names that nodes have beside their own.
    #[must_use]
    pub(super) fn with_other_names(mut self, names: BTreeMap<String, usize>) -> Self {
        self.other_names = names;
        self
    }

    /// With the nodes that are not points but coordinates, sorted: no rigid motion moves them.
    #[must_use]
    pub(super) fn with_coordinates(mut self, coordinates: Vec<usize>) -> Self {
        self.coordinates = coordinates;
        self
    }

    /// Whether a node is not a point but a coordinate of a superelement.
    pub fn is_coordinate(&self, node: usize) -> bool {
        self.coordinates.binary_search(&node).is_ok()
    }

    /// A map for a model that is not made of nodes and elements: one row per (node, dof), no constraint.
    ///
    /// * `nodes` - name and position of each node
    /// * `rows` - (node index, dof) of each row of K and M
    pub fn from_rows(nodes: Vec<(String, [f64; 3])>, rows: Vec<(usize, Dof)>) -> Self {
        let mut full = vec![Vec::new(); 6 * nodes.len()];
        for (row, &(node, dof)) in rows.iter().enumerate() {
            full[6 * node + dof as usize] = vec![(row, 1.0)];
        }
        let (node_names, positions) = nodes.into_iter().unzip();
        Self { node_names, positions, rows, full, motions: None, coordinates: Vec::new(), other_names: BTreeMap::new() }
    }

    /// The map of a model whose rows are coefficients of vectors, q = V y; a row is named after the largest entry of its vector.
    ///
    /// * `basis` - V, (n_dof x n_rows)
    /// * `motions` - the coefficients of the rigid motions, (n_rows x 6)
    pub(super) fn on_basis(&self, basis: &DMatrix<f64>, motions: &DMatrix<f64>) -> Self {
        let on_rows = |combination: &Combination| -> Combination {
            if combination.is_empty() {
                return Vec::new();
            }
            (0..basis.ncols()).map(|j| (j, combination.iter().map(|&(i, f)| f * basis[(i, j)]).sum())).collect()
        };
        Self {
            node_names: self.node_names.clone(),
            positions: self.positions.clone(),
            rows: basis.column_iter().map(|v| self.rows[v.icamax()]).collect(),
            full: self.full.iter().map(on_rows).collect(),
            motions: Some(motions.clone()),
            coordinates: self.coordinates.clone(),
            other_names: self.other_names.clone(),
        }
    }

    /// The map of a model whose rows are coordinates of vectors and of no node.
    ///
    /// * `motions` - the coordinates of the rigid motions, (n x 6)
    pub(super) fn of_coordinates(n: usize, motions: &DMatrix<f64>) -> Self {
        let rows = vec![(0, Dof::Ux); n];
        let (node_names, positions) = (vec!["coordinates".to_string()], vec![[0.0; 3]]);
        let full = vec![Vec::new(); 6];
        Self {
            node_names,
            positions,
            rows,
            full,
            motions: Some(motions.clone()),
            coordinates: vec![0],
            other_names: BTreeMap::new(),
        }
    }

    /// Number of independent dofs: the size of K and M.
    pub fn n_dof(&self) -> usize {
        self.rows.len()
    }

    /// Number of nodes.
    pub fn n_nodes(&self) -> usize {
        self.node_names.len()
    }

    /// Names of nodes.
    pub fn node_names(&self) -> &[String] {
        &self.node_names
    }

    /// Positions of nodes, global, m.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Index of a node.
    pub fn node(&self, name: &str) -> Option<usize> {
        self.node_names.iter().position(|n| n == name).or_else(|| self.other_names.get(name).copied())
    }

    /// The (node, dof) of each row.
    pub fn rows(&self) -> &[(usize, Dof)] {
        &self.rows
    }

    /// `node.dof` of a row, for messages.
    pub fn row_name(&self, row: usize) -> String {
        let (node, dof) = self.rows[row];
        format!("{}.{dof}", self.node_names[node])
    }

    /// A dof of a node as a combination of rows; empty where it does not move.
    pub fn express(&self, node: usize, dof: Dof) -> &[(usize, f64)] {
        &self.full[6 * node + dof as usize]
    }

    /// Nodes whose dofs a node moves with.
    pub fn led_by(&self, node: usize) -> Vec<usize> {
        let rows = Dof::ALL.into_iter().flat_map(|d| self.express(node, d));
        let mut nodes: Vec<usize> = rows.map(|&(row, _)| self.rows[row].0).filter(|n| *n != node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// The displacements and rotations of all nodes that belong to q: (nodes x 6); zero where a node is a coordinate.
    pub fn expand(&self, q: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.n_nodes(), 6, |node, d| {
            if self.is_coordinate(node) {
                return 0.0;
            }
            self.full[6 * node + d].iter().map(|&(row, f)| f * q[row]).sum()
        })
    }

    /// The values of q when the structure moves as a rigid body: translations along and rotations about the global axes
    /// through the origin, (n_dof x 6).
    pub fn rigid_motions(&self) -> DMatrix<f64> {
        if let Some(motions) = &self.motions {
            return motions.clone();
        }
        DMatrix::from_fn(self.n_dof(), 6, |row, motion| {
            let (node, dof) = self.rows[row];
            if self.is_coordinate(node) {
                return 0.0;
            }
            rigid_motion(self.positions[node], motion)[dof as usize]
        })
    }
}

/// Displacements and rotations at a point for a unit rigid motion: 0..3 translations, 3..6 rotations about the origin.
pub fn rigid_motion(at: [f64; 3], motion: usize) -> [f64; 6] {
    let mut u = [0.0; 6];
    u[motion] = 1.0;
    if motion >= 3 {
        let mut axis = [0.0; 3];
        axis[motion - 3] = 1.0;
        u[..3].copy_from_slice(&super::geometry::cross(axis, at));
    }
    u
}
