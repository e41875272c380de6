//! A stiffness that is locally wrong.

use super::location::Location;
use super::patch::{Builder, Patch, PatchError, entry, scalar};
use super::structure::{PartKind, Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "A part of the structure that is softer or stiffer than the model has it: damage, a splice, a doubler, a wrong modulus."]
#[derive(Debug, Clone, Copy)]
pub struct StiffnessChange;

impl Effect for StiffnessChange {
    fn name(&self) -> &'static str {
        "stiffness-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A part of the structure that is softer or stiffer than the model has it: damage, a splice, a \
                    doubler, a wrong modulus.",
            signature: "Shifts modes that strain the part, up or down together; curvature of the shapes changes there.",
            formulation: "The stiffness matrix of the elements is multiplied by 1 + p; p = 0 leaves it, p = -1 would \
                    remove it. Of a spring or bushing that is stiff in several directions, also one of them alone: k_uz \
                    (1 + p).",
            confusable: &[
                "bending-stiffness-change",
                "torsion-stiffness-change",
                "joint-flexibility",
                "taper",
                "softening",
            ],
            references: &[
                "O. S. Salawu, Detection of structural damage through changes in frequency: a review, Engineering Structures 19, 1997",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all =
            structure.places(|p| p.kind != PartKind::Mass && p.elements.iter().any(|&e| structure.deforms(e)));
        for dof in Dof::ALL {
            let springs = structure.places(|p| {
                p.kind == PartKind::Element && p.elements.iter().all(|&e| gives_several_ways(structure, e, dof))
            });
            all.extend(springs.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let (along, most) = match at.direction() {
            "" => (String::new(), 2.0),
            dof => (format!(" along {dof}"), MOST_OF_A_SPRING),
        };
        let about = format!("stiffness of {}{along} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, [-0.99, most], &about);
        let factor = format!("1 + {p}");
        let change = match at.direction() {
            "" => OverrideSpec { stiffness: Some(scalar(&factor)), ..OverrideSpec::default() },
            dof => OverrideSpec { scale: entry(&stiffness_along(dof), &factor), ..OverrideSpec::default() },
        };
        b.change("", &entries(&parts), change);
        Ok(b.finish())
    }
}

/// A mount may be blocked.
const MOST_OF_A_SPRING: f64 = 9.0;

/// Name of the property of a bushing or a ground spring.
fn stiffness_along(dof: &str) -> String {
    format!("k_{dof}")
}

/// Whether an element is a spring that is stiff in this direction and in others.
fn gives_several_ways(structure: &Structure<'_>, element: usize, dof: Dof) -> bool {
    let is_stiff = |d: &Dof| structure.property(element, &stiffness_along(d.name())).is_some_and(|k| k > 0.0);
    structure.deforms(element) && is_stiff(&dof) && Dof::ALL.iter().filter(|d| is_stiff(d)).count() > 1
}
