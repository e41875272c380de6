//! What is kept of an element until the model is assembled: the terms of its matrices on the dofs that it acts on.
//!
//! A solid has no rotations and mostly no damping, and each parameter is in one of its matrices: of 48 x 48 numbers in each matrix of each term
//! a small part is kept, which for a mesh of 10^5 elements makes the difference between megabytes and gigabytes.

use super::dependence::{Monomial, Terms, dependences, element_matrices, interior_point, step};
use super::parameter::ParameterSet;
use super::placed_element::PlacedElement;
use super::{ElementMatrices, Model, ModelError, ParametricModel};
use crate::linalg::SymMatrix;
use std::collections::HashMap;
use std::sync::Arc;

/// Elements up to which a model keeps their terms, for models that differ from it in a few.
const KEPT: usize = 2000;

/// A term of an element's matrices; what is zero is left out.
#[derive(Debug)]
pub(super) struct Term {
    /// What it is multiplied with.
    pub(super) monomial: Monomial,
    /// K, M and C, on the dofs that the element acts on.
    pub(super) matrices: [Option<SymMatrix>; 3],
    /// Whether a balance sees another mass than M.
    has_own_weight: bool,
    /// That mass, where it is not zero.
    weighed: Option<SymMatrix>,
}

/// An element's matrices on the dofs that it acts on.
#[derive(Debug)]
pub(super) struct Acting {
    /// Dofs of the element in which any of its matrices has an entry, ascending.
    pub(super) dofs: Vec<u16>,
    /// `None` where the matrices are not polynomials of the parameters.
    pub(super) terms: Option<Vec<Term>>,
}

impl Acting {
    /// Of each element.
    ///
    /// * `beside` - a model that has some of the elements: theirs are not looked for again
    pub(super) fn of_all(
        elements: &[PlacedElement],
        parameters: &ParameterSet,
        beside: Option<&Model>,
    ) -> Result<Vec<Arc<Self>>, ModelError> {
        let known = beside.filter(|model| begins_with(parameters, model.parameters())).map(Known::of);
        let mut found: Vec<Option<Arc<Self>>> =
            elements.iter().map(|e| known.as_ref().and_then(|known| known.get(e))).collect();
        let open: Vec<usize> = (0..elements.len()).filter(|&e| found[e].is_none()).collect();
        let new = dependences(elements, &open, parameters, |e, terms| match terms {
            Some(terms) => Self::new(terms),
            None => Self::general(&elements[e], parameters),
        })?;
        open.into_iter().zip(new).for_each(|(e, acting)| found[e] = Some(Arc::new(acting)));
        Ok(found.into_iter().flatten().collect())
    }

    /// What a model keeps of its elements: of very many nothing.
    pub(super) fn kept(all: Vec<Arc<Self>>) -> Arc<[Arc<Self>]> {
        if all.len() > KEPT { Arc::default() } else { all.into() }
    }

    /// No polynomial: what it acts on is looked at beside the base too.
    fn general(element: &PlacedElement, parameters: &ParameterSet) -> Self {
        let base = interior_point(parameters);
        let mut beside = base.clone();
        for (i, value) in beside.iter_mut().enumerate() {
            *value += 0.618 * step(parameters, i, *value);
        }
        let at = [&base, &beside].into_iter().filter_map(|theta| element_matrices(element, theta).ok());
        Self { dofs: acted_on(&at.collect::<Vec<_>>()), terms: None }
    }

    fn new(terms: Terms) -> Self {
        let (monomials, matrices): (Vec<_>, Vec<_>) = terms.into_iter().unzip();
        let dofs = acted_on(&matrices);
        let on_dofs = |a: &SymMatrix| (!a.is_zero()).then(|| part(a, &dofs));
        let term = |(monomial, m): (Monomial, &ElementMatrices)| Term {
            monomial,
            matrices: [&m.stiffness, &m.mass, &m.damping].map(on_dofs),
            has_own_weight: m.weighed_mass.is_some(),
            weighed: m.weighed_mass.as_ref().and_then(on_dofs),
        };
        let terms = monomials.into_iter().zip(&matrices).map(term);
        Self { terms: Some(terms.filter(|t| !t.is_zero()).collect()), dofs }
    }
}

/// The terms of a model's elements by the names of these.
struct Known<'m> {
    model: &'m Model,
    places: HashMap<&'m str, usize>,
}

impl<'m> Known<'m> {
    fn of(model: &'m Model) -> Self {
        let kept = &model.elements()[..model.acting().len()];
        Self { model, places: kept.iter().enumerate().map(|(i, e)| (e.name.as_str(), i)).collect() }
    }

    /// Those of an element that the model has too.
    fn get(&self, element: &PlacedElement) -> Option<Arc<Acting>> {
        let &place = self.places.get(element.name.as_str())?;
        element.is_made_as(&self.model.elements()[place]).then(|| self.model.acting()[place].clone())
    }
}

/// Whether some parameters are the first of others.
fn begins_with(all: &ParameterSet, first: &ParameterSet) -> bool {
    first.len() <= all.len() && first.iter().zip(all.iter()).all(|(a, b)| a == b)
}

impl Term {
    fn is_zero(&self) -> bool {
        self.weighed.is_none() && self.matrices.iter().all(Option::is_none)
    }

    /// The mass that a balance sees, on all dofs of the element.
    ///
    /// * `dofs` - those that the element acts on
    /// * `n` - how many it has
    pub(super) fn weighed(&self, dofs: &[u16], n: usize) -> Option<SymMatrix> {
        let own = if self.has_own_weight { &self.weighed } else { &self.matrices[1] }.as_ref()?;
        let mut all = SymMatrix::zeros(n);
        for (i, &to) in dofs.iter().enumerate() {
            for (j, &other) in dofs[..=i].iter().enumerate() {
                all.add(to.into(), other.into(), own.get(i, j));
            }
        }
        Some(all)
    }
}

fn acted_on(all: &[ElementMatrices]) -> Vec<u16> {
    let Some(first) = all.first() else { return Vec::new() };
    let mut acts = vec![false; first.stiffness.n()];
    for a in all.iter().flat_map(|m| [&m.stiffness, &m.mass, &m.damping]) {
        let rows = (0..a.n()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), _) in rows.zip(a.lower()).filter(|(_, v)| **v != 0.0) {
            acts[i] = true;
            acts[j] = true;
        }
    }
    (0..).zip(acts).filter(|(_, acts)| *acts).map(|(dof, _)| dof).collect()
}

fn part(a: &SymMatrix, dofs: &[u16]) -> SymMatrix {
    let rows = dofs.iter().enumerate().flat_map(|(i, &row)| dofs[..=i].iter().map(move |&column| (row, column)));
    let lower: Vec<f64> = rows.map(|(row, column)| a.get(row.into(), column.into())).collect();
    SymMatrix::from_lower(dofs.len(), &lower)
}
