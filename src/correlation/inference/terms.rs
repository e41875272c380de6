//! What is known of one pair: its frequency and its shape beside what parameters and model form may do to them.

use super::{Form, LEAST_FREQUENCY_SD, LEAST_SHAPE_SD, Measured, Modelled};
use crate::linalg::{DMatrix, DVector};
use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, TAU};

/// Coupling of two modes by an error of the model, as a share of the relative error τ of their frequencies.
pub(super) const COUPLING: f64 = 0.35;
/// Modes of the model that may mix into one, the most coupled ones.
const MIXED: usize = 12;
/// Standard deviation of a shape that states none, of its largest entry.
const SHAPE_SD: f64 = 0.03;
/// The angle by which parameters may turn a shape in all, rad: beyond it their linear columns promise what the model cannot do, and
/// with many parameters they would make any shape of any other.
const TURN: f64 = 0.3;
/// The angle to which the noise of a shape and errors of the model in no direction of their own amount at most, root mean square over
/// all entries, rad: shapes that are farther apart are not alike, however large the noise.
const ASTRAY: f64 = 0.6;
/// With the shape of its partner and so many standard deviations off, a frequency counts as noted wrongly.
const MISREAD: f64 = 6.0;

/// What is known of one pair, before model form and spread.
#[derive(Debug, Clone)]
pub(super) struct Terms {
    frequency: Frequency,
    /// 2 ρ √(λ_a λ_b)/|λ_a - λ_b| of every mode that may mix into a.
    couplings: Vec<f64>,
    /// The columns [P J_u | P φ_b/|φ_a| | P y], each row over its standard deviation.
    shape: Option<(DMatrix<f64>, ShapeNoise)>,
    label: f64,
}

/// The same with what the parameters may do in at most one column more than there are sensors.
#[derive(Debug, Clone)]
pub(super) struct Spread {
    frequency: Frequency,
    couplings: Vec<f64>,
    /// Products of the columns.
    shape: Option<(DMatrix<f64>, ShapeNoise)>,
    pub(super) label: f64,
}

/// The frequencies of a pair.
#[derive(Debug, Clone)]
struct Frequency {
    /// (ln f_i - ln f_a)/s_f, and what the parameters do to it.
    z: f64,
    slope: DVector<f64>,
    /// s_f.
    sd: f64,
}

/// How well a shape is known.
#[derive(Debug, Clone, Copy)]
struct ShapeNoise {
    /// Number of sensors, and Σ ln s over them.
    n: f64,
    ln_sd: f64,
    /// Largest factor of the noise.
    most: f64,
}

impl ShapeNoise {
    /// k.
    fn factor(&self, form: Form) -> f64 {
        form.k.min(self.most)
    }
}

/// Rows, entries over their length, and standard deviations of these.
pub(super) type Unit = (Vec<usize>, DVector<f64>, DVector<f64>);

/// Measured entries of a shape with the rows they stand in, over their length, and their standard deviations.
pub(super) fn unit(mode: &Measured<'_>) -> Option<Unit> {
    let shape = mode.shape?;
    let rows: Vec<usize> = (0..shape.len()).filter(|&i| shape[i].is_finite()).collect();
    let y = DVector::from_iterator(rows.len(), rows.iter().map(|&i| shape[i]));
    let (length, largest) = (y.norm(), y.amax());
    if rows.len() < 2 || length <= 0.0 {
        return None;
    }
    let sd = |&i: &usize| {
        let stated = mode.shape_sd.map_or(SHAPE_SD * largest, |sd| sd[i]);
        stated.max(LEAST_SHAPE_SD * largest) / length
    };
    let sd = DVector::from_iterator(rows.len(), rows.iter().map(sd));
    Some((rows, y / length, sd))
}

/// Share of foreign modes that move one sensor alone: what it is glued to, its cable, an instrument beside it.
const LOCAL: f64 = 0.2;
/// By how much more than by their noise the others may move then.
const BESIDE: [f64; 3] = [1.0, 2.0, 4.0];

/// ln of the density of a shape that is of no mode of the model: any direction, or one sensor alone.
pub(super) fn ln_of_none((rows, y, sd): &Unit) -> f64 {
    let n = rows.len() as f64;
    let isotropic = (1.0 - LOCAL).ln() + ln_gamma(0.5 * n) - 0.5 * n * PI.ln();
    let share = (LOCAL / (n * BESIDE.len() as f64)).ln();
    let alone = |j: usize, k: f64| -> f64 {
        let others = (0..y.len()).filter(|&i| i != j);
        share - others.map(|i| 0.5 * (y[i] / (k * sd[i])).powi(2) + (k * sd[i] * TAU.sqrt()).ln()).sum::<f64>()
    };
    let all: Vec<f64> =
        BESIDE.iter().flat_map(|&k| (0..y.len()).map(move |j| (j, k))).map(|(j, k)| alone(j, k)).collect();
    let most = all.iter().copied().fold(isotropic, f64::max);
    most + all.iter().chain([&isotropic]).map(|l| (l - most).exp()).sum::<f64>().ln()
}

impl Terms {
    pub(super) fn new(m: &Measured<'_>, u: Option<&Unit>, modelled: &[Modelled], a: usize) -> Self {
        let own = &modelled[a];
        let p = own.d_ln_f.len();
        let sd = (m.frequency.1 / m.frequency.0).max(LEAST_FREQUENCY_SD);
        let z = (m.frequency.0 / own.frequency).ln() / sd;
        let coupling = |b: usize| {
            let (la, lb) = (own.frequency.powi(2), modelled[b].frequency.powi(2));
            2.0 * COUPLING * (la * lb).sqrt() / (la - lb).abs().max(f64::MIN_POSITIVE)
        };
        let mut others: Vec<usize> = (0..modelled.len()).filter(|&b| b != a).collect();
        others.sort_by(|&b, &c| coupling(c).total_cmp(&coupling(b)));
        others.truncate(MIXED);
        let label = match (m.label, &own.label) {
            (Some(measured), Some(model)) => measured.ln_odds(model),
            _ => 0.0,
        };
        let frequency = Frequency { z, slope: &own.d_ln_f / sd, sd };
        let mut out = Self { frequency, couplings: Vec::new(), shape: None, label };
        let Some((rows, y, s)) = u else { return out };
        let at = |v: &DVector<f64>| DVector::from_iterator(rows.len(), rows.iter().map(|&r| v[r]));
        let phi = at(&own.shape);
        let length = phi.norm();
        out.couplings = others.iter().map(|&b| coupling(b)).collect();
        let unit = if length > 0.0 { &phi / length } else { phi.clone() };
        let cosine = unit.dot(y);
        let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
        let n = rows.len();
        let mut columns = DMatrix::zeros(n, p + others.len() + 1);
        let mut put = |k: usize, v: DVector<f64>| {
            let along = unit.dot(&v);
            let tangent = (v - &unit * along).component_div(s);
            columns.set_column(k, &tangent);
        };
        if length > 0.0 {
            for j in 0..p {
                put(j, at(&own.d_shape.column(j).into_owned()) * (cosine.abs() / length));
            }
            for (k, &b) in others.iter().enumerate() {
                put(p + k, at(&modelled[b].shape) * (cosine.abs() / length));
            }
        }
        put(p + others.len(), y * sign);
        let ln_sd: f64 = s.iter().map(|v| v.ln()).sum();
        let n = n as f64;
        let most = (ASTRAY / ((ln_sd / n).exp() * (n - 1.0).sqrt())).max(1.0);
        out.shape = Some((columns, ShapeNoise { n, ln_sd, most }));
        out
    }

    /// With columns of C^½ instead of those of the parameters, where they turn the shape by [`TURN`] at most.
    ///
    /// There are as many as rows, at most: with A the columns, frequency first, and Aᵀ = Q R, A Aᵀ is Rᵀ R.
    pub(super) fn spread(&self, spread: &DMatrix<f64>) -> Spread {
        let p = spread.ncols();
        let n = self.shape.as_ref().map_or(0, |(columns, _)| columns.nrows());
        let mut a = DMatrix::zeros(1 + n, p);
        a.row_mut(0).tr_copy_from(&spread.tr_mul(&self.frequency.slope));
        if let Some((columns, noise)) = &self.shape {
            let mut own = columns.columns(0, p) * spread;
            // The columns stand over the standard deviation of an entry.
            let turn = own.norm() * (noise.ln_sd / noise.n).exp();
            if turn > TURN {
                own *= TURN / turn;
            }
            a.rows_mut(1, n).copy_from(&own);
        }
        if p > 1 + n {
            a = a.transpose().qr().r().transpose();
        }
        let frequency = Frequency { slope: a.row(0).transpose(), ..self.frequency };
        let shape = self.shape.as_ref().map(|(columns, noise)| {
            let rest = columns.columns(p, columns.ncols() - p);
            let mut all = DMatrix::zeros(n, a.ncols() + rest.ncols());
            all.columns_mut(0, a.ncols()).copy_from(&a.rows(1, n));
            all.columns_mut(a.ncols(), rest.ncols()).copy_from(&rest);
            (all.tr_mul(&all), *noise)
        });
        Spread { frequency, couplings: self.couplings.clone(), shape, label: self.label }
    }

    /// JᵀV⁻¹J and JᵀV⁻¹z, V of noise and model form.
    pub(super) fn normal_equations(&self, form: Form, may_be_misread: bool) -> (DMatrix<f64>, DVector<f64>) {
        let Frequency { z, slope, sd } = &self.frequency;
        let p = slope.len();
        // V of the frequency is 1 + (τ/s)².
        let mut over_f = 1.0 / (1.0 + (form.tau / sd).powi(2));
        if may_be_misread && self.shape.is_some() && z * z * over_f > MISREAD * MISREAD {
            over_f = 0.0;
        }
        let mut h = slope * slope.transpose() * over_f;
        let mut g = slope * (z * over_f);
        let Some((columns, noise)) = &self.shape else { return (h, g) };
        let over = noise.factor(form).powi(-2);
        let mixing = DVector::from_vec(mixing(&self.couplings, form));
        let m = mixing.len();
        let gram = columns.tr_mul(columns);
        let jj = gram.view((0, 0), (p, p)).into_owned() * over;
        let jz = gram.view((0, p + m), (p, 1)).column(0).into_owned() * over;
        let scale = DMatrix::from_diagonal(&mixing);
        let jw = gram.view((0, p), (p, m)) * &scale * over;
        let wz = &scale * gram.view((p, p + m), (m, 1)).column(0) * over;
        let ww = DMatrix::identity(m, m) + &scale * gram.view((p, p), (m, m)) * &scale * over;
        let Some(factor) = ww.cholesky() else { return (h, g) };
        h += jj - &jw * factor.solve(&jw.transpose());
        g += jz - &jw * factor.solve(&wz);
        (h, g)
    }
}

/// c_ab.
fn mixing(couplings: &[f64], form: Form) -> Vec<f64> {
    couplings.iter().map(|c| (c * form.tau).min(1.0)).collect()
}

impl Spread {
    /// Whether there is a shape.
    pub(super) fn has_shape(&self) -> bool {
        self.shape.is_some()
    }

    /// Whether the frequencies are more than some standard deviations apart at a model form.
    pub(super) fn is_beyond(&self, deviations: f64, tau: f64) -> bool {
        let Frequency { z, slope, sd } = &self.frequency;
        let variance = 1.0 + (tau / sd).powi(2) + slope.norm_squared();
        z * z > deviations * deviations * variance
    }

    /// ln of the density of ln f_i that decays with the distance of the frequencies (Laplace), whatever noise and parameters say.
    ///
    /// * `mean` - of |ln f_i/f_a|
    pub(super) fn ln_far(&self, mean: f64) -> f64 {
        -(self.frequency.z * self.frequency.sd).abs() / mean - (2.0 * mean).ln()
    }

    /// ln p of the pair; without its frequency where `of_frequency` is not set.
    pub(super) fn ln_density(&self, form: Form, of_frequency: bool) -> f64 {
        let Frequency { z, slope, sd } = &self.frequency;
        let p = slope.len();
        let mixing = mixing(&self.couplings, form);
        let q = p + mixing.len() + 1;
        let mut a = DMatrix::identity(q, q);
        let mut b = DVector::zeros(q);
        let (mut square, mut ln_norm) = (0.0, 0.0);
        if of_frequency {
            // Columns: parameters, mixing, model form in frequency.
            let mut of_f = DVector::zeros(q);
            of_f.rows_mut(0, p).copy_from(slope);
            of_f[q - 1] = form.tau / sd;
            a += &of_f * of_f.transpose();
            b += &of_f * *z;
            square += z * z;
            ln_norm -= (sd * TAU.sqrt()).ln();
        }
        if let Some((gram, noise)) = &self.shape {
            let k = noise.factor(form);
            let over = 1.0 / (k * k);
            let scale = |i: usize| if i < p { 1.0 } else { mixing[i - p] };
            let last = q - 1;
            for j in 0..last {
                for i in 0..last {
                    a[(i, j)] += scale(i) * scale(j) * gram[(i, j)] * over;
                }
                b[j] += scale(j) * gram[(j, last)] * over;
            }
            square += gram[(last, last)] * over;
            let per_sensor = noise.ln_sd / noise.n + (k * TAU.sqrt()).ln();
            ln_norm -= (noise.n - 1.0) * per_sensor;
        }
        let Some(factor) = a.cholesky() else { return f64::NEG_INFINITY };
        let ln_det: f64 = 2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>();
        let chi2 = square - b.dot(&factor.solve(&b));
        -0.5 * chi2.max(0.0) - 0.5 * ln_det + ln_norm
    }
}
