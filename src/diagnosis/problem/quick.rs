//! Fits that go most of their way on few coordinates.
//!
//! A model that the batched kernel does not take, because of its size, is reduced once for all values of its parameters, and an effect is a handful
//! of element matrices on top of that ([`StandIn`]). A race runs there, and the best of its runners goes on with the model itself: what is reported
//! of a fit never comes from the reduced one.

use super::scene::{Case, Scene};
use crate::diagnosis::thresholds::STAND_IN_ERROR;
use crate::effect::Candidate;
use crate::model::{ParametricModel, ReducedOptions, StandIn};
use std::sync::Arc;

/// Models of more dofs are reduced: those of fewer go through the kernel as they are.
const FROM: usize = 150;

impl Scene {
    /// With reduced models beside those that are worth it; a test of more than modes, and damping, need the model itself.
    pub(crate) fn with_reduced(mut self) -> Self {
        let of_modes = !self.is_damped && !self.cases.iter().any(|c| c.test.has_more_than_modes());
        let is_worth = |c: &Case| c.model.dof_map().n_dof() > FROM;
        if !of_modes || self.has_reduced() || self.is_large() || !self.cases.iter().any(is_worth) {
            return self;
        }
        let n_modes = 2 * self.cases.iter().map(|c| c.test.modes.len()).max().unwrap_or(0) + 4;
        let mut made: Vec<Arc<StandIn>> = Vec::new();
        for k in 0..self.cases.len() {
            let model = &self.cases[k].model;
            let known = made.iter().find(|s| Arc::ptr_eq(s.model(), model)).cloned();
            let options = ReducedOptions { n_modes, tolerance: STAND_IN_ERROR, ..ReducedOptions::default() };
            let Some(own) = known.or_else(|| StandIn::reduced(model, options, None, &[]).ok().map(Arc::new)) else {
                return self;
            };
            made.push(own);
        }
        self.origin = Some(Arc::new(self.clone()));
        self.cases.iter_mut().zip(made).for_each(|(case, own)| case.reduced = Some(own));
        self
    }

    /// Whether fits go most of their way on few coordinates.
    fn has_reduced(&self) -> bool {
        self.cases.iter().all(|c| c.reduced.is_some())
    }

    /// Places the changes of effects that will be fitted, where reduced models take them.
    pub(crate) fn place_on_reduced<'a>(&self, candidates: impl Iterator<Item = &'a Candidate>) {
        if let Some(origin) = self.origin.as_ref().filter(|_| self.has_reduced()) {
            origin.place(&candidates.cloned().collect::<Vec<_>>());
        }
    }

    /// With the reduced models of the scene that an effect was added to, and the effect on them; none where it is no change of elements.
    pub(super) fn reduced_as(mut self, before: &Self, candidate: &Candidate) -> Self {
        let Some(origin) = before.origin.as_ref().filter(|_| before.has_reduced()) else { return self };
        let (sizes, typical) = (candidate.sizes(), candidate.typical());
        let of = |(case, on): (&Case, &Case)| {
            let change = origin.change(on, candidate)?;
            case.reduced.as_ref()?.with(&change, &sizes, &typical).ok().map(Arc::new)
        };
        let own = before.cases.iter().zip(&origin.cases).map(of).collect::<Option<Vec<_>>>();
        if let Some(own) = own {
            self.cases.iter_mut().zip(own).for_each(|(case, own)| case.reduced = Some(own));
        }
        self
    }

    /// The same on few coordinates.
    pub(super) fn quick(&self) -> Option<Self> {
        let case = |case: &Case| Some(case.with_stand_in((**case.reduced.as_ref()?).clone()));
        let cases = self.cases.iter().map(case).collect::<Option<Vec<_>>>()?;
        Some(Self { cases, ..self.clone() })
    }
}
