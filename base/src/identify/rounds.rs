//! The rounds of an identification: search, fit, judge, piece by piece.

use super::IdentifyError;
use super::band::Band;
use super::complexity::complexity;
use super::fit::{choose_terms, fit};
use super::fitted::{Fit, model};
use super::options::{Discarded, IdentifyOptions};
use super::outside::{Side, start};
use super::plscf::{Pole, poles_by_order};
use super::poles::{Poles, ResidualTerms};
use super::scan::{LEAST_MPC, scan, threshold};
use super::stabilisation::{StabilisationDiagram, mac};
use retune_linalg::Complex;
use std::f64::consts::TAU;

/// Steps of the fit; Gauss-Newton from pLSCF poles needs three to six.
const MAX_STEPS: usize = 40;

/// Half width of the window in which a candidate of the scan is fitted, lines: thirty times its bandwidth at least.
const WINDOW: f64 = 64.0;

/// Most candidates that one scan may add in a piece: it is for the few that were missed.
const MAX_SCANNED: usize = 8;

/// How far a piece looks beyond its ends, as a share of its width: modes near an end are then inside.
const OVERLAP: f64 = 0.25;

/// Where a round looks for new poles.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Search {
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
pub(super) struct Candidate {
    pub(super) pole: Pole,
    pub(super) n_orders: usize,
    pub(super) piece: usize,
    /// Half width, rad/s, of the window of its own in which a candidate of the scan is fitted: the broad misfit of stronger
    /// modes would otherwise draw a weak one away from its few lines.
    pub(super) window: Option<f64>,
    /// Lies beyond an end of the whole band: a pole of the fit, no mode of the result.
    pub(super) is_outside: bool,
}

impl Candidate {
    /// Whether the fit of piece `index` has this pole as an unknown.
    fn belongs_to(&self, index: usize) -> bool {
        self.piece == index && self.window.is_none()
    }
}

/// The work on one piece in one round.
pub(super) struct Piece {
    pub(super) band: Band,
    pub(super) diagram: Option<StabilisationDiagram>,
    pub(super) candidates: Vec<Candidate>,
    pub(super) discarded: Vec<Discarded>,
    pub(super) terms: ResidualTerms,
    pub(super) fit: Option<Fit>,
}

pub(super) fn piece(
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
    // Beyond these ends there is no other piece.
    let ends = (core.0 * TAU <= whole.omega[0], core.1 * TAU >= whole.omega[whole.n_lines() - 1]);
    let mut work = Work { band: band.clone(), neighbours: neighbours.clone(), options, ends, discarded: Vec::new() };
    let is_inside = |p: &Pole| {
        let grace = -0.5 * p.value.re;
        p.value.norm() >= TAU * core.0 - grace && p.value.norm() <= TAU * core.1 + grace
    };
    let (mut candidates, mut terms, mut fit) = work.fit(own)?;
    // What is left within a bandwidth of a mode is the misfit of that mode.
    let is_new = |pole: &Pole, known: &[Candidate]| {
        known
            .iter()
            .map(|c| &c.pole)
            .chain(&neighbours)
            .all(|p| (p.value - pole.value).norm() > -2.0 * (p.value.re + pole.value.re))
    };
    let subtract =
        |fit: &Option<Fit>| fit.as_ref().map(|f| band.minus(|o, i, s| model(f, band.order, band.n_inputs(), o, i, s)));
    if matches!(search, Search::Scan | Search::None)
        && let Some(remainder) = subtract(&fit)
    {
        work.band = band.with_profile(&remainder);
        if work.band.profile.is_some() {
            (candidates, terms, fit) = work.fit(candidates)?;
        }
    }
    if search == Search::Remainder {
        for side in [Side::Below, Side::Above] {
            let is_end = if side == Side::Below { ends.0 } else { ends.1 };
            let is_there = |c: &Candidate| c.is_outside && (c.pole.value.norm() < low) == (side == Side::Below);
            let (Some(now), Some(remainder)) = (&fit, subtract(&fit)) else { continue };
            if !is_end || candidates.iter().any(is_there) {
                continue;
            }
            let free: Vec<Pole> = candidates.iter().map(|c| c.pole.clone()).collect();
            let Some(pole) = start(&band, &remainder, (&free, &neighbours), now, side)? else { continue };
            let mut extended = candidates.clone();
            extended.push(Candidate { pole, n_orders: 0, piece: index, window: None, is_outside: true });
            let n_discarded = work.discarded.len();
            let next = work.fit(extended)?;
            let is_better = next.2.as_ref().is_some_and(|f| f.bic < now.bic);
            if is_better && next.0.len() == candidates.len() + 1 {
                (candidates, terms, fit) = next;
            } else {
                work.discarded.truncate(n_discarded);
            }
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
                extended.push(Candidate {
                    pole: pole.clone(),
                    n_orders,
                    piece: index,
                    window: None,
                    is_outside: false,
                });
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
            if scanned.len() < MAX_SCANNED && is_inside(&pole) && is_new(&pole, &candidates) && is_new(&pole, &scanned)
            {
                let half_width = WINDOW * spacing;
                let found = Candidate { pole, n_orders: 0, piece: index, window: Some(half_width), is_outside: false };
                let own = window(whole, &found, half_width, known, options)?;
                work.discarded.extend(own.discarded);
                scanned.extend(own.candidates);
            }
        }
    }
    let Work { band, discarded, .. } = work;
    candidates.retain(|c| c.is_outside || is_inside(&c.pole));
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
pub(super) fn window(
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
    let mut work = Work { band, neighbours, options, ends: (false, false), discarded: Vec::new() };
    let (candidates, terms, fit) = work.fit(vec![candidate.clone()])?;
    Ok(Piece { diagram: None, candidates, discarded: work.discarded, terms, fit, band: work.band })
}

/// Fits in one piece.
struct Work<'a> {
    band: Band,
    neighbours: Vec<Pole>,
    options: &'a IdentifyOptions,
    /// Whether the piece ends where the whole band does: below, above.
    ends: (bool, bool),
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
            let verdicts = verdicts(&self.band, &result, &candidates, self.options, self.ends);
            let (low, high) = (self.band.omega[0], self.band.omega[self.band.n_lines() - 1]);
            for candidate in &mut candidates {
                candidate.is_outside = !(low..=high).contains(&candidate.pole.value.norm());
            }
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
pub(super) fn merge(candidates: impl Iterator<Item = Candidate>) -> Vec<Candidate> {
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
fn verdicts(
    band: &Band,
    fit: &Fit,
    candidates: &[Candidate],
    options: &IdentifyOptions,
    ends: (bool, bool),
) -> Vec<Option<&'static str>> {
    let n = candidates.len();
    let unknowns = fit.poles.unknowns();
    let (low, high) = (band.omega[0], band.omega[band.n_lines() - 1]);
    let price = threshold(2.0 * (band.n_outputs() + band.n_inputs()) as f64, band.n_lines() as f64);
    let mut out: Vec<Option<&'static str>> = (0..n)
        .map(|r| {
            let p = fit.poles.values[r];
            let (omega, zeta) = (p.norm(), -p.re / p.norm());
            let is_outside = omega < low || omega > high;
            if (omega < low && !ends.0) || (omega > high && !ends.1) {
                return Some("lies outside the band");
            }
            if !is_outside && candidates[r].is_outside {
                return Some("was looked for outside the band, and is not there");
            }
            if zeta > options.stability.max_damping {
                return Some("is damped more than a mode may be");
            }
            let k = 2 * unknowns.iter().position(|&u| u == (r, None)).unwrap_or(0);
            let factor = fit.inflation[r];
            let (sd_re, sd_im) =
                (fit.covariance[(k, k)].sqrt() * factor, fit.covariance[(k + 1, k + 1)].sqrt() * factor);
            if is_outside {
                // Its damping is hardly felt inside; its place must be.
                let beyond = (low - omega).max(omega - high);
                return (sd_im.is_nan() || sd_im > 0.5 * beyond).then_some("lies outside the band");
            }
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
            if candidates[r].n_orders > 0 {
                return None;
            }
            if complexity(&fit.shapes.column(r).into_owned()).mpc < LEAST_MPC {
                return Some("was found by the scan alone, and its shape is not in phase");
            }
            (contribution(band, fit, r) < options.least_contribution)
                .then_some("was found by the scan alone, and stands for too little of the response there")
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

/// Share of a mode in the power of all functions within its half-power band, one line on each side at least.
///
/// ```text
/// c_r = Σ |mode r|² / Σ |H|²   over lines |ω - ω_r| <= max(ζω_r, Δω), outputs and inputs
/// ```
fn contribution(band: &Band, fit: &Fit, r: usize) -> f64 {
    let lambda = fit.poles.values[r];
    let spacing = (band.omega[band.n_lines() - 1] - band.omega[0]) / (band.n_lines() - 1).max(1) as f64;
    let reach = (-lambda.re).max(spacing);
    let (mut own, mut all) = (0.0, 0.0);
    for (l, w) in band.omega.iter().enumerate().filter(|(_, w)| (*w - lambda.norm()).abs() <= reach) {
        let s = Complex::new(0.0, *w);
        for o in 0..band.n_outputs() {
            for i in 0..band.n_inputs() {
                let residue = fit.shapes[(o, r)] * fit.poles.participation[r][i];
                let term = residue / (s - lambda) + residue.conj() / (s - lambda.conj());
                own += (s.powi(band.order) * term).norm_sqr();
                all += band.function(o, i)[l].norm_sqr();
            }
        }
    }
    own / all.max(f64::MIN_POSITIVE)
}
