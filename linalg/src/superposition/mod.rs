//! Frequency responses by superposition over all vectors of the pencil, and their derivatives.
//!
//! ```text
//! Xᵀ (K + σM) X = I,   Xᵀ M X = diag(θ)                              all vectors: exact, massless dofs and rigid bodies included
//! Z = K (1 + iη) + iωC - ω²M,   C = αM + βK + W Γ Wᵀ
//! Xᵀ (Z - iω W Γ Wᵀ) X = diag(a - cθ),   a = 1 + iη + iωβ,   c = aσ + ω² - iωα,   g_k = 1/(a - cθ_k)
//! H = S Z⁻¹ Bᵀ = Σ_k g_k (S x_k)(B x_k)ᵀ                             without W; with it by Woodbury's formula
//! ```
//!
//! The derivative of a response is a sum over pairs of vectors. Partial fractions make it one over vectors:
//!
//! ```text
//! ∂H = -Σ_km s_k b_m (a A'_km - c M'_km + iω C'_km) g_k g_m          A' = Xᵀ(∂K + σ∂M)X,  M' = Xᵀ∂M X,  C' = Xᵀ(∂C - α∂M - β∂K)X
//! a g_k g_m = (θ_k g_k - θ_m g_m)/(θ_k - θ_m),   c g_k g_m = (g_k - g_m)/(θ_k - θ_m)
//! ```
//!
//! so that a line takes as many products as there are vectors, whatever the parameter does. Vectors so close that the fractions would lose digits
//! keep their products; all vectors without mass have one g.
//!
//! # Source
//! D. J. Ewins, Modal Testing, 2nd ed., 2000, sections 2.4 to 2.7, over the vectors of a shifted pencil; W. W. Hager, Updating the inverse of a
//! matrix, SIAM Review 31(2), 1989.

mod damping;

use crate::{Complex, DMatrix, ShiftedPencil};
use damping::Damping;
use std::f64::consts::TAU;

/// Vectors whose θ differ by a smaller share are close.
const CLOSE: f64 = 1e-6;
/// Multiplications of a decomposition, over n³, as many as take the time of it.
const DECOMPOSITION: f64 = 30.0;
/// Share of the largest θ below which a vector has no mass.
const MASSLESS: f64 = 1e-14;

/// What a parameter changes in the matrices, entry by entry, both triangles.
#[derive(Debug, Clone, Default)]
pub struct EntrySlopes {
    /// Rows with an entry.
    pub rows: Vec<usize>,
    /// Number among these rows, column, ∂K, ∂C and ∂M.
    pub list: Vec<(usize, usize, [f64; 3])>,
    /// ∂η.
    pub loss_factor: f64,
}

/// The responses of a structure at the lines of a test.
#[derive(Debug)]
pub struct Superposition<'a> {
    basis: &'a ShiftedPencil,
    /// Xᵀ: what a dof has of every vector, as columns.
    of_dofs: DMatrix<f64>,
    /// From here on vectors have no mass.
    massless: usize,
    close: Vec<(usize, usize)>,
    damping: Damping,
    lines: Vec<Line>,
    /// X̂ᵀ of the responses and dashpots, and of the references and dashpots, (n x any number).
    loads: [DMatrix<f64>; 2],
    /// Numbers of responses and references.
    shape: [usize; 2],
    /// What dashpots do at a line to the loads of responses and references, (n_dashpots x n) each; empty without them.
    coupled: Vec<[DMatrix<Complex<f64>>; 2]>,
    values: Vec<Complex<f64>>,
}

/// A line: ω, a and c.
#[derive(Debug, Clone, Copy)]
struct Line {
    omega: f64,
    a: Complex<f64>,
    c: Complex<f64>,
}

impl Line {
    fn g(&self, theta: f64) -> Complex<f64> {
        (self.a - self.c * theta).inv()
    }

    fn i_omega(&self) -> Complex<f64> {
        Complex::new(0.0, self.omega)
    }
}

impl<'a> Superposition<'a> {
    /// Multiplications that a sweep takes: beside them nothing counts on a large one.
    ///
    /// * `functions` - responses times references
    /// * `is_known` - whether the vectors are
    pub fn multiplications(n: usize, lines: usize, functions: usize, is_known: bool) -> f64 {
        let (n, all) = (n as f64, (lines * functions) as f64);
        2.0 * n * all + if is_known { 0.0 } else { DECOMPOSITION * n.powi(3) }
    }

    /// Solves for the responses at all lines; `None` where dashpots hold more than 48 dofs, or are more than a dozen.
    ///
    /// * `basis` - all vectors of K and M, (n)
    /// * `matrices` - K, M and C, (n x n)
    /// * `rows` - of the responses and of the references, (any number x n)
    ///
    /// # Panics
    /// If sizes differ.
    pub fn new(
        basis: &'a ShiftedPencil,
        matrices: (&DMatrix<f64>, &DMatrix<f64>, Option<&DMatrix<f64>>),
        rows: [&DMatrix<f64>; 2],
        lines_hz: &[f64],
        loss_factor: f64,
    ) -> Option<Self> {
        let n = basis.theta.len();
        assert!(rows.iter().all(|r| r.ncols() == n), "rows of the model");
        let (k, m, c) = matrices;
        let damping = Damping::split(k, m, c)?;
        let of = |hz: &f64| {
            let omega = TAU * hz;
            let a = Complex::new(1.0, loss_factor + omega * damping.by_stiffness);
            let c = a * basis.shift + Complex::new(omega * omega, -omega * damping.by_mass);
            Line { omega, a, c }
        };
        let massless = basis.theta.iter().position(|t| *t <= MASSLESS * basis.theta[0]).unwrap_or(n);
        // θ descends.
        let is_close = |&(i, j): &(usize, usize)| basis.theta[i] - basis.theta[j] <= CLOSE * basis.theta[i];
        let close = (0..massless).flat_map(|i| (i + 1..massless).map(move |j| (i, j)).take_while(is_close)).collect();
        let of_dashpots = basis.vectors.tr_mul(&damping.vectors);
        let loads = rows.map(|rows| {
            let own = basis.vectors.tr_mul(&rows.transpose());
            let mut all = DMatrix::zeros(n, own.ncols() + of_dashpots.ncols());
            all.columns_mut(0, own.ncols()).copy_from(&own);
            all.columns_mut(own.ncols(), of_dashpots.ncols()).copy_from(&of_dashpots);
            all
        });
        let mut all = Self {
            of_dofs: basis.vectors.transpose(),
            basis,
            massless,
            close,
            lines: lines_hz.iter().map(of).collect(),
            shape: rows.map(DMatrix::nrows),
            loads,
            damping,
            coupled: Vec::new(),
            values: Vec::new(),
        };
        all.solve();
        Some(all)
    }

    /// H without powers of iω: response by response, then reference by reference, then line by line.
    pub fn responses(&self) -> &[Complex<f64>] {
        &self.values
    }

    /// ∂H of a parameter, as [`Self::responses`].
    pub fn derivative(&self, of: &EntrySlopes) -> Vec<Complex<f64>> {
        let mut sums = DMatrix::zeros(2 * self.lines.len(), self.loads[0].ncols() * self.loads[1].ncols());
        self.add_pairs(of, &mut sums);
        if of.loss_factor != 0.0 {
            let [rows, references] = &self.loads;
            let sigma = self.basis.shift;
            let share = |k: usize, i: usize, j: usize| {
                -rows[(k, i)] * references[(k, j)] * of.loss_factor * (1.0 - sigma * self.theta(k))
            };
            let columns = self.columns(|_, g| Complex::new(0.0, 1.0) * g * g);
            add(&columns, &self.coefficients(share), &mut sums);
        }
        self.seen(&sums, |at, extended| {
            let [u, v] = &self.coupled[at.0];
            let [s, b] = self.shape;
            let dashpots = self.damping.values.len();
            let (i, j) = at.1;
            let mut sum = extended(i, j);
            for p in 0..dashpots {
                sum -= u[(p, i)] * extended(s + p, j) + extended(i, b + p) * v[(p, j)];
                for q in 0..dashpots {
                    sum += u[(p, i)] * extended(s + p, b + q) * v[(q, j)];
                }
            }
            sum
        })
    }

    /// θ, zero of a vector without mass.
    fn theta(&self, k: usize) -> f64 {
        if k < self.massless { self.basis.theta[k] } else { 0.0 }
    }

    /// Columns of a quantity of lines and vectors, real parts above imaginary ones; one for all vectors without mass.
    fn columns(&self, value: impl Fn(&Line, Complex<f64>) -> Complex<f64>) -> DMatrix<f64> {
        let (lines, n) = (self.lines.len(), self.basis.theta.len());
        let mut out = DMatrix::zeros(2 * lines, self.massless + usize::from(self.massless < n));
        for (k, mut column) in out.column_iter_mut().enumerate() {
            let theta = self.theta(k);
            for (l, line) in self.lines.iter().enumerate() {
                let v = value(line, line.g(theta));
                (column[l], column[lines + l]) = (v.re, v.im);
            }
        }
        out
    }

    /// Values of the functions by sums over the loads of them and of the dashpots.
    ///
    /// * `coupled` - of a line and a function, where there are dashpots
    fn seen(
        &self,
        sums: &DMatrix<f64>,
        coupled: impl Fn((usize, (usize, usize)), &dyn Fn(usize, usize) -> Complex<f64>) -> Complex<f64>,
    ) -> Vec<Complex<f64>> {
        let (lines, [responses, references]) = (self.lines.len(), self.shape);
        let n_rows = self.loads[0].ncols();
        let mut out = Vec::with_capacity(lines * responses * references);
        for l in 0..lines {
            let extended = |i: usize, j: usize| {
                let f = j * n_rows + i;
                Complex::new(sums[(l, f)], sums[(lines + l, f)])
            };
            for j in 0..references {
                for i in 0..responses {
                    let is_free = self.coupled.is_empty();
                    out.push(if is_free { extended(i, j) } else { coupled((l, (i, j)), &extended) });
                }
            }
        }
        out
    }

    fn solve(&mut self) {
        let [rows, references] = &self.loads;
        let mut sums = DMatrix::zeros(2 * self.lines.len(), self.loads[0].ncols() * self.loads[1].ncols());
        add(&self.columns(|_, g| g), &self.coefficients(|k, i, j| rows[(k, i)] * references[(k, j)]), &mut sums);
        let (lines, [s, b]) = (self.lines.len(), self.shape);
        let n_rows = self.loads[0].ncols();
        let dashpots = self.damping.values.len();
        let at = |l: usize, i: usize, j: usize| {
            let f = j * n_rows + i;
            Complex::new(sums[(l, f)], sums[(lines + l, f)])
        };
        if dashpots > 0 {
            let of_line = |(l, line): (usize, &Line)| {
                // (1 + iω Γ Wᵀ Z₀⁻¹ W)⁻¹ iω Γ of Wᵀ Z₀⁻¹ times the loads.
                let gamma = |p: usize| line.i_omega() * self.damping.values[p];
                let own = DMatrix::from_fn(dashpots, dashpots, |p, q| {
                    gamma(p) * at(l, s + p, b + q) + if p == q { 1.0 } else { 0.0 }
                });
                let responses = DMatrix::from_fn(dashpots, s, |p, i| gamma(p) * at(l, i, b + p));
                let references = DMatrix::from_fn(dashpots, b, |p, j| gamma(p) * at(l, s + p, j));
                let lu = own.lu();
                let nan = Complex::new(f64::NAN, f64::NAN);
                [responses, references].map(|right| lu.solve(&right).unwrap_or_else(|| right.map(|_| nan)))
            };
            self.coupled = self.lines.iter().enumerate().map(of_line).collect();
        }
        self.values = self.seen(&sums, |(l, (i, j)), extended| {
            let by_dashpots: Complex<f64> =
                (0..dashpots).map(|p| extended(i, b + p) * self.coupled[l][1][(p, j)]).sum();
            extended(i, j) - by_dashpots
        });
    }

    /// The sums over pairs of vectors, without what dashpots do.
    fn add_pairs(&self, of: &EntrySlopes, sums: &mut DMatrix<f64>) {
        let n = self.basis.theta.len();
        let Damping { by_mass, by_stiffness, .. } = self.damping;
        let sigma = self.basis.shift;
        let elastic = self.congruent(of, |[k, _, m]| k + sigma * m);
        let mass = self.congruent(of, |[_, _, m]| m);
        let own_damping = |[k, c, m]: [f64; 3]| c - by_mass * m - by_stiffness * k;
        let damping = self.congruent(of, own_damping);
        let at = |matrix: &Option<DMatrix<f64>>, i: usize, j: usize| matrix.as_ref().map_or(0.0, |a| a[(i, j)]);
        let is_massless = |k: usize| k >= self.massless;
        let mut is_apart = DMatrix::from_fn(n, n, |i, j| i != j && !(is_massless(i) && is_massless(j)));
        for &(i, j) in &self.close {
            (is_apart[(i, j)], is_apart[(j, i)]) = (false, false);
        }
        let gap = |i: usize, j: usize| self.theta(i) - self.theta(j);
        let apart = |value: &dyn Fn(usize, usize) -> f64| {
            DMatrix::from_fn(n, n, |i, j| if is_apart[(i, j)] { value(i, j) / gap(i, j) } else { 0.0 })
        };
        let is_equal = |i: usize, j: usize| i == j || is_massless(i) && is_massless(j);
        let equal = |value: &dyn Fn(usize, usize) -> f64| {
            DMatrix::from_fn(n, n, |i, j| if is_equal(i, j) { value(i, j) } else { 0.0 })
        };
        let [rows, references] = &self.loads;
        // x_k (E y)_k + y_k (E x)_k and x_k (E y)_k as coefficients.
        let across = |e: &DMatrix<f64>| {
            let (of_rows, of_references) = (e * rows, e * references);
            self.coefficients(|k, i, j| -(rows[(k, i)] * of_references[(k, j)] + references[(k, j)] * of_rows[(k, i)]))
        };
        let along = |e: &DMatrix<f64>| {
            let of_references = e * references;
            self.coefficients(|k, i, j| -rows[(k, i)] * of_references[(k, j)])
        };
        if elastic.is_some() || mass.is_some() {
            let slope = |i: usize, j: usize| self.theta(i) * at(&elastic, i, j) - at(&mass, i, j);
            let mut alpha = across(&apart(&slope));
            alpha += along(&equal(&|i, j| at(&elastic, i, j)));
            // Of a close pair: a g_k g_m = g_m + θ_k c g_k g_m.
            for &(i, j) in &self.close {
                self.each_function(|f, x, y| {
                    alpha[(j, f)] -= (x[i] * y[j] + x[j] * y[i]) * at(&elastic, i, j);
                });
            }
            add(&self.columns(|_, g| g), &alpha, sums);
            let beta = along(&equal(&slope));
            add(&self.columns(|line, g| line.c * g * g), &beta, sums);
            self.add_close(&slope, |line| line.c, sums);
        }
        if damping.is_some() {
            let slope = |i: usize, j: usize| at(&damping, i, j);
            add(&self.columns(|line, g| line.i_omega() / line.c * g), &across(&apart(&slope)), sums);
            add(&self.columns(|line, g| line.i_omega() * g * g), &along(&equal(&slope)), sums);
            self.add_close(&slope, Line::i_omega, sums);
        }
    }

    /// Xᵀ D X of one of the matrices; `None` where it does not change.
    fn congruent(&self, of: &EntrySlopes, value: impl Fn([f64; 3]) -> f64) -> Option<DMatrix<f64>> {
        let n = self.basis.theta.len();
        let mut products = DMatrix::zeros(n, of.rows.len());
        let mut is_any = false;
        for &(row, column, values) in &of.list {
            let v = value(values);
            if v != 0.0 {
                is_any = true;
                products.column_mut(row).axpy(v, &self.of_dofs.column(column), 1.0);
            }
        }
        is_any.then(|| self.of_dofs.select_columns(&of.rows) * products.transpose())
    }

    /// What every vector adds to every pair of loads; those without mass together.
    ///
    /// * `of` - by vector, number of the row and of the reference
    fn coefficients(&self, of: impl Fn(usize, usize, usize) -> f64) -> DMatrix<f64> {
        let n_rows = self.loads[0].ncols();
        let n = self.basis.theta.len();
        let functions = n_rows * self.loads[1].ncols();
        let mut out = DMatrix::zeros(self.massless + usize::from(self.massless < n), functions);
        for (f, mut column) in out.column_iter_mut().enumerate() {
            for k in 0..n {
                column[k.min(self.massless)] += of(k, f % n_rows, f / n_rows);
            }
        }
        out
    }

    fn each_function(&self, mut tell: impl FnMut(usize, &[f64], &[f64])) {
        let [rows, references] = &self.loads;
        let n = rows.nrows();
        for (f, (y, x)) in
            references.as_slice().chunks(n).flat_map(|y| rows.as_slice().chunks(n).map(move |x| (y, x))).enumerate()
        {
            tell(f, x, y);
        }
    }

    /// Products of close vectors, which have no partial fractions.
    fn add_close(
        &self,
        slope: &dyn Fn(usize, usize) -> f64,
        factor: impl Fn(&Line) -> Complex<f64>,
        sums: &mut DMatrix<f64>,
    ) {
        let moving: Vec<(usize, usize)> = self.close.iter().copied().filter(|&(i, j)| slope(i, j) != 0.0).collect();
        if moving.is_empty() {
            return;
        }
        let lines = self.lines.len();
        let mut columns = DMatrix::zeros(2 * lines, moving.len());
        for (&(i, j), mut column) in moving.iter().zip(columns.column_iter_mut()) {
            for (l, line) in self.lines.iter().enumerate() {
                let v = factor(line) * line.g(self.theta(i)) * line.g(self.theta(j));
                (column[l], column[lines + l]) = (v.re, v.im);
            }
        }
        let mut coefficients = DMatrix::zeros(moving.len(), sums.ncols());
        for (p, &(i, j)) in moving.iter().enumerate() {
            self.each_function(|f, x, y| coefficients[(p, f)] = -(x[i] * y[j] + x[j] * y[i]) * slope(i, j));
        }
        add(&columns, &coefficients, sums);
    }
}

/// Adds what vectors do at every line.
fn add(columns: &DMatrix<f64>, coefficients: &DMatrix<f64>, sums: &mut DMatrix<f64>) {
    sums.gemm(1.0, columns, coefficients, 1.0);
}

#[cfg(test)]
mod tests;
