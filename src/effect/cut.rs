//! A cut or a crack through shells.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

/// Nearly all of a stiffness: what is left keeps nodes between cut elements in place, and even over the length of one element is nothing beside the
/// bending of what is cut. A hundredth would still hold both sides of a slit together.
const NEARLY_ALL: f64 = 0.99999;

#[doc = "A saw cut, a crack or an open seam through shells, from a free edge inwards."]
#[derive(Debug, Clone, Copy)]
pub struct Cut;

impl Effect for Cut {
    fn name(&self) -> &'static str {
        "cut"
    }

    fn about(&self) -> About {
        About {
            summary: "A saw cut, a crack or an open seam through shells, from a free edge inwards.",
            signature: "Modes that bend or twist the shell across the line fall, most of all those in which its two sides move apart.",
            formulation: "The stiffness matrix of a run of elements, one wide, is multiplied by 1 - p, their mass is left; p = 0 leaves them, \
                    p = 0.99999 parts both sides. A real cut is narrower than an element: on a finer mesh it is better met.",
            confusable: &["stiffness-change", "bending-stiffness-change", "thickness-change"],
            references: &[
                "A. D. Dimarogonas, Vibration of cracked structures: a state of the art review, Engineering Fracture Mechanics 55, 1996",
                "M. I. Friswell, J. E. T. Penny, Crack modeling for structural health monitoring, Structural Health Monitoring 1, 2002",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.cuts()
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("share of the stiffness of {} that is cut", at.place());
        let p = b.parameter("loss", "1", 0.5, [0.0, NEARLY_ALL], &about);
        let left = Some(scalar(&format!("1 - {p}")));
        b.change("", &entries(&parts), OverrideSpec { stiffness: left, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
