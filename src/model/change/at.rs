//! A change at one point: what it adds to forces.

use super::factored::Factored;
use crate::linalg::{DMatrix, SymMatrix};
use crate::model::ElementMatrices;
use crate::model::connection::{Connection, place};

/// A change at one point.
#[derive(Debug)]
pub struct ChangeAt<'a> {
    rows: Vec<usize>,
    n_old: usize,
    parts: Vec<PartAt<'a>>,
}

/// One of its parts.
#[derive(Debug)]
pub(super) enum PartAt<'a> {
    Element { connection: &'a Connection, own: ElementMatrices },
    Factored { part: &'a Factored, factors: [f64; 2] },
}

impl<'a> ChangeAt<'a> {
    /// * `rows` - all that it touches, ascending, new coordinates last
    /// * `n_dof` - rows of the model
    pub(super) fn new(rows: Vec<usize>, n_dof: usize, parts: Vec<PartAt<'a>>) -> Self {
        let n_old = rows.partition_point(|row| *row < n_dof);
        Self { rows, n_old, parts }
    }

    /// Rows of the model that it touches, ascending, with its new coordinates behind them.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Rows of the model that it touches, ascending.
    pub fn old_rows(&self) -> &[usize] {
        &self.rows[..self.n_old]
    }

    /// Whether it changes K or M there.
    pub fn acts(&self) -> bool {
        self.parts.iter().any(|part| match part {
            PartAt::Element { own, .. } => !(own.stiffness.is_zero() && own.mass.is_zero()),
            PartAt::Factored { part, factors } => part.acts(*factors),
        })
    }

    /// ΔK x and ΔM x on its rows; `None` where it has none.
    ///
    /// * `x` - motions of its rows, (rows x any number)
    pub fn times(&self, x: &DMatrix<f64>) -> [Option<DMatrix<f64>>; 2] {
        self.sums(x, PartAt::times)
    }

    /// ΔC x on its rows; `None` where it has none. Superelements damp nothing here.
    ///
    /// * `x` - motions of its rows, (rows x any number)
    pub fn damping_times(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let [sum] = self.sums(x, |part, x| [part.damping_times(x)]);
        sum
    }

    fn sums<const N: usize>(
        &self,
        x: &DMatrix<f64>,
        of: impl Fn(&PartAt<'a>, &DMatrix<f64>) -> [Option<DMatrix<f64>>; N],
    ) -> [Option<DMatrix<f64>>; N] {
        let mut sums = [const { None }; N];
        for part in &self.parts {
            let rows = part.rows();
            let places: Vec<usize> = rows.iter().map(|&row| place(&self.rows, row)).collect();
            let own = x.select_rows(&places);
            for (sum, force) in sums.iter_mut().zip(of(part, &own)) {
                let Some(force) = force else { continue };
                let sum = sum.get_or_insert_with(|| DMatrix::zeros(self.rows.len(), x.ncols()));
                for (mut to, from) in sum.column_iter_mut().zip(force.column_iter()) {
                    places.iter().zip(from.iter()).for_each(|(&i, f)| to[i] += f);
                }
            }
        }
        sums
    }
}

impl PartAt<'_> {
    fn rows(&self) -> &[usize] {
        match self {
            PartAt::Element { connection, .. } => &connection.rows,
            PartAt::Factored { part, .. } => part.of.rows(),
        }
    }

    /// ΔK x and ΔM x on its rows.
    fn times(&self, x: &DMatrix<f64>) -> [Option<DMatrix<f64>>; 2] {
        match self {
            PartAt::Factored { part, factors } => part.times(*factors, x),
            PartAt::Element { connection, own } => {
                let local = connection.times(x);
                let on_rows = |a: &SymMatrix| connection.tr_times(&(a.to_dense() * &local));
                [&own.stiffness, &own.mass].map(|a| (!a.is_zero()).then(|| on_rows(a)))
            }
        }
    }

    /// ΔC x on its rows.
    fn damping_times(&self, x: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let PartAt::Element { connection, own } = self else { return None };
        let force = || connection.tr_times(&(own.damping.to_dense() * connection.times(x)));
        (!own.damping.is_zero()).then(force)
    }
}
