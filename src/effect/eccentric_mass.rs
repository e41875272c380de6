//! A mass that the model lacks, on an arm beside a node.

use super::edit::{Edit, NewParameter, PatchError, scalar};
use super::location::{ALL_AXES, Location};
use super::patch::{Builder, Patch, body_at, round, times};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::AXES;
use crate::model::spec::MassSpec;
use crate::units::Scalar;

/// Arms, as shares of the size of the structure: one worth a start, to either side, and the longest.
const TYPICAL: f64 = 0.05;
const LONGEST: f64 = 0.5;

#[doc = "A mass that the model lacks, with its centre of gravity beside the node: equipment on a bracket, a store under a wing, a fairing."]
#[derive(Debug, Clone, Copy)]
pub struct EccentricMass;

impl Effect for EccentricMass {
    fn name(&self) -> &'static str {
        "eccentric-mass"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass that the model lacks, with its centre of gravity beside the node: equipment on a bracket, a \
                    store under a wing, a fairing.",
            signature: "A point mass that also couples the displacement of the node with its rotation: bending modes gain \
                    twist, torsion modes fall by the inertia m e².",
            formulation: "M gains m |u̇ + θ̇ × e|² with e along one global axis, or along all; m = 0 leaves it, \
                    whatever the arm. e = 0 is a point mass.",
            confusable: &["point-mass", "mass-offset", "point-rotary-inertia", "sprung-mass"],
            references: &[
                "H. Goldstein, C. Poole, J. Safko, Classical Mechanics, 3rd ed., 2002, sections 5.1 to 5.3",
                "R. L. Bisplinghoff, H. Ashley, R. L. Halfman, Aeroelasticity, 1955, section 3.7",
            ],
        }
    }

    /// Without its arm.
    fn becomes(&self) -> &'static [&'static str] {
        &["point-mass"]
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.total_mass() <= 0.0 || structure.extent() <= 0.0 {
            return Vec::new();
        }
        let along = |axis: usize| {
            let nodes = structure.nodes(|n| couples(structure, n, axis));
            nodes.into_iter().map(move |at| at.along(AXES[axis]))
        };
        let all = structure.nodes_along_all(|n| (0..3).filter(|&axis| couples(structure, n, axis)).collect());
        (0..3).flat_map(along).chain(all).collect()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let node = at.names.first().and_then(|name| structure.model().geometry().node(name)).ok_or_else(unknown)?;
        let is_asked = |axis: &usize| at.direction() == ALL_AXES || at.direction() == AXES[*axis];
        let axes: Vec<usize> = (0..3).filter(is_asked).filter(|&axis| couples(structure, node, axis)).collect();
        if axes.is_empty() {
            return Err(unknown());
        }
        let mut b = Builder::new(self.name(), at);
        let total = structure.total_mass();
        let about = format!("mass missing beside {}", at.place());
        let m = b.parameter("mass", "kg", 0.02 * total, [0.0, 0.5 * total], &about);
        let arm = round(TYPICAL * structure.extent());
        let longest = round(LONGEST * structure.extent());
        let mut arms = Vec::new();
        for (k, &axis) in axes.iter().enumerate() {
            let suffix = if axes.len() > 1 { format!("_{}", AXES[axis]) } else { String::new() };
            let name = b.add(NewParameter {
                name: format!("{}.arm{suffix}", b.stem()),
                unit: "m".to_string(),
                // One arm leads out of the node, to either side; the others come with it.
                neutral: if k == 0 { arm } else { 0.0 },
                typical: arm,
                bounds: [-longest, longest],
                grid: if k == 0 { vec![-arm, arm] } else { Vec::new() },
                description: format!(
                    "from {} to its centre of gravity, along {}; any value is neutral while the mass is zero",
                    at.place(),
                    AXES[axis]
                ),
            });
            arms.push((axis, name));
        }
        let stem = b.stem().to_string();
        for (k, name) in at.names.iter().enumerate() {
            let mut offset = [(); 3].map(|()| Scalar::constant(0.0));
            for (axis, arm) in &arms {
                let sign = if k > 0 && structure.mirrors(*axis) { -1.0 } else { 1.0 };
                offset[*axis] = scalar(&times(sign, arm));
            }
            let body = body_at(std::slice::from_ref(name));
            let entry = MassSpec { mass: Some(scalar(&m)), offset: Some(offset), ..body };
            let name = if at.names.len() > 1 { format!("{stem}.{}", k + 1) } else { stem.clone() };
            b.edit(Edit::AddMass { name, entry });
        }
        Ok(b.finish())
    }
}

/// Whether an arm along a global axis couples a displacement of a node with a rotation.
fn couples(structure: &Structure<'_>, node: usize, axis: usize) -> bool {
    let moves = |d: usize| structure.node_moves(node, Dof::ALL[d]);
    let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
    moves(third) && moves(3 + second) || moves(second) && moves(3 + third)
}
