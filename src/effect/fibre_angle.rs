//! Fibres that run in another direction than the model has them.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry, times};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "Plies or an orthotropic skin that were laid at another angle than the model has."]
#[derive(Debug, Clone, Copy)]
pub struct FibreAngle;

impl Effect for FibreAngle {
    fn name(&self) -> &'static str {
        "fibre-angle"
    }

    fn about(&self) -> About {
        About {
            summary: "Plies or an orthotropic skin that were laid at another angle than the model has.",
            signature: "Bending and twist couple more, or less: shapes of bending turn, torsion rises where bending falls; mass \
                    stays.",
            formulation: "The `angle` of the shells gains p about their normals; all plies turn together; p = 0 leaves them.",
            confusable: &["bend-twist-coupling", "stiffness-change", "thickness-change"],
            references: &[
                "R. M. Jones, Mechanics of Composite Materials, Taylor & Francis 1999",
                "T. A. Weisshaar, B. L. Foist, Vibration tailoring of advanced composite lifting surfaces, J. Aircraft 22, 1985",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let is_directed = |e: usize| {
            let of = |a, b| structure.property(e, a).zip(structure.property(e, b));
            // Alike along and across, and between them, is alike in every direction.
            let differs = |pair: Option<(f64, f64)>| pair.is_some_and(|(a, b)| (a / b - 1.0).abs() > 1e-6);
            let isotropic = |a, b, c| {
                let all = [structure.property(e, a), structure.property(e, b), structure.property(e, c)];
                let [Some(a), Some(b), Some(c)] = all else { return true };
                ((a - b) / (2.0 * c) - 1.0).abs() <= 1e-6
            };
            differs(of("E1", "E2"))
                || differs(of("A11", "A22"))
                || differs(of("D11", "D22"))
                || !isotropic("A11", "A12", "A66")
                || !isotropic("D11", "D12", "D66")
        };
        structure.skins(is_directed)
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("angle of the fibres of {} against the model", at.place());
        let p = b.parameter("angle", "rad", 0.1, [-0.5, 0.5], &about);
        // The image of a turn is a turn the other way.
        for (i, part) in parts.iter().enumerate() {
            let suffix = if i == 0 { String::new() } else { format!(".{}", i + 1) };
            let turn = times(if i == 0 { 1.0 } else { -1.0 }, &p);
            b.change(
                &suffix,
                &entries(&[part]),
                OverrideSpec { add: entry("angle", &turn), ..OverrideSpec::default() },
            );
        }
        Ok(b.finish())
    }
}
