//! A skin that is thinner or thicker than the model has it.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "A shell that is thinner or thicker than the model has it: corrosion, wear, a tolerance of rolling, a doubler."]
#[derive(Debug, Clone, Copy)]
pub struct ThicknessChange;

impl Effect for ThicknessChange {
    fn name(&self) -> &'static str {
        "thickness-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A shell that is thinner or thicker than the model has it: corrosion, wear, a tolerance of rolling, a \
                    doubler.",
            signature: "Stiffness of membranes goes with the thickness, of bending with its cube, and mass with the thickness: \
                    modes that bend the place rise with it, those that only carry it fall.",
            formulation: "The thickness of the shells is multiplied by 1 + p; p = 0 leaves it.",
            confusable: &["stiffness-change", "bending-stiffness-change", "distributed-mass"],
            references: &[
                "O. S. Salawu, Detection of structural damage through changes in frequency: a review, Engineering Structures 19, 1997",
                "A. W. Leissa, Vibration of Plates, NASA SP-160, 1969",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.skins(|e| structure.property(e, "thickness").is_some())
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("thickness of {} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", 0.1, [-0.9, 2.0], &about);
        let scale = entry("thickness", &format!("1 + {p}"));
        b.change("", &entries(&parts), OverrideSpec { scale, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
