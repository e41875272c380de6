//! A connection between two near nodes that the model does not have.

use super::edit::{Edit, PatchError};
use super::location::Location;
use super::patch::{Builder, Patch, between, entry};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::{ElementSpec, Named, SectionValue, SpringSpec};
use crate::units::Scalar;

/// Typical stiffness against M ω² of the structure: a strut that is seen.
const SEEN: f64 = 0.05;

#[doc = "A connection that the model lacks between two near nodes: a brace, a strut, a path through a skin, a bolt or a contact between two faces."]
#[derive(Debug, Clone, Copy)]
pub struct Connection;

impl Effect for Connection {
    fn name(&self) -> &'static str {
        "connection"
    }

    fn about(&self) -> About {
        About {
            summary: "A connection that the model lacks between two near nodes: a brace, a strut, a path through a skin, a \
                    bolt or a contact between two faces.",
            signature: "Modes that move the two nodes against each other rise; those that move them alike stay.",
            formulation: "K gains k d dᵀ along the line between the nodes, d their relative displacement; where they are at \
                    one place, k along all three axes. k = 0 leaves it. ω rises by k d²/(2 ω).",
            confusable: &["rigid-link", "stiffness-change", "bending-stiffness-change", "ground-spring", "asymmetry"],
            references: &[
                "C. Mares, M. I. Friswell, J. E. Mottershead, Model updating using robust estimation, Mechanical Systems and Signal Processing 16, 2002",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.generalised_stiffness(Dof::Ux) > 0.0 { structure.near_pairs() } else { Vec::new() }
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let pairs = structure.pairs_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let typical = SEEN * structure.generalised_stiffness(Dof::Ux);
        let about = format!("stiffness of a connection between {}", between(&pairs));
        let k = b.parameter("stiffness", "N/m", typical, [0.0, structure.rigid()], &about);
        for (name, pair) in b.named(&pairs) {
            let nodes = pair.map(str::to_string);
            if structure.coincide(*pair) {
                let axes = [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().filter(|&dof| structure.any_node_moves(dof));
                let k: Named<Scalar> = axes.flat_map(|dof| entry(dof.name(), &k)).collect();
                b.edit(Edit::AddSpring { name, entry: SpringSpec { nodes: Some(nodes), k, ..SpringSpec::default() } });
            } else {
                let properties = entry("k", &k).into_iter().map(|(n, v)| (n, SectionValue::Scalar(v))).collect();
                let entry = ElementSpec {
                    kind: "spring".to_string(),
                    nodes: nodes.to_vec(),
                    section: None,
                    properties,
                    orientation: None,
                    frame: None,
                };
                b.edit(Edit::AddElement { name, entry });
            }
        }
        Ok(b.finish())
    }
}
