//! Blocks of vectors that are orthonormal in the mass inner product, and what makes them so.

use super::kernel::{Row, Small, WIDTH, grams, multiply, subtract, transform};
use super::matrix::SparseSym;

/// A block of [`WIDTH`] vectors, row by row.
pub(super) type Block = Vec<Row>;

/// The unit matrix.
pub(super) fn identity() -> Small {
    let mut a = [[0.0; WIDTH]; WIDTH];
    for (i, row) in a.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    a
}

/// a b.
pub(super) fn product(a: &Small, b: &Small) -> Small {
    let mut c = [[0.0; WIDTH]; WIDTH];
    for i in 0..WIDTH {
        for k in 0..WIDTH {
            for j in 0..WIDTH {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// Numbers between -1/2 and 1/2 that depend on their index only, so that a solution never depends on who asks for it.
///
/// # Source
/// G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014 (SplitMix64).
pub(super) fn scattered(index: u64) -> f64 {
    let mut z = index.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 - 0.5
}

/// A block of such numbers.
pub(super) fn scattered_block(n: usize, seed: u64) -> Block {
    let row = |i: usize| std::array::from_fn(|l| scattered(seed.wrapping_mul(1 << 40) + (i * WIDTH + l) as u64));
    (0..n).map(row).collect()
}

/// The result of [`orthonormalise`].
pub(super) struct Orthonormal {
    /// R with W = Q R, the parts along the given blocks aside.
    pub(super) r: Small,
    /// Coefficients along each of the given blocks.
    pub(super) coefficients: Vec<Small>,
    /// Whether nothing is left of the block, nor of random vectors: the given blocks span all.
    pub(super) is_empty: bool,
}

/// Makes `w` M-orthogonal to `blocks` and M-orthonormal in itself, and overwrites `mw` by M w.
///
/// * `near` - indices of the blocks that `w` has large parts along; these parts are taken off first, so that one more
///   pass over all blocks leaves only rounding
/// * `seed` - of the random vectors
///
/// A vector that depends on the others is replaced by a random one; where there is none left, by zero.
///
/// # Source
/// G. W. Stewart, Matrix Algorithms II: Eigensystems, SIAM 2001, section 5.3 (full reorthogonalisation); the block itself
/// by the Cholesky factor of its Gram matrix, repeated while that is ill conditioned.
pub(super) fn orthonormalise(
    m: &SparseSym,
    w: &mut Block,
    mw: &mut Block,
    blocks: &[&[Row]],
    near: &[usize],
    seed: u64,
) -> Orthonormal {
    let mut coefficients = vec![[[0.0; WIDTH]; WIDTH]; blocks.len()];
    multiply(m, w, mw);
    let mut gram = [[[0.0; WIDTH]; WIDTH]];
    grams(&[w], mw, &mut gram);
    let scale: Vec<f64> = (0..WIDTH).map(|l| gram[0][l][l]).collect();
    let close: Vec<&[Row]> = near.iter().map(|&i| blocks[i]).collect();
    let mut parts = vec![[[0.0; WIDTH]; WIDTH]; close.len()];
    grams(&close, mw, &mut parts);
    subtract(w, &close, &parts);
    for (&i, part) in near.iter().zip(&parts) {
        coefficients[i] = *part;
    }
    let mut r = identity();
    let mut dropped = [false; WIDTH];
    let mut parts = vec![[[0.0; WIDTH]; WIDTH]; blocks.len()];
    let mut is_empty = false;
    for _ in 0..MOST_PASSES {
        multiply(m, w, mw);
        grams(blocks, mw, &mut parts);
        subtract(w, blocks, &parts);
        for (sum, part) in coefficients.iter_mut().zip(&parts) {
            let part = product(part, &r);
            for (a, b) in sum.iter_mut().flatten().zip(part.iter().flatten()) {
                *a += b;
            }
        }
        multiply(m, w, mw);
        grams(&[w], mw, &mut gram);
        // Rounding of the vectors that came in; those that a random vector has replaced have unit length.
        let limit: Row = std::array::from_fn(|l| if dropped[l] { 1e-16 } else { 1e-28 * scale[l] / r[l][l].powi(2) });
        let factor = cholesky(&gram[0], &limit);
        transform(w, &factor.inverse);
        transform(mw, &factor.inverse);
        r = product(&factor.r, &r);
        for l in (0..WIDTH).filter(|&l| factor.is_lost[l]) {
            r[l] = [0.0; WIDTH];
        }
        let lost: Vec<usize> = (0..WIDTH).filter(|&l| factor.is_lost[l]).collect();
        if lost.is_empty() && factor.worst > 1e-4 {
            break;
        }
        // A vector that is lost once more lies in the span of all: there is no other.
        for &l in lost.iter().filter(|&&l| !dropped[l]) {
            for (i, row) in w.iter_mut().enumerate() {
                row[l] = scattered(seed.wrapping_mul(1 << 41) + (i * WIDTH + l) as u64);
            }
        }
        if !lost.is_empty() {
            normalise(m, w, mw, &lost);
        }
        let settled = lost.iter().all(|&l| dropped[l]) && factor.worst > 1e-4;
        is_empty = settled && lost.len() == WIDTH;
        for l in lost {
            dropped[l] = true;
        }
        if settled {
            break;
        }
    }
    Orthonormal { r, coefficients, is_empty }
}

/// Scales the vectors `which` to unit M-norm; a zero one stays zero.
fn normalise(m: &SparseSym, w: &mut Block, mw: &mut Block, which: &[usize]) {
    multiply(m, w, mw);
    let mut gram = [[[0.0; WIDTH]; WIDTH]];
    grams(&[w], mw, &mut gram);
    let mut factor = identity();
    for &l in which {
        factor[l][l] = if gram[0][l][l] > 0.0 { 1.0 / gram[0][l][l].sqrt() } else { 0.0 };
    }
    transform(w, &factor);
}

/// Passes until a block is orthonormal, at most; most blocks take one.
const MOST_PASSES: usize = 12;
/// A pivot below this part of its diagonal entry is not known: rounding of a Gram matrix of blocks that are nearly dependent is some 10⁻¹³ of it.
const UNKNOWN: f64 = 1e-10;

/// Upper triangle R with RᵀR = G, but for what is not known of G.
struct SmallCholesky {
    r: Small,
    /// R⁻¹, a zero column where a vector is lost.
    inverse: Small,
    /// Vectors of which nothing is left.
    is_lost: [bool; WIDTH],
    /// The least ratio of a pivot to its diagonal entry.
    worst: f64,
}

/// A vector whose pivot is not known is taken apart from those before it and enlarged by a safe factor, and those after it are not taken apart from
/// it: products with what rounding has left are rounding too, and a quotient of the two grows from vector to vector. The next pass knows more.
fn cholesky(g: &Small, limit: &Row) -> SmallCholesky {
    let mut r = [[0.0; WIDTH]; WIDTH];
    let mut is_lost = [false; WIDTH];
    let mut is_known = [false; WIDTH];
    let mut worst = 1.0f64;
    for j in 0..WIDTH {
        for i in (0..j).filter(|&i| is_known[i]) {
            let sum: f64 = (0..i).map(|k| r[k][i] * r[k][j]).sum();
            r[i][j] = (0.5 * (g[i][j] + g[j][i]) - sum) / r[i][i];
        }
        if g[j][j] <= limit[j] {
            is_lost[j] = true;
            continue;
        }
        let pivot = g[j][j] - (0..j).map(|k| r[k][j] * r[k][j]).sum::<f64>();
        is_known[j] = pivot > UNKNOWN * g[j][j];
        let pivot = pivot.max(UNKNOWN * g[j][j]);
        worst = worst.min(pivot / g[j][j]);
        r[j][j] = pivot.sqrt();
    }
    let mut inverse = [[0.0; WIDTH]; WIDTH];
    for j in (0..WIDTH).filter(|&j| !is_lost[j]) {
        inverse[j][j] = 1.0 / r[j][j];
        for i in (0..j).rev().filter(|&i| !is_lost[i]) {
            let sum: f64 = (i + 1..=j).map(|k| r[i][k] * inverse[k][j]).sum();
            inverse[i][j] = -sum / r[i][i];
        }
    }
    SmallCholesky { r, inverse, is_lost, worst }
}
