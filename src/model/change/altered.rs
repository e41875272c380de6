//! An element of the model that a change alters: what differs, so that a change of ten thousand elements is little more than their numbers.

use super::scaled::{self, Factors};
use crate::model::ElementMatrices;
use crate::model::dependence::element_matrices;
use crate::model::placed_element::PlacedElement;
use crate::model::value::Value;
use crate::model::{ModelError, dependence::Terms};
use std::sync::Arc;

/// What an element becomes.
#[derive(Debug, Clone)]
pub(super) struct Altered {
    /// As the elements of a section share theirs.
    values: Arc<Vec<Option<Value>>>,
    /// On its stiffness and its mass, and of its damping per stiffness and per mass.
    factors: Arc<[Option<Value>; 4]>,
    /// By which factors its matrices change, where that is all.
    scaled: Option<Arc<Factors>>,
    /// The element itself, where it gets other axes or other ends.
    moved: Option<Box<PlacedElement>>,
}

impl Altered {
    /// * `last` - of another element of the change, which it may be like
    pub(super) fn new(after: PlacedElement, before: &PlacedElement, last: Option<&Self>) -> Self {
        let factors = factors_of(&after);
        let values = match last {
            Some(last) if last.values == after.values => last.values.clone(),
            _ => after.values.clone(),
        };
        let factors = match last {
            Some(last) if *last.factors == factors => last.factors.clone(),
            _ => Arc::new(factors),
        };
        let stands = scaled::stands_as(&after, before);
        let scaled = (stands && after.values == before.values).then(|| scaled::change_of_factors(&after, before));
        let scaled = scaled.map(|own| match last.and_then(|last| last.scaled.as_ref()) {
            Some(last) if **last == own => last.clone(),
            _ => Arc::new(own),
        });
        Self { values, factors, scaled, moved: (!stands).then(|| Box::new(after)) }
    }

    /// The element as it is with the change.
    pub(super) fn element(&self, before: &PlacedElement) -> PlacedElement {
        if let Some(moved) = &self.moved {
            return (**moved).clone();
        }
        let [stiffness_factor, mass_factor, stiffness_damping, mass_damping] = (*self.factors).clone();
        let values = self.values.clone();
        PlacedElement { values, stiffness_factor, mass_factor, stiffness_damping, mass_damping, ..before.clone() }
    }

    /// Elements of whose terms those of the change are made, see [`Self::terms`].
    pub(super) fn asked(&self, before: &PlacedElement) -> Vec<PlacedElement> {
        match &self.scaled {
            Some(_) => vec![scaled::bare(before)],
            None => vec![self.element(before), before.clone()],
        }
    }

    /// The terms of the change; `None` where it is not a polynomial.
    ///
    /// * `next` - those of [`Self::asked`], one after the other
    pub(super) fn terms(&self, mut next: impl FnMut() -> Option<Terms>) -> Option<Terms> {
        if let Some(factors) = &self.scaled {
            return next().map(|t| scaled::times(factors, &t.iter().map(|(m, a)| (m, a)).collect::<Vec<_>>()));
        }
        let (after, before) = (next(), next());
        let (mut terms, before) = (after?, before?);
        terms.extend(before.into_iter().map(|(m, a)| (m, a.combine(&a, |a, _| -a))));
        Some(terms)
    }

    /// What it adds to K, M and C in its axes.
    ///
    /// * `all` - the parameters of the model, `theta`, then the sizes
    pub(super) fn matrices(
        &self,
        before: &PlacedElement,
        all: &[f64],
        theta: &[f64],
    ) -> Result<ElementMatrices, ModelError> {
        if let Some(factors) = &self.scaled {
            return Ok(scaled::at(factors, all, &element_matrices(&scaled::bare(before), all)?));
        }
        let after = element_matrices(&self.element(before), all)?;
        Ok(after.combine(&element_matrices(before, theta)?, |a, b| a - b))
    }

    /// Whether any of what it becomes depends on parameter `j`.
    pub(super) fn depends_on(&self, j: usize) -> bool {
        let values = self.values.iter().flatten().chain(self.factors.iter().flatten());
        values.flat_map(Value::parameters).any(|p| p == j)
    }
}

fn factors_of(element: &PlacedElement) -> [Option<Value>; 4] {
    [&element.stiffness_factor, &element.mass_factor, &element.stiffness_damping, &element.mass_damping]
        .map(Clone::clone)
}
