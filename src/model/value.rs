//! Property values as functions of θ: products of affine expressions, and what is added to them.

pub use super::affine::Affine;
use super::lay_up::Rigidity;

/// A product of affine expressions and a sum of more: a property with its factors, and what is added to it.
///
/// ```text
/// v(θ) = rigidity(θ) Π factors(θ) + Σ addends(θ)
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Value {
    /// The factors; their product is one where there are none.
    pub factors: Vec<Affine>,
    /// What is added to the product.
    pub addends: Vec<Affine>,
    /// A rigidity or a mass of plies that parameters move, as one factor more.
    pub rigidity: Option<Rigidity>,
}

impl Value {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self::of(Affine::constant(value))
    }

    /// One affine expression.
    pub fn of(affine: Affine) -> Self {
        Self { factors: vec![affine], ..Self::default() }
    }

    /// Its value at θ.
    pub fn at(&self, theta: &[f64]) -> f64 {
        let product: f64 = self.factors.iter().map(|a| a.at(theta)).product();
        let product = self.rigidity.as_ref().map_or(product, |r| product * r.at(theta));
        self.addends.iter().fold(product, |sum, a| sum + a.at(theta))
    }

    /// Indices in θ that it depends on.
    pub fn parameters(&self) -> impl Iterator<Item = usize> + '_ {
        let own = self.factors.iter().chain(&self.addends).flat_map(|a| a.terms.iter().map(|t| t.0));
        own.chain(self.rigidity.iter().flat_map(Rigidity::parameters))
    }
}

/// Four significant digits of a number with its unit.
pub(super) fn quantity(value: f64, unit: &str) -> String {
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{value:.3e} {unit}");
    }
    let decimals = if size > 0.0 { (3.0 - size.log10().floor()).max(0.0) as usize } else { 0 };
    format!("{value:.decimals$} {unit}")
}
