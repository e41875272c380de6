//! A spring to ground: suspension, cables, contact.

use super::location::Location;
use super::patch::{Builder, Edit, Patch, PatchError, entry};
use super::structure::Structure;
use super::{About, Belongs, Effect};
use crate::element::Dof;
use crate::model::spec::SpringSpec;

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
        let mut all = Vec::new();
        for dof in Dof::ALL {
            // A bearing that holds the slope: only what carries a node can resist its turning.
            let can_hold = |n: usize| !dof.is_rotation() || structure.is_supported(n) || structure.is_mounted(n);
            let matters = structure.generalised_stiffness(dof) > 0.0;
            let nodes = structure.nodes(|n| matters && structure.node_moves(n, dof) && can_hold(n));
            all.extend(nodes.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Rig
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
        let (unit, word) = if dof.is_rotation() { ("N m/rad", "about") } else { ("N/m", "along") };
        let typical = 0.02 * structure.generalised_stiffness(dof);
        let axis = &at.direction()[1..];
        let about = format!("stiffness to ground at {} {word} {axis}", at.place());
        let k = b.parameter("stiffness", unit, typical, [0.0, 1000.0 * typical], &about);
        for (i, node) in at.names.iter().enumerate() {
            let name = if at.names.len() > 1 { format!("{}.{}", b.stem(), i + 1) } else { b.stem().to_string() };
            let k = entry(at.direction(), &k);
            b.edit(Edit::AddSpring {
                name,
                entry: SpringSpec { node: Some(node.clone()), k, ..SpringSpec::default() },
            });
        }
        Ok(b.finish())
    }
}
