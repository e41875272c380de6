//! Assembly of one block for a batch of candidates, and the removal of its rigid-body modes.

use super::lane::{Lane, Mask};
use super::plan::{Block, Observation, Products, SlotList};
use crate::envelope::Envelope;

/// Every slot of the list at θ, into `out`.
#[inline(always)]
pub(super) fn evaluate<L: Lane>(list: &SlotList, theta: &[L], out: &mut [L]) {
    for (s, (&constant, value)) in list.constant.iter().zip(out).enumerate() {
        let mut sum = L::splat(constant);
        let terms = list.start[s]..list.start[s + 1];
        for (&p, &c) in list.parameter[terms.clone()].iter().zip(&list.coefficient[terms]) {
            sum = L::splat(c).mul_add(theta[p as usize], sum);
        }
        *value = sum;
    }
}

/// W = (M R)_f L_G⁻ᵀ with L_G L_Gᵀ = Rᵀ M R, in place of (M R)_f; gives the mask of the lanes with positive pivots.
///
/// * `w` - (M R)_f, m x r row by row
/// * `gram` - Rᵀ M R, lower triangle row by row; overwritten by L_G with the reciprocal of its diagonal
#[inline(always)]
pub(super) fn rigid_factor<L: Lane>(r: usize, w: &mut [L], gram: &mut [L]) -> Mask {
    let envelope = |i: usize, j: usize| i * (i + 1) / 2 + j;
    let mut positive = Mask::splat(true);
    for i in 0..r {
        for j in 0..=i {
            let mut sum = gram[envelope(i, j)];
            let least = L::splat(1e-13) * sum.abs();
            for t in 0..j {
                sum = gram[envelope(i, t)].neg_mul_add(gram[envelope(j, t)], sum);
            }
            gram[envelope(i, j)] = if i == j {
                let good = least.lt(sum);
                positive = positive.and(good);
                L::splat(1.0) / L::select(good, sum, L::splat(1.0)).sqrt()
            } else {
                sum * gram[envelope(j, j)]
            };
        }
    }
    for row in w.chunks_exact_mut(r.max(1)) {
        for j in 0..r {
            let mut sum = row[j];
            for t in 0..j {
                sum = gram[envelope(j, t)].neg_mul_add(row[t], sum);
            }
            row[j] = sum * gram[envelope(j, j)];
        }
    }
    positive
}

/// M_ff - W Wᵀ as a full matrix (m x m, both triangles).
#[inline(always)]
pub(super) fn free_mass<L: Lane>(envelope: &Envelope, r: usize, mass: &[L], w: &[L], c: &mut [L]) {
    let m = envelope.rows();
    for i in 0..m {
        let first = envelope.first[i];
        let row = &mass[envelope.row(i)];
        for j in 0..=i {
            let mut value = if j >= first { row[j - first] } else { L::splat(0.0) };
            for k in 0..r {
                value = w[i * r + k].neg_mul_add(w[j * r + k], value);
            }
            c[i * m + j] = value;
            c[j * m + i] = value;
        }
    }
}

/// The rigid part c of the shapes whose supported deformation is ψ, written below it: c = -L_G⁻ᵀ Wᵀ ψ; ψ += R_f c.
///
/// * `x` - ψ in the first m rows, c in the next r ones (width columns, row by row)
#[inline(always)]
pub(super) fn add_rigid<L: Lane>(block: &Block, w: &[L], gram: &[L], x: &mut [L], width: usize, count: usize) {
    let (m, r) = (block.m, block.r);
    let envelope = |i: usize, j: usize| i * (i + 1) / 2 + j;
    let (psi, motion) = x.split_at_mut(m * width);
    for j in 0..count {
        for k in 0..r {
            let mut sum = L::splat(0.0);
            for i in 0..m {
                sum = w[i * r + k].neg_mul_add(psi[i * width + j], sum);
            }
            motion[k * width + j] = sum;
        }
        for k in (0..r).rev() {
            let mut sum = motion[k * width + j];
            for t in k + 1..r {
                sum = gram[envelope(t, k)].neg_mul_add(motion[t * width + j], sum);
            }
            motion[k * width + j] = sum * gram[envelope(k, k)];
        }
    }
    for i in 0..m {
        for k in 0..r {
            let factor = L::splat(block.rigid[i * r + k]);
            for j in 0..count {
                psi[i * width + j] = factor.mul_add(motion[k * width + j], psi[i * width + j]);
            }
        }
    }
}

/// Products of the shapes at the sensors with reference shapes and, last, with themselves, (references + 1 x width). The sensors
/// need not be looked at one by one: a product with a reference is one with a fixed vector of the coordinates.
#[inline(always)]
pub(super) fn project<L: Lane>(products: &Products, x: &[L], width: usize, count: usize, out: &mut [L]) {
    let mut j = 0;
    while j + 4 <= count {
        project_tile::<L, 4>(products, x, width, j, out);
        j += 4;
    }
    while j < count {
        project_tile::<L, 1>(products, x, width, j, out);
        j += 1;
    }
}

/// The products of T shapes, from column j on.
#[inline(always)]
fn project_tile<L: Lane, const T: usize>(products: &Products, x: &[L], width: usize, j: usize, out: &mut [L]) {
    let zero = L::splat(0.0);
    let squares = &products.squares;
    let mut own = [zero; T];
    for s in squares.start.windows(2) {
        let mut sum = [zero; T];
        for (&c, &factor) in squares.coordinate[s[0]..s[1]].iter().zip(&squares.coefficient[s[0]..s[1]]) {
            let (factor, row) = (L::splat(factor), &x[c as usize * width + j..][..T]);
            for t in 0..T {
                sum[t] = factor.mul_add(row[t], sum[t]);
            }
        }
        for t in 0..T {
            own[t] = sum[t].mul_add(sum[t], own[t]);
        }
    }
    let rows = x.len() / width;
    let n = products.references.len() / rows;
    out[n * width + j..][..T].copy_from_slice(&own);
    for (k, reference) in products.references.chunks_exact(rows).enumerate() {
        let mut sum = [zero; T];
        for (&value, row) in reference.iter().zip(x.chunks_exact(width)) {
            let (factor, row) = (L::splat(value), &row[j..j + T]);
            for t in 0..T {
                sum[t] = factor.mul_add(row[t], sum[t]);
            }
        }
        out[k * width + j..][..T].copy_from_slice(&sum);
    }
}

/// Sensor rows of the shapes (rows x width), the shapes being (m + r) x width.
#[inline(always)]
pub(super) fn observe<L: Lane>(observation: &Observation, x: &[L], width: usize, count: usize, out: &mut [L]) {
    let rows = observation.start.len() - 1;
    for s in 0..rows {
        let target = &mut out[s * width..][..count];
        target.fill(L::splat(0.0));
        for at in observation.start[s]..observation.start[s + 1] {
            let row = &x[observation.coordinate[at] as usize * width..][..count];
            let factor = L::splat(observation.coefficient[at]);
            for (t, &value) in target.iter_mut().zip(row) {
                *t = factor.mul_add(value, *t);
            }
        }
    }
}
