//! The page and the data file.

use super::data::{Frfs, ReportData, ReportError, Spectrum};
use std::borrow::Cow;
use std::fmt::Write as _;

/// The front end, built from `web/`; `npm run check` there compares it with a fresh build.
const SCRIPT: &str = include_str!("web/dist/report.js");
const STYLE: &str = include_str!("web/dist/report.css");
/// Hash of the script: the only script that the page allows itself to run.
const SCRIPT_HASH: &str = include_str!("web/dist/report.js.hash");

/// A page stays below this, so that it travels by mail and opens at once.
const LARGEST_PAGE: usize = 6_000_000;

/// One HTML file with everything in it: opens from disk, asks no network, prints to paper.
///
/// Names in the data may be hostile. They reach the page only as JSON whose `<`, `>` and `&` are escaped, become text
/// nodes, and the page's content security policy allows no script but its own.
///
/// A page above 6 MB is made smaller before it is written: frequency responses keep every second (third, ...)
/// line, then beams lose their curvature. The page says so; [`json`] keeps everything.
///
/// # Errors
/// [`ReportError`] when the parts do not fit together, see [`ReportData::validate`].
pub fn html(data: &ReportData) -> Result<String, ReportError> {
    data.validate()?;
    let mut text = compact(data)?;
    let room = LARGEST_PAGE - SCRIPT.len() - STYLE.len() - 4096;
    if escaped_len(&text) > room {
        text = compact(&lighter(data, escaped_len(&text) - room))?;
    }
    let mut page = String::with_capacity(SCRIPT.len() + STYLE.len() + text.len() + 4096);
    page.push_str("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    page.push_str("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    let _ = writeln!(
        page,
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src '{SCRIPT_HASH}'; \
         style-src 'unsafe-inline'; img-src data: blob:; font-src data:; worker-src blob:; base-uri 'none'; form-action 'none'\">"
    );
    page.push_str("<meta name=\"generator\" content=\"retune\">\n<title>");
    push_markup(&mut page, if data.meta.title.is_empty() { "Report" } else { &data.meta.title });
    page.push_str("</title>\n<style>");
    page.push_str(STYLE);
    page.push_str("</style>\n</head>\n<body>\n<div id=\"report\">");
    page.push_str("<noscript>This report draws its pictures by a script inside this file; please allow it.</noscript>");
    page.push_str("</div>\n<script type=\"application/json\" id=\"report-data\">");
    push_script_json(&mut page, &text);
    page.push_str("</script>\n<script>");
    page.push_str(SCRIPT);
    page.push_str("</script>\n</body>\n</html>\n");
    Ok(page)
}

/// The report's data as a JSON file: [`data::SCHEMA`](super::data::SCHEMA) is its version.
///
/// # Errors
/// [`ReportError`] when the parts do not fit together, see [`ReportData::validate`].
pub fn json(data: &ReportData) -> Result<String, ReportError> {
    data.validate()?;
    let text = serde_json::to_string_pretty(data).map_err(|e| ReportError::Json { reason: e.to_string() })?;
    Ok(text + "\n")
}

fn compact(data: &ReportData) -> Result<String, ReportError> {
    serde_json::to_string(data).map_err(|e| ReportError::Json { reason: e.to_string() })
}

/// The length that [`push_script_json`] makes of a text.
fn escaped_len(text: &str) -> usize {
    text.len() + 5 * text.bytes().filter(|b| matches!(b, b'<' | b'>' | b'&')).count()
}

/// JSON inside a script element: nothing in it can end the element or open another.
fn push_script_json(page: &mut String, json: &str) {
    for c in json.chars() {
        match c {
            '<' => page.push_str("\\u003c"),
            '>' => page.push_str("\\u003e"),
            '&' => page.push_str("\\u0026"),
            '\u{2028}' => page.push_str("\\u2028"),
            '\u{2029}' => page.push_str("\\u2029"),
            c => page.push(c),
        }
    }
}

/// Text as markup, for elements and quoted attributes.
pub(super) fn push_markup(out: &mut String, text: &str) {
    for c in text.chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // XML knows no other control characters.
            c if c.is_control() && !matches!(c, '\t' | '\n') => out.push('\u{fffd}'),
            '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
}

/// The data without what a page can do without, smaller by about `excess` bytes.
fn lighter(data: &ReportData, excess: usize) -> Cow<'_, ReportData> {
    let mut data = data.clone();
    let mut excess = excess;
    if let Some(frfs) = &mut data.frfs {
        let size = spectra_size(frfs);
        if size > 0 {
            let lines = frfs.frequency_hz.len();
            let keep = size.saturating_sub(excess).max(size / 64);
            let step = size.div_ceil(keep.max(1)).max(2);
            thin(frfs, step);
            excess = excess.saturating_sub(size - spectra_size(frfs));
            data.meta.warnings.push(format!(
                "To keep this page small, its frequency responses show every {step}{} of {lines} lines; the criteria \
                 were computed on all lines, and the JSON file holds them.",
                ordinal(step)
            ));
        }
    }
    if excess > 0 && data.modes.model.iter().any(|m| m.rotation.is_some()) {
        for mode in &mut data.modes.model {
            mode.rotation = None;
        }
        data.meta.warnings.push("To keep this page small, beams are drawn straight between their nodes.".into());
    }
    Cow::Owned(data)
}

fn ordinal(n: usize) -> &'static str {
    match (n % 100, n % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    }
}

/// Base64 bytes of all curves: four bytes a value become 16/3.
fn spectra_size(frfs: &Frfs) -> usize {
    let spectra = |c: &super::data::Channel| {
        [&c.measured, &c.model, &c.before].into_iter().flatten().map(|h| h.0.len()).sum::<usize>()
            + c.coherence.as_ref().map_or(0, super::data::Floats::len)
    };
    frfs.channels.iter().map(spectra).sum::<usize>() * 16 / 3
}

fn thin(frfs: &mut Frfs, step: usize) {
    let floats = |values: &mut Vec<f32>| *values = values.iter().copied().step_by(step).collect();
    floats(&mut frfs.frequency_hz.0);
    for channel in &mut frfs.channels {
        for spectrum in [&mut channel.measured, &mut channel.model, &mut channel.before].into_iter().flatten() {
            *spectrum = Spectrum(spectrum.0.iter().copied().step_by(step).collect());
        }
        if let Some(coherence) = &mut channel.coherence {
            floats(&mut coherence.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::data::{Channel, Floats, Meta, Node, Structure};
    use super::*;

    fn embedded(page: &str) -> &str {
        let start = page.find("id=\"report-data\">").unwrap() + "id=\"report-data\">".len();
        &page[start..start + page[start..].find("</script>").unwrap()]
    }

    #[test]
    fn hostile_names_stay_inside_the_data() {
        let hostile = "</script><script>alert(1)</script><!--<script> & \u{2028} ' \" \u{0} ]]>";
        let node = Node { name: hostile.into(), position: [0.0; 3] };
        let data = ReportData {
            meta: Meta { title: hostile.into(), subtitle: hostile.into(), ..Meta::default() },
            structure: Some(Structure { nodes: vec![node], ..Structure::default() }),
            ..ReportData::default()
        };
        let page = html(&data).unwrap();
        assert_eq!(page.matches("</script>").count(), 2);
        assert_eq!(page.matches("<script").count(), 2);
        let text = embedded(&page);
        assert!(!text.contains(['<', '>', '&', '\u{2028}']));
        assert_eq!(serde_json::from_str::<ReportData>(text).unwrap(), data);
    }

    #[test]
    fn the_page_asks_no_network_and_allows_only_its_own_script() {
        let page = html(&ReportData::default()).unwrap();
        assert!(page.contains("default-src 'none'") && page.contains("script-src 'sha256-"));
        for tag in ["<link", "<img", "<iframe", " src=\"http", " href=\"http", "@import"] {
            assert!(!page[..page.find("</head>").unwrap()].contains(tag), "{tag}");
        }
        assert!(!SCRIPT.contains('\r') && !SCRIPT.to_lowercase().contains("</script") && !SCRIPT.contains("<!--"));
        assert!(SCRIPT.contains("MIT License") && STYLE.is_ascii());
    }

    #[test]
    fn a_page_with_many_curves_stays_below_its_limit_and_says_so() {
        let lines = 1000;
        let curve = || Some(Spectrum((0..lines).map(|i| [i as f32 + 1.0, 0.5]).collect()));
        let channel = || Channel { measured: curve(), model: curve(), before: curve(), ..Channel::default() };
        let frfs = Frfs {
            frequency_hz: Floats((0..lines).map(|i| i as f32).collect()),
            channels: (0..500).map(|_| channel()).collect(),
            ..Frfs::default()
        };
        let data = ReportData { frfs: Some(frfs), ..ReportData::default() };
        let page = html(&data).unwrap();
        assert!(page.len() < LARGEST_PAGE, "{}", page.len());
        let shown: ReportData = serde_json::from_str(embedded(&page)).unwrap();
        shown.validate().unwrap();
        assert_eq!(shown.frfs.unwrap().frequency_hz.0[..2], [0.0, 3.0]);
        assert!(shown.meta.warnings[0].contains("every 3rd of 1000 lines"), "{:?}", shown.meta.warnings);
    }

    #[test]
    fn the_data_file_reads_back_equal() {
        let data = super::super::fixture::wing::report();
        let text = json(&data).unwrap();
        let mut back: ReportData = serde_json::from_str(&text).unwrap();
        // Curves are rounded once (see `Spectrum`); everything else is exact. Texts are compared, for NaN is not NaN.
        back.frfs.clone_from(&data.frfs);
        assert!(json(&back).unwrap() == text);
    }
}
