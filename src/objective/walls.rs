//! Residuals that stand for one-sided constraints.

use std::ops::Range;

use crate::linalg::DVector;

/// Residuals r = ln(1 + eᵗ) that stand for constraints t(x) <= 0: a soft wall of width one in t.
///
/// A wall is steep and its t nearly linear, so a method with derivatives does better with t than with the slope of r: it
/// reads t back from r and keeps to the linearised constraint, instead of bouncing off a wall that it sees from near by only.
///
/// ```text
/// t = r + ln(1 - e⁻ʳ),   ∂t = ∂r/(1 - e⁻ʳ)
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Walls {
    rows: Vec<(usize, Option<f64>)>,
}

impl Walls {
    /// These rows among the residuals.
    ///
    /// * `slope` - where the cost holds slope · max(0, t) in place of ½ r²: that slope. Such a constraint is met exactly.
    pub fn new(rows: Range<usize>, slope: Option<f64>) -> Self {
        Self { rows: rows.map(|row| (row, slope)).collect() }
    }

    /// Row and slope of every wall, rows ascending.
    pub fn rows(&self) -> &[(usize, Option<f64>)] {
        &self.rows
    }

    /// The same walls where this many residuals stand before them.
    #[must_use]
    pub fn after(mut self, residuals: usize) -> Self {
        self.rows.iter_mut().for_each(|r| r.0 += residuals);
        self
    }

    /// Adds walls of later rows.
    pub fn extend(&mut self, later: Self) {
        self.rows.extend(later.rows);
    }

    /// ½ Σ r² of the other rows, and what the walls add to it; the cost itself, where an objective's cost is so made.
    pub fn cost(&self, residuals: &DVector<f64>) -> f64 {
        let exact = self.rows.iter().filter_map(|&(row, slope)| slope.map(|s| (residuals[row], s)));
        let squares = residuals.norm_squared() - exact.clone().map(|(r, _)| r * r).sum::<f64>();
        0.5 * squares + exact.map(|(r, slope)| slope * Self::excess(r).map_or(0.0, |t| t.max(0.0))).sum::<f64>()
    }

    /// t of a residual; `None` where it is too far inside to be told.
    pub(crate) fn excess(r: f64) -> Option<f64> {
        (r > 0.0).then(|| r + (-(-r).exp_m1()).ln())
    }

    /// ∂t/∂r.
    pub(crate) fn stretch(r: f64) -> f64 {
        -1.0 / (-r).exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn t_comes_back_from_its_residual() {
        for t in [-80.0, -3.0, 0.0, 0.5, 40.0, 900.0_f64] {
            let r = t.max(0.0) + (-t.abs()).exp().ln_1p();
            let back = Walls::excess(r).unwrap();
            assert!((back - t).abs() < 1e-12 * t.abs().max(1.0), "{t}: {back}");
            let slope = 1.0 / (1.0 + (-t).exp());
            assert!((Walls::stretch(r) * slope - 1.0).abs() < 1e-12);
        }
        assert_eq!(Walls::excess(0.0), None);
    }

    #[test]
    fn a_slope_counts_what_lies_beyond() {
        let r = DVector::from_vec(vec![2.0, 3.0 + (-3.0_f64).exp().ln_1p(), (-5.0_f64).exp().ln_1p(), 1.0]);
        let walls = Walls::new(1..3, Some(0.1));
        assert!((walls.cost(&r) - (2.0 + 0.5 + 0.3)).abs() < 1e-13);
        assert!((Walls::default().cost(&r) - 0.5 * r.norm_squared()).abs() < 1e-14);
    }
}
