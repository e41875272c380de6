//! What a matrix is, as far as its numbers and the places of its dofs tell.

use super::matrix::{DofRow, Matrix, Symmetric, SymmetryError};
use crate::linalg::LinalgError;
use crate::linalg::sparse::{SparsePlan, SparseSym, count_negative};
use std::collections::HashMap;

/// What is known of one matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Number of entries that are not zero, both triangles counted.
    pub n_entries: usize,
    /// Whether it is symmetric, and how far it is off; or why not.
    pub symmetry: Result<f64, SymmetryError>,
    /// Rows without any entry.
    pub empty_rows: Vec<usize>,
    /// Number of negative and of zero eigenvalues, by the inertia of A ± 1e-10 |diag A|; `None` of one that is not symmetric, or too large.
    pub inertia: Option<[usize; 2]>,
    /// |A r| over |A| |r| of the six rigid motions about the origin, where places are known.
    pub rigid: Option<[f64; 6]>,
    /// rᵀ A r of the three translations, where places are known: of a mass matrix the mass.
    pub translations: Option<[f64; 3]>,
}

/// What of a rigid motion is left in a stiffness matrix by rounding, at most.
pub const RIGID: f64 = 1e-6;
/// Most entries of a matrix that is factorised for its inertia.
const MOST_ENTRIES: usize = 20_000_000;
/// Part of the diagonal that counts as zero.
const ZERO: f64 = 1e-10;

/// Looks at a matrix.
///
/// * `dofs` - what its rows are, if as many as it has rows
pub fn inspect(matrix: &Matrix, dofs: &[DofRow]) -> Inspection {
    let full = matrix.full();
    let mut used = vec![false; matrix.n_rows.min(full.len().saturating_mul(2).saturating_add(1 << 20))];
    for e in &full {
        if let Some(used) = used.get_mut(e.row as usize) {
            *used = true;
        }
    }
    let symmetric = matrix.symmetric(false);
    let motions = motions(dofs).filter(|m| m.len() == matrix.n_rows);
    let rigid = symmetric.as_ref().ok().zip(motions.as_ref()).map(|(a, r)| rigid(a, r));
    Inspection {
        n_entries: full.len(),
        empty_rows: (0..used.len()).filter(|&i| !used[i]).collect(),
        inertia: symmetric.as_ref().ok().and_then(|a| inertia(a).ok().flatten()),
        rigid: rigid.map(|r| r.0),
        translations: rigid.map(|r| r.1),
        symmetry: symmetric.map(|a| a.asymmetry),
    }
}

/// Values of the dofs in unit rigid motions about the origin; `None` where a place is not known.
fn motions(dofs: &[DofRow]) -> Option<Vec<[f64; 6]>> {
    let of = |row: &DofRow| {
        let Some(dof) = row.label.dof else { return Some([0.0; 6]) };
        let p = row.position.filter(|_| row.frame.is_none())?;
        let (axis, mut u) = (dof.axis(), [0.0; 6]);
        if dof.is_rotation() {
            u[3 + axis] = 1.0;
        } else {
            u[axis] = 1.0;
            // (θ × p) along an axis.
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            u[3 + next] = p[last];
            u[3 + last] = -p[next];
        }
        Some(u)
    };
    (!dofs.is_empty()).then(|| dofs.iter().map(of).collect()).flatten()
}

fn rigid(a: &Symmetric, motions: &[[f64; 6]]) -> ([f64; 6], [f64; 3]) {
    let n = motions.len();
    let (mut residual, mut translations) = ([0.0; 6], [0.0; 3]);
    for motion in 0..6 {
        let (mut force, mut size) = (vec![0.0; n], vec![0.0; n]);
        for e in &a.lower {
            let (i, j) = (e.row as usize, e.column as usize);
            let pairs = [(i, j), (j, i)];
            for &(i, j) in &pairs[..if i == j { 1 } else { 2 }] {
                force[i] += e.value * motions[j][motion];
                size[i] += (e.value * motions[j][motion]).abs();
            }
        }
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        residual[motion] = if norm(&size) > 0.0 { norm(&force) / norm(&size) } else { 0.0 };
        if motion < 3 {
            translations[motion] = force.iter().zip(motions).map(|(f, r)| f * r[motion]).sum();
        }
    }
    (residual, translations)
}

/// Number of negative and of zero eigenvalues; `None` of a matrix that is too large.
fn inertia(a: &Symmetric) -> Result<Option<[usize; 2]>, LinalgError> {
    if a.lower.len() > MOST_ENTRIES || a.n > a.lower.len().saturating_mul(4).saturating_add(1000) {
        return Ok(None);
    }
    let entries = a.lower.iter().map(|e| (e.row as usize, e.column as usize, e.value));
    let matrix = SparseSym::from_triplets(a.n, entries);
    let largest = (0..a.n).map(|i| matrix.diagonal(i).abs()).fold(0.0, f64::max);
    if largest == 0.0 {
        return Ok(None);
    }
    // A row of zeros has no scale of its own.
    let scale = |i: usize| Some(matrix.diagonal(i).abs()).filter(|d| *d > 0.0).unwrap_or(largest);
    let diagonal = SparseSym::from_triplets(a.n, (0..a.n).map(|i| (i, i, scale(i))));
    let plan = SparsePlan::new(&matrix, &diagonal, &(0..a.n).collect::<Vec<_>>())?;
    let below = |shift: f64| count_negative(&plan, &matrix, &diagonal, shift);
    let (negative, not_positive) = (below(ZERO)?, below(-ZERO)?);
    Ok(negative.zip(not_positive).map(|(n, p)| [n, p.saturating_sub(n)]))
}

/// The unit of length in which waves would run through the structure as in metals, if there is one.
///
/// √(k_ii/m_ii) times the distance to the nearest node, of the stiffest displacement of a node, is some twice the speed of sound, 5 km/s, whatever
/// the units of mass and force; the median over the nodes counts. Metres, inches and millimetres are told apart, nothing finer.
pub fn suspected_length(k: &Symmetric, m: &Symmetric, dofs: &[DofRow]) -> Option<&'static str> {
    /// Words, and how many metres each is.
    const UNITS: [(&str, f64); 3] = [("m", 1.0), ("mm", 1e-3), ("in", 0.0254)];
    const USUAL: f64 = 12_000.0;
    /// Less than half the way from one unit to the next.
    const WITHIN: f64 = 4.5;
    let diagonal = |a: &Symmetric| -> HashMap<usize, f64> {
        a.lower.iter().filter(|e| e.row == e.column).map(|e| (e.row as usize, e.value)).collect()
    };
    let (stiffness, mass) = (diagonal(k), diagonal(m));
    let position = |i: usize| dofs.get(i)?.position;
    // The nearest node that it is coupled to.
    let mut nearest: HashMap<&str, f64> = HashMap::new();
    for e in &k.lower {
        let (i, j) = (e.row as usize, e.column as usize);
        let (Some(p), Some(q)) = (position(i), position(j)) else { continue };
        let distance = (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt();
        if distance > 0.0 {
            for i in [i, j] {
                let own = nearest.entry(dofs[i].label.node.as_str()).or_insert(distance);
                *own = own.min(distance);
            }
        }
    }
    let mut fastest: HashMap<&str, f64> = HashMap::new();
    for (i, row) in dofs.iter().enumerate().filter(|(_, r)| r.label.dof.is_some_and(|d| !d.is_rotation())) {
        let node = row.label.node.as_str();
        let (Some(k), Some(m), Some(distance)) = (stiffness.get(&i), mass.get(&i), nearest.get(node)) else { continue };
        let speed = (k / m).sqrt() * distance;
        if speed.is_finite() && speed > 0.0 {
            let own = fastest.entry(node).or_insert(speed);
            *own = own.max(speed);
        }
    }
    let mut speeds: Vec<f64> = fastest.into_values().collect();
    speeds.sort_by(f64::total_cmp);
    let median = *speeds.get(speeds.len() / 2)?;
    let off = |unit: &(&str, f64)| (median * unit.1 / USUAL).ln().abs();
    UNITS.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).filter(|u| off(u) < WITHIN.ln()).map(|u| u.0)
}
