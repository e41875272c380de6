//! Property values as functions of θ: products of affine expressions, and what is added to them.

/// constant + Σ factor θ\[index\].
#[derive(Debug, Clone, PartialEq)]
pub struct Affine {
    /// The constant part, SI.
    pub constant: f64,
    /// Index in θ and factor.
    pub terms: Vec<(usize, f64)>,
}

impl Affine {
    /// Its value at θ.
    pub fn at(&self, theta: &[f64]) -> f64 {
        self.terms.iter().fold(self.constant, |sum, (i, f)| sum + f * theta[*i])
    }

    /// Smallest and largest value while every parameter moves within `range`.
    pub fn range(&self, range: &dyn Fn(usize) -> [f64; 2]) -> [f64; 2] {
        self.terms.iter().fold([self.constant; 2], |[low, high], &(i, f)| {
            let [a, b] = range(i).map(|v| f * v);
            [low + a.min(b), high + a.max(b)]
        })
    }
}

/// A product of affine expressions and a sum of more: a property with its factors, and what is added to it.
///
/// ```text
/// v(θ) = Π factors(θ) + Σ addends(θ)
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Value {
    /// The factors; their product is one where there are none.
    pub factors: Vec<Affine>,
    /// What is added to the product.
    pub addends: Vec<Affine>,
}

impl Value {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self::of(Affine { constant: value, terms: Vec::new() })
    }

    /// One affine expression.
    pub fn of(affine: Affine) -> Self {
        Self { factors: vec![affine], addends: Vec::new() }
    }

    /// Its value at θ.
    pub fn at(&self, theta: &[f64]) -> f64 {
        let product: f64 = self.factors.iter().map(|a| a.at(theta)).product();
        self.addends.iter().fold(product, |sum, a| sum + a.at(theta))
    }

    /// Indices in θ that it depends on.
    pub fn parameters(&self) -> impl Iterator<Item = usize> + '_ {
        self.factors.iter().chain(&self.addends).flat_map(|a| a.terms.iter().map(|t| t.0))
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
