//! A dashpot to ground.

use super::edit::{Edit, PatchError};
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::Structure;
use super::{About, Belongs, Effect};
use crate::element::Dof;
use crate::model::spec::SpringSpec;

#[doc = "A dashpot between a node and the ground: friction of a support, a shaker's coil, a damper."]
#[derive(Debug, Clone, Copy)]
pub struct GroundDashpot;

impl Effect for GroundDashpot {
    fn name(&self) -> &'static str {
        "ground-dashpot"
    }

    fn about(&self) -> About {
        About {
            summary: "A dashpot between a node and the ground: friction of a support, a shaker's coil, a damper.",
            signature: "Damping ratios of modes that move the node rise by c φ²/(2 ω); FRF peaks fall, shapes become \
                    complex; frequencies stay to first order. Only FRFs and damping ratios show it.",
            formulation: "C gains c v² in one direction at the node; c = 0 leaves it. Hysteretic (frequency-independent) \
                    damping is not part of K, M, C: see `stiffness-damping` for its viscous equivalent.",
            confusable: &["stiffness-damping", "mass-damping"],
            references: &[
                "S. Adhikari, Damping models for structural vibration, 2000",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for dof in [Dof::Ux, Dof::Uy, Dof::Uz] {
            let nodes = structure.nodes(|n| structure.node_moves(n, dof) && structure.total_mass() > 0.0);
            all.extend(nodes.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn belongs_to(&self) -> Belongs {
        Belongs::Rig
    }

    fn damps(&self) -> bool {
        true
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        let typical = 0.02 * structure.total_mass() * structure.omega2().sqrt();
        let about = format!("dashpot to ground at {} along {}", at.place(), &at.direction()[1..]);
        let c = b.parameter("damping", "N s/m", typical, [0.0, 50.0 * typical], &about);
        for (i, node) in at.names.iter().enumerate() {
            let name = if at.names.len() > 1 { format!("{}.{}", b.stem(), i + 1) } else { b.stem().to_string() };
            let c = entry(at.direction(), &c);
            b.edit(Edit::AddSpring {
                name,
                entry: SpringSpec { node: Some(node.clone()), c, ..SpringSpec::default() },
            });
        }
        Ok(b.finish())
    }
}
