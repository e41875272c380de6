//! Polynomials of the parameters.

use super::dependence::Monomial;
use super::value::{Affine, Value};
use std::collections::BTreeMap;

/// Σ a_k Π θ_j^p.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polynomial {
    terms: BTreeMap<Monomial, f64>,
}

impl Polynomial {
    pub(super) fn constant(value: f64) -> Self {
        Self { terms: BTreeMap::from([(Monomial::default(), value)]) }
    }

    fn affine(affine: &Affine) -> Self {
        let mut out = Self::constant(affine.constant);
        for &(j, factor) in &affine.terms {
            *out.terms.entry(Monomial::parameter(j)).or_default() += factor;
        }
        out
    }

    /// A property as a polynomial; of none it is the constant 1.
    pub(super) fn of(value: Option<&Value>) -> Self {
        let Some(value) = value else { return Self::constant(1.0) };
        let factors = value.factors.iter().map(Self::affine);
        // The product of none is one, as in `Value::at`.
        let product = factors.fold(Self::constant(1.0), |p, f| p.times(&f));
        value.addends.iter().fold(product, |sum, a| sum.plus(&Self::affine(a)))
    }

    pub(super) fn plus(mut self, other: &Self) -> Self {
        for (monomial, factor) in &other.terms {
            *self.terms.entry(monomial.clone()).or_default() += factor;
        }
        self
    }

    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.terms.values_mut().for_each(|a| *a *= factor);
        self
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut terms: BTreeMap<Monomial, f64> = BTreeMap::new();
        for (a, x) in &self.terms {
            for (b, y) in &other.terms {
                *terms.entry(a.times(b)).or_default() += x * y;
            }
        }
        Self { terms }
    }

    /// Its terms that are not zero.
    pub(super) fn terms(&self) -> impl Iterator<Item = (&Monomial, f64)> {
        self.terms.iter().map(|(m, f)| (m, *f)).filter(|t| t.1 != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ((θ0/2)³ (1 + θ1/10) - 1).
    #[test]
    fn a_property_is_the_sum_of_its_powers() {
        let of = |factor: f64| Affine { constant: 0.0, terms: vec![(0, factor)] };
        let value = Value {
            factors: vec![of(0.5), of(0.5), of(0.5), Affine { constant: 1.0, terms: vec![(1, 0.1)] }],
            addends: vec![Affine { constant: -1.0, terms: Vec::new() }],
            ..Value::default()
        };
        let polynomial = Polynomial::of(Some(&value));
        for theta in [[3.0, 0.5], [2.2, 0.9], [-1.0, 4.0]] {
            let sum: f64 = polynomial.terms().map(|(m, f)| f * m.at(&theta)).sum();
            assert!((sum - value.at(&theta)).abs() < 1e-13 * value.at(&theta).abs().max(1.0), "{theta:?}");
        }
        let half = Polynomial::of(Some(&Value::of(of(0.5))));
        assert_eq!(half.terms().collect::<Vec<_>>(), [(&Monomial::parameter(0), 0.5)]);
    }
}
