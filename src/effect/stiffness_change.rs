//! A stiffness that is locally wrong.

use super::edit::{PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch, entry};
use super::structure::{Part, PartKind, Structure, entries};
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
                    remove it. Of a spring or bushing that is stiff in several directions, also one of them alone, k_uz \
                    (1 + p), and those together in which it is equally stiff, rx_ry. Of a spring that is far stiffer than the structure, p is near -1: a support that gives.",
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
        let mut springs = |direction: &str, gives: &dyn Fn(usize) -> bool| {
            let is_meant = |p: &Part| matches!(p.kind, PartKind::Element | PartKind::Group);
            let places = structure.places(|p| is_meant(p) && p.elements.iter().all(|&e| gives(e)));
            all.extend(places.into_iter().map(|at| at.along(direction)));
        };
        for dof in Dof::ALL {
            springs(dof.name(), &|e| gives_several_ways(structure, e, dof));
        }
        for dofs in SEVERAL {
            springs(&dofs.iter().map(|d| d.name()).collect::<Vec<_>>().join(AND), &|e| gives_alike(structure, e, dofs));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let parts = structure.parts_at(self.name(), at)?;
        let mut b = Builder::new(self.name(), at);
        let (along, most) = match at.direction() {
            "" => (String::new(), 2.0),
            dofs => (format!(" along {}", dofs.replace(AND, " and ")), MOST_OF_A_SPRING),
        };
        let about = format!("stiffness of {}{along} against the model, factor less one", at.place());
        let hardly = parts.iter().flat_map(|p| &p.elements).map(|&e| hardly_gives(structure, e, at.direction()));
        let (typical, bounds) = match hardly.fold(f64::INFINITY, f64::min) {
            k if k > STIFF && k.is_finite() => (GIVES / k - 1.0, [LEAST / k - 1.0, most]),
            _ => (0.1, [-0.99, most]),
        };
        let p = b.parameter("change", "1", typical, bounds, &about);
        let factor = format!("1 + {p}");
        let change = match at.direction() {
            "" => OverrideSpec { stiffness: Some(scalar(&factor)), ..OverrideSpec::default() },
            dofs => {
                let scale = dofs.split(AND).flat_map(|dof| entry(&stiffness_along(dof), &factor)).collect();
                OverrideSpec { scale, ..OverrideSpec::default() }
            }
        };
        b.change("", &entries(&parts), change);
        Ok(b.finish())
    }
}

/// Stiffness of a spring against the generalised one of the structure, M ω²: above the first a tenth less is hardly seen, and a support that gives
/// does so by another order of magnitude. It is sought from where it gives much, for from there steps fall short and from the stiff side they go too
/// far; and down to the least.
const STIFF: f64 = 10.0;
const GIVES: f64 = 2.0;
const LEAST: f64 = 0.01;
/// The stiffest direction of a spring, or that along a dof, against M ω² of the structure; zero of what is not a spring.
fn hardly_gives(structure: &Structure<'_>, element: usize, along: &str) -> f64 {
    let is_meant = |dof: &Dof| along.is_empty() || along.split(AND).any(|d| d == dof.name());
    let of = |dof: Dof| {
        let k = structure.property(element, &stiffness_along(dof.name()))?;
        Some(k / structure.generalised_stiffness(dof))
    };
    let most = Dof::ALL.into_iter().filter(is_meant).filter_map(of).fold(0.0, f64::max);
    if most.is_finite() { most } else { 0.0 }
}

/// A mount may be blocked.
const MOST_OF_A_SPRING: f64 = 9.0;

/// Name of the property of a bushing or a ground spring.
fn stiffness_along(dof: &str) -> String {
    format!("k_{dof}")
}

/// Directions that may be of one cause: a foundation rocks about both axes, a mount gives sideways alike.
const SEVERAL: [&[Dof]; 8] = [
    &[Dof::Ux, Dof::Uy, Dof::Uz],
    &[Dof::Ux, Dof::Uy],
    &[Dof::Ux, Dof::Uz],
    &[Dof::Uy, Dof::Uz],
    &[Dof::Rx, Dof::Ry, Dof::Rz],
    &[Dof::Rx, Dof::Ry],
    &[Dof::Rx, Dof::Rz],
    &[Dof::Ry, Dof::Rz],
];
/// Between the names of such directions.
const AND: &str = "_";

/// The directions in which an element is a spring, each with its stiffness.
fn stiffnesses(structure: &Structure<'_>, element: usize) -> Vec<(Dof, f64)> {
    let of = |dof: Dof| Some((dof, structure.property(element, &stiffness_along(dof.name()))?));
    Dof::ALL.into_iter().filter_map(of).filter(|(_, k)| *k > 0.0).collect()
}

/// Whether an element is a spring that is stiff in this direction and in others.
fn gives_several_ways(structure: &Structure<'_>, element: usize, dof: Dof) -> bool {
    let all = stiffnesses(structure, element);
    structure.deforms(element) && all.len() > 1 && all.iter().any(|(d, _)| *d == dof)
}

/// Whether an element is a spring of one stiffness in these directions, of another in all others of their kind, and stiff in some other.
fn gives_alike(structure: &Structure<'_>, element: usize, dofs: &[Dof]) -> bool {
    let all = stiffnesses(structure, element);
    let Some(&(_, first)) = all.iter().find(|(d, _)| *d == dofs[0]) else { return false };
    let is_alike = |d: &Dof, k: f64| d.is_rotation() == dofs[0].is_rotation() && (k - first).abs() <= 1e-9 * first;
    let alike: Vec<Dof> = all.iter().filter(|(d, k)| is_alike(d, *k)).map(|(d, _)| *d).collect();
    structure.deforms(element) && alike == dofs && all.len() > dofs.len()
}
