//! Parameters of an update with their uncertainties, as text and as JSON.

use retune::update::{IntervalMethod, ParameterChange, ParameterUncertainty, Update};
use retune_report::text::{Align, Cell, Style, Table, Tone, brief, number, paragraph};
use std::fmt::Write as _;

/// Correlations below this are not worth a line.
const STRONG: f64 = 0.9;

/// The parameters of an update, and what the data say about them.
pub(crate) fn parameters(u: &Update, style: &Style) -> String {
    let full = full_table(u);
    let table = if full.natural_width() <= style.width { full.render(style) } else { narrow_table(u, style) };
    table + &folded(&remarks(u), style)
}

/// What is to be known of a parameter beside its numbers: a mark, and the words for it.
fn note(p: &ParameterChange, known: Option<&ParameterUncertainty>) -> (&'static str, &'static str) {
    match known {
        None => ("c", "constant"),
        Some(_) if p.at_bound => ("*", "on its bound"),
        Some(k) if k.is_undetermined() => ("?", "not determined"),
        Some(k) if k.method == IntervalMethod::Unconfirmed => ("~", "interval unconfirmed"),
        Some(_) => ("", ""),
    }
}

fn known<'a>(u: &'a Update, p: &ParameterChange) -> Option<&'a ParameterUncertainty> {
    u.uncertainty.parameters.iter().find(|k| k.name == p.name)
}

fn range(ends: Option<(f64, f64)>, write: fn(f64) -> String) -> String {
    ends.map_or_else(|| "–".to_string(), |(l, h)| format!("{} … {}", write(l), write(h)))
}

fn full_table(u: &Update) -> Table {
    let mut table = Table::new([
        ("parameter", Align::Left),
        ("before", Align::Right),
        ("after", Align::Right),
        ("± sd", Align::Right),
        ("90 % interval", Align::Left),
        ("bounds", Align::Left),
        ("unit", Align::Left),
        ("", Align::Left),
    ]);
    for p in &u.parameters {
        let known = known(u, p);
        let (_, words) = note(p, known);
        table.row([
            p.name.as_str().into(),
            number(p.before).into(),
            number(p.after).into(),
            known.and_then(|k| k.sd).map_or_else(|| "–".to_string(), number).into(),
            range(known.map(|k| (k.interval[0], k.interval[1])), number).into(),
            range(p.lower.zip(p.upper), number).into(),
            p.unit.as_str().into(),
            Cell::new(words, if known.is_some() { Tone::Warning } else { Tone::Dim }),
        ]);
    }
    table
}

/// Three digits, no standard deviations, marks in place of notes: for a terminal of 80 columns.
fn narrow_table(u: &Update, style: &Style) -> String {
    let mut table = Table::new([
        ("parameter", Align::Left),
        ("before", Align::Right),
        ("after", Align::Right),
        ("", Align::Right),
        ("90 % interval", Align::Right),
        ("bounds", Align::Right),
        ("unit", Align::Left),
    ]);
    let mut marks: Vec<(&str, &str)> = Vec::new();
    for p in &u.parameters {
        let known = known(u, p);
        let (mark, words) = note(p, known);
        if !mark.is_empty() && !marks.contains(&(mark, words)) {
            marks.push((mark, words));
        }
        table.row([
            p.name.as_str().into(),
            brief(p.before).into(),
            brief(p.after).into(),
            Cell::new(mark, if known.is_some() { Tone::Warning } else { Tone::Dim }),
            range(known.map(|k| (k.interval[0], k.interval[1])), brief).into(),
            range(p.lower.zip(p.upper), brief).into(),
            p.unit.as_str().into(),
        ]);
    }
    let keys: Vec<String> = marks.iter().map(|(mark, words)| format!("{mark} {words}")).collect();
    let keys = if keys.is_empty() { String::new() } else { format!("{}\n", keys.join("   ")) };
    table.render(style) + &keys
}

/// Lines no wider than the style; what is continued stands two columns further in.
pub(crate) fn folded(text: &str, style: &Style) -> String {
    let indent = |line: &str| " ".repeat(line.len() - line.trim_start_matches(' ').len() + 2);
    text.lines().map(|line| paragraph(line, &indent(line), style.width)).collect()
}

/// What cannot be told apart, what goes together, what sits on a bound, and what limits the numbers.
fn remarks(u: &Update) -> String {
    let c = &u.uncertainty;
    let n = c.parameters.len();
    let undetermined: Vec<&str> =
        c.parameters.iter().filter(|p| p.is_undetermined()).map(|p| p.name.as_str()).collect();
    let mut out = if undetermined.is_empty() {
        format!("\nthe data determine {} of {n} combinations of parameters\n", c.rank)
    } else {
        format!(
            "\nthe data respond to {} of {n} combinations of parameters, but near these values they set no limit inside the bounds of: {}\n",
            c.rank,
            undetermined.join(", ")
        )
    };
    for g in &c.inseparable {
        let names = g.parameters.join(", ");
        let _ = match g.n_numbers {
            0 => writeln!(out, "{names}: no effect on the data near these values"),
            1 => writeln!(out, "{names} act only through {}", g.combinations[0]),
            k => writeln!(out, "{names} act only through {k} numbers: {}", g.combinations.join("; ")),
        };
        if !g.shared.is_empty() {
            let _ = writeln!(out, "  what the data determine of them includes: {}", g.shared.join(", "));
        }
    }
    for (i, p) in c.parameters.iter().enumerate() {
        let strong = (i + 1..n).filter(|&j| c.correlations[(i, j)].abs() >= STRONG);
        let words: Vec<String> =
            strong.map(|j| format!("{} ({:+.2})", c.parameters[j].name, c.correlations[(i, j)])).collect();
        if !words.is_empty() {
            let _ = writeln!(out, "{} is correlated with {}", p.name, words.join(", "));
        }
    }
    if c.parameters.iter().any(|p| p.method == IntervalMethod::Unconfirmed) {
        out += "interval unconfirmed: the curvature at the optimum gives it, but further away the cost is no parabola, and no profile was found\n";
    }
    let without: Vec<String> =
        c.parameters.iter().filter_map(|p| Some(format!("{} ({})", p.name, p.why_no_sd()?))).collect();
    if n > 1 && !without.is_empty() {
        let _ = writeln!(out, "no standard deviation and no correlation: {}", without.join(", "));
    }
    out += &alternatives(u);
    let on_bounds: Vec<_> = u.parameters.iter().filter(|p| p.at_bound && p.lower.is_some()).collect();
    if !on_bounds.is_empty() {
        let (sits, it) = if on_bounds.len() == 1 { ("sits", "the parameter") } else { ("sit", "the parameters") };
        let _ = writeln!(
            out,
            "\n{} of {n} parameters {sits} on a bound: that says something about the model, not about {it}",
            on_bounds.len()
        );
    }
    for (p, held) in c.parameters.iter().filter_map(|p| p.held.map(|h| (p, h))) {
        let side = if held.is_upper { "upper" } else { "lower" };
        let unit = u.parameters.iter().find(|q| q.name == p.name).map_or("", |q| q.unit.as_str());
        let _ = match held.would_be {
            Some(v) => writeln!(
                out,
                "  {}: its {side} bound holds it; without it the fit would go on to about {} {unit}, and the squared misfit would fall by {}",
                p.name,
                number(v),
                number(held.gain)
            ),
            None => writeln!(
                out,
                "  {}: only its {side} bound holds it; without it the squared misfit would fall by {}",
                p.name,
                number(held.gain)
            ),
        };
    }
    for remark in &c.remarks {
        let _ = writeln!(out, "note: {remark}");
    }
    out
}

/// Other sets of parameters that fit as well, each with its intervals.
fn alternatives(u: &Update) -> String {
    let (first, others) = match u.alternatives.as_slice() {
        [] => return String::new(),
        [_] => ("another set of parameters fits", "it"),
        _ => ("other sets of parameters fit", "them"),
    };
    let mut out = format!("\n{first} as well; nothing in the data chooses between {others} and the one above\n");
    for a in &u.alternatives {
        let value = |p: &ParameterChange| {
            let k = a.uncertainty.parameters.iter().find(|k| k.name == p.name)?;
            let [low, high] = k.interval.map(number);
            Some(format!("{} = {} {} ({low} … {high})", p.name, number(p.after), p.unit))
        };
        let values: Vec<String> = a.parameters.iter().filter_map(value).collect();
        let _ = writeln!(
            out,
            "  {}; squared misfit {:.2} in place of {:.2}",
            values.join(", "),
            2.0 * a.cost,
            2.0 * u.optimum.cost
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_folded_at_blanks_and_stand_further_in() {
        let style = Style { color: false, width: 30 };
        let text = "\n  m1: its lower bound holds it; it would go on\nshort\n";
        assert_eq!(folded(text, &style), "\n  m1: its lower bound holds\n    it; it would go on\nshort\n");
    }
}
