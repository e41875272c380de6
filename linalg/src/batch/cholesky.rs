//! Envelope Cholesky K = L Lᵀ and the products with L⁻¹ that turn a pencil into one symmetric matrix.
//!
//! Row i of the lower triangle is stored from its first entry that can differ from zero up to the diagonal; the factor
//! fills this envelope and nothing else. The reciprocal of the diagonal of L stands in the place of the diagonal.
//!
//! Source: A. George, J. W. Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981, chapter 4.

use super::lane::{Lane, Mask};
use crate::envelope::Envelope;

/// A + s C in place of A.
///
/// * `c` - symmetric (m x m, row by row); what lies outside the envelope must be zero
#[inline(always)]
pub(super) fn add<L: Lane>(envelope: &Envelope, s: f64, c: &[L], a: &mut [L]) {
    let (m, s) = (envelope.rows(), L::splat(s));
    for i in 0..m {
        for (x, &y) in a[envelope.row(i)].iter_mut().zip(&c[i * m + envelope.first[i]..]) {
            *x = s.mul_add(y, *x);
        }
    }
}

/// Factors in place; gives the mask of the lanes where a pivot is positive in every row.
///
/// A pivot is positive when it keeps at least 1e-13 of its diagonal entry: below that the matrix is singular to rounding.
#[inline(always)]
pub(super) fn factor<L: Lane>(envelope: &Envelope, a: &mut [L]) -> Mask {
    let mut positive = Mask::splat(true);
    for i in 0..envelope.rows() {
        let first = envelope.first[i];
        let (above, row) = a.split_at_mut(envelope.start[i]);
        let mut pivot = row[i - first];
        let least = L::splat(1e-13) * pivot.abs();
        for j in first..i {
            let begin = envelope.first[j].max(first);
            let other = &above[envelope.at(j, begin)..];
            let mut sum = row[j - first];
            for t in begin..j {
                sum = row[t - first].neg_mul_add(other[t - begin], sum);
            }
            let l = sum * other[j - begin];
            row[j - first] = l;
            pivot = l.neg_mul_add(l, pivot);
        }
        let good = least.lt(pivot);
        positive = positive.and(good);
        row[i - first] = L::splat(1.0) / L::select(good, pivot, L::splat(1.0)).sqrt();
    }
    positive
}

/// C = L⁻¹ C L⁻ᵀ in place.
///
/// * `c` - symmetric (m x m, row by row); both triangles are read, the lower one of the result is written
#[inline(always)]
pub(super) fn reduce<L: Lane>(envelope: &Envelope, l: &[L], c: &mut [L]) {
    let m = envelope.rows();
    for i in 0..m {
        let (above, row) = c.split_at_mut(i * m);
        let factors = &l[envelope.row(i)];
        let mut j = 0;
        while j + 4 <= m {
            forward_tile::<L, 4>(m, envelope.first[i], factors, above, &mut row[j..j + 4], j);
            j += 4;
        }
        while j < m {
            forward_tile::<L, 1>(m, envelope.first[i], factors, above, &mut row[j..=j], j);
            j += 1;
        }
    }
    let mut i = 0;
    while i + 4 <= m {
        right_tile::<L, 4>(envelope, l, &mut c[i * m..(i + 4) * m], i);
        i += 4;
    }
    while i < m {
        right_tile::<L, 1>(envelope, l, &mut c[i * m..(i + 1) * m], i);
        i += 1;
    }
}

/// T entries of row i of L⁻¹ C, from the finished rows above.
#[inline(always)]
fn forward_tile<L: Lane, const T: usize>(m: usize, first: usize, l: &[L], above: &[L], row: &mut [L], j: usize) {
    let mut sum: [L; T] = std::array::from_fn(|t| row[t]);
    let (diagonal, left) = (l[l.len() - 1], &l[..l.len() - 1]);
    for (q, &factor) in left.iter().enumerate() {
        let x = &above[(first + q) * m + j..][..T];
        for t in 0..T {
            sum[t] = factor.neg_mul_add(x[t], sum[t]);
        }
    }
    for t in 0..T {
        row[t] = sum[t] * diagonal;
    }
}

/// The lower triangle of T rows, from row i on, of X L⁻ᵀ.
#[inline(always)]
fn right_tile<L: Lane, const T: usize>(envelope: &Envelope, l: &[L], rows: &mut [L], i: usize) {
    let m = envelope.rows();
    for j in 0..i + T {
        let first = envelope.first[j];
        let factors = &l[envelope.row(j)];
        let mut sum: [L; T] = std::array::from_fn(|t| rows[t * m + j]);
        for (q, &factor) in factors[..j - first].iter().enumerate() {
            for t in 0..T {
                sum[t] = factor.neg_mul_add(rows[t * m + first + q], sum[t]);
            }
        }
        for t in 0..T {
            rows[t * m + j] = sum[t] * factors[j - first];
        }
    }
}

/// X := L⁻ᵀ X for the first `count` columns of X (m x width, row by row).
#[inline(always)]
pub(super) fn solve_transposed<L: Lane>(envelope: &Envelope, l: &[L], x: &mut [L], width: usize, count: usize) {
    for i in (0..envelope.rows()).rev() {
        let first = envelope.first[i];
        let (above, row) = x.split_at_mut(i * width);
        let factors = &l[envelope.row(i)];
        for value in &mut row[..count] {
            *value = *value * factors[i - first];
        }
        for (q, &factor) in factors[..i - first].iter().enumerate() {
            let target = &mut above[(first + q) * width..][..count];
            for (t, &value) in target.iter_mut().zip(&row[..count]) {
                *t = factor.neg_mul_add(value, *t);
            }
        }
    }
}
