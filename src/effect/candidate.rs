//! Effects in their places on one model, ready to be tried.

use super::location::Location;
use super::patch::{NewParameter, Patch, PatchError};
use super::structure::{Context, Structure};
use super::{Effect, Effects};
use crate::model::{Model, ParametricModel, Registry};

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
}

impl Candidate {
    /// The effect at one of its locations.
    pub fn new(effect: &'static dyn Effect, structure: &Structure<'_>, at: &Location) -> Result<Self, PatchError> {
        let patch = effect.patch(structure, at)?;
        let parameters = patch.parameters().cloned().collect();
        Ok(Self { effect, location: at.clone(), patch, parameters })
    }

    /// `mass-offset@left_wing.y`, as `add` takes it.
    pub fn id(&self) -> String {
        format!("{}@{}", self.effect.name(), self.location)
    }

    /// The model with the effect at its neutral value.
    pub fn build(&self, model: &Model, registry: &Registry) -> Result<Patched, PatchError> {
        let spec = self.patch.apply(model.spec())?;
        let (patched, _) = Model::new(spec, registry).map_err(PatchError::Refused)?;
        Ok(Patched {
            first_new: model.parameters().len(),
            neutral: self.parameters.iter().map(|p| p.neutral).collect(),
            typical: self.parameters.iter().map(|p| p.typical).collect(),
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
    let structure = Structure::new(model, context);
    effects
        .iter()
        .flat_map(|effect| {
            let structure = &structure;
            let locations = effect.locations(structure);
            // A place that an effect lists and then refuses is a mistake of that effect; the contract finds it.
            locations.into_iter().filter_map(move |at| Candidate::new(effect, structure, &at).ok())
        })
        .collect()
}
