//! How the dofs of an element follow from the rows of a model.

use super::dof_map::DofMap;
use super::entry::Entry;
use super::placed_element::PlacedElement;
use crate::element::Dof;
use crate::linalg::{DMatrix, SymMatrix};

/// How an element's dofs follow from the rows: u_e = B q\[rows\], (6 nodes x rows), in its axes.
///
/// B is mostly zero, and a mesh has one of each element: only what is not zero is kept, dof by dof.
#[derive(Debug, Clone)]
pub struct Connection {
    /// The rows, ascending but for those of new coordinates.
    pub rows: Vec<usize>,
    /// Where each dof of the element ends in `terms`.
    ends: Vec<u32>,
    /// Column of B and factor.
    terms: Vec<(u32, f64)>,
}

impl Connection {
    pub(super) fn new(element: &PlacedElement, dofs: &DofMap) -> Self {
        let mut rows: Vec<usize> = element
            .nodes
            .iter()
            .flat_map(|&node| Dof::ALL.into_iter().flat_map(move |d| dofs.express(node, d).iter().map(|t| t.0)))
            .collect();
        rows.sort_unstable();
        rows.dedup();
        let b = motion_in_axes(element, rows.len(), |node, dof| dofs.express(node, dof), |row| place(&rows, row));
        Self::of(rows, &b)
    }

    /// By a full B.
    pub(super) fn of(rows: Vec<usize>, b: &DMatrix<f64>) -> Self {
        let (mut ends, mut terms) = (Vec::with_capacity(b.nrows()), Vec::new());
        for dof in b.row_iter() {
            terms.extend((0..).zip(dof.iter().copied()).filter(|t| t.1 != 0.0));
            ends.push(terms.len() as u32);
        }
        terms.shrink_to_fit();
        Self { rows, ends, terms }
    }

    /// Some rows themselves.
    pub(super) fn unit(rows: Vec<usize>) -> Self {
        let n = rows.len() as u32;
        Self { rows, ends: (1..=n).collect(), terms: (0..n).map(|i| (i, 1.0)).collect() }
    }

    /// Number of dofs of the element.
    pub fn n_dof(&self) -> usize {
        self.ends.len()
    }

    /// What is not zero in a row of B: (column, value).
    pub fn terms(&self, dof: usize) -> &[(u32, f64)] {
        let from = if dof == 0 { 0 } else { self.ends[dof - 1] as usize };
        &self.terms[from..self.ends[dof] as usize]
    }

    /// B in full.
    pub fn b(&self) -> DMatrix<f64> {
        let mut b = DMatrix::zeros(self.n_dof(), self.rows.len());
        for dof in 0..self.n_dof() {
            for &(column, value) in self.terms(dof) {
                b[(dof, column as usize)] = value;
            }
        }
        b
    }

    /// B x.
    ///
    /// * `x` - (rows x any number)
    pub fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(self.n_dof(), x.ncols(), |dof, k| {
            self.terms(dof).iter().map(|&(column, value)| value * x[(column as usize, k)]).sum()
        })
    }

    /// Bᵀ f.
    ///
    /// * `f` - (dofs of the element x any number)
    pub fn tr_times(&self, f: &DMatrix<f64>) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(self.rows.len(), f.ncols());
        for (from, mut to) in f.column_iter().zip(out.column_iter_mut()) {
            for dof in 0..self.n_dof() {
                self.terms(dof).iter().for_each(|&(column, value)| to[column as usize] += value * from[dof]);
            }
        }
        out
    }

    /// Bᵀ a B on the rows.
    pub fn reduce(&self, a: &SymMatrix) -> DMatrix<f64> {
        self.reduce_of(a, |i| i, a.n())
    }

    /// The same of a matrix on some dofs of the element alone.
    pub(super) fn reduce_on(&self, dofs: &[u16], a: &SymMatrix) -> DMatrix<f64> {
        self.reduce_of(a, |i| usize::from(dofs[i]), dofs.len())
    }

    fn reduce_of(&self, a: &SymMatrix, dof: impl Fn(usize) -> usize, n: usize) -> DMatrix<f64> {
        // B as it is on the dofs of a, transposed: a column of it is what one dof is made of.
        let mut half = DMatrix::zeros(self.rows.len(), n);
        for (i, mut column) in half.column_iter_mut().enumerate() {
            for j in 0..n {
                let value = a.get(i, j);
                if value != 0.0 {
                    self.terms(dof(j)).iter().for_each(|&(c, factor)| column[c as usize] += factor * value);
                }
            }
        }
        let mut out = DMatrix::zeros(self.rows.len(), self.rows.len());
        for (i, column) in half.column_iter().enumerate() {
            for &(c, factor) in self.terms(dof(i)) {
                out.column_mut(c as usize).axpy(factor, &column, 1.0);
            }
        }
        out
    }

    /// Whether a row of a B is not zero up to rounding: the dofs of the element that some motion of the structure loads.
    pub(crate) fn loads(&self, a: &SymMatrix) -> Vec<bool> {
        let (mut force, mut size) = (vec![0.0; self.rows.len()], vec![0.0; self.rows.len()]);
        let is_loaded = |i: usize| {
            force.fill(0.0);
            size.fill(0.0);
            for j in 0..a.n() {
                let value: f64 = a.get(i, j);
                for &(column, factor) in self.terms(j) {
                    force[column as usize] += value * factor;
                    size[column as usize] += (value * factor).abs();
                }
            }
            force.iter().zip(&size).any(|(f, s)| *s > 0.0 && f.abs() > 1e-9 * s)
        };
        (0..a.n()).map(is_loaded).collect()
    }

    /// The lower triangle of a symmetric matrix on the rows, the mean of what rounding has made two.
    pub(super) fn entries<'a>(&'a self, reduced: &'a DMatrix<f64>) -> impl Iterator<Item = Entry> + Clone + 'a {
        let lower = self
            .rows
            .iter()
            .enumerate()
            .flat_map(|(i, &row)| self.rows[..=i].iter().enumerate().map(move |(j, &column)| (i, row, j, column)));
        lower.map(|(i, row, j, column)| Entry::new(row, column, 0.5 * (reduced[(i, j)] + reduced[(j, i)])))
    }
}

/// How the dofs of an element follow from some coordinates, (6 nodes x coordinates), in its axes.
///
/// * `terms` - a dof of a node as a sum of coordinates: (coordinate, factor)
/// * `column` - where a coordinate stands
pub(super) fn motion_in_axes<'a>(
    element: &PlacedElement,
    n_columns: usize,
    terms: impl Fn(usize, Dof) -> &'a [(usize, f64)],
    column: impl Fn(usize) -> usize,
) -> DMatrix<f64> {
    let mut b = DMatrix::zeros(6 * element.nodes.len(), n_columns);
    for (k, &node) in element.nodes.iter().enumerate() {
        let arm = element.arm(k);
        for i in 0..6 {
            for global in 0..3 {
                let direction = element.axes[i % 3][global];
                for &(coordinate, factor) in terms(node, Dof::ALL[global + 3 * (i / 3)]) {
                    b[(6 * k + i, column(coordinate))] += direction * factor;
                }
                // The end of an arm r moves by u + θ × r.
                for (turn, lever) in turns(global, arm).into_iter().filter(|t| i < 3 && t.1 != 0.0) {
                    for &(coordinate, factor) in terms(node, turn) {
                        b[(6 * k + i, column(coordinate))] += direction * lever * factor;
                    }
                }
            }
        }
    }
    b
}

/// The rotations that move the end of an arm along a global axis, with their levers: (θ × r) of that axis.
pub(super) fn turns(axis: usize, arm: [f64; 3]) -> [(Dof, f64); 2] {
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    [(Dof::ALL[3 + next], arm[last]), (Dof::ALL[3 + last], -arm[next])]
}

/// Where a row stands among sorted ones.
pub(super) fn place(rows: &[usize], row: usize) -> usize {
    rows.partition_point(|r| *r < row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// What is kept of B gives the products of the full one.
    #[test]
    fn products_are_those_of_the_full_matrix() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let b = DMatrix::from_fn(6, 4, |_, _| if rng.random_bool(0.4) { rng.random_range(-1.0..1.0) } else { 0.0 });
        let connection = Connection::of(vec![3, 5, 8, 9], &b);
        assert_eq!(connection.b(), b);
        let mut random = |n: usize, m: usize| DMatrix::from_fn(n, m, |_, _| rng.random_range(-1.0..1.0));
        let (x, f, square) = (random(4, 3), random(6, 2), random(6, 6));
        assert!((connection.times(&x) - &b * &x).amax() < 1e-14);
        assert!((connection.tr_times(&f) - b.tr_mul(&f)).amax() < 1e-14);
        let a = SymMatrix::from_dense(&square);
        let full = b.tr_mul(&(a.to_dense() * &b));
        assert!((connection.reduce(&a) - &full).amax() < 1e-14);
        // On some of the dofs, zero elsewhere.
        let some = [1_u16, 2, 4];
        let part = SymMatrix::from_dense(&DMatrix::from_fn(3, 3, |i, j| a.get(some[i].into(), some[j].into())));
        let wide = DMatrix::from_fn(6, 6, |i, j| {
            let at = |d: usize| some.iter().position(|s| usize::from(*s) == d);
            at(i).zip(at(j)).map_or(0.0, |(i, j)| part.get(i, j))
        });
        assert!((connection.reduce_on(&some, &part) - b.tr_mul(&(wide * &b))).amax() < 1e-14);
        assert_eq!(Connection::unit(vec![2, 7]).b(), DMatrix::identity(2, 2));
    }
}
