//! Parameters inside their bounds, before and after, with their intervals.

use super::super::data::{Parameter, Update};
use super::cut;
use super::plot::{BEFORE, Canvas, INK, MODEL, SOFT, TEST, TEXT, legend, short};

/// Height of a row in tenths of a millimetre.
const ROW: f64 = 46.0;
const TOP: f64 = 96.0;

/// The parameters that may move.
pub(super) fn free(u: &Update) -> Vec<&Parameter> {
    u.parameters.iter().filter(|p| p.lower.zip(p.upper).is_some_and(|(l, h)| h > l)).collect()
}

/// A unit with raised digits: `kg m2` is kg m².
fn raised(unit: &str) -> String {
    let mut out = String::new();
    for c in unit.chars() {
        let after_letter = out.ends_with(|p: char| p.is_ascii_alphabetic());
        out.push(match c {
            '2' if after_letter => '²',
            '3' if after_letter => '³',
            '4' if after_letter => '⁴',
            _ => c,
        });
    }
    out
}

/// One row a parameter, drawn over the whole range between its bounds.
pub(super) fn parameters(u: &Update) -> Canvas {
    let rows = free(u);
    let mut canvas = Canvas::new(120.0, (TOP + ROW * rows.len() as f64 + 24.0) / 10.0);
    let (left, right) = (470.0, canvas.width - 160.0);
    let mut has_interval = false;
    for (i, p) in rows.iter().enumerate() {
        let (Some(low), Some(high)) = (p.lower, p.upper) else { continue };
        let y = TOP + ROW * (i as f64 + 0.5);
        let at = |v: f64| [left + (right - left) * ((v - low) / (high - low)).clamp(0.0, 1.0), y];
        let unit = if p.unit.is_empty() || p.unit == "1" { String::new() } else { format!(", {}", raised(&p.unit)) };
        canvas.text([12.0, y + 9.0], &cut(&format!("{}{unit}", p.name), 24), TEXT - 2.0, "start", INK, 0.0);
        canvas.text([left - 22.0, y + 9.0], &short(low), TEXT - 6.0, "end", SOFT, 0.0);
        canvas.text([right + 22.0, y + 9.0], &short(high), TEXT - 6.0, "start", SOFT, 0.0);
        canvas.line([left, y], [right, y], "#c3cbd3", 2.5, "");
        for x in [left, right] {
            canvas.line([x, y - 12.0], [x, y + 12.0], "#c3cbd3", 2.5, "");
        }
        if let Some([from, to]) = p.interval {
            has_interval = true;
            let (from, to) = (at(from), at(to));
            canvas.rect([from[0], y - 6.0], [(to[0] - from[0]).max(1.0), 12.0], "#9cc3e4", "none");
        }
        canvas.circle(at(p.before), 9.0, "#ffffff", BEFORE);
        if let Some(after) = p.after {
            canvas.diamond(at(after), 13.0, if p.at_bound.is_some() { TEST } else { MODEL });
        }
    }
    let label = rows.iter().map(|p| p.interval_label.as_str()).find(|l| !l.is_empty()).unwrap_or_default();
    let interval = format!("{label} interval");
    let mut keys = vec![("before", BEFORE, "circle"), ("after", MODEL, "diamond")];
    if rows.iter().any(|p| p.at_bound.is_some()) {
        keys.push(("on a bound", TEST, "diamond"));
    }
    if has_interval {
        keys.push((interval.trim(), "#9cc3e4", "box"));
    }
    legend(&mut canvas, [12.0, 46.0], &keys);
    canvas
}
