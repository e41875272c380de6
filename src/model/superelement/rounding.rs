//! What a reduction to modal coordinates leaves where theory has zeros.

use crate::matrices::Symmetric;
use std::collections::HashMap;

/// Coupling of nodes and modal coordinates up to this part of its scale changes an eigenvalue by the square of it.
const COUPLING: f64 = 1e-9;
/// Stiffness among nodes up to this part of its scale is a frequency below a 300 000th of the first mode with the nodes held.
const STATIC: f64 = 1e-11;

/// Takes out of a stiffness what is rounding of a Craig-Bampton reduction: K_bq, which is zero in theory, and K_bb where rigid motions of the nodes
/// are all that they do. Left in, it would hold rigid motions.
///
/// ```text
/// |K_bq| <= 1e-9 ω_q² √(M_bb M_qq),    |K_bb'| <= 1e-11 ω_1² √(M_bb M_b'b'),    ω_q² = K_qq/M_qq, ω_1² the least of them
/// ```
///
/// * `is_modal` - which dofs are modal coordinates
pub(super) fn without_rounding(k: &Symmetric, m: &Symmetric, is_modal: &[bool]) -> Option<Symmetric> {
    let diagonal = |a: &Symmetric| -> HashMap<u32, f64> {
        a.lower.iter().filter(|e| e.row == e.column && e.value > 0.0).map(|e| (e.row, e.value)).collect()
    };
    let (stiffness, mass) = (diagonal(k), diagonal(m));
    let square = |q: u32| Some(stiffness.get(&q)? / mass.get(&q)?);
    let modal = (0..k.n as u32).filter(|&i| is_modal[i as usize]);
    let first = modal.filter_map(square).reduce(f64::min)?;
    let root = |i: u32, j: u32| Some((mass.get(&i)? * mass.get(&j)?).sqrt());
    let least = |i: u32, j: u32| match (is_modal[i as usize], is_modal[j as usize]) {
        (true, true) => None,
        (false, false) => Some(STATIC * first * root(i, j)?),
        (true, false) => Some(COUPLING * square(i)? * root(i, j)?),
        (false, true) => Some(COUPLING * square(j)? * root(i, j)?),
    };
    let mut out = k.clone();
    out.lower.retain(|e| least(e.row, e.column).is_none_or(|least| e.value.abs() > least));
    Some(out)
}
