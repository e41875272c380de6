//! Edges that two elements share: where one stays straight, the other must not bend.
//!
//! A `shell3` has edges that bend with the rotations of its corners, and so gives its corners moments; a neighbour with straight edges
//! gives none, and nothing would hold them: such a mesh fails the patch test.

use crate::model::placed_element::PlacedElement;
use std::collections::HashMap;

/// Makes edges straight that are shared with an element whose edges are.
pub(super) fn straighten(elements: &mut [PlacedElement]) {
    let n_nodes = 1 + elements.iter().flat_map(|e| &e.nodes).max().copied().unwrap_or(0);
    let mut has_bent = vec![false; n_nodes];
    // Edges that may bend, and whether one that stays straight lies beside them.
    let mut edges: HashMap<[usize; 2], bool> = HashMap::new();
    for e in elements.iter().filter(|e| bends(e)) {
        edges.extend(edges_of(&e.nodes).map(|edge| (edge, false)));
        e.nodes.iter().for_each(|&n| has_bent[n] = true);
    }
    if edges.is_empty() {
        return;
    }
    let mut shared: Vec<usize> = Vec::new();
    for e in elements.iter().filter(|e| e.is_of_mesh() && !bends(e)) {
        shared.clear();
        shared.extend(e.nodes.iter().copied().filter(|&n| has_bent[n]));
        for (i, &a) in shared.iter().enumerate() {
            for &b in &shared[i + 1..] {
                if let Some(is_straight) = edges.get_mut(&sorted(a, b)) {
                    *is_straight = true;
                }
            }
        }
    }
    for e in elements.iter_mut().filter(|e| bends(e)) {
        let straight: Vec<bool> = edges_of(&e.nodes).map(|edge| edges[&edge]).collect();
        if let Some(kind) = e.kind.beside(&straight) {
            e.kind = kind;
        }
    }
}

/// Whether an element has edges that bend with the rotations of its corners.
fn bends(e: &PlacedElement) -> bool {
    e.is_of_mesh() && e.kind.beside(&[]).is_some()
}

fn edges_of(nodes: &[usize]) -> impl Iterator<Item = [usize; 2]> + '_ {
    (0..nodes.len()).map(|i| sorted(nodes[i], nodes[(i + 1) % nodes.len()]))
}

fn sorted(a: usize, b: usize) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
