//! Scenes with effects in them.
//!
//! An effect is written into the file of a small model. Of a large one, which a stand-in is solved for, all effects are placed at once
//! ([`Additions`]), and each is a handful of element matrices on top of the stand-in; what is found is written into the file, and the model
//! reduced anew, before anything is looked for beside it ([`Scene::in_full`]).

use super::scene::{Case, Scene, configuration, in_configuration};
use crate::error::DiagnosisError;
use rayon::prelude::*;
use retune::correlation::CorrelationError;
use retune::effect::{Candidate, NewParameter, PatchError};
use retune::linalg::DVector;
use retune::model::spec::ModelSpec;
use retune::model::{Additions, Change, Model, ModelError};
use retune::objective::Scaling;
use std::sync::Arc;

/// Changes that are placed at once: a file may have some 10⁵ elements, and each may bring some.
const AT_ONCE: usize = 20_000;

/// Elastic modes that are kept for every measured one, and on top of them, where the parameters stay: what a change needs beside them is its static
/// shapes.
const OF_A_MODE: usize = 3;
const AT_LEAST: usize = 4;

/// The scene with an effect in it.
pub(crate) fn with_effect(scene: &Scene, candidate: &Candidate) -> Result<Scene, DiagnosisError> {
    let added = [scene.added.clone(), candidate.parameters.clone()].concat();
    if scene.is_large() {
        return scene.with_change(candidate, added);
    }
    scene.with_file(candidate.patch.apply(&scene.file)?, added)
}

impl Scene {
    /// Places the changes of many candidates at once, those that are not known yet.
    pub(crate) fn place(&self, candidates: &[Candidate]) {
        for (k, case) in self.cases.iter().enumerate() {
            let of = self.configuration(case).map(str::to_string);
            if self.cases[..k].iter().any(|c| self.configuration(c) == of.as_deref()) {
                continue;
            }
            let new: Vec<&Candidate> = candidates.iter().filter(|c| !self.changes.has(&(of.clone(), c.id()))).collect();
            let found: Vec<(String, Option<Arc<Change>>)> =
                new.chunks(AT_ONCE).flat_map(|chunk| self.placed_in(case, chunk)).collect();
            self.changes.extend(found.into_iter().map(|(id, change)| ((of.clone(), id), change)));
        }
    }

    fn placed_in(&self, case: &Case, candidates: &[&Candidate]) -> Vec<(String, Option<Arc<Change>>)> {
        let none = |c: &&Candidate| (c.id(), None);
        let mut file = (*self.file).clone();
        // What cannot be added changes nothing, and is found to be missing below.
        for candidate in candidates {
            let _ = candidate.patch.add_to(&mut file);
        }
        let longer = match configuration(&file, &case.test) {
            Some(name) => match file.configured(name) {
                Ok(longer) => longer,
                Err(_) => return candidates.iter().map(none).collect(),
            },
            None => file,
        };
        let additions = Additions::new(&case.model, &longer, case.model.registry());
        let change = |candidate: &&Candidate| (candidate.id(), candidate.change(&additions).map(Arc::new));
        candidates.par_iter().map(change).collect()
    }

    /// The change of a candidate in a case; `None` where it is not made of elements.
    pub(crate) fn change(&self, case: &Case, candidate: &Candidate) -> Option<Arc<Change>> {
        let key = (self.configuration(case).map(str::to_string), candidate.id());
        if !self.changes.has(&key) {
            self.place(std::slice::from_ref(candidate));
        }
        self.changes.get(&key)
    }

    /// The same at one point of the parameters, for a look at changes of many sizes there: what stands in for a model keeps its lowest modes at this point
    /// alone. On a mesh of more dofs than matrices are dense for, where another factor takes seconds, stand-ins stay as they are.
    ///
    /// * `theta` - the parameters of the model, in the order of what is solved
    pub(crate) fn at_one_point(&self, theta: &[f64]) -> Self {
        if self.is_huge() {
            return self.clone();
        }
        let at_one_point = |case: &Case| {
            // Answers to loads need more than the lowest modes.
            if case.test.has_answers() {
                return None;
            }
            let kept = OF_A_MODE * case.test.modes.len() + AT_LEAST;
            let made = case.stand_in.as_ref()?.at_one_point(theta, kept).ok()??;
            Some(case.with_stand_in(made))
        };
        let cases = self.cases.iter().map(|c| at_one_point(c).unwrap_or_else(|| c.clone())).collect();
        Self { cases, ..self.clone() }
    }

    /// With a change of the stand-ins.
    ///
    /// * `added` - all sizes that effects have brought, those of this one last
    fn with_change(&self, candidate: &Candidate, added: Vec<NewParameter>) -> Result<Self, DiagnosisError> {
        let refused = || DiagnosisError::from(PatchError::NotOnLarge { id: candidate.id() });
        let (sizes, typical) = (candidate.sizes(), candidate.typical());
        let changed = |case: &Case| {
            let change = self.change(case, candidate).ok_or_else(refused)?;
            let stand_in = case.stand_in.as_ref().ok_or_else(refused)?;
            let failed = |e: ModelError| CorrelationError::Model(e.to_string());
            Ok(case.with_stand_in(stand_in.with(&change, &sizes, &typical).map_err(failed)?))
        };
        let cases = self.cases.iter().map(changed).collect::<Result<Vec<_>, DiagnosisError>>()?;
        let mut scene = Self { cases, added, ..self.clone() };
        scene.patches.push(candidate.patch.clone());
        Ok(scene)
    }

    /// The same with all changes written into the file.
    ///
    /// * `near` - where a fit has brought the parameters: a stand-in is made for all values of those of the file, with sizes near these
    ///
    /// # Errors
    /// The file is not a model then.
    pub(crate) fn in_full(self, near: Option<&DVector<f64>>) -> Result<Self, DiagnosisError> {
        if self.patches.is_empty() {
            return Ok(self);
        }
        let theta = near.map(|x| Scaling::new(self.solved()).theta(x));
        let value = |new: &NewParameter| {
            let index = self.solved().parameters().index_of(&new.name)?;
            Some((new.name.clone(), theta.as_ref()?[index]))
        };
        let sizes: Vec<(String, f64)> = self.added.iter().filter_map(value).collect();
        self.with_file_near(self.file_in_full()?, self.added.clone(), &sizes)
    }

    /// The same with the models themselves instead of what stands in for them; `None` where they are too large.
    ///
    /// # Errors
    /// As [`Self::in_full`].
    pub(crate) fn by_itself(&self) -> Result<Option<Self>, DiagnosisError> {
        if !self.is_large() {
            return Ok(Some(self.clone()));
        }
        if self.is_huge() {
            return Ok(None);
        }
        let alone = Self { large: usize::MAX, ..self.clone() };
        alone.with_file(self.file_in_full()?, self.added.clone()).map(Some)
    }

    /// The model of the first test with all changes.
    ///
    /// # Errors
    /// As [`Self::in_full`].
    pub(crate) fn model_in_full(&self) -> Result<Model, DiagnosisError> {
        if self.patches.is_empty() {
            return Ok(self.model().clone());
        }
        in_configuration(&self.file_in_full()?, &self.cases[0].test, &self.cases[0].model)
    }

    fn file_in_full(&self) -> Result<ModelSpec, DiagnosisError> {
        let mut file = (*self.file).clone();
        self.patches.iter().try_for_each(|patch| patch.add_to(&mut file))?;
        Ok(file)
    }
}
