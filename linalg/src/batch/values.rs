//! All eigenvalues of small symmetric tridiagonal matrices: the QL iteration without square roots.
//!
//! ```text
//! T - σ = Q L,  T <- L Q + σ,   on d_i and e_i² alone;  σ from the leading 2 x 2 block
//! ```
//!
//! A step works on the whole matrix below the converged corner, in every lane; a lane whose corner has converged is frozen
//! until the others' have. Eigenvalues are exact to rounding of the largest one, which has size one here: the residual test
//! after inverse iteration judges the small ones.
//!
//! Source: B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, section 8.15 (Pal-Walker-Kahan variant).

use super::lane::Lane;
use super::sturm::Tridiagonal;

/// Below this an off-diagonal entry squared is nothing beside a matrix of norm one.
const NOTHING: f64 = 1e-34;
/// Steps for one eigenvalue after which it is taken as it is.
const STEPS: usize = 30;

/// The largest eigenvalues, descending.
///
/// * `d`, `e2` - scratch of m numbers each
#[inline(always)]
pub(super) fn largest_eigenvalues<L: Lane>(t: Tridiagonal<'_, L>, d: &mut [L], e2: &mut [L], out: &mut [L]) {
    let m = t.d.len();
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let (d, e2) = (&mut d[..m], &mut e2[..m]);
    d.copy_from_slice(t.d);
    e2.copy_from_slice(&t.e2[..m]);
    for corner in 0..m - 1 {
        for _ in 0..STEPS {
            let open = L::splat(NOTHING).lt(e2[corner]);
            if !open.any() {
                break;
            }
            // The eigenvalue of the leading block that is nearer to d.
            let root = e2[corner].sqrt();
            let ratio = (d[corner + 1] - d[corner]) / (root + root);
            let length = ratio.mul_add(ratio, one).sqrt();
            let sum = ratio + L::select(ratio.lt(zero), -length, length);
            let sigma = d[corner] - root / sum;
            let (mut c, mut s) = (one, zero);
            let mut gamma = d[m - 1] - sigma;
            let mut p = gamma * gamma;
            for i in (corner..m - 1).rev() {
                let b = e2[i];
                let r = (p + b).max(L::splat(f64::MIN_POSITIVE));
                if i + 2 < m {
                    e2[i + 1] = L::select(open, s * r, e2[i + 1]);
                }
                let before = c;
                // Two divisions that do not wait for each other: 1/r, and 1/c = r/p.
                let (inverse, over_c) = (one / r, r / p);
                c = p * inverse;
                s = b * inverse;
                let old = gamma;
                let alpha = d[i];
                gamma = c * (alpha - sigma) - s * old;
                d[i + 1] = L::select(open, old + (alpha - gamma), d[i + 1]);
                p = L::select(zero.lt(c), gamma * gamma * over_c, before * b);
            }
            e2[corner] = L::select(open, s * p, e2[corner]);
            d[corner] = L::select(open, sigma + gamma, d[corner]);
        }
    }
    for j in 0..out.len() {
        for i in j + 1..m {
            let (a, b) = (d[j], d[i]);
            let swap = a.lt(b);
            d[j] = L::select(swap, b, a);
            d[i] = L::select(swap, a, b);
        }
        out[j] = d[j];
    }
}
