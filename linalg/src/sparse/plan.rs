//! What the pattern of a pencil decides once for all its values: elimination order and structure of the factor.

use super::factor::Structure;
use super::matrix::SparseSym;
use crate::{DMatrix, LinalgError};

/// Elimination order and structure of the factor of K + aM, for every K and M whose entries lie within one pattern.
///
/// The order is approximate minimum degree on the graph of nodes: the dofs of a node are neighbours of the same dofs and
/// are eliminated together, so the graph is smaller by the square of the dofs a node has.
///
/// # Source
/// P. R. Amestoy, T. A. Davis, I. S. Duff, An approximate minimum degree ordering algorithm, SIAM J. Matrix Anal. Appl.
/// 17(4), 1996; the structure and the numerical factorisation are faer's supernodal Cholesky.
#[derive(Debug)]
pub struct SparsePlan {
    /// Row of the pencil that stands at each place of the elimination order.
    pub(super) order: Vec<usize>,
    /// Place of each row in the elimination order.
    pub(super) place: Vec<usize>,
    /// K's and M's common pattern in the elimination order, with values zero.
    pattern: SparseSym,
    pub(super) structure: Structure,
}

/// K and M in the elimination order, on their common pattern.
#[derive(Debug)]
pub(super) struct Ordered {
    pub(super) stiffness: SparseSym,
    pub(super) mass: SparseSym,
}

impl Ordered {
    /// K + aM.
    pub(super) fn shifted(&self, shift: f64) -> SparseSym {
        let mut out = self.stiffness.clone();
        for (value, mass) in out.values.iter_mut().zip(&self.mass.values) {
            *value += shift * mass;
        }
        out
    }
}

impl SparsePlan {
    /// Orders and analyses the pattern of a pencil.
    ///
    /// * `k`, `m` - symmetric (n x n); only where they have entries matters
    /// * `node` - which node each row belongs to, any numbering (n)
    ///
    /// # Errors
    /// [`LinalgError::OutOfMemory`] if the structure of the factor does not fit.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn new(k: &SparseSym, m: &SparseSym, node: &[usize]) -> Result<Self, LinalgError> {
        let n = k.n();
        assert!(m.n() == n && node.len() == n, "matrices of one size and a node for every row");
        let order = nodal_order(k, m, node)?;
        let mut place = vec![0; n];
        for (at, &row) in order.iter().enumerate() {
            place[row] = at;
        }
        let places = k.entries().chain(m.entries()).map(|(i, j, _)| (place[i], place[j], 0.0));
        let pattern = SparseSym::from_triplets(n, places);
        let structure = Structure::new(&pattern)?;
        Ok(Self { order, place, pattern, structure })
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.order.len()
    }

    /// Number of values of the factor, its explicit zeros included; each takes 8 bytes.
    pub fn factor_len(&self) -> usize {
        self.structure.len()
    }

    /// K and M in the elimination order.
    ///
    /// # Panics
    /// If one has an entry outside the pattern.
    pub(super) fn pencil(&self, k: &SparseSym, m: &SparseSym) -> Ordered {
        Ordered { stiffness: self.ordered(k), mass: self.ordered(m) }
    }

    /// A matrix in the elimination order.
    ///
    /// # Panics
    /// If it has an entry outside the pattern.
    pub(super) fn ordered(&self, a: &SparseSym) -> SparseSym {
        let mut out = self.pattern.clone();
        for (i, j, value) in a.entries() {
            let (i, j) = (self.place[i], self.place[j]);
            let (row, column) = (i.max(j), i.min(j));
            let (start, end) = (out.columns[column], out.columns[column + 1]);
            let at = out.rows[start..end].binary_search(&row);
            out.values[start + at.expect("an entry of the pattern the plan was made for")] += value;
        }
        out
    }

    /// Rows in the elimination order.
    pub(super) fn ordered_rows(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.n(), x.ncols(), |i, j| x[(self.order[i], j)])
    }

    /// Rows in their own order, from those in the elimination order.
    pub(super) fn restored_rows(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.n(), x.ncols(), |i, j| x[(self.place[i], j)])
    }

    /// Whether every entry of `a` lies within the pattern.
    pub fn covers(&self, a: &SparseSym) -> bool {
        a.n() == self.n()
            && a.entries().all(|(i, j, _)| {
                let (i, j) = (self.place[i], self.place[j]);
                let column = i.min(j);
                let range = self.pattern.columns[column]..self.pattern.columns[column + 1];
                self.pattern.rows[range].binary_search(&i.max(j)).is_ok()
            })
    }
}

/// Rows in the order of elimination: nodes by minimum degree, the rows of a node one after the other.
fn nodal_order(k: &SparseSym, m: &SparseSym, node: &[usize]) -> Result<Vec<usize>, LinalgError> {
    // Nodes numbered by first appearance.
    let mut number = std::collections::HashMap::new();
    let mut members: Vec<Vec<usize>> = Vec::new();
    let mut of_row = Vec::with_capacity(node.len());
    for (row, name) in node.iter().enumerate() {
        let id = *number.entry(*name).or_insert(members.len());
        if id == members.len() {
            members.push(Vec::new());
        }
        members[id].push(row);
        of_row.push(id);
    }
    let n = members.len();
    let mut edges: Vec<(usize, usize)> = k
        .entries()
        .chain(m.entries())
        .map(|(i, j, _)| (of_row[i].min(of_row[j]), of_row[i].max(of_row[j])))
        .filter(|(a, b)| a != b)
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let graph = SparseSym::from_triplets(n, edges.into_iter().map(|(a, b)| (a, b, 0.0)));
    let order = super::factor::minimum_degree(&graph)?;
    Ok(order.into_iter().flat_map(|node| members[node].iter().copied()).collect())
}
