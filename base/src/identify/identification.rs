//! From functions to modes: the workflow.

use super::IdentifyError;
use super::band::Band;
use super::fitted::{Fit, model};
use super::gaps::Gap;
use super::mode::{IdentifiedMode, modes};
use super::options::{Discarded, IdentifyOptions, Segments};
use super::poles::ResidualTerms;
use super::rounds::{Candidate, Piece, Search, merge, piece, window};
use super::stabilisation::{StabilisationDiagram, mac};
use crate::data::FrfSet;
use rayon::prelude::*;
use retune_linalg::{Complex, DMatrix};
use std::f64::consts::TAU;

/// Least number of lines in an octave that becomes a piece of its own: some ten per unknown of a mode or two.
const LINES_PER_SEGMENT: usize = 128;

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
    /// Functions that lack lines of the band, and what was done about it.
    pub gaps: Vec<Gap>,
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
/// weak one, and tries a pole beyond each end of the band beside the residual terms; a third scans the remainder with a
/// matched filter for sharp resonances of a few lines; a last one fits every piece again with the poles of its neighbours
/// known.
///
/// No mode found is a result, not an error; the diagrams then show why. A function that lacks lines keeps its place when these are few: they
/// are then left out of all functions; else the function is left out. `gaps` tells of both. The unit of the functions, however large or
/// small, has no influence on the poles.
///
/// # Errors
/// A set whose lengths disagree, a band without enough lines, no function measured in full.
pub fn identify(frfs: &FrfSet, options: &IdentifyOptions) -> Result<Identification, IdentifyError> {
    check(options)?;
    let whole = Band::select(frfs, options.band_hz, options.weighting)?;
    let cores = cores(&whole, &options.segments)?;
    let mut known: Vec<Candidate> = Vec::new();
    let mut terms: Vec<Option<ResidualTerms>> = vec![options.residual_terms; cores.len()];
    let mut diagrams: Vec<Vec<StabilisationDiagram>> = vec![Vec::new(); cores.len()];
    let mut discarded: Vec<Vec<Discarded>> = vec![Vec::new(); cores.len()];
    for search in [Search::Data, Search::Remainder, Search::Scan, Search::None] {
        let found: Vec<Result<Piece, IdentifyError>> = (0..cores.len())
            .into_par_iter()
            .map(|k| {
                piece(
                    &whole,
                    cores[k],
                    k,
                    &known,
                    search,
                    &IdentifyOptions { residual_terms: terms[k], ..options.clone() },
                )
            })
            .collect();
        let mut pieces = found.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut windows = known
            .par_iter()
            .filter_map(|c| Some(window(&whole, c, c.window?, &known, options)))
            .collect::<Result<Vec<_>, _>>()?;
        known = merge(pieces.iter().chain(&windows).flat_map(|p| p.candidates.iter().cloned()));
        for (k, p) in pieces.iter().enumerate() {
            // Chosen for good once the modes next door are known.
            if search == Search::Remainder && p.fit.is_some() {
                terms[k] = Some(p.terms);
            }
            diagrams[k].extend(p.diagram.clone());
            discarded[k].extend(p.discarded.iter().cloned());
        }
        if matches!(search, Search::None) {
            pieces.par_iter_mut().chain(&mut windows).try_for_each(|p| -> Result<(), IdentifyError> {
                p.fit = p.fit.take().map(|f| f.with_common_noise(&p.band)).transpose()?;
                Ok(())
            })?;
            return Ok(Identification {
                gaps: whole.gaps,
                ..finish(frfs, &cores, (pieces, windows), diagrams, discarded)
            });
        }
    }
    Ok(Identification { modes: Vec::new(), segments: Vec::new(), gaps: whole.gaps })
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
    for (((piece, &core_hz), diagrams), mut discarded) in pieces.into_iter().zip(cores).zip(diagrams).zip(discarded) {
        let own: Vec<&Candidate> = piece.candidates.iter().filter(|c| !c.is_outside).collect();
        let n_orders: Vec<usize> = own.iter().map(|c| c.n_orders).collect();
        // The candidates of the last round are the free poles of its fit that lie in the piece, in order.
        if let Some(fit) = &piece.fit {
            let inside: Vec<usize> =
                (0..fit.poles.n_free()).filter(|&r| own.iter().any(|c| c.pole.value == fit.poles.values[r])).collect();
            all.extend(modes(frfs, &piece.band, fit, &inside, &n_orders));
        }
        discarded.extend(piece.candidates.iter().filter(|c| c.is_outside).map(|c| Discarded {
            frequency_hz: c.pole.frequency_hz(),
            damping_ratio: c.pole.damping_ratio(),
            reason: "lies outside the band; the fit knows it",
        }));
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
    drop_copies(&mut all, &mut segments);
    Identification { modes: all, segments, gaps: Vec::new() }
}

/// Least number of channels for which one shape means one mode: random shapes reach a MAC of 0.9 with a chance below 1 %.
const LEAST_CHANNELS: usize = 6;

/// Takes modes of the scan away that have the shape of a stronger mode beside them (see `scan`).
fn drop_copies(all: &mut Vec<IdentifiedMode>, segments: &mut [Segment]) {
    let pairs = |a: &IdentifiedMode, b: &IdentifiedMode| -> (Vec<Complex<f64>>, Vec<Complex<f64>>) {
        a.shape.iter().zip(&b.shape).filter(|(x, y)| x.is_finite() && y.is_finite()).map(|(x, y)| (*x, *y)).unzip()
    };
    let strength = |m: &IdentifiedMode| {
        let largest = m.participation.iter().filter(|l| l.is_finite()).map(|l| l.norm()).fold(0.0, f64::max);
        m.residue_scale.norm() * largest / -m.pole.re
    };
    let is_copy = |m: &IdentifiedMode| {
        all.iter().any(|other| {
            let gap = (other.frequency_hz.value / m.frequency_hz.value - 1.0).abs();
            let (x, y) = pairs(m, other);
            gap > 0.0 && gap < 0.05 && strength(other) > strength(m) && x.len() >= LEAST_CHANNELS && mac(&x, &y) > 0.9
        })
    };
    let copies: Vec<bool> = all.iter().map(|m| m.n_orders == 0 && is_copy(m)).collect();
    for m in all.iter().zip(&copies).filter(|(_, c)| **c).map(|(m, _)| m) {
        let (frequency_hz, damping_ratio) = (m.frequency_hz.value, m.damping_ratio.value);
        let reason = "was found by the scan alone, and has the shape of a stronger mode beside it";
        if let Some(s) = segments.iter_mut().find(|s| frequency_hz <= s.core_hz.1) {
            s.discarded.push(Discarded { frequency_hz, damping_ratio, reason });
        }
    }
    let mut is_copy = copies.into_iter();
    all.retain(|_| !is_copy.next().unwrap_or(false));
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
            while top / 2.0 > first
                && count(top / 2.0, top) >= LINES_PER_SEGMENT
                && count(first, top / 2.0) >= LINES_PER_SEGMENT
            {
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
    range("least_contribution", options.least_contribution, -1e-300, 1.0, "between 0 and 1")?;
    range("stability.min_presence", s.min_presence, 0.0, 1.0, "above 0 and at most 1")?;
    // 400 poles are far above any use; the companion matrices grow with the square.
    range("max_order", options.max_order as f64, 3.0, 400.0, "between 4 and 400")?;
    if let Some(t) = options.residual_terms {
        range("residual_terms.lower", t.lower as f64, -1.0, 6.0, "at most 6")?;
        range("residual_terms.upper", t.upper as f64, -1.0, 6.0, "at most 6")?;
    }
    Ok(())
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
    let root = |x: Vec<f64>| x.iter().zip(&count).map(|(x, c)| (x / c).sqrt() * band.scale).collect();
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
                        let value = fit
                            .as_ref()
                            .map_or(zero, |fit| model(fit, band.order, band.n_inputs(), k, j, s) * band.scale);
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
