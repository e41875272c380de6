//! Values of a model file as YAML: numbers, lists, maps, comments.

/// A line longer than this is broken.
const WIDTH: usize = 140;

/// A text of one line in quotation marks.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", clean(text).replace('\\', "\\\\").replace('"', "\\\""))
}

/// A comment on one line, without control characters.
pub(crate) fn clean(text: &str) -> String {
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    text.trim().to_string()
}

/// The value itself in as few digits as give it back.
pub(crate) fn exact(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_string()
    } else if (1e-4..1e9).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A value that was computed, to twelve digits.
pub(crate) fn computed(value: f64) -> String {
    exact(rounded(value))
}

/// A value to twelve significant digits.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// A number with a unit.
pub(crate) fn with_unit(number: &str, unit: &str) -> String {
    if unit.is_empty() { number.to_string() } else { format!("{number} {unit}") }
}

/// A flow list, broken into lines where it is long.
pub(crate) fn list<T: AsRef<str>>(items: &[T]) -> String {
    let total: usize = items.iter().map(|i| i.as_ref().len() + 2).sum();
    if total < WIDTH - 20 {
        return format!("[{}]", items.iter().map(AsRef::as_ref).collect::<Vec<_>>().join(", "));
    }
    let mut out = String::with_capacity(total + total / 20);
    out.push('[');
    let mut column = WIDTH;
    for item in items {
        let item = item.as_ref();
        if column + item.len() + 2 > WIDTH {
            out.push_str("\n    ");
            column = 4;
        }
        out.push_str(item);
        out.push_str(", ");
        column += item.len() + 2;
    }
    let kept = out.trim_end_matches([',', ' ']).len();
    out.truncate(kept);
    out.push(']');
    out
}

/// A flow map.
pub(crate) fn map<K: AsRef<str>, V: AsRef<str>>(items: &[(K, V)]) -> String {
    let parts: Vec<String> = items.iter().map(|(k, v)| format!("{}: {}", k.as_ref(), v.as_ref())).collect();
    format!("{{{}}}", parts.join(", "))
}

/// Three directions.
pub(crate) fn direction(v: [f64; 3]) -> String {
    let shown = v.map(|c| computed(if c.abs() < 1e-15 { 0.0 } else { c }));
    format!("[{}]", shown.join(", "))
}

/// The entry of a frame: its origin as text and its axes, kept to the last bit.
pub(crate) fn frame(origin: impl std::fmt::Display, axes: [[f64; 3]; 3]) -> String {
    let whole = |v: [f64; 3]| {
        if v.iter().all(|c| *c == 0.0 || c.abs() == 1.0) {
            direction(v)
        } else {
            format!("[{}]", v.map(exact).join(", "))
        }
    };
    format!("{{origin: {origin}, x: {}, xy: {}}}", whole(axes[0]), whole(axes[1]))
}
