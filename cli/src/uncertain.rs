//! Parameters of an update with their uncertainties, as text and as JSON.

use retune::report::text::{Align, Cell, Style, Table, Tone, number};
use retune::update::{IntervalMethod, ParameterUncertainty, Uncertainty, Update};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// Correlations below this are not worth a line.
const STRONG: f64 = 0.9;

/// The parameters of an update, and what the data say about them.
pub(crate) fn parameters(u: &Update, style: &Style) -> String {
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
    let pair = |a: f64, b: f64| format!("{} … {}", number(a), number(b));
    for p in &u.parameters {
        let known = u.uncertainty.parameters.iter().find(|k| k.name == p.name);
        let bounds = p.lower.zip(p.upper).map_or_else(|| "–".to_string(), |(l, h)| pair(l, h));
        let note = match known {
            None => Cell::new("constant", Tone::Dim),
            Some(_) if p.at_bound => Cell::new("on its bound", Tone::Warning),
            Some(k) if k.is_undetermined() => Cell::new("not determined", Tone::Warning),
            Some(k) if k.method == IntervalMethod::Unconfirmed => Cell::new("interval unconfirmed", Tone::Warning),
            Some(_) => "".into(),
        };
        table.row([
            p.name.as_str().into(),
            number(p.before).into(),
            number(p.after).into(),
            known.and_then(|k| k.sd).map_or_else(|| "–".to_string(), number).into(),
            known.map_or_else(|| "–".to_string(), |k| pair(k.interval[0], k.interval[1])).into(),
            bounds.into(),
            p.unit.as_str().into(),
            note,
        ]);
    }
    table.render(style) + &remarks(u)
}

/// What cannot be told apart, what goes together, what sits on a bound, and what limits the numbers.
fn remarks(u: &Update) -> String {
    let c = &u.uncertainty;
    let n = c.parameters.len();
    let mut out = format!("\nthe data see {} of {n} parameter combinations\n", c.rank);
    for g in &c.inseparable {
        let names = g.parameters.join(", ");
        let _ = match g.n_numbers {
            0 => writeln!(out, "{names}: no effect on the data"),
            1 => writeln!(out, "{names} act only through {}", g.combinations[0]),
            k => writeln!(out, "{names} act only through {k} numbers: {}", g.combinations.join("; ")),
        };
        if !g.shared.is_empty() {
            let _ = writeln!(out, "  what the data see of them includes: {}", g.shared.join(", "));
        }
    }
    let undetermined: Vec<&str> =
        c.parameters.iter().filter(|p| p.is_undetermined()).map(|p| p.name.as_str()).collect();
    if !undetermined.is_empty() {
        let _ = writeln!(out, "not determined, any value between the bounds fits: {}", undetermined.join(", "));
    }
    for (i, p) in c.parameters.iter().enumerate() {
        let strong = (i + 1..n).filter(|&j| c.correlations[(i, j)].abs() >= STRONG);
        let words: Vec<String> =
            strong.map(|j| format!("{} ({:+.2})", c.parameters[j].name, c.correlations[(i, j)])).collect();
        if !words.is_empty() {
            let _ = writeln!(out, "{} is correlated with {}", p.name, words.join(", "));
        }
    }
    let on_bounds: Vec<_> = u.parameters.iter().filter(|p| p.at_bound && p.lower.is_some()).collect();
    if !on_bounds.is_empty() {
        let _ = writeln!(
            out,
            "\n{} of {n} parameters sit on a bound: that says something about the model, not about the parameters",
            on_bounds.len()
        );
    }
    for (p, held) in c.parameters.iter().filter_map(|p| p.held.map(|h| (p, h))) {
        let side = if held.is_upper { "upper" } else { "lower" };
        let unit = u.parameters.iter().find(|q| q.name == p.name).map_or("", |q| q.unit.as_str());
        let _ = match held.would_be {
            Some(v) => writeln!(
                out,
                "  {}: its {side} bound holds it; it would go on to about {} {unit}, and the squared misfit fall by {}",
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

/// `parameters[]` of `retune update --json`.
pub(crate) fn parameters_json(u: &Update) -> Value {
    let c = &u.uncertainty;
    let one = |p: &retune::update::ParameterChange| {
        let mut entry = json!({
            "name": p.name, "unit": p.unit, "before": p.before, "after": p.after,
            "lower": p.lower, "upper": p.upper, "at_bound": p.at_bound,
        });
        let place = c.parameters.iter().position(|k| k.name == p.name);
        if let (Some(i), Some(entry)) = (place, entry.as_object_mut()) {
            entry.extend(known_json(&c.parameters[i]));
            entry.insert("correlations".to_string(), correlations_json(c, i));
        }
        entry
    };
    u.parameters.iter().map(one).collect()
}

fn known_json(p: &ParameterUncertainty) -> Map<String, Value> {
    let held = p
        .held
        .map(|h| json!({"bound": if h.is_upper { "upper" } else { "lower" }, "would_be": h.would_be, "gain": h.gain}));
    let entries = [
        ("sd", json!(p.sd)),
        ("interval", json!(p.interval)),
        ("interval_ends_at_bound", json!(p.ends_at_bound)),
        ("interval_method", json!(p.method.word())),
        ("determined", json!(!p.is_undetermined())),
        ("held", json!(held)),
    ];
    entries.into_iter().map(|(k, v)| (k.to_string(), v)).collect()
}

/// Correlations with the other parameters that have a standard deviation.
fn correlations_json(c: &Uncertainty, i: usize) -> Value {
    let others =
        (0..c.parameters.len()).filter(|&j| j != i && c.parameters[i].sd.is_some() && c.parameters[j].sd.is_some());
    Value::Object(others.map(|j| (c.parameters[j].name.clone(), json!(c.correlations[(i, j)]))).collect())
}

/// `unidentifiable[]` of `retune update --json`.
pub(crate) fn unidentifiable_json(c: &Uncertainty) -> Value {
    let one = |g: &retune::update::Inseparable| json!({"parameters": g.parameters, "numbers": g.n_numbers, "combinations": g.combinations, "shared": g.shared});
    c.inseparable.iter().map(one).collect()
}
