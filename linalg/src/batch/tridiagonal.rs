//! Householder reduction of a symmetric matrix to tridiagonal form, and back.
//!
//! ```text
//! Hᵀ C H = T,   H = H_0 H_1 ... H_{m-3},   H_k = I - β_k v_k v_kᵀ
//! ```
//!
//! The rank-two update of one step and the product with the next reflector share one pass over the matrix, in tiles
//! of columns, so that every entry is loaded once a step.
//!
//! Source: G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 2013, section 8.3.1 (algorithm 8.3.1).

use super::lane::Lane;

/// The buffers of one reduction, all of length m except where stated.
pub(super) struct Reflectors<'a, L> {
    /// C (m x m, row by row, lower triangle); overwritten by the reflectors: v_k stands in column k below the diagonal.
    pub(super) c: &'a mut [L],
    /// β_k.
    pub(super) beta: &'a mut [L],
    /// Diagonal of T.
    pub(super) d: &'a mut [L],
    /// Off-diagonal of T: e_k couples rows k and k + 1; the last one is zero.
    pub(super) e: &'a mut [L],
    /// The current reflector.
    pub(super) v: &'a mut [L],
    /// The vector w of the rank-two update C - v wᵀ - w vᵀ.
    pub(super) w: &'a mut [L],
    /// The next reflector.
    pub(super) next: &'a mut [L],
    /// The product of the updated matrix with it.
    pub(super) p: &'a mut [L],
}

/// Columns handled together in one pass over the matrix.
const TILE: usize = 4;

/// Reduces C to tridiagonal form.
#[inline(always)]
pub(super) fn tridiagonalise<L: Lane>(m: usize, r: &mut Reflectors<'_, L>) {
    let zero = L::splat(0.0);
    let half = L::splat(0.5);
    r.v[..m].fill(zero);
    r.w[..m].fill(zero);
    for k in 0..m {
        // Column k with the pending update of the last step.
        let (vk, wk) = (r.v[k], r.w[k]);
        r.d[k] = wk.neg_mul_add(vk, vk.neg_mul_add(wk, r.c[k * m + k]));
        if k + 1 == m {
            r.e[k] = zero;
            break;
        }
        let mut norm2 = zero;
        for i in k + 1..m {
            let x = r.w[i].neg_mul_add(vk, r.v[i].neg_mul_add(wk, r.c[i * m + k]));
            r.next[i] = x;
            norm2 = x.mul_add(x, norm2);
        }
        if k + 2 == m {
            r.e[k] = r.next[k + 1];
            r.beta[k] = zero;
            r.c[(k + 1) * m + k] = zero;
            let (v, w) = (r.v[k + 1], r.w[k + 1]);
            r.d[k + 1] = w.neg_mul_add(v, v.neg_mul_add(w, r.c[(k + 1) * m + k + 1]));
            r.e[k + 1] = zero;
            break;
        }
        // H x = -sign(x₁) |x| e₁ with v = x + sign(x₁) |x| e₁; a zero column needs no reflector (β = 0).
        let norm = norm2.sqrt();
        let x1 = r.next[k + 1];
        let negative = x1.lt(zero);
        let length = norm * (norm + x1.abs());
        let empty = length.lt(L::splat(f64::MIN_POSITIVE));
        let beta = L::select(empty, zero, L::splat(1.0) / length);
        r.e[k] = L::select(negative, norm, -norm);
        r.next[k + 1] = x1 - r.e[k];
        r.beta[k] = beta;
        for i in k + 1..m {
            r.c[i * m + k] = r.next[i];
            r.p[i] = zero;
        }
        update_and_multiply(m, k + 1, r);
        // w = β (p - (β/2)(vᵀ p) v).
        let mut vp = zero;
        for i in k + 1..m {
            vp = r.next[i].mul_add(r.p[i], vp);
        }
        let s = half * beta * vp;
        for i in k + 1..m {
            r.w[i] = beta * s.neg_mul_add(r.next[i], r.p[i]);
            r.v[i] = r.next[i];
        }
    }
}

/// C -= v wᵀ + w vᵀ and p = C next on the trailing block that starts at `start`, in one pass.
#[inline(always)]
fn update_and_multiply<L: Lane>(m: usize, start: usize, r: &mut Reflectors<'_, L>) {
    let mut j = start;
    while j + TILE <= m {
        update_tile::<L, TILE>(m, j, r);
        j += TILE;
    }
    while j < m {
        update_tile::<L, 1>(m, j, r);
        j += 1;
    }
}

/// The columns j .. j + T of the pass, from the diagonal down.
#[inline(always)]
fn update_tile<L: Lane, const T: usize>(m: usize, j: usize, r: &mut Reflectors<'_, L>) {
    let v: [L; T] = std::array::from_fn(|t| r.v[j + t]);
    let w: [L; T] = std::array::from_fn(|t| r.w[j + t]);
    let next: [L; T] = std::array::from_fn(|t| r.next[j + t]);
    let mut p: [L; T] = std::array::from_fn(|t| r.p[j + t]);
    // The triangle on the diagonal.
    for i in 0..T {
        let row = &mut r.c[(j + i) * m + j..][..T];
        for t in 0..=i {
            let c = w[i].neg_mul_add(v[t], v[i].neg_mul_add(w[t], row[t]));
            row[t] = c;
            p[i] = c.mul_add(next[t], p[i]);
            if t < i {
                p[t] = c.mul_add(next[i], p[t]);
            }
        }
    }
    // The rows below.
    let below = j + T;
    let (vs, ws, ns, ps) = (&r.v[below..m], &r.w[below..m], &r.next[below..m], &mut r.p[below..m]);
    let rows = r.c[below * m..].chunks_exact_mut(m);
    for ((((row, &vi), &wi), &ni), pi) in rows.zip(vs).zip(ws).zip(ns).zip(ps) {
        let row = &mut row[j..j + T];
        let mut sum = *pi;
        for t in 0..T {
            let c = wi.neg_mul_add(v[t], vi.neg_mul_add(w[t], row[t]));
            row[t] = c;
            sum = c.mul_add(next[t], sum);
            p[t] = c.mul_add(ni, p[t]);
        }
        *pi = sum;
    }
    r.p[j..j + T].copy_from_slice(&p);
}

/// Z := H Z: from the basis of T back to that of C.
///
/// * `c`, `beta` - the reflectors as [`tridiagonalise`] left them
/// * `z` - (m x width, row by row), the first `count` columns are transformed
#[inline(always)]
pub(super) fn back_transform<L: Lane>(m: usize, c: &[L], beta: &[L], z: &mut [L], width: usize, count: usize) {
    for k in (0..m.saturating_sub(2)).rev() {
        let mut j = 0;
        while j + TILE <= count {
            reflect::<L, TILE>(m, k, c, beta[k], z, width, j);
            j += TILE;
        }
        while j < count {
            reflect::<L, 1>(m, k, c, beta[k], z, width, j);
            j += 1;
        }
    }
}

/// Columns j .. j + T of Z -= β v (vᵀ Z).
#[inline(always)]
fn reflect<L: Lane, const T: usize>(m: usize, k: usize, c: &[L], beta: L, z: &mut [L], width: usize, j: usize) {
    let mut s = [L::splat(0.0); T];
    for i in k + 1..m {
        let v = c[i * m + k];
        let row = &z[i * width + j..][..T];
        for t in 0..T {
            s[t] = v.mul_add(row[t], s[t]);
        }
    }
    for t in 0..T {
        s[t] = s[t] * beta;
    }
    for i in k + 1..m {
        let v = c[i * m + k];
        let row = &mut z[i * width + j..][..T];
        for t in 0..T {
            row[t] = v.neg_mul_add(s[t], row[t]);
        }
    }
}
