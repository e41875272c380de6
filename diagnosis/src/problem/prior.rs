//! Priors of the parameters, as rows of the least-squares problem.
//!
//! Every free parameter of the file has a Gaussian prior: its `prior_sd` where the file gives one, else half its interval around its estimate. A
//! size that an effect has brought has one of these around its neutral value, with its typical size as scale, twice as high where it has one sign:
//!
//! ```text
//! p(x) = 1/(π s (1 + z²)),    z = (x - c)/s;                             ½ρ² = ln(1 + z²)
//! p(x) = 1/(2 s arsinh(z_end) √(1 + z²))   where it spans decades;       ½ρ² = ½ ln(1 + z²)
//! ```
//!
//! A typical size is an order of magnitude, and one that is ten times as large must not be bent towards it. A compliance of a joint that is nearly a
//! hinge is thousands of times the typical one; with the first of these densities it would be next to impossible.

use crate::thresholds::WEAK_PRIOR;
use retune::effect::NewParameter;
use std::f64::consts::PI;

/// The prior of a parameter in the unit box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Prior {
    centre: f64,
    /// Standard deviation; of what has tails, where they begin.
    scale: f64,
    tails: Tails,
}

/// How the density of a prior falls, z scales from its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tails {
    /// exp(-z²/2).
    Gaussian,
    /// 1/(1 + z²): ten times the scale is rare, and not bent towards it.
    Cauchy,
    /// 1/√(1 + z²) up to a bound: every decade is as likely as the next. A joint that gives may be next to a hinge, a contact next to a weld.
    Decades {
        /// The bound, in scales.
        end: f64,
    },
}

impl Prior {
    /// No prior to speak of, for rows that are never read.
    pub(crate) const NONE: Self = Self { centre: 0.0, scale: 1.0, tails: Tails::Gaussian };

    pub(super) fn gaussian(centre: f64, scale: f64) -> Self {
        Self { centre, scale, tails: Tails::Gaussian }
    }

    /// Of a size that an effect has brought, in a box of this width.
    pub(super) fn of_size(new: &NewParameter, [lower, upper]: [f64; 2]) -> Self {
        let width = upper - lower;
        let centre = (new.neutral - lower) / width;
        let scale = (new.typical - new.neutral).abs() / width;
        if scale == 0.0 {
            return Self::gaussian(centre, WEAK_PRIOR);
        }
        let tails = if new.spans_decades() { Tails::Decades { end: (1.0 - centre) / scale } } else { Tails::Cauchy };
        Self { centre, scale, tails }
    }

    /// The row and its slope: half of its square is -ln of the density against that at the centre.
    pub(crate) fn row(self, x: f64) -> (f64, f64) {
        let z = (x - self.centre) / self.scale;
        let power = match self.tails {
            Tails::Gaussian => return (z, 1.0 / self.scale),
            Tails::Cauchy => 2.0,
            Tails::Decades { .. } => 1.0,
        };
        let rho = (power * (z * z).ln_1p()).sqrt().copysign(z);
        // Near zero ρ = √p z.
        let slope = if z.abs() < 1e-6 { f64::sqrt(power) } else { power * z / ((1.0 + z * z) * rho) };
        (rho, slope / self.scale)
    }

    /// ln of the density at the centre of both sides, beside the 1/√2π of every Gaussian, which Laplace's method takes back.
    pub(super) fn ln_height(self) -> f64 {
        let tails = match self.tails {
            Tails::Gaussian => 0.0,
            Tails::Cauchy => 0.5 * (2.0 / PI).ln(),
            Tails::Decades { end } => 0.5 * (0.5 * PI).ln() - end.asinh().ln(),
        };
        tails - self.scale.ln()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn new(bounds: [f64; 2]) -> NewParameter {
        NewParameter {
            name: "c".to_string(),
            unit: "1".to_string(),
            neutral: 0.0,
            typical: 0.05,
            bounds,
            grid: Vec::new(),
            description: String::new(),
        }
    }

    /// ∫ p = 1 over the box for what has decades, and 1 less what lies beyond the box for the others; slopes are those of the rows.
    #[test]
    fn densities_have_their_heights_and_rows_their_slopes() {
        for (bounds, tolerance) in [([0.0, 50.0], 1e-4), ([0.0, 2.0], 0.02), ([-2.0, 2.0], 0.02)] {
            let size = new(bounds);
            let prior = Prior::of_size(&size, bounds);
            let sides = if size.one_sided() { 2.0 } else { 1.0 };
            let height = sides * prior.ln_height().exp() / (2.0 * PI).sqrt();
            let n = 2_000_000;
            let density = |i: usize| (-0.5 * prior.row((i as f64 + 0.5) / f64::from(n as u32)).0.powi(2)).exp();
            let sum = (0..n).map(density).sum::<f64>() / n as f64 * height;
            assert!((sum - 1.0).abs() < tolerance, "{bounds:?}: {sum}");
            for x in [0.3, 0.5, 0.500_000_01, 0.9] {
                let step = 1e-7;
                let slope = (prior.row(x + step).0 - prior.row(x - step).0) / (2.0 * step);
                assert!((prior.row(x).1 / slope - 1.0).abs() < 1e-4, "{bounds:?} {x}");
            }
        }
        assert!(new([0.0, 50.0]).spans_decades() && !new([0.0, 2.0]).spans_decades());
    }
}
