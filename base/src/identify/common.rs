//! Noise that is common to all channels of one reference: what it adds to the covariances.
//!
//! Noise of the measured force multiplies every function of its reference by the same factor, line by line; independent channels would average it
//! out, these do not:
//!
//! ```text
//! ε_o(ω) = n_o(ω) + H_o(ω) δ(ω),      E|δ|² = 2 s²,   n_o independent over channels
//! ```
//! s is estimated from what the residuals e of different channels have in common. With u_o = w_o H_o/σ_o and r_o = w_o e_o/σ_o (weighted and scaled
//! to unit variance),
//!
//! ```text
//! q = |Σ_o u*_o r_o|² - Σ_o |u_o|² |r_o|²        per line; zero on average for independent channels
//! ```
//! and s² is the ratio of Σ d q to its expectation per s², weights d = 1/(1 + s² g)², g = Σ |u_o|². The expectations count what the fit
//! has taken out: with U the common pattern and P the projection on everything fitted, E Uᵀ r rᵀ U = M + s² M², M = Uᵀ (I-P) U. So modes that are
//! a few lines wide, which follow the common noise, do not hide it. The estimate counts when it exceeds its own standard deviation.
//!
//! Poles, participation and shapes are linear in the noise, so their covariances follow: the independent part with the variance that
//! is left to it, and the common part line by line,
//!
//! ```text
//! cov = Σ_l [ Σ_o X_ol κ_ol X_olᵀ + s² (Σ_o X_ol u_ol)(Σ_o X_ol u_ol)ᵀ ]
//! ```
//! where X is the influence of a line on the estimates; κ = 1 - s²|u|² where the coherence gives each line its variance, and 1 - s² mean|u|² elsewhere.
//! This is the cluster-robust covariance with the lines of one reference as clusters, its middle taken from the noise model in place of single
//! residuals: a mode two lines wide has no more than two of these.
//!
//! Source: K.-Y. Liang, S. L. Zeger, Longitudinal data analysis using generalized linear models, Biometrika 73, 1986 (covariance over clusters);
//! C. R. Rao, Estimation of variance and covariance components, J. Multivariate Anal. 1, 1971 (quadratic estimates of components).

use super::IdentifyError;
use super::band::Band;
use super::basis::{Basis, data, row_weights, weigh};
use super::fitted::{Common, Fit, model};
use retune_linalg::{Complex, DMatrix, DVector, thin_qr};
use std::rc::Rc;

/// Lines from which s is estimated: those where the common noise is seen best.
const LINES: usize = 160;

/// Lines kept in the factors of a mode; the others enter by their share of the sum.
const KEPT: usize = 256;

/// One output, weighted and scaled to unit noise.
struct Output {
    /// Orthonormal basis of the linear part.
    q1: Rc<DMatrix<f64>>,
    /// Derivative to the unknowns, projected off the linear part, over σ (rows x unknowns).
    jacobian: DMatrix<f64>,
    /// Rows of the shapes in the pseudo-inverse (2 modes x rows), times σ: from unit noise to ψ.
    inverse: DMatrix<f64>,
}

/// The factorisation that outputs with the same weights share.
struct Factored {
    q1: Rc<DMatrix<f64>>,
    /// Q2 R22 in the columns of D.
    projected: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

fn factor(matrix: &DMatrix<f64>, p: usize, n_modes: usize) -> Result<Factored, IdentifyError> {
    let mut a = matrix.clone();
    let n = a.ncols();
    let mut scale = vec![1.0; n];
    for (j, mut column) in a.column_iter_mut().enumerate() {
        let norm = column.norm();
        if norm > 0.0 {
            scale[j] = norm;
            column /= norm;
        }
    }
    let qr = thin_qr(&a)?;
    let q1 = qr.q.columns(0, p).into_owned();
    let mut projected = qr.q.columns(p, n - p) * qr.r.view((p, p), (n - p, n - p));
    for j in 0..n - p {
        projected.column_mut(j).scale_mut(scale[p + j]);
    }
    let mut inverse = q1.transpose();
    if !qr.r.view((0, 0), (p, p)).solve_upper_triangular_mut(&mut inverse) {
        return Err(IdentifyError::Singular { what: "equations of the mode shapes" });
    }
    let mut inverse = inverse.rows(0, 2 * n_modes).into_owned();
    for (j, mut row) in inverse.row_iter_mut().enumerate() {
        row.scale_mut(1.0 / scale[j]);
    }
    Ok(Factored { q1: Rc::new(q1), projected, inverse })
}

/// Everything that both passes need of a fit.
struct Frame<'a> {
    band: &'a Band,
    fit: &'a Fit,
    matrix: DMatrix<f64>,
    p: usize,
    back: f64,
    shared: Option<Factored>,
}

impl Frame<'_> {
    fn output(&self, o: usize) -> Result<Output, IdentifyError> {
        let own;
        let factored = match &self.shared {
            Some(shared) => shared,
            None => {
                let mut matrix = self.matrix.clone();
                if let Some(w) = row_weights(self.band, o) {
                    weigh(&mut matrix, &w);
                }
                own = factor(&matrix, self.p, self.fit.poles.len())?;
                &own
            }
        };
        let sigma = self.fit.sigma[o].max(f64::MIN_POSITIVE);
        let unknowns = self.fit.poles.unknowns();
        let mut jacobian = DMatrix::zeros(factored.projected.nrows(), 2 * unknowns.len());
        for (q, &(r, _)) in unknowns.iter().enumerate() {
            let psi = self.fit.shapes[(o, r)] / (self.back * sigma);
            let (d1, d2) = (factored.projected.column(2 * q), factored.projected.column(2 * q + 1));
            jacobian.set_column(2 * q, &(d1 * psi.re + d2 * psi.im));
            jacobian.set_column(2 * q + 1, &(d2 * psi.re - d1 * psi.im));
        }
        let inverse = &factored.inverse * (self.back * sigma);
        Ok(Output { q1: factored.q1.clone(), jacobian, inverse })
    }
}

/// Two rows of a matrix that belong to one line, times a complex pattern as a 2 x 2 matrix: [[re, -im], [im, re]].
fn times_pattern(rows: [f64; 2], u: Complex<f64>) -> [f64; 2] {
    [rows[0] * u.re + rows[1] * u.im, -rows[0] * u.im + rows[1] * u.re]
}

/// The covariance of a fit with the noise that the channels of each reference have in common; `None` where there is none.
pub(super) fn common_noise(band: &Band, fit: &Fit) -> Result<Option<Common>, IdentifyError> {
    let (n_l, n_i, n_o) = (band.n_lines(), band.n_inputs(), band.n_outputs());
    let unknowns = fit.poles.unknowns();
    let d = 2 * unknowns.len();
    if n_o < 2 || d == 0 || fit.covariance.iter().any(|x| !x.is_finite()) {
        return Ok(None);
    }
    let n_k = n_l * n_i;
    let basis = Basis { band, poles: &fit.poles, terms: fit.terms, omega_ref: fit.omega_ref };
    let (matrix, p) = (basis.matrix(true), basis.n_linear());
    let y = data(band, 0..n_o);
    // Patterns and residuals, unit noise.
    let (mut u, mut r) = (Vec::with_capacity(n_o), Vec::with_capacity(n_o));
    for o in 0..n_o {
        let weights = row_weights(band, o);
        let sigma = fit.sigma[o].max(f64::MIN_POSITIVE);
        let (mut pattern, mut left) = (Vec::with_capacity(n_k), Vec::with_capacity(n_k));
        for i in 0..n_i {
            for (l, omega) in band.omega.iter().enumerate() {
                let row = 2 * (i * n_l + l);
                let w = weights.as_ref().map_or(1.0, |w| w[row]) / sigma;
                let h = model(fit, band.order, n_i, o, i, Complex::new(0.0, *omega));
                pattern.push(h * w);
                left.push((Complex::new(y[(row, o)], y[(row + 1, o)]) - h) * w);
            }
        }
        u.push(pattern);
        r.push(left);
    }
    let g: Vec<f64> = (0..n_k).map(|k| u.iter().map(|u| u[k].norm_sqr()).sum()).collect();
    let fourth: Vec<f64> = (0..n_k).map(|k| u.iter().map(|u| u[k].norm_sqr().powi(2)).sum()).collect();
    let is_shared = band.variance.is_none();
    let shared = if is_shared {
        let mut weighted = matrix.clone();
        if let Some(w) = row_weights(band, 0) {
            weigh(&mut weighted, &w);
        }
        Some(factor(&weighted, p, fit.poles.len())?)
    } else {
        None
    };
    let frame = Frame { band, fit, matrix, p, back: fit.omega_ref.powi(1 - band.order), shared };
    // H⁻¹ of the scaled unknowns.
    let unit = |k: usize| if unknowns[k / 2].1.is_none() { fit.omega_ref } else { 1.0 };
    let inverse_h = DMatrix::from_fn(d, d, |a, b| fit.covariance[(a, b)] / (unit(a) * unit(b)));

    // First pass: what the fit takes out of the common pattern.
    let chosen: Vec<Vec<usize>> = (0..n_i)
        .map(|i| {
            let mut lines: Vec<usize> = (i * n_l..(i + 1) * n_l).collect();
            lines.sort_by(|a, b| g[*b].total_cmp(&g[*a]));
            lines.truncate(LINES);
            lines
        })
        .collect();
    // Σ_o J_oᵀ u_o per line, and its square summed over single outputs.
    let mut joint = DMatrix::zeros(d, 2 * n_k);
    let mut single = vec![0.0; n_k];
    let mut taken: Vec<DMatrix<f64>> = chosen.iter().map(|c| DMatrix::zeros(2 * c.len(), 2 * c.len())).collect();
    for o in 0..n_o {
        let output = frame.output(o)?;
        let mut own = DMatrix::zeros(d, 2 * n_k);
        for k in 0..n_k {
            for q in 0..d {
                let v = times_pattern([output.jacobian[(2 * k, q)], output.jacobian[(2 * k + 1, q)]], u[o][k]);
                (own[(q, 2 * k)], own[(q, 2 * k + 1)]) = (v[0], v[1]);
            }
        }
        let scaled = &inverse_h * &own;
        for (k, s) in single.iter_mut().enumerate() {
            *s += own.column(2 * k).dot(&scaled.column(2 * k)) + own.column(2 * k + 1).dot(&scaled.column(2 * k + 1));
        }
        joint += own;
        for (lines, taken) in chosen.iter().zip(&mut taken) {
            let x = DMatrix::from_fn(p, 2 * lines.len(), |c, j| {
                let k = lines[j / 2];
                times_pattern([output.q1[(2 * k, c)], output.q1[(2 * k + 1, c)]], u[o][k])[j % 2]
            });
            *taken += x.tr_mul(&x);
        }
    }
    let influence = &inverse_h * &joint;
    let mut variance = vec![0.0; n_i];
    for (i, lines) in chosen.iter().enumerate() {
        let n = lines.len();
        let pick = |m: &DMatrix<f64>| DMatrix::from_fn(d, 2 * n, |q, j| m[(q, 2 * lines[j / 2] + j % 2)]);
        let mut m = -(&taken[i] + pick(&joint).tr_mul(&pick(&influence)));
        for (j, k) in lines.iter().enumerate() {
            m[(2 * j, 2 * j)] += g[*k];
            m[(2 * j + 1, 2 * j + 1)] += g[*k];
        }
        let square = &m * &m;
        let rows: Vec<[f64; 4]> = lines
            .iter()
            .enumerate()
            .map(|(j, &k)| {
                let sum: Complex<f64> = (0..n_o).map(|o| u[o][k].conj() * r[o][k]).sum();
                let own: f64 = (0..n_o).map(|o| u[o][k].norm_sqr() * r[o][k].norm_sqr()).sum();
                let all = joint.column(2 * k).dot(&influence.column(2 * k))
                    + joint.column(2 * k + 1).dot(&influence.column(2 * k + 1));
                let kept = 0.5 * (m[(2 * j, 2 * j)] + m[(2 * j + 1, 2 * j + 1)]) / g[k].max(f64::MIN_POSITIVE);
                let per_s = square[(2 * j, 2 * j)] + square[(2 * j + 1, 2 * j + 1)] - 2.0 * kept * kept * fourth[k];
                // q, its mean without common noise, its mean per s², its variance without.
                let spread = 4.0 * kept * kept * (g[k] * g[k] - fourth[k]).max(0.0);
                [sum.norm_sqr() - own, single[k] - all, per_s.max(0.0), spread]
            })
            .collect();
        let (mut s2, mut sd) = (0.0_f64, f64::INFINITY);
        for _ in 0..6 {
            let (mut q, mut per, mut v) = (0.0, 0.0, 0.0);
            for (row, &k) in rows.iter().zip(lines) {
                let weight = (1.0 + s2 * g[k]).powi(-2);
                q += weight * (row[0] - row[1]);
                per += weight * row[2];
                v += weight * weight * row[3];
            }
            if per <= 0.0 {
                s2 = 0.0;
                break;
            }
            (s2, sd) = ((q / per).max(0.0), v.sqrt() / per);
        }
        variance[i] = if s2 > sd { s2 } else { 0.0 };
    }
    if variance.iter().all(|v| *v == 0.0) {
        return Ok(None);
    }

    // What is left to the independent noise.
    let kappa: Vec<Vec<f64>> = u
        .iter()
        .map(|u| {
            let shares: Vec<f64> = (0..n_k).map(|k| variance[k / n_l] * u[k].norm_sqr()).collect();
            if is_shared {
                let mean = shares.iter().sum::<f64>() / n_k as f64;
                vec![(1.0 - mean).max(0.02); n_k]
            } else {
                shares.iter().map(|s| (1.0 - s).max(0.02)).collect()
            }
        })
        .collect();
    let root: Vec<f64> = variance.iter().map(|v| v.sqrt()).collect();

    // Second pass: covariances.
    let n_modes = fit.poles.len();
    let mut middle = DMatrix::zeros(d, d);
    let mut local = vec![vec![[0.0; 3]; n_o]; n_modes];
    let lines = kept_lines(&influence, &unknowns, n_modes, n_l, &variance);
    let mut shapes: Vec<DMatrix<f64>> = lines.iter().map(|(c, _)| DMatrix::zeros(2 * n_o, 2 * c.len())).collect();
    let theta: Vec<DMatrix<f64>> = lines
        .iter()
        .map(|(columns, factor)| {
            DMatrix::from_fn(d, 2 * columns.len(), |q, j| {
                let k = columns[j / 2];
                influence[(q, 2 * k + j % 2)] * unit(q) * root[k / n_l] * factor
            })
        })
        .collect();
    for o in 0..n_o {
        let output = frame.output(o)?;
        let mut weighted = output.jacobian.clone();
        for (k, share) in kappa[o].iter().enumerate() {
            for part in 0..2 {
                weighted.row_mut(2 * k + part).scale_mut(*share);
            }
        }
        middle += output.jacobian.tr_mul(&weighted);
        for (r, (columns, factor)) in lines.iter().enumerate() {
            let [rr, ri, ii] = &mut local[r][o];
            for (k, share) in kappa[o].iter().enumerate() {
                for row in [2 * k, 2 * k + 1] {
                    let (re, im) = (output.inverse[(2 * r, row)], output.inverse[(2 * r + 1, row)]);
                    *rr += share * re * re;
                    *ri += share * re * im;
                    *ii += share * im * im;
                }
            }
            for (j, &k) in columns.iter().enumerate() {
                for part in 0..2 {
                    let row = [output.inverse[(2 * r + part, 2 * k)], output.inverse[(2 * r + part, 2 * k + 1)]];
                    let v = times_pattern(row, u[o][k]);
                    for c in 0..2 {
                        shapes[r][(2 * o + part, 2 * j + c)] += v[c] * root[k / n_l] * factor;
                    }
                }
            }
        }
    }
    for (r, shape) in shapes.iter_mut().enumerate() {
        *shape += &fit.slope[r] * &theta[r];
    }
    let mut white = &inverse_h * middle * &inverse_h;
    for a in 0..d {
        for b in 0..d {
            white[(a, b)] *= unit(a) * unit(b);
        }
    }
    let (mut expected, mut spread) = (vec![0.0; n_l], vec![0.0; n_l]);
    for k in 0..n_k {
        let s2 = variance[k / n_l];
        let (mut own, mut own_squared, mut cross) = (0.0, 0.0, 0.0);
        for o in 0..n_o {
            own += kappa[o][k];
            own_squared += kappa[o][k].powi(2);
            cross += kappa[o][k] * u[o][k].norm_sqr();
        }
        expected[k % n_l] += 2.0 * (own + s2 * g[k]);
        spread[k % n_l] += 4.0 * (own_squared + 2.0 * s2 * cross + (s2 * g[k]).powi(2));
    }
    Ok(Some(Common { white, local, theta, shapes, expected, spread }))
}

/// Per mode: the lines whose common noise moves its unknowns most, and the factor that makes up for the others.
fn kept_lines(
    influence: &DMatrix<f64>,
    unknowns: &[(usize, Option<usize>)],
    n_modes: usize,
    n_l: usize,
    variance: &[f64],
) -> Vec<(Vec<usize>, f64)> {
    let n_k = influence.ncols() / 2;
    (0..n_modes)
        .map(|r| {
            let own: Vec<usize> = (0..unknowns.len()).filter(|&q| unknowns[q].0 == r).collect();
            let energy: DVector<f64> = DVector::from_fn(n_k, |k, _| {
                let columns = [2 * k, 2 * k + 1];
                let sum: f64 = own
                    .iter()
                    .flat_map(|q| [2 * q, 2 * q + 1])
                    .flat_map(|row| columns.map(|c| influence[(row, c)].powi(2)))
                    .sum();
                sum * variance[k / n_l]
            });
            let mut order: Vec<usize> = (0..n_k).collect();
            order.sort_by(|a, b| energy[*b].total_cmp(&energy[*a]).then(a.cmp(b)));
            order.truncate(KEPT);
            let kept: f64 = order.iter().map(|&k| energy[k]).sum();
            let factor = if kept > 0.0 { (energy.sum() / kept).sqrt() } else { 1.0 };
            (order, factor)
        })
        .collect()
}
