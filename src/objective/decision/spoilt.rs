//! Sensors that spoil the shapes of a test: one that is turned, scaled or dead must not make its modes foreign.

use super::{Found, FoundSide, Inference, Side};
use crate::linalg::DMatrix;
use crate::objective::EvalError;

/// A sensor has a noise of its own above so many times the median, and as many standard deviations.
const SPOILT: f64 = 4.0;

/// Factors on the noise of every sensor, of every test.
pub(super) type Factors = Vec<Vec<f64>>;

/// ln of the odds against a sensor whose readings tell nothing.
const LN_ODDS: f64 = 6.0;
/// Its noise over what is stated.
const NOTHING: f64 = 64.0;
/// Fewest sensors of which one is left out.
const FEWEST: usize = 4;
/// Frequencies of a pair that differ by more than this factor are strange, and so is noise of shapes from this step of the grid on.
const STRANGE: f64 = 1.4;
const STRANGE_STEP: usize = 3;

impl Inference<'_> {
    /// The factors of the sensors and the pairs where the readings of one sensor tell nothing, if that is more probable: a sensor that is
    /// turned over takes the true pair of its modes away, so that the pairs themselves do not show it.
    ///
    /// It is looked for where something is strange: a mode with a shape that has no partner, frequencies of a pair that are far apart, shapes that
    /// are far from their partners.
    pub(super) fn without_one(
        &self,
        found: &Found,
        inverse: &DMatrix<f64>,
    ) -> Result<Option<(Factors, Found)>, EvalError> {
        let mut best: Option<(Factors, Found)> = None;
        let none: Vec<Vec<f64>> = self.sides.iter().map(|s| vec![1.0; s.comparison.shapes().nrows()]).collect();
        for (k, (side, at)) in self.sides.iter().zip(&found.sides).enumerate() {
            let n = none[k].len();
            if n < FEWEST || !is_strange(side, at) {
                continue;
            }
            for sensor in 0..n {
                let mut factors = none.clone();
                factors[k][sensor] = NOTHING;
                let looks = self.looks(&found.x, true, Some(&factors))?;
                let tried = self.judged(found.x.clone(), looks, inverse);
                let least = best.as_ref().map_or(found.score + LN_ODDS, |b| b.1.score);
                if tried.score > least {
                    best = Some((factors, tried));
                }
            }
        }
        Ok(best)
    }

    /// Factors of the noise of every sensor, where one stands out among the pairs of a test whose shapes need more noise than stated.
    pub(super) fn spoilt(&self, found: &Found) -> Option<Factors> {
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

fn is_strange(side: &Side<'_>, at: &FoundSide) -> bool {
    let modes = &side.comparison.test().modes;
    let has_shape = |row: usize| modes[side.open[row]].shape.is_some();
    let is_far = |row: usize, a: usize| {
        let ratio = at.look.prediction.frequencies_hz[at.look.modes[a]] / modes[side.open[row]].frequency_hz.value;
        ratio.max(ratio.recip()) > STRANGE
    };
    let strange = |(row, pair): (usize, &Option<usize>)| has_shape(row) && pair.is_none_or(|a| is_far(row, a));
    at.partners().iter().enumerate().any(strange)
        || at.level.noise_step() >= STRANGE_STEP && (0..side.open.len()).any(has_shape)
}
