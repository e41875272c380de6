//! The functions of frequency that a modal model is made of, as real matrices.

use super::band::Band;
use super::poles::{Poles, ResidualTerms};
use retune_linalg::{Complex, DMatrix, DVector};

impl ResidualTerms {
    pub(super) fn powers(self) -> Vec<i32> {
        (0..self.lower as i32).map(|k| -2 - k).chain(0..self.upper as i32).collect()
    }
}

/// Basis functions of a band at given poles.
pub(super) struct Basis<'a> {
    pub(super) band: &'a Band,
    pub(super) poles: &'a Poles,
    pub(super) terms: ResidualTerms,
    pub(super) omega_ref: f64,
}

impl Basis<'_> {
    pub(super) fn rows(&self) -> usize {
        2 * self.band.n_lines() * self.band.n_inputs()
    }

    pub(super) fn n_linear(&self) -> usize {
        2 * self.poles.len() + self.band.n_inputs() * self.terms.powers().len()
    }

    /// Linear unknowns of an output that its living functions determine.
    pub(super) fn n_fitted(&self, output: usize) -> usize {
        2 * self.poles.len() + self.band.n_alive(output) * self.terms.powers().len()
    }

    /// Writes the real columns of coefficient (Re, Im) of ψ u + ψ* v into two columns.
    fn put(&self, a: &mut DMatrix<f64>, column: usize, input: usize, u: impl Fn(f64) -> (Complex<f64>, Complex<f64>)) {
        let n_l = self.band.n_lines();
        for (l, w) in self.band.omega.iter().enumerate() {
            let (u, v) = u(w / self.omega_ref);
            let row = 2 * (input * n_l + l);
            let (sum, difference) = (u + v, (u - v) * Complex::i());
            (a[(row, column)], a[(row + 1, column)]) = (sum.re, sum.im);
            (a[(row, column + 1)], a[(row + 1, column + 1)]) = (difference.re, difference.im);
        }
    }

    /// [A D], or A alone.
    pub(super) fn matrix(&self, with_derivatives: bool) -> DMatrix<f64> {
        let unknowns = if with_derivatives { self.poles.unknowns() } else { Vec::new() };
        let (n_modes, n_i, p) = (self.poles.len(), self.band.n_inputs(), self.n_linear());
        let mut a = DMatrix::zeros(self.rows(), p + 2 * unknowns.len());
        let order = self.band.order;
        let front = |w: f64| Complex::new(0.0, w).powi(order);
        for r in 0..n_modes {
            let lambda = self.poles.values[r] / self.omega_ref;
            for i in 0..n_i {
                let l = self.poles.participation[r][i];
                self.put(&mut a, 2 * r, i, |w| {
                    let (s, g) = (Complex::new(0.0, w), front(w));
                    (g * l / (s - lambda), g * l.conj() / (s - lambda.conj()))
                });
            }
        }
        let powers = self.terms.powers();
        for i in 0..n_i {
            for (t, &k) in powers.iter().enumerate() {
                let column = 2 * n_modes + i * powers.len() + t;
                for (l, w) in self.band.omega.iter().enumerate() {
                    let x = Complex::new(0.0, w / self.omega_ref).powi(order + k);
                    let row = 2 * (i * self.band.n_lines() + l);
                    (a[(row, column)], a[(row + 1, column)]) = (x.re, x.im);
                }
            }
        }
        for (k, (r, input)) in unknowns.into_iter().enumerate() {
            let lambda = self.poles.values[r] / self.omega_ref;
            match input {
                None => {
                    for i in 0..n_i {
                        let l = self.poles.participation[r][i];
                        self.put(&mut a, p + 2 * k, i, |w| {
                            let (s, g) = (Complex::new(0.0, w), front(w));
                            (g * l / (s - lambda).powi(2), g * l.conj() / (s - lambda.conj()).powi(2))
                        });
                    }
                }
                Some(i) => self.put(&mut a, p + 2 * k, i, |w| {
                    let (s, g) = (Complex::new(0.0, w), front(w));
                    (g / (s - lambda), g / (s - lambda.conj()))
                }),
            }
        }
        a
    }
}

/// The data of outputs `range`, one real column each, weighted by `weight(row pair)`.
pub(super) fn data(band: &Band, range: std::ops::Range<usize>) -> DMatrix<f64> {
    let n_l = band.n_lines();
    let mut y = DMatrix::zeros(2 * n_l * band.n_inputs(), range.len());
    for (column, o) in range.enumerate() {
        for i in 0..band.n_inputs() {
            for (l, h) in band.function(o, i).iter().enumerate() {
                let row = 2 * (i * n_l + l);
                (y[(row, column)], y[(row + 1, column)]) = (h.re, h.im);
            }
        }
    }
    y
}

/// 1/sd of every real row of an output, when it varies over lines.
pub(super) fn row_weights(band: &Band, o: usize) -> Option<DVector<f64>> {
    if band.variance.is_none() && band.profile.is_none() {
        return None;
    }
    let mut w = Vec::with_capacity(2 * band.n_lines() * band.n_inputs());
    for i in 0..band.n_inputs() {
        let variance = band.variance_of(o, i);
        for l in 0..band.n_lines() {
            let v = variance.map_or(1.0, |v| v[l]) * band.profile.as_ref().map_or(1.0, |p| p[l]);
            let x = 1.0 / v.sqrt();
            w.extend([x, x]);
        }
    }
    Some(DVector::from_vec(w))
}

pub(super) fn weigh(m: &mut DMatrix<f64>, w: &DVector<f64>) {
    for mut column in m.column_iter_mut() {
        column.component_mul_assign(w);
    }
}
