//! What a diagnosis and a history of learning say on a terminal.

use super::{Align, Cell, Style, Table, Tone, bar, brief, broken, chance, number, printable, wrap};
use crate::data::{Category, Damping, Diagnosis, Estimate, Hypothesis, Outcome, Step, Steps};
use retune::correlation::odds;
use retune::effect::{Effect, Effects};
use std::fmt::Write as _;
use unicode_width::UnicodeWidthStr;

/// Rows of the table of hypotheses.
const SHOWN: usize = 10;
/// Proposals for the next measurement.
const PROPOSALS: usize = 5;
/// Columns of a bar.
const BAR: usize = 20;

/// Words for the model and the test where the files are not known.
pub const FILES: [&str; 2] = ["MODEL", "TEST"];

/// A diagnosis: the answer, what was tried, the hypotheses with their estimates, the edit, the next measurement.
///
/// Names of hypotheses are never cut: somebody will type them after `retune add`.
///
/// * `[model, test]` - the files, as they are named in the command that puts the effect in
pub fn diagnosis(d: &Diagnosis, [model, test]: [&str; 2], style: &Style) -> String {
    let mut out = String::new();
    let (sign, word, tone) = match d.outcome {
        Outcome::Adequate => ("✓", "adequate", Tone::Good),
        Outcome::MissingEffect => ("!", "missing effect", Tone::Warning),
        Outcome::MeasurementFault => ("!", "measurement fault", Tone::Warning),
        Outcome::Tied => ("!", "tied", Tone::Warning),
        Outcome::SeveralEffects => ("✕", "several effects", Tone::Bad),
        Outcome::Unexplained => ("✕", "unexplained", Tone::Bad),
        Outcome::NoiseOrModel => ("✕", "noise or model", Tone::Bad),
    };
    let lead = format!("{sign} {word}: ");
    for (i, line) in broken(&format!("{lead}{}", printable(&d.sentence)), style.width).iter().enumerate() {
        let line = match line.strip_prefix(lead.trim_end()).filter(|_| i == 0) {
            Some(rest) => format!("{}{rest}", style.paint(tone, lead.trim_end())),
            None => line.clone(),
        };
        let _ = writeln!(out, "{line}");
    }
    out.push('\n');
    if let (Some(m), Some(dof)) = (d.misfit, d.degrees_of_freedom) {
        let p = d.p_value.map_or_else(String::new, |p| {
            format!("; in {} tests some hypothesis looks as good as the best one here by noise alone", odds(p))
        });
        paragraph(
            &mut out,
            &format!("misfit of the fitted model {}, noise alone leaves about {}{p}", number(m), number(dof)),
            style,
        );
    }
    if !d.tried.is_empty() {
        paragraph(&mut out, &format!("tried: {}", d.tried), style);
    }
    out.push('\n');
    out.push_str(&hypotheses(d, style));
    let held = d.hypotheses.iter().any(|h| h.held_out_after.is_some());
    let mut legend =
        "P: prior odds times Bayes factor, over the sum of all; ln B: against the fitted model; misfit: sum of \
                      ((model - test)/sd)² after a refit"
            .to_string();
    if held {
        legend += "; held out: every mode predicted from the others";
    }
    // Of two both are named, of more the first.
    let is_of_more = |h: &Hypothesis| h.id == "together" && h.kind.matches(" + ").count() > 1;
    let n_named = match d.outcome {
        Outcome::SeveralEffects if !d.hypotheses.iter().any(is_of_more) => 2,
        _ => 1,
    };
    if d.outcome == Outcome::SeveralEffects {
        legend += match n_named {
            2 => "; the first two: P of being one of the two, ln B against the other alone",
            _ => "; the first: P of being one of those that are wrong",
        };
    }
    out.push('\n');
    for line in wrap(&legend, style.width) {
        let _ = writeln!(out, "{}", style.paint(Tone::Dim, &line));
    }
    let is_named = |h: &Hypothesis| match d.outcome {
        Outcome::Adequate | Outcome::NoiseOrModel => false,
        Outcome::Unexplained => h.probability.is_some_and(|p| p > 0.5),
        _ => true,
    };
    for best in d.hypotheses.iter().take(n_named).filter(|h| is_named(h) && !h.patch.is_empty()) {
        let what =
            if best.category == Category::Effect { format!("retune add {model} ") } else { "to do about ".to_string() };
        let needs_sensors = Effects::builtin().find(&best.kind).is_some_and(Effect::needs_sensors);
        let test = if needs_sensors { format!(" --test {test}") } else { String::new() };
        let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, &format!("{what}{}{test}", printable(&best.id))));
        for line in best.patch.lines() {
            for part in flowed(line, style.width.saturating_sub(2)) {
                let _ = writeln!(out, "  {}", printable(&part));
            }
        }
    }
    if !d.next_measurements.is_empty() {
        out.push('\n');
        /// ln B that would be worth a remark.
        const WORTH: f64 = 1.0;
        let is_worth = d.next_measurements.iter().any(|m| m.expected_log_bayes_factor.is_none_or(|v| v >= WORTH));
        let title = if is_worth {
            "what would separate the tied ones"
        } else {
            "no single measurement would separate the tied ones; these come nearest"
        };
        let _ = writeln!(out, "{}", style.paint(Tone::Strong, title));
        let mut table = Table::new([("expected ln B", Align::Right), ("measure", Align::Left)]).wrapping_last();
        for m in d.next_measurements.iter().take(PROPOSALS) {
            let value = m.expected_log_bayes_factor.map_or_else(|| "–".to_string(), |v| format!("{v:.1}"));
            table.row([value.into(), m.what.as_str().into()]);
        }
        out.push_str(&table.render(style));
    }
    if let Some(found) = &d.damping {
        let _ = writeln!(out, "\n{}", style.paint(Tone::Strong, "damping, which the model does not have"));
        paragraph(&mut out, &found.sentence, style);
        out.push_str(&laws(found, style));
    }
    if !d.warnings.is_empty() {
        out.push('\n');
    }
    for warning in &d.warnings {
        paragraph(&mut out, &format!("note: {warning}"), style);
    }
    out
}

/// The first laws of damping that are not hopeless.
fn laws(found: &Damping, style: &Style) -> String {
    /// Laws of less are not shown.
    const HOPELESS: f64 = 0.01;
    let columns = [("P", Align::Right), ("ln B", Align::Right), ("misfit", Align::Right), ("law", Align::Left)];
    let mut table = Table::new(columns).wrapping_last();
    for law in found.laws.iter().filter(|l| l.probability.is_some_and(|p| p >= HOPELESS)) {
        let words: Vec<String> = law.estimates.iter().map(estimate).collect();
        table.row([
            Cell::new(law.probability.map_or_else(|| "–".into(), chance), Tone::Strong),
            law.log_bayes_factor.map_or_else(String::new, |b| format!("{b:.1}")).into(),
            law.misfit_after.map_or_else(String::new, number).into(),
            words.join("; ").into(),
        ]);
    }
    table.render(style)
}

fn paragraph(out: &mut String, text: &str, style: &Style) {
    for line in wrap(&printable(text), style.width) {
        let _ = writeln!(out, "{line}");
    }
}

/// A line of a patch on several: broken after blanks, continued four columns further in, which YAML reads as one.
fn flowed(line: &str, width: usize) -> Vec<String> {
    let indent = line.len() - line.trim_start().len();
    if line.width() <= width || indent + 12 > width {
        return vec![line.to_string()];
    }
    let mut out: Vec<String> = Vec::new();
    let mut now = " ".repeat(indent);
    let mut is_fresh = true;
    for word in line.split_whitespace() {
        if !is_fresh && now.width() + 1 + word.width() > width {
            out.push(std::mem::replace(&mut now, " ".repeat(indent + 4)));
            is_fresh = true;
        }
        if !is_fresh {
            now.push(' ');
        }
        now.push_str(word);
        is_fresh = false;
    }
    out.push(now);
    out
}

/// The estimate as a reader wants it: `offset 0.0821 m (90 %: 0.0787 … 0.0854)`.
fn estimate(e: &Estimate) -> String {
    let unit = if e.unit.is_empty() { String::new() } else { format!(" {}", e.unit) };
    let interval = e.interval.map_or_else(String::new, |[l, u]| {
        let label = if e.interval_label.is_empty() { String::new() } else { format!("{}: ", e.interval_label) };
        format!(" ({label}{} … {})", brief(l), brief(u))
    });
    format!("{} {}{unit}{interval}", e.quantity, brief(e.value))
}

fn hypotheses(d: &Diagnosis, style: &Style) -> String {
    let columns = [
        ("P", Align::Right),
        ("ln B", Align::Right),
        ("misfit", Align::Right),
        ("held out", Align::Right),
        ("hypothesis", Align::Left),
    ];
    let tied: &[String] = d.hypotheses.first().map_or(&[], |h| &h.tied_with);
    let numbers = |h: &Hypothesis| -> Vec<Cell> {
        let is_model = matches!(h.category, Category::None);
        let misfit = if is_model { d.misfit.or(h.misfit_before) } else { h.misfit_after };
        let held = if is_model { h.held_out_before } else { h.held_out_after };
        vec![
            Cell::new(h.probability.map_or_else(|| "–".into(), chance), Tone::Strong),
            h.log_bayes_factor.map_or_else(String::new, |b| format!("{b:.1}")).into(),
            misfit.map_or_else(String::new, number).into(),
            held.map_or_else(String::new, number).into(),
        ]
    };
    // The ten best, and the two that are always compared.
    let shown = || {
        d.hypotheses
            .iter()
            .enumerate()
            .filter(|(i, h)| *i < SHOWN || matches!(h.category, Category::None | Category::Other))
    };
    let name = |i: usize, h: &Hypothesis| {
        let tie = if i > 0 && tied.contains(&h.id) { " = tied with the first" } else { "" };
        if matches!(h.category, Category::None | Category::Other) { h.kind.clone() } else { format!("{}{tie}", h.id) }
    };
    let words = |h: &Hypothesis| h.estimates.iter().map(estimate).collect::<Vec<_>>().join("; ");
    let where_on_mesh = |h: &Hypothesis| Some(h.place.on_mesh.clone()).filter(|at| !at.is_empty());
    // Under the hypothesis, in the last column of the narrow table and the last but one of the wide.
    let below = |line: String| {
        let blank = std::iter::repeat_n("", columns.len() - 1).map(Cell::from);
        blank.chain([Cell::new(format!("  {line}"), Tone::Dim)])
    };
    let mut wide = Table::new(columns.into_iter().chain([("estimate", Align::Left)]));
    for (i, h) in shown() {
        wide.row(numbers(h).into_iter().chain([name(i, h).into(), words(h).into()]));
        if let Some(at) = where_on_mesh(h) {
            wide.row(below(at));
        }
    }
    if wide.natural_width() <= style.width {
        return wide.render(style);
    }
    let mut narrow = Table::new(columns).wrapping_last();
    for (i, h) in shown() {
        narrow.row(numbers(h).into_iter().chain([name(i, h).into()]));
        for line in where_on_mesh(h).into_iter().chain(h.estimates.iter().map(estimate)) {
            narrow.row(below(line));
        }
    }
    narrow.render(style)
}

/// The error over the steps: in total with what was held out, then mode by mode.
pub fn steps(s: &Steps, style: &Style) -> String {
    let mut out = String::new();
    let largest = s.steps.iter().map(|x| x.misfit).filter(|v| v.is_finite()).fold(0.0, f64::max).max(1e-300);
    let held = s.steps.iter().any(|x| x.held_out.is_some());
    let mut columns = vec![("", Align::Right), ("misfit", Align::Right), ("", Align::Left)];
    if held {
        columns.push(("held out", Align::Right));
    }
    columns.push(("step", Align::Left));
    let mut table = Table::new(columns).wrapping_last();
    let width = if style.width < 90 { BAR / 2 } else { BAR };
    for (i, x) in s.steps.iter().enumerate() {
        let mut row: Vec<Cell> =
            vec![i.to_string().into(), number(x.misfit).into(), bar(x.misfit / largest, width).into()];
        if held {
            row.push(x.held_out.map_or_else(|| "–".to_string(), number).into());
        }
        row.push(x.name.as_str().into());
        table.row(row);
    }
    out.push_str(&table.render(style));
    if let Some(floor) = s.noise_floor {
        let _ = writeln!(out, "{}", style.paint(Tone::Dim, &format!("noise alone leaves about {}", number(floor))));
    }
    let is_modal = s.steps.len() > 1 && s.steps.iter().all(|x| x.per_mode.len() == s.mode_labels.len());
    if is_modal && !s.mode_labels.is_empty() {
        let heads: Vec<String> = (0..s.steps.len()).map(|i| format!("step {i}")).collect();
        let mut table = Table::new(
            [("misfit per mode", Align::Left)].into_iter().chain(heads.iter().map(|h| (h.as_str(), Align::Right))),
        );
        for (m, label) in s.mode_labels.iter().enumerate() {
            let values = s.steps.iter().map(|x| x.per_mode[m].map_or_else(|| "–".to_string(), number).into());
            table.row([Cell::from(label)].into_iter().chain(values));
        }
        out.push('\n');
        out.push_str(&table.render(style));
    }
    for note in rises(s) {
        paragraph(&mut out, &note, style);
    }
    out
}

/// Why a misfit may rise from one step to the next, and in which mode it does most.
fn rises(s: &Steps) -> Vec<String> {
    /// A larger misfit by less than this share is rounding of the fit.
    const VISIBLE: f64 = 0.01;
    let steps = s.steps.windows(2).enumerate().filter(|(_, w)| w[1].misfit > (1.0 + VISIBLE) * w[0].misfit);
    let one = |(i, w): (usize, &[Step])| {
        let risen = |m: &usize| Some(w[1].per_mode.get(*m).copied()?? - w[0].per_mode.get(*m).copied()?.unwrap_or(0.0));
        let most = (0..s.mode_labels.len())
            .filter_map(|m| Some((m, risen(&m)?)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map_or_else(String::new, |(m, _)| format!(", most in {}", s.mode_labels[m]));
        format!(
            "note: the misfit rises from step {i} to step {}{most}: at every step modes are paired anew, and each has the misfit of its own pairs",
            i + 1
        )
    };
    steps.map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::fixture::wing;
    use super::*;

    #[test]
    fn a_diagnosis_fits_the_terminal_and_cuts_nothing() {
        let data = wing::report();
        let d = data.diagnosis.as_ref().unwrap();
        for width in [60, 80, 100, 120, 160] {
            let text = diagnosis(d, FILES, &Style { color: false, width });
            // Wrapped lines put together again.
            let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
            // The sign stands in intervals only, never for something cut.
            assert_eq!(flat.matches('…').count(), flat.matches(" … ").count(), "{text}");
            for h in &d.hypotheses {
                assert!(flat.contains(&h.id) || flat.contains(&h.kind), "{} at {width}:\n{text}", h.id);
            }
            assert!(flat.contains("offset aft of the spar 61.0 mm (90 %: 52.0 … 70.0)"), "{width}: {text}");
            assert!(text.lines().all(|l| l.width() <= width || l.starts_with("  #")), "{width}: {text}");
            assert!(flat.contains("= tied with the first") && flat.contains("retune add MODEL mass-offset@outer_wing"));
        }
    }

    #[test]
    fn a_patch_that_flows_over_lines_is_still_the_same_yaml() {
        let patch = "edits:\n  - add_parameter: {name: mass_offset.left_wing.offset, unit: m, neutral: 0, typical: 0.0635, \
                     bounds: [-0.318, 0.318], description: \"centres of gravity beside the axis of left_wing\"}\n";
        let flowed: String = patch.lines().flat_map(|l| flowed(l, 60)).map(|l| l + "\n").collect();
        assert!(flowed.lines().all(|l| l.width() <= 60) && flowed.lines().count() > 3);
        let read = |text: &str| serde_yaml::from_str::<serde_json::Value>(text).unwrap();
        assert_eq!(read(patch), read(&flowed));
    }

    #[test]
    fn steps_show_the_error_in_total_and_per_mode() {
        let data = wing::report();
        for width in [60, 80, 120] {
            let text = steps(data.steps.as_ref().unwrap(), &Style { color: false, width });
            for word in ["initial", "refitted", "+ mass-offset @ outer wing", "held out", "212.4", "41.20", "step 3"] {
                assert!(text.contains(word), "{word} at {width}:\n{text}");
            }
            assert!(text.lines().all(|l| l.width() <= width), "{width}: {text}");
            assert!(!text.contains("rises"), "{text}");
        }
    }

    /// A misfit that rises looks like a fault of the fit: the step that does says why.
    #[test]
    fn a_step_that_rises_says_why_and_where() {
        let mut data = wing::report().steps.unwrap();
        data.steps[1].misfit = 2.0 * data.steps[0].misfit;
        data.steps[1].per_mode[1] = Some(1e3);
        let text = steps(&data, &Style { color: false, width: 400 });
        let told = format!(
            "rises from step 0 to step 1, most in {}: at every step modes are paired anew",
            data.mode_labels[1]
        );
        assert!(text.contains(&told), "{text}");
    }
}
