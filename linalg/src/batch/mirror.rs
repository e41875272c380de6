//! Left-right symmetry: a signed permutation of the dofs that leaves every parameter matrix unchanged.
//!
//! ```text
//! P e_i = s_i e_{p(i)},   P P = I,   P K_j P = K_j,   P M_j P = M_j   for every j
//! ```
//!
//! The shapes of such a model are symmetric or antisymmetric, and the pencil falls apart into two of half the size.

use std::collections::BTreeMap;

use super::BatchError;
use super::pencil::{AffineEntry, AffinePencil};

/// A signed permutation of the dofs: dof i goes to `permutation[i]` with the sign `signs[i]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mirror {
    /// The partner of every dof; a dof in the mirror plane is its own.
    pub permutation: Vec<usize>,
    /// +1 or -1 per dof: a lateral displacement changes its sign, a vertical one does not.
    pub signs: Vec<f64>,
}

/// Relative difference below which two mirrored coefficients count as equal: rounding of coordinates and rotations.
const TOLERANCE: f64 = 1e-11;

/// Whether the mirror leaves K_j and M_j unchanged for every parameter and for the constant part.
///
/// * `pencil` - the affine pencil (n dofs)
/// * `mirror` - the candidate, found from the geometry of the model
///
/// A mirror that is not a signed involution of n dofs is an error; a model that is merely not symmetric gives `false`.
pub fn detect_mirror(pencil: &AffinePencil, mirror: &Mirror) -> Result<bool, BatchError> {
    mirror.check(pencil.n)?;
    Ok([&pencil.stiffness, &pencil.mass].into_iter().all(|entries| is_invariant(pencil, entries, mirror)))
}

fn is_invariant(pencil: &AffinePencil, entries: &[AffineEntry], mirror: &Mirror) -> bool {
    let mut sums: BTreeMap<(Option<usize>, usize, usize), f64> = BTreeMap::new();
    let mut diagonal: BTreeMap<(Option<usize>, usize), f64> = BTreeMap::new();
    for e in entries {
        *sums.entry((e.parameter, e.row, e.col)).or_default() += e.coefficient;
        for i in [e.row, e.col] {
            let d = diagonal.entry((e.parameter, i)).or_default();
            *d += e.coefficient.abs();
        }
    }
    debug_assert_eq!(mirror.permutation.len(), pencil.n);
    sums.iter().all(|(&(parameter, row, col), &value)| {
        let (i, j) = (mirror.permutation[row], mirror.permutation[col]);
        let image = sums.get(&(parameter, i.max(j), i.min(j))).copied().unwrap_or(0.0);
        let expected = value * mirror.signs[row] * mirror.signs[col];
        // The size of an entry is that of its row and column: units may differ between dofs.
        let size = (diagonal[&(parameter, row)] * diagonal[&(parameter, col)]).sqrt();
        (image - expected).abs() <= TOLERANCE * size
    })
}

impl Mirror {
    /// Refuses anything but a signed involution of n dofs.
    pub(super) fn check(&self, n: usize) -> Result<(), BatchError> {
        if self.permutation.len() != n || self.signs.len() != n {
            return Err(BatchError::MirrorSize { dofs: self.permutation.len(), signs: self.signs.len(), n });
        }
        for i in 0..n {
            let j = self.permutation[i];
            let involution = j < n && self.permutation[j] == i && self.signs[i] == self.signs[j];
            if !involution || self.signs[i].abs() != 1.0 {
                return Err(BatchError::MirrorNotInvolution { dof: i });
            }
        }
        Ok(())
    }
}

/// The coordinates of one family of shapes: coordinate c moves dof `pairs[c].0` by one and, if there is one, its
/// partner by the sign.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Family {
    /// +1 symmetric, -1 antisymmetric, 0 for all shapes.
    pub(super) parity: i8,
    pub(super) pairs: Vec<(usize, Option<(usize, f64)>)>,
}

/// All dofs (no mirror), or the symmetric and the antisymmetric family.
pub(super) fn families(n: usize, mirror: Option<&Mirror>) -> Vec<Family> {
    let Some(mirror) = mirror else {
        return vec![Family { parity: 0, pairs: (0..n).map(|i| (i, None)).collect() }];
    };
    let family = |parity: f64| Family {
        parity: parity as i8,
        pairs: (0..n)
            .filter_map(|i| {
                let (j, sign) = (mirror.permutation[i], parity * mirror.signs[i]);
                match j.cmp(&i) {
                    std::cmp::Ordering::Greater => Some((i, Some((j, sign)))),
                    std::cmp::Ordering::Equal if sign > 0.0 => Some((i, None)),
                    _ => None,
                }
            })
            .collect(),
    };
    [family(1.0), family(-1.0)].into_iter().filter(|f| !f.pairs.is_empty()).collect()
}

impl Family {
    /// The terms of the pencil in the coordinates of this family, per entry of the lower triangle and parameter.
    pub(super) fn project(&self, n: usize, entries: &[AffineEntry]) -> BTreeMap<(usize, usize), Terms> {
        // dof -> (coordinate, factor); a dof moves in at most one coordinate of a family.
        let mut coordinate = vec![None; n];
        for (c, &(i, partner)) in self.pairs.iter().enumerate() {
            coordinate[i] = Some((c, 1.0));
            if let Some((j, sign)) = partner {
                coordinate[j] = Some((c, sign));
            }
        }
        let mut sums: BTreeMap<(usize, usize), Sums> = BTreeMap::new();
        for e in entries {
            if let (Some((c, f)), Some((d, g))) = (coordinate[e.row], coordinate[e.col]) {
                // An entry beside the diagonal stands for two of the full matrix.
                let twice = if c == d && e.row != e.col { 2.0 } else { 1.0 };
                let value = twice * f * g * e.coefficient;
                let sum = sums.entry((c.max(d), c.min(d))).or_default().entry(e.parameter).or_default();
                *sum = (sum.0 + value, sum.1 + value.abs());
            }
        }
        let kept = |(parameter, (sum, size)): (Option<usize>, (f64, f64))| {
            (sum.abs() > 1e-15 * size).then_some((parameter, sum))
        };
        sums.into_iter().map(|(at, terms)| (at, terms.into_iter().filter_map(kept).collect())).collect()
    }
}

/// Per parameter: the sum of the terms, and that of their absolute values.
type Sums = BTreeMap<Option<usize>, (f64, f64)>;

/// The terms of one entry: coefficient per parameter (`None` first: the constant).
pub(super) type Terms = Vec<(Option<usize>, f64)>;
