//! A report on a terminal: the verdict first, then what the page shows, in tables.

use super::agreement::wrapped;
use super::{Align, Cell, Style, Table, Tone, cost_history, findings, number, percent, printable, shorten, wrap};
use crate::data::{Bound, Comparison, Level, Localization, ReportData, Update};
use std::fmt::Write as _;
use unicode_width::UnicodeWidthStr;

/// The report as text: verdict, pairs, update, the error falling, hypotheses.
pub fn summary(data: &ReportData, style: &Style) -> String {
    let mut out = String::new();
    let meta = &data.meta;
    let _ = writeln!(out, "{}", style.paint(Tone::Strong, &shorten(&printable(&meta.title), style.width)));
    if !meta.subtitle.is_empty() {
        let _ = writeln!(out, "{}", style.paint(Tone::Dim, &shorten(&printable(&meta.subtitle), style.width)));
    }
    if let Some(verdict) = &meta.verdict {
        let (sign, tone) = match verdict.level {
            Level::Good => ("✓", Tone::Good),
            Level::Warning => ("!", Tone::Warning),
            Level::Bad => ("✕", Tone::Bad),
            Level::Neutral => ("•", Tone::Strong),
        };
        out.push('\n');
        for (i, line) in wrap(&printable(&verdict.sentence), style.width.saturating_sub(2)).iter().enumerate() {
            let _ = writeln!(
                out,
                "{} {}",
                if i == 0 { style.paint(tone, sign) } else { " ".into() },
                style.paint(Tone::Strong, line)
            );
        }
        if !verdict.number.is_empty() {
            let _ = writeln!(
                out,
                "  {}  {}",
                style.paint(tone, &printable(&verdict.number)),
                printable(&verdict.number_label)
            );
        }
    }
    for warning in &meta.warnings {
        for (i, line) in wrap(&printable(warning), style.width.saturating_sub(11)).iter().enumerate() {
            let _ = writeln!(
                out,
                "  {} {line}",
                if i == 0 { style.paint(Tone::Warning, "warning:") } else { " ".repeat(8) }
            );
        }
    }
    if let Some(c) = &data.comparison {
        pairs(&mut out, data, c, style);
    }
    if let Some(u) = &data.update {
        update(&mut out, u, style);
    }
    if let Some(l) = &data.localization {
        localization(&mut out, l, style);
    }
    if let Some(s) = &data.steps {
        head(&mut out, "The error falling", &s.measure, style);
        out.push_str(&findings::steps(s, style));
    }
    if let Some(d) = &data.diagnosis {
        head(&mut out, "Diagnosis", "", style);
        out.push_str(&findings::diagnosis(d, findings::FILES, style));
    }
    out
}

/// Places in the list.
const SUSPECTS: usize = 5;

fn localization(out: &mut String, l: &Localization, style: &Style) {
    head(out, "Where model and test disagree", "", style);
    for line in wrap(&printable(&l.sentence), style.width) {
        let _ = writeln!(out, "{line}");
    }
    if !l.stands_out {
        return;
    }
    let mut table = Table::new([("above noise", Align::Right), ("P by noise", Align::Right), ("element", Align::Left)]);
    for s in l.elements.iter().take(SUSPECTS) {
        let p = |p: f64| if p < 1e-300 { "< 1e-300".into() } else { number(p) };
        table.row([optional(s.above_noise, number), optional(s.p_value, p), (&s.place.text).into()]);
    }
    out.push_str(&table.render(style));
}

fn head(out: &mut String, title: &str, note: &str, style: &Style) {
    let note = shorten(&printable(note), style.width.saturating_sub(title.width() + 2));
    let _ = writeln!(
        out,
        "\n{}{}",
        style.paint(Tone::Strong, title),
        if note.is_empty() { String::new() } else { format!("  {}", style.paint(Tone::Dim, &note)) }
    );
}

fn optional(value: Option<f64>, write: impl Fn(f64) -> String) -> Cell {
    value.map_or_else(|| "–".into(), |v| write(v).into())
}

fn pairs(out: &mut String, data: &ReportData, c: &Comparison, style: &Style) {
    head(out, "Pairs", &c.criteria, style);
    let mut table = Table::new([
        ("mode", Align::Left),
        ("test Hz", Align::Right),
        ("model Hz", Align::Right),
        ("error", Align::Right),
        ("MAC", Align::Right),
        ("", Align::Left),
    ]);
    for p in &c.pairs {
        let state = match p.passes {
            Some(true) => Cell::new("✓ pass", Tone::Good),
            Some(false) => Cell::new("✕ fail", Tone::Bad),
            None => Cell::default(),
        };
        table.row([
            (&p.label).into(),
            number(p.test_hz).into(),
            number(p.model_hz).into(),
            percent(p.error).into(),
            optional(p.mac, |m| format!("{m:.3}")),
            state,
        ]);
    }
    out.push_str(&table.render(style));
    let _ = writeln!(
        out,
        "{}",
        style.paint(Tone::Dim, "error = (model - test)/test: plus means that the model is too high")
    );
    let name = |label: &str, hz: f64| format!("{} ({} Hz)", printable(label), number(hz));
    for (k, i) in c.unpaired_test.iter().enumerate() {
        let Some(mode) = data.modes.test.get(*i) else { continue };
        let why = c.unpaired_reasons.get(k).filter(|r| !r.is_empty()).map_or_else(String::new, |r| format!(": {r}"));
        wrapped(out, &format!("test mode without a partner: {}{why}", name(&mode.label, mode.frequency_hz)), style);
    }
    let model: Vec<_> = c.unpaired_model.iter().filter_map(|i| data.modes.model.get(*i)).collect();
    if !model.is_empty() {
        let names: Vec<_> = model.iter().map(|m| name(&m.label, m.frequency_hz)).collect();
        let text = format!("model modes without a partner: {}", names.join(", "));
        let _ = writeln!(out, "{}", shorten(&text, style.width));
    }
}

fn update(out: &mut String, u: &Update, style: &Style) {
    if u.histories.is_empty() && !u.has_moved() {
        return;
    }
    head(out, "Update", &u.objective, style);
    for h in &u.histories {
        let name = shorten(&printable(&h.name), 26);
        let line = cost_history(&h.evaluations, &h.best_cost, style.width.saturating_sub(28));
        if !line.is_empty() {
            let _ = writeln!(out, "{name:<26}  {line}");
        }
    }
    if !u.has_moved() {
        return;
    }
    let mut table = Table::new([
        ("parameter", Align::Left),
        ("before", Align::Right),
        ("after", Align::Right),
        ("unit", Align::Left),
        ("lower", Align::Right),
        ("within", Align::Left),
        ("upper", Align::Right),
        ("", Align::Left),
    ]);
    for p in &u.parameters {
        let state = match p.at_bound {
            Some(Bound::Lower) => Cell::new("! at lower bound", Tone::Warning),
            Some(Bound::Upper) => Cell::new("! at upper bound", Tone::Warning),
            None => Cell::default(),
        };
        let track = match (p.lower, p.upper) {
            (Some(low), Some(high)) if high > low => {
                gauge((p.before - low) / (high - low), p.after.map(|a| (a - low) / (high - low)))
            }
            _ => String::new(),
        };
        table.row([
            (&p.name).into(),
            number(p.before).into(),
            optional(p.after, number),
            (&p.unit).into(),
            optional(p.lower, number),
            track.into(),
            optional(p.upper, number),
            state,
        ]);
    }
    out.push_str(&table.render(style));
}

/// A rail with a circle where the parameter was and a diamond where it is.
fn gauge(before: f64, after: Option<f64>) -> String {
    const WIDTH: usize = 15;
    let mut rail = ['─'; WIDTH];
    let place = |f: f64| (f.clamp(0.0, 1.0) * (WIDTH - 1) as f64).round() as usize;
    if before.is_finite() {
        rail[place(before)] = '○';
    }
    if let Some(a) = after.filter(|a| a.is_finite()) {
        rail[place(a)] = '◆';
    }
    rail.iter().collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::wing;
    use super::*;

    #[test]
    fn the_wing_reads_well_at_every_width() {
        for width in [60, 80, 100, 140] {
            let text = summary(&wing::report(), &Style { color: false, width });
            assert!(!text.contains('\u{1b}'));
            for word in ["Pairs", "symmetric", "E_wing", "mass-offset", "noise alone leaves about 1.000"] {
                assert!(text.contains(word), "{word} at {width}:\n{text}");
            }
            if width >= 100 {
                let long: Vec<&str> = text.lines().filter(|l| l.width() > width).collect();
                assert!(long.is_empty(), "{long:#?}");
            }
        }
    }

    #[test]
    fn an_empty_report_is_two_lines_at_most() {
        assert!(summary(&ReportData::default(), &Style::default()).lines().count() <= 2);
    }

    #[test]
    fn signs_and_words_stand_without_colour() {
        let text = summary(&wing::report(), &Style::default());
        assert!(text.contains("✕ fail") && text.contains("! at lower bound") && text.contains("= tied"));
    }
}
