//! From functions to modes: the workflow.

use super::IdentifyError;
use super::band::Band;
use super::fit::{Fit, Poles, ResidualTerms, choose_terms, fit};
use super::mode::{IdentifiedMode, modes};
use super::plscf::{Pole, poles_by_order};
use super::stabilisation::{Stability, StabilisationDiagram, mac};
use crate::data::FrfSet;
use crate::linalg::{Complex, DMatrix};
use std::f64::consts::TAU;

/// Steps of the fit; Gauss-Newton from pLSCF poles needs three to six.
const MAX_STEPS: usize = 40;

/// How lines are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weighting {
    /// By the variance that the coherence implies, where the set has coherences; else equally.
    #[default]
    Coherence,
    /// All lines of a channel alike.
    Equal,
}

/// Settings of [`identify`].
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyOptions {
    /// Limits of the band, Hz; all lines when absent.
    pub band_hz: Option<(f64, f64)>,
    /// Poles of the highest model order, conjugates counted: at least twice the modes in the band, four times is good.
    pub max_order: usize,
    /// The rules of the stabilisation diagram.
    pub stability: Stability,
    /// Terms for modes outside the band; chosen by an information criterion when absent.
    pub residual_terms: Option<ResidualTerms>,
    /// Weights of the lines.
    pub weighting: Weighting,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            band_hz: None,
            max_order: 60,
            stability: Stability::default(),
            residual_terms: None,
            weighting: Weighting::default(),
        }
    }
}

/// A stable column that is not a mode after all.
#[derive(Debug, Clone, PartialEq)]
pub struct Discarded {
    /// Where, Hz.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// Why.
    pub reason: &'static str,
}

/// The result of an identification.
#[derive(Debug, Clone)]
pub struct Identification {
    /// Modes by ascending frequency.
    pub modes: Vec<IdentifiedMode>,
    /// The stabilisation diagram behind them.
    pub diagram: StabilisationDiagram,
    /// Columns of the diagram that the fit rejected.
    pub discarded: Vec<Discarded>,
    /// Terms used for modes outside the band.
    pub residual_terms: ResidualTerms,
    /// Residual noise sd of each response (root mean square over references), in the unit of the FRF (per real part);
    /// NaN where the response was not fitted.
    pub noise_sd: Vec<f64>,
    /// Root mean square of each response over the band, in the unit of the FRF.
    pub rms: Vec<f64>,
    /// Whether the fit converged.
    pub is_converged: bool,
    fit: Option<Fit>,
    band: Band,
}

/// Identifies the modes of a structure from its frequency response functions.
///
/// 1. Poles by pLSCF for model orders up to `max_order` (see the sources in `plscf`).
/// 2. Columns of the stabilisation diagram that come back at the next orders are candidates.
/// 3. All candidates are fitted to all functions by maximum likelihood; candidates that leave the band, coincide with
///    another, are not determined by the data (sd of the damping above half of it, sd of the frequency above the half
///    bandwidth), or explain less than their own number of unknowns is worth (Bayesian information criterion), go.
///
/// No mode found is a result, not an error; `diagram` then shows why.
///
/// # Errors
/// A set whose lengths disagree, a band without enough lines, no function measured in full.
pub fn identify(frfs: &FrfSet, options: &IdentifyOptions) -> Result<Identification, IdentifyError> {
    check(options)?;
    let band = Band::select(frfs, options.band_hz, options.weighting)?;
    let orders = orders(&band, options.max_order)?;
    let diagram = StabilisationDiagram::build(&orders, poles_by_order(&band, &orders)?, &options.stability);
    let mut candidates: Vec<(Pole, usize)> = diagram
        .chosen
        .iter()
        .filter_map(|&c| Some((diagram.representative(c)?.clone(), diagram.column(c).count())))
        .collect();
    let mut discarded = Vec::new();
    let mut terms = options.residual_terms.unwrap_or(ResidualTerms { lower: 2, upper: 2 });
    let mut fitted: Option<Fit> = None;
    let mut is_term_choice_open = options.residual_terms.is_none();
    while !candidates.is_empty() {
        let poles = Poles::new(&candidates.iter().map(|c| c.0.clone()).collect::<Vec<_>>());
        let steps = if is_term_choice_open { 3 } else { MAX_STEPS };
        let result = match fit(&band, &poles, terms, steps) {
            Ok(result) => result,
            Err(IdentifyError::Singular { .. } | IdentifyError::TooFewLines { .. }) => {
                // Two candidates are one, or there are more unknowns than lines: the least persistent one goes.
                let weakest = (0..candidates.len()).min_by_key(|&c| candidates[c].1).unwrap_or(0);
                discard(&mut discarded, &candidates.remove(weakest).0, "cannot be told from another candidate");
                continue;
            }
            Err(e) => return Err(e),
        };
        for (c, (pole, _)) in candidates.iter_mut().enumerate() {
            pole.value = result.poles.values[c];
            pole.participation.clone_from(&result.poles.participation[c]);
        }
        if is_term_choice_open {
            terms = choose_terms(&band, &result.poles)?;
            is_term_choice_open = false;
            continue;
        }
        let verdicts = verdicts(&band, &result, &candidates, &options.stability);
        let n_bad = verdicts.iter().flatten().count();
        if n_bad == 0 {
            fitted = Some(result);
            break;
        }
        let mut verdict = verdicts.into_iter();
        candidates.retain(|(pole, _)| match verdict.next().flatten() {
            Some(reason) => {
                discard(&mut discarded, pole, reason);
                false
            }
            None => true,
        });
    }
    let n_orders: Vec<usize> = candidates.iter().map(|c| c.1).collect();
    let found = fitted.as_ref().map(|f| modes(frfs, &band, f, &n_orders)).unwrap_or_default();
    let (noise_sd, rms) = levels(frfs, &band, fitted.as_ref());
    Ok(Identification {
        modes: found,
        diagram,
        discarded,
        residual_terms: terms,
        noise_sd,
        rms,
        is_converged: fitted.as_ref().is_none_or(|f| f.is_converged),
        fit: fitted,
        band,
    })
}

fn discard(list: &mut Vec<Discarded>, pole: &Pole, reason: &'static str) {
    list.push(Discarded { frequency_hz: pole.frequency_hz(), damping_ratio: pole.damping_ratio(), reason });
}

fn check(options: &IdentifyOptions) -> Result<(), IdentifyError> {
    let s = &options.stability;
    let range = |name: &'static str, value: f64, low: f64, high: f64, expected: &'static str| {
        if value > low && value <= high { Ok(()) } else { Err(IdentifyError::Option { name, value, expected }) }
    };
    range("stability.frequency", s.frequency, 0.0, 1.0, "above 0 and at most 1")?;
    range("stability.damping", s.damping, 0.0, f64::MAX, "above 0")?;
    range("stability.participation", s.participation, 0.0, 1.0, "above 0 and at most 1")?;
    range("stability.max_damping", s.max_damping, 0.0, 1.0, "above 0 and at most 1")?;
    range("stability.min_presence", s.min_presence, 0.0, 1.0, "above 0 and at most 1")?;
    // 400 poles are far above any use; the companion matrices grow with the square.
    range("max_order", options.max_order as f64, 3.0, 400.0, "between 4 and 400")?;
    if let Some(t) = options.residual_terms {
        range("residual_terms.lower", t.lower as f64, -1.0, 6.0, "at most 6")?;
        range("residual_terms.upper", t.upper as f64, -1.0, 6.0, "at most 6")?;
    }
    Ok(())
}

/// Degrees of A(z): every second one for one input, every one for several, as far as the lines allow.
fn orders(band: &Band, max_order: usize) -> Result<Vec<usize>, IdentifyError> {
    let n_i = band.n_inputs();
    let top = (max_order / n_i).max(2).min(band.n_lines() / 3);
    if top < 2 {
        return Err(IdentifyError::TooFewLines { found: band.n_lines(), needed: 6 });
    }
    Ok((2..=top).step_by(if n_i == 1 { 2 } else { 1 }).collect())
}

/// For each candidate: why it is not a mode, if it is not.
fn verdicts(band: &Band, fit: &Fit, candidates: &[(Pole, usize)], stability: &Stability) -> Vec<Option<&'static str>> {
    let n = candidates.len();
    let unknowns = fit.poles.unknowns();
    let (low, high) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let rows = (2 * band.n_lines() * band.n_inputs() * band.n_outputs()) as f64;
    let price = 2.0 * (band.n_outputs() + band.n_inputs()) as f64 * rows.ln();
    let mut out: Vec<Option<&'static str>> = (0..n)
        .map(|r| {
            let p = fit.poles.values[r];
            let (omega, zeta) = (p.norm(), -p.re / p.norm());
            if omega < low || omega > high {
                return Some("lies outside the band");
            }
            if zeta > stability.max_damping {
                return Some("is damped more than a mode may be");
            }
            let k = 2 * unknowns.iter().position(|&u| u == (r, None)).unwrap_or(0);
            let factor = fit.inflation[r];
            let (sd_re, sd_im) = (fit.covariance[(k, k)].sqrt() * factor, fit.covariance[(k + 1, k + 1)].sqrt() * factor);
            if sd_re.is_nan() || sd_im.is_nan() || sd_re > -0.5 * p.re || sd_im > -p.re {
                return Some("is not determined by the data");
            }
            // Wald statistic of the whole shape, at fixed poles.
            let gain: f64 = (0..band.n_outputs())
                .map(|o| {
                    let (x, [a, b, d]) = (fit.shapes[(o, r)], fit.local[r][o]);
                    let det = a * d - b * b;
                    if det > 0.0 { (d * x.re * x.re - 2.0 * b * x.re * x.im + a * x.im * x.im) / det } else { 0.0 }
                })
                .sum();
            (gain / (factor * factor) < price).then_some("explains no more than noise would")
        })
        .collect();
    for a in 0..n {
        for b in 0..a {
            if out[a].is_some() || out[b].is_some() {
                continue;
            }
            let (pa, pb) = (fit.poles.values[a], fit.poles.values[b]);
            let shape = |r: usize| fit.shapes.column(r).iter().copied().collect::<Vec<_>>();
            // A tenth of the bandwidth apart with one shape: one resonance split in two by the fit.
            if (pa - pb).norm() < -0.1 * (pa.re + pb.re) && mac(&shape(a), &shape(b)) > 0.9 {
                let weaker = if candidates[a].1 < candidates[b].1 { a } else { b };
                out[weaker] = Some("doubles another candidate");
            }
        }
    }
    out
}

fn levels(frfs: &FrfSet, band: &Band, fit: Option<&Fit>) -> (Vec<f64>, Vec<f64>) {
    let n = frfs.responses.len();
    let (mut noise, mut power, mut count) = (vec![0.0; n], vec![0.0; n], vec![0.0_f64; n]);
    let n_l = band.n_lines() as f64;
    for (k, &o) in band.outputs.iter().enumerate() {
        for (j, &i) in band.inputs.iter().enumerate() {
            let response = if band.is_transposed { i } else { o };
            let scale = band.variance_of(k, j).map_or(1.0, |v| (v.iter().sum::<f64>() / n_l).sqrt());
            let sd = fit.map_or(f64::NAN, |f| f.sigma[k] * scale);
            noise[response] += sd * sd;
            power[response] += band.function(k, j).iter().map(Complex::norm_sqr).sum::<f64>() / n_l;
            count[response] += 1.0;
        }
    }
    let root = |x: Vec<f64>| x.iter().zip(&count).map(|(x, c)| (x / c).sqrt()).collect();
    (root(noise), root(power))
}

impl Identification {
    /// The functions of the fitted model at any frequencies, in the quantity of the test, layout of [`FrfSet`]'s `h`; NaN for
    /// functions that were not fitted, zero everywhere when no mode was found.
    pub fn synthesise(&self, frequencies_hz: &[f64], n_references: usize, n_responses: usize) -> Vec<Complex<f64>> {
        let nan = Complex::new(f64::NAN, f64::NAN);
        let mut h = vec![nan; frequencies_hz.len() * n_references * n_responses];
        let (band, n_i) = (&self.band, self.band.n_inputs());
        for (line, f) in frequencies_hz.iter().enumerate() {
            let s = Complex::new(0.0, TAU * f);
            for (k, &o) in band.outputs.iter().enumerate() {
                for (j, &i) in band.inputs.iter().enumerate() {
                    let (response, reference) = if band.is_transposed { (i, o) } else { (o, i) };
                    if response < n_responses && reference < n_references {
                        let value = self.fit.as_ref().map_or(Complex::new(0.0, 0.0), |fit| model(fit, band.order, n_i, k, j, s));
                        h[(line * n_references + reference) * n_responses + response] = value;
                    }
                }
            }
        }
        h
    }

    /// Complex shapes of all modes at the responses (responses x modes).
    pub fn shapes(&self) -> DMatrix<Complex<f64>> {
        let n = self.modes.first().map_or(0, |m| m.shape.len());
        DMatrix::from_fn(n, self.modes.len(), |o, r| self.modes[r].shape[o])
    }
}

fn model(fit: &Fit, order: i32, n_inputs: usize, output: usize, input: usize, s: Complex<f64>) -> Complex<f64> {
    let mut sum = Complex::new(0.0, 0.0);
    for r in 0..fit.poles.len() {
        let residue = fit.shapes[(output, r)] * fit.poles.participation[r][input];
        let lambda = fit.poles.values[r];
        sum += residue / (s - lambda) + residue.conj() / (s - lambda.conj());
    }
    let ResidualTerms { lower, upper } = fit.terms;
    let n_terms = fit.residuals.nrows() / n_inputs;
    let front = s.powi(order);
    let mut value = front * sum;
    for t in 0..n_terms {
        let k = if t < lower { -2 - t as i32 } else { (t - lower).min(upper) as i32 };
        // Together, so that the mass line of accelerance is finite at 0 Hz.
        value += (s / fit.omega_ref).powi(order + k) * fit.omega_ref.powi(order) * fit.residuals[(input * n_terms + t, output)];
    }
    value
}
