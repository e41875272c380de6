//! Members whose elements turn their axes over.

use super::{Part, Structure};
use crate::model::dot;

impl Structure<'_> {
    /// Sign of an element's axis against that of the first of its chain: a chain may bend, and turn its axes over.
    fn along_first(&self, part: &Part, element: usize, axis: usize) -> f64 {
        let axes = |e: usize| self.model.elements()[e].axes[axis];
        if dot(axes(part.elements[0]), axes(element)) < 0.0 { -1.0 } else { 1.0 }
    }

    /// The member as one name, or its elements in two lists where their axes turn over, each with its sign.
    pub(in crate::effect) fn runs(&self, part: &Part, axis: usize, sign: f64) -> Vec<(Vec<String>, f64)> {
        let signs: Vec<f64> = part.elements.iter().map(|&e| self.along_first(part, e, axis)).collect();
        if signs.iter().all(|s| *s > 0.0) {
            return vec![(part.of.clone(), sign)];
        }
        let named = |wanted: f64| {
            let chosen = part.elements.iter().zip(&signs).filter(|(_, s)| **s == wanted);
            chosen.map(|(&e, _)| self.model.elements()[e].name.clone()).collect::<Vec<_>>()
        };
        vec![(named(1.0), sign), (named(-1.0), -sign)]
    }
}
