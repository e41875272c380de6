//! The modal model and its maximum-likelihood fit: poles and participation refined, shapes and residuals eliminated.
//!
//! ```text
//! H_oi(ω) = (iω)^n [ Σ_r ψ_or l_ri /(iω-λ_r) + ψ*_or l*_ri /(iω-λ*_r)  +  Σ_k c_oik (iω)^k ]
//! n = 0, 1, 2 for receptance, mobility, accelerance;   k = -2, -3, .. (below the band) and 0, 1, .. (above it)
//! ```
//!
//! Given λ and l the model is linear in ψ and c (the least-squares frequency-domain estimator, LSFD), with one matrix for
//! all outputs; the poles are then found by Gauss-Newton on the projected problem (variable projection). With D the
//! derivatives of the matrix, one factorisation [A D] = Q R gives everything: shapes, projected gradient, Hessian, and the
//! covariance of all estimates. The powers k are the two series in s of modes outside the band: they have real
//! coefficients because such a mode is a real function of s; k = -2 and 0 are the usual lower and upper residuals.
//!
//! Noise: independent over lines and outputs, Gaussian, its level per output estimated (profile likelihood).
//!
//! Sources: G. H. Golub, V. Pereyra, Separable nonlinear least squares: the variable projection method and its
//! applications, Inverse Problems 19, 2003; M. El-Kafafy, T. De Troyer, P. Guillaume, Fast maximum-likelihood
//! identification of modal parameters with uncertainty intervals, Mech. Syst. Signal Process. 37, 2013.

use super::IdentifyError;
use super::band::Band;
use super::basis::{Basis, data, row_weights, weigh};
use super::common::common_noise;
use super::fitted::{Common, Fit, Left};
use super::poles::{Poles, ResidualTerms};
use rayon::prelude::*;
use retune_linalg::{Complex, DMatrix, DVector, thin_qr};

/// The linear part at given poles, for outputs that share their weights.
struct Linear {
    /// Outputs of the group.
    outputs: std::ops::Range<usize>,
    /// Coefficients of A (columns x outputs), scaled back.
    c: DMatrix<f64>,
    /// Weighted sum of squares left over per output.
    sse: Vec<f64>,
    /// (AᵀWA)⁻¹.
    inverse: DMatrix<f64>,
    /// A⁺ D.
    pinv_d: DMatrix<f64>,
    /// R22: D projected off A, in its own basis.
    r22: DMatrix<f64>,
    /// The data in that basis (columns of D x outputs).
    z2: DMatrix<f64>,
}

fn solve_group(
    basis: &DMatrix<f64>,
    y: &DMatrix<f64>,
    p: usize,
    outputs: std::ops::Range<usize>,
) -> Result<Linear, IdentifyError> {
    let singular = || IdentifyError::Singular { what: "equations of the mode shapes" };
    let mut a = basis.clone();
    let n = a.ncols();
    let mut scale = vec![1.0; n];
    for (j, mut column) in a.column_iter_mut().enumerate() {
        let norm = column.norm();
        if norm > 0.0 {
            scale[j] = 1.0 / norm;
            column *= scale[j];
        }
    }
    let qr = thin_qr(&a)?;
    let r11 = qr.r.view((0, 0), (p, p));
    // Columns of unit norm: a diagonal of R below 1e-11 means that two modes or terms are the same function.
    if r11.diagonal().iter().any(|d| d.abs() < 1e-11) {
        return Err(singular());
    }
    let z = qr.q.tr_mul(y);
    let mut c = z.rows(0, p).into_owned();
    r11.solve_upper_triangular_mut(&mut c);
    let mut pinv_d = qr.r.view((0, p), (p, n - p)).into_owned();
    r11.solve_upper_triangular_mut(&mut pinv_d);
    let inverse_r = r11.solve_upper_triangular(&DMatrix::identity(p, p)).ok_or_else(singular)?;
    let mut inverse = &inverse_r * inverse_r.transpose();
    let mut r22 = qr.r.view((p, p), (n - p, n - p)).into_owned();
    for j in 0..n - p {
        r22.column_mut(j).scale_mut(1.0 / scale[p + j]);
        for i in 0..p {
            pinv_d[(i, j)] *= scale[i] / scale[p + j];
        }
    }
    for i in 0..p {
        c.row_mut(i).scale_mut(scale[i]);
        for j in 0..p {
            inverse[(i, j)] *= scale[i] * scale[j];
        }
    }
    let sse = (0..y.ncols())
        .map(|k| {
            let total = y.column(k).norm_squared();
            // Below (1e-13)² of the data the difference is rounding.
            (total - z.column(k).rows(0, p).norm_squared()).max(1e-26 * total)
        })
        .collect();
    Ok(Linear { outputs, c, sse, inverse, pinv_d, r22, z2: z.rows(p, n - p).into_owned() })
}

/// The linear fit of all outputs; one group without line weights, else one per output.
fn solve_linear(basis: &Basis<'_>, y: &DMatrix<f64>, with_derivatives: bool) -> Result<Vec<Linear>, IdentifyError> {
    let (band, p) = (basis.band, basis.n_linear());
    let mut matrix = basis.matrix(with_derivatives);
    if matrix.nrows() < matrix.ncols() + 2 {
        let needed = (matrix.ncols() + 2).div_ceil(2 * band.n_inputs());
        return Err(IdentifyError::TooFewLines { found: band.n_lines(), needed });
    }
    if band.variance.is_none() {
        // One set of weights for all outputs, or none.
        let Some(w) = row_weights(band, 0) else {
            return Ok(vec![solve_group(&matrix, y, p, 0..band.n_outputs())?]);
        };
        let mut y = y.clone();
        weigh(&mut matrix, &w);
        weigh(&mut y, &w);
        return Ok(vec![solve_group(&matrix, &y, p, 0..band.n_outputs())?]);
    }
    let found: Vec<Result<Linear, IdentifyError>> = (0..band.n_outputs())
        .into_par_iter()
        .map(|o| {
            let (mut a, mut y) = (matrix.clone(), y.columns(o, 1).into_owned());
            if let Some(w) = row_weights(band, o) {
                weigh(&mut a, &w);
                weigh(&mut y, &w);
            }
            solve_group(&a, &y, p, o..o + 1)
        })
        .collect();
    found.into_iter().collect()
}

/// -2 ln L, profiled over the noise level of each output.
fn merit(groups: &[Linear], band: &Band) -> f64 {
    let of = |(o, s): (usize, &f64)| band.n_values(o) as f64 * s.max(f64::MIN_POSITIVE).ln();
    groups.iter().flat_map(|g| g.outputs.clone().zip(&g.sse)).map(of).sum()
}

/// Degrees of freedom of each output: real values of its living functions, less what is fitted to them and its share of the unknowns.
fn degrees_of_freedom(basis: &Basis<'_>) -> Vec<f64> {
    let band = basis.band;
    let share = 2.0 * basis.poles.unknowns().len() as f64 / band.n_outputs() as f64;
    let of = |o: usize| (band.n_values(o) as f64 - basis.n_fitted(o) as f64 - share).max(1.0);
    (0..band.n_outputs()).map(of).collect()
}

/// [`merit`] at given poles, nothing refined.
pub(super) fn merit_at(band: &Band, poles: &Poles, terms: ResidualTerms) -> Result<f64, IdentifyError> {
    let basis = Basis { band, poles, terms, omega_ref: band.omega[band.n_lines() - 1] };
    Ok(merit(&solve_linear(&basis, &data(band, 0..band.n_outputs()), false)?, band))
}

/// Hessian and gradient of the unknowns, scaled to unit noise.
fn normal_equations(groups: &[Linear], poles: &Poles, dof: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
    let unknowns = poles.unknowns();
    let n = 2 * unknowns.len();
    let (mut h, mut g) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for group in groups {
        let gram = group.r22.tr_mul(&group.r22);
        let gradient = group.r22.tr_mul(&group.z2);
        for (k, o) in group.outputs.clone().enumerate() {
            let weight = dof[o] / group.sse[k].max(f64::MIN_POSITIVE);
            let psi: Vec<(f64, f64)> =
                unknowns.iter().map(|&(r, _)| (group.c[(2 * r, k)], group.c[(2 * r + 1, k)])).collect();
            for (a, &(re_a, im_a)) in psi.iter().enumerate() {
                let (g1, g2) = (gradient[(2 * a, k)], gradient[(2 * a + 1, k)]);
                g[2 * a] += weight * (re_a * g1 + im_a * g2);
                g[2 * a + 1] += weight * (-im_a * g1 + re_a * g2);
                for (b, &(re_b, im_b)) in psi.iter().enumerate() {
                    let (m11, m12) = (gram[(2 * a, 2 * b)], gram[(2 * a, 2 * b + 1)]);
                    let (m21, m22) = (gram[(2 * a + 1, 2 * b)], gram[(2 * a + 1, 2 * b + 1)]);
                    // C_aᵀ G C_b with C = [[Re, -Im], [Im, Re]].
                    let (x11, x12) = (m11 * re_b + m12 * im_b, -m11 * im_b + m12 * re_b);
                    let (x21, x22) = (m21 * re_b + m22 * im_b, -m21 * im_b + m22 * re_b);
                    h[(2 * a, 2 * b)] += weight * (re_a * x11 + im_a * x21);
                    h[(2 * a, 2 * b + 1)] += weight * (re_a * x12 + im_a * x22);
                    h[(2 * a + 1, 2 * b)] += weight * (-im_a * x11 + re_a * x21);
                    h[(2 * a + 1, 2 * b + 1)] += weight * (-im_a * x12 + re_a * x22);
                }
            }
        }
    }
    (h, g)
}

/// The number of residual terms that the data ask for, by the Bayesian information criterion at fixed poles.
///
/// One to three terms on each side: three describe a mode 15 % outside the band to better than a percent of its share.
pub(super) fn choose_terms(band: &Band, poles: &Poles) -> Result<ResidualTerms, IdentifyError> {
    let y = data(band, 0..band.n_outputs());
    let mut best = (f64::INFINITY, ResidualTerms { lower: 1, upper: 1 });
    for k in 1..=3 {
        let terms = ResidualTerms { lower: k, upper: k };
        let basis = Basis { band, poles, terms, omega_ref: band.omega[band.n_lines() - 1] };
        let n = basis.rows();
        let groups = match solve_linear(&basis, &y, false) {
            Ok(groups) => groups,
            Err(_) if k > 1 => break,
            Err(e) => return Err(e),
        };
        let bic = merit(&groups, band) + (band.n_outputs() * band.n_inputs() * 2 * k) as f64 * (n as f64).ln();
        if bic < best.0 {
            best = (bic, terms);
        }
    }
    Ok(best.1)
}

/// Fits the modal model; `refine` false keeps the poles (plain LSFD, covariances as if the poles were exact optima).
pub(super) fn fit(band: &Band, start: &Poles, terms: ResidualTerms, max_steps: usize) -> Result<Fit, IdentifyError> {
    let omega_ref = band.omega[band.n_lines() - 1];
    let line_spacing = (omega_ref - band.omega[0]) / (band.n_lines() - 1).max(1) as f64;
    let y = data(band, 0..band.n_outputs());
    let mut poles = start.clone();
    let at = |poles: &Poles| solve_linear(&Basis { band, poles, terms, omega_ref }, &y, true);
    let basis = Basis { band, poles: start, terms, omega_ref };
    let dof = degrees_of_freedom(&basis);
    let mut groups = at(&poles)?;
    let mut value = merit(&groups, band);
    let (mut damping, mut is_converged) = (1e-4, start.n_free == 0);
    let max_steps = if start.n_free == 0 { 0 } else { max_steps };
    'steps: for _ in 0..max_steps {
        let (h, g) = normal_equations(&groups, &poles, &dof);
        loop {
            let mut damped = h.clone();
            for k in 0..h.nrows() {
                damped[(k, k)] *= 1.0 + damping;
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&g)) else {
                damping *= 10.0;
                if damping > 1e8 {
                    break 'steps;
                }
                continue;
            };
            // A hundredth of a standard deviation, or rounding of the poles themselves: nothing left to gain.
            let is_small = step.dot(&g) < 1e-4 || step.amax() < 1e-13;
            let trial = poles.moved(&step, omega_ref, start, line_spacing);
            if let Ok(next) = at(&trial)
                && merit(&next, band) <= value
            {
                (value, poles, groups) = (merit(&next, band), trial, next);
                damping = (damping * 0.1).max(1e-9);
                if is_small {
                    is_converged = true;
                    break 'steps;
                }
                break;
            }
            if is_small {
                is_converged = true;
                break 'steps;
            }
            damping = damping.max(1e-4) * 10.0;
            if damping > 1e8 {
                break 'steps;
            }
        }
    }
    let n_fitted = basis.n_linear() * band.n_outputs() + 2 * start.unknowns().len();
    let bic = value + n_fitted as f64 * (basis.rows() as f64).ln();
    Ok(Fit { bic, is_converged, ..assemble(band, poles, terms, &groups, &y, &dof) })
}

fn assemble(band: &Band, poles: Poles, terms: ResidualTerms, groups: &[Linear], y: &DMatrix<f64>, dof: &[f64]) -> Fit {
    let omega_ref = band.omega[band.n_lines() - 1];
    let (n_modes, n_o) = (poles.len(), band.n_outputs());
    let (h, _) = normal_equations(groups, &poles, dof);
    let n = h.nrows();
    let unknown = || DMatrix::from_diagonal_element(n, n, f64::INFINITY);
    let mut covariance = if n == 0 { h } else { h.cholesky().map_or_else(unknown, |c| c.inverse()) };
    let unknowns = poles.unknowns();
    let unit = |k: usize| if unknowns[k / 2].1.is_none() { omega_ref } else { 1.0 };
    // ψ of the scaled axis: H = ω_ref^(n-1) ψ (iω')^n/(iω'-λ').
    let back = omega_ref.powi(1 - band.order);
    let back_terms = omega_ref.powi(-band.order);
    let n_terms = band.n_inputs() * terms.powers().len();
    let mut shapes = DMatrix::zeros(n_o, n_modes);
    let mut residuals = DMatrix::zeros(n_terms, n_o);
    let mut sigma = vec![0.0; n_o];
    let mut local = vec![vec![[0.0; 3]; n_o]; n_modes];
    let mut slope = vec![DMatrix::zeros(2 * n_o, n); n_modes];
    for group in groups {
        for (k, o) in group.outputs.clone().enumerate() {
            let variance = group.sse[k] / dof[o];
            sigma[o] = variance.sqrt();
            let psi: Vec<(f64, f64)> = (0..n_modes).map(|r| (group.c[(2 * r, k)], group.c[(2 * r + 1, k)])).collect();
            for r in 0..n_modes {
                shapes[(o, r)] = Complex::new(psi[r].0, psi[r].1) * back;
                let v = |a: usize, b: usize| group.inverse[(2 * r + a, 2 * r + b)] * variance * back * back;
                local[r][o] = [v(0, 0), v(0, 1), v(1, 1)];
                for (q, &(mode, _)) in unknowns.iter().enumerate() {
                    let (re, im) = psi[mode];
                    for part in 0..2 {
                        let (d1, d2) = (group.pinv_d[(2 * r + part, 2 * q)], group.pinv_d[(2 * r + part, 2 * q + 1)]);
                        slope[r][(2 * o + part, 2 * q)] = -back * (d1 * re + d2 * im) / unit(2 * q);
                        slope[r][(2 * o + part, 2 * q + 1)] = -back * (-d1 * im + d2 * re) / unit(2 * q);
                    }
                }
            }
            for t in 0..n_terms {
                residuals[(t, o)] = group.c[(2 * n_modes + t, k)] * back_terms;
            }
        }
    }
    for a in 0..n {
        for b in 0..n {
            covariance[(a, b)] *= unit(a) * unit(b);
        }
    }
    let left = Left::new(band, &poles, terms, groups, y, &sigma);
    let (inflation, level) = left.inflation(band, &poles, None);
    let (bic, is_converged) = (f64::NAN, false);
    Fit {
        poles,
        terms,
        shapes,
        residuals,
        omega_ref,
        covariance,
        local,
        slope,
        sigma,
        inflation,
        level,
        bic,
        is_converged,
        left,
        common: None,
    }
}

impl Left {
    fn new(
        band: &Band,
        poles: &Poles,
        terms: ResidualTerms,
        groups: &[Linear],
        y: &DMatrix<f64>,
        sigma: &[f64],
    ) -> Self {
        let n_l = band.n_lines();
        let basis = Basis { band, poles, terms, omega_ref: band.omega[n_l - 1] };
        let a = basis.matrix(false);
        let (mut power, mut product) = (vec![0.0; n_l], vec![0.0; n_l]);
        for group in groups {
            let model = &a * &group.c;
            for (k, o) in group.outputs.clone().enumerate() {
                let weights = row_weights(band, o);
                for i in (0..band.n_inputs()).filter(|&i| band.is_alive(o, i)) {
                    let e = |l: usize| {
                        let row = 2 * (i * n_l + l);
                        let w = weights.as_ref().map_or(1.0, |w| w[row]) / sigma[o].max(f64::MIN_POSITIVE);
                        Complex::new(y[(row, o)] - model[(row, k)], y[(row + 1, o)] - model[(row + 1, k)]) * w
                    };
                    let mut here = e(0);
                    for l in 0..n_l {
                        power[l] += here.norm_sqr();
                        if l + 1 < n_l {
                            let next = e(l + 1);
                            product[l] += (here.conj() * next).re;
                            here = next;
                        }
                    }
                }
            }
        }
        Self { power, product }
    }

    /// How much larger than the sd of the noise model the truth is likely to be near each resonance.
    ///
    /// ```text
    /// factor² = (local mean of |e|² over its expectation) (1 + ρ)/(1 - ρ),   ρ = lag-one correlation of the residual over lines
    /// ```
    /// each counted only when it exceeds its own chance level by two standard deviations. Noise as the model has it gives 1; an
    /// imperfect structure (friction, drift, leakage) leaves a residual that is larger and smoother at its peaks. Returns the
    /// factors, and the same squared without the test of significance.
    ///
    /// Source: R. T. Birge, The calculation of errors by the method of least squares, Phys. Rev. 40, 1932, for the ratio;
    /// the variance inflation of first-order autoregressive noise is textbook (Bayley and Hammersley, 1946).
    fn inflation(&self, band: &Band, poles: &Poles, common: Option<&Common>) -> (Vec<f64>, Vec<f64>) {
        let n_l = band.n_lines();
        let functions = (0..band.n_outputs()).map(|o| band.n_alive(o)).sum::<usize>() as f64;
        poles
            .values
            .iter()
            .map(|p| {
                let (centre, half) = (p.norm(), -2.0 * p.re);
                let nearest = band.omega.partition_point(|w| *w < centre).min(n_l - 1);
                let from = band.omega.partition_point(|w| *w < centre - half).min(nearest.saturating_sub(6));
                let to = band.omega.partition_point(|w| *w <= centre + half).max(nearest + 7).min(n_l);
                let white = 2.0 * functions * (to - from) as f64;
                let sum = |v: &[f64]| v[from..to].iter().sum::<f64>();
                // Expected power, and the number of independent values in it: all of them when the noise is white.
                let (expected, count) = common.map_or((white, white), |c| {
                    let expected = sum(&c.expected);
                    (expected, 2.0 * expected * expected / sum(&c.spread).max(f64::MIN_POSITIVE))
                });
                let total = sum(&self.power);
                let level = total / expected;
                let correlation =
                    self.product[from..to.max(from + 2) - 1].iter().sum::<f64>() / total.max(f64::MIN_POSITIVE);
                // For white noise the level has sd √(2/count) and the correlation sd 1/√count.
                let significant = if level > 1.0 + 2.0 * (2.0 / count).sqrt() { level } else { 1.0 };
                let rho = if correlation > 2.0 / count.sqrt() { correlation.min(0.95) } else { 0.0 };
                let smoothness = (1.0 + rho) / (1.0 - rho);
                ((significant * smoothness).sqrt(), level.max(f64::MIN_POSITIVE) * smoothness)
            })
            .unzip()
    }
}

impl Fit {
    /// The same fit with covariances that hold where the channels of a reference have noise in common; see [`common_noise`].
    pub(super) fn with_common_noise(mut self, band: &Band) -> Result<Self, IdentifyError> {
        let Some(common) = common_noise(band, &self)? else { return Ok(self) };
        let n = self.covariance.nrows();
        for (k, &(r, _)) in self.poles.unknowns().iter().enumerate() {
            // Every row with the lines of its own mode; a pair of modes shares those of the first.
            for a in [2 * k, 2 * k + 1] {
                for b in 0..n {
                    self.covariance[(a, b)] =
                        common.white[(a, b)] + common.theta[r].row(a).dot(&common.theta[r].row(b));
                }
            }
        }
        (self.inflation, self.level) = self.left.inflation(band, &self.poles, Some(&common));
        self.common = Some(common);
        Ok(self)
    }
}
