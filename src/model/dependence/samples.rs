//! An element at points of its parameters, evaluated once each.

use super::{Terms, element_matrices, interior_point, step};
use crate::linalg::SymMatrix;
use crate::model::parameter::ParameterSet;
use crate::model::placed_element::PlacedElement;
use crate::model::value::Value;
use crate::model::{ElementMatrices, ModelError};
use std::collections::HashMap;

/// A sum of terms and the element agree to this part of the entries on the diagonal.
pub(super) const AGREEMENT: f64 = 1e-11;
/// Where a sum of terms is checked, in steps; parameters take them in turn.
const CHECKS: [[f64; 3]; 2] = [[0.37, 0.71, 0.53], [0.83, 0.29, 0.61]];

/// See [`Samples::agree`].
pub(super) const ALL_CHECKS: usize = CHECKS.len();

/// An element at points of its parameters, evaluated once each.
pub(super) struct Samples<'a> {
    pub(super) element: &'a PlacedElement,
    theta: Vec<f64>,
    /// The parameters it depends on, their values at the base, and how far each may be moved within its bounds.
    pub(super) used: Vec<usize>,
    pub(super) base: Vec<f64>,
    pub(super) steps: Vec<f64>,
    /// The matrices at the points looked at; the first at the base.
    pub(super) known: Vec<ElementMatrices>,
    /// Values of the parameters that it depends on, as bits, and where in `known` the matrices are.
    places: HashMap<Vec<u64>, usize>,
}

impl<'a> Samples<'a> {
    pub(super) fn new(element: &'a PlacedElement, parameters: &ParameterSet) -> Result<Self, ModelError> {
        let theta = interior_point(parameters);
        let mut used: Vec<usize> = element.expressions().flat_map(Value::parameters).collect();
        used.sort_unstable();
        used.dedup();
        let known = vec![element_matrices(element, &theta)?];
        let base: Vec<f64> = used.iter().map(|&p| theta[p]).collect();
        let steps = used.iter().map(|&p| step(parameters, p, theta[p])).collect();
        let places = HashMap::from([(bits(&base), 0)]);
        Ok(Self { element, theta, used, base, steps, known, places })
    }

    /// The place in `known` of the matrices at some values of the parameters used; `None` where the element has none.
    pub(super) fn at(&mut self, values: &[f64]) -> Option<usize> {
        let key = bits(values);
        if let Some(place) = self.places.get(&key) {
            return Some(*place);
        }
        let matrices = element_matrices(self.element, &self.point(values)).ok()?;
        self.known.push(matrices);
        self.places.insert(key, self.known.len() - 1);
        Some(self.known.len() - 1)
    }

    /// Values of the parameters used at all points looked at, in the order of `known`.
    pub(super) fn points(&self) -> Vec<Vec<f64>> {
        let mut all: Vec<_> = self.places.iter().collect();
        all.sort_unstable_by_key(|(_, place)| **place);
        all.into_iter().map(|(key, _)| key.iter().map(|bits| f64::from_bits(*bits)).collect()).collect()
    }

    /// θ with these values of the parameters used.
    pub(super) fn point(&self, values: &[f64]) -> Vec<f64> {
        let mut theta = self.theta.clone();
        self.used.iter().zip(values).for_each(|(&p, value)| theta[p] = *value);
        theta
    }

    /// The same with all but a few parameters at the base.
    ///
    /// * `moved` - places in `used`, and values
    pub(super) fn at_moved(&mut self, moved: &[(usize, f64)]) -> Option<usize> {
        let mut values = self.base.clone();
        for &(k, value) in moved {
            values[k] = value;
        }
        self.at(&values)
    }

    /// Values of the parameters used at a point at which none of them is zero.
    pub(super) fn beside_zero(&self) -> Vec<f64> {
        let pairs = self.base.iter().zip(&self.steps);
        pairs.map(|(&base, &step)| if base == 0.0 { 0.5 * step } else { base }).collect()
    }

    /// Whether a sum of terms is the element's matrices where they are checked, within the bounds.
    ///
    /// * `checks` - at how many points: one where the terms are those of another element, else [`ALL_CHECKS`]
    pub(super) fn agree(&mut self, terms: &Terms, checks: usize) -> Option<bool> {
        for check in &CHECKS[..checks] {
            let moved = self.base.iter().zip(&self.steps).enumerate();
            let values: Vec<f64> = moved.map(|(k, (b, step))| b + check[k % 3] * step).collect();
            let place = self.at(&values)?;
            if !is_close(&self.known[place], &sum(terms, &self.point(&values), &self.known[0]), AGREEMENT) {
                return Some(false);
            }
        }
        Some(true)
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// Σ c_k(θ) A_k, with the shape of another.
fn sum(terms: &Terms, theta: &[f64], like: &ElementMatrices) -> ElementMatrices {
    let mut out = ElementMatrices::zeros(like.stiffness.n());
    out.weighed_mass = like.weighed_mass.as_ref().map(|m| SymMatrix::zeros(m.n()));
    for (monomial, matrices) in terms {
        let factor = monomial.at(theta);
        out.stiffness.add_scaled(factor, &matrices.stiffness);
        out.mass.add_scaled(factor, &matrices.mass);
        out.damping.add_scaled(factor, &matrices.damping);
        if let (Some(into), Some(own)) = (&mut out.weighed_mass, &matrices.weighed_mass) {
            into.add_scaled(factor, own);
        }
    }
    out
}

/// For each dof, the largest entry of its row: what entries are compared with, √(s_i s_j), knows no units.
pub(super) fn sizes(a: &SymMatrix, into: &mut Vec<f64>) {
    into.resize(a.n(), 0.0);
    let rows = (0..a.n()).flat_map(|i| (0..=i).map(move |j| (i, j)));
    for ((i, j), value) in rows.zip(a.lower()) {
        into[i] = into[i].max(value.abs());
        into[j] = into[j].max(value.abs());
    }
}

/// Whether every entry agrees within `tolerance` times the size of its dofs.
pub(super) fn is_close(a: &ElementMatrices, b: &ElementMatrices, tolerance: f64) -> bool {
    let close = |a: &SymMatrix, b: &SymMatrix| {
        let mut size = Vec::new();
        sizes(a, &mut size);
        sizes(b, &mut size);
        let rows = (0..a.n()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        rows.zip(a.lower().iter().zip(b.lower()))
            .all(|((i, j), (x, y))| (x - y).abs() <= tolerance * (size[i] * size[j]).sqrt())
    };
    close(&a.stiffness, &b.stiffness)
        && close(&a.mass, &b.mass)
        && close(&a.damping, &b.damping)
        && match (&a.weighed_mass, &b.weighed_mass) {
            (Some(a), Some(b)) => close(a, b),
            _ => true,
        }
}
