//! A spring to ground: suspension, cables, contact.

use super::edit::{Edit, PatchError};
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::Structure;
use super::{About, Belongs, Effect};
use crate::element::Dof;
use crate::model::spec::{Named, SpringSpec};

#[doc = "A spring between a node and the ground: a soft suspension, cables, a contact or a bearing that holds the slope, which the model lacks."]
#[derive(Debug, Clone, Copy)]
pub struct GroundSpring;

impl Effect for GroundSpring {
    fn name(&self) -> &'static str {
        "ground-spring"
    }

    fn about(&self) -> About {
        About {
            summary: "A spring between a node and the ground: a soft suspension, cables, a contact or a bearing that holds the \
                    slope, which the model lacks.",
            signature: "Rigid-body modes rise above zero; low modes rise in proportion to the square of their motion \
                    there over ω².",
            formulation: "K gains k u² in one direction at the node, or k r² about one axis where the node rests on a \
                    support or a spring; k = 0 leaves it. A small k raises ω by k φ²/(2 ω).",
            confusable: &["point-mass", "stiffness-change", "axial-preload", "sprung-inertia"],
            references: &[
                "T. G. Carne, D. T. Griffith, M. E. Casias, Support conditions for experimental modal analysis, Sound and Vibration 41, 2007",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.nodes_along(&Dof::ALL, |n, dof| can_stand(structure, n, dof))
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Rig
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        let axes = structure.axes_at(at, &Dof::ALL, |n, dof| can_stand(structure, n, dof));
        let mut k = Named::new();
        for dof in &axes {
            let (unit, word) = if dof.is_rotation() { ("N m/rad", "about") } else { ("N/m", "along") };
            let typical = 0.02 * structure.generalised_stiffness(*dof);
            let about = format!("stiffness to ground at {} {word} {}", at.place(), &dof.name()[1..]);
            let quantity = if axes.len() > 1 { format!("stiffness_{dof}") } else { "stiffness".to_string() };
            let name = b.parameter(&quantity, unit, typical, [0.0, 1000.0 * typical], &about);
            k.extend(entry(dof.name(), &name));
        }
        for (i, node) in at.names.iter().enumerate() {
            let name = if at.names.len() > 1 { format!("{}.{}", b.stem(), i + 1) } else { b.stem().to_string() };
            let entry = SpringSpec { node: Some(node.clone()), k: k.clone(), ..SpringSpec::default() };
            b.edit(Edit::AddSpring { name, entry });
        }
        Ok(b.finish())
    }
}

/// Whether a node moves in a direction in which what carries it can hold it: along every axis; about one, where it rests on a support or
/// a spring, as in a bearing that holds the slope.
fn can_stand(structure: &Structure<'_>, node: usize, dof: Dof) -> bool {
    let can_hold = !dof.is_rotation() || structure.is_supported(node) || structure.is_mounted(node);
    structure.generalised_stiffness(dof) > 0.0 && structure.node_moves(node, dof) && can_hold
}
