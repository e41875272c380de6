//! A dashpot of the file that damps otherwise than stated.

use super::edit::PatchError;
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Part, PartKind, Structure, entries};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::OverrideSpec;

#[doc = "A dashpot of the file that damps more or less than stated, or is not connected: a damper that leaks, a joint that is stuck."]
#[derive(Debug, Clone, Copy)]
pub struct DashpotChange;

impl Effect for DashpotChange {
    fn name(&self) -> &'static str {
        "dashpot-change"
    }

    fn about(&self) -> About {
        About {
            summary: "A dashpot of the file that damps more or less than stated, or is not connected: a damper that \
                    leaks, a joint that is stuck.",
            signature: "Damping ratios of the modes that work the dashpot change together; frequencies stay to first order. Only \
                    FRFs and damping ratios show it.",
            formulation: "Every dashpot of the element is multiplied by 1 + p; p = 0 leaves it, p = -1 takes it away.",
            confusable: &["ground-dashpot", "stiffness-damping", "mass-damping"],
            references: &[
                "S. Adhikari, Damping models for structural vibration, 2000",
                "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.places(|p| {
            let first = dashpots(structure, p.elements[0]);
            let is_meant = matches!(p.kind, PartKind::Element | PartKind::Group) && !first.is_empty();
            is_meant && p.elements.iter().all(|&e| dashpots(structure, e) == first)
        })
    }

    fn damps(&self) -> bool {
        true
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts: Vec<&Part> = structure.parts_at(self.name(), at)?;
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let first = *parts.first().and_then(|p| p.elements.first()).ok_or_else(unknown)?;
        let mut b = Builder::new(self.name(), at);
        let about = format!("damping of {} against the model, factor less one", at.place());
        let p = b.parameter("change", "1", -0.3, [-1.0, MOST], &about);
        let scale = dashpots(structure, first).iter().flat_map(|name| entry(name, &format!("1 + {p}"))).collect();
        b.change("", &entries(&parts), OverrideSpec { scale, ..OverrideSpec::default() });
        Ok(b.finish())
    }
}

/// A damper may be stuck, or of another kind.
const MOST: f64 = 9.0;

/// The dashpots that an element has, by the names of their properties.
fn dashpots(structure: &Structure<'_>, element: usize) -> Vec<String> {
    let along = Dof::ALL.into_iter().map(|dof| format!("c_{}", dof.name()));
    let has = |name: &String| structure.property(element, name).is_some_and(|c| c > 0.0);
    std::iter::once("c".to_string()).chain(along).filter(has).collect()
}
