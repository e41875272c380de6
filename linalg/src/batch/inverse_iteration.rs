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
        // Tiles of one size: a single column would wait for its divisions.
        let tile = count.div_ceil(count.div_ceil(ABREAST));
        for (k, sigma) in theta.chunks(tile).enumerate() {
            iterate(t, sigma, z, width, k * tile, f);
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
        let mut j = 0;
        while j < count {
            let tile = if j + 4 <= count { 4 } else { 1 };
            let (quotients, residuals) = if tile == 4 {
                rayleigh::<L, 4>(t, theta, z, width, j)
            } else {
                rayleigh_of_one(t, theta, z, width, j)
            };
            for k in 0..tile {
                theta[j + k] = L::select(passed, theta[j + k], quotients[k]);
                good = good.and(residuals[k].lt(tolerance).or(wanted.above(j + k).not()));
            }
            j += tile;
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
    let z = &mut z[..m * width];
    for j in 0..count {
        if j > 0 {
            let shortened = normalise(z, width, j, Mask::splat(true));
            if shortened.any() {
                for k in 0..j {
                    project_out::<L, 1>(z, width, k, j, shortened);
                }
                normalise(z, width, j, shortened);
            }
        }
        let mut next = j + 1;
        while next + 4 <= count {
            project_out::<L, 4>(z, width, j, next, Mask::splat(true));
            next += 4;
        }
        while next < count {
            project_out::<L, 1>(z, width, j, next, Mask::splat(true));
            next += 1;
        }
    }
}

/// Takes the part along column k out of T columns from j on, in the lanes of the mask.
#[inline(always)]
fn project_out<L: Lane, const T: usize>(z: &mut [L], width: usize, k: usize, j: usize, lanes: Mask) {
    let zero = L::splat(0.0);
    let mut dot = [zero; T];
    for row in z.chunks_exact(width) {
        for t in 0..T {
            dot[t] = row[k].mul_add(row[j + t], dot[t]);
        }
    }
    for d in &mut dot {
        *d = L::select(lanes, *d, zero);
    }
    for row in z.chunks_exact_mut(width) {
        for t in 0..T {
            row[j + t] = dot[t].neg_mul_add(row[k], row[j + t]);
        }
    }
}

/// Gives column j length one in the lanes of the mask, and tells in which of them most of the length had been lost.
#[inline(always)]
fn normalise<L: Lane>(z: &mut [L], width: usize, j: usize, lanes: Mask) -> Mask {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let mut norm2 = zero;
    for row in z.chunks_exact(width) {
        norm2 = row[j].mul_add(row[j], norm2);
    }
    let scale = L::select(lanes, one / norm2.sqrt(), one);
    for row in z.chunks_exact_mut(width) {
        row[j] = row[j] * scale;
    }
    lanes.and(norm2.lt(L::splat(0.5)))
}

/// Rayleigh quotients zᵀ T z of C columns from j on (|z| = 1) and the norms of their residuals, from r = T z - θ z with the θ that is
/// known: the quotient is θ + zᵀ r, and its residual |r - z zᵀ r|.
#[inline(always)]
fn rayleigh<L: Lane, const C: usize>(
    t: Tridiagonal<'_, L>,
    theta: &[L],
    z: &[L],
    width: usize,
    j: usize,
) -> ([L; C], [L; C]) {
    let (m, zero) = (t.d.len(), L::splat(0.0));
    let (mut along, mut squared) = ([zero; C], [zero; C]);
    let (mut above, mut here, mut known) = ([zero; C], [zero; C], [zero; C]);
    here.copy_from_slice(&z[j..j + C]);
    known.copy_from_slice(&theta[j..j + C]);
    let mut coupling = zero;
    for i in 0..m {
        let mut below = [zero; C];
        if i + 1 < m {
            below.copy_from_slice(&z[(i + 1) * width + j..][..C]);
        }
        for c in 0..C {
            let r = t.e[i].mul_add(below[c], coupling.mul_add(above[c], (t.d[i] - known[c]) * here[c]));
            along[c] = here[c].mul_add(r, along[c]);
            squared[c] = r.mul_add(r, squared[c]);
        }
        (coupling, above, here) = (t.e[i], here, below);
    }
    for c in 0..C {
        squared[c] = along[c].neg_mul_add(along[c], squared[c]).max(zero).sqrt();
        known[c] = known[c] + along[c];
    }
    (known, squared)
}

/// The same of one column, in the first places.
#[inline(always)]
fn rayleigh_of_one<L: Lane>(t: Tridiagonal<'_, L>, theta: &[L], z: &[L], width: usize, j: usize) -> ([L; 4], [L; 4]) {
    let (quotient, residual) = rayleigh::<L, 1>(t, theta, z, width, j);
    ([quotient[0]; 4], [residual[0]; 4])
}
