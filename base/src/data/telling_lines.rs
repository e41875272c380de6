//! Lines of functions that tell of the structure; those between say the same once more.
//!
//! Within a bandwidth of a mode, 2ζf, a function changes as a circle does, and between modes as two of them do: a few lines about every
//! mode and some between hold what a model can be told by. Errors of neighbouring lines (calibration, leakage, what the model lacks) are not
//! independent, so that a thousand of them taken as so many data would be believed too much.

use super::frf::FrfSet;
use super::test::{FrfFit, TestMode};

/// How densely lines are chosen: about a mode, in parts of ζf from its frequency on either side, and the largest step elsewhere, as a share of the
/// frequency.
struct Density {
    beside: &'static [f64],
    step: f64,
}

/// The densest first.
const DENSITIES: [Density; 3] = [
    Density { beside: &[0.0, 0.7, 1.5, 3.0, 6.0], step: 0.02 },
    Density { beside: &[0.0, 1.0, 3.0], step: 0.04 },
    Density { beside: &[0.0, 1.5], step: 0.08 },
];
/// Damping ratio of a mode of which none is known, and bounds of the others.
const USUAL_RATIO: f64 = 0.01;
const RATIOS: [f64; 2] = [1e-3, 0.1];

impl FrfFit {
    /// The same with the lines that tell most of these modes, as densely as `most` values allow; unchanged where there are not more.
    ///
    /// * `most` - values of all functions together
    #[must_use]
    pub fn with_telling_lines(&self, set: &FrfSet, modes: &[TestMode], most: usize) -> Self {
        let used: Vec<f64> = set.frequencies_hz.iter().copied().filter(|&f| self.uses(f)).collect();
        let functions = set.responses.len() * set.references.len();
        if used.len() * functions <= most {
            return self.clone();
        }
        let chosen = DENSITIES.iter().map(|density| self.lines(&used, modes, density));
        let chosen = chosen.reduce(|best, next| if best.len() * functions <= most { best } else { next });
        Self { lines_hz: chosen, ..self.clone() }
    }

    /// * `used` - lines in its bands, ascending
    fn lines(&self, used: &[f64], modes: &[TestMode], density: &Density) -> Vec<f64> {
        let mut chosen = vec![false; used.len()];
        let nearest = |hz: f64| {
            let above = used.partition_point(|f| *f < hz).min(used.len() - 1);
            let is_below = above > 0 && hz - used[above - 1] < used[above] - hz;
            above - usize::from(is_below)
        };
        for mode in modes {
            let f = mode.frequency_hz.value;
            let ratio = mode.damping_ratio.map(|d| d.value).or(self.loss_factor.map(|eta| 0.5 * eta));
            let half = f * ratio.filter(|r| *r > 0.0).unwrap_or(USUAL_RATIO).clamp(RATIOS[0], RATIOS[1]);
            let beside = density.beside.iter().flat_map(|d| [f - d * half, f + d * half]);
            for hz in beside.filter(|hz| self.uses(*hz)) {
                chosen[nearest(hz)] = true;
            }
        }
        // The first and the last, and no step larger than allowed.
        let mut last = 0.0;
        for k in 0..used.len() {
            let next = used.get(k + 1).copied().unwrap_or(f64::INFINITY);
            chosen[k] |= next > last * (1.0 + density.step);
            if chosen[k] {
                last = used[k];
            }
        }
        (0..used.len()).filter(|&k| chosen[k]).map(|k| used[k]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Channel, FrfFit, FrfQuantity, FrfSet, TestMode, read_test};
    use proptest::prelude::*;

    fn set(lines: usize, functions: usize) -> FrfSet {
        let channels = |n: usize| (0..n).map(|k| Channel { name: k.to_string(), direction: None }).collect();
        FrfSet {
            quantity: FrfQuantity::Accelerance,
            frequencies_hz: (0..lines).map(|k| 0.05 * k as f64).collect(),
            references: channels(1),
            responses: channels(functions),
            h: Vec::new(),
            coherence: None,
            n_averages: None,
        }
    }

    fn modes() -> Vec<TestMode> {
        let text = "retune_test: 1\nname: t\nsources: {made: {kind: synthetic, text: by hand}}\nmodes:\n\
                    - {frequency: 5 Hz, frequency_sd: 0.1 Hz, source: made, damping: 2 %, damping_sd: 0.1 %}\n\
                    - {frequency: 37 Hz, frequency_sd: 0.1 Hz, source: made}\n";
        read_test(text).unwrap().0.modes
    }

    proptest! {
        /// Lines of the test, ascending, in the bands, the nearest to every mode among them, and no wide gap.
        #[test]
        fn lines_tell_of_every_mode_and_leave_no_gap(lines in 1_usize..3000, functions in 1_usize..40) {
            let (set, modes) = (set(lines, functions), modes());
            let bands = vec![[3.0, 20.0], [30.0, 60.0]];
            let fit = FrfFit { relative_sd: 0.05, bands_hz: bands, ..FrfFit::default() };
            let fewer = fit.with_telling_lines(&set, &modes, 1000);
            let used: Vec<f64> = set.frequencies_hz.iter().copied().filter(|f| fewer.uses(*f)).collect();
            let before: Vec<f64> = set.frequencies_hz.iter().copied().filter(|f| fit.uses(*f)).collect();
            prop_assert!(used.iter().all(|f| before.contains(f)));
            if before.len() * functions <= 1000 {
                prop_assert_eq!(&used, &before);
            }
            for mode in modes.iter().map(|m| m.frequency_hz.value) {
                if let Some(nearest) = before.iter().copied().min_by(|a, b| (a - mode).abs().total_cmp(&(b - mode).abs()))
                    .filter(|f| (f - mode).abs() < 0.03)
                {
                    prop_assert!(used.contains(&nearest), "{} of {:?}", nearest, used);
                }
            }
            for pair in used.windows(2) {
                let is_next = before.iter().position(|f| *f == pair[0]).is_some_and(|k| before[k + 1] == pair[1]);
                prop_assert!(is_next || pair[1] <= 1.0801 * pair[0] + 0.05, "{pair:?}");
            }
        }
    }

    #[test]
    fn a_thousand_lines_become_a_hundred() {
        let fit = FrfFit { relative_sd: 0.05, ..FrfFit::default() };
        let fewer = fit.with_telling_lines(&set(1201, 36), &modes(), 6000);
        let count = fewer.lines_hz.map(|lines| lines.len());
        assert!(count.is_some_and(|n| (100..170).contains(&n)), "{count:?}");
    }
}
