//! An identified mode, with a standard deviation behind every number.

use super::band::Band;
use super::complexity::{Complexity, complexity, real_shape};
use super::fitted::Fit;
use crate::data::{FrfSet, Measured};
use retune_linalg::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// A mode identified from frequency response functions.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedMode {
    /// Undamped natural frequency |λ|/2π, Hz.
    pub frequency_hz: Measured,
    /// Damping ratio -Re λ/|λ|.
    pub damping_ratio: Measured,
    /// λ, rad/s.
    pub pole: Complex<f64>,
    /// Complex shape at the responses, entry of largest modulus 1; NaN where it was not measured in full.
    pub shape: DVector<Complex<f64>>,
    /// Standard deviation of the real and of the imaginary part of each entry, the common scale left free.
    pub shape_sd: DVector<f64>,
    /// Modal participation at the references, entry of largest modulus 1; NaN where not measured in full.
    pub participation: DVector<Complex<f64>>,
    /// Standard deviation of its parts; 0 for a single reference.
    pub participation_sd: DVector<f64>,
    /// R: the residue of receptance at response o and reference i is `residue_scale * shape[o] * participation[i]`, m/(N s).
    pub residue_scale: Complex<f64>,
    /// Standard deviation of the residue of receptance (per part), (responses x references), m/(N s).
    pub residue_sd: DMatrix<f64>,
    /// Real normal shape, [`real_shape`] of `shape`; the imaginary part left over is in `complexity`.
    pub normal_shape: DVector<f64>,
    /// Its standard deviation, the common scale left free.
    pub normal_shape_sd: DVector<f64>,
    /// The normal shape scaled to unit modal mass, when a driving point was measured with a residue of the right sign.
    pub mass_normalised: Option<MassNormalised>,
    /// Complexity of the shape.
    pub complexity: Complexity,
    /// Factor already contained in every sd for misfit near the resonance; 1 where the residual is white noise.
    pub sd_inflation: f64,
    /// Number of model orders whose poles form the column of this mode.
    pub n_orders: usize,
}

/// A normal shape scaled to unit modal mass.
#[derive(Debug, Clone, PartialEq)]
pub struct MassNormalised {
    /// Shape, kg^-1/2.
    pub shape: DVector<f64>,
    /// Relative standard deviation of the common scale.
    pub scale_sd: f64,
    /// Index of the response and the reference that are the driving point.
    pub driving_point: (usize, usize),
}

impl IdentifiedMode {
    /// Residue of receptance, m/(N s).
    pub fn residue(&self, response: usize, reference: usize) -> Complex<f64> {
        self.residue_scale * self.shape[response] * self.participation[reference]
    }

    /// Modal constant 2iω_d R of receptance, 1/kg: the product φ_o φ_i of mass-normalised shapes when damping is
    /// proportional, so positive at a driving point.
    pub fn modal_constant(&self, response: usize, reference: usize) -> Complex<f64> {
        self.residue(response, reference) * Complex::new(0.0, 2.0 * self.pole.im)
    }
}

/// Pairs (response, reference, sign) at the same point along the same line.
///
/// Points are the same when their names are; directions, where both are known, must be parallel within 8 degrees
/// (cosine above 0.99), and the sign says whether they agree.
pub fn driving_points(frfs: &FrfSet) -> Vec<(usize, usize, f64)> {
    let mut found = Vec::new();
    for (i, reference) in frfs.references.iter().enumerate() {
        for (o, response) in frfs.responses.iter().enumerate() {
            if reference.name != response.name {
                continue;
            }
            match (reference.direction, response.direction) {
                (Some(a), Some(b)) => {
                    let cosine: f64 = a.iter().zip(&b).map(|(x, y)| x * y).sum();
                    if cosine.abs() > 0.99 {
                        found.push((o, i, cosine.signum()));
                    }
                }
                _ => found.push((o, i, 1.0)),
            }
        }
    }
    found
}

/// The modes `which` of a fit, with the number of orders of each column.
pub(super) fn modes(frfs: &FrfSet, band: &Band, fit: &Fit, which: &[usize], n_orders: &[usize]) -> Vec<IdentifiedMode> {
    let points = driving_points(frfs);
    which.iter().zip(n_orders).map(|(&r, &n)| mode(frfs, band, fit, r, n, &points)).collect()
}

fn mode(
    frfs: &FrfSet,
    band: &Band,
    fit: &Fit,
    r: usize,
    n_orders: usize,
    points: &[(usize, usize, f64)],
) -> IdentifiedMode {
    let unknowns = fit.poles.unknowns();
    let inflation = fit.inflation[r];
    let at_pole = unknowns.iter().position(|&u| u == (r, None)).unwrap_or(0);
    let lambda = fit.poles.values[r];
    // d|λ| = Re(λ* dλ)/|λ|;  ζ = -Re λ/|λ|: dζ = -(dRe + ζ d|λ|)/|λ|.
    let modulus = lambda.norm();
    let zeta = -lambda.re / modulus;
    let d_modulus = [lambda.re / modulus, lambda.im / modulus];
    let d_zeta = [-(1.0 + zeta * d_modulus[0]) / modulus, -zeta * d_modulus[1] / modulus];
    let block = fit.covariance.view((2 * at_pole, 2 * at_pole), (2, 2));
    let sd = |d: [f64; 2]| {
        (d[0] * d[0] * block[(0, 0)] + 2.0 * d[0] * d[1] * block[(0, 1)] + d[1] * d[1] * block[(1, 1)]).max(0.0).sqrt()
            * inflation
    };
    let measured = |value: f64, sd: f64| Measured { value, sd, sd_is_default: false };

    let psi: DVector<Complex<f64>> = fit.shapes.column(r).into_owned();
    let l = DVector::from_vec(fit.poles.participation[r].clone());
    let scale = psi.iter().copied().fold(Complex::new(0.0, 0.0), |a, x| if x.norm() > a.norm() { x } else { a });
    let scale = if scale.norm() > 0.0 { scale } else { Complex::new(1.0, 0.0) };
    let white = fit.common.as_ref().map_or(&fit.covariance, |c| &c.white);
    let local = fit.common.as_ref().map_or(&fit.local, |c| &c.local);
    let spread = scale_free(&psi, &local[r], &fit.slope[r], white, fit.common.as_ref().map(|c| &c.shapes[r]));
    let output_sd: Vec<f64> =
        spread.iter().map(|v| v[0].midpoint(v[2]).max(0.0).sqrt() * inflation / scale.norm()).collect();
    // Variance along the line of the shape: the real part after turning.
    let phase = Complex::from_polar(1.0, -complexity(&psi).mean_phase);
    let along: Vec<f64> = spread
        .iter()
        .map(|v| {
            let (c, s) = (phase.re, -phase.im);
            (c * c * v[0] + 2.0 * c * s * v[1] + s * s * v[2]).max(0.0).sqrt() * inflation / scale.norm()
        })
        .collect();
    let input_sd: Vec<f64> = (0..l.len())
        .map(|i| {
            unknowns.iter().position(|&u| u == (r, Some(i))).map_or(0.0, |k| {
                let c = &fit.covariance;
                c[(2 * k, 2 * k)].midpoint(c[(2 * k + 1, 2 * k + 1)]).sqrt() * inflation
            })
        })
        .collect();

    // Back to the channels of the set.
    let nan = Complex::new(f64::NAN, f64::NAN);
    let (n_res, n_ref) = (frfs.responses.len(), frfs.references.len());
    let (n_out, n_in) = if band.is_transposed { (n_ref, n_res) } else { (n_res, n_ref) };
    let mut outputs = DVector::from_element(n_out, nan);
    let mut outputs_sd = DVector::from_element(n_out, f64::NAN);
    let mut outputs_along = DVector::from_element(n_out, f64::NAN);
    for (k, &o) in band.outputs.iter().enumerate() {
        outputs[o] = psi[k] / scale;
        outputs_sd[o] = output_sd[k];
        outputs_along[o] = along[k];
    }
    let mut inputs = DVector::from_element(n_in, nan);
    let mut inputs_sd = DVector::from_element(n_in, f64::NAN);
    for (k, &i) in band.inputs.iter().enumerate() {
        inputs[i] = l[k];
        inputs_sd[i] = input_sd[k];
    }
    let mut residue_sd = DMatrix::from_element(n_res, n_ref, f64::NAN);
    for (k, &o) in band.outputs.iter().enumerate() {
        for (j, &i) in band.inputs.iter().enumerate() {
            let (response, reference) = if band.is_transposed { (i, o) } else { (o, i) };
            let entry = unknowns.iter().position(|&u| u == (r, Some(j)));
            residue_sd[(response, reference)] = residue_spread(fit, r, k, psi[k], l[j], entry) * inflation * band.scale;
        }
    }
    let (shape, shape_sd, participation, participation_sd) = if band.is_transposed {
        (inputs, inputs_sd, outputs, outputs_sd)
    } else {
        (outputs, outputs_sd, inputs, inputs_sd)
    };
    let normal_shape = real_shape(&shape);
    let normal_shape_sd = if band.is_transposed { shape_sd.clone() } else { outputs_along };
    let mut mode = IdentifiedMode {
        frequency_hz: measured(modulus / TAU, sd(d_modulus) / TAU),
        damping_ratio: measured(zeta, sd(d_zeta)),
        pole: lambda,
        complexity: complexity(if band.is_transposed { &participation } else { &shape }),
        shape,
        shape_sd,
        participation,
        participation_sd,
        residue_scale: scale * band.scale,
        residue_sd,
        normal_shape,
        normal_shape_sd,
        mass_normalised: None,
        sd_inflation: inflation,
        n_orders,
    };
    mode.mass_normalised = mass_normalised(&mode, points);
    mode
}

/// Covariances (rr, ri, ii) of the entries of ψ with the common complex scale projected out.
///
/// ```text
/// δψ -> (I - ψψᴴ/ψᴴψ) δψ,   cov δψ = blockdiag(local) + S C Sᵀ + F Fᵀ
/// ```
/// F, where there is one, holds what noise common to all channels does line by line.
fn scale_free(
    psi: &DVector<Complex<f64>>,
    local: &[[f64; 3]],
    slope: &DMatrix<f64>,
    c: &DMatrix<f64>,
    of_all: Option<&DMatrix<f64>>,
) -> Vec<[f64; 3]> {
    let n = psi.len();
    let norm = psi.norm();
    if norm <= 0.0 || c.iter().any(|x| !x.is_finite()) {
        return vec![[f64::INFINITY, 0.0, f64::INFINITY]; n];
    }
    // V spans the scale: ψ/|ψ| and iψ/|ψ| as real vectors.
    let v = DMatrix::from_fn(2 * n, 2, |k, j| {
        let x = psi[k / 2] / norm * if j == 0 { Complex::new(1.0, 0.0) } else { Complex::i() };
        if k % 2 == 0 { x.re } else { x.im }
    });
    let root = c.clone().cholesky().map_or_else(|| DMatrix::zeros(c.nrows(), c.ncols()), |x| x.l());
    let free = |common: DMatrix<f64>| &common - &v * v.tr_mul(&common);
    let common = free(slope * root);
    let of_all = of_all.map(|f| free(f.clone()));
    // local V, (2n x 2), and Vᵀ local V.
    let lv = DMatrix::from_fn(2 * n, 2, |k, j| {
        let s = local[k / 2];
        let (a, b) = (v[(k / 2 * 2, j)], v[(k / 2 * 2 + 1, j)]);
        if k % 2 == 0 { s[0] * a + s[1] * b } else { s[1] * a + s[2] * b }
    });
    let vlv = v.tr_mul(&lv);
    let vvlv = &v * vlv;
    (0..n)
        .map(|o| {
            let entry = |a: usize, b: usize, own: f64| {
                let (p, q) = (2 * o + a, 2 * o + b);
                let cross: f64 = (0..2).map(|j| lv[(p, j)] * v[(q, j)] + v[(p, j)] * lv[(q, j)]).sum();
                let inner: f64 = (0..2).map(|j| vvlv[(p, j)] * v[(q, j)]).sum();
                let lines = of_all.as_ref().map_or(0.0, |f| f.row(p).dot(&f.row(q)));
                own - cross + inner + common.row(p).dot(&common.row(q)) + lines
            };
            [entry(0, 0, local[o][0]), entry(0, 1, local[o][1]), entry(1, 1, local[o][2])]
        })
        .collect()
}

/// Sd of a residue ψ_o l_i, root mean square over its two parts.
fn residue_spread(fit: &Fit, r: usize, o: usize, psi: Complex<f64>, l: Complex<f64>, entry: Option<usize>) -> f64 {
    let n = fit.covariance.nrows();
    let slope = &fit.slope[r];
    // Rows of (Re, Im) of l δψ + ψ δl.
    let mut rows = DMatrix::from_fn(2, n, |part, k| {
        let d = Complex::new(slope[(2 * o, k)], slope[(2 * o + 1, k)]) * l;
        if part == 0 { d.re } else { d.im }
    });
    if let Some(k) = entry {
        rows[(0, 2 * k)] += psi.re;
        rows[(0, 2 * k + 1)] -= psi.im;
        rows[(1, 2 * k)] += psi.im;
        rows[(1, 2 * k + 1)] += psi.re;
    }
    let white = fit.common.as_ref().map_or(&fit.covariance, |c| &c.white);
    let mut common = (&rows * white * rows.transpose()).trace();
    if let Some(c) = &fit.common {
        // Of the common noise ψ has its own part beside that through the unknowns.
        let psi_part = c.shapes[r].rows(2 * o, 2);
        for j in 0..psi_part.ncols() {
            let mut value = Complex::new(psi_part[(0, j)], psi_part[(1, j)]) * l;
            if let Some(k) = entry {
                value += psi * Complex::new(c.theta[r][(2 * k, j)], c.theta[r][(2 * k + 1, j)]);
            }
            common += value.norm_sqr();
        }
    }
    let local = fit.common.as_ref().map_or(&fit.local, |c| &c.local)[r][o];
    let own = (local[0] + local[2]) * l.norm_sqr();
    common.midpoint(own).max(0.0).sqrt()
}

/// Scales by the driving point with the largest modal constant in units of its sd.
fn mass_normalised(mode: &IdentifiedMode, points: &[(usize, usize, f64)]) -> Option<MassNormalised> {
    let (o, i, constant, sd) = points
        .iter()
        .map(|&(o, i, sign)| {
            let sd = mode.residue_sd[(o, i)] * 2.0 * mode.pole.im;
            (o, i, sign * mode.modal_constant(o, i).re, sd)
        })
        .filter(|(_, _, c, sd)| c.is_finite() && *c > 2.0 * sd)
        .max_by(|a, b| (a.2 / a.3).total_cmp(&(b.2 / b.3)))?;
    let at = mode.normal_shape[o];
    (at != 0.0).then(|| MassNormalised {
        shape: &mode.normal_shape * (constant.sqrt() / at.abs()),
        scale_sd: ((0.5 * sd / constant).powi(2) + (mode.normal_shape_sd[o] / at).powi(2)).sqrt(),
        driving_point: (o, i),
    })
}
