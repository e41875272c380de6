//! A mass of the file on a spring.

use super::edit::{Edit, PatchError, scalar};
use super::location::Location;
use super::patch::{Builder, Patch};
use super::sprung::on_springs;
use super::structure::{PartKind, Structure};
use super::{About, Effect};
use crate::element::Dof;
use crate::model::spec::{MassSpec, OverrideSpec};

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
                    one direction and rigidly in the others: M loses p m u̇² and gains p m ṡ², K gains k (s - u)². p = 0 leaves it, \
                    p = 1 is all of the mass; its frequency is √(k/pm)/2π.",
            confusable: &["sprung-mass", "absent-mass", "point-mass"],
            references: &[
                "J. P. Den Hartog, Mechanical Vibrations, 1956, section 3.2",
                "R. D. Blevins, Formulas for Natural Frequency and Mode Shape, 1979",
            ],
        }
    }

    fn locations(&self, structure: &Structure<'_>) -> Vec<Location> {
        let mut all = Vec::new();
        for dof in [Dof::Ux, Dof::Uy, Dof::Uz] {
            let places = structure.places(|p| {
                p.kind == PartKind::Mass
                    && !structure.context().is_own_mass(&p.name)
                    && structure.mass_of(&p.elements) > 0.0
                    && stands(structure, &p.name).is_some_and(|(_, n)| structure.node_moves(n, dof))
            });
            all.extend(places.into_iter().map(|at| at.along(dof.name())));
        }
        all
    }

    fn patch(&self, structure: &Structure<'_>, at: &Location) -> Result<Patch, PatchError> {
        let unknown = || PatchError::unknown_place(self.name(), &at.to_string(), &[]);
        let dof = Dof::from_name(at.direction()).ok_or_else(unknown)?;
        let bodies = at.names.iter().map(|name| stands(structure, name).ok_or_else(unknown));
        let bodies = bodies.collect::<Result<Vec<_>, _>>()?;
        let mass = structure.mass_of(&structure.parts_at(self.name(), at)?[0].elements);
        let mut b = Builder::new(self.name(), at);
        let about = format!("share of {} that stands on a spring", at.place());
        let p = b.parameter("share", "1", 1.0, [0.0, 1.0], &about);
        let about =
            format!("stiffness of the spring under {}; any value is neutral while the share is zero", at.place());
        let hosts: Vec<String> = bodies.iter().filter_map(|(body, _)| body.node.clone()).collect();
        let stores = on_springs(&mut b, structure, &hosts, (dof, mass, about));
        for (((body, _), store), name) in bodies.into_iter().zip(stores).zip(&at.names) {
            let moved = format!("{store}.mass");
            b.edit(Edit::AddMass { name: moved.clone(), entry: MassSpec { node: Some(store), ..body.clone() } });
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

/// A mass of the file on one node, and the node.
fn stands<'s>(structure: &Structure<'s>, name: &str) -> Option<(&'s MassSpec, usize)> {
    let body = structure.model().spec().masses.get(name)?;
    Some((body, structure.model().geometry().node(body.node.as_ref()?)?))
}
