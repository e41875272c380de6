//! Supernodal Cholesky and LDLᵀ factors; the only file of this folder that names faer.

use super::kernel::{Row, Supernodes, WIDTH, solve};
use super::matrix::SparseSym;
use crate::{DMatrix, LinalgError};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::prelude::default;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Par, Side};

/// Sequential, so that bits do not depend on the number of threads; callers run several solutions at once.
const SEQUENTIAL: Par = Par::Seq;

impl From<FaerError> for LinalgError {
    fn from(_: FaerError) -> Self {
        Self::OutOfMemory
    }
}

fn memory(request: StackReq) -> Result<MemBuffer, LinalgError> {
    MemBuffer::try_new(request).map_err(|_| LinalgError::OutOfMemory)
}

/// The upper triangle's pattern, by columns: the transpose of the lower one.
fn transposed(a: &SparseSym) -> (Vec<usize>, Vec<usize>) {
    let n = a.n();
    let mut columns = vec![0; n + 1];
    for &i in &a.rows {
        columns[i + 1] += 1;
    }
    for i in 0..n {
        columns[i + 1] += columns[i];
    }
    let mut next = columns.clone();
    let mut rows = vec![0; a.rows.len()];
    for j in 0..n {
        for &i in &a.rows[a.columns[j]..a.columns[j + 1]] {
            rows[next[i]] = j;
            next[i] += 1;
        }
    }
    (columns, rows)
}

/// Nodes of a graph in the order of approximate minimum degree.
pub(super) fn minimum_degree(graph: &SparseSym) -> Result<Vec<usize>, LinalgError> {
    let n = graph.n();
    let (columns, rows) = transposed(graph);
    let (mut order, mut place) = (vec![0; n], vec![0; n]);
    let mut buffer = memory(amd::order_scratch::<usize>(n, rows.len()))?;
    let upper = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
    amd::order(&mut order, &mut place, upper, amd::Control::default(), MemStack::new(&mut buffer))?;
    Ok(order)
}

/// Which values a factor has.
#[derive(Debug)]
pub(super) struct Structure(SymbolicCholesky<usize>);

impl Structure {
    /// Of a matrix in its elimination order.
    pub(super) fn new(pattern: &SparseSym) -> Result<Self, LinalgError> {
        let n = pattern.n();
        let (columns, rows) = transposed(pattern);
        let upper = SymbolicSparseColMatRef::new_checked(n, n, &columns, None, &rows);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        Ok(Self(factorize_symbolic_cholesky(upper, Side::Upper, SymmetricOrdering::Identity, params)?))
    }

    /// Number of values.
    pub(super) fn len(&self) -> usize {
        self.0.len_val()
    }

    fn supernodal(&self) -> &SymbolicSupernodalCholesky<usize> {
        match self.0.raw() {
            SymbolicCholeskyRaw::Supernodal(s) => s,
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("a supernodal structure was asked for"),
        }
    }

    /// Values for a factor, to be passed to [`Self::cholesky`] or [`Self::indefinite`].
    pub(super) fn values(&self) -> Result<Vec<f64>, LinalgError> {
        let mut values = Vec::new();
        values.try_reserve_exact(self.len()).map_err(|_| LinalgError::OutOfMemory)?;
        values.resize(self.len(), 0.0);
        Ok(values)
    }

    /// L with a = L Lᵀ; the error is the place of the first pivot that is not positive.
    pub(super) fn cholesky(&self, a: &SparseSym, mut values: Vec<f64>) -> Result<Factor<'_>, FactorError> {
        let mut buffer = memory(self.0.factorize_numeric_llt_scratch::<f64>(SEQUENTIAL, default()))?;
        self.0
            .factorize_numeric_llt(
                &mut values,
                matrix(a),
                Side::Lower,
                default(),
                SEQUENTIAL,
                MemStack::new(&mut buffer),
                default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| FactorError::Pivot(index))?;
        Ok(Factor { structure: self, values, work: self.work() })
    }

    /// Room for [`Self::solve`].
    pub(super) fn work(&self) -> Vec<Row> {
        let longest = self.supernodal().nnz_per_super().iter().copied().max().unwrap_or(0);
        vec![[0.0; WIDTH]; longest]
    }

    /// a⁻¹ X with the values of a Cholesky factor, overwriting X.
    pub(super) fn solve(&self, values: &[f64], x: &mut [Row], work: &mut [Row]) {
        let s = self.supernodal();
        let supernodes = Supernodes {
            begin: s.supernode_begin(),
            end: s.supernode_end(),
            row_start: s.col_ptr_for_row_idx(),
            row_count: s.nnz_per_super(),
            rows: s.row_idx(),
            value_start: s.col_ptr_for_val(),
            values,
        };
        solve(&supernodes, x, work);
    }

    /// L, B with a = L B Lᵀ for an `a` that may be indefinite.
    ///
    /// The pivots are chosen within each supernode (Bunch and Kaufman), so they are blocks of one or two rows.
    pub(super) fn indefinite(&self, a: &SparseSym, mut values: Vec<f64>) -> Result<Indefinite<'_>, LinalgError> {
        let n = a.n();
        let mut subdiagonal = vec![0.0; n];
        let (mut forward, mut inverse) = (vec![0; n], vec![0; n]);
        let mut buffer = memory(self.0.factorize_numeric_intranode_lblt_scratch::<f64>(SEQUENTIAL, default()))?;
        self.0.factorize_numeric_intranode_lblt(
            &mut values,
            &mut subdiagonal,
            &mut forward,
            &mut inverse,
            matrix(a),
            Side::Lower,
            SEQUENTIAL,
            MemStack::new(&mut buffer),
            default(),
        );
        Ok(Indefinite { structure: self, values, subdiagonal, forward, inverse })
    }
}

/// a = L B Lᵀ, B with blocks of one or two rows.
#[derive(Debug)]
pub(super) struct Indefinite<'a> {
    structure: &'a Structure,
    values: Vec<f64>,
    subdiagonal: Vec<f64>,
    forward: Vec<usize>,
    inverse: Vec<usize>,
}

impl Indefinite<'_> {
    /// Number of negative eigenvalues of a, by Sylvester's law of inertia; `None` if a pivot is not a number.
    pub(super) fn negative(&self) -> Option<usize> {
        let s = self.structure.supernodal();
        let mut negative = 0;
        for node in 0..s.n_supernodes() {
            let (first, end) = (s.supernode_begin()[node], s.supernode_end()[node]);
            let height = end - first + s.nnz_per_super()[node];
            let at = s.col_ptr_for_val()[node];
            let pivot = |j: usize| self.values[at + (j - first) * (height + 1)];
            let mut j = first;
            while j < end {
                let (p, q) = (pivot(j), self.subdiagonal[j]);
                if q == 0.0 {
                    if !p.is_finite() {
                        return None;
                    }
                    negative += usize::from(p < 0.0);
                    j += 1;
                } else {
                    // Two rows with a negative determinant have one eigenvalue of each sign.
                    let determinant = p * pivot(j + 1) - q * q;
                    if !determinant.is_finite() {
                        return None;
                    }
                    negative += if determinant < 0.0 { 1 } else { 2 * usize::from(p < 0.0) };
                    j += 2;
                }
            }
        }
        Some(negative)
    }

    /// a⁻¹ X, overwriting X.
    pub(super) fn solve(&self, x: &mut DMatrix<f64>) -> Result<(), LinalgError> {
        let (n, count) = x.shape();
        let pivots = faer::perm::PermRef::new_checked(&self.forward, &self.inverse, n);
        let factor = IntranodeLbltRef::new(&self.structure.0, &self.values, &self.subdiagonal, pivots);
        let mut buffer = memory(self.structure.0.solve_in_place_scratch::<f64>(count, SEQUENTIAL))?;
        factor.solve_in_place_with_conj(
            faer::Conj::No,
            faer::MatMut::from_column_major_slice_mut(x.as_mut_slice(), n, count),
            SEQUENTIAL,
            MemStack::new(&mut buffer),
        );
        Ok(())
    }

    /// The memory of its values, for the next factor.
    pub(super) fn into_values(self) -> Vec<f64> {
        self.values
    }
}

fn matrix(a: &SparseSym) -> SparseColMatRef<'_, usize, f64> {
    let n = a.n();
    SparseColMatRef::new(SymbolicSparseColMatRef::new_checked(n, n, &a.columns, None, &a.rows), &a.values)
}

/// Why there is no Cholesky factor.
#[derive(Debug)]
pub(super) enum FactorError {
    /// The pivot at this place is not positive.
    Pivot(usize),
    /// No memory.
    Memory,
}

impl From<LinalgError> for FactorError {
    fn from(_: LinalgError) -> Self {
        Self::Memory
    }
}

/// a = L Lᵀ.
#[derive(Debug)]
pub(super) struct Factor<'a> {
    structure: &'a Structure,
    values: Vec<f64>,
    work: Vec<Row>,
}

impl Factor<'_> {
    /// a⁻¹ X, overwriting X.
    pub(super) fn solve(&mut self, x: &mut [Row]) {
        self.structure.solve(&self.values, x, &mut self.work);
    }

    /// The memory of its values, for the next factor.
    pub(super) fn into_values(self) -> Vec<f64> {
        self.values
    }
}
