//! Polynomials of the parameters, by powers of θ - b.

use super::dependence::Monomial;
use super::value::{Affine, Value};
use std::collections::BTreeMap;

/// Σ a_k Π (θ_j - b_j)^p.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polynomial {
    terms: BTreeMap<Monomial, f64>,
}

impl Polynomial {
    pub(super) fn constant(value: f64) -> Self {
        Self { terms: BTreeMap::from([(Monomial::default(), value)]) }
    }

    fn affine(affine: &Affine, origin: &[f64]) -> Self {
        let mut out = Self::constant(affine.at(origin));
        for &(j, factor) in &affine.terms {
            *out.terms.entry(Monomial { powers: vec![(j, 1)] }).or_default() += factor;
        }
        out
    }

    /// A property as a polynomial; of none it is the constant 1.
    ///
    /// * `origin` - b, as long as θ
    pub(super) fn of(value: Option<&Value>, origin: &[f64]) -> Self {
        let Some(value) = value else { return Self::constant(1.0) };
        let factors = value.factors.iter().map(|f| Self::affine(f, origin));
        // The product of none is one, as in `Value::at`.
        let product = factors.fold(Self::constant(1.0), |p, f| p.times(&f));
        value.addends.iter().fold(product, |sum, a| sum.plus(&Self::affine(a, origin)))
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
                let mut powers: BTreeMap<usize, i32> = a.powers.iter().copied().collect();
                for &(j, p) in &b.powers {
                    *powers.entry(j).or_default() += p;
                }
                *terms.entry(Monomial { powers: powers.into_iter().collect() }).or_default() += x * y;
            }
        }
        Self { terms }
    }

    /// The constant and the slope by each parameter of c + Σ s_j θ_j, if it is no more than that.
    pub(super) fn slopes(&self, origin: &[f64]) -> Option<(f64, Vec<(usize, f64)>)> {
        let mut constant = 0.0;
        let mut slopes = Vec::new();
        for (monomial, &factor) in &self.terms {
            match monomial.powers.as_slice() {
                [] => constant += factor,
                _ if factor == 0.0 => {}
                &[(j, 1)] => {
                    constant -= factor * origin[j];
                    slopes.push((j, factor));
                }
                _ => return None,
            }
        }
        Some((constant, slopes))
    }

    /// Its terms that are not zero.
    pub(super) fn terms(&self) -> impl Iterator<Item = (&Monomial, f64)> {
        self.terms.iter().map(|(m, f)| (m, *f)).filter(|t| t.1 != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ((θ0/2)³ - 1) at and beside the origin.
    #[test]
    fn a_property_is_the_sum_of_its_powers() {
        let of = |factor: f64| Affine { constant: 0.0, terms: vec![(0, factor)] };
        let value = Value {
            factors: vec![of(0.5), of(0.5), of(0.5), Affine { constant: 1.0, terms: vec![(1, 0.1)] }],
            addends: vec![Affine { constant: -1.0, terms: Vec::new() }],
            ..Value::default()
        };
        let origin = [3.0, 0.5];
        let polynomial = Polynomial::of(Some(&value), &origin);
        for theta in [[3.0, 0.5], [2.2, 0.9], [-1.0, 4.0]] {
            let sum: f64 = polynomial.terms().map(|(m, f)| f * m.at(&theta, &origin)).sum();
            assert!((sum - value.at(&theta)).abs() < 1e-13 * value.at(&theta).abs().max(1.0), "{theta:?}");
        }
        assert_eq!(polynomial.slopes(&origin), None);
        let (constant, slopes) = Polynomial::of(Some(&Value::of(of(0.5))), &origin).slopes(&origin).unwrap();
        assert_eq!((constant, slopes), (0.0, vec![(0, 0.5)]));
    }
}
