//! A rigid link between two near nodes that the model does not have.

use super::edit::{Edit, NewParameter, PatchError};
use super::flow::number;
use super::location::Location;
use super::patch::{Builder, Patch, between, entry, round};
use super::structure::Structure;
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::{ElementSpec, SectionValue};
use crate::units::Scalar;

/// Typical stiffness against M ω² of the structure: its lowest modes hardly strain a stiffer link.
const STIFF: f64 = 10.0;
/// Where it is sought, against the typical stiffness: from a soft link a fit hardly comes to a rigid one, which other modes pair with.
const STARTS: [f64; 3] = [0.01, 1.0, 1000.0];

#[doc = "Two nodes across a gap, or at one place, that the model leaves apart and the structure holds in displacement and rotation: a weld, a fitting, nodes that were not merged."]
#[derive(Debug, Clone, Copy)]
pub struct RigidLink;

impl Effect for RigidLink {
    fn name(&self) -> &'static str {
        "rigid-link"
    }

    fn about(&self) -> About {
        About {
            summary: "Two nodes across a gap, or at one place, that the model leaves apart and the structure holds in \
                    displacement and rotation: a weld, a fitting, nodes that were not merged.",
            signature: "Modes that move or turn the two nodes against each other rise; rigid motions of the two together \
                    stay.",
            formulation: "A bushing between rigid arms to the middle of the two nodes: k along all three axes and k a² about them, a \
                    a quarter of the largest dimension. k = 0 leaves it; far above M ω² the link is rigid.",
            confusable: &["connection", "stiffness-change", "bending-stiffness-change", "joint-flexibility"],
            references: &[
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.generalised_stiffness(Dof::Rx) > 0.0 { structure.pairs_across_gaps() } else { Vec::new() }
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let pairs = structure.pairs_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let typical = STIFF * structure.generalised_stiffness(Dof::Ux);
        let turning = structure.generalised_stiffness(Dof::Rx) / structure.generalised_stiffness(Dof::Ux);
        let about = format!("stiffness of a link between {}", between(&pairs));
        let k = b.add(NewParameter {
            name: format!("{}.stiffness", b.stem()),
            unit: "N/m".to_string(),
            neutral: 0.0,
            typical: round(typical),
            bounds: [0.0, round(structure.rigid())],
            grid: STARTS.map(|share| round(share * typical)).to_vec(),
            description: about,
        });
        for (name, pair) in b.named(&pairs) {
            let of = |dof: &Dof| {
                let value = if dof.is_rotation() { format!("{} m2*{k}", number(turning)) } else { k.clone() };
                (format!("k_{}", dof.name()), value)
            };
            let properties = Dof::ALL.iter().map(of).flat_map(|(name, value)| entry(&name, &value));
            let properties = properties.map(|(name, v): (String, Scalar)| (name, SectionValue::Scalar(v))).collect();
            let entry = ElementSpec {
                kind: "bushing".to_string(),
                nodes: pair.map(str::to_string).to_vec(),
                section: None,
                properties,
                orientation: None,
                frame: None,
            };
            b.edit(Edit::AddElement { name, entry });
        }
        Ok(b.finish())
    }
}
