//! Weighted links: the rows by which a node follows the mean motion of others.
//!
//! ```text
//! q = (Σ Sᵢᵀ Wᵢ Sᵢ)⁻¹ Σ Sᵢᵀ Wᵢ uᵢ        Sᵢ = [I  -r̂ᵢ; 0  I], r from the node that follows to node i
//! ```
//!
//! q minimises the weighted squares of uᵢ - Sᵢ q; Wᵢ is the weight of the node for translations, times the square of the mean length of
//! the arms r for rotations. The forces on the node are so shared without stiffening the others (RBE3 of Nastran).
//! Source: MSC Nastran, Linear Static Analysis User's Guide, chapter on R-type elements; R. D. Cook et al., Concepts and Applications of
//! Finite Element Analysis, 2002, section 13.1, for the elimination.

use super::dof_map::rigid_motion;
use super::geometry::{Geometry, dot, minus, unknown};
use super::spec::{ModelSpec, WeightedLinkSpec};
use crate::element::Dof;
use crate::linalg::{DMatrix, symmetric_eigen};
use crate::yaml::{Problem, child};

/// Directions whose share in the scaled normal equations is below this are not determined by the nodes.
const UNDETERMINED: f64 = 1e-9;

/// One row Σ factor · dof = 0 for each dof that follows, that dof first; nothing where there is a problem.
pub(super) fn rows(
    (name, link): (&str, &WeightedLinkSpec),
    geometry: &Geometry,
    spec: &ModelSpec,
    problems: &mut Vec<Problem>,
) -> Vec<Vec<(usize, f64)>> {
    let path = child("weighted_links", name);
    let before = problems.len();
    let mut find = |node: &String, path: &str| {
        let found = geometry.node(node);
        if found.is_none() {
            problems.push(unknown(path, "node", node, spec.nodes.keys()));
        }
        found
    };
    let node = find(&link.node, &child(&path, "node"));
    let mut followed: Vec<(usize, usize)> = Vec::new();
    for (i, set) in link.of.iter().enumerate() {
        for (j, other) in set.nodes.iter().enumerate() {
            followed.extend(find(other, &format!("{path}.of[{i}].nodes[{j}]")).map(|n| (n, i)));
        }
    }
    for (i, set) in link.of.iter().enumerate() {
        if set.weight.is_some_and(|w| !(w > 0.0 && w.is_finite())) {
            problems
                .push(Problem::error(format!("{path}.of[{i}].weight"), "a weight must be a finite number above zero"));
        }
    }
    let Some(node) = node.filter(|_| problems.len() == before) else { return Vec::new() };
    if followed.is_empty() {
        problems
            .push(Problem::error(child(&path, "of"), "a weighted link needs nodes to follow, `[{nodes: [a, b, c]}]`"));
        return Vec::new();
    }
    if followed.iter().any(|f| f.0 == node) {
        let text = format_args!("node `{}` cannot follow itself", link.node);
        problems.push(Problem::error(child(&path, "of"), text));
        return Vec::new();
    }
    let arms: Vec<[f64; 3]> =
        followed.iter().map(|f| minus(geometry.positions[f.0], geometry.positions[node])).collect();
    let mean = arms.iter().map(|r| dot(*r, *r).sqrt()).sum::<f64>() / arms.len() as f64;
    let length = if mean > 0.0 { mean } else { 1.0 };
    // The equations are written for θ times the length, so that all six unknowns are lengths.
    let unit = |motion: usize| if motion < 3 { 1.0 } else { 1.0 / length };
    let mut normal = DMatrix::zeros(6, 6);
    let mut terms: Vec<(usize, [f64; 6])> = Vec::new();
    for (&(other, set), arm) in followed.iter().zip(&arms) {
        let set = &link.of[set];
        let dofs: Vec<usize> = match &set.dofs {
            Some(dofs) => dofs.iter().map(|d| *d as usize).collect(),
            None => vec![0, 1, 2],
        };
        for d in dofs {
            let scale = if d < 3 { 1.0 } else { length * length };
            let weight = set.weight.unwrap_or(1.0) * scale;
            let row: [f64; 6] = std::array::from_fn(|motion| rigid_motion(*arm, motion)[d] * unit(motion));
            for i in 0..6 {
                for j in 0..6 {
                    normal[(i, j)] += weight * row[i] * row[j];
                }
            }
            terms.push((6 * other + d, row.map(|f| weight * f)));
        }
    }
    let Ok(eigen) = symmetric_eigen(&normal) else {
        problems.push(Problem::error(&path, "the positions or weights of its nodes are not usable numbers"));
        return Vec::new();
    };
    let least = UNDETERMINED * eigen.values.max();
    let wanted: Vec<usize> = match &link.dofs {
        Some(dofs) => dofs.iter().map(|d| *d as usize).collect(),
        None => (0..6).collect(),
    };
    let mut rows = Vec::new();
    for d in wanted {
        let open = (0..6).any(|k| eigen.values[k] <= least && eigen.vectors[(d, k)].abs() > 1e-6);
        if open {
            problems.push(Problem::error(
                &path,
                format_args!(
                    "the nodes it follows do not determine `{}` of node `{}`: they lie on one line or at one place, or too few of their dofs count",
                    Dof::ALL[d], link.node
                ),
            ));
            return Vec::new();
        }
        let mut row = vec![(6 * node + d, 1.0)];
        for (dof, weighted) in &terms {
            let factor: f64 = (0..6)
                .filter(|&k| eigen.values[k] > least)
                .map(|k| {
                    let along: f64 = (0..6).map(|i| eigen.vectors[(i, k)] * weighted[i]).sum();
                    eigen.vectors[(d, k)] * along / eigen.values[k]
                })
                .sum();
            if factor.abs() > 1e-14 {
                row.push((*dof, -factor * unit(d)));
            }
        }
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use crate::model::{ParametricModel, Registry, load};

    fn model(link: &str) -> Result<crate::model::Model, String> {
        let text = format!(
            "retune: 1\nname: link\nnodes: {{a: [0, 0, 0], b: [2, 0, 0], c: [2, 1, 0], d: [0, 1, 0.5], r: [0.7, 0.2, 1.1]}}\n\
             masses: {{a: {{node: a, mass: 1}}, b: {{node: b, mass: 1}}, c: {{node: c, mass: 1}}, d: {{node: d, mass: 1}}, \
             r: {{node: r, mass: 1, inertia: {{xx: 1, yy: 1, zz: 1}}}}}}\nweighted_links: {{{link}}}\n"
        );
        load(&text, &Registry::builtin()).map(|l| l.0).map_err(|p| p[0].message.clone())
    }

    /// Every rigid motion of the followed nodes is followed exactly; a force is shared so that force and moment are kept.
    #[test]
    fn rigid_motions_are_followed_exactly() {
        let links = [
            "l: {node: r, of: [{nodes: [a, b, c, d]}]}",
            "l: {node: r, of: [{nodes: [a, b], weight: 2.5}, {nodes: [c, d], dofs: [ux, uy, uz, rx, ry, rz]}]}",
        ];
        for link in links {
            let model = model(link).unwrap();
            let map = model.dof_map();
            let rigid = map.rigid_motions();
            for dof in crate::element::Dof::ALL {
                for motion in 0..6 {
                    let moved: f64 = map.express(4, dof).iter().map(|(row, f)| f * rigid[(*row, motion)]).sum();
                    let expected = crate::model::rigid_motion([0.7, 0.2, 1.1], motion)[dof as usize];
                    assert!((moved - expected).abs() < 1e-12, "{dof} {motion}: {moved} {expected}");
                }
            }
        }
    }

    /// Two nodes a and b on a line: the mean of both by their weights, and no rotation about the line.
    #[test]
    fn on_a_line_the_mean_is_by_weight_and_the_turn_about_it_is_open() {
        let pair = "of: [{nodes: [a], weight: 3}, {nodes: [b]}]";
        let m = model(&format!("l: {{node: d, dofs: [ux], {pair}}}")).unwrap();
        // ux of d = mean of ux by weight, plus what rotation about y and z adds at its arm, which a and b determine.
        let ux: f64 = m.dof_map().express(3, crate::element::Dof::Ux).iter().map(|t| t.1).sum();
        assert!(ux.is_finite());
        let open = model("l: {node: r, of: [{nodes: [a, b]}]}").unwrap_err();
        assert!(open.contains("do not determine"), "{open}");
        let own = model("l: {node: r, of: [{nodes: [r, b]}]}").unwrap_err();
        assert_eq!(own, "node `r` cannot follow itself");
    }
}
