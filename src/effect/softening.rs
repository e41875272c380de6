//! All members softer or stiffer together.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::structure::Structure;
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "All members softer (or stiffer) by one factor: temperature, moisture, cure, a modulus that is wrong everywhere."]
#[derive(Debug, Clone, Copy)]
pub struct Softening;

impl Effect for Softening {
    fn name(&self) -> &'static str {
        "softening"
    }

    fn about(&self) -> About {
        About {
            summary: "All members softer (or stiffer) by one factor: temperature, moisture, cure, a modulus that is \
                    wrong everywhere.",
            signature: "All elastic frequencies shift by the same ratio, shapes stay; rigid-body modes on springs stay.",
            formulation: "The stiffness matrix of every beam and bar is multiplied by 1 - p; p = 0 leaves it; every \
                    frequency falls by p/2.",
            confusable: &["stiffness-change", "distributed-mass", "air-mass"],
            references: &[
                "P. Cornwell, C. R. Farrar, S. W. Doebling, H. Sohn, Environmental variability of modal properties, Experimental Techniques 23, 1999",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        if structure.stiff_entries(false).is_empty() { Vec::new() } else { vec![Location::whole()] }
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let mut b = Builder::new(self.name(), at);
        let p = b.parameter("loss", "1", 0.02, [-0.3, 0.5], "loss of stiffness of all members, relative");
        let factor = Some(scalar(&format!("1 - {p}")));
        b.change("", &structure.stiff_entries(false), OverrideSpec { stiffness: factor, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}
