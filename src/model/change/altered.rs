//! An element of the model that a change alters: what differs, so that a change of ten thousand elements is little more than their numbers.

use super::scaled::{self, Factors};
use crate::linalg::SymMatrix;
use crate::model::ElementMatrices;
use crate::model::dependence::{element_matrices, weighed_mass};
use crate::model::placed_element::PlacedElement;
use crate::model::value::Value;
use crate::model::{ModelError, dependence::Terms};
use std::sync::Arc;

/// What an element becomes.
#[derive(Debug, Clone)]
pub(super) struct Altered {
    /// Property values that differ, by index; as the factors, shared by elements that follow each other.
    values: Arc<Vec<(usize, Option<Value>)>>,
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
        let stands = scaled::stands_as(&after, before);
        let both = after.values.iter().zip(before.values.iter()).enumerate();
        let values =
            both.filter(|(_, (new, old))| new != old).map(|(i, (new, _))| (i, new.clone())).collect::<Vec<_>>();
        let scaled = (stands && values.is_empty()).then(|| scaled::change_of_factors(&after, before));
        let last_scaled = last.and_then(|last| last.scaled.as_ref());
        Self {
            values: shared(values, last.map(|last| &last.values)),
            factors: shared(factors_of(&after), last.map(|last| &last.factors)),
            scaled: scaled.map(|own| shared(own, last_scaled)),
            moved: (!stands).then(|| Box::new(after)),
        }
    }

    /// The element as it is with the change.
    pub(super) fn element(&self, before: &PlacedElement) -> PlacedElement {
        if let Some(moved) = &self.moved {
            return (**moved).clone();
        }
        let [stiffness_factor, mass_factor, stiffness_damping, mass_damping] = (*self.factors).clone();
        let mut values = before.values.clone();
        if !self.values.is_empty() {
            let own = Arc::make_mut(&mut values);
            self.values.iter().for_each(|(i, value)| own[*i].clone_from(value));
        }
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

    /// What it adds to the mass that a balance sees, in its axes.
    ///
    /// * `all` - the parameters of the model, `theta`, then the sizes
    pub(super) fn weighed(&self, before: &PlacedElement, all: &[f64], theta: &[f64]) -> Result<SymMatrix, ModelError> {
        let mut added = weighed_mass(&self.element(before), all)?;
        added.add_scaled(-1.0, &weighed_mass(before, theta)?);
        Ok(added)
    }

    /// Whether any of what it becomes depends on parameter `j`.
    pub(super) fn depends_on(&self, j: usize) -> bool {
        if let Some(moved) = &self.moved {
            return moved.depends_on(j);
        }
        let values = self.values.iter().filter_map(|(_, value)| value.as_ref()).chain(self.factors.iter().flatten());
        values.flat_map(Value::parameters).any(|p| p == j)
    }
}

/// What is equal to another is that.
fn shared<T: PartialEq>(own: T, last: Option<&Arc<T>>) -> Arc<T> {
    last.filter(|last| ***last == own).cloned().unwrap_or_else(|| Arc::new(own))
}

fn factors_of(element: &PlacedElement) -> [Option<Value>; 4] {
    [&element.stiffness_factor, &element.mass_factor, &element.stiffness_damping, &element.mass_damping]
        .map(Clone::clone)
}
