//! Eight lines side by side: a number of all of them is a row of eight.

// A loop runs with the instructions of the function it is inlined into; without the attribute it would run without them.
#![allow(clippy::inline_always)]

use super::Entry;
use crate::envelope::Envelope;
use crate::{Complex, DMatrix};

/// Lines that are solved together.
pub(super) const LINES: usize = 8;

/// A complex number of every line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Lane {
    re: [f64; LINES],
    im: [f64; LINES],
}

const ZERO: Lane = Lane { re: [0.0; LINES], im: [0.0; LINES] };

/// a b + c, fused where the processor can.
#[inline(always)]
fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

impl Lane {
    /// self - a b.
    #[inline(always)]
    fn minus<const FUSED: bool>(&mut self, a: &Lane, b: &Lane) {
        for l in 0..LINES {
            self.re[l] = fma::<FUSED>(a.im[l], b.im[l], fma::<FUSED>(-a.re[l], b.re[l], self.re[l]));
            self.im[l] = fma::<FUSED>(-a.im[l], b.re[l], fma::<FUSED>(-a.re[l], b.im[l], self.im[l]));
        }
    }

    #[inline(always)]
    fn times<const FUSED: bool>(&self, b: &Lane) -> Lane {
        let mut product = ZERO;
        for l in 0..LINES {
            product.re[l] = fma::<FUSED>(self.re[l], b.re[l], -self.im[l] * b.im[l]);
            product.im[l] = fma::<FUSED>(self.re[l], b.im[l], self.im[l] * b.re[l]);
        }
        product
    }

    #[inline(always)]
    fn inverse(&self) -> Lane {
        let mut inverse = ZERO;
        for l in 0..LINES {
            let over = 1.0 / (self.re[l] * self.re[l] + self.im[l] * self.im[l]);
            inverse.re[l] = self.re[l] * over;
            inverse.im[l] = -self.im[l] * over;
        }
        inverse
    }
}

/// The memory of eight lines.
pub(super) struct Lines {
    /// L in the envelope, its diagonal replaced by 1/D.
    factor: Vec<Lane>,
    /// Solutions, and last that of the column whose residual is found (n x columns + 1), row by row.
    x: Vec<Lane>,
    columns: usize,
    /// That column.
    probe: Vec<f64>,
    residual: Vec<Lane>,
    size: Vec<[f64; LINES]>,
}

/// What one solution needs.
struct Task<'a> {
    envelope: &'a Envelope,
    entries: &'a [Entry],
    omega: [f64; LINES],
    loss_factor: f64,
    right: &'a DMatrix<f64>,
}

impl Lines {
    /// * `right` - the right-hand sides in the order of the elimination
    pub(super) fn new(envelope: &Envelope, right: &DMatrix<f64>) -> Self {
        let (n, columns) = right.shape();
        // Without a pattern that a structure could have: fractions of the golden ratio.
        let probe = (0..n).map(|i| (0.618_033_988_749_894_9 * (i + 1) as f64).fract() + 0.5).collect();
        Self {
            factor: vec![ZERO; envelope.len()],
            x: vec![ZERO; n * (columns + 1)],
            columns,
            probe,
            residual: vec![ZERO; n],
            size: vec![[0.0; LINES]; n],
        }
    }

    /// Solves up to eight lines; gives for each the largest residual of a row of Z x = b over the sum of its terms, for a column b beside
    /// the wanted ones.
    pub(super) fn solve(
        &mut self,
        envelope: &Envelope,
        entries: &[Entry],
        (omegas, loss_factor): (&[f64], f64),
        right: &DMatrix<f64>,
    ) -> [f64; LINES] {
        // Lanes without a line repeat the last one.
        let omega = std::array::from_fn(|l| omegas[l.min(omegas.len() - 1)]);
        let task = Task { envelope, entries, omega, loss_factor, right };
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return pulp::Simd::vectorize(simd, || self.run::<true>(&task));
        }
        self.run::<{ cfg!(target_arch = "aarch64") }>(&task)
    }

    /// The solution of a line, its rows back in their own order.
    pub(super) fn unload(&self, lane: usize, order: &[usize], out: &mut DMatrix<Complex<f64>>) {
        for (row, &old) in self.x.chunks_exact(self.columns + 1).zip(order) {
            for (j, value) in row[..self.columns].iter().enumerate() {
                out[(old, j)] = Complex::new(value.re[lane], value.im[lane]);
            }
        }
    }

    #[inline(always)]
    fn run<const FUSED: bool>(&mut self, task: &Task<'_>) -> [f64; LINES] {
        self.factor.fill(ZERO);
        for e in task.entries {
            self.factor[task.envelope.at(e.row, e.column)] = value::<FUSED>(task, e);
        }
        factor::<FUSED>(task.envelope, &mut self.factor);
        let width = self.columns + 1;
        for (i, row) in self.x.chunks_exact_mut(width).enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                let b = if j < self.columns { task.right[(i, j)] } else { self.probe[i] };
                *x = Lane { re: [b; LINES], im: [0.0; LINES] };
            }
        }
        solve::<FUSED>(task.envelope, &self.factor, width, &mut self.x);
        self.probe_residual::<FUSED>(task)
    }

    /// max_i |b - Z x|_i / (|b| + |Z| |x|)_i of the last column.
    #[inline(always)]
    fn probe_residual<const FUSED: bool>(&mut self, task: &Task<'_>) -> [f64; LINES] {
        let width = self.columns + 1;
        for ((r, size), &b) in self.residual.iter_mut().zip(&mut self.size).zip(&self.probe) {
            *r = Lane { re: [b; LINES], im: [0.0; LINES] };
            *size = [b.abs(); LINES];
        }
        let mut add = |row: usize, column: usize, z: &Lane| {
            let x = &self.x[column * width + self.columns];
            self.residual[row].minus::<FUSED>(z, x);
            for l in 0..LINES {
                self.size[row][l] += (z.re[l].abs() + z.im[l].abs()) * (x.re[l].abs() + x.im[l].abs());
            }
        };
        for e in task.entries {
            let z = value::<FUSED>(task, e);
            add(e.row, e.column, &z);
            if e.row != e.column {
                add(e.column, e.row, &z);
            }
        }
        let mut worst = [0.0_f64; LINES];
        for (r, size) in self.residual.iter().zip(&self.size) {
            for l in 0..LINES {
                let ratio = (r.re[l].abs() + r.im[l].abs()) / size[l];
                // A NaN must stay: it is the worst of all.
                worst[l] = if ratio <= worst[l] || worst[l].is_nan() { worst[l] } else { ratio };
            }
        }
        worst
    }
}

/// Z at an entry.
#[inline(always)]
fn value<const FUSED: bool>(task: &Task<'_>, e: &Entry) -> Lane {
    let [k, c, m] = e.values;
    let damping = task.loss_factor * k;
    let mut z = ZERO;
    for l in 0..LINES {
        let omega = task.omega[l];
        z.re[l] = fma::<FUSED>(-omega * omega, m, k);
        z.im[l] = fma::<FUSED>(omega, c, damping);
    }
    z
}

/// Z = L D Lᵀ in place, row by row.
///
/// ```text
/// g_ij = z_ij - Σ_t g_it l_jt,   l_ij = g_ij / d_j,   d_i = z_ii - Σ_j g_ij l_ij
/// ```
#[inline(always)]
fn factor<const FUSED: bool>(envelope: &Envelope, z: &mut [Lane]) {
    for i in 0..envelope.rows() {
        let first = envelope.first[i];
        let (above, row) = z.split_at_mut(envelope.start[i]);
        for j in first..i {
            let begin = envelope.first[j].max(first);
            let other = &above[envelope.at(j, begin)..][..j - begin];
            let (known, rest) = row.split_at_mut(j - first);
            for (g, l) in known[begin - first..].iter().zip(other) {
                rest[0].minus::<FUSED>(g, l);
            }
        }
        let (off, diagonal) = row.split_at_mut(i - first);
        for (j, g) in off.iter_mut().enumerate() {
            let l = g.times::<FUSED>(&above[envelope.at(first + j, first + j)]);
            diagonal[0].minus::<FUSED>(g, &l);
            *g = l;
        }
        diagonal[0] = diagonal[0].inverse();
    }
}

/// X := (L D Lᵀ)⁻¹ X, (n x width) row by row.
#[inline(always)]
fn solve<const FUSED: bool>(envelope: &Envelope, z: &[Lane], width: usize, x: &mut [Lane]) {
    for i in 0..envelope.rows() {
        let first = envelope.first[i];
        let (above, row) = x.split_at_mut(i * width);
        for (j, l) in z[envelope.row(i)][..i - first].iter().enumerate() {
            for (x, y) in row[..width].iter_mut().zip(&above[(first + j) * width..]) {
                x.minus::<FUSED>(l, y);
            }
        }
    }
    for (i, row) in x.chunks_exact_mut(width).enumerate() {
        let inverse = &z[envelope.at(i, i)];
        for x in row {
            *x = x.times::<FUSED>(inverse);
        }
    }
    for i in (0..envelope.rows()).rev() {
        let first = envelope.first[i];
        let (above, row) = x.split_at_mut(i * width);
        for (j, l) in z[envelope.row(i)][..i - first].iter().enumerate() {
            for (x, y) in above[(first + j) * width..][..width].iter_mut().zip(&row[..width]) {
                x.minus::<FUSED>(l, y);
            }
        }
    }
}
