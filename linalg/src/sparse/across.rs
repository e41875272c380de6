//! Systems K - λM across modes that are known, without a factor of their own: by conjugate gradients.

use super::matrix::SparseSym;
use super::shifted::PencilFactor;
use crate::{DMatrix, tall_take, tall_tr_mul};

/// Steps after which an answer is as good as it gets.
const MOST_STEPS: usize = 60;

/// W with Φᵀ M W = 0 and (K - λ_c M) w_c = f_c in all directions across Φ, one λ for each column.
///
/// ```text
/// P (K - λ_c M) Pᵀ w_c = P f_c,   P = I - M Φ Φᵀ
/// ```
///
/// The operator is positive definite where Φ holds every mode up to λ_c. Conjugate gradients are preconditioned by the factor of K₀ + aM₀, those
/// of a neighbour serve as well; with λ₊ the first mode that is not in Φ the condition is (λ₊ + a)/(λ₊ - λ_c) where the factor is that of the
/// matrices. A column stops at the tolerance, after sixty steps, or where λ₊ turns out to lie below λ_c, with what it has by then; which have
/// reached the tolerance comes with W.
///
/// * `factor` - of K₀ + aM₀, of the same size
/// * `known` - Φ, M-orthonormal (n x any number)
/// * `lambda` - of every column
/// * `forces` - F, (n x columns)
/// * `tolerance` - part of the force, in the norm of the preconditioner, that may be left
///
/// # Panics
/// If sizes differ.
///
/// # Source
/// Y. Notay, Combination of Jacobi-Davidson and conjugate gradients for the partial symmetric eigenproblem, Numerical Linear Algebra with
/// Applications 9, 2002: the same projected systems.
pub fn solve_across_modes(
    factor: &PencilFactor,
    k: &SparseSym,
    m: &SparseSym,
    known: &DMatrix<f64>,
    lambda: &[f64],
    forces: &DMatrix<f64>,
    tolerance: f64,
) -> (DMatrix<f64>, Vec<bool>) {
    let (n, count) = forces.shape();
    assert_eq!(lambda.len(), count, "a λ for each column");
    let m_known = m.mul(known);
    let force_across = |r: &mut DMatrix<f64>| {
        let along = tall_tr_mul(known, r);
        tall_take(r, &m_known, &along);
    };
    let shape_across = |x: &mut DMatrix<f64>| {
        let along = tall_tr_mul(&m_known, x);
        tall_take(x, known, &along);
    };
    let dots = |a: &DMatrix<f64>, b: &DMatrix<f64>| -> Vec<f64> {
        a.column_iter().zip(b.column_iter()).map(|(a, b)| a.dot(&b)).collect()
    };
    let mut w = DMatrix::zeros(n, count);
    let mut r = forces.clone();
    force_across(&mut r);
    let mut z = factor.solve(&r);
    shape_across(&mut z);
    let mut p = z.clone();
    let mut size = dots(&r, &z);
    let goal: Vec<f64> = size.iter().map(|s| s * tolerance * tolerance).collect();
    let mut runs: Vec<bool> = size.iter().map(|s| *s > 0.0).collect();
    for _ in 0..MOST_STEPS {
        if !runs.contains(&true) {
            break;
        }
        let mut ap = k.mul(&p);
        let mp = m.mul(&p);
        for (c, l) in lambda.iter().enumerate() {
            ap.column_mut(c).axpy(-l, &mp.column(c), 1.0);
        }
        force_across(&mut ap);
        let curvature = dots(&p, &ap);
        for c in 0..count {
            runs[c] &= curvature[c] > 0.0;
            if runs[c] {
                let step = size[c] / curvature[c];
                w.column_mut(c).axpy(step, &p.column(c), 1.0);
                r.column_mut(c).axpy(-step, &ap.column(c), 1.0);
            }
        }
        z = factor.solve(&r);
        shape_across(&mut z);
        let next = dots(&r, &z);
        for c in 0..count {
            runs[c] &= next[c] > goal[c];
            if runs[c] {
                let turn = next[c] / size[c];
                let mut p = p.column_mut(c);
                p *= turn;
                p += z.column(c);
            }
        }
        size = next;
    }
    shape_across(&mut w);
    let is_solved = size.iter().zip(&goal).map(|(size, goal)| size <= goal).collect();
    (w, is_solved)
}
