//! What an identification did with functions that lack lines, and why it has no mode when it has none.

use super::super::cmif;
use super::super::gaps::lines_text;
use super::super::{Identification, PeakOptions, spectrum_peaks};
use super::{Finding, Level};
use crate::data::FrfSet;

/// Most peaks that a text names.
const NAMED: usize = 8;

/// What a user of the modes must know of their identification: functions that lack lines, and what was done about it; that no mode was found,
/// and why.
pub fn check_identification(frfs: &FrfSet, identification: &Identification) -> Vec<Finding> {
    let mut found: Vec<Finding> = identification
        .gaps
        .iter()
        .map(|gap| {
            let (response, reference) = (&frfs.responses[gap.response].name, &frfs.references[gap.reference].name);
            let done = if gap.is_kept {
                let lines = if gap.lines_hz.len() == 1 { "this line is" } else { "these lines are" };
                format!("{lines} left out of all functions")
            } else {
                format!(
                    "too many to do without, so that the identification leaves {response} out and no shape has an entry there"
                )
            };
            Finding {
                level: Level::Warning,
                code: "missing-lines",
                subject: format!("{response} / {reference}"),
                evidence: vec![("lines missing", gap.lines_hz.len() as f64), ("lines", gap.n_lines as f64)],
                text: format!(
                    "function {response} / {reference} lacks {}: {done}",
                    lines_text(&gap.lines_hz, gap.n_lines)
                ),
                remedy: "find out why the file has no numbers there (overload, range of the export); to use the channel, give it the lines, or \
                         restrict the band to those that it has",
            }
        })
        .collect();
    found.extend(identification.modes.is_empty().then(|| no_mode(frfs, identification)));
    found
}

fn no_mode(frfs: &FrfSet, identification: &Identification) -> Finding {
    let limits = (
        identification.segments.first().map_or(0.0, |s| s.core_hz.0),
        identification.segments.last().map_or(f64::INFINITY, |s| s.core_hz.1),
    );
    let peaks = cmif(frfs)
        .and_then(|c| {
            let column: Vec<f64> = c.values.column(0).iter().copied().collect();
            spectrum_peaks(&c.frequencies_hz, &column, &PeakOptions::resonances(limits))
        })
        .unwrap_or_default();
    let mut reasons: Vec<(&'static str, usize)> = Vec::new();
    for d in identification.segments.iter().flat_map(|s| &s.discarded) {
        match reasons.iter_mut().find(|(r, _)| *r == d.reason) {
            Some((_, n)) => *n += 1,
            None => reasons.push((d.reason, 1)),
        }
    }
    reasons.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let why = match &reasons[..] {
        [] => "no column of the stabilisation diagram is stable".to_string(),
        list => {
            let list: Vec<String> = list.iter().take(3).map(|(reason, n)| format!("{reason} ({n} times)")).collect();
            format!("every candidate was rejected: {}", list.join("; "))
        }
    };
    let shown = match &peaks[..] {
        [] => "the functions show no peak, and no mode was found".to_string(),
        list => {
            let hz: Vec<String> = list.iter().take(NAMED).map(|p| format!("{:.1}", p.frequency_hz)).collect();
            let more = if list.len() > NAMED { " and others" } else { "" };
            format!("no mode was found, although the functions have peaks at {}{more} Hz", hz.join(", "))
        }
    };
    Finding {
        level: if peaks.is_empty() { Level::Warning } else { Level::Fault },
        code: "no-mode",
        subject: "identification".to_string(),
        evidence: vec![
            ("peaks", peaks.len() as f64),
            ("candidates rejected", reasons.iter().map(|(_, n)| n).sum::<usize>() as f64),
        ],
        text: format!("{shown}; {why}"),
        remedy: "check that the files hold frequency response functions, response over force, with several lines to a peak; then narrow the band \
                 around a peak or change the model order",
    }
}

/// That functions were written for exp(-iωt), see [`reversed_time`](super::super::reversed_time).
pub fn reversed_time_finding() -> Finding {
    Finding {
        level: Level::Warning,
        code: "functions-conjugate",
        subject: "functions".to_string(),
        evidence: Vec::new(),
        text: "as the files hold them, the responses come before the force, as in functions for exp(-iωt); the imaginary parts of all functions were \
               reversed"
            .to_string(),
        remedy: "export the functions for exp(+iωt), so that other programs read them right too",
    }
}
