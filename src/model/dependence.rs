//! An element's matrices at θ, and how they depend on the parameters, found by evaluation.
//!
//! A file's properties are products and sums of parameters, and element matrices are mostly polynomials of the properties: EI
//! of two parameters is bilinear, a mass off its axis quadratic in the offset, a plate's bending cubic in the thickness. A user's own
//! element needs to declare nothing: its matrices are sampled on a grid inside the bounds, interpolated, and checked beside
//! the grid.

use super::parameter::ParameterSet;
use super::placed_element::PlacedElement;
use super::value::Value;
use super::{ElementMatrices, ModelError};
use crate::element::{ElementInput, StrainParts};
use crate::linalg::SymMatrix;
use std::collections::HashMap;

/// Most samples of a grid: three parameters to the second power, or two to the third with room.
const MOST_SAMPLES: usize = 27;
/// Highest power of one parameter.
const MOST_POWER: usize = 3;
/// Interpolation and evaluation agree to this part of the largest entry.
const AGREEMENT: f64 = 1e-11;
/// A sum that is no more than this part of the sum of its terms' moduli is rounding.
const ROUNDING: f64 = 1e-13;
/// Where the interpolation is checked, in steps; parameters take them in turn.
const CHECKS: [[f64; 3]; 2] = [[0.37, 0.71, 0.53], [0.83, 0.29, 0.61]];

/// The matrices of one element at θ, in its axes.
pub(super) fn element_matrices(element: &PlacedElement, theta: &[f64]) -> Result<ElementMatrices, ModelError> {
    let values = element.values_at(theta);
    let input = ElementInput { points: &element.points, values: &values };
    let wrap = |source| ModelError::Element { element: element.name.clone(), path: element.path.clone(), source };
    let scaled = |mut a: SymMatrix, factor: &Option<Value>| {
        if let Some(f) = factor {
            a.scale(f.at(theta));
        }
        a
    };
    let stiffness = scaled(element.kind.stiffness(&input).map_err(wrap)?, &element.stiffness_factor);
    let mass = scaled(element.kind.mass(&input).map_err(wrap)?, &element.mass_factor);
    let weighed_mass = element.kind.weighed_mass(&input).map_err(wrap)?.map(|m| scaled(m, &element.mass_factor));
    let mut damping = element.kind.damping(&input).map_err(wrap)?;
    for (factor, matrix) in [(&element.stiffness_damping, &stiffness), (&element.mass_damping, &mass)] {
        if let Some(factor) = factor.as_ref().map(|f| f.at(theta)) {
            damping = damping.combine(matrix, |c, a| c + factor * a);
        }
    }
    Ok(ElementMatrices { stiffness, mass, weighed_mass, damping })
}

/// The stiffness of one element at θ by kinds of strain, in its axes; `None` where the element does not know them.
pub(super) fn strain_parts(element: &PlacedElement, theta: &[f64]) -> Result<Option<StrainParts>, ModelError> {
    let values = element.values_at(theta);
    let input = ElementInput { points: &element.points, values: &values };
    let wrap = |source| ModelError::Element { element: element.name.clone(), path: element.path.clone(), source };
    let parts = element.kind.strain_parts(&input).map_err(wrap)?;
    Ok(parts.map(|mut parts| {
        if let Some(f) = &element.stiffness_factor {
            for part in [&mut parts.axial, &mut parts.bending, &mut parts.torsion] {
                part.scale(f.at(theta));
            }
        }
        parts
    }))
}

/// The mass of one element at θ as scales see it, in its axes: [`ElementMatrices::weighed`] without the other matrices.
pub(super) fn weighed_mass(element: &PlacedElement, theta: &[f64]) -> Result<SymMatrix, ModelError> {
    let values = element.values_at(theta);
    let input = ElementInput { points: &element.points, values: &values };
    let mass = element.kind.weighed_mass(&input).and_then(|m| m.map_or_else(|| element.kind.mass(&input), Ok));
    let wrap = |source| ModelError::Element { element: element.name.clone(), path: element.path.clone(), source };
    let mut mass = mass.map_err(wrap)?;
    if let Some(f) = &element.mass_factor {
        mass.scale(f.at(theta));
    }
    Ok(mass)
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

/// A product of powers of parameters, each from its origin: Π (θ_j - b_j)^p.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub struct Monomial {
    /// Index in θ and power p ≥ 1, by index; none for the constant 1.
    pub powers: Vec<(usize, i32)>,
}

impl Monomial {
    /// Its value at θ.
    ///
    /// * `origin` - b, as long as θ
    pub fn at(&self, theta: &[f64], origin: &[f64]) -> f64 {
        self.powers.iter().map(|&(j, p)| (theta[j] - origin[j]).powi(p)).product()
    }

    /// Its derivative ∂/∂θ_j at θ.
    pub fn derivative(&self, theta: &[f64], origin: &[f64], j: usize) -> f64 {
        let Some(&(_, power)) = self.powers.iter().find(|p| p.0 == j) else { return 0.0 };
        let others = self.powers.iter().filter(|p| p.0 != j);
        let others: f64 = others.map(|&(i, p)| (theta[i] - origin[i]).powi(p)).product();
        f64::from(power) * (theta[j] - origin[j]).powi(power - 1) * others
    }
}

/// An element's matrices as functions of θ.
pub(super) enum Dependence {
    /// Constant part, and one part per parameter: A0 + Σ θ_j A_j.
    Affine(ElementMatrices, Vec<(usize, ElementMatrices)>),
    /// The matrices at the origin, and Σ c_k(θ) A_k.
    Polynomial(ElementMatrices, Vec<(Monomial, ElementMatrices)>),
    /// Anything else.
    General,
}

/// Finds out how an element's matrices depend on θ.
///
/// First as an affine function: from the [`interior_point`] b and each parameter moved alone. Else as a sum over groups of
/// parameters that act together, found by mixed differences of pairs; a group of n is a polynomial of degree 1, 2 or 3 in
/// each, through a grid of (degree + 1)ⁿ points:
///
/// ```text
/// A(θ) = A(b) + Σ_groups (Σ_k L_k(θ) A(θ_k) - A(b)),    L_k: products of Lagrange's polynomials, sorted by powers of θ - b
/// ```
///
/// The whole is checked with all parameters moved together, to 1e-11 of the largest entry. At b it is exactly A(b).
pub(super) fn dependence(element: &PlacedElement, parameters: &ParameterSet) -> Result<Dependence, ModelError> {
    let base = interior_point(parameters);
    let mut used: Vec<usize> = element.expressions().flat_map(Value::parameters).collect();
    used.sort_unstable();
    used.dedup();
    let at_base = element_matrices(element, &base)?;
    if used.is_empty() {
        return Ok(Dependence::Affine(at_base, Vec::new()));
    }
    let steps = used.iter().map(|&p| step(parameters, p, base[p])).collect();
    let places = HashMap::from([(Vec::new(), 0)]);
    let mut samples = Samples { element, base, steps, known: vec![at_base], places, used };
    let found = affine(&mut samples).or_else(|| polynomial(&mut samples));
    Ok(found.unwrap_or(Dependence::General))
}

/// An element at points of its parameters, evaluated once each.
struct Samples<'a> {
    element: &'a PlacedElement,
    base: Vec<f64>,
    /// The parameters it depends on, and how far each is moved.
    used: Vec<usize>,
    steps: Vec<f64>,
    /// The matrices at the points looked at; the first at the base.
    known: Vec<ElementMatrices>,
    /// Fractions of the steps other than zero, by place in `used`, and where in `known` the matrices are.
    places: HashMap<Vec<(usize, u64)>, usize>,
}

impl Samples<'_> {
    /// The place in `known` of the matrices at some fractions of the steps; `None` where the element has none.
    fn at(&mut self, fractions: &[f64]) -> Option<usize> {
        let moved = fractions.iter().enumerate().filter(|(_, f)| **f != 0.0);
        let key: Vec<(usize, u64)> = moved.map(|(k, f)| (k, f.to_bits())).collect();
        if let Some(place) = self.places.get(&key) {
            return Some(*place);
        }
        let mut theta = self.base.clone();
        for ((&p, step), fraction) in self.used.iter().zip(&self.steps).zip(fractions) {
            theta[p] += fraction * step;
        }
        let matrices = element_matrices(self.element, &theta).ok()?;
        self.known.push(matrices);
        self.places.insert(key, self.known.len() - 1);
        Some(self.known.len() - 1)
    }

    /// The same with all but the parameters of a group at the base.
    fn at_group(&mut self, group: &[usize], fractions: impl Iterator<Item = f64>) -> Option<usize> {
        let mut all = vec![0.0; self.used.len()];
        group.iter().zip(fractions).for_each(|(&k, fraction)| all[k] = fraction);
        self.at(&all)
    }

    /// Whether a prediction, given the fractions, agrees with the element at the points of the checks.
    fn agree(&mut self, predicted: impl Fn(&Self, &[f64]) -> ElementMatrices) -> Option<bool> {
        for check in CHECKS {
            let fractions: Vec<f64> = (0..self.used.len()).map(|k| check[k % 3]).collect();
            let place = self.at(&fractions)?;
            if !self.known[place].is_close(&predicted(self, &fractions), AGREEMENT) {
                return Some(false);
            }
        }
        Some(true)
    }
}

/// A0 + Σ θ_j A_j.
fn affine(samples: &mut Samples<'_>) -> Option<Dependence> {
    let n = samples.used.len();
    let mut slopes = Vec::with_capacity(n);
    for k in 0..n {
        let place = samples.at_group(&[k], std::iter::once(1.0))?;
        let (moved, at_base, step) = (&samples.known[place], &samples.known[0], samples.steps[k]);
        slopes.push(moved.combine(at_base, |a, b| clean(a - b, a.abs() + b.abs()) / step));
    }
    let predicted = |samples: &Samples<'_>, fractions: &[f64]| {
        let mut sum = samples.known[0].clone();
        for ((slope, step), fraction) in slopes.iter().zip(&samples.steps).zip(fractions) {
            sum = sum.combine(slope, |s, a| s + fraction * step * a);
        }
        sum
    };
    if !samples.agree(predicted)? {
        return None;
    }
    let mut constant = samples.known[0].clone();
    for (slope, &p) in slopes.iter().zip(&samples.used) {
        constant = constant.combine(slope, |c, s| clean(c - samples.base[p] * s, c.abs()));
    }
    Some(Dependence::Affine(constant, samples.used.iter().copied().zip(slopes).collect()))
}

/// Parameters that act together, and the grid through which their polynomial goes.
struct Group {
    /// Places in [`Samples::used`].
    of: Vec<usize>,
    degree: usize,
    /// Places in [`Samples::known`] of the points of the grid.
    places: Vec<usize>,
}

impl Group {
    /// The lowest degree that agrees at a point beside the grid.
    fn new(samples: &mut Samples<'_>, of: &[usize]) -> Option<Self> {
        let check: Vec<f64> = (0..of.len()).map(|k| CHECKS[0][k % 3]).collect();
        let beside = samples.at_group(of, check.iter().copied())?;
        for degree in 1..=MOST_POWER {
            let size = (degree + 1).checked_pow(of.len() as u32).filter(|size| *size <= MOST_SAMPLES)?;
            let group = Self { places: Vec::new(), degree, of: of.to_vec() };
            let grid = |k: usize| group.digits(k).map(|d| d as f64 / degree as f64).collect::<Vec<f64>>();
            let places = (0..size).map(|k| samples.at_group(of, grid(k).into_iter())).collect::<Option<_>>()?;
            let group = Self { places, ..group };
            let predicted = weighted(samples, &group.places, &group.weights(&check));
            if samples.known[beside].is_close(&predicted, AGREEMENT) {
                return Some(group);
            }
        }
        None
    }

    /// The digits of a number in base degree + 1: which node along each parameter, which power of each.
    fn digits(&self, k: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.of.len()).map(move |i| k / (self.degree + 1).pow(i as u32) % (self.degree + 1))
    }

    fn nodes(&self, step: f64) -> Vec<f64> {
        (0..=self.degree).map(|k| step * k as f64 / self.degree as f64).collect()
    }

    /// The products of Lagrange's polynomials of the grid, given fractions of the steps.
    fn weights(&self, fractions: &[f64]) -> Vec<f64> {
        let nodes = self.nodes(1.0);
        let along: Vec<Vec<f64>> = fractions.iter().map(|&t| lagrange(&nodes, t)).collect();
        (0..self.places.len()).map(|k| self.digits(k).enumerate().map(|(i, d)| along[i][d]).product()).collect()
    }

    /// The terms that are not constant.
    fn terms(&self, samples: &Samples<'_>) -> Vec<(Monomial, ElementMatrices)> {
        let powers: Vec<Vec<Vec<f64>>> = self.of.iter().map(|&k| by_powers(&self.nodes(samples.steps[k]))).collect();
        let term = |m: usize| {
            let weight = |k: usize| {
                let pairs = self.digits(m).zip(self.digits(k)).enumerate();
                pairs.map(|(i, (power, node))| powers[i][node][power]).product()
            };
            let weights: Vec<f64> = (0..self.places.len()).map(weight).collect();
            let powers = self.digits(m).zip(&self.of).filter(|(power, _)| *power > 0);
            let mut powers: Vec<(usize, i32)> = powers.map(|(power, &k)| (samples.used[k], power as i32)).collect();
            powers.sort_unstable();
            (Monomial { powers }, weighted(samples, &self.places, &weights))
        };
        (1..self.places.len()).map(term).filter(|(_, a)| !a.is_zero()).collect()
    }
}

/// A(b) + Σ c_k(θ) A_k.
fn polynomial(samples: &mut Samples<'_>) -> Option<Dependence> {
    let groups = groups(samples)?.into_iter().map(|of| Group::new(samples, &of)).collect::<Option<Vec<_>>>()?;
    let predicted = |samples: &Samples<'_>, fractions: &[f64]| {
        let at_base = &samples.known[0];
        let mut sum = at_base.clone();
        for group in &groups {
            let own: Vec<f64> = group.of.iter().map(|&k| fractions[k]).collect();
            let part = weighted(samples, &group.places, &group.weights(&own));
            sum = sum.combine(&part.combine(at_base, |a, b| a - b), |s, p| s + p);
        }
        sum
    };
    if !samples.agree(predicted)? {
        return None;
    }
    let terms = groups.iter().flat_map(|g| g.terms(samples)).collect();
    Some(Dependence::Polynomial(samples.known[0].clone(), terms))
}

/// Groups of parameters, as places in [`Samples::used`], between which no mixed difference is seen; `None` where one is larger than any grid.
fn groups(samples: &mut Samples<'_>) -> Option<Vec<Vec<usize>>> {
    let n = samples.used.len();
    let mut group: Vec<usize> = (0..n).collect();
    for i in 1..n {
        let all: Vec<usize> = (0..i).collect();
        let mut partners = Vec::new();
        partners_of(samples, i, &all, &mut partners)?;
        for j in partners {
            let (from, to) = (group[i], group[j]);
            group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
        }
        // Not even the lowest degree has a grid for it.
        let own = group[..=i].iter().filter(|g| **g == group[i]).count();
        2_usize.checked_pow(own as u32).filter(|size| *size <= MOST_SAMPLES)?;
    }
    let members = |g: usize| (0..n).filter(|&k| group[k] == g).collect::<Vec<_>>();
    Some((0..n).map(members).filter(|m| !m.is_empty()).collect())
}

/// Which of some parameters have a mixed difference with parameter i: all of them moved together tell whether any has, halves which.
fn partners_of(samples: &mut Samples<'_>, i: usize, of: &[usize], found: &mut Vec<usize>) -> Option<()> {
    if found.len() > MOST_SAMPLES {
        return None;
    }
    let moved = |samples: &mut Samples<'_>, of: &[usize]| samples.at_group(of, of.iter().map(|_| 1.0));
    let with: Vec<usize> = of.iter().copied().chain([i]).collect();
    let (both, first, second) = (moved(samples, &with)?, moved(samples, of)?, moved(samples, &[i])?);
    let apart = weighted(samples, &[first, second, 0], &[1.0, 1.0, -1.0]);
    if samples.known[both].is_close(&apart, AGREEMENT) {
        return Some(());
    }
    if of.len() == 1 {
        found.push(of[0]);
        return Some(());
    }
    let (left, right) = of.split_at(of.len() / 2);
    partners_of(samples, i, left, found)?;
    partners_of(samples, i, right, found)
}

/// Lagrange's polynomials of the nodes at t.
fn lagrange(nodes: &[f64], t: f64) -> Vec<f64> {
    let of = |k: usize| {
        let others = nodes.iter().enumerate().filter(|(j, _)| *j != k);
        others.map(|(_, node)| (t - node) / (nodes[k] - node)).product()
    };
    (0..nodes.len()).map(of).collect()
}

/// The coefficients of the powers of t in Lagrange's polynomial of each node.
fn by_powers(nodes: &[f64]) -> Vec<Vec<f64>> {
    let of = |k: usize| {
        let mut out = vec![1.0];
        for (_, node) in nodes.iter().enumerate().filter(|(j, _)| *j != k) {
            let width = nodes[k] - node;
            // out · (t - node) / width
            let mut next = vec![0.0; out.len() + 1];
            for (power, c) in out.iter().enumerate() {
                next[power] -= c * node / width;
                next[power + 1] += c / width;
            }
            out = next;
        }
        out
    };
    (0..nodes.len()).map(of).collect()
}

/// Σ w A over some of the samples; an entry that is rounding of its terms is zero.
fn weighted(samples: &Samples<'_>, places: &[usize], weights: &[f64]) -> ElementMatrices {
    let of = |matrix: fn(&ElementMatrices) -> &SymMatrix| {
        let n = matrix(&samples.known[0]).n();
        let (mut sum, mut size) = (vec![0.0; n * (n + 1) / 2], vec![0.0; n * (n + 1) / 2]);
        for (&place, w) in places.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
            for ((s, z), a) in sum.iter_mut().zip(&mut size).zip(matrix(&samples.known[place]).lower()) {
                *s += w * a;
                *z += (w * a).abs();
            }
        }
        sum.iter_mut().zip(&size).for_each(|(s, z)| *s = clean(*s, *z));
        SymMatrix::from_lower(n, &sum)
    };
    let has_weighed = places.iter().all(|&p| samples.known[p].weighed_mass.is_some());
    ElementMatrices {
        stiffness: of(|m| &m.stiffness),
        mass: of(|m| &m.mass),
        weighed_mass: has_weighed.then(|| of(ElementMatrices::weighed)),
        damping: of(|m| &m.damping),
    }
}

/// A difference that is rounding noise of its terms is zero.
fn clean(difference: f64, size: f64) -> f64 {
    if difference.abs() <= ROUNDING * size { 0.0 } else { difference }
}

/// The estimates, moved into their bounds.
pub(super) fn interior_point(parameters: &ParameterSet) -> Vec<f64> {
    parameters.iter().map(|p| p.bounds.map_or(p.value, |[l, u]| p.value.max(l).min(u))).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Every power is found as it went in.
    #[test]
    fn a_cubic_comes_back_by_powers() {
        for nodes in [[0.0_f64, 1.0, 2.0, 3.0], [0.0, 5e-4, 1e-3, 1.5e-3], [0.0, -2e6, -4e6, -6e6]] {
            let size = nodes[3].abs();
            let exact = [0.7, -1.3 / size, 0.0, 2.1 / size.powi(3)];
            let value = |t: f64| exact.iter().rev().fold(0.0, |sum, c| sum * t + c);
            let found = by_powers(&nodes);
            for (power, c) in exact.iter().enumerate() {
                let sum: f64 = nodes.iter().enumerate().map(|(k, &t)| value(t) * found[k][power]).sum();
                assert!((sum - c).abs() * size.powi(power as i32) < 1e-13, "{power}: {sum} {c}");
            }
            let sum: f64 = lagrange(&nodes, 0.9 * size).iter().zip(nodes).map(|(w, t)| w * value(t)).sum();
            assert!((sum - value(0.9 * size)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_monomial_and_its_derivative() {
        let m = Monomial { powers: vec![(0, 1), (2, 3)] };
        let (theta, origin) = ([3.0, 9.0, -0.5], [1.0, 0.0, 1.0]);
        assert_eq!(m.at(&theta, &origin), 2.0 * -3.375);
        assert_eq!(m.derivative(&theta, &origin, 0), -3.375);
        assert_eq!(m.derivative(&theta, &origin, 1), 0.0);
        assert_eq!(m.derivative(&theta, &origin, 2), 2.0 * 3.0 * 2.25);
        assert_eq!(Monomial::default().at(&theta, &origin), 1.0);
    }
}
