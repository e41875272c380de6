//! Single figures fit for a paper: SVG in millimetres, 8 pt text, colours that survive colour blindness and grey print.

mod mac;
mod parameters;
mod plan;
mod plot;
mod shapes;
mod view;

use super::data::{Channel, Comparison, Frfs, ReportData, Steps, Update};
use plot::{Axis, BEFORE, Canvas, Frame, GRID, INK, MODEL, SOFT, TEST, TEXT, legend, short};

/// A figure as a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// Name of the file without its ending: `mac-after`.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// The SVG text.
    pub svg: String,
}

/// Width of one column of a journal, mm.
const COLUMN: f64 = 88.0;

/// Every figure that the data allow.
///
/// The model, MAC matrices before and after, frequency against frequency, cost history, parameters, the error falling, the
/// mode shapes, and frequency responses: all channels when there are at most twelve, otherwise the driving points and the
/// lowest, the middle and the highest FRAC.
pub fn figures(data: &ReportData) -> Vec<Figure> {
    let mut list = Vec::new();
    let mut add = |name: String, title: String, canvas: Canvas| {
        let same = |n: &String| list.iter().any(|f: &Figure| f.name == *n);
        let numbered = (2..=list.len() + 2).map(|k| format!("{name}-{k}")).find(|n| !same(n)).filter(|_| same(&name));
        let svg = canvas.finish(&title);
        list.push(Figure { name: numbered.unwrap_or(name), title, svg });
    };
    if let Some(s) = data.structure.as_ref().filter(|s| !s.nodes.is_empty()) {
        add("model".into(), "The model and the sensors of the test".into(), plan::plan(s));
    }
    if let Some(c) = &data.comparison {
        let after = if c.mac_before.is_some() { "mac-after" } else { "mac" };
        for (name, m, pairs) in [("mac-before", &c.mac_before, &c.pairs_before), (after, &c.mac, &c.pairs)] {
            if let Some(m) = m {
                let title = if m.title.is_empty() { "MAC".into() } else { m.title.clone() };
                add(name.into(), title, mac::mac(m, pairs));
            }
        }
        if !c.pairs.is_empty() {
            add(
                "frequency-frequency".into(),
                "Frequency of the model against frequency of the test".into(),
                frequencies(c),
            );
        }
    }
    if let Some(u) = data.update.as_ref().filter(|u| !u.histories.is_empty()) {
        add("cost-history".into(), "Best cost against evaluations".into(), cost(u));
    }
    if let Some(u) = data.update.as_ref().filter(|u| u.has_moved() && !parameters::free(u).is_empty()) {
        add("parameters".into(), "Parameters inside their bounds".into(), parameters::parameters(u));
    }
    if let Some(s) = data.steps.as_ref().filter(|s| !s.steps.is_empty()) {
        add("error-falling".into(), "Misfit after every step".into(), waterfall(s));
    }
    if let Some(s) = data.structure.as_ref().filter(|_| !data.modes.model.is_empty() || !data.modes.test.is_empty()) {
        add("mode-shapes".into(), "Mode shapes of test and model".into(), shapes::mode_shapes(data, s));
    }
    if let Some(f) = &data.frfs {
        for channel in chosen(f) {
            let (name, title) = response_names(f, channel);
            add(name, title, frf(f, channel));
        }
    }
    list
}

/// The frequency response of one channel, test and model: `None` where the report has no such channel.
pub fn response_figure(data: &ReportData, response: &str, reference: &str) -> Option<Figure> {
    let f = data.frfs.as_ref()?;
    let channel = f.channels.iter().find(|c| c.response == response && c.reference == reference)?;
    let (name, title) = response_names(f, channel);
    let svg = frf(f, channel).finish(&title);
    Some(Figure { name, title, svg })
}

/// Name of the file and title of a channel: letters and digits of its names alone, so that every system takes them.
fn response_names(f: &Frfs, channel: &Channel) -> (String, String) {
    let word = |text: &str| -> String {
        text.chars().take(40).map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
    };
    (
        format!("frf-{}-{}", word(&channel.response), word(&channel.reference)),
        format!("{} of {} over {}", f.quantity, channel.response, channel.reference),
    )
}

fn chosen(f: &Frfs) -> Vec<&Channel> {
    let mut order: Vec<(usize, &Channel)> = f.channels.iter().enumerate().collect();
    if order.len() <= 12 {
        return f.channels.iter().collect();
    }
    let mean = |c: &Channel| {
        let known: Vec<f64> = c.frac.iter().flatten().copied().filter(|v| v.is_finite()).collect();
        if known.is_empty() { 2.0 } else { known.iter().sum::<f64>() / known.len() as f64 }
    };
    order.sort_by(|a, b| mean(a.1).total_cmp(&mean(b.1)).then(a.0.cmp(&b.0)));
    let last = order.len() - 1;
    let mut list: Vec<usize> = [0, last / 2, last].map(|k| order[k].0).to_vec();
    for (i, _) in f.channels.iter().enumerate().filter(|(_, c)| c.response == c.reference).take(3) {
        if !list.contains(&i) {
            list.push(i);
        }
    }
    list.into_iter().map(|i| &f.channels[i]).collect()
}

fn cut(text: &str, length: usize) -> String {
    if text.chars().count() <= length { text.into() } else { text.chars().take(length - 1).chain(['…']).collect() }
}

fn frequencies(c: &Comparison) -> Canvas {
    let mut canvas = Canvas::new(COLUMN, 82.0);
    let all = || c.pairs.iter().chain(&c.pairs_before).flat_map(|p| [p.test_hz, p.model_hz]);
    let axis = Axis::linear(all(), true);
    let frame = Frame { left: 130.0, top: 70.0, width: 710.0, height: 650.0, x: axis, y: axis };
    let band = if c.frequency_band > 0.0 { c.frequency_band } else { 0.05 };
    let top = axis.high;
    let corners = [(0.0, 0.0), (top / (1.0 + band), top), (top, top), (top, top * (1.0 - band))];
    canvas.polygon(&corners.map(|(x, y)| frame.at(x, y)), "#8a99a8", 0.25);
    frame.draw(&mut canvas, "test, Hz", "model, Hz", true);
    canvas.line(frame.at(0.0, 0.0), frame.at(top, top), SOFT, 2.0, "");
    for p in &c.pairs_before {
        canvas.circle(frame.at(p.test_hz, p.model_hz), 12.0, "none", BEFORE);
    }
    for p in &c.pairs {
        canvas.diamond(frame.at(p.test_hz, p.model_hz), 15.0, MODEL);
    }
    let label = format!("±{} %", short(100.0 * band));
    let mut keys = vec![(if c.pairs_before.is_empty() { "model" } else { "after" }, MODEL, "diamond")];
    if !c.pairs_before.is_empty() {
        keys.push(("before", BEFORE, "circle"));
    }
    keys.push((&label, "#c9d0d8", "box"));
    legend(&mut canvas, [130.0, 46.0], &keys);
    canvas
}

fn cost(u: &Update) -> Canvas {
    let mut canvas = Canvas::new(COLUMN, 62.0);
    let y = Axis::log(u.histories.iter().flat_map(|h| h.best_cost.iter().copied()));
    let x = Axis::linear(u.histories.iter().flat_map(|h| h.evaluations.iter().map(|e| *e as f64)), true);
    let frame = Frame { left: 150.0, top: 70.0, width: 690.0, height: 450.0, x, y };
    frame.draw(&mut canvas, "evaluations of the model", "best cost", true);
    let inks = [MODEL, TEST, BEFORE, INK];
    let dashes = ["", "22 12", "6 10"];
    let style = |i: usize| (inks[i % 4], dashes[i % 3]);
    for (i, h) in u.histories.iter().enumerate() {
        let (ink, dash) = style(i);
        canvas.path(h.evaluations.iter().zip(&h.best_cost).map(|(e, v)| frame.at(*e as f64, *v)), ink, 6.0, dash);
    }
    if u.histories.len() > 1 {
        let keys: Vec<_> = u.histories.iter().enumerate().take(3).map(|(i, h)| (cut(&h.name, 24), style(i))).collect();
        let keys: Vec<_> = keys.iter().map(|(name, (ink, dash))| (name.as_str(), *ink, *dash)).collect();
        legend(&mut canvas, [150.0, 46.0], &keys);
    }
    canvas
}

fn waterfall(s: &Steps) -> Canvas {
    let n = s.steps.len();
    let lines = s.steps.iter().map(|step| wrap(&step.name, 13).len().min(3)).max().unwrap_or(1);
    let mut canvas = Canvas::new(COLUMN.max(16.0 * n as f64 + 20.0), 63.0 + 3.1 * lines as f64);
    let values = s.steps.iter().flat_map(|s| [Some(s.misfit), s.held_out]).flatten().chain(s.noise_floor);
    let mut y = Axis::linear(values, true);
    // Room for the numbers above the bars.
    y.high += 0.09 * (y.high - y.low);
    let x = Axis { low: 0.0, high: n as f64, log: false };
    let frame = Frame { left: 130.0, top: 70.0, width: canvas.width - 170.0, height: 540.0, x, y };
    let bottom = frame.top + frame.height;
    for (v, label) in y.ticks() {
        let [_, at] = frame.at(0.0, v);
        canvas.line([frame.left, at], [frame.left + frame.width, at], GRID, 1.5, "");
        canvas.text([frame.left - 10.0, at + 9.0], &label, TEXT, "end", INK, 0.0);
    }
    let slot = frame.width / n as f64;
    for (i, step) in s.steps.iter().enumerate() {
        let [left, top] = frame.at(i as f64 + 0.2, step.misfit);
        let before = if i > 0 { s.steps[i - 1].misfit } else { step.misfit };
        if before > step.misfit {
            let [_, from] = frame.at(0.0, before);
            canvas.rect([left, from], [slot * 0.6, top - from], "#eef1f4", "#b3bdc7");
        }
        canvas.rect([left, top], [slot * 0.6, (bottom - top).max(0.0)], MODEL, "none");
        let highest = before.max(step.misfit).max(step.held_out.unwrap_or(0.0));
        let clear = if step.held_out.is_some_and(|v| v >= highest) { 26.0 } else { 10.0 };
        let above = frame.at(0.0, highest)[1] - clear;
        canvas.text([left + slot * 0.3, above], &short(step.misfit), TEXT, "middle", INK, 0.0);
        for (line, part) in wrap(&step.name, 13).iter().enumerate().take(3) {
            canvas.text([left + slot * 0.3, bottom + 36.0 + 31.0 * line as f64], part, TEXT - 2.0, "middle", INK, 0.0);
        }
    }
    canvas.line([frame.left, bottom], [frame.left + frame.width, bottom], SOFT, 2.0, "");
    let mut keys = vec![("misfit", MODEL, "box")];
    let held = s.steps.iter().enumerate().filter_map(|(i, s)| s.held_out.map(|v| frame.at(i as f64 + 0.5, v)));
    let held: Vec<_> = held.collect();
    if !held.is_empty() {
        canvas.path(held.iter().copied(), TEST, 4.0, "6 10");
        for p in &held {
            canvas.diamond(*p, 13.0, TEST);
        }
        keys.push(("held-out data", TEST, "diamond"));
    }
    let floor = s.noise_floor.map(|v| format!("noise floor {}", short(v)));
    if let (Some(v), Some(text)) = (s.noise_floor, &floor) {
        canvas.line(frame.at(0.0, v), frame.at(n as f64, v), "#1a6f43", 4.0, "22 12");
        keys.push((text, "#1a6f43", "22 12"));
    }
    legend(&mut canvas, [130.0, 46.0], &keys);
    canvas
}

/// Words on lines of at most `width` letters; a longer word is cut.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let word = cut(word, width);
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

fn frf(f: &Frfs, channel: &Channel) -> Canvas {
    let mut canvas = Canvas::new(COLUMN * 1.4, 90.0);
    let hz: Vec<f64> = f.frequency_hz.0.iter().map(|v| f64::from(*v)).collect();
    let test = if f.origin == "synthetic" { "test (synthetic)" } else { "measured" };
    let curves: Vec<_> = [
        (test, &channel.measured, TEST, ""),
        ("model", &channel.model, MODEL, "22 12"),
        ("before", &channel.before, BEFORE, "6 10"),
    ]
    .into_iter()
    .filter_map(|(name, h, ink, dash)| h.as_ref().map(|h| (name, h, ink, dash)))
    .collect();
    let size = |v: &[f32; 2]| f64::from(v[0]).hypot(f64::from(v[1]));
    let mut x = Axis::linear(hz.iter().copied(), false);
    x.high = hz.iter().copied().filter(|v| v.is_finite()).fold(x.low, f64::max).max(x.low + 1e-9);
    let y = Axis::log(curves.iter().flat_map(|c| c.1.0.iter().map(size)));
    let (left, width) = (160.0, canvas.width - 200.0);
    let upper = Frame { left, top: 70.0, width, height: 470.0, x, y };
    let lower = Frame { left, top: 570.0, width, height: 230.0, x, y: Axis { low: -180.0, high: 180.0, log: false } };
    let unit = if f.unit.is_empty() { f.quantity.clone() } else { format!("|{}|, {}", f.quantity, f.unit) };
    upper.draw(&mut canvas, "", &unit, false);
    lower.draw(&mut canvas, "frequency, Hz", "phase, °", true);
    for (_, h, ink, dash) in &curves {
        canvas.path(hz.iter().zip(&h.0).map(|(f, v)| upper.at(*f, size(v).max(y.low))), ink, 4.5, dash);
        let phase = |v: &[f32; 2]| f64::from(v[1]).atan2(f64::from(v[0])).to_degrees();
        let mut last = f64::NAN;
        let points = hz.iter().zip(&h.0).flat_map(|(f, v)| {
            let now = phase(v);
            // A jump over half a turn is the edge of the picture, not of the curve.
            let gap = (now - last).abs() > 180.0;
            last = now;
            [gap.then_some([f64::NAN; 2]), Some(lower.at(*f, now))].into_iter().flatten()
        });
        canvas.path(points.collect::<Vec<_>>(), ink, 3.5, dash);
    }
    legend(&mut canvas, [left, 46.0], &curves.iter().map(|c| (c.0, c.2, c.3)).collect::<Vec<_>>());
    canvas
}

#[cfg(test)]
mod tests {
    use super::super::fixture::wing;
    use super::*;

    #[test]
    fn every_figure_of_the_wing_is_there_and_is_well_formed() {
        let list = figures(&wing::report());
        let names: Vec<&str> = list.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(
            names[..8],
            [
                "model",
                "mac-before",
                "mac-after",
                "frequency-frequency",
                "cost-history",
                "parameters",
                "error-falling",
                "mode-shapes"
            ]
        );
        assert!(names[8..].iter().all(|n| n.starts_with("frf-")));
        let one = &wing::report().frfs.unwrap().channels[0];
        let alone = response_figure(&wing::report(), &one.response, &one.reference).unwrap();
        assert!(alone.title.contains(&one.response) && alone.svg.contains("phase"));
        assert!(response_figure(&wing::report(), "nowhere", &one.reference).is_none());
        for f in &list {
            assert!(f.svg.starts_with("<svg ") && f.svg.ends_with("</svg>\n"));
            assert!(!f.svg.contains("NaN") && !f.svg.contains("inf"), "{}", f.name);
            assert_eq!(f.svg.matches("<text").count(), f.svg.matches("</text>").count());
        }
        let mac = &wing::report().comparison.unwrap().mac.unwrap();
        for v in mac.values.iter().flatten() {
            assert!(list[2].svg.contains(&format!(">{v:.2}<")));
        }
    }

    #[test]
    fn an_empty_report_has_no_figure_and_names_cannot_become_markup() {
        assert!(figures(&ReportData::default()).is_empty());
        let mut data = wing::report();
        let c = data.comparison.as_mut().unwrap();
        c.mac.as_mut().unwrap().rows[0] = "<a>&\"\u{1}".into();
        let list = figures(&data);
        assert!(list[2].svg.contains("&lt;a&gt;&amp;&quot;\u{fffd}"));
    }

    #[test]
    fn words_are_wrapped() {
        assert_eq!(wrap("+ mass-offset @ outer wing", 13), ["+ mass-offset", "@ outer wing"]);
        assert_eq!(wrap("abcdefghijklmnopqrstuvwxyz", 5), ["abcd…"]);
    }
}
