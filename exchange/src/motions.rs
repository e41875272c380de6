//! Motions of nodes along axes of their own, as sums of dofs along global axes.

use super::text::{computed, list};
use retune::element::Dof;
use retune::linalg::vector3::{cross, dot, minus, plus};
use retune::model::rigid_motion;

/// Where a node is and the directions of its displacements, as rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placed {
    pub position: [f64; 3],
    pub axes: [[f64; 3]; 3],
}

impl Placed {
    /// Whether its displacements are along global axes.
    pub(super) fn is_global(&self) -> bool {
        self.axes == retune::model::GLOBAL
    }

    /// A component, 0 to 5, as dofs along global axes with their factors.
    pub(super) fn component(&self, component: usize) -> Vec<(Dof, f64)> {
        let first = 3 * (component / 3);
        let row = self.axes[component % 3];
        (0..3).filter(|i| row[*i].abs() > 1e-12).map(|i| (Dof::ALL[first + i], row[i])).collect()
    }
}

/// A term of a constraint: node, dof along a global axis, factor.
pub(super) type Term = (String, Dof, f64);

/// Whether components are all three of a kind or none, and so the same in any axes.
pub(super) fn is_whole(flags: [bool; 6]) -> bool {
    let same = |first: usize| flags[first] == flags[first + 1] && flags[first] == flags[first + 2];
    same(0) && same(3)
}

/// Names of dofs: `[ux, uy]`.
pub(super) fn dofs(flags: [bool; 6]) -> String {
    let dofs: Vec<&str> = Dof::ALL.into_iter().filter(|d| flags[*d as usize]).map(Dof::name).collect();
    format!("[{}]", dofs.join(", "))
}

/// A component of a node that follows another as one rigid body: aᵀ u - aᵀ S(r) q = 0.
///
/// * `master` - name and position of the node that leads
pub(super) fn follows(
    (slave, placed): (&str, &Placed),
    (master, lead): (&str, [f64; 3]),
    component: usize,
) -> Vec<Term> {
    let arm = minus(placed.position, lead);
    let parts = placed.component(component);
    let mut terms: Vec<Term> = parts.iter().map(|(dof, f)| (slave.to_string(), *dof, *f)).collect();
    for motion in 0..6 {
        let factor: f64 = parts.iter().map(|(dof, f)| f * rigid_motion(arm, motion)[*dof as usize]).sum();
        terms.push((master.to_string(), Dof::ALL[motion], -factor));
    }
    terms
}

/// The entry of Σ factor · dof = 0 in a model file.
///
/// * `metre` - the deck's unit of length in metres
pub(super) fn constraint(terms: Vec<Term>, metre: f64) -> String {
    // Beside a displacement the factor of a rotation is a length, which a model file has in metres.
    let has_displacement = terms.iter().any(|t| !t.1.is_rotation());
    let terms: Vec<String> = terms
        .into_iter()
        .filter(|t| t.2.abs() > 1e-15)
        .map(|(node, dof, factor)| {
            let factor = if has_displacement && dof.is_rotation() { factor * metre } else { factor };
            let factor = if factor == 1.0 { String::new() } else { format!(", factor: {}", computed(factor)) };
            format!("{{node: {node}, dof: {dof}{factor}}}")
        })
        .collect();
    format!("{{terms: {}}}", list(&terms))
}

/// The angle about the normal from global x, projected (from y where it is normal), to a direction, rad.
pub(super) fn angle_from_global(normal: [f64; 3], direction: [f64; 3]) -> f64 {
    let projected = |v: [f64; 3]| plus(v, -dot(v, normal), normal);
    let x = projected([1.0, 0.0, 0.0]);
    let x = if dot(x, x) > 1e-12 { x } else { projected([0.0, 1.0, 0.0]) };
    let d = projected(direction);
    dot(cross(x, d), normal).atan2(dot(x, d))
}
