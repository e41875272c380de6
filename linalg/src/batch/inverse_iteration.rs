//! Eigenvectors of symmetric tridiagonal matrices: inverse iteration until the residual is small in every lane.
//!
//! ```text
//! (T - σ) z = y,  y = z / |z|  (twice, from a fixed start);  Gram-Schmidt;  θ = yᵀ T y;  |T y - θ y| <= tolerance?
//! ```
//!
//! T - σ is factored with row exchanges (selects, no branches). A lane that passes the residual test is frozen, so that
//! its result does not depend on how long its companions iterate.
//!
//! Sources: B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, section 4.9; G. Peters, J. H. Wilkinson, The
//! calculation of specified eigenvectors by inverse iteration, Handbook for Automatic Computation II, 1971.

use super::lane::{ABREAST, Counter, Lane, Mask};
use super::sturm::Tridiagonal;

/// Sweeps after which a lane that does not pass goes to the reference path.
const SWEEPS: usize = 6;

/// Scratch of m x [`ABREAST`] each, except where stated.
pub(super) struct Factors<'a, L> {
    pub(super) inverse: &'a mut [L],
    pub(super) upper1: &'a mut [L],
    pub(super) upper2: &'a mut [L],
    pub(super) multiplier: &'a mut [L],
    /// The vectors of the sweep before, m x width.
    pub(super) old: &'a mut [L],
}

/// Eigenvectors z (m x width, row by row) of the first `count` eigenvalues `theta`, which are improved to Rayleigh
/// quotients; gives the mask of the lanes where all wanted pairs pass the residual test.
///
/// * `wanted` - per lane the number of eigenpairs that matter (the first ones)
/// * `start` - fixed start values, at least m + count
#[inline(always)]
pub(super) fn eigenvectors<L: Lane>(
    t: Tridiagonal<'_, L>,
    theta: &mut [L],
    wanted: Counter,
    start: &[f64],
    z: &mut [L],
    width: usize,
    f: &mut Factors<'_, L>,
) -> Mask {
    let (m, count) = (t.d.len(), theta.len());
    let tolerance = L::splat(2e-15 * (m as f64).sqrt());
    for i in 0..m {
        for j in 0..count {
            z[i * width + j] = L::splat(start[i + j * 7 % 31]);
        }
    }
    let mut passed = Mask::splat(false);
    for sweep in 0..SWEEPS {
        if sweep > 0 {
            f.old[..m * width].copy_from_slice(&z[..m * width]);
        }
        for (tile, sigma) in theta.chunks(ABREAST).enumerate() {
            iterate(t, sigma, z, width, tile * ABREAST, f);
        }
        orthonormalise(m, count, z, width);
        if sweep > 0 {
            for i in 0..m {
                for j in 0..count {
                    z[i * width + j] = L::select(passed, f.old[i * width + j], z[i * width + j]);
                }
            }
        }
        let mut good = Mask::splat(true);
        for j in 0..count {
            let (quotient, residual) = rayleigh(t, z, width, j);
            theta[j] = L::select(passed, theta[j], quotient);
            good = good.and(residual.lt(tolerance).or(wanted.above(j).not()));
        }
        passed = passed.or(good);
        if !passed.not().any() {
            break;
        }
    }
    passed
}

/// Two solves with T - σ for the columns of z from j on, one per shift.
#[inline(always)]
fn iterate<L: Lane>(t: Tridiagonal<'_, L>, sigma: &[L], z: &mut [L], width: usize, j: usize, f: &mut Factors<'_, L>) {
    let (m, count) = (t.d.len(), sigma.len().min(ABREAST));
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    // P (T - σ) = L U; U has two superdiagonals, the second one is not zero exactly where rows were exchanged.
    let mut pivot = [zero; ABREAST];
    let mut right = [t.e[0]; ABREAST];
    for a in 0..count {
        pivot[a] = t.d[0] - sigma[a];
    }
    for i in 0..m - 1 {
        let (sub, d, e) = (t.e[i], t.d[i + 1], t.e[i + 1]);
        for a in 0..count {
            let diagonal = d - sigma[a];
            let swap = pivot[a].abs().lt(sub.abs());
            let p = L::select(swap, sub, pivot[a]);
            let q = L::select(swap, pivot[a], sub);
            let u1 = L::select(swap, diagonal, right[a]);
            let v1 = L::select(swap, right[a], diagonal);
            let u2 = L::select(swap, e, zero);
            let v2 = L::select(swap, zero, e);
            let inverse = one / p;
            let multiplier = q * inverse;
            pivot[a] = multiplier.neg_mul_add(u1, v1);
            right[a] = multiplier.neg_mul_add(u2, v2);
            let at = i * ABREAST + a;
            f.inverse[at] = inverse;
            f.upper1[at] = u1;
            f.upper2[at] = u2;
            f.multiplier[at] = multiplier;
        }
    }
    // The last pivot vanishes when σ is an eigenvalue: any value at rounding level serves.
    let least = L::splat(f64::EPSILON / 8.0);
    for a in 0..count {
        let p = L::select(pivot[a].abs().lt(least), least, pivot[a]);
        f.inverse[(m - 1) * ABREAST + a] = one / p;
    }
    // The first right-hand side is taken as L⁻¹ P of some start, so only U is solved with.
    back_substitute(m, count, z, width, j, f);
    // Forward: L⁻¹ P.
    let mut carry = [zero; ABREAST];
    carry[..count].copy_from_slice(&z[j..j + count]);
    for i in 0..m - 1 {
        for a in 0..count {
            let at = i * ABREAST + a;
            let next = z[(i + 1) * width + j + a];
            let u2 = f.upper2[at];
            let swap = u2.lt(zero).or(zero.lt(u2));
            let y = L::select(swap, next, carry[a]);
            let rest = L::select(swap, carry[a], next);
            z[i * width + j + a] = y;
            carry[a] = f.multiplier[at].neg_mul_add(y, rest);
        }
    }
    for a in 0..count {
        z[(m - 1) * width + j + a] = carry[a];
    }
    back_substitute(m, count, z, width, j, f);
}

/// Solves U z = z for `count` columns from j on and normalises them.
#[inline(always)]
fn back_substitute<L: Lane>(m: usize, count: usize, z: &mut [L], width: usize, j: usize, f: &Factors<'_, L>) {
    let zero = L::splat(0.0);
    let mut norm2 = [zero; ABREAST];
    let (mut z1, mut z2) = ([zero; ABREAST], [zero; ABREAST]);
    for a in 0..count {
        let z0 = z[(m - 1) * width + j + a] * f.inverse[(m - 1) * ABREAST + a];
        z[(m - 1) * width + j + a] = z0;
        norm2[a] = z0 * z0;
        z1[a] = z0;
    }
    for i in (0..m - 1).rev() {
        for a in 0..count {
            let at = i * ABREAST + a;
            let y = z[i * width + j + a];
            let z0 = f.upper2[at].neg_mul_add(z2[a], f.upper1[at].neg_mul_add(z1[a], y)) * f.inverse[at];
            z[i * width + j + a] = z0;
            norm2[a] = z0.mul_add(z0, norm2[a]);
            z2[a] = z1[a];
            z1[a] = z0;
        }
    }
    let mut scale = [zero; ABREAST];
    for a in 0..count {
        scale[a] = L::splat(1.0) / norm2[a].sqrt();
    }
    for i in 0..m {
        for a in 0..count {
            z[i * width + j + a] = z[i * width + j + a] * scale[a];
        }
    }
}

/// Modified Gram-Schmidt over all columns; a column that loses most of its length is orthogonalised again.
#[inline(always)]
fn orthonormalise<L: Lane>(m: usize, count: usize, z: &mut [L], width: usize) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    for j in 1..count {
        let mut active = Mask::splat(true);
        for _ in 0..2 {
            for k in 0..j {
                let mut dot = zero;
                for row in z[..m * width].chunks_exact(width) {
                    dot = row[k].mul_add(row[j], dot);
                }
                let dot = L::select(active, dot, zero);
                for row in z[..m * width].chunks_exact_mut(width) {
                    row[j] = dot.neg_mul_add(row[k], row[j]);
                }
            }
            let mut norm2 = zero;
            for row in z[..m * width].chunks_exact(width) {
                norm2 = row[j].mul_add(row[j], norm2);
            }
            let scale = L::select(active, one / norm2.sqrt(), one);
            for row in z[..m * width].chunks_exact_mut(width) {
                row[j] = row[j] * scale;
            }
            active = active.and(norm2.lt(L::splat(0.5)));
            if !active.any() {
                break;
            }
        }
    }
}

/// Row i of T z for column j, and the entry of z in that row.
#[inline(always)]
fn row_product<L: Lane>(t: Tridiagonal<'_, L>, z: &[L], width: usize, j: usize, i: usize) -> (L, L) {
    let here = z[i * width + j];
    let mut sum = t.d[i] * here;
    if i > 0 {
        sum = t.e[i - 1].mul_add(z[(i - 1) * width + j], sum);
    }
    if i + 1 < t.d.len() {
        sum = t.e[i].mul_add(z[(i + 1) * width + j], sum);
    }
    (sum, here)
}

/// Rayleigh quotient zᵀ T z of column j (|z| = 1) and the norm of its residual.
#[inline(always)]
fn rayleigh<L: Lane>(t: Tridiagonal<'_, L>, z: &[L], width: usize, j: usize) -> (L, L) {
    let m = t.d.len();
    let zero = L::splat(0.0);
    let mut quotient = zero;
    for i in 0..m {
        let (product, here) = row_product(t, z, width, j, i);
        quotient = here.mul_add(product, quotient);
    }
    let mut norm2 = zero;
    for i in 0..m {
        let (product, here) = row_product(t, z, width, j, i);
        let r = quotient.neg_mul_add(here, product);
        norm2 = r.mul_add(r, norm2);
    }
    (quotient, norm2.sqrt())
}
