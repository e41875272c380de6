//! A mass of the file on a spring.

use super::edit::{Edit, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::sprung::on_springs;
use super::structure::{Part, Structure};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::{MassSpec, ModelSpec, OverrideSpec};

#[doc = "A mass that the model has rigid on its node and that stands on a spring: equipment on a bracket, an engine on mounts, a fuel tank that sloshes."]
#[derive(Debug, Clone, Copy)]
pub struct FlexibleMount;

impl Effect for FlexibleMount {
    fn name(&self) -> &'static str {
        "flexible-mount"
    }

    fn about(&self) -> About {
        About {
            summary: "A mass that the model has rigid on its node and that stands on a spring: equipment on a bracket, an \
                    engine on mounts, a fuel tank that sloshes.",
            signature: "An extra mode near the frequency of the mass on its spring; below it modes sink, above it they rise as if \
                    the mass were not there.",
            formulation: "The share p of the mass of the file moves to a node of its own, joined to the old one by a spring k in \
                    one direction, or one in each of several, and rigidly in the others: M loses p m u̇² and gains p m ṡ², K gains k (s - u)². p = 0 leaves it, \
                    p = 1 is all of the mass; its frequency is √(k/pm)/2π.",
            confusable: &["sprung-mass", "absent-mass", "point-mass"],
            references: &[
                "J. P. Den Hartog, Mechanical Vibrations, 1956, section 3.2",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        structure.masses_along(&TRANSLATIONS, |p, dof| can_give(structure, p, dof))
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let part = structure.parts_at(self.name(), at)?[0];
        let dofs: Vec<Dof> =
            TRANSLATIONS.into_iter().filter(|&dof| at.is_along(dof) && can_give(structure, part, dof)).collect();
        if dofs.is_empty() {
            return Err(unknown());
        }
        let bodies = at.names.iter().map(|name| stands(structure, name).ok_or_else(unknown));
        let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
        let mass = structure.mass_of(&part.elements);
        let mut b = Builder::new(self.name(), at);
        let about = format!("share of {} that stands on a spring", at.place());
        let p = b.parameter("share", "1", 1.0, [0.0, 1.0], &about);
        let about = |along: &str| {
            format!("stiffness of the spring under {}{along}; any value is neutral while the share is zero", at.place())
        };
        let hosts: Vec<String> = bodies.iter().filter_map(|(body, _)| body.node.clone()).collect();
        let stores = on_springs(&mut b, structure, &hosts, (&dofs, mass, about));
        for (((body, _), store), name) in bodies.into_iter().zip(stores).zip(&at.names) {
            let moved = format!("{store}.mass");
            b.edit(Edit::AddMass { name: moved.clone(), entry: MassSpec { node: Some(store), ..body.clone() } });
            // What moves stays as other changes have made it: no mass is lost.
            for (of, change) in changes_of(structure.model().spec(), name) {
                b.change(&format!(".{name}.as.{of}"), std::slice::from_ref(&moved), change.clone());
            }
            let there = Some(scalar(&p));
            b.change(&format!(".{name}.there"), &[moved], OverrideSpec { mass: there, ..OverrideSpec::default() });
            let left = Some(scalar(&format!("1 - {p}")));
            b.change(
                &format!(".{name}"),
                std::slice::from_ref(name),
                OverrideSpec { mass: left, ..OverrideSpec::default() },
            );
        }
        Ok(b.finish())
    }
}

const TRANSLATIONS: [Dof; 3] = [Dof::Ux, Dof::Uy, Dof::Uz];

/// Whether a part is a mass of the file that can stand on a spring in a direction.
fn can_give(structure: &Structure<'_>, part: &Part, dof: Dof) -> bool {
    !structure.context().is_own_mass(&part.name)
        && structure.mass_of(&part.elements) > 0.0
        && stands(structure, &part.name).is_some_and(|(_, n)| structure.node_moves(n, dof))
}

/// A mass of the file on one node, and the node.
fn stands<'s>(structure: &Structure<'s>, name: &str) -> Option<(&'s MassSpec, usize)> {
    let body = structure.model().spec().masses.get(name)?;
    Some((body, structure.model().geometry().node(body.node.as_ref()?)?))
}

/// The overrides that change a mass, by its name or by a group.
fn changes_of<'m>(model: &'m ModelSpec, name: &'m str) -> impl Iterator<Item = (&'m String, &'m OverrideSpec)> {
    let is_it =
        move |known: &String| known == name || model.groups.get(known).is_some_and(|g| g.iter().any(|n| n == name));
    model.overrides.iter().filter(
        move |(of, change)| {
            if change.of.is_empty() { is_it(of) } else { change.of.iter().any(is_it) }
        },
    )
}
