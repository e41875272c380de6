//! What is placed and still refused: points where there is none, and motions that nothing resists.

use crate::element::ElementInput;
use crate::model::constraint::{Elimination, active};
use crate::model::dependence::interior_point;
use crate::model::place::Placed;
use crate::model::spec::ModelSpec;
use crate::yaml::{Problem, child};

/// Refuses elements and links that need a point where there is a coordinate.
pub(super) fn only_scalar_on_coordinates(spec: &ModelSpec, placed: &Placed, problems: &mut Vec<Problem>) {
    let geometry = &placed.geometry;
    const ALLOWED: [&str; 3] = ["ground_spring", "mass_matrix", "scalar_spring"];
    for e in placed.elements.iter().filter(|e| e.matrices.is_none() && !ALLOWED.contains(&e.kind.name())) {
        if let Some(n) = e.nodes.iter().find(|n| geometry.is_coordinate(**n)) {
            problems.push(Problem::error(
                &e.path,
                format_args!(
                    "node `{}` is a coordinate and no point: only springs to ground, `scalar_spring` and `mass_matrix` act on it, by `ux`",
                    geometry.names[*n]
                ),
            ));
        }
    }
    let is_coordinate = |name: &String| geometry.node(name).is_some_and(|n| geometry.is_coordinate(n));
    for (name, link) in &spec.rigid_links {
        if let Some(node) = std::iter::once(&link.master).chain(&link.slaves).find(|n| is_coordinate(n)) {
            problems.push(Problem::error(
                child("rigid_links", name),
                format_args!("node `{node}` is a coordinate and no point: it cannot be part of a rigid body"),
            ));
        }
    }
}

/// Refuses elements that lack a property against a motion that is possible.
pub(super) fn lacks(spec: &ModelSpec, placed: &Placed, elimination: &Elimination, problems: &mut Vec<Problem>) {
    let active = active(spec);
    let theta = interior_point(&placed.parameters);
    for e in &placed.elements {
        let values: Vec<Option<f64>> = e.values.iter().map(|v| v.as_ref().map(|v| v.at(&theta))).collect();
        for lack in e.kind.lacks(&ElementInput { points: &e.points, values: &values }) {
            let local = lack.dof.axis();
            let base = if lack.dof.is_rotation() { 3 } else { 0 };
            let moves = e.nodes.iter().any(|&node| {
                (0..3).any(|g| {
                    let dof = base + g;
                    e.axes[local][g].abs() > 1e-6 && active[dof] && !elimination.express(6 * node + dof).is_empty()
                })
            });
            let path = e.section.as_ref().map_or(e.path.clone(), |s| child("sections", s));
            let already =
                problems.iter().any(|p| p.path == path && p.message.contains(&format!("`{}`", lack.property)));
            if moves && !already {
                problems.push(Problem::error(path, format_args!("element `{}` needs `{}` against motion in {} (its own axes); give it, or leave that dof out of `active_dofs`", e.name, lack.property, lack.dof)));
            }
        }
    }
}
