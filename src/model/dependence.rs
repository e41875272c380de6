//! An element's matrices at θ, and how they depend on the parameters, found by evaluation.
//!
//! A file's properties are products and sums of parameters, and element matrices are mostly polynomials of the properties: EI
//! of two parameters is bilinear, a mass off its axis quadratic in the offset, a plate's bending cubic in the thickness. A user's own
//! element needs to declare nothing: its matrices are sampled, interpolated, and checked beside the samples.

mod pattern;
mod powers;
mod samples;
#[cfg(test)]
mod tests;

pub(super) use self::pattern::dependences;

use self::samples::{ALL_CHECKS, Samples};
use super::parameter::ParameterSet;
use super::placed_element::PlacedElement;
use super::rounding::clean;
use super::value::Value;
use super::{ElementMatrices, ModelError};
use crate::element::{ElementError, ElementInput, StrainParts};
use crate::linalg::SymMatrix;
use std::collections::BTreeMap;

/// The matrices of one element at θ, in its axes and at its ends as they are at the estimates.
pub(super) fn element_matrices(element: &PlacedElement, theta: &[f64]) -> Result<ElementMatrices, ModelError> {
    let values = element.values_at(theta);
    let stand = element.stand(theta).map_err(|e| failed(element, e))?;
    let input = ElementInput { points: &stand.points, values: &values };
    let made = |matrix: Result<SymMatrix, ElementError>, factor: Option<&Value>| {
        let matrix = stand.brought_back(matrix.map_err(|e| failed(element, e))?);
        Ok::<_, ModelError>(scaled(matrix, factor, theta))
    };
    let stiffness = made(element.kind.stiffness(&input), element.stiffness_factor.as_ref())?;
    let mass = made(element.kind.mass(&input), element.mass_factor.as_ref())?;
    let weighed_mass = element.kind.weighed_mass(&input).transpose();
    let weighed_mass = weighed_mass.map(|m| made(m, element.mass_factor.as_ref())).transpose()?;
    let mut damping = made(element.kind.damping(&input), None)?;
    for (factor, matrix) in [(&element.stiffness_damping, &stiffness), (&element.mass_damping, &mass)] {
        if let Some(factor) = factor.as_ref().map(|f| f.at(theta)) {
            damping = damping.combine(matrix, |c, a| c + factor * a);
        }
    }
    Ok(ElementMatrices { stiffness, mass, weighed_mass, damping })
}

fn failed(element: &PlacedElement, source: ElementError) -> ModelError {
    ModelError::Element { element: element.name.clone(), path: element.path.clone(), source }
}

fn scaled(mut a: SymMatrix, factor: Option<&Value>, theta: &[f64]) -> SymMatrix {
    if let Some(f) = factor {
        a.scale(f.at(theta));
    }
    a
}

/// The stiffness of one element at θ by kinds of strain, as [`element_matrices`] has it; `None` where the element does not know them.
pub(super) fn strain_parts(element: &PlacedElement, theta: &[f64]) -> Result<Option<StrainParts>, ModelError> {
    let values = element.values_at(theta);
    let stand = element.stand(theta).map_err(|e| failed(element, e))?;
    let input = ElementInput { points: &stand.points, values: &values };
    let parts = element.kind.strain_parts(&input).map_err(|e| failed(element, e))?;
    let made = |a: SymMatrix| scaled(stand.brought_back(a), element.stiffness_factor.as_ref(), theta);
    Ok(parts.map(|p| StrainParts { axial: made(p.axial), bending: made(p.bending), torsion: made(p.torsion) }))
}

/// The mass of one element at θ as scales see it: [`ElementMatrices::weighed`] without the other matrices.
pub(super) fn weighed_mass(element: &PlacedElement, theta: &[f64]) -> Result<SymMatrix, ModelError> {
    let values = element.values_at(theta);
    let stand = element.stand(theta).map_err(|e| failed(element, e))?;
    let input = ElementInput { points: &stand.points, values: &values };
    let mass = element.kind.weighed_mass(&input).and_then(|m| m.map_or_else(|| element.kind.mass(&input), Ok));
    let mass = stand.brought_back(mass.map_err(|e| failed(element, e))?);
    Ok(scaled(mass, element.mass_factor.as_ref(), theta))
}

/// The derivative of something by its values a step above and below; at the edge of an element's domain the difference is one-sided.
///
/// * `at` - its value at a multiple of the step
/// * `divided` - (first - second)/width
pub(super) fn central_difference<T>(
    at: impl Fn(f64) -> Result<T, ModelError>,
    step: f64,
    divided: impl Fn(T, T, f64) -> T,
) -> Result<T, ModelError> {
    match (at(1.0), at(-1.0)) {
        (Ok(a), Ok(b)) => Ok(divided(a, b, 2.0 * step)),
        (Ok(a), Err(_)) => Ok(divided(a, at(0.0)?, step)),
        (Err(_), Ok(b)) => Ok(divided(at(0.0)?, b, step)),
        (Err(e), Err(_)) => Err(e),
    }
}

/// A product of powers of parameters: Π θ_j^p.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Monomial {
    /// Index in θ and power p ≥ 1, by index; none for the constant 1.
    pub powers: Vec<(usize, i32)>,
}

impl Monomial {
    /// θ_j itself.
    pub(super) fn parameter(j: usize) -> Self {
        Self { powers: vec![(j, 1)] }
    }

    /// Its product with another.
    pub(super) fn times(&self, other: &Self) -> Self {
        let mut powers: BTreeMap<usize, i32> = self.powers.iter().copied().collect();
        for &(j, p) in &other.powers {
            *powers.entry(j).or_default() += p;
        }
        Self { powers: powers.into_iter().collect() }
    }

    /// Its value at θ.
    pub fn at(&self, theta: &[f64]) -> f64 {
        self.powers.iter().map(|&(j, p)| theta[j].powi(p)).product()
    }

    /// Its derivative ∂/∂θ_j at θ.
    pub fn derivative(&self, theta: &[f64], j: usize) -> f64 {
        let Some(&(_, power)) = self.powers.iter().find(|p| p.0 == j) else { return 0.0 };
        let others = self.powers.iter().filter(|p| p.0 != j);
        let others: f64 = others.map(|&(i, p)| theta[i].powi(p)).product();
        f64::from(power) * theta[j].powi(power - 1) * others
    }
}

/// An element's matrices as a polynomial of θ: Σ_k c_k(θ) A_k.
pub(super) type Terms = Vec<(Monomial, ElementMatrices)>;

/// How an element's matrices depend on θ, found from nothing; `None` where they are no polynomial.
///
/// First as an affine function: from the [`interior_point`] b and each parameter moved alone. Else by [`powers::polynomial`].
///
/// # Errors
/// The element has no matrices at b.
pub(super) fn dependence(element: &PlacedElement, parameters: &ParameterSet) -> Result<Option<Terms>, ModelError> {
    Ok(search(&mut Samples::new(element, parameters)?))
}

fn search(samples: &mut Samples<'_>) -> Option<Terms> {
    // Where its ends move, its matrices may be polynomials and its mass about the origin is none.
    if samples.element.moving.is_some() {
        return None;
    }
    affine(samples).or_else(|| powers::polynomial(samples))
}

/// A0 + Σ θ_j A_j.
fn affine(samples: &mut Samples<'_>) -> Option<Terms> {
    let mut slopes = Vec::with_capacity(samples.used.len());
    for k in 0..samples.used.len() {
        let place = samples.at_moved(&[(k, samples.base[k] + samples.steps[k])])?;
        let (moved, at_base, step) = (&samples.known[place], &samples.known[0], samples.steps[k]);
        slopes.push(moved.combine(at_base, |a, b| clean(a - b, a.abs() + b.abs()) / step));
    }
    let mut constant = samples.known[0].clone();
    for (slope, b) in slopes.iter().zip(&samples.base) {
        constant = constant.combine(slope, |c, s| clean(c - b * s, c.abs()));
    }
    let slopes = samples.used.iter().map(|&j| Monomial::parameter(j)).zip(slopes);
    let terms: Terms = std::iter::once((Monomial::default(), constant)).chain(slopes).collect();
    samples.agree(&terms, ALL_CHECKS)?.then_some(terms)
}

/// The estimates, moved into their bounds.
pub(super) fn interior_point(parameters: &ParameterSet) -> Vec<f64> {
    parameters.iter().map(|p| p.bounds.map_or(p.value, |[l, u]| p.value.max(l).min(u))).collect()
}

/// Gives parameters, by name, the values at which they are held.
pub(super) fn hold(parameters: &ParameterSet, held: &[(String, f64)], theta: &mut [f64]) {
    for (name, value) in held {
        if let Some(j) = parameters.index_of(name) {
            theta[j] = *value;
        }
    }
}

/// How far a parameter is moved from a value: to its farther bound, else by half its value, else by one.
pub(super) fn step(parameters: &ParameterSet, index: usize, value: f64) -> f64 {
    match parameters.get(index).bounds {
        Some([lower, upper]) if upper - value >= value - lower => upper - value,
        Some([lower, _]) => lower - value,
        None if value != 0.0 => 0.5 * value,
        None => 1.0,
    }
}
