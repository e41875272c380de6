//! Functions that lack lines: which lines, and what becomes of them.

use super::IdentifyError;
use super::layout::check_layout;
use crate::data::FrfSet;

/// Share of the lines that may be left out of all functions for the sake of those that lack them: a resonance keeps its shape without every
/// tenth of its lines, and a channel is worth more than these.
const MOST_LOST: f64 = 0.1;

/// A function without a value at some lines of the band, and with one at others.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// Index of the response.
    pub response: usize,
    /// Index of the reference.
    pub reference: usize,
    /// The lines that it lacks, Hz.
    pub lines_hz: Vec<f64>,
    /// Number of lines of the band.
    pub n_lines: usize,
    /// Whether the function takes part, and these lines are left out of all others too; else the function is left out.
    pub is_kept: bool,
}

/// The functions that lack some of `lines`, and the lines that all kept functions have.
///
/// Functions are taken in the order of what they lack; each is kept while the lines left out are at most a tenth. A function without any
/// value was not measured and is not a gap.
///
/// # Errors
/// A set whose lengths disagree.
pub(super) fn gaps(frfs: &FrfSet, lines: &[usize]) -> Result<(Vec<Gap>, Vec<usize>), IdentifyError> {
    check_layout(frfs)?;
    let mut lacking: Vec<(usize, usize, Vec<usize>)> = Vec::new();
    for response in 0..frfs.responses.len() {
        for reference in 0..frfs.references.len() {
            let lost: Vec<usize> =
                (0..lines.len()).filter(|&k| !frfs.at(lines[k], reference, response).is_finite()).collect();
            if !lost.is_empty() && lost.len() < lines.len() {
                lacking.push((response, reference, lost));
            }
        }
    }
    lacking.sort_by_key(|(.., lost)| lost.len());
    let mut is_lost = vec![false; lines.len()];
    let mut found = Vec::new();
    for (response, reference, lost) in lacking {
        let more = lost.iter().filter(|&&k| !is_lost[k]).count();
        let n_lost = is_lost.iter().filter(|x| **x).count() + more;
        let is_kept = n_lost as f64 <= MOST_LOST * lines.len() as f64;
        if is_kept {
            for &k in &lost {
                is_lost[k] = true;
            }
        }
        let lines_hz = lost.iter().map(|&k| frfs.frequencies_hz[lines[k]]).collect();
        found.push(Gap { response, reference, lines_hz, n_lines: lines.len(), is_kept });
    }
    found.sort_by_key(|g| (g.response, g.reference));
    let kept = lines.iter().zip(is_lost).filter(|(_, lost)| !lost).map(|(l, _)| *l).collect();
    Ok((found, kept))
}

/// The lines of a gap in words: `100 of 201 lines, between 101 and 200 Hz`.
pub(super) fn lines_text(lines_hz: &[f64], n_lines: usize) -> String {
    let of = format!("{} of {n_lines} lines", lines_hz.len());
    match lines_hz {
        [] => of,
        [one] => format!("{of}, at {one} Hz"),
        [one, other] => format!("{of}, at {one} and {other} Hz"),
        [first, .., last] => format!("{of}, between {first} and {last} Hz"),
    }
}
