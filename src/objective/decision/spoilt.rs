//! Sensors that spoil the shapes of a test: one that is turned, scaled or dead must not make its modes foreign.

use super::{Found, FoundSide, Inference, Side};

/// A sensor has a noise of its own above so many times the median, and as many standard deviations.
const SPOILT: f64 = 4.0;

impl Inference<'_> {
    /// Factors of the noise of every sensor, where one stands out among the pairs of a test whose shapes need more noise than stated.
    pub(super) fn spoilt(&self, found: &Found) -> Option<Vec<Vec<f64>>> {
        let mut any = false;
        let one = |(side, at): (&Side<'_>, &FoundSide)| {
            let n = side.comparison.shapes().nrows();
            let mut factors = vec![1.0; n];
            if !at.level.is_noisy() {
                return factors;
            }
            let (mut square, mut count) = (vec![0.0; n], vec![0_u32; n]);
            for (row, a) in at.partners().iter().enumerate() {
                let i = side.open[row];
                let (Some(a), Some(sd)) = (a, &side.comparison.test().modes[i].shape_sd) else { continue };
                let phi = at.look.prediction.at_sensors.column(at.look.modes[*a]);
                let y = side.comparison.shapes().column(i);
                let rows: Vec<usize> = (0..n).filter(|&s| y[s].is_finite()).collect();
                let own: f64 = rows.iter().map(|&s| phi[s] * phi[s]).sum();
                let cross: f64 = rows.iter().map(|&s| phi[s] * y[s]).sum();
                let scale = if own > 0.0 { cross / own } else { 0.0 };
                for s in rows {
                    square[s] += ((y[s] - scale * phi[s]) / sd[s]).powi(2);
                    count[s] += 1;
                }
            }
            let rms: Vec<f64> = square.iter().zip(&count).map(|(q, c)| (q / f64::from((*c).max(1))).sqrt()).collect();
            let mut known: Vec<f64> = rms.iter().zip(&count).filter(|(_, c)| **c > 0).map(|(r, _)| *r).collect();
            known.sort_by(f64::total_cmp);
            let Some(&median) = known.get(known.len() / 2) else { return factors };
            for (factor, r) in factors.iter_mut().zip(&rms) {
                if *r > SPOILT * median && *r > SPOILT {
                    *factor = *r;
                    any = true;
                }
            }
            factors
        };
        let all: Vec<Vec<f64>> = self.sides.iter().zip(&found.sides).map(one).collect();
        any.then_some(all)
    }
}
