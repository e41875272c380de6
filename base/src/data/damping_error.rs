//! What the scatter of damping ratios does to functions.
//!
//! A model without damping of its own is compared with one loss factor for all modes, an estimate; every mode has its own. What that does to the
//! functions follows from the functions: their poles, refined from those of the modes, and residues.
//!
//! ```text
//! H/(iω)^p = Σ_m A_m/(ω_m²(1 + iη_m) - ω²) - L/ω² + U          by least squares, rows times ω²
//! ∂ln H/∂ln η_m = -i η_m ω_m² A_m (iω)^p/((ω_m²(1 + iη_m) - ω²)² H)
//! ```
//!
//! # Source
//! D. J. Ewins, Modal Testing, 2nd ed., 2000, section 4.4.

use super::frf::FrfSet;
use super::test::{Measured, TestMode};
use retune_linalg::{Complex, DMatrix, thin_svd};
use std::f64::consts::TAU;

/// Share of the largest singular value below which residues are not told apart.
const TOLD: f64 = 1e-8;
/// Steps in which the poles are refined: where they are off by a part of a bandwidth, so is what another damping does.
const STEPS: usize = 10;
/// Terms beside the modes: what lies below and above.
const BESIDE: usize = 2;

/// Errors of functions by the damping of each of their modes.
#[derive(Debug, Clone, PartialEq)]
pub struct DampingError {
    /// Standard deviation of ln η of a mode.
    sd: f64,
    /// ω_m² and η_m.
    poles: Vec<[f64; 2]>,
    /// A, (n_modes x n_functions), functions as in [`FrfSet`]; zero of a function that was not measured.
    residues: DMatrix<f64>,
    n_responses: usize,
    order: i32,
}

impl DampingError {
    /// Of functions at the poles of modes; `None` where they do not tell the residues.
    ///
    /// * `sd` - standard deviation of ln η of a mode
    /// * `loss_factor` - of modes whose damping was not measured
    pub fn new(sd: f64, loss_factor: f64, set: &FrfSet, modes: &[TestMode]) -> Option<Self> {
        let pole = |m: &TestMode| {
            let eta = m.damping_ratio.map_or(loss_factor, |Measured { value, .. }| 2.0 * value);
            [(TAU * m.frequency_hz.value).powi(2), eta]
        };
        let in_lines = |m: &&TestMode| {
            let (first, last) = (set.frequencies_hz.first(), set.frequencies_hz.last());
            first.zip(last).is_some_and(|(first, last)| (*first..=*last).contains(&m.frequency_hz.value))
        };
        let poles: Vec<[f64; 2]> = modes.iter().filter(in_lines).map(pole).collect();
        let lines: Vec<usize> = (0..set.n_lines()).filter(|&l| set.frequencies_hz[l] > 0.0).collect();
        let n_columns = poles.len() + BESIDE;
        if poles.is_empty() || 2 * lines.len() < 2 * n_columns {
            return None;
        }
        let order = set.quantity.order();
        let n_functions = set.references.len() * set.responses.len();
        let mut values = DMatrix::zeros(2 * lines.len(), n_functions);
        for (row, &l) in lines.iter().enumerate() {
            let omega = TAU * set.frequencies_hz[l];
            let front = omega.powi(2) / Complex::new(0.0, omega).powi(order);
            for f in 0..n_functions {
                let h = set.h[l * n_functions + f] * front;
                (values[(2 * row, f)], values[(2 * row + 1, f)]) =
                    if h.is_finite() { (h.re, h.im) } else { (0.0, 0.0) };
            }
        }
        let squares: Vec<f64> = lines.iter().map(|&l| (TAU * set.frequencies_hz[l]).powi(2)).collect();
        let mut fit = Fit::new(poles, &squares, &values)?;
        for _ in 0..STEPS {
            let Some(next) = fit.step(&squares, &values).filter(|next| next.left < fit.left) else { break };
            fit = next;
        }
        let Fit { poles, residues, .. } = fit;
        Some(Self { sd, poles, residues, n_responses: set.responses.len(), order })
    }

    /// Number of modes.
    pub fn n_modes(&self) -> usize {
        self.poles.len()
    }

    /// Standard deviation of ln H, complex, of one value of a function by the damping of a mode.
    ///
    /// * `h` - the value
    pub fn of_value(
        &self,
        hz: f64,
        (reference, response): (usize, usize),
        h: Complex<f64>,
        mode: usize,
    ) -> Complex<f64> {
        let omega = TAU * hz;
        let pole @ [square, eta] = self.poles[mode];
        let residue = self.residues[(mode, reference * self.n_responses + response)];
        let moved = Complex::new(0.0, -eta * square * residue) / between(&pole, omega * omega).powi(2);
        let error = moved * Complex::new(0.0, omega).powi(self.order) / h * self.sd;
        if error.is_finite() { error } else { Complex::default() }
    }
}

/// Poles, and the residues that fit best with them.
struct Fit {
    poles: Vec<[f64; 2]>,
    residues: DMatrix<f64>,
    /// An orthonormal basis of what residues can fit.
    basis: DMatrix<f64>,
    remainder: DMatrix<f64>,
    /// Sum of its squares.
    left: f64,
}

impl Fit {
    /// * `squares` - ω² of the lines
    /// * `values` - ω² H/(iω)^p, real and imaginary parts in turns, (2 n_lines x n_functions)
    fn new(poles: Vec<[f64; 2]>, squares: &[f64], values: &DMatrix<f64>) -> Option<Self> {
        let mut a = DMatrix::zeros(2 * squares.len(), poles.len() + BESIDE);
        for (m, pole) in poles.iter().enumerate() {
            put(&mut a, m, squares, |square| square / between(pole, square));
        }
        put(&mut a, poles.len(), squares, |_| Complex::new(-1.0, 0.0));
        put(&mut a, poles.len() + 1, squares, |square| Complex::new(square, 0.0));
        let lengths: Vec<f64> = a.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        a.column_iter_mut().zip(&lengths).for_each(|(mut column, length)| column /= *length);
        let parts = thin_svd(&a).ok()?;
        let basis = parts.left.columns(0, parts.rank(TOLD)).into_owned();
        let mut residues = (parts.pseudo_inverse(TOLD) * values).rows(0, poles.len()).into_owned();
        residues.row_iter_mut().zip(&lengths).for_each(|(mut row, length)| row /= *length);
        let remainder = values - &basis * basis.tr_mul(values);
        let left = remainder.norm_squared();
        left.is_finite().then_some(Self { poles, residues, basis, remainder, left })
    }

    /// A step of Gauss and Newton in ln ω_m² and ln η_m, the residues eliminated, half a bandwidth and a fifth at most.
    ///
    /// # Source
    /// L. Kaufman, A variable projection method for solving separable nonlinear least squares problems, BIT 15, 1975.
    fn step(&self, squares: &[f64], values: &DMatrix<f64>) -> Option<Self> {
        const LARGEST: f64 = 0.2;
        let n = self.poles.len();
        let mut slopes = DMatrix::zeros(2 * squares.len(), 2 * n);
        for (m, pole @ &[of_mode, eta]) in self.poles.iter().enumerate() {
            let moved = |square: f64| -square / between(pole, square).powi(2);
            put(&mut slopes, 2 * m, squares, |square| moved(square) * Complex::new(of_mode, eta * of_mode));
            put(&mut slopes, 2 * m + 1, squares, |square| moved(square) * Complex::new(0.0, eta * of_mode));
        }
        let slopes = &slopes - &self.basis * self.basis.tr_mul(&slopes);
        let shared = &self.residues * self.residues.transpose();
        let gram = slopes.tr_mul(&slopes);
        let normal = DMatrix::from_fn(2 * n, 2 * n, |p, q| gram[(p, q)] * shared[(p / 2, q / 2)]);
        let along = slopes.tr_mul(&self.remainder);
        let gradient = DMatrix::from_fn(2 * n, 1, |p, _| along.row(p).dot(&self.residues.row(p / 2)));
        let step = normal.cholesky()?.solve(&gradient);
        let poles = self.poles.iter().enumerate().map(|(m, &[of_mode, eta])| {
            let by = step[2 * m].clamp(-eta, eta);
            [of_mode * by.exp(), eta * step[2 * m + 1].clamp(-LARGEST, LARGEST).exp()]
        });
        Self::new(poles.collect(), squares, values)
    }
}

/// A column of a quantity of all lines.
fn put(a: &mut DMatrix<f64>, column: usize, squares: &[f64], value: impl Fn(f64) -> Complex<f64>) {
    for (row, &square) in squares.iter().enumerate() {
        let v = value(square);
        (a[(2 * row, column)], a[(2 * row + 1, column)]) = (v.re, v.im);
    }
}

/// ω_m²(1 + iη_m) - ω².
fn between([pole, eta]: &[f64; 2], square: f64) -> Complex<f64> {
    Complex::new(pole - square, pole * eta)
}

#[cfg(test)]
mod tests {
    use super::super::{Channel, FrfQuantity, read_test};
    use super::*;

    /// Two modes, one of which hardly moves the second response, and what is above them.
    fn set(factors: [f64; 2]) -> (FrfSet, Vec<TestMode>) {
        let text = "retune_test: 1\nname: t\nsources: {made: {kind: synthetic, text: by hand}}\nmodes:\n\
                    - {frequency: 10.05 Hz, frequency_sd: 0.1 Hz, source: made, damping: 2 %, damping_sd: 0.1 %}\n\
                    - {frequency: 12.97 Hz, frequency_sd: 0.1 Hz, source: made, damping: 1.1 %, damping_sd: 0.1 %}\n";
        let modes = read_test(text).unwrap().0.modes;
        let lines: Vec<f64> = (1..400).map(|k| 0.05 * f64::from(k)).collect();
        let residues = [[1.0, 0.02], [-0.5, 0.7]];
        let value = |hz: f64, response: usize| {
            let square = (TAU * hz).powi(2);
            let of = |m: usize| {
                let f = [10.0, 13.0][m];
                let eta = 2.0 * [0.02, 0.01][m] * factors[m];
                residues[m][response] / between(&[(TAU * f).powi(2), eta], square)
            };
            -square * (of(0) + of(1) + 1e-5)
        };
        let h = lines.iter().flat_map(|&hz| [value(hz, 0), value(hz, 1)]).collect();
        let channels = |n: usize| (0..n).map(|k| Channel { name: k.to_string(), direction: None }).collect();
        let set = FrfSet {
            quantity: FrfQuantity::Accelerance,
            frequencies_hz: lines,
            references: channels(1),
            responses: channels(2),
            h,
            coherence: None,
            n_averages: None,
        };
        (set, modes)
    }

    #[test]
    fn errors_are_what_another_damping_does() {
        let (own, modes) = set([1.0, 1.0]);
        let error = DampingError::new(0.1, 0.03, &own, &modes).unwrap();
        let step = 1e-5;
        for mode in 0..2 {
            let mut factors = [1.0; 2];
            factors[mode] += step;
            let moved = set(factors).0;
            for (l, &hz) in own.frequencies_hz.iter().enumerate() {
                for response in 0..2 {
                    let (before, after) = (own.at(l, 0, response), moved.at(l, 0, response));
                    let exact = (after / before - 1.0) / step * 0.1;
                    let found = error.of_value(hz, (0, response), before, mode);
                    assert!((found - exact).norm() < 1e-4 * (1.0 + exact.norm()), "{hz} {found} {exact}");
                }
            }
        }
    }
}
