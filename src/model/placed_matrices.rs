//! Matrices of a superelement in their place: how its dofs follow from the rows of a model, and what it adds there.

use super::dof_map::{Combination, DofMap, rigid_motion};
use super::entry::Entry;
use super::value::Value;
use crate::element::{Axes, Dof, Element, ElementError, ElementInput, Property};
use crate::linalg::SymMatrix;
use crate::matrices::Symmetric;
use std::sync::Arc;

/// The type of the elements that stand for superelements and their terms; their matrices are not its own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Superelement;

impl Element for Superelement {
    fn name(&self) -> &'static str {
        "superelement"
    }

    fn summary(&self) -> &'static str {
        "Matrices of another solver."
    }

    fn theory(&self) -> &'static str {
        "K, M and C come from files; see docs/matrices.md."
    }

    fn nodes(&self) -> &'static [&'static [Dof]] {
        &[]
    }

    fn properties(&self) -> &'static [Property] {
        &[]
    }

    fn axes(&self) -> Axes {
        Axes::Given
    }

    fn stiffness(&self, _: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        Ok(SymMatrix::zeros(0))
    }

    fn mass(&self, _: &ElementInput<'_>) -> Result<SymMatrix, ElementError> {
        Ok(SymMatrix::zeros(0))
    }
}

/// A dof of a superelement: a displacement or a rotation of a node of the model along a global direction, or a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlacedDof {
    /// Node of the model.
    pub node: usize,
    /// Its direction in the superelement's axes; `None` of a coordinate, which is the first dof of a node of its own.
    pub dof: Option<Dof>,
    /// Its direction, global.
    pub axis: [f64; 3],
}

impl PlacedDof {
    /// Its parts along the dofs of its node: (6 node + dof, factor).
    pub(super) fn parts(&self) -> impl Iterator<Item = (usize, f64)> {
        let (first, axis) = match self.dof {
            None => (6 * self.node, [1.0, 0.0, 0.0]),
            Some(dof) => (6 * self.node + if dof.is_rotation() { 3 } else { 0 }, self.axis),
        };
        axis.into_iter().enumerate().filter(|(_, a)| a.abs() > 1e-12).map(move |(i, a)| (first + i, a))
    }

    /// Its value in a unit rigid motion about the origin.
    fn rigid(&self, positions: &[[f64; 3]], motion: usize) -> f64 {
        let Some(dof) = self.dof else { return 0.0 };
        let u = rigid_motion(positions[self.node], motion);
        let first = if dof.is_rotation() { 3 } else { 0 };
        (0..3).map(|i| self.axis[i] * u[first + i]).sum()
    }
}

/// The matrices of a superelement, or of one of its terms, in their place.
#[derive(Debug, Clone)]
pub struct PlacedMatrices {
    /// What the rows of the matrices are.
    pub dofs: Arc<Vec<PlacedDof>>,
    /// Stiffness.
    pub k: Option<Arc<Symmetric>>,
    /// Mass.
    pub m: Option<Arc<Symmetric>>,
    /// Damping.
    pub c: Option<Arc<Symmetric>>,
    /// Factor on the damping, which no override changes; one where there is none.
    pub(super) damping_factor: Option<Value>,
    /// Whether it is the stiffness of a preload, and its factor that of the preload.
    pub(super) is_preload: bool,
}

/// How every dof follows from the rows of a model.
pub(super) struct Follows(Vec<Combination>);

impl PlacedMatrices {
    fn all(&self) -> impl Iterator<Item = &Symmetric> {
        [&self.k, &self.m, &self.c].into_iter().flatten().map(Arc::as_ref)
    }

    /// Its nodes, each once, in ascending order.
    pub fn nodes(&self) -> Vec<usize> {
        let mut nodes: Vec<usize> = self.dofs.iter().map(|d| d.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Pairs of its nodes that an entry of its stiffness couples, several times where several do.
    pub(crate) fn coupled(&self) -> impl Iterator<Item = (usize, usize)> {
        let entries = self.k.iter().flat_map(|k| &k.lower);
        let nodes = entries.map(|e| (self.dofs[e.row as usize].node, self.dofs[e.column as usize].node));
        nodes.filter(|(a, b)| a != b)
    }

    /// Whether it resists, or drives on, a displacement or a rotation of a node along a global axis.
    pub(crate) fn has_stiffness(&self, node: usize, dof: Dof) -> bool {
        let wanted = 6 * node + dof as usize;
        let acts: Vec<bool> = self.dofs.iter().map(|d| d.node == node && d.parts().any(|p| p.0 == wanted)).collect();
        let diagonal = |e: &&crate::matrices::Entry| e.row == e.column && acts[e.row as usize];
        self.k.iter().flat_map(|k| &k.lower).filter(diagonal).any(|e| e.value != 0.0)
    }

    /// Marks the dofs of nodes, 6 per node, that it acts on.
    pub(super) fn touch(&self, touched: &mut [bool]) {
        let mut acts = vec![false; self.dofs.len()];
        for e in self.all().flat_map(|a| &a.lower) {
            acts[e.row as usize] = true;
            acts[e.column as usize] = true;
        }
        for (dof, _) in self.dofs.iter().zip(acts).filter(|(_, acts)| *acts) {
            dof.parts().for_each(|(i, _)| touched[i] = true);
        }
    }

    /// How its dofs follow from the rows.
    pub(super) fn follows(&self, map: &DofMap) -> Follows {
        let follow = |d: &PlacedDof| {
            let mut parts = d.parts();
            if let (Some((i, factor)), None) = (parts.next(), parts.next())
                && factor == 1.0
            {
                return map.express(i / 6, Dof::ALL[i % 6]).to_vec();
            }
            let mut sum: Combination = d
                .parts()
                .flat_map(|(i, a)| map.express(i / 6, Dof::ALL[i % 6]).iter().map(move |&(row, f)| (row, a * f)))
                .collect();
            sum.sort_by_key(|t| t.0);
            sum.dedup_by(|later, kept| {
                let same = later.0 == kept.0;
                if same {
                    kept.1 += later.1;
                }
                same
            });
            sum
        };
        Follows(self.dofs.iter().map(follow).collect())
    }

    /// Rᵀ A R of the six rigid motions about the origin.
    pub(super) fn rigid(&self, a: &Symmetric, positions: &[[f64; 3]]) -> SymMatrix {
        let motions: Vec<[f64; 6]> =
            self.dofs.iter().map(|d| std::array::from_fn(|motion| d.rigid(positions, motion))).collect();
        let mut sum = SymMatrix::zeros(6);
        for e in &a.lower {
            let (r, c) = (&motions[e.row as usize], &motions[e.column as usize]);
            for i in 0..6 {
                for j in i..6 {
                    let both = if e.row == e.column { r[i] * c[j] } else { r[i] * c[j] + c[i] * r[j] };
                    if both != 0.0 {
                        sum.add(i, j, both * e.value);
                    }
                }
            }
        }
        complete(&mut sum);
        sum
    }
}

/// Adds to a mass of rigid motions what directions would have in which no dof moves: as if the mass stood there at its centre.
fn complete(rigid: &mut SymMatrix) {
    let present: Vec<usize> = (0..3).filter(|&t| rigid.get(t, t) != 0.0).collect();
    if present.is_empty() || present.len() == 3 {
        return;
    }
    let mass = present.iter().map(|&t| rigid.get(t, t)).sum::<f64>() / present.len() as f64;
    // About axis r the displacement along t is that of the coordinate c: (t, r, c, sign).
    const MOMENTS: [(usize, usize, usize, f64); 6] =
        [(1, 5, 0, 1.0), (2, 4, 0, -1.0), (2, 3, 1, 1.0), (0, 5, 1, -1.0), (0, 4, 2, 1.0), (1, 3, 2, -1.0)];
    let centre: [f64; 3] = std::array::from_fn(|c| {
        let known = MOMENTS.iter().filter(|m| m.2 == c && present.contains(&m.0));
        let all: Vec<f64> = known.map(|&(t, r, _, sign)| sign * rigid.get(t, r) / mass).collect();
        if all.is_empty() { 0.0 } else { all.iter().sum::<f64>() / all.len() as f64 }
    });
    for t in (0..3).filter(|t| !present.contains(t)) {
        let motion: [f64; 6] = std::array::from_fn(|j| rigid_motion(centre, j)[t]);
        rigid.add_outer(mass, &motion);
    }
}

impl Follows {
    /// Per dof: (row, factor).
    pub(super) fn all(&self) -> &[Combination] {
        &self.0
    }

    /// Tᵀ A T: entries of the lower triangle, several of one place among them.
    pub(super) fn reduce(&self, a: &Symmetric) -> Vec<Entry> {
        let mut out = Vec::with_capacity(a.lower.len());
        for e in &a.lower {
            let (first, second) = (&self.0[e.row as usize], &self.0[e.column as usize]);
            for &(r, f) in first {
                for &(s, g) in second {
                    let value = e.value * f * g;
                    let (row, column) = (r.max(s), r.min(s));
                    if e.row != e.column {
                        // The mirror image gives as much: on the diagonal both count.
                        out.push(Entry::new(row, column, if r == s { 2.0 * value } else { value }));
                    } else if r >= s {
                        out.push(Entry::new(row, column, value));
                    }
                }
            }
        }
        out
    }

    /// qᵀ Tᵀ A T q.
    pub(super) fn energy(&self, a: &Symmetric, q: &[f64]) -> f64 {
        let u: Vec<f64> = self.0.iter().map(|c| c.iter().map(|&(row, f)| f * q[row]).sum()).collect();
        let of = |e: &crate::matrices::Entry| {
            let twice = if e.row == e.column { 1.0 } else { 2.0 };
            twice * e.value * u[e.row as usize] * u[e.column as usize]
        };
        a.lower.iter().map(of).sum()
    }
}
