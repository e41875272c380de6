//! Effects in their places on one model, ready to be tried.

use super::edit::{Edit, NewParameter, PatchError};
use super::location::{BASE, Location};
use super::patch::Patch;
use super::structure::{Context, Structure};
use super::{Belongs, Effect, Effects};
use crate::model::{Additions, Change, Model, Parameter, ParametricModel, Registry};
use indexmap::IndexMap;

/// An effect at a place.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Where.
    pub location: Location,
    /// The edits that put it there.
    pub patch: Patch,
    /// The parameters that it brings, in the order in which they follow those of the model.
    pub parameters: Vec<NewParameter>,
    /// ln of the prior of its place against one of those that every search tries: of one that is sought beside them it is part of the evidence.
    pub of_place: f64,
}

impl Candidate {
    /// The effect at one of its locations; `structure` is that of the configuration, if the location has one.
    pub fn new(effect: &'static dyn Effect, structure: &Structure<'_>, at: &Location) -> Result<Self, PatchError> {
        let mut patch = effect.patch(structure, at)?;
        if let Some(configuration) = &at.configuration {
            let configurations = &structure.model().spec().configurations;
            patch = match configuration.as_str() {
                BASE if !configurations.is_empty() => patch.outside(configurations.keys()),
                name => patch.within(name),
            };
        }
        let parameters = patch.parameters().cloned().collect();
        Ok(Self { effect, location: at.clone(), patch, parameters, of_place: 0.0 })
    }

    /// `mass-offset@left_wing.y`, as `add` takes it.
    pub fn id(&self) -> String {
        format!("{}@{}", self.effect.name(), self.location)
    }

    /// Sizes that an engineer would expect.
    pub fn typical(&self) -> Vec<f64> {
        self.parameters.iter().map(|p| p.typical).collect()
    }

    /// The parameters that it brings, as parameters of a model.
    pub fn sizes(&self) -> Vec<Parameter> {
        self.parameters.iter().map(NewParameter::parameter).collect()
    }

    /// What it changes in the matrices, of a file to which its edits were added; `None` where that is not made of elements.
    pub fn change(&self, additions: &Additions) -> Option<Change> {
        let parameters: Vec<&str> = self.parameters.iter().map(|p| p.name.as_str()).collect();
        let entries: Vec<&str> = self.patch.edits.iter().map(Edit::name).collect();
        additions.change(&parameters, &entries, &self.typical())
    }

    /// The model with the effect at its neutral value.
    pub fn build(&self, model: &Model, registry: &Registry) -> Result<Patched, PatchError> {
        let spec = self.patch.apply(model.spec())?;
        let (patched, _) = Model::new_beside(spec, registry, model).map_err(PatchError::Refused)?;
        Ok(Patched {
            first_new: model.parameters().len(),
            neutral: self.parameters.iter().map(|p| p.neutral).collect(),
            typical: self.typical(),
            model: patched,
        })
    }
}

/// A model with an effect in it; the new parameters stand last in θ.
#[derive(Debug, Clone)]
pub struct Patched {
    /// The model.
    pub model: Model,
    /// Index in θ of the first new parameter; the number of parameters of the model without the effect.
    pub first_new: usize,
    /// Values of the new parameters at which the model is as without the effect.
    pub neutral: Vec<f64>,
    /// Sizes that an engineer would expect.
    pub typical: Vec<f64>,
}

impl Patched {
    /// θ of the model without the effect, with the new parameters at `values`.
    pub fn theta(&self, base: &[f64], values: &[f64]) -> Vec<f64> {
        [base, values].concat()
    }

    /// Indices in θ of the new parameters.
    pub fn new_parameters(&self) -> std::ops::Range<usize> {
        self.first_new..self.first_new + self.neutral.len()
    }
}

/// Every effect at every place of a model, in the order of the effects and of the file.
pub fn candidates(model: &Model, effects: &Effects, context: &Context) -> Vec<Candidate> {
    candidates_in(&[Configured { name: None, model, context }], effects)
}

/// A configuration of a structure that was tested.
#[derive(Debug, Clone, Copy)]
pub struct Configured<'a> {
    /// Its name; none for the model without a configuration.
    pub name: Option<&'a str>,
    /// The model in it.
    pub model: &'a Model,
    /// What is known beside it.
    pub context: &'a Context,
}

/// Every effect at every place of a structure that was tested in several configurations.
///
/// What belongs to the structure acts in every configuration that has the place. A support's own effect acts where the support
/// is; what belongs to the rig of a test is tried in each configuration alone, and in all of them. What acts on a mass that a
/// configuration brings acts there.
pub fn candidates_in(tested: &[Configured<'_>], effects: &Effects) -> Vec<Candidate> {
    let structures: Vec<Structure<'_>> = tested.iter().map(|c| Structure::new(c.model, c.context)).collect();
    placed(tested, &structures, effects, |_, _| true)
}

/// Every effect at one place of a structure, in any direction and configuration.
///
/// * `names` - all of the names that the place has
pub fn candidates_at_place(tested: &[Configured<'_>], effects: &Effects, names: &[String]) -> Vec<Candidate> {
    let structures: Vec<Structure<'_>> = tested.iter().map(|c| Structure::new(c.model, c.context)).collect();
    placed(tested, &structures, effects, |_, at| at.names == names)
}

/// Every effect at the wider places of a structure: a few successive elements, ends that give about both axes of bending or in all
/// directions, nodes with all axes.
///
/// * `near` - names of nodes, elements, members, spans or ends of which a place has to have a node or an element; none for all places
pub fn candidates_on_wider_places(
    tested: &[Configured<'_>],
    effects: &Effects,
    near: Option<&[String]>,
) -> Vec<Candidate> {
    let structures: Vec<Structure<'_>> =
        tested.iter().map(|c| Structure::new(c.model, c.context).on_wider_places()).collect();
    placed(tested, &structures, effects, |structure, at| structure.is_wide_and_near(at, near))
}

/// * `is_wanted` - of the locations that an effect lists
fn placed(
    tested: &[Configured<'_>],
    structures: &[Structure<'_>],
    effects: &Effects,
    is_wanted: impl Fn(&Structure<'_>, &Location) -> bool,
) -> Vec<Candidate> {
    let one_base = tested.len() == 1 && tested[0].name.is_none();
    let mut out = Vec::new();
    for effect in effects.iter() {
        let mut places: IndexMap<Location, Vec<usize>> = IndexMap::new();
        for (k, structure) in structures.iter().enumerate() {
            for at in effect.locations(structure).into_iter().filter(|at| is_wanted(structure, at)) {
                places.entry(at).or_default().push(k);
            }
        }
        let belongs = if one_base { Belongs::Structure } else { effect.belongs_to() };
        for (at, listed) in places {
            let own = |k: &usize| at.names.iter().all(|name| structures[*k].context().is_own_mass(name));
            if !at.names.is_empty() && listed.iter().all(own) {
                for k in listed {
                    let there = tested[k].name.map_or_else(|| at.clone(), |name| at.clone().within(name));
                    out.extend(Candidate::new(effect, &structures[k], &there).ok());
                }
                continue;
            }
            // A place that an effect lists and then refuses is a mistake of that effect; the contract finds it.
            if belongs == Belongs::Structure || listed.len() > 1 {
                out.extend(Candidate::new(effect, &structures[listed[0]], &at).ok());
            }
            if belongs == Belongs::Rig || (belongs == Belongs::Support && listed.len() == 1) {
                for k in listed {
                    let alone = at.clone().within(tested[k].name.unwrap_or(BASE));
                    out.extend(Candidate::new(effect, &structures[k], &alone).ok());
                }
            }
        }
    }
    out
}
