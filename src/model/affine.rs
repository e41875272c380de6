//! Affine expressions of parameters.

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
        self.at_values(|i| theta[i])
    }

    /// Its value, asking for no parameter but its own.
    pub fn at_values(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.terms.iter().fold(self.constant, |sum, (i, f)| sum + f * value(*i))
    }

    /// Its derivative by a parameter.
    pub fn slope(&self, parameter: usize) -> f64 {
        self.terms.iter().filter(|t| t.0 == parameter).map(|t| t.1).sum()
    }

    /// Smallest and largest value while every parameter moves within `range`.
    pub fn range(&self, range: &dyn Fn(usize) -> [f64; 2]) -> [f64; 2] {
        self.terms.iter().fold([self.constant; 2], |[low, high], &(i, f)| {
            let [a, b] = range(i).map(|v| f * v);
            [low + a.min(b), high + a.max(b)]
        })
    }
}

impl Affine {
    /// A number that no parameter moves.
    pub(super) fn constant(value: f64) -> Self {
        Self { constant: value, terms: Vec::new() }
    }

    /// Its sum with a multiple of another.
    pub(super) fn plus(&self, factor: f64, other: &Self) -> Self {
        let mut out = self.clone();
        out.constant += factor * other.constant;
        for &(p, f) in &other.terms {
            match out.terms.iter_mut().find(|t| t.0 == p) {
                Some(term) => term.1 += factor * f,
                None => out.terms.push((p, factor * f)),
            }
        }
        out.terms.retain(|t| t.1 != 0.0);
        out
    }

    /// With other parameters, or with their values in their places.
    ///
    /// * `of` - the new index of a parameter, or its value
    pub(super) fn with_parameters(&self, of: &dyn Fn(usize) -> Result<usize, f64>) -> Self {
        let mut out = Self::constant(self.constant);
        for &(p, factor) in &self.terms {
            match of(p) {
                Ok(q) => out.terms.push((q, factor)),
                Err(value) => out.constant += factor * value,
            }
        }
        out
    }
}
