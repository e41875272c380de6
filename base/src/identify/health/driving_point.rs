//! What is wrong with a driving point? Hypotheses are weighed by how well a passive point would explain the function.
//!
//! The function of a driving point with real modes has residues of one sign, whatever the structure:
//!
//! ```text
//! H(ω) = (iω)^n [ Σ_r A_r/(ω_r² - ω² + 2iζ_r ω_r ω) - B/ω² + C ],     A_r, B, C >= 0
//! ```
//! Each hypothesis is an edit of the measured function that undoes one fault; the edited function is fitted with non-negative A, B, C at its
//! own poles, and what is left over decides:
//!
//! | fault | edit |
//! |---|---|
//! | sign of sensor or force | -H |
//! | phase: written for exp(-iωt) | H* |
//! | another quantity than stated | n' instead of n |
//! | delay of the response by τ | H exp(iωτ) |
//!
//! The fit sees what tells them apart: the sign of the imaginary part at the resonances, the sense in which the phase turns through them, and
//! the slope of the amplitude below and between them. Errors of a line are the noise and 5 % of the value; an edit fits when its mean
//! square is below four, or within twice that of the best where that one fits.

use super::super::band::median;
use super::super::{IdentifyOptions, Segments, identify};
use crate::catalogue::Choice;
use crate::data::{FrfQuantity, FrfSet};
use retune_linalg::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// Error of the modal form itself, relative to the value of a line: real residues in place of slightly complex ones.
const FORM: f64 = 0.05;

/// Mean square residual up to which an edit fits.
const FITS: f64 = 4.0;

/// Delays are looked for up to this phase at the highest line, rad: beyond a turn, a delay can give any mode any sign.
const MOST_PHASE: f64 = TAU;

/// What may be wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cause {
    /// The sensor or the force is reversed.
    Sign,
    /// All imaginary parts have the other sign.
    Conjugate,
    /// The functions are of this quantity.
    Quantity(FrfQuantity),
    /// The response comes later than the force by so many seconds (or earlier, when negative).
    Delay(f64),
}

impl Cause {
    /// What is the case, as a clause.
    pub(super) fn text(self) -> String {
        match self {
            Cause::Sign => "its sensor or the force is reversed".to_string(),
            Cause::Conjugate => {
                "the phase has the other sign: all imaginary parts are reversed, as in a file for exp(-iωt)".to_string()
            }
            Cause::Quantity(q) => format!("the functions are {}, not what the file says", q.word()),
            Cause::Delay(t) => format!(
                "the response is {} the force by {:.3} ms",
                if t > 0.0 { "behind" } else { "ahead of" },
                1e3 * t.abs()
            ),
        }
    }

    /// A stable word for programs.
    pub(super) fn code(self) -> &'static str {
        match self {
            Cause::Sign => "driving-point-reversed",
            Cause::Conjugate => "driving-point-conjugate",
            Cause::Quantity(_) => "driving-point-quantity",
            Cause::Delay(_) => "driving-point-delay",
        }
    }

    /// What to do.
    pub(super) fn remedy(self) -> &'static str {
        match self {
            Cause::Sign => "reverse the sign of the sensor or of the force in the test file",
            Cause::Conjugate => {
                "export the functions again for exp(+iωt), or reverse the sign of their imaginary parts"
            }
            Cause::Quantity(_) => {
                "correct the quantity where the file states it: in a universal file the data type of the ordinate (8 displacement, 11 \
                 velocity, 12 acceleration), in a table the row of units"
            }
            Cause::Delay(_) => {
                "correct the delay between the channels (trigger, filter or converter) and compute the functions again"
            }
        }
    }

    /// Name of its number in the evidence.
    pub(super) fn evidence(self) -> &'static str {
        match self {
            Cause::Sign => "misfit with the other sign",
            Cause::Conjugate => "misfit of the conjugate",
            Cause::Quantity(FrfQuantity::Receptance) => "misfit as receptance",
            Cause::Quantity(FrfQuantity::Mobility) => "misfit as mobility",
            Cause::Quantity(FrfQuantity::Accelerance) => "misfit as accelerance",
            Cause::Delay(_) => "misfit without the delay",
        }
    }
}

/// The hypotheses on one driving point.
#[derive(Debug, Clone)]
pub(super) struct Weighed {
    /// Mean square residual of the function as it stands.
    pub(super) as_stated: f64,
    /// That of each cause, best first.
    pub(super) causes: Vec<(Cause, f64)>,
}

impl Weighed {
    /// The causes that explain the function, best first.
    pub(super) fn fitting(&self) -> Vec<Cause> {
        let best = self.causes.first().map_or(f64::INFINITY, |c| c.1);
        self.causes.iter().filter(|c| c.1 <= FITS && c.1 <= (2.0 * best).max(1.0)).map(|c| c.0).collect()
    }
}

/// Weighs the hypotheses for response `o` and reference `i`; `sign` says whether their directions agree.
pub(super) fn weigh(frfs: &FrfSet, o: usize, i: usize, sign: f64) -> Weighed {
    let lines: Vec<usize> =
        (0..frfs.n_lines()).filter(|&l| frfs.frequencies_hz[l] > 0.0 && frfs.at(l, i, o).is_finite()).collect();
    let h: Vec<Complex<f64>> = lines.iter().map(|&l| frfs.at(l, i, o) * sign).collect();
    let omega: Vec<f64> = lines.iter().map(|&l| TAU * frfs.frequencies_hz[l]).collect();
    let n = frfs.quantity.order();
    let noise = noise(&h);
    let poles = |values: &[Complex<f64>]| poles(&omega, values, frfs.quantity);
    let own = poles(&h);
    let misfit =
        |values: &[Complex<f64>], order: i32, poles: &[Complex<f64>]| misfit(&omega, values, order, poles, &noise);
    let negative: Vec<Complex<f64>> = h.iter().map(|x| -x).collect();
    let conjugate: Vec<Complex<f64>> = h.iter().map(Complex::conj).collect();
    let mut causes =
        vec![(Cause::Sign, misfit(&negative, n, &own)), (Cause::Conjugate, misfit(&conjugate, n, &poles(&conjugate)))];
    for q in [FrfQuantity::Receptance, FrfQuantity::Mobility, FrfQuantity::Accelerance] {
        if q != frfs.quantity {
            causes.push((Cause::Quantity(q), misfit(&h, q.order(), &own)));
        }
    }
    let as_stated = misfit(&h, n, &own);
    if let Some(top) = omega.last() {
        // A sixteenth of a turn at the top changes no sign.
        let steps = 32;
        let shifted = |tau: f64| -> Vec<Complex<f64>> {
            h.iter().zip(&omega).map(|(x, w)| x * Complex::from_polar(1.0, w * tau)).collect()
        };
        let at = |tau: f64| misfit(&shifted(tau), n, &own);
        let step = MOST_PHASE / top / f64::from(steps);
        let coarse = (-steps..=steps).filter(|k| *k != 0).map(|k| f64::from(k) * step);
        if let Some((mut tau, mut best)) = coarse.map(|t| (t, at(t))).min_by(|a, b| a.1.total_cmp(&b.1)) {
            let mut width = 0.5 * step;
            while width > 1e-3 * step {
                for t in [tau - width, tau + width] {
                    let value = at(t);
                    if value < best {
                        (tau, best) = (t, value);
                    }
                }
                width *= 0.5;
            }
            causes.push((Cause::Delay(tau), best));
        }
    }
    causes.sort_by(|a, b| a.1.total_cmp(&b.1));
    Weighed { as_stated, causes }
}

/// Lines on each side over which the noise is taken: a resonance a few lines wide does not move the median of 33.
const AROUND: usize = 16;

/// Noise sd per real part at each line, from second differences over the lines around it.
pub(super) fn noise(h: &[Complex<f64>]) -> Vec<f64> {
    let d: Vec<f64> = h.windows(3).map(|w| (w[0] - w[1] * 2.0 + w[2]).norm_sqr()).collect();
    (0..h.len())
        .map(|l| {
            let to = (l + AROUND).min(d.len());
            let from = l.saturating_sub(AROUND + 1).min(to);
            (median(&mut d[from..to].to_vec()) / (12.0 * std::f64::consts::LN_2)).sqrt()
        })
        .collect()
}

/// The poles that the function alone shows.
fn poles(omega: &[f64], values: &[Complex<f64>], quantity: FrfQuantity) -> Vec<Complex<f64>> {
    let channel = || vec![crate::data::Channel { name: "1".to_string(), direction: None }];
    let set = FrfSet {
        quantity,
        frequencies_hz: omega.iter().map(|w| w / TAU).collect(),
        references: channel(),
        responses: channel(),
        h: values.to_vec(),
        coherence: None,
        n_averages: None,
    };
    let options = IdentifyOptions { segments: Segments::Octaves, ..IdentifyOptions::default() };
    identify(&set, &options).map_or_else(|_| Vec::new(), |found| found.modes.iter().map(|m| m.pole).collect())
}

/// Mean square of what the best passive point leaves of a function, in units of its errors; infinite without a pole.
fn misfit(omega: &[f64], h: &[Complex<f64>], order: i32, poles: &[Complex<f64>], noise: &[f64]) -> f64 {
    if poles.is_empty() {
        return f64::INFINITY;
    }
    let (rows, columns) = (2 * omega.len(), poles.len() + 2);
    let (mut a, mut y) = (DMatrix::zeros(rows, columns), DVector::zeros(rows));
    for (l, (w, value)) in omega.iter().zip(h).enumerate() {
        let front = Complex::new(0.0, *w).powi(order);
        let weight = 1.0 / noise[l].hypot(FORM * value.norm()).max(f64::MIN_POSITIVE);
        for c in 0..columns {
            let x = match poles.get(c) {
                Some(p) => (Complex::new(p.norm_sqr() - w * w, -2.0 * p.re * w)).inv(),
                None if c == poles.len() => Complex::new(-1.0 / (w * w), 0.0),
                None => Complex::new(1.0, 0.0),
            };
            let x = front * x * weight;
            (a[(2 * l, c)], a[(2 * l + 1, c)]) = (x.re, x.im);
        }
        (y[2 * l], y[2 * l + 1]) = (value.re * weight, value.im * weight);
    }
    let x = non_negative(&mut a, &y);
    (y - a * x).norm_squared() / rows as f64
}

/// min |A x - y| with x >= 0, by descent along coordinates on the normal equations; scales the columns of A to unit norm.
fn non_negative(a: &mut DMatrix<f64>, y: &DVector<f64>) -> DVector<f64> {
    for mut column in a.column_iter_mut() {
        let norm = column.norm();
        if norm > 0.0 && norm.is_finite() {
            column /= norm;
        }
    }
    let (gram, b) = (a.tr_mul(a), a.tr_mul(y));
    let n = b.len();
    let mut x = DVector::zeros(n);
    for _ in 0..2000 {
        let mut moved: f64 = 0.0;
        for k in 0..n {
            if gram[(k, k)] > 0.0 {
                let next = f64::max(0.0, x[k] + (b[k] - gram.row(k).transpose().dot(&x)) / gram[(k, k)]);
                moved = moved.max((next - x[k]).abs());
                x[k] = next;
            }
        }
        if moved <= 1e-9 * x.amax() {
            break;
        }
    }
    x
}
