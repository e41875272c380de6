//! What measured damping ratios say of the damping of a structure whose model has none.
//!
//! The answer on stiffness and mass stands; ratios are read at its fit, where damping is light and a law of it is linear in its sizes:
//!
//! ```text
//! ζ_i = Σ_j t_j a_ij + e_i,    a_ij = φ_iᵀ C_j φ_i / (2 ω_i) over its mean of all modes,    t_j ≥ 0
//! t_j ~ half-normal(1 %),    e_i ~ N(0, sd_i² + (τ ζ_i)²),    τ = 0, 5, 10, 20, 40 % with equal odds
//! ```
//!
//! t is what a term adds to the mean ratio. A law is one ratio for all modes, one placed effect of damping ([`retune::effect::Effect::damps`]), both, or Rayleigh's:
//! mass and stiffness of the whole structure. Ratios of real joints scatter about every simple law by far more than a test states, so that τ is
//! marginalised: else the law of most terms would win. Where a dashpot sits is told by ratios only as far as modes differ there; complex shapes
//! and functions tell more.
//!
//! # Source
//! S. Adhikari, Damping models for structural vibration, 2000; M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, 1995.

use super::error::DiagnosisError;
use super::problem::evidence::ln_sum;
use super::problem::scene::{Case, Scene};
use super::screen::stage::Stage;
use super::thresholds::NINETY;
use rayon::prelude::*;
use retune::effect::Candidate;
use retune::linalg::DMatrix;
use retune::model::ParametricModel;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Modes with a ratio, at least: two are explained by any law.
const FEWEST: usize = 3;
/// Scale of the prior of a term: what it adds to the mean ratio. Metal structures have some tenths of a per cent, bolted and bonded ones some per cent
/// (Adhikari, table 1.1).
const TYPICAL_RATIO: f64 = 0.01;
/// Scatter of ratios about a law, relative.
const SCATTERS: [f64; 5] = [0.0, 0.05, 0.1, 0.2, 0.4];
/// Points of the integral over a second term.
const POINTS: usize = 201;
/// Laws that are listed.
const LISTED: usize = 6;

/// What measured damping ratios say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DampingReading {
    /// The answer in a sentence.
    pub sentence: String,
    /// Relative scatter of the ratios about the best law, beside the stated standard deviations.
    pub scatter: f64,
    /// Laws by descending probability.
    pub laws: Vec<DampingLaw>,
    /// The ratios, and what the best law makes of them.
    pub modes: Vec<DampedMode>,
}

/// A law of damping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DampingLaw {
    /// `constant`, `stiffness-damping@left_wing`, or two of these with a plus sign.
    pub id: String,
    /// Its terms.
    pub terms: Vec<DampingTerm>,
    /// Among all laws that were tried.
    pub probability: f64,
    /// ln of its Bayes factor against one ratio for all modes.
    pub ln_bayes: f64,
    /// Σ ((law - test)/σ)² by the stated standard deviations.
    pub misfit: f64,
}

/// One term of a law of damping.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DampingTerm {
    /// `constant`, or an effect as `add` takes it.
    pub id: String,
    /// The ratio, or the size of the effect.
    pub value: f64,
    /// 90 % interval of `value`.
    pub interval: [f64; 2],
    /// Unit of `value`.
    pub unit: String,
    /// What it adds to the mean ratio.
    pub mean_ratio: f64,
    /// Effects that have the same share of every mode, so that ratios do not tell them apart.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alike: Vec<String>,
}

/// A mode with a measured damping ratio.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DampedMode {
    /// The mode, from 1, through all tests.
    pub mode: usize,
    /// Hz, measured.
    pub frequency_hz: f64,
    /// Measured.
    pub ratio: f64,
    /// Standard deviation of `ratio`.
    pub sd: f64,
    /// By the best law.
    pub by_law: f64,
}

impl DampingTerm {
    /// Whether it is one ratio for all modes, and no effect.
    pub fn is_ratio(&self) -> bool {
        self.id == CONSTANT
    }
}

/// Id of one ratio for all modes.
const CONSTANT: &str = "constant";

/// A paired mode with a ratio.
struct Mode {
    number: usize,
    frequency_hz: f64,
    ratio: f64,
    sd: f64,
    omega: f64,
}

/// Paired modes of all tests, and their shapes on the rows of the model, test by test.
struct Seen {
    modes: Vec<Mode>,
    shapes: Vec<DMatrix<f64>>,
}

/// Something that damps: its part of each ratio at a size, over the mean of all.
struct Term {
    id: String,
    a: Vec<f64>,
    /// Size of the effect per part of the mean ratio.
    size: f64,
    unit: String,
    /// Whether it damps every mode as the mass or the stiffness of the whole structure does.
    is_whole: bool,
    /// Ids of what has the same share of every mode.
    alike: Vec<String>,
}

/// Shares of all modes that differ by less are the same.
const SAME: f64 = 1e-3;

/// Mean ratio that a placed effect of its typical size gives the modes, at least: below, they do not move it but for rounding.
const LEAST: f64 = 1e-9;

/// Terms of one law.
type Law<'a> = Vec<&'a Term>;

/// What the ratios say, where the model has no damping and enough paired modes have one.
///
/// # Errors
/// The model cannot be solved at its fit.
pub(super) fn read(base: &Stage) -> Result<Option<DampingReading>, DiagnosisError> {
    let scene = &base.scene;
    if scene.is_damped {
        return Ok(None);
    }
    let theta = &base.fit.theta;
    let seen = seen(scene, theta)?;
    let modes = &seen.modes;
    if modes.len() < FEWEST {
        return Ok(None);
    }
    let laws_of_whole =
        [|omega: f64| omega, f64::recip].map(|law| over_mean(modes.iter().map(|m| law(m.omega)).collect()).1);
    let damps = base.screened.iter().map(|s| &s.candidate).filter(|c| c.effect.damps());
    let mut candidates: Vec<Candidate> = damps.cloned().collect();
    // Of what is alike the whole structure is named, then pairs before their partners.
    candidates.sort_by_key(|c| !c.location.names.is_empty());
    scene.place(&candidates);
    let placed = candidates.par_iter().filter_map(|c| term(scene, theta, &seen, &laws_of_whole, c)).collect();
    let placed = told_apart(placed);
    let constant = Term {
        id: CONSTANT.into(),
        a: vec![1.0; modes.len()],
        size: 1.0,
        unit: String::new(),
        is_whole: true,
        alike: Vec::new(),
    };
    let (laws, ln_priors) = laws(&constant, &placed);
    let y: Vec<f64> = modes.iter().map(|m| m.ratio).collect();
    let tried: Vec<Tried> = laws.par_iter().map(|law| Tried::new(law, modes, &y)).collect();
    let posterior: Vec<f64> = tried.iter().zip(&ln_priors).map(|(t, p)| t.ln_z + p).collect();
    let total = ln_sum(&posterior);
    let mut order: Vec<usize> = (0..laws.len()).collect();
    order.sort_by(|&a, &b| posterior[b].total_cmp(&posterior[a]));
    let law = |&i: &usize| DampingLaw {
        id: laws[i].iter().map(|t| t.id.as_str()).collect::<Vec<_>>().join(" + "),
        terms: tried[i].terms(&laws[i]),
        probability: (posterior[i] - total).exp(),
        ln_bayes: tried[i].ln_z - tried[0].ln_z,
        misfit: tried[i].misfit,
    };
    let best = order[0];
    let by_law = modes.iter().enumerate().map(|(i, m)| DampedMode {
        mode: m.number + 1,
        frequency_hz: m.frequency_hz,
        ratio: m.ratio,
        sd: m.sd,
        by_law: laws[best].iter().zip(&tried[best].t).map(|(term, t)| t * term.a[i]).sum(),
    });
    let scatter = tried[best].scatter;
    let laws: Vec<DampingLaw> = order.iter().take(LISTED).map(law).collect();
    let sentence = sentence(&laws, scatter, modes.len());
    Ok(Some(DampingReading { sentence, scatter, laws, modes: by_law.collect() }))
}

fn seen(scene: &Scene, theta: &[f64]) -> Result<Seen, DiagnosisError> {
    let (mut modes, mut shapes) = (Vec::new(), Vec::new());
    for (case, comparison) in scene.cases.iter().zip(scene.comparisons()?) {
        let prediction = comparison.predict(theta)?;
        let mut columns = Vec::new();
        for (m, mode) in case.test.modes.iter().enumerate() {
            let (Some(ratio), Some(elastic)) = (&mode.damping_ratio, prediction.partner(m)) else { continue };
            let column = prediction.modes.n_rigid + elastic;
            let omega = prediction.modes.lambda[column].max(0.0).sqrt();
            if omega > 0.0 && ratio.sd > 0.0 {
                columns.push(column);
                let (number, frequency_hz) = (case.first_mode + m, mode.frequency_hz.value);
                modes.push(Mode { number, frequency_hz, ratio: ratio.value, sd: ratio.sd, omega });
            }
        }
        let own = prediction.modes.shapes.select_columns(&columns);
        shapes.push(match &case.stand_in {
            Some(stand_in) => stand_in.expanded(&own),
            None => own,
        });
    }
    Ok(Seen { modes, shapes })
}

/// The mean of some values, and the values over it.
fn over_mean(mut values: Vec<f64>) -> (f64, Vec<f64>) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    for value in &mut values {
        *value /= mean;
    }
    (mean, values)
}

/// A placed effect at its typical size; nothing where it damps none of these modes.
///
/// * `of_whole` - shares of the modes where the stiffness or the mass of the whole structure damps
fn term(scene: &Scene, theta: &[f64], seen: &Seen, of_whole: &[Vec<f64>; 2], candidate: &Candidate) -> Option<Term> {
    let [parameter] = candidate.parameters.as_slice() else { return None };
    let sizes = candidate.typical();
    let of = |(case, shapes): (&Case, &DMatrix<f64>)| {
        if shapes.ncols() == 0 {
            return Some(Vec::new());
        }
        let own = theta.get(..case.model.parameters().len())?;
        scene.change(case, candidate)?.damping_of(own, &sizes, shapes).ok()
    };
    let work: Vec<f64> = scene.cases.iter().zip(&seen.shapes).map(of).collect::<Option<Vec<_>>>()?.concat();
    let (mean, a) = over_mean(work.iter().zip(&seen.modes).map(|(c, m)| c / (2.0 * m.omega)).collect());
    (mean.is_finite() && mean > LEAST).then(|| Term {
        id: candidate.id(),
        is_whole: candidate.location.names.is_empty() || of_whole.iter().any(|law| is_same(&a, law)),
        a,
        size: (parameter.typical - parameter.neutral) / mean,
        unit: parameter.unit.clone(),
        alike: Vec::new(),
    })
}

fn is_same(a: &[f64], b: &[f64]) -> bool {
    let largest = a.iter().chain(b).fold(0.0_f64, |m, v| m.max(v.abs()));
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME * largest)
}

/// Terms of the same share of every mode as one, what damps the whole structure first.
fn told_apart(mut terms: Vec<Term>) -> Vec<Term> {
    terms.sort_by_key(|t| !t.is_whole);
    let mut out: Vec<Term> = Vec::new();
    for term in terms {
        match out.iter_mut().find(|known| is_same(&known.a, &term.a)) {
            Some(known) => known.alike.push(term.id),
            None => out.push(term),
        }
    }
    out
}

/// One ratio first; then what damps the whole structure, alone and two at once; then every place, alone and beside one ratio. Laws of the whole
/// structure have odds of one each, places of one together, alone and beside a ratio.
fn laws<'a>(constant: &'a Term, placed: &'a [Term]) -> (Vec<Law<'a>>, Vec<f64>) {
    let (whole, local): (Vec<&Term>, Vec<&Term>) = placed.iter().partition(|t| t.is_whole);
    let mut all: Vec<Law<'a>> = vec![vec![constant]];
    all.extend(whole.iter().map(|t| vec![*t]));
    for (i, a) in whole.iter().enumerate() {
        all.extend(whole[i + 1..].iter().map(|b| vec![*a, *b]));
    }
    let n_whole = all.len();
    all.extend(local.iter().flat_map(|t| [vec![*t], vec![constant, *t]]));
    let places = |t: &Term| (1 + t.alike.len()) as f64;
    let n_places: f64 = local.iter().map(|t| places(t)).sum();
    let of_place = local.iter().flat_map(|t| [(places(t) / n_places).ln(); 2]);
    let ln_priors = std::iter::repeat_n(0.0, n_whole).chain(of_place).collect();
    (all, ln_priors)
}

/// A law against the ratios.
struct Tried {
    ln_z: f64,
    scatter: f64,
    /// Parts of the mean ratio, and their standard deviations.
    t: Vec<f64>,
    sd: Vec<f64>,
    misfit: f64,
}

impl Tried {
    fn new(law: &Law<'_>, modes: &[Mode], y: &[f64]) -> Self {
        let a: Vec<&[f64]> = law.iter().map(|t| &t.a[..]).collect();
        let variance = |m: &Mode, tau: f64| m.sd * m.sd + (tau * m.ratio).powi(2);
        let at = |tau: f64| {
            let w: Vec<f64> = modes.iter().map(|m| variance(m, tau).recip()).collect();
            let none: f64 = y.iter().zip(&w).map(|(y, w)| 0.5 * (w.ln() - y * y * w)).sum();
            none + ln_evidence(y, &w, &a)
        };
        let each: Vec<f64> = SCATTERS.iter().map(|tau| at(*tau)).collect();
        let best = (0..each.len()).max_by(|&i, &j| each[i].total_cmp(&each[j])).unwrap_or(0);
        let w: Vec<f64> = modes.iter().map(|m| variance(m, SCATTERS[best]).recip()).collect();
        let (t, sd) = estimate(y, &w, &a);
        let left = |(i, m): (usize, &Mode)| {
            let by_law: f64 = a.iter().zip(&t).map(|(a, t)| t * a[i]).sum();
            ((by_law - m.ratio) / m.sd).powi(2)
        };
        let misfit = modes.iter().enumerate().map(left).sum();
        Self { ln_z: ln_sum(&each) - (SCATTERS.len() as f64).ln(), scatter: SCATTERS[best], t, sd, misfit }
    }

    fn terms(&self, law: &Law<'_>) -> Vec<DampingTerm> {
        let term = |((term, t), sd): ((&&Term, &f64), &f64)| DampingTerm {
            id: term.id.clone(),
            value: t * term.size,
            interval: [(t - NINETY * sd).max(0.0), t + NINETY * sd].map(|t| t * term.size),
            unit: term.unit.clone(),
            mean_ratio: *t,
            alike: term.alike.clone(),
        };
        law.iter().zip(&self.t).zip(&self.sd).map(term).collect()
    }
}

/// Mean and variance of the size of one term with its prior, not cut at zero.
fn uncut(y: &[f64], w: &[f64], a: &[f64]) -> (f64, f64) {
    let square: f64 = a.iter().zip(w).map(|(a, w)| a * a * w).sum();
    let along: f64 = a.iter().zip(w).zip(y).map(|((a, w), y)| a * w * y).sum();
    let variance = (square + TYPICAL_RATIO.powi(-2)).recip();
    (variance * along, variance)
}

/// ln of ∫ p(y | t) p(t) dt over t ≥ 0, over p(y | 0).
fn ln_evidence(y: &[f64], w: &[f64], a: &[&[f64]]) -> f64 {
    match a {
        [one] => {
            let (mean, variance) = uncut(y, w, one);
            let (sd, normal) = (variance.sqrt(), Normal::standard());
            // Far below zero the share of the positive side is too small for a number.
            let share = normal.cdf(mean / sd).max(1e-300);
            2_f64.ln() + (sd / TYPICAL_RATIO).ln() + 0.5 * mean * mean / variance + share.ln()
        }
        [one, other] => {
            let without = |t: f64| -> Vec<f64> { y.iter().zip(*other).map(|(y, a)| y - t * a).collect() };
            let ln_prior = |t: f64| {
                -0.5 * (t / TYPICAL_RATIO).powi(2) - (TYPICAL_RATIO * (0.5 * std::f64::consts::PI).sqrt()).ln()
            };
            let none = |y: &[f64]| -> f64 { y.iter().zip(w).map(|(y, w)| -0.5 * y * y * w).sum() };
            let base = none(y);
            let at = |t: f64| {
                let rest = without(t);
                ln_prior(t) + none(&rest) - base + ln_evidence(&rest, w, &[one])
            };
            let (t, sd) = estimate(y, w, a);
            let (low, high) = ((t[1] - 8.0 * sd[1]).max(0.0), t[1] + 8.0 * sd[1]);
            let step = (high - low) / (POINTS - 1) as f64;
            // Simpson's rule.
            let weight = |i: usize| match i {
                0 => 1.0,
                i if i == POINTS - 1 => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0_f64,
            };
            let points: Vec<f64> =
                (0..POINTS).map(|i| (weight(i) * step / 3.0).ln() + at(low + step * i as f64)).collect();
            ln_sum(&points)
        }
        _ => 0.0,
    }
}

/// The most probable sizes of one or two terms, none below zero, and their standard deviations: of two, each with the other free where that is above
/// zero.
fn estimate(y: &[f64], w: &[f64], a: &[&[f64]]) -> (Vec<f64>, Vec<f64>) {
    let alone = |k: usize| {
        let (mean, variance) = uncut(y, w, a[k]);
        (mean.max(0.0), variance.sqrt())
    };
    let [one, other] = a else {
        let (mean, sd) = alone(0);
        return (vec![mean], vec![sd]);
    };
    let dot = |u: &[f64], v: &[f64]| -> f64 { u.iter().zip(v).zip(w).map(|((u, v), w)| u * v * w).sum() };
    let prior = TYPICAL_RATIO.powi(-2);
    let (h11, h22, h12) = (dot(one, one) + prior, dot(other, other) + prior, dot(one, other));
    let (g1, g2) = (dot(one, y), dot(other, y));
    let determinant = h11 * h22 - h12 * h12;
    let t = [(h22 * g1 - h12 * g2) / determinant, (h11 * g2 - h12 * g1) / determinant];
    match t {
        [t1, t2] if t1 >= 0.0 && t2 >= 0.0 => {
            (vec![t1, t2], vec![(h22 / determinant).sqrt(), (h11 / determinant).sqrt()])
        }
        [t1, _] if t1 < 0.0 => {
            let (mean, sd) = alone(1);
            (vec![0.0, mean], vec![h11.sqrt().recip(), sd])
        }
        _ => {
            let (mean, sd) = alone(0);
            (vec![mean, 0.0], vec![sd, h22.sqrt().recip()])
        }
    }
}

fn sentence(laws: &[DampingLaw], scatter: f64, n: usize) -> String {
    let [best, ..] = laws else { return String::new() };
    let per_cent = |v: f64| format!("{:.2} %", 100.0 * v);
    let about = if scatter > 0.0 {
        format!("; the ratios scatter about it by some {:.0} %, beside what the test states", 100.0 * scatter)
    } else {
        String::new()
    };
    let what = match best.terms.as_slice() {
        [only] if only.is_ratio() => {
            let [low, high] = only.interval.map(per_cent);
            format!("one ratio of {} ({low} ... {high}) for all modes", per_cent(only.value))
        }
        terms => {
            let term = |t: &DampingTerm| {
                let name = if t.is_ratio() { "one ratio for all modes" } else { &t.id };
                let or = match t.alike.as_slice() {
                    [] => String::new(),
                    [other] => format!(" or {other}"),
                    others => format!(" or one of {} others with the same share of every mode", others.len()),
                };
                format!("{name}{or} ({} on average)", per_cent(t.mean_ratio))
            };
            terms.iter().map(term).collect::<Vec<_>>().join(" and ")
        }
    };
    if best.probability > 0.5 {
        let write = match best.terms.as_slice() {
            [only] if only.is_ratio() => format!("; `modal_damping: {}` gives it to the model", per_cent(only.value)),
            _ => String::new(),
        };
        format!("the {n} measured damping ratios speak for {what}{about}{write}")
    } else {
        let next = laws.get(1).map_or_else(String::new, |l| format!("; {} comes next", l.id));
        format!(
            "the {n} measured damping ratios do not tell laws of damping apart: {what} is most probable{next}{about}"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(i: usize, ratio: f64, sd: f64) -> Mode {
        let frequency_hz = 10.0 * (i + 1) as f64;
        let omega = std::f64::consts::TAU * frequency_hz;
        Mode { number: i, frequency_hz, ratio, sd, omega }
    }

    fn term(id: &str, a: &[f64], is_whole: bool) -> Term {
        let mean = a.iter().sum::<f64>() / a.len() as f64;
        Term {
            id: id.into(),
            a: a.iter().map(|v| v / mean).collect(),
            size: 1.0,
            unit: String::new(),
            is_whole,
            alike: Vec::new(),
        }
    }

    /// ∫∫ by brute force on a fine grid.
    #[test]
    fn evidence_is_the_integral_over_positive_sizes() {
        let (y, w) = ([0.004, 0.011, 0.007], [1e6, 3e5, 5e5]);
        let (a, b) = ([0.5, 1.5, 1.0], [1.6, 0.4, 1.0]);
        let n = 4000;
        let step = 0.06 / f64::from(n);
        let prior =
            |t: f64| (-0.5 * (t / TYPICAL_RATIO).powi(2)).exp() / (TYPICAL_RATIO * (0.5 * std::f64::consts::PI).sqrt());
        let ratio = |t: f64, u: f64| -> f64 {
            let left = |i: usize| -0.5 * w[i] * ((y[i] - t * a[i] - u * b[i]).powi(2) - y[i] * y[i]);
            (0..3).map(left).sum::<f64>().exp()
        };
        let at = |i: i32| (f64::from(i) + 0.5) * step;
        let one: f64 = (0..n).map(|i| prior(at(i)) * ratio(at(i), 0.0) * step).sum();
        assert!((ln_evidence(&y, &w, &[&a]) - one.ln()).abs() < 1e-6);
        let both: f64 = (0..n)
            .map(|i| (0..n).map(|j| prior(at(j)) * ratio(at(i), at(j)) * step).sum::<f64>() * prior(at(i)) * step)
            .sum();
        assert!((ln_evidence(&y, &w, &[&a, &b]) - both.ln()).abs() < 1e-4);
    }

    /// The law that made the ratios is the most probable one: one ratio, Rayleigh's, a dashpot beside a ratio.
    #[test]
    fn the_law_that_made_the_ratios_leads() {
        let omegas: Vec<f64> = (1..=6).map(f64::from).collect();
        let constant = term("constant", &[1.0; 6], true);
        let mut placed = vec![
            term("mass-damping@whole", &omegas.iter().map(|o| o.recip()).collect::<Vec<_>>(), true),
            term("stiffness-damping@whole", &omegas, true),
        ];
        for n in 1..=3 {
            let shape = |i: usize| {
                (f64::from(n) * (i + 1) as f64 * std::f64::consts::FRAC_PI_6).sin().powi(2) / (i + 1) as f64 + 1e-4
            };
            placed.push(term(&format!("ground-dashpot@n{n}.uz"), &(0..6).map(shape).collect::<Vec<_>>(), false));
        }
        let noise = [0.3, -0.5, 0.9, -0.2, -1.1, 0.4];
        for (parts, expected) in [
            (vec![(&constant, 0.008)], "constant"),
            (vec![(&placed[0], 0.004), (&placed[1], 0.006)], "mass-damping@whole + stiffness-damping@whole"),
            (vec![(&constant, 0.004), (&placed[3], 0.008)], "constant + ground-dashpot@n2.uz"),
        ] {
            let ratio = |i: usize| -> f64 { parts.iter().map(|(t, s)| s * t.a[i]).sum() };
            let modes: Vec<Mode> = (0..6)
                .map(|i| {
                    let sd = 0.03 * ratio(i);
                    mode(i, ratio(i) + noise[i] * sd, sd)
                })
                .collect();
            let y: Vec<f64> = modes.iter().map(|m| m.ratio).collect();
            let (laws, priors) = laws(&constant, &placed);
            let score = |i: usize| Tried::new(&laws[i], &modes, &y).ln_z + priors[i];
            let best = (0..laws.len()).max_by(|&i, &j| score(i).total_cmp(&score(j))).unwrap();
            let id = laws[best].iter().map(|t| t.id.as_str()).collect::<Vec<_>>().join(" + ");
            assert_eq!(id, expected);
            let tried = Tried::new(&laws[best], &modes, &y);
            for (t, (_, s)) in tried.t.iter().zip(&parts) {
                assert!((t / s - 1.0).abs() < 0.1, "{t} {s}");
            }
        }
    }
}
