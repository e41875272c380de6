//! Cuts: runs of shells of a mesh, one element wide, from a free edge inwards, as a saw or a crack goes.
//!
//! A patch is as wide as it is long, and what is cut through lies in none of them alone: a slit that ends in the middle of a patch, or runs
//! between two, softens parts of both.

use super::listing::sorted;
use super::{Part, PartKind, Structure};
use crate::element::Dof;
use crate::model::{Vector, cross, dot, minus, spread, unit};
use std::collections::{BTreeMap, BTreeSet};

/// Free edges of a part at which cuts begin, at most; they are spread evenly.
const MOST_BEGINNINGS: usize = 60;
/// Lengths of the cuts from one edge, at most.
const MOST_LENGTHS: usize = 6;
/// Cosine of the largest angle between neighbours that a cut crosses, 45 degrees: a fold ends it.
const SHARP: f64 = 0.707;

/// The shells at each edge, by its nodes in ascending order.
type Edges = BTreeMap<[usize; 2], Vec<usize>>;

impl Structure<'_> {
    /// Cuts of every part of a mesh, from each of its free edges and through to the opposite one, in several lengths; `e18..e20` by their ends.
    pub(super) fn list_cuts(&self) -> Vec<Part> {
        if self.model.mesh_parts().is_empty() {
            return Vec::new();
        }
        let edges = self.edges_of_shells();
        let mut cuts: Vec<Part> = Vec::new();
        let mut known: BTreeSet<Vec<usize>> = self.parts.iter().map(|p| sorted(&p.elements)).collect();
        let mut names = BTreeSet::new();
        for name in self.model.mesh_parts() {
            let own: BTreeSet<usize> = self.model.element_set(name).into_iter().flatten().copied().collect();
            let free: Vec<([usize; 2], usize)> = edges
                .iter()
                .filter_map(|(edge, on)| match on.as_slice() {
                    [only] if own.contains(only) && edge.iter().any(|&n| !self.is_clamped(n)) => Some((*edge, *only)),
                    _ => None,
                })
                .collect();
            let middles: Vec<Vector> = free.iter().map(|(edge, _)| self.middle(*edge)).collect();
            let all: Vec<usize> = (0..free.len()).collect();
            for k in spread(&middles, &all, MOST_BEGINNINGS) {
                let (edge, first) = free[k];
                let run = self.run_from(edge, first, &edges, &own);
                for length in lengths(run.len()) {
                    let elements = run[..length].to_vec();
                    let of: Vec<String> = elements.iter().map(|&e| self.model.elements()[e].name.clone()).collect();
                    let name = if length == 1 { of[0].clone() } else { format!("{}..{}", of[0], of[length - 1]) };
                    if known.insert(sorted(&elements)) && names.insert(name.clone()) {
                        cuts.push(Part { name, kind: PartKind::Cut, of, elements, partner: None, is_member: false });
                    }
                }
            }
        }
        cuts
    }

    fn edges_of_shells(&self) -> Edges {
        let mut edges = Edges::new();
        for e in (0..self.model.elements().len()).filter(|&e| self.is_shell(e)) {
            for edge in edges_of(&self.model.elements()[e].nodes) {
                edges.entry(edge).or_default().push(e);
            }
        }
        edges
    }

    fn is_clamped(&self, node: usize) -> bool {
        Dof::ALL.into_iter().all(|dof| !self.node_moves(node, dof))
    }

    fn middle(&self, [a, b]: [usize; 2]) -> Vector {
        let at = &self.model.geometry().positions;
        std::array::from_fn(|i| 0.5 * (at[a][i] + at[b][i]))
    }

    /// Shells from a free edge on: through a quadrilateral to its opposite side, through triangles straight on.
    fn run_from(&self, edge: [usize; 2], first: usize, edges: &Edges, own: &BTreeSet<usize>) -> Vec<usize> {
        let at = &self.model.geometry().positions;
        let mut run = vec![first];
        let (mut entered, mut from) = (edge, self.middle(edge));
        let mut normal = self.normal(first);
        let mut along = inwards(minus(at[edge[1]], at[edge[0]]), normal, minus(self.centre(first), from));
        while let Some(&e) = run.last() {
            let nodes = &self.model.elements()[e].nodes;
            let left = match nodes.as_slice() {
                [_, _, _, _] => edges_of(nodes).find(|other| other.iter().all(|n| !entered.contains(n))),
                [_, _, _] => nodes.iter().copied().find(|n| !entered.contains(n)).map(|apex| {
                    // The line leaves on that side of the apex on which it passes.
                    let across = cross(normal, along);
                    let side = |n: usize| dot(across, minus(at[n], from));
                    let other = entered.into_iter().max_by(|&a, &b| {
                        let off = |n: usize| if side(apex) > 0.0 { -side(n) } else { side(n) };
                        off(a).total_cmp(&off(b))
                    });
                    edge_of(apex, other.unwrap_or(apex))
                }),
                _ => None,
            };
            let Some(left) = left else { break };
            let next = match edges.get(&left).map(Vec::as_slice) {
                Some(&[a, b]) => {
                    if a == e {
                        b
                    } else {
                        a
                    }
                }
                _ => break,
            };
            let its_normal = self.normal(next);
            let turn = dot(normal, its_normal);
            if !own.contains(&next) || run.contains(&next) || turn.abs() < SHARP {
                break;
            }
            if nodes.len() == 4 {
                let to = self.middle(left);
                (along, from) = (unit(minus(to, from)).unwrap_or(along), to);
            }
            // Neighbours may have their normals on opposite sides.
            normal = its_normal.map(|v| v * turn.signum());
            entered = left;
            run.push(next);
        }
        run
    }

    /// The mean of the nodes of an element.
    pub(super) fn centre(&self, element: usize) -> Vector {
        let (nodes, at) = (&self.model.elements()[element].nodes, &self.model.geometry().positions);
        std::array::from_fn(|i| nodes.iter().map(|&n| at[n][i]).sum::<f64>() / nodes.len() as f64)
    }

    fn normal(&self, element: usize) -> Vector {
        let (nodes, at) = (&self.model.elements()[element].nodes, &self.model.geometry().positions);
        let across = match *nodes.as_slice() {
            [p, q, r, s] => unit(cross(minus(at[r], at[p]), minus(at[s], at[q]))),
            [p, q, r] => unit(cross(minus(at[q], at[p]), minus(at[r], at[p]))),
            _ => None,
        };
        across.unwrap_or(self.model.elements()[element].axes[2])
    }
}

fn edge_of(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

fn edges_of(nodes: &[usize]) -> impl Iterator<Item = [usize; 2]> {
    (0..nodes.len()).map(|k| edge_of(nodes[k], nodes[(k + 1) % nodes.len()]))
}

/// The direction across an edge in the plane of a shell, to the side of its middle.
fn inwards(edge: Vector, normal: Vector, to_middle: Vector) -> Vector {
    let Some(across) = unit(cross(normal, edge)) else { return to_middle };
    if dot(across, to_middle) < 0.0 { across.map(|v| -v) } else { across }
}

/// How many elements of a run are cut: each number where they are few, else in even steps up to all.
fn lengths(n: usize) -> impl Iterator<Item = usize> {
    let steps = n.min(MOST_LENGTHS);
    (1..=steps).map(move |k| (k * n).div_ceil(steps.max(1)))
}
