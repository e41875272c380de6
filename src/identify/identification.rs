//! From functions to modes: the workflow.

use super::IdentifyError;
use super::band::Band;
use super::complexity::complexity;
use super::fit::{Fit, Poles, ResidualTerms, choose_terms, fit};
use super::mode::{IdentifiedMode, modes};
use super::plscf::{Pole, poles_by_order};
use super::scan::{LEAST_MPC, scan, threshold};
use super::stabilisation::{Stability, StabilisationDiagram, mac};
use crate::data::FrfSet;
use crate::linalg::{Complex, DMatrix};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Steps of the fit; Gauss-Newton from pLSCF poles needs three to six.
const MAX_STEPS: usize = 40;

/// Half width of the window in which a candidate of the scan is fitted, lines: thirty times its bandwidth at least.
const WINDOW: f64 = 64.0;

/// Most candidates that one scan may add in a piece: it is for the few that were missed.
const MAX_SCANNED: usize = 8;

/// How lines are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weighting {
    /// By the variance that the coherence implies, where the set has coherences; else equally.
    #[default]
    Coherence,
    /// All lines of a channel alike.
    Equal,
}

/// Into which pieces the band is cut; each is identified on its own with the others' modes as residual terms.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Segments {
    /// Octaves from the top of the band, as long as each has at least 128 lines: every piece then has its own noise level
    /// and a model order that fits it, and a strong mode at 700 Hz does not hide a weak one at 13 Hz.
    #[default]
    Octaves,
    /// The band in one piece.
    Whole,
    /// Cuts at these frequencies, Hz.
    At(Vec<f64>),
}

/// Least number of lines in an octave that becomes a piece of its own: some ten per unknown of a mode or two.
const LINES_PER_SEGMENT: usize = 128;

/// How far a piece looks beyond its ends, as a share of its width: modes near an end are then inside.
const OVERLAP: f64 = 0.25;

/// Settings of [`identify`].
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifyOptions {
    /// Limits of the band, Hz; all lines when absent.
    pub band_hz: Option<(f64, f64)>,
    /// Pieces of the band.
    pub segments: Segments,
    /// Poles of the highest model order of each piece, conjugates counted: at least twice the modes in it, four times is good.
    pub max_order: usize,
    /// The rules of the stabilisation diagram.
    pub stability: Stability,
    /// Terms for modes outside each piece; chosen by an information criterion when absent.
    pub residual_terms: Option<ResidualTerms>,
    /// Weights of the lines.
    pub weighting: Weighting,
}

impl Default for IdentifyOptions {
    fn default() -> Self {
        Self {
            band_hz: None,
            segments: Segments::default(),
            max_order: 40,
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

/// What was done in one piece of the band.
#[derive(Debug, Clone)]
pub struct Segment {
    /// Ends of the piece, Hz; the modes between them are its own.
    pub core_hz: (f64, f64),
    /// Its stabilisation diagrams, over the piece and its overlap: of the functions, then of what the first modes left.
    pub diagrams: Vec<StabilisationDiagram>,
    /// Columns of the diagram that the fit rejected.
    pub discarded: Vec<Discarded>,
    /// Terms used for modes outside.
    pub residual_terms: ResidualTerms,
    /// Residual noise sd of each response (root mean square over references), in the unit of the FRF (per real part);
    /// NaN where the response was not fitted or the piece holds no mode.
    pub noise_sd: Vec<f64>,
    /// Root mean square of each response over the piece, in the unit of the FRF.
    pub rms: Vec<f64>,
    /// Whether the fit converged.
    pub is_converged: bool,
    fit: Option<Fit>,
    band: Band,
}

/// The result of an identification.
#[derive(Debug, Clone)]
pub struct Identification {
    /// Modes by ascending frequency.
    pub modes: Vec<IdentifiedMode>,
    /// The pieces of the band, ascending.
    pub segments: Vec<Segment>,
}

/// Identifies the modes of a structure from its frequency response functions.
///
/// In each piece of the band (with an overlap):
///
/// 1. poles by pLSCF for model orders up to `max_order`;
/// 2. columns of the stabilisation diagram that come back at the next orders are candidates;
/// 3. all candidates are fitted to all functions by maximum likelihood; candidates that leave the piece, coincide with
///    another, are not determined by the data (sd of the damping above half of it, sd of the frequency above the half
///    bandwidth), or explain no more than noise could (chi-squared, chance 1e-3 anywhere in the piece), go.
///
/// A second round looks for stable columns in what the modes found so far leave over, so that a strong mode does not hide a
/// weak one; a third scans the remainder with a matched filter for sharp resonances of a few lines; a last one fits
/// every piece again with the poles of its neighbours known.
///
/// No mode found is a result, not an error; the diagrams then show why.
///
/// # Errors
/// A set whose lengths disagree, a band without enough lines, no function measured in full.
pub fn identify(frfs: &FrfSet, options: &IdentifyOptions) -> Result<Identification, IdentifyError> {
    check(options)?;
    let whole = Band::select(frfs, options.band_hz, options.weighting)?;
    let cores = cores(&whole, &options.segments)?;
    let mut known: Vec<Candidate> = Vec::new();
    let mut diagrams: Vec<Vec<StabilisationDiagram>> = vec![Vec::new(); cores.len()];
    let mut discarded: Vec<Vec<Discarded>> = vec![Vec::new(); cores.len()];
    for search in [Search::Data, Search::Remainder, Search::Scan, Search::None] {
        let found: Vec<Result<Piece, IdentifyError>> = (0..cores.len())
            .into_par_iter()
            .map(|k| piece(&whole, cores[k], k, &known, search, options))
            .collect();
        let pieces = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        let windows = known
            .par_iter()
            .filter_map(|c| Some(window(&whole, c, c.window?, &known, options)))
            .collect::<Result<Vec<_>, _>>()?;
        known = merge(pieces.iter().chain(&windows).flat_map(|p| p.candidates.iter().cloned()));
        for (k, p) in pieces.iter().enumerate() {
            diagrams[k].extend(p.diagram.clone());
            discarded[k].extend(p.discarded.iter().cloned());
        }
        if matches!(search, Search::None) {
            return Ok(finish(frfs, &cores, (pieces, windows), diagrams, discarded));
        }
    }
    Ok(Identification { modes: Vec::new(), segments: Vec::new() })
}

/// Where a round looks for new poles.
#[derive(Clone, Copy, PartialEq)]
enum Search {
    /// In the functions themselves.
    Data,
    /// In what the modes found so far leave: a mode that a stronger one hid.
    Remainder,
    /// In the remainder again, with a matched filter for weak and sharp resonances.
    Scan,
    /// Nowhere: the last fit, with every mode of every piece known.
    None,
}

/// A pole on its way to become a mode.
#[derive(Debug, Clone)]
struct Candidate {
    pole: Pole,
    n_orders: usize,
    piece: usize,
    /// Half width, rad/s, of the window of its own in which a candidate of the scan is fitted: the broad misfit of stronger
    /// modes would otherwise draw a weak one away from its few lines.
    window: Option<f64>,
}

impl Candidate {
    /// Whether the fit of piece `index` has this pole as an unknown.
    fn belongs_to(&self, index: usize) -> bool {
        self.piece == index && self.window.is_none()
    }
}

/// The work on one piece in one round.
struct Piece {
    band: Band,
    diagram: Option<StabilisationDiagram>,
    candidates: Vec<Candidate>,
    discarded: Vec<Discarded>,
    terms: ResidualTerms,
    fit: Option<Fit>,
}

fn piece(
    whole: &Band,
    core: (f64, f64),
    index: usize,
    known: &[Candidate],
    search: Search,
    options: &IdentifyOptions,
) -> Result<Piece, IdentifyError> {
    let reach = OVERLAP * (core.1 - core.0);
    let band = whole.part(TAU * (core.0 - reach), TAU * (core.1 + reach));
    let (low, high) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let neighbours = neighbours(known, low, high, |c| c.belongs_to(index));
    let own: Vec<Candidate> = known.iter().filter(|c| c.belongs_to(index)).cloned().collect();
    let mut work = Work { band: band.clone(), neighbours: neighbours.clone(), options, discarded: Vec::new() };
    let is_inside = |p: &Pole| {
        let grace = -0.5 * p.value.re;
        p.value.norm() >= TAU * core.0 - grace && p.value.norm() <= TAU * core.1 + grace
    };
    let (mut candidates, mut terms, mut fit) = work.fit(own)?;
    // What is left within a bandwidth of a mode is the misfit of that mode.
    let is_new = |pole: &Pole, known: &[Candidate]| {
        known.iter().map(|c| &c.pole).chain(&neighbours).all(|p| {
            (p.value - pole.value).norm() > -2.0 * (p.value.re + pole.value.re)
        })
    };
    let subtract = |fit: &Option<Fit>| {
        fit.as_ref().map(|f| band.minus(|o, i, s| model(f, band.order, band.n_inputs(), o, i, s)))
    };
    if matches!(search, Search::Scan | Search::None)
        && let Some(remainder) = subtract(&fit)
    {
        work.band = band.with_profile(&remainder);
        if work.band.profile.is_some() {
            (candidates, terms, fit) = work.fit(candidates)?;
        }
    }
    let mut diagram = None;
    if search == Search::Data || (search == Search::Remainder && fit.is_some()) {
        let remainder = subtract(&fit);
        let band = remainder.as_ref().unwrap_or(&band);
        let orders = orders(band, options.max_order)?;
        let found = StabilisationDiagram::build(&orders, poles_by_order(band, &orders)?, &options.stability);
        let mut extended = candidates.clone();
        for &column in &found.chosen {
            let Some(pole) = found.representative(column) else { continue };
            if is_new(pole, &candidates) && (search == Search::Data || is_inside(pole)) {
                let n_orders = found.column(column).count();
                extended.push(Candidate { pole: pole.clone(), n_orders, piece: index, window: None });
            }
        }
        diagram = Some(found);
        if extended.len() > candidates.len() {
            (candidates, terms, fit) = work.fit(extended)?;
        }
    }
    let mut scanned = Vec::new();
    if search == Search::Scan {
        let remainder = subtract(&fit);
        let spacing = (high - low) / (band.n_lines() - 1).max(1) as f64;
        for pole in scan(remainder.as_ref().unwrap_or(&band), &band) {
            if scanned.len() < MAX_SCANNED && is_inside(&pole) && is_new(&pole, &candidates) && is_new(&pole, &scanned) {
                let half_width = WINDOW * spacing;
                let found = Candidate { pole, n_orders: 0, piece: index, window: Some(half_width) };
                let own = window(whole, &found, half_width, known, options)?;
                work.discarded.extend(own.discarded);
                scanned.extend(own.candidates);
            }
        }
    }
    let Work { band, discarded, .. } = work;
    candidates.retain(|c| is_inside(&c.pole));
    candidates.extend(scanned);
    Ok(Piece { band, diagram, candidates, discarded, terms, fit })
}

/// The poles that a fit from `low` to `high`, rad/s, takes as known: all but its own, up to an octave beyond its ends, from
/// where the series of the residual terms are exact to the level of any noise.
fn neighbours(known: &[Candidate], low: f64, high: f64, is_own: impl Fn(&Candidate) -> bool) -> Vec<Pole> {
    let is_near = |c: &Candidate| c.pole.value.norm() > 0.5 * low && c.pole.value.norm() < 2.0 * high;
    known.iter().filter(|c| !is_own(c) && is_near(c)).map(|c| c.pole.clone()).collect()
}

/// Fits a candidate of the scan in its own window.
fn window(
    whole: &Band,
    candidate: &Candidate,
    half_width: f64,
    known: &[Candidate],
    options: &IdentifyOptions,
) -> Result<Piece, IdentifyError> {
    let centre = candidate.pole.value.im;
    let band = whole.part(centre - half_width, centre + half_width);
    let (low, high) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let neighbours = neighbours(known, low, high, |c| c.pole == candidate.pole);
    let mut work = Work { band, neighbours, options, discarded: Vec::new() };
    let (candidates, terms, fit) = work.fit(vec![candidate.clone()])?;
    Ok(Piece { diagram: None, candidates, discarded: work.discarded, terms, fit, band: work.band })
}

/// Fits in one piece.
struct Work<'a> {
    band: Band,
    neighbours: Vec<Pole>,
    options: &'a IdentifyOptions,
    discarded: Vec<Discarded>,
}

impl Work<'_> {
    /// Fits the candidates until all that remain pass; neighbours have fixed poles.
    fn fit(
        &mut self,
        mut candidates: Vec<Candidate>,
    ) -> Result<(Vec<Candidate>, ResidualTerms, Option<Fit>), IdentifyError> {
        let mut terms = self.options.residual_terms.unwrap_or(ResidualTerms { lower: 2, upper: 2 });
        let mut is_term_choice_open = self.options.residual_terms.is_none();
        while candidates.len() + self.neighbours.len() > 0 {
            let poles = Poles::new(candidates.iter().map(|c| &c.pole), &self.neighbours);
            let steps = if is_term_choice_open { 3 } else { MAX_STEPS };
            let result = match fit(&self.band, &poles, terms, steps) {
                Ok(result) => result,
                Err(IdentifyError::Singular { .. } | IdentifyError::TooFewLines { .. }) if !candidates.is_empty() => {
                    // Two candidates are one, or there are more unknowns than lines: the least persistent one goes.
                    let weakest = (0..candidates.len()).min_by_key(|&c| candidates[c].n_orders).unwrap_or(0);
                    let gone = candidates.remove(weakest);
                    self.discard(&gone.pole, "cannot be told from another candidate");
                    continue;
                }
                Err(IdentifyError::Singular { .. } | IdentifyError::TooFewLines { .. }) => break,
                Err(e) => return Err(e),
            };
            for (c, candidate) in candidates.iter_mut().enumerate() {
                candidate.pole.value = result.poles.values[c];
                candidate.pole.participation.clone_from(&result.poles.participation[c]);
            }
            if is_term_choice_open {
                terms = choose_terms(&self.band, &result.poles)?;
                is_term_choice_open = false;
                continue;
            }
            let verdicts = verdicts(&self.band, &result, &candidates, &self.options.stability);
            if verdicts.iter().all(Option::is_none) {
                return Ok((candidates, terms, Some(result)));
            }
            let mut remaining = Vec::new();
            for (candidate, verdict) in candidates.into_iter().zip(verdicts) {
                match verdict {
                    Some(reason) => self.discard(&candidate.pole, reason),
                    None => remaining.push(candidate),
                }
            }
            candidates = remaining;
        }
        Ok((candidates, terms, None))
    }

    fn discard(&mut self, pole: &Pole, reason: &'static str) {
        let (frequency_hz, damping_ratio) = (pole.frequency_hz(), pole.damping_ratio());
        self.discarded.push(Discarded { frequency_hz, damping_ratio, reason });
    }
}

/// One list of the candidates of all pieces; of two that are one mode at a cut, the more persistent one.
fn merge(candidates: impl Iterator<Item = Candidate>) -> Vec<Candidate> {
    let mut merged: Vec<Candidate> = Vec::new();
    for c in candidates {
        let twin = merged.iter().position(|m| {
            m.piece != c.piece
                && (m.pole.value - c.pole.value).norm() < -0.5 * (m.pole.value.re + c.pole.value.re)
                && mac(&m.pole.participation, &c.pole.participation) > 0.9
        });
        match twin {
            Some(k) if merged[k].n_orders < c.n_orders => merged[k] = c,
            Some(_) => {}
            None => merged.push(c),
        }
    }
    merged
}

fn finish(
    frfs: &FrfSet,
    cores: &[(f64, f64)],
    (pieces, windows): (Vec<Piece>, Vec<Piece>),
    diagrams: Vec<Vec<StabilisationDiagram>>,
    discarded: Vec<Vec<Discarded>>,
) -> Identification {
    let mut all = Vec::new();
    let mut segments = Vec::new();
    for piece in &windows {
        if let (Some(fit), false) = (&piece.fit, piece.candidates.is_empty()) {
            all.extend(modes(frfs, &piece.band, fit, &[0], &[0]));
        }
    }
    for (((piece, &core_hz), diagrams), discarded) in pieces.into_iter().zip(cores).zip(diagrams).zip(discarded) {
        let n_orders: Vec<usize> = piece.candidates.iter().map(|c| c.n_orders).collect();
        // The candidates of the last round are the free poles of its fit that lie in the piece, in order.
        if let Some(fit) = &piece.fit {
            let inside: Vec<usize> = (0..fit.poles.n_free())
                .filter(|&r| piece.candidates.iter().any(|c| c.pole.value == fit.poles.values[r]))
                .collect();
            all.extend(modes(frfs, &piece.band, fit, &inside, &n_orders));
        }
        let (noise_sd, rms) = levels(frfs, &piece.band, piece.fit.as_ref());
        segments.push(Segment {
            core_hz,
            diagrams,
            discarded,
            residual_terms: piece.terms,
            noise_sd,
            rms,
            is_converged: piece.fit.as_ref().is_none_or(|f| f.is_converged),
            fit: piece.fit,
            band: piece.band,
        });
    }
    all.sort_by(|a, b| a.frequency_hz.value.total_cmp(&b.frequency_hz.value));
    Identification { modes: all, segments }
}

/// Ends of the pieces, Hz, ascending; the first begins at the first line and the last ends at the last.
fn cores(band: &Band, segments: &Segments) -> Result<Vec<(f64, f64)>, IdentifyError> {
    let (first, last) = (band.omega[0] / TAU, band.omega[band.n_lines() - 1] / TAU);
    let count = |a: f64, b: f64| band.omega.iter().filter(|w| **w >= a * TAU && **w <= b * TAU).count();
    let mut cuts = vec![first, last];
    match segments {
        Segments::Whole => {}
        Segments::At(at) => {
            for &f in at {
                if !f.is_finite() {
                    return Err(IdentifyError::Option { name: "segments", value: f, expected: "a finite frequency" });
                }
                if f > first && f < last {
                    cuts.push(f);
                }
            }
        }
        Segments::Octaves => {
            let mut top = last;
            while top / 2.0 > first && count(top / 2.0, top) >= LINES_PER_SEGMENT && count(first, top / 2.0) >= LINES_PER_SEGMENT {
                top /= 2.0;
                cuts.push(top);
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    Ok(cuts.windows(2).map(|w| (w[0], w[1])).collect())
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
fn verdicts(band: &Band, fit: &Fit, candidates: &[Candidate], stability: &Stability) -> Vec<Option<&'static str>> {
    let n = candidates.len();
    let unknowns = fit.poles.unknowns();
    let (low, high) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let price = threshold(2.0 * (band.n_outputs() + band.n_inputs()) as f64, band.n_lines() as f64);
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
            if gain / fit.level[r] < price {
                return Some("explains no more than noise would");
            }
            let is_scanned = candidates[r].n_orders == 0;
            (is_scanned && mpc_less_noise(fit, r) < LEAST_MPC).then_some("was found by the scan alone, and its shape is not in phase")
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
                let weaker = if candidates[a].n_orders < candidates[b].n_orders { a } else { b };
                out[weaker] = Some("doubles another candidate");
            }
        }
    }
    out
}

/// Modal phase collinearity of a fitted shape, the energy that its noise puts along and across its line taken away.
fn mpc_less_noise(fit: &Fit, r: usize) -> f64 {
    let shape = fit.shapes.column(r).into_owned();
    // Along and across from MPC and power: λ1 + λ2 = power, λ1 - λ2 = power √MPC.
    let power = shape.norm_squared();
    let difference = power * complexity(&shape).mpc.sqrt();
    let noise: f64 = fit.local[r].iter().map(|v| v[0] + v[2]).sum::<f64>() * fit.level[r];
    if power > noise { (difference / (power - noise)).powi(2).min(1.0) } else { 0.0 }
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
    /// functions that were not fitted, zero in pieces without a mode.
    pub fn synthesise(&self, frequencies_hz: &[f64], n_references: usize, n_responses: usize) -> Vec<Complex<f64>> {
        let nan = Complex::new(f64::NAN, f64::NAN);
        let mut h = vec![nan; frequencies_hz.len() * n_references * n_responses];
        for (line, f) in frequencies_hz.iter().enumerate() {
            let s = Complex::new(0.0, TAU * f);
            // The piece that holds the frequency; the nearest one outside the band.
            let at = self.segments.partition_point(|p| p.core_hz.1 < *f).min(self.segments.len().saturating_sub(1));
            let Some(Segment { band, fit, .. }) = self.segments.get(at) else { continue };
            for (k, &o) in band.outputs.iter().enumerate() {
                for (j, &i) in band.inputs.iter().enumerate() {
                    let (response, reference) = if band.is_transposed { (i, o) } else { (o, i) };
                    if response < n_responses && reference < n_references {
                        let zero = Complex::new(0.0, 0.0);
                        let value = fit.as_ref().map_or(zero, |fit| model(fit, band.order, band.n_inputs(), k, j, s));
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
