//! Stiffness of a free part whose files have few digits: what is left of stiffness against rigid motions is taken out.

use crate::linalg::{DMatrix, thin_svd};
use crate::matrices::{Entry, Symmetric};
use crate::model::dof_map::rigid_motion;
use crate::model::exported::{ExportedDof, ExportedNode};

/// Dofs above which the result, which is full, is not worth its memory.
pub(super) const MOST_DOFS: usize = 3_000;
/// A change above this part of the entries' scale is not rounding.
pub(super) const MOST_CHANGE: f64 = 1e-5;

/// K' = Pᵀ K P with P = I - Q Qᵀ, Q an orthonormal basis of the rigid motions, all scaled by √K_ii; and the largest change of an entry,
/// of √(K_ii K_jj). `None` where a displacement has no stiffness, or nothing is known of rigid motions.
pub(super) fn freed(k: &Symmetric, dofs: &[ExportedDof], nodes: &[ExportedNode]) -> Option<(Symmetric, f64)> {
    let n = dofs.len();
    let mut dense: DMatrix<f64> = DMatrix::zeros(n, n);
    for e in &k.lower {
        dense[(e.row as usize, e.column as usize)] = e.value;
        dense[(e.column as usize, e.row as usize)] = e.value;
    }
    let scale: Vec<f64> = (0..n).map(|i| dense[(i, i)].sqrt()).collect();
    if scale.iter().any(|s| s.is_nan()) {
        return None;
    }
    let inverse = |i: usize| if scale[i] > 0.0 { 1.0 / scale[i] } else { 0.0 };
    let scaled = DMatrix::from_fn(n, n, |i, j| dense[(i, j)] * inverse(i) * inverse(j));
    let motions = DMatrix::from_fn(n, 6, |i, motion| {
        let (Some(dof), Some(at)) = (dofs[i].dof, nodes[dofs[i].node].position) else { return 0.0 };
        let u = rigid_motion(at, motion);
        let first = if dof.is_rotation() { 3 } else { 0 };
        scale[i] * (0..3).map(|c| dofs[i].axis[c] * u[first + c]).sum::<f64>()
    });
    let svd = thin_svd(&motions).ok()?;
    let largest = svd.values.iter().copied().fold(0.0, f64::max);
    let rank = svd.values.iter().filter(|v| **v > 1e-9 * largest).count();
    if rank == 0 {
        return None;
    }
    let q = svd.left.columns(0, rank).into_owned();
    let force = &scaled * &q;
    let energy = q.transpose() * &force;
    // K - Q Fᵀ - F Qᵀ + Q (Qᵀ F) Qᵀ
    let change = &q * force.transpose() + &force * q.transpose() - &q * energy * q.transpose();
    let mut lower = Vec::with_capacity(n * (n + 1) / 2);
    for j in 0..n {
        for i in j..n {
            let value = dense[(i, j)] - 0.5 * (change[(i, j)] + change[(j, i)]) * scale[i] * scale[j];
            if value != 0.0 {
                lower.push(Entry { row: i as u32, column: j as u32, value });
            }
        }
    }
    Some((Symmetric { n, lower, asymmetry: k.asymmetry }, change.amax()))
}
