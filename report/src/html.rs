//! The page and the data file.

use super::data::{Frfs, Levels, ModelMode, ReportData, ReportError, Spectrum, encoding_base64};
use retune::catalogue::counted;
use std::fmt::Write as _;

/// The front end, built from `web/`; `npm run check` there compares it with a fresh build.
const SCRIPT: &str = include_str!("../web/dist/report.js");
const STYLE: &str = include_str!("../web/dist/report.css");
/// Hash of the script: the only script that the page allows itself to run.
const SCRIPT_HASH: &str = include_str!("../web/dist/report.js.hash");

/// From here on the data of a page are packed.
const PACKED: usize = 1_000_000;
/// A page that would be longer has rounded shapes.
const EXACT_PAGE: usize = 6_000_000;
/// A page stays below this, so that it travels by mail and opens at once.
const LARGEST_PAGE: usize = 12_000_000;

/// One HTML file with everything in it: opens from disk, asks no network, prints to paper.
///
/// Names in the data may be hostile. They reach the page only as JSON whose `<`, `>` and `&` are escaped, become text
/// nodes, and the page's content security policy allows no script but its own.
///
/// Data of more than 1 MB are packed (deflate). A page above 6 MB has shapes rounded to a tenth of a pixel. A page above 12 MB is made smaller
/// before it is written: frequency responses keep every second (third, ...) line, beams lose their curvature, then modes without a partner
/// their shapes, the highest first. The page says so; [`json`] keeps everything.
///
/// # Errors
/// [`ReportError`] when the parts do not fit together, see [`ReportData::validate`].
pub fn html(data: &ReportData) -> Result<String, ReportError> {
    data.validate()?;
    let frame = SCRIPT.len() + STYLE.len() + 4096;
    let content = fitted(data, EXACT_PAGE - frame, LARGEST_PAGE - frame)?;
    let mut page = String::with_capacity(frame + content.len());
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
    page.push_str("</div>\n");
    content.write(&mut page);
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

/// The data inside the page: JSON, or, where that is long, base64 text of JSON packed by deflate (RFC 1951).
enum Content {
    Plain(String),
    Packed(String),
}

impl Content {
    fn of(data: &ReportData) -> Result<Self, ReportError> {
        let text = compact(data)?;
        Ok(if text.len() > PACKED {
            Self::Packed(encoding_base64(&miniz_oxide::deflate::compress_to_vec(text.as_bytes(), 6)))
        } else {
            Self::Plain(text)
        })
    }

    /// Bytes that it takes in the page.
    fn len(&self) -> usize {
        match self {
            Self::Plain(text) => text.len() + 5 * text.bytes().filter(|b| matches!(b, b'<' | b'>' | b'&')).count(),
            Self::Packed(text) => text.len(),
        }
    }

    fn write(&self, page: &mut String) {
        match self {
            Self::Plain(text) => {
                page.push_str("<script type=\"application/json\" id=\"report-data\">");
                push_script_json(page, text);
            }
            Self::Packed(text) => {
                page.push_str("<script type=\"text/plain\" data-packed=\"deflate\" id=\"report-data\">");
                page.push_str(text);
            }
        }
    }
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

/// Makes data that are too long by so many bytes smaller; whether doing it again may help.
type Lighter = fn(&mut ReportData, usize) -> bool;

/// The data as they go into a page.
///
/// * `exact` - bytes above which shapes are rounded
/// * `largest` - bytes above which something is left out
fn fitted(data: &ReportData, exact: usize, largest: usize) -> Result<Content, ReportError> {
    let steps: [(usize, Lighter); 4] =
        [(exact, round_shapes), (largest, thin_responses), (largest, straighten), (largest, drop_shapes)];
    let mut content = Content::of(data)?;
    let mut lighter = None;
    for (room, step) in steps {
        while content.len() > room {
            let data = lighter.get_or_insert_with(|| data.clone());
            let again = step(data, content.len() - room);
            content = Content::of(data)?;
            if !again {
                break;
            }
        }
    }
    Ok(content)
}

/// Displacements at nodes as levels.
fn round_shapes(data: &mut ReportData, _: usize) -> bool {
    for mode in &mut data.modes.model {
        let exact = std::mem::take(&mut mode.displacement);
        mode.displacement_levels = (!exact.is_empty()).then_some(Levels(exact.0));
    }
    for mode in &mut data.modes.test {
        mode.expanded_levels = mode.expanded.take().map(|exact| Levels(exact.0));
    }
    false
}

fn thin_responses(data: &mut ReportData, excess: usize) -> bool {
    let Some(frfs) = &mut data.frfs else { return false };
    let size = spectra_size(frfs);
    if size == 0 {
        return false;
    }
    let lines = frfs.frequency_hz.len();
    let keep = size.saturating_sub(excess).max(size / 64);
    let step = size.div_ceil(keep.max(1)).max(2);
    thin(frfs, step);
    data.meta.warnings.push(format!(
        "To keep this page small, its frequency responses show every {step}{} of {lines} lines; the criteria \
         were computed on all lines, and the JSON file holds them.",
        ordinal(step)
    ));
    false
}

fn straighten(data: &mut ReportData, _: usize) -> bool {
    if data.modes.model.iter().any(|m| m.rotation.is_some()) {
        data.modes.model.iter_mut().for_each(|mode| mode.rotation = None);
        data.meta.warnings.push("To keep this page small, beams are drawn straight between their nodes.".into());
    }
    false
}

const DROPPED: &str = "To keep this page small, the shapes of modes without a partner are left out: of";

/// Modes without a partner lose their shapes, the highest first.
fn drop_shapes(data: &mut ReportData, excess: usize) -> bool {
    /// Bytes of a level in a page, at most: two, as text, twice.
    const LEVEL: usize = 4;
    let paired: Vec<usize> = data.comparison.iter().flat_map(|c| &c.pairs).filter_map(|p| p.model_mode).collect();
    let levels = |m: &ModelMode| m.displacement_levels.as_ref().map_or(0, |l| l.0.len());
    let modes = &mut data.modes.model;
    let mut freed = 0;
    for (_, mode) in modes.iter_mut().enumerate().rev().filter(|(i, m)| !paired.contains(i) && levels(m) > 0) {
        if freed >= excess {
            break;
        }
        freed += LEVEL * levels(mode);
        (mode.displacement_levels, mode.displacement_imag) = (None, None);
    }
    let without = modes.iter().filter(|m| levels(m) == 0).count();
    if freed > 0 {
        data.meta.warnings.retain(|w| !w.starts_with(DROPPED));
        let modes = counted(without, "mode");
        data.meta.warnings.push(format!("{DROPPED} {modes}; the JSON file holds them."));
    }
    freed > 0
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
    use super::super::data::{Channel, Comparison, Floats, Meta, Node, Pair, Structure, from_base64};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn embedded(page: &str) -> String {
        let start = page.find("id=\"report-data\">").unwrap() + "id=\"report-data\">".len();
        let text = &page[start..start + page[start..].find("</script>").unwrap()];
        if !page[..start].contains("data-packed=\"deflate\" id=\"report-data\">") {
            return text.to_string();
        }
        let packed = from_base64(text).unwrap();
        String::from_utf8(miniz_oxide::inflate::decompress_to_vec_with_limit(&packed, 1 << 30).unwrap()).unwrap()
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
        assert_eq!(serde_json::from_str::<ReportData>(&text).unwrap(), data);
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
        // Noise, which cannot be packed.
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut curve = || Some(Spectrum((0..lines).map(|_| [rng.random::<f32>(), rng.random::<f32>()]).collect()));
        let mut channel = || Channel { measured: curve(), model: curve(), before: curve(), ..Channel::default() };
        let frfs = Frfs {
            frequency_hz: Floats((0..lines).map(|i| i as f32).collect()),
            channels: (0..1000).map(|_| channel()).collect(),
            ..Frfs::default()
        };
        let data = ReportData { frfs: Some(frfs), ..ReportData::default() };
        let page = html(&data).unwrap();
        assert!(page.len() < LARGEST_PAGE, "{}", page.len());
        let shown: ReportData = serde_json::from_str(&embedded(&page)).unwrap();
        shown.validate().unwrap();
        assert_eq!(shown.frfs.unwrap().frequency_hz.0[..2], [0.0, 2.0]);
        assert!(shown.meta.warnings[0].contains("every 2nd of 1000 lines"), "{:?}", shown.meta.warnings);
    }

    /// Twenty modes of 2000 nodes that move at random, of which two are paired.
    #[test]
    fn a_mesh_whose_shapes_do_not_fit_keeps_those_of_its_pairs() {
        let n = 2000;
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut mode = || ModelMode {
            displacement: Floats((0..3 * n).map(|_| rng.random::<f32>()).collect()),
            ..ModelMode::default()
        };
        let nodes = (0..n).map(|i| Node { name: format!("n{i}"), position: [f64::from(i), 0.0, 0.0] }).collect();
        let mut data = ReportData {
            structure: Some(Structure { nodes, ..Structure::default() }),
            comparison: Some(Comparison {
                pairs: [1, 19].map(|k| Pair { model_mode: Some(k), ..Pair::default() }).to_vec(),
                ..Comparison::default()
            }),
            ..ReportData::default()
        };
        data.modes.model = (0..20).map(|_| mode()).collect();
        let read = |exact: usize, largest: usize| {
            let content = fitted(&data, exact, largest).unwrap();
            assert!(content.len() <= largest, "{} of {largest}", content.len());
            let mut page = String::new();
            content.write(&mut page);
            let shown: ReportData = serde_json::from_str(&embedded(&(page + "</script>"))).unwrap();
            shown.validate().unwrap();
            shown
        };
        assert_eq!(read(3_000_000, 3_000_000), data);
        // Rounded, all fit: 16 kB each beside 100 kB of nodes.
        let rounded = read(400_000, 600_000);
        let worst = |k: usize| {
            let levels = &rounded.modes.model[k].displacement_levels.as_ref().unwrap().0;
            levels.iter().zip(&data.modes.model[k].displacement.0).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!((0..20).all(|k| worst(k) < 1.0 / 4000.0));
        let shown = read(200_000, 300_000);
        let kept: Vec<usize> = (0..20).filter(|&k| shown.modes.model[k].displacement_levels.is_some()).collect();
        assert!(kept.starts_with(&[0, 1, 2]) && kept.ends_with(&[19]) && !kept.contains(&18), "{kept:?}");
        assert_eq!(shown.meta.warnings.len(), 1);
        assert!(shown.meta.warnings[0].contains(&format!("of {} modes", 20 - kept.len())), "{:?}", shown.meta.warnings);
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
