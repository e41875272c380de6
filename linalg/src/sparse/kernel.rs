//! Loops over blocks of vectors, [`WIDTH`] numbers a row, compiled for AVX2 with fused multiply-add and for any processor.
//!
//! A block is stored row by row, so that one entry of a sparse matrix or factor meets a whole vector register of
//! right-hand sides: the loops run at the speed of memory, which reads the factor once for all of them.

// A loop is compiled for a processor's instructions only where it is inlined into the function that has them.
#![allow(clippy::inline_always)]

use super::matrix::SparseSym;

/// Vectors a block.
pub(super) const WIDTH: usize = 8;

/// One row of a block.
pub(super) type Row = [f64; WIDTH];

/// A small matrix over two blocks: coefficient of vector i of the one and vector j of the other.
pub(super) type Small = [Row; WIDTH];

/// Rows that stay in the first-level cache while all blocks pass by.
const CHUNK: usize = 128;

/// Columns of a factor that are worked off together.
const PANEL: usize = 4;

/// Runs one of the loops compiled for what this processor can do.
macro_rules! dispatch {
    ($kernel:ident($($argument:expr),*)) => {{
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return pulp::Simd::vectorize(simd, || $kernel::<true>($($argument),*));
        }
        $kernel::<{ cfg!(target_arch = "aarch64") }>($($argument),*)
    }};
}

/// a b + c, fused where the processor can.
#[inline(always)]
fn fma<const FUSED: bool>(a: f64, b: f64, c: f64) -> f64 {
    if FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// y + a x.
#[inline(always)]
fn axpy<const FUSED: bool>(y: &mut Row, a: f64, x: &Row) {
    for l in 0..WIDTH {
        y[l] = fma::<FUSED>(a, x[l], y[l]);
    }
}

/// y = A x.
pub(super) fn multiply(a: &SparseSym, x: &[Row], y: &mut [Row]) {
    dispatch!(multiply_with(a, x, y));
}

#[inline(always)]
fn multiply_with<const FUSED: bool>(a: &SparseSym, x: &[Row], y: &mut [Row]) {
    y.fill([0.0; WIDTH]);
    for (j, range) in a.columns.windows(2).enumerate() {
        let (rows, values) = (&a.rows[range[0]..range[1]], &a.values[range[0]..range[1]]);
        let from = x[j];
        let mut sum = y[j];
        axpy::<FUSED>(&mut sum, values[0], &from);
        for (&i, &value) in rows.iter().zip(values).skip(1) {
            axpy::<FUSED>(&mut y[i], value, &from);
            axpy::<FUSED>(&mut sum, value, &x[i]);
        }
        y[j] = sum;
    }
}

/// The Gram matrices of every block with `p`: g\[k\] = Q_kᵀ P.
pub(super) fn grams(blocks: &[&[Row]], p: &[Row], g: &mut [Small]) {
    dispatch!(grams_with(blocks, p, g));
}

#[inline(always)]
fn grams_with<const FUSED: bool>(blocks: &[&[Row]], p: &[Row], g: &mut [Small]) {
    g.fill([[0.0; WIDTH]; WIDTH]);
    let n = p.len();
    let mut start = 0;
    while start < n {
        let end = (start + CHUNK).min(n);
        let right = &p[start..end];
        for (block, sum) in blocks.iter().zip(g.iter_mut()) {
            let left = &block[start..end];
            // Half the vectors at a time: their sums fit into the registers.
            for half in 0..2 {
                let first = half * (WIDTH / 2);
                let mut part = [[0.0; WIDTH]; WIDTH / 2];
                for (a, b) in left.iter().zip(right) {
                    for k in 0..WIDTH / 2 {
                        axpy::<FUSED>(&mut part[k], a[first + k], b);
                    }
                }
                for k in 0..WIDTH / 2 {
                    for l in 0..WIDTH {
                        sum[first + k][l] += part[k][l];
                    }
                }
            }
        }
        start = end;
    }
}

/// W - Σ Q_k C_k, overwriting W.
pub(super) fn subtract(w: &mut [Row], blocks: &[&[Row]], c: &[Small]) {
    dispatch!(subtract_with(w, blocks, c));
}

#[inline(always)]
fn subtract_with<const FUSED: bool>(w: &mut [Row], blocks: &[&[Row]], c: &[Small]) {
    let n = w.len();
    let mut start = 0;
    while start < n {
        let end = (start + CHUNK).min(n);
        let target = &mut w[start..end];
        for (block, coefficients) in blocks.iter().zip(c) {
            for (out, q) in target.iter_mut().zip(&block[start..end]) {
                let mut sum = *out;
                for k in 0..WIDTH {
                    axpy::<FUSED>(&mut sum, -q[k], &coefficients[k]);
                }
                *out = sum;
            }
        }
        start = end;
    }
}

/// W C for every row, overwriting W.
pub(super) fn transform(w: &mut [Row], c: &Small) {
    dispatch!(transform_with(w, c));
}

#[inline(always)]
fn transform_with<const FUSED: bool>(w: &mut [Row], c: &Small) {
    for row in w {
        let mut sum = [0.0; WIDTH];
        for k in 0..WIDTH {
            axpy::<FUSED>(&mut sum, row[k], &c[k]);
        }
        *row = sum;
    }
}

/// The structure of a supernodal factor L: neighbouring columns of like structure, each stored as a dense panel.
pub(super) struct Supernodes<'a> {
    /// First column of each.
    pub(super) begin: &'a [usize],
    /// One past its last column.
    pub(super) end: &'a [usize],
    /// Where its rows start in `rows`.
    pub(super) row_start: &'a [usize],
    /// How many rows it has below its triangle.
    pub(super) row_count: &'a [usize],
    /// Rows below the triangles.
    pub(super) rows: &'a [usize],
    /// Where its panel starts in `values`.
    pub(super) value_start: &'a [usize],
    /// Panels: columns of the triangle and the rows below it.
    pub(super) values: &'a [f64],
}

impl Supernodes<'_> {
    /// First column, number of columns, rows below, panel.
    #[inline(always)]
    fn get(&self, s: usize) -> (usize, usize, &[usize], &[f64]) {
        let (first, count) = (self.begin[s], self.end[s] - self.begin[s]);
        let rows = &self.rows[self.row_start[s]..self.row_start[s] + self.row_count[s]];
        (first, count, rows, &self.values[self.value_start[s]..self.value_start[s + 1]])
    }
}

/// (L Lᵀ)⁻¹ X, overwriting X; `work` holds as many rows as the longest supernode has below its triangle.
pub(super) fn solve(l: &Supernodes<'_>, x: &mut [Row], work: &mut [Row]) {
    dispatch!(solve_with(l, x, work));
}

#[inline(always)]
fn solve_with<const FUSED: bool>(l: &Supernodes<'_>, x: &mut [Row], work: &mut [Row]) {
    for s in 0..l.begin.len() {
        let (first, count, rows, panel) = l.get(s);
        let below = &mut work[..rows.len()];
        below.fill([0.0; WIDTH]);
        forward::<FUSED>(panel, &mut x[first..first + count], below);
        for (&i, sum) in rows.iter().zip(below.iter()) {
            for l in 0..WIDTH {
                x[i][l] += sum[l];
            }
        }
    }
    for s in (0..l.begin.len()).rev() {
        let (first, count, rows, panel) = l.get(s);
        let below = &mut work[..rows.len()];
        for (&i, row) in rows.iter().zip(below.iter_mut()) {
            *row = x[i];
        }
        backward::<FUSED>(panel, &mut x[first..first + count], below);
    }
}

/// Solves with the triangle of one supernode and adds -L x to the rows below it.
#[inline(always)]
fn forward<const FUSED: bool>(panel: &[f64], x: &mut [Row], below: &mut [Row]) {
    let (count, height) = (x.len(), x.len() + below.len());
    let mut j = 0;
    while j < count {
        let wide = PANEL.min(count - j);
        let mut solved = [[0.0; WIDTH]; PANEL];
        for k in 0..wide {
            let column = &panel[(j + k) * height..(j + k + 1) * height];
            let mut value = x[j + k];
            for (m, known) in solved.iter().enumerate().take(k) {
                axpy::<FUSED>(&mut value, -panel[(j + m) * height + j + k], known);
            }
            let inverse = 1.0 / column[j + k];
            for v in &mut value {
                *v *= inverse;
            }
            x[j + k] = value;
            solved[k] = value;
        }
        if wide == PANEL {
            let column = |k: usize| &panel[(j + k) * height..(j + k + 1) * height];
            let columns = [column(0), column(1), column(2), column(3)];
            update::<FUSED>(columns.map(|c| &c[j + PANEL..count]), &solved, &mut x[j + PANEL..]);
            update::<FUSED>(columns.map(|c| &c[count..]), &solved, below);
        } else {
            for (k, known) in solved.iter().enumerate().take(wide) {
                let column = &panel[(j + k) * height..(j + k + 1) * height];
                for (out, value) in x[j + wide..].iter_mut().zip(&column[j + wide..count]) {
                    axpy::<FUSED>(out, -value, known);
                }
                for (out, value) in below.iter_mut().zip(&column[count..]) {
                    axpy::<FUSED>(out, -value, known);
                }
            }
        }
        j += wide;
    }
}

/// out - Σ columns\[k\] x\[k\].
#[inline(always)]
fn update<const FUSED: bool>(columns: [&[f64]; PANEL], x: &[Row; PANEL], out: &mut [Row]) {
    let n = out.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    for i in 0..n {
        let mut sum = out[i];
        axpy::<FUSED>(&mut sum, -a[i], &x[0]);
        axpy::<FUSED>(&mut sum, -b[i], &x[1]);
        axpy::<FUSED>(&mut sum, -c[i], &x[2]);
        axpy::<FUSED>(&mut sum, -d[i], &x[3]);
        out[i] = sum;
    }
}

/// Solves with the transposed triangle of one supernode, the rows below it known.
#[inline(always)]
fn backward<const FUSED: bool>(panel: &[f64], x: &mut [Row], below: &[Row]) {
    let (count, height) = (x.len(), x.len() + below.len());
    let mut end = count;
    while end > 0 {
        let wide = if end % PANEL == 0 { PANEL } else { end % PANEL };
        let j = end - wide;
        let mut sums = [[0.0; WIDTH]; PANEL];
        if wide == PANEL {
            let column = |k: usize| &panel[(j + k) * height..(j + k + 1) * height];
            let columns = [column(0), column(1), column(2), column(3)];
            gather::<FUSED>(columns.map(|c| &c[end..count]), &x[end..], &mut sums);
            gather::<FUSED>(columns.map(|c| &c[count..]), below, &mut sums);
        } else {
            for (k, sum) in sums.iter_mut().enumerate().take(wide) {
                let column = &panel[(j + k) * height..(j + k + 1) * height];
                for (value, row) in column[end..count].iter().zip(&x[end..]) {
                    axpy::<FUSED>(sum, *value, row);
                }
                for (value, row) in column[count..].iter().zip(below) {
                    axpy::<FUSED>(sum, *value, row);
                }
            }
        }
        for k in (0..wide).rev() {
            let column = &panel[(j + k) * height..(j + k + 1) * height];
            let mut value = x[j + k];
            for l in 0..WIDTH {
                value[l] -= sums[k][l];
            }
            for m in k + 1..wide {
                let known = x[j + m];
                axpy::<FUSED>(&mut value, -column[j + m], &known);
            }
            let inverse = 1.0 / column[j + k];
            for v in &mut value {
                *v *= inverse;
            }
            x[j + k] = value;
        }
        end = j;
    }
}

/// sums\[k\] + Σ columns\[k\] x.
#[inline(always)]
fn gather<const FUSED: bool>(columns: [&[f64]; PANEL], x: &[Row], sums: &mut [Row; PANEL]) {
    let n = x.len();
    let [a, b, c, d] = columns.map(|column| &column[..n]);
    let [mut s0, mut s1, mut s2, mut s3] = *sums;
    for i in 0..n {
        axpy::<FUSED>(&mut s0, a[i], &x[i]);
        axpy::<FUSED>(&mut s1, b[i], &x[i]);
        axpy::<FUSED>(&mut s2, c[i], &x[i]);
        axpy::<FUSED>(&mut s3, d[i], &x[i]);
    }
    *sums = [s0, s1, s2, s3];
}
