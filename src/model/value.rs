//! Property values as functions of θ: products of affine expressions.

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

/// A product of affine expressions: a property with its factors.
#[derive(Debug, Clone, PartialEq)]
pub struct Value(pub Vec<Affine>);

impl Value {
    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self(vec![Affine { constant: value, terms: Vec::new() }])
    }

    /// Its value at θ.
    pub fn at(&self, theta: &[f64]) -> f64 {
        self.0.iter().map(|a| a.at(theta)).product()
    }

    /// Indices in θ that it depends on.
    pub fn parameters(&self) -> impl Iterator<Item = usize> + '_ {
        self.0.iter().flat_map(|a| a.terms.iter().map(|t| t.0))
    }
}
