//! Tension or pressure in a skin.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Structure, entries};
use super::{About, Effect};
use crate::model::spec::OverrideSpec;

#[doc = "A static tension or pressure in a skin, alike in all directions of its plane: heat, a frame that was pulled tight, stresses of welding."]
#[derive(Debug, Clone, Copy)]
pub struct MembranePreload;

impl Effect for MembranePreload {
    fn name(&self) -> &'static str {
        "membrane-preload"
    }

    fn about(&self) -> About {
        About {
            summary: "A static tension or pressure in a skin, alike in all directions of its plane: heat, a frame that was pulled \
                    tight, stresses of welding.",
            signature: "Shifts low bending modes most (the relative effect falls with the square of the wave number); motions in \
                    the plane and mass stay.",
            formulation: "Geometric stiffness N ∫ |∇w|² dA by `N11` and `N22`, tension positive; N = 0 leaves it. A simply supported \
                    plate has ω² = ω0² + N (π²/a² p² + π²/b² q²)/m.",
            confusable: &["bending-stiffness-change", "stiffness-change", "thickness-change"],
            references: &[
                "A. W. Leissa, Vibration of Plates, NASA SP-160, 1969, section 10.1",
                "S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 2nd ed., 1961, section 9.2",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.skins(|e| buckling_force(structure, e).is_some())
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let least = parts
            .iter()
            .flat_map(|p| &p.elements)
            .filter_map(|&e| buckling_force(structure, e))
            .fold(f64::INFINITY, f64::min);
        if !least.is_finite() {
            return Err(PatchError::unknown_place(self.name(), &at.to_string(), &[]));
        }
        let mut b = Builder::new(self.name(), at);
        let about = format!("force by width in {}, in every direction of its plane, tension positive", at.place());
        let n = b.parameter("force", "N/m", 0.5 * least, [-0.5 * least, 100.0 * least], &about);
        let add = [entry("N11", &n), entry("N22", &n)].into_iter().flatten().collect();
        b.change("", &entries(&parts), OverrideSpec { add, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}

/// What a plate of the bending rigidity of a shell bears before it buckles, N/m, were it clamped at one edge and as long as the structure is large:
/// π² D/4 L².
fn buckling_force(structure: &Structure<'_>, element: usize) -> Option<f64> {
    let of = |name: &str| structure.property(element, name);
    let plies = of("D11").zip(of("D22")).map(|(a, b)| a.min(b));
    let plate = |e: f64| of("thickness").map(|t| e * t.powi(3) / 12.0);
    let rigidity = plies.or_else(|| of("E").and_then(plate)).or_else(|| {
        let (along, across) = of("E1").zip(of("E2"))?;
        plate(along.min(across))
    })?;
    let size = structure.extent();
    (rigidity > 0.0 && size > 0.0).then(|| std::f64::consts::PI.powi(2) * rigidity / (4.0 * size * size))
}
