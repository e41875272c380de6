//! What an engineer would want to be told about a test that can be read.

use crate::data::{Place, Sensor, TestData, TestMode};
use crate::yaml::{Problem, child};
use retune_linalg::Complex;

/// Relative standard deviations of a frequency beyond these are slips of a unit more often than meant.
const FREQUENCY_SD: [f64; 2] = [1e-6, 0.2];
/// The same of a shape, relative to its largest entry.
const SHAPE_SD: [f64; 2] = [1e-5, 0.5];
/// No structure that is tested for its modes has such a damping ratio.
const DAMPING: f64 = 0.5;
/// Squared cosine above which two shapes are one.
const ALIKE: f64 = 0.98;

/// Standard deviations over their value beyond which nothing is measured, or everything exactly: squares of their ratios have no digits left.
const SENSIBLE_SD: [f64; 2] = [1e-15, 1e9];

/// Whether a standard deviation can be meant for a value.
pub(super) fn is_sensible_sd(sd: f64, value: f64) -> bool {
    // A share of nothing is nothing: then the value itself is wrong, which is said elsewhere.
    if sd == 0.0 && value == 0.0 {
        return true;
    }
    let [least, most] = SENSIBLE_SD;
    // Beside a value of zero any size may be meant, as long as its square is a number.
    let size = if value == 0.0 { 1.0 } else { value.abs() };
    (least * size..=most * size).contains(&sd)
}

/// What is wrong with one that cannot.
pub(super) fn senseless_sd(sd: f64, unit: &str, value: f64) -> String {
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let advice = if sd > value.abs() {
        "leave out a value that says nothing"
    } else {
        "nothing is known so well; write what repeated measurements scatter by"
    };
    format!("a standard deviation of {sd:e}{unit} for a value of {value}{unit}: {advice}")
}

/// Doubtful things of a test, with their paths.
pub(super) fn doubts(data: &TestData) -> Vec<Problem> {
    let mut out = numbers(&data.modes);
    same_modes(&data.modes, &mut out);
    lonely_spaces(&data.modes, &mut out);
    sensors(data, &mut out);
    out
}

fn name(mode: &TestMode) -> String {
    let hz = format!("{:.6}", mode.frequency_hz.value);
    format!("the mode at {} Hz", hz.trim_end_matches('0').trim_end_matches('.'))
}

fn percent(ratio: f64) -> String {
    let value = 100.0 * ratio;
    if value >= 0.1 { format!("{value:.1} %") } else { format!("{value:.1e} %") }
}

/// A question to a mode.
type Doubt<'a> = &'a dyn Fn(&TestMode) -> Option<String>;

/// What is doubtful in the numbers of modes: of every kind the first, and how many more there are.
fn numbers(modes: &[TestMode]) -> Vec<Problem> {
    let frequency = |m: &TestMode| {
        let relative = m.frequency_hz.sd / m.frequency_hz.value;
        let is_odd = !m.frequency_hz.sd_is_default && !(FREQUENCY_SD[0]..=FREQUENCY_SD[1]).contains(&relative);
        is_odd.then(|| format!("its frequency has a standard deviation of {}; is that meant?", percent(relative)))
    };
    let shape = |m: &TestMode| {
        let largest = m.shape.as_ref()?.iter().map(|v| v.norm()).filter(|v| v.is_finite()).fold(0.0, f64::max);
        let sd = m.shape_sd.as_ref()?.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        let relative = sd / largest;
        let is_odd = relative.is_finite() && !(SHAPE_SD[0]..=SHAPE_SD[1]).contains(&relative);
        is_odd.then(|| {
            format!("its shape has a standard deviation of {} of the largest entry; is that meant?", percent(relative))
        })
    };
    let damping = |m: &TestMode| {
        let ratio = m.damping_ratio.filter(|d| d.value > DAMPING)?.value;
        Some(format!(
            "a damping ratio of {ratio} is {} of the critical one; {ratio} percent is written `{ratio} %`",
            percent(ratio)
        ))
    };
    let kinds: [Doubt<'_>; 3] = [&frequency, &shape, &damping];
    let mut out = Vec::new();
    for of in kinds {
        let found: Vec<(&TestMode, String)> = modes.iter().filter_map(|m| Some((m, of(m)?))).collect();
        let Some((mode, text)) = found.first() else { continue };
        let others = match found.len() - 1 {
            0 => String::new(),
            n => format!(" (and {n} more modes like it)"),
        };
        out.push(Problem::warning("modes", format!("{}{others}: {text}", name(mode))));
    }
    out
}

/// Names of spaces that one mode has alone: nothing is mixed with it.
fn lonely_spaces(modes: &[TestMode], out: &mut Vec<Problem>) {
    for (k, mode) in modes.iter().enumerate() {
        let Some(space) = &mode.space else { continue };
        if modes.iter().filter(|m| m.space.as_ref() == Some(space)).count() == 1 {
            let text = format!(
                "{} is alone in the space `{space}`: give the modes that are mixed with it the same name",
                name(mode)
            );
            out.push(Problem::warning(child(&format!("modes[{k}]"), "space"), text));
        }
    }
}

/// Modes that look like one, listed twice; shapes that are all alike.
fn same_modes(modes: &[TestMode], out: &mut Vec<Problem>) {
    let shapes: Vec<_> = modes.iter().filter_map(|m| m.shape.as_ref()).collect();
    if shapes.len() > 2 && shapes.iter().skip(1).all(|s| likeness(shapes[0].as_slice(), s.as_slice()) > ALIKE) {
        let text = format!("all {} shapes are alike: is one row repeated?", shapes.len());
        out.push(Problem::warning("modes", text));
        return;
    }
    for (i, a) in modes.iter().enumerate() {
        for b in &modes[i + 1..] {
            let (Some(x), Some(y)) = (&a.shape, &b.shape) else { continue };
            let (f, g) = (&a.frequency_hz, &b.frequency_hz);
            if (f.value - g.value).abs() <= f.sd + g.sd && likeness(x.as_slice(), y.as_slice()) > ALIKE {
                let text = format!("{} and {} have one shape: is it one mode, listed twice?", name(a), name(b));
                out.push(Problem::warning("modes", text));
            }
        }
    }
}

/// Squared cosine of two shapes over the sensors that both have; NaN for fewer than three, which say little.
fn likeness(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
    let both = || a.iter().zip(b).filter(|(x, y)| x.is_finite() && y.is_finite());
    if both().count() < 3 {
        return f64::NAN;
    }
    // Shapes have any scale: by their largest entries before anything is squared.
    let largest = |list: &[Complex<f64>]| list.iter().map(|v| v.norm()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let (p, q) = (largest(a), largest(b));
    let scaled = || both().map(|(x, y)| (x / p, y / q));
    let cross: Complex<f64> = scaled().map(|(x, y)| x.conj() * y).sum();
    let (own, other) = scaled().fold((0.0, 0.0), |(s, t), (x, y)| (s + x.norm_sqr(), t + y.norm_sqr()));
    cross.norm_sqr() / (own * other)
}

fn sensors(data: &TestData, out: &mut Vec<Problem>) {
    let shapes: Vec<_> = data.modes.iter().filter_map(|m| m.shape.as_ref()).collect();
    for (k, sensor) in data.sensors.iter().enumerate() {
        let path = child("sensors", &sensor.name);
        if let Some(other) = data.sensors[..k].iter().find(|other| is_same(other, sensor)) {
            let text = format!("`{}` and `{}` stand in one place and one direction", other.name, sensor.name);
            out.push(Problem::warning(path.clone(), text));
        }
        if !shapes.is_empty() && shapes.iter().all(|s| s.get(k).is_some_and(|v| v.re.is_nan())) {
            out.push(Problem::warning(path, format!("`{}` has no value in any shape", sensor.name)));
        }
    }
}

fn is_same(a: &Sensor, b: &Sensor) -> bool {
    let place = |s: &Sensor| match &s.place {
        Place::Node { node, .. } => (node.clone(), None),
        Place::Element { element, fraction, .. } => (element.clone(), Some(*fraction)),
    };
    let position = |s: &Sensor| match &s.place {
        Place::Node { position, .. } | Place::Element { position, .. } => *position,
    };
    let cosine: f64 = (0..3).map(|i| a.direction[i] * b.direction[i]).sum();
    place(a) == place(b)
        && position(a) == position(b)
        && a.offset == b.offset
        && a.is_rotation == b.is_rotation
        && cosine.abs() > 0.999
}

#[cfg(test)]
mod tests {
    use crate::data::read_test;

    const TEXT: &str = "
retune_test: 1
name: bench
sources: {bench: {kind: measured, text: by hand}}
sensors:
  p: {node: a, direction: +z}
  q: {node: b, direction: +z}
  r: {node: c, direction: +z}
  s: {node: d, direction: +z}
modes:
  - {frequency: 1 Hz, frequency_sd: 1 %, damping: 1 %, source: bench, shape: {real: [1, 2, 3, 4], sd: 2 %}}
  - {frequency: 2 Hz, frequency_sd: 1 %, damping: 1 %, source: bench, shape: {real: [1, 2, -3, 0], sd: 2 %}}
  - {frequency: 3 Hz, frequency_sd: 1 %, damping: 1 %, source: bench, shape: {real: [1, -2, 1, -1], sd: 2 %}}
";

    fn said(from: &str, to: &str) -> Vec<String> {
        let text = TEXT.replace(from, to);
        assert!(from.is_empty() || text != TEXT, "{from}");
        read_test(&text).unwrap().1.into_iter().map(|p| p.message).collect()
    }

    #[test]
    fn a_sound_test_raises_no_doubt() {
        assert_eq!(said("", ""), Vec::<String>::new());
    }

    #[test]
    fn what_is_doubtful_is_said() {
        for (from, to, expected) in [
            (
                "frequency: 2 Hz, frequency_sd: 1 %",
                "frequency: 2 Hz, frequency_sd: 30 %",
                "standard deviation of 30.0 %",
            ),
            ("-3, 0], sd: 2 %", "-3, 0], sd: 200 %", "standard deviation of 200.0 %"),
            ("damping: 1 %", "damping: 0.9", "(and 2 more modes like it): a damping ratio of 0.9 is 90.0 %"),
            ("2, -3, 0]", "2, 3, 4]", ""),
            (
                "2 Hz, frequency_sd: 1 %, damping: 1 %, source: bench, shape: {real: [1, 2, -3, 0]",
                "1.01 Hz, frequency_sd: 1 %, source: bench, shape: {real: [-2, -4, -6, -8]",
                "is it one mode, listed twice?",
            ),
            (
                "q: {node: b, direction: +z}",
                "q: {node: a, direction: -z}",
                "`p` and `q` stand in one place and one direction",
            ),
        ] {
            let said = said(from, to);
            assert!(
                if expected.is_empty() { said.is_empty() } else { said.iter().any(|t| t.contains(expected)) },
                "{to}: {said:?}"
            );
        }
        let none = TEXT.replace("3, 4]", "3, .nan]").replace("-3, 0]", "-3, null]").replace("1, -1]", "1, .nan]");
        assert_eq!(read_test(&none).unwrap().1[0].message, "`s` has no value in any shape");
        let alike = TEXT.replace("2, -3, 0]", "2, 3, 4]").replace("-2, 1, -1]", "2.1, 3, 4]");
        assert_eq!(read_test(&alike).unwrap().1[0].message, "all 3 shapes are alike: is one row repeated?");
    }
}
