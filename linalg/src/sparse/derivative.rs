//! Systems whose matrix is singular along one mode or a few: derivatives of shapes.

use super::matrix::SparseSym;
use super::plan::SparsePlan;
use crate::{DMatrix, LinalgError};

/// Z with (K - λM) Z = F - MΦ ΦᵀF and Φᵀ M Z = 0: beside a mode, or outside the space of a cluster of modes whose λ are equal or nearly so.
///
/// * `plan` - of a pattern that covers `k` and `m`
/// * `lambda` - of the cluster
/// * `cluster` - Φ, M-orthonormal, any basis of the space, (n x size)
/// * `forces` - F, (n x any number)
///
/// K - λM is singular, or nearly, along Φ. B = K - λM + P D Pᵀ, with a spring D at as many dofs as there are modes, where these move, has the same
/// pattern and is not; the border takes the springs out again:
///
/// ```text
/// [ B       MΦ   P    ] [ Z ]   [ F - MΦ ΦᵀF ]
/// [ (MΦ)ᵀ   0    0    ] [ μ ] = [ 0          ]      y = -D Pᵀ Z
/// [ Pᵀ      0    D⁻¹  ] [ y ]   [ 0          ]
/// ```
///
/// B is factored as LDLᵀ and the solution refined once. An error of the shapes changes Z by as much. `None` where one more mode has this λ.
///
/// # Errors
/// [`LinalgError::OutOfMemory`].
///
/// # Panics
/// If sizes differ, or the plan's pattern does not cover the matrices.
///
/// # Source
/// The bordered form of R. B. Nelson's method: I. W. Lee, G. H. Jung, An efficient algebraic method for the computation of natural frequency and mode
/// shape sensitivities, Computers & Structures 62(3), 1997, for several modes; M. A. Woodbury's identity for the border.
pub fn solve_beside_modes(
    plan: &SparsePlan,
    k: &SparseSym,
    m: &SparseSym,
    lambda: f64,
    cluster: &DMatrix<f64>,
    forces: &DMatrix<f64>,
) -> Result<Option<DMatrix<f64>>, LinalgError> {
    let (n, size) = cluster.shape();
    if forces.ncols() == 0 || n == 0 {
        return Ok(Some(DMatrix::zeros(n, forces.ncols())));
    }
    let m_phi = m.mul(cluster);
    let right = plan.ordered_rows(&(forces - &m_phi * cluster.tr_mul(forces)));
    // Borders of the size of stiffnesses.
    let border = plan.ordered_rows(&m_phi) * lambda.abs().sqrt();
    let stiffness = |i: usize| k.diagonal(plan.order[i]).max(0.0);
    let held = independent_rows(&plan.ordered_rows(cluster), |i| stiffness(i).sqrt(), size);
    let shifted = plan.pencil(k, m).shifted(-lambda);
    let mut supported = shifted.clone();
    let mut springs = DMatrix::zeros(n, size);
    for (c, &i) in held.iter().enumerate() {
        let spring = stiffness(i).max(f64::MIN_POSITIVE);
        let own = supported.columns[i]..supported.columns[i + 1];
        let Some(p) = own.into_iter().find(|&p| supported.rows[p] == i) else { return Ok(None) };
        supported.values[p] += spring;
        springs[(i, c)] = spring.sqrt();
    }
    let factor = plan.structure.indefinite(&supported, plan.structure.values()?)?;
    let count = right.ncols();
    let mut borders = DMatrix::zeros(n, 2 * size);
    borders.columns_mut(0, size).copy_from(&border);
    borders.columns_mut(size, size).copy_from(&springs);
    let mut all = DMatrix::zeros(n, count + 2 * size);
    all.columns_mut(0, count).copy_from(&right);
    all.columns_mut(count, 2 * size).copy_from(&borders);
    factor.solve(&mut all)?;
    let moves = all.columns(count, 2 * size).into_owned();
    let mut schur = borders.tr_mul(&moves);
    (size..2 * size).for_each(|c| schur[(c, c)] -= 1.0);
    let schur = schur.lu();
    // Z and μ of a solution with B for forces across the border, g along it.
    let bordered = |mut z: DMatrix<f64>, g: &DMatrix<f64>| -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let mut beside = borders.tr_mul(&z);
        let mut upper = beside.rows_mut(0, size);
        upper -= g;
        let forces = schur.solve(&beside)?;
        z -= &moves * &forces;
        Some((z, forces.rows(0, size).into_owned()))
    };
    let first = bordered(all.columns(0, count).into_owned(), &DMatrix::zeros(size, count));
    let Some((mut z, mut mu)) = first else { return Ok(None) };
    let left = |z: &DMatrix<f64>, mu: &DMatrix<f64>| &right - shifted.mul(z) - &border * mu;
    let mut correction = left(&z, &mu);
    factor.solve(&mut correction)?;
    let Some((dz, dmu)) = bordered(correction, &-border.tr_mul(&z)) else { return Ok(None) };
    // With one more mode of this λ the border is singular still: then what is solved does not satisfy the equations, or is rounding.
    // Forces that move the cluster and hardly anything else, as those of one modulus of the whole structure, leave rounding of these alone.
    let along = (cluster * cluster.tr_mul(forces)).norm() / lambda.abs().max(f64::MIN_POSITIVE);
    let is_rounding = dz.norm() > 1e-4 * z.norm() + 1e-6 * along;
    z += dz;
    mu += dmu;
    let scale = shifted.abs().mul(&z.abs()).amax() + forces.amax();
    if is_rounding || !z.iter().all(|v| v.is_finite()) || left(&z, &mu).amax() > 1e-8 * scale {
        return Ok(None);
    }
    Ok(Some(plan.restored_rows(&z)))
}

/// Rows of a matrix of few columns that are as independent as can be: each has the largest part across those before it.
fn independent_rows(a: &DMatrix<f64>, weight: impl Fn(usize) -> f64, count: usize) -> Vec<usize> {
    let mut rest = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| weight(i) * a[(i, j)]);
    let mut chosen = Vec::with_capacity(count);
    for _ in 0..count {
        let best = (0..rest.nrows()).map(|i| (i, rest.row(i).norm_squared()));
        let Some((row, _)) = best.filter(|b| !chosen.contains(&b.0)).reduce(|a, b| if b.1 > a.1 { b } else { a })
        else {
            break;
        };
        chosen.push(row);
        let direction = rest.row(row).normalize();
        if direction.iter().all(|v| v.is_finite()) {
            let along = &rest * direction.transpose();
            rest -= along * direction;
        }
    }
    chosen
}
