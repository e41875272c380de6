//! A matrix of damping in its parts: what vectors of the structure leave uncoupled, and dashpots.

use crate::{DMatrix, symmetric_eigen};

/// Most dashpots, as the rank of what they make: every one is a load more.
const MOST_DASHPOTS: usize = 12;
/// Most dofs that they hold.
const MOST_ROWS: usize = 48;
/// Share of the largest entry of C below which one is rounding.
const ROUNDING: f64 = 1e-12;
/// Share of the largest entry of C to which one agrees with Rayleigh's damping before that is refined.
const AGREEING: f64 = 1e-6;

/// C = αM + βK + W Γ Wᵀ.
#[derive(Debug, Clone)]
pub(super) struct Damping {
    /// α, 1/s.
    pub(super) by_mass: f64,
    /// β, s.
    pub(super) by_stiffness: f64,
    /// Γ.
    pub(super) values: Vec<f64>,
    /// W, (n x n_dashpots).
    pub(super) vectors: DMatrix<f64>,
}

impl Damping {
    /// The parts of C; `None` where dashpots hold more than [`MOST_ROWS`] dofs, or are more than [`MOST_DASHPOTS`].
    ///
    /// α and β are those of the greater part of the entries, if any: elements in proportion, and a few dashpots or springs that are not.
    pub(super) fn split(k: &DMatrix<f64>, m: &DMatrix<f64>, c: Option<&DMatrix<f64>>) -> Option<Self> {
        let n = k.nrows();
        let Some(c) = c.filter(|c| c.iter().any(|v| *v != 0.0)) else {
            return Some(Self { by_mass: 0.0, by_stiffness: 0.0, values: Vec::new(), vectors: DMatrix::zeros(n, 0) });
        };
        let alone = || Self::remaining(k, m, c, [0.0, 0.0]);
        alone().or_else(|| Self::remaining(k, m, c, rayleigh(k, m, c)?))
    }

    /// What is left of C as dashpots.
    fn remaining(
        k: &DMatrix<f64>,
        m: &DMatrix<f64>,
        c: &DMatrix<f64>,
        [by_mass, by_stiffness]: [f64; 2],
    ) -> Option<Self> {
        let n = k.nrows();
        let limit = ROUNDING * c.amax();
        let left = |i: usize, j: usize| {
            let v = c[(i, j)] - by_mass * m[(i, j)] - by_stiffness * k[(i, j)];
            if v.abs() > limit { v } else { 0.0 }
        };
        let held: Vec<usize> = (0..n).filter(|&i| (0..n).any(|j| left(i.max(j), i.min(j)) != 0.0)).collect();
        if held.len() > MOST_ROWS {
            return None;
        }
        let block = DMatrix::from_fn(held.len(), held.len(), |p, q| {
            let (i, j) = (held[p.max(q)], held[p.min(q)]);
            left(i.max(j), i.min(j))
        });
        let parts = symmetric_eigen(&block).ok()?;
        let least = ROUNDING * parts.values.amax();
        let kept: Vec<usize> = (0..held.len()).filter(|&p| parts.values[p].abs() > least).collect();
        if kept.len() > MOST_DASHPOTS {
            return None;
        }
        let mut vectors = DMatrix::zeros(n, kept.len());
        for (q, &p) in kept.iter().enumerate() {
            held.iter().enumerate().for_each(|(row, &dof)| vectors[(dof, q)] = parts.vectors[(row, p)]);
        }
        let values = kept.iter().map(|&p| parts.values[p]).collect();
        Some(Self { by_mass, by_stiffness, values, vectors })
    }
}

/// α and β: the median of what each row says, then of all entries that agree with it.
///
/// # Source
/// P. J. Rousseeuw, A. M. Leroy, Robust Regression and Outlier Detection, 1987: subsets, and a fit of what agrees with the best of them.
fn rayleigh(k: &DMatrix<f64>, m: &DMatrix<f64>, c: &DMatrix<f64>) -> Option<[f64; 2]> {
    let n = k.nrows();
    let scales = [m.amax(), k.amax()].map(|scale| scale.max(f64::MIN_POSITIVE));
    let at = |i: usize, j: usize| {
        let lower = (i.max(j), i.min(j));
        [m[lower] / scales[0], k[lower] / scales[1], c[lower]]
    };
    let of_rows: Vec<[f64; 2]> = (0..n).filter_map(|i| proportions((0..n).map(|j| at(i, j)))).collect();
    let median = |which: usize| {
        let mut all: Vec<f64> = of_rows.iter().map(|own| own[which]).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied()
    };
    let first = [median(0)?, median(1)?];
    let largest = c.amax();
    let is_like = |&[m, k, c]: &[f64; 3]| (c - first[0] * m - first[1] * k).abs() <= AGREEING * largest;
    let all = (0..n).flat_map(|j| (j..n).map(move |i| (i, j))).map(|(i, j)| at(i, j));
    let [by_mass, by_stiffness] = proportions(all.filter(is_like))?;
    Some([by_mass / scales[0], by_stiffness / scales[1]])
}

/// The c = αm + βk of some entries by least squares; `None` where they do not tell both.
fn proportions(entries: impl Iterator<Item = [f64; 3]>) -> Option<[f64; 2]> {
    const TOLD: f64 = 1e-10;
    let mut sums = [[0.0; 3]; 2];
    for own in entries {
        for p in 0..2 {
            (0..3).for_each(|q| sums[p][q] += own[p] * own[q]);
        }
    }
    let [[mm, mk, mc], [_, kk, kc]] = sums;
    let det = mm * kk - mk * mk;
    (det > TOLD * mm * kk).then(|| [(mc * kk - kc * mk) / det, (kc * mm - mc * mk) / det])
}
