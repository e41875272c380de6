//! From the unit box of the optimisers to θ.

use crate::linalg::DVector;
use crate::model::ParametricModel;

/// Bounds farther apart than this, both above zero, leave the order of magnitude open.
const DECADES: f64 = 1000.0;

/// θ = base, with the free parameters between their bounds: at lower + x (upper - lower), or evenly in the logarithm.
///
/// ```text
/// θ = lower + x (upper - lower)            Scaling::new
/// θ = lower (upper/lower)^x                Scaling::for_search, where 0 < lower and upper >= 1000 lower
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Scaling {
    base: Vec<f64>,
    free: Vec<usize>,
    lower: Vec<f64>,
    width: Vec<f64>,
    /// ln(upper/lower) of the parameters that are taken in the logarithm.
    decades: Vec<Option<f64>>,
}

impl Scaling {
    /// The bounded parameters of a model are free, the others stay at their estimates.
    pub fn new(model: &dyn ParametricModel) -> Self {
        let parameters = model.parameters();
        let free = parameters.free();
        let bounds: Vec<[f64; 2]> = free.iter().filter_map(|&i| parameters.get(i).bounds).collect();
        Self {
            base: parameters.nominal(),
            decades: vec![None; free.len()],
            free,
            lower: bounds.iter().map(|b| b[0]).collect(),
            width: bounds.iter().map(|b| b[1] - b[0]).collect(),
        }
    }

    /// The same for a search: a parameter whose bounds leave its order of magnitude open is searched in the logarithm, for a
    /// step that suits one decade is too long or too short for the others.
    pub fn for_search(model: &dyn ParametricModel) -> Self {
        let mut scaling = Self::new(model);
        for (k, decades) in scaling.decades.iter_mut().enumerate() {
            let (lower, upper) = (scaling.lower[k], scaling.lower[k] + scaling.width[k]);
            *decades = (lower > 0.0 && upper / lower >= DECADES).then(|| (upper / lower).ln());
        }
        scaling
    }

    /// Number of free parameters.
    pub fn len(&self) -> usize {
        self.free.len()
    }

    /// Whether no parameter is free.
    pub fn is_empty(&self) -> bool {
        self.free.is_empty()
    }

    /// Indices in θ of the free parameters.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// Upper minus lower bound of each free parameter.
    pub fn width(&self) -> &[f64] {
        &self.width
    }

    /// ln(upper/lower) of each free parameter that is taken in the logarithm.
    pub fn decades(&self) -> &[Option<f64>] {
        &self.decades
    }

    /// dθ/dx of each free parameter at θ: the width of its interval, θ ln(upper/lower) in the logarithm.
    pub fn slopes(&self, theta: &[f64]) -> Vec<f64> {
        (0..self.len()).map(|k| self.decades[k].map_or(self.width[k], |d| d * theta[self.free[k]])).collect()
    }

    /// θ at x.
    pub fn theta(&self, x: &DVector<f64>) -> Vec<f64> {
        let mut theta = self.base.clone();
        self.overwrite(x, &mut theta);
        theta
    }

    /// The value of the free parameter `k` at x_k, also outside the unit box.
    pub fn value(&self, k: usize, x: f64) -> f64 {
        match self.decades[k] {
            // The bound itself where rounding would pass it.
            Some(_) if x == 1.0 => self.lower[k] + self.width[k],
            Some(decades) => self.lower[k] * (x * decades).exp(),
            None => self.lower[k] + x * self.width[k],
        }
    }

    /// θ at x, into a θ of this scaling.
    pub(super) fn overwrite(&self, x: &DVector<f64>, theta: &mut [f64]) {
        for (k, &i) in self.free.iter().enumerate() {
            theta[i] = self.value(k, x[k]);
        }
    }

    /// θ with the free parameters in the middle of their bounds.
    pub(super) fn centre(&self) -> Vec<f64> {
        self.theta(&DVector::from_element(self.len(), 0.5))
    }

    /// The constants, and any value of the free parameters.
    pub(super) fn base(&self) -> &[f64] {
        &self.base
    }

    /// x of a θ; outside the unit box where a value is outside its bounds.
    pub fn x(&self, theta: &[f64]) -> DVector<f64> {
        DVector::from_fn(self.free.len(), |k, _| {
            let value = theta[self.free[k]];
            match self.decades[k] {
                Some(decades) => (value.max(f64::MIN_POSITIVE) / self.lower[k]).ln() / decades,
                None => (value - self.lower[k]) / self.width[k],
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Registry, load};

    #[test]
    fn bounds_over_decades_are_searched_in_the_logarithm() {
        let text = "
retune: 1
name: two springs
active_dofs: [uz]
parameters: {k: {value: 100 N/m, bounds: [1 N/m, 1e4 N/m]}, m: {value: 2 kg, bounds: [0 kg, 1e4 kg]}, s: {value: 3 N/m, bounds: [1 N/m, 999 N/m]}}
nodes: {a: [0, 0, 0], b: [1, 0, 0]}
springs: {g: {node: a, k: {uz: k}}, h: {node: b, k: {uz: s}}}
masses: {a: {node: a, mass: m}, b: {node: b, mass: 1 kg}}
";
        let model = load(text, &Registry::builtin()).unwrap().0;
        let (even, search) = (Scaling::new(&model), Scaling::for_search(&model));
        assert!(even.decades().iter().all(Option::is_none));
        assert_eq!(search.decades().iter().map(Option::is_some).collect::<Vec<_>>(), [true, false, false]);
        let theta = model.parameters().nominal();
        let x = search.x(&theta);
        assert!((x[0] - 0.5).abs() < 1e-15 && x[1] == even.x(&theta)[1]);
        assert!((search.theta(&x)[0] - 100.0).abs() < 1e-10);
        // The bounds are met exactly, and a step in x is a factor.
        assert_eq!([0.0, 1.0].map(|x| search.value(0, x)), [1.0, 1e4]);
        assert!((search.slopes(&theta)[0] - 100.0 * 1e4_f64.ln()).abs() < 1e-9);
        assert_eq!(search.slopes(&theta)[1..], even.width()[1..]);
    }
}
