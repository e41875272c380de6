//! All eigenvalues of small symmetric tridiagonal matrices: the QL iteration without square roots.
//!
//! ```text
//! T - σ = Q L,  T <- L Q + σ,   on d_i and e_i² alone;  σ from the leading 2 x 2 block
//! ```
//!
//! A step works on the whole matrix below the converged corner, which every lane has for itself. A row waits for one division, and
//! several matrices go side by side to fill the wait. Eigenvalues are exact to rounding of the largest one, which has size one
//! here: the residual test after inverse iteration judges the small ones.
//!
//! Source: B. N. Parlett, The Symmetric Eigenvalue Problem, 1998, section 8.15 (Pal-Walker-Kahan variant).

use super::lane::{Lane, Mask};
use super::sturm::Tridiagonal;

/// Below this an off-diagonal entry squared moves no eigenvalue by more than rounding, beside a matrix of norm one: by its ratio to
/// the gap, which inverse iteration sees to where there is none.
const NOTHING: f64 = 1e-24;
/// Steps, for one eigenvalue on average, after which they are taken as they are.
const STEPS: usize = 30;
/// Least p that the quotient takes: below it the limit for p = 0 holds.
const LEAST: f64 = 1e-150;

/// A tridiagonal matrix of size m on which the iteration works, by its diagonal and the squares of its off-diagonal.
pub(super) struct Squared<'a, L> {
    /// At least m numbers.
    pub(super) d: &'a mut [L],
    /// At least m numbers; the last one does not belong to the matrix.
    pub(super) e2: &'a mut [L],
}

impl<L: Lane> Squared<'_, L> {
    /// Takes a matrix over, whose eigenvalues are in [0, 1]; rows beyond it are coupled to nothing, and far from any shift.
    #[inline(always)]
    pub(super) fn take(&mut self, t: Tridiagonal<'_, L>) {
        let m = t.d.len();
        self.d[..m].copy_from_slice(t.d);
        self.e2[..m].copy_from_slice(&t.e2[..m]);
        self.e2[m - 1] = L::splat(0.0);
        self.d[m..].fill(L::splat(-1.0));
        self.e2[m..].fill(L::splat(0.0));
    }
}

/// All eigenvalues of several matrices side by side, on their diagonals: one waits for its divisions while another works. All
/// have `m` rows, the smaller ones filled up.
///
/// Every lane has a corner of its own. The rows above it have converged: they are coupled to nothing (e² = 0 gives s = 0, which
/// keeps it zero and ends the step of this lane there), and their eigenvalues stay as they are while others go on.
#[inline(always)]
pub(super) fn all_eigenvalues<L: Lane, const A: usize>(m: usize, t: &mut [Squared<'_, L>; A]) {
    let (zero, one) = (L::splat(0.0), L::splat(1.0));
    let is_at_most = |corner: L, row: usize| corner.lt(L::splat(row as f64 + 0.5));
    let mut corner = [zero; A];
    // The least and the greatest corner of a lane that has not converged.
    let (mut first, mut last) = (0, 0);
    for _ in 0..STEPS * m {
        let (mut d0, mut d1, mut b) = ([zero; A], [one; A], [one; A]);
        let mut row = first;
        let mut least = m;
        while row <= last && row + 1 < m {
            let mut open = Mask::splat(false);
            let mut moves = Mask::splat(false);
            for a in 0..A {
                let (d, e2) = (&t[a].d, &mut t[a].e2);
                let here = is_at_most(corner[a], row);
                let here = if row > 0 { here.and(is_at_most(corner[a], row - 1).not()) } else { here };
                let stays = here.and(L::splat(NOTHING).lt(e2[row]));
                let converged = here.and(stays.not());
                let next = if row + 2 == m { L::splat(f64::MAX) } else { L::splat((row + 1) as f64) };
                corner[a] = L::select(converged, next, corner[a]);
                e2[row] = L::select(converged, zero, e2[row]);
                d0[a] = L::select(stays, d[row], d0[a]);
                d1[a] = L::select(stays, d[row + 1], d1[a]);
                b[a] = L::select(stays, e2[row], b[a]);
                open = open.or(stays);
                moves = moves.or(converged);
            }
            if open.any() {
                least = least.min(row);
            }
            if moves.any() {
                last = last.max(row + 1);
            }
            row += 1;
        }
        if least == m {
            break;
        }
        first = least;
        let (mut c, mut s, mut gamma, mut p, mut sigma) = ([one; A], [zero; A], [zero; A], [zero; A], [zero; A]);
        for a in 0..A {
            // The eigenvalue of the leading block that is nearer to d.
            let root = b[a].max(L::splat(LEAST)).sqrt();
            let ratio = (d1[a] - d0[a]) / (root + root);
            let length = ratio.mul_add(ratio, one).sqrt();
            let sum = ratio + L::select(ratio.lt(zero), -length, length);
            sigma[a] = d0[a] - root / sum;
            gamma[a] = t[a].d[m - 1] - sigma[a];
            p[a] = gamma[a] * gamma[a];
        }
        for i in (first..m - 1).rev() {
            for a in 0..A {
                let (d, e2) = (&mut t[a].d[i..i + 2], &mut t[a].e2[i..i + 2]);
                let b = e2[0];
                let vanishes = p[a].lt(L::splat(LEAST));
                let q = p[a].max(L::splat(LEAST));
                let r = q + b;
                e2[1] = s[a] * r;
                // One division for c = q/r, s = b/r and 1/c = r/q.
                let inverse = one / (q * r);
                let over_c = r * r * inverse;
                let before = c[a];
                c[a] = q * q * inverse;
                s[a] = b * q * inverse;
                let (old, alpha) = (gamma[a], d[0]);
                gamma[a] = c[a] * (alpha - sigma[a]) - s[a] * old;
                // The row of the corner is the last one that this step changes.
                let kept = L::select(is_at_most(corner[a], i + 1), sigma[a] + old, d[1]);
                d[1] = L::select(is_at_most(corner[a], i), old + (alpha - gamma[a]), kept);
                p[a] = L::select(vanishes, before * b, gamma[a] * gamma[a] * over_c);
            }
        }
        for a in 0..A {
            t[a].e2[first] = s[a] * p[a].max(L::splat(LEAST));
            t[a].d[first] = L::select(is_at_most(corner[a], first), sigma[a] + gamma[a], t[a].d[first]);
        }
    }
}

/// Puts the numbers in descending order.
#[inline(always)]
pub(super) fn sort<L: Lane>(d: &mut [L]) {
    for j in 1..d.len() {
        for i in (0..j).rev() {
            let (a, b) = (d[i], d[i + 1]);
            let swap = a.lt(b);
            d[i] = L::select(swap, b, a);
            d[i + 1] = L::select(swap, a, b);
        }
    }
}
