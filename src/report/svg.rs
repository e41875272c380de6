//! Single figures fit for a paper: SVG in millimetres, 8 pt text, colours that survive colour blindness and grey print.

mod parameters;
mod plot;

use super::data::{Channel, Comparison, Frfs, LabelledMatrix, ReportData, Steps, Structure, Update};
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
/// MAC matrices before and after, frequency against frequency, cost history, parameters, the error falling, the mode shapes, and
/// frequency responses: all channels when there are at most twelve, otherwise the lowest, the middle and the highest
/// FRAC.
pub fn figures(data: &ReportData) -> Vec<Figure> {
    let mut list = Vec::new();
    let mut add = |name: String, title: String, canvas: Canvas| {
        let svg = canvas.finish(&title);
        list.push(Figure { name, title, svg });
    };
    if let Some(c) = &data.comparison {
        let after = if c.mac_before.is_some() { "mac-after" } else { "mac" };
        for (name, m) in [("mac-before", &c.mac_before), (after, &c.mac)] {
            if let Some(m) = m {
                add(name.into(), if m.title.is_empty() { "MAC".into() } else { m.title.clone() }, mac(m));
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
    if let Some(u) = data.update.as_ref().filter(|u| !parameters::free(u).is_empty()) {
        add("parameters".into(), "Parameters inside their bounds".into(), parameters::parameters(u));
    }
    if let Some(s) = data.steps.as_ref().filter(|s| !s.steps.is_empty()) {
        add("error-falling".into(), "Misfit after every step".into(), waterfall(s));
    }
    if let Some(s) = data.structure.as_ref().filter(|_| !data.modes.model.is_empty() || !data.modes.test.is_empty()) {
        add("mode-shapes".into(), "Mode shapes of test and model".into(), mode_shapes(data, s));
    }
    if let Some(f) = &data.frfs {
        for (i, channel) in chosen(f) {
            let title = format!("{} of {} over {}", f.quantity, channel.response, channel.reference);
            add(format!("frf-{}", i + 1), title, frf(f, channel));
        }
    }
    list
}

fn chosen(f: &Frfs) -> Vec<(usize, &Channel)> {
    let mut order: Vec<(usize, &Channel)> = f.channels.iter().enumerate().collect();
    if order.len() <= 12 {
        return order;
    }
    let mean = |c: &Channel| {
        let known: Vec<f64> = c.frac.iter().flatten().copied().filter(|v| v.is_finite()).collect();
        if known.is_empty() { 2.0 } else { known.iter().sum::<f64>() / known.len() as f64 }
    };
    order.sort_by(|a, b| mean(a.1).total_cmp(&mean(b.1)).then(a.0.cmp(&b.0)));
    let last = order.len() - 1;
    vec![order[0], order[last / 2], order[last]]
}

/// Anchors of viridis at equal distances.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

fn viridis(t: f64) -> (String, &'static str) {
    if !t.is_finite() {
        return ("#eeeeee".into(), INK);
    }
    let place = t.clamp(0.0, 1.0) * 8.0;
    let i = (place.floor() as usize).min(7);
    let f = place - i as f64;
    let [r, g, b]: [f64; 3] = std::array::from_fn(|k| VIRIDIS[i][k] + (VIRIDIS[i + 1][k] - VIRIDIS[i][k]) * f);
    let hex = format!("#{:02x}{:02x}{:02x}", r.round() as u8, g.round() as u8, b.round() as u8);
    (hex, if t > 0.55 { INK } else { "#ffffff" })
}

fn cut(text: &str, length: usize) -> String {
    if text.chars().count() <= length { text.into() } else { text.chars().take(length - 1).chain(['…']).collect() }
}

fn mac(m: &LabelledMatrix) -> Canvas {
    let (rows, columns) = (m.rows.len().max(1) as f64, m.columns.len().max(1) as f64);
    let width = COLUMN.max(6.0 * columns + 30.0);
    let cell = ((width * 10.0 - 270.0) / columns).min(150.0);
    let mut c = Canvas::new(width, (rows * cell + 230.0) / 10.0);
    let (left, top) = (240.0, 30.0);
    let size = (cell * 0.3).min(TEXT);
    for (i, name) in m.rows.iter().enumerate() {
        let y = top + cell * (i as f64 + 0.5) + 9.0;
        c.text([left - 12.0, y], &cut(name, 14), TEXT.min(cell * 0.6), "end", INK, 0.0);
        for (j, v) in m.values.get(i).into_iter().flatten().enumerate() {
            let (fill, ink) = viridis(*v);
            let corner = [left + cell * j as f64, top + cell * i as f64];
            c.rect(corner, [cell, cell], &fill, "#ffffff");
            if size > 12.0 && v.is_finite() {
                c.text(
                    [corner[0] + cell / 2.0, corner[1] + cell / 2.0 + size * 0.35],
                    &format!("{v:.2}"),
                    size,
                    "middle",
                    ink,
                    0.0,
                );
            }
        }
    }
    let bottom = top + cell * rows;
    for (j, name) in m.columns.iter().enumerate() {
        let x = left + cell * (j as f64 + 0.5) + 9.0;
        c.text([x, bottom + 14.0], &cut(name, 10), TEXT.min(cell * 0.6), "end", INK, -60.0);
    }
    c.text([34.0, top + cell * rows / 2.0], &m.row_axis, TEXT, "middle", INK, -90.0);
    c.text([left + cell * columns / 2.0, bottom + 184.0], &m.column_axis, TEXT, "middle", INK, 0.0);
    c
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
    let mut canvas = Canvas::new(COLUMN.max(16.0 * n as f64 + 20.0), 80.0);
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

/// Test over model, seen obliquely from above, one panel a pair (or a mode, where nothing is paired).
fn mode_shapes(data: &ReportData, s: &Structure) -> Canvas {
    let up = s.up.unwrap_or(2).min(2);
    let (a, b) = ((up + 1) % 3, (up + 2) % 3);
    let (sin, cos) = 0.62_f64.sin_cos();
    // From 69 degrees beside the first axis, 36 degrees above: the oblique view of the page.
    let (side, ahead) = (-1.2_f64).sin_cos();
    let flat = move |p: [f64; 3]| {
        let [x, y, z] = [p[a], p[b], p[up]];
        [-side * x + ahead * y, -(z * cos - sin * (ahead * x + side * y))]
    };
    let panels: Vec<(Option<usize>, Option<usize>, String)> = match &data.comparison {
        Some(c) if !c.pairs.is_empty() => {
            c.pairs.iter().map(|p| (p.test_mode, p.model_mode, p.label.clone())).collect()
        }
        _ if !data.modes.model.is_empty() => {
            data.modes.model.iter().enumerate().map(|(i, m)| (None, Some(i), m.label.clone())).collect()
        }
        _ => data.modes.test.iter().enumerate().map(|(i, m)| (Some(i), None, m.label.clone())).collect(),
    };
    let panels = &panels[..panels.len().min(12)];
    let (columns, wide, high) = (2.min(panels.len().max(1)), 850.0, 440.0);
    let rows = panels.len().div_ceil(columns).max(1);
    let mut canvas = Canvas::new(columns as f64 * wide / 10.0, (rows as f64 * high + 100.0) / 10.0);
    let points: Vec<[f64; 2]> =
        s.nodes.iter().map(|n| n.position).chain(s.sensors.iter().map(|x| x.position)).map(flat).collect();
    let ends = |k: usize| {
        points
            .iter()
            .map(|p| p[k])
            .filter(|v| v.is_finite())
            .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)))
    };
    let ((x0, x1), (y0, y1)) = (ends(0), ends(1));
    let span = (x1 - x0).max((y1 - y0) * 1.2).max(1e-12);
    let reach = 0.12 * span;
    let scale = ((wide - 90.0) / (x1 - x0 + 1e-12)).min((high - 80.0) / (y1 - y0 + 2.0 * reach));
    for (k, (test, model, label)) in panels.iter().enumerate() {
        let corner = [(k % columns) as f64 * wide, (k / columns) as f64 * high + 85.0];
        let put = |p: [f64; 3]| {
            let q = flat(p);
            [
                corner[0] + wide / 2.0 + (q[0] - f64::midpoint(x0, x1)) * scale,
                corner[1] + high / 2.0 + 24.0 + (q[1] - f64::midpoint(y0, y1)) * scale,
            ]
        };
        let test = test.and_then(|i| data.modes.test.get(i));
        let model = model.and_then(|i| data.modes.model.get(i)).filter(|m| m.displacement.len() == 3 * s.nodes.len());
        let hz = [test.map(|m| m.frequency_hz), model.map(|m| m.frequency_hz)];
        let hz: Vec<String> = hz.iter().flatten().map(|f| format!("{f:.2}")).collect();
        canvas.text(
            [corner[0] + 45.0, corner[1] + 20.0],
            &format!("{} ({} Hz)", cut(label, 34), hz.join(" / ")),
            TEXT,
            "start",
            INK,
            0.0,
        );
        for e in s.elements.iter().filter(|e| e.nodes.len() > 1) {
            canvas.path(
                e.nodes.iter().filter_map(|n| s.nodes.get(*n)).map(|n| put(n.position)).collect::<Vec<_>>(),
                "#c3cbd3",
                2.5,
                "",
            );
        }
        let unit = model.map_or(0.0, |m| {
            m.displacement.0.chunks(3).map(|u| f64::from(u[0].hypot(u[1]).hypot(u[2]))).fold(0.0, f64::max)
        });
        // The largest motion of nodes and sensors alike, as in the page.
        let read = model.and_then(|m| m.at_sensors.as_ref());
        let known = read.into_iter().flat_map(|a| &a.0).filter(|v| v.is_finite());
        let unit = known.fold(unit, |u, v| u.max(f64::from(v.abs())));
        if let Some(m) = model {
            let enlarge = reach / cos / unit.max(1e-300);
            let at = |values: &super::data::Floats, n: usize| -> [f64; 3] {
                std::array::from_fn(|c| f64::from(values.0[3 * n + c]) * enlarge)
            };
            let rotation = m.rotation.as_ref().filter(|r| r.len() == m.displacement.len());
            for e in s.elements.iter().filter(|e| e.nodes.len() > 1 && e.nodes.iter().all(|n| *n < s.nodes.len())) {
                let [i, j] = [e.nodes[0], e.nodes[1]];
                let curve: Vec<[f64; 2]> = if let Some(r) = rotation.filter(|_| e.nodes.len() == 2) {
                    let (p, q) = (s.nodes[i].position, s.nodes[j].position);
                    let (ends, turns) = ([at(&m.displacement, i), at(&m.displacement, j)], [at(r, i), at(r, j)]);
                    (0..=8).map(|k| put(beam_point([p, q], ends, turns, f64::from(k) / 8.0))).collect()
                } else {
                    let moved = |n: usize| {
                        let u = at(&m.displacement, n);
                        put(std::array::from_fn(|c| s.nodes[n].position[c] + u[c]))
                    };
                    e.nodes.iter().map(|n| moved(*n)).collect()
                };
                canvas.path(curve, MODEL, 5.0, "");
            }
        }
        if let Some(x) = test.and_then(|m| m.at_sensors.as_ref()).filter(|x| x.len() == s.sensors.len()) {
            let at = read.filter(|a| a.len() == x.len());
            let known = || x.0.iter().enumerate().filter(|(_, v)| v.is_finite()).map(|(i, v)| (i, f64::from(*v)));
            let factor = match at {
                Some(a) => {
                    known().map(|(i, v)| v * f64::from(a.0[i])).sum::<f64>()
                        / known().map(|(_, v)| v * v).sum::<f64>().max(1e-300)
                        / unit.max(1e-300)
                }
                None => 1.0 / known().map(|(_, v)| v.abs()).fold(1e-300, f64::max),
            };
            let moved = |i: usize| {
                let sensor = &s.sensors[i];
                let v = f64::from(x.0[i]) * factor * reach / cos;
                put(std::array::from_fn(|c| sensor.position[c] + v * sensor.direction[c]))
            };
            for line in &s.trace_lines {
                canvas.path(
                    line.iter().filter(|i| **i < s.sensors.len()).map(|i| moved(*i)).collect::<Vec<_>>(),
                    TEST,
                    3.0,
                    "14 8",
                );
            }
            for i in (0..s.sensors.len()).filter(|i| !s.sensors[*i].is_rotation && x.0[*i].is_finite()) {
                canvas.circle(moved(i), 5.0, TEST, "none");
            }
        }
    }
    let mut keys = Vec::new();
    if !data.modes.model.is_empty() {
        keys.push(("model", MODEL, ""));
    }
    if !data.modes.test.is_empty() {
        keys.push(("test", TEST, "14 8"));
    }
    keys.push(("at rest", "#c3cbd3", ""));
    legend(&mut canvas, [45.0, 46.0], &keys);
    canvas
}

/// Where the point at fraction `t` of a beam goes when its ends move by `u` and turn by `r`: linear along the axis,
/// cubic across it, with the end slopes θ × e.
///
/// # Source
/// J. S. Przemieniecki, Theory of matrix structural analysis, 1968, section 5.6.
fn beam_point([p, q]: [[f64; 3]; 2], u: [[f64; 3]; 2], r: [[f64; 3]; 2], t: f64) -> [f64; 3] {
    let axis: [f64; 3] = std::array::from_fn(|c| q[c] - p[c]);
    let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    if length == 0.0 {
        return p;
    }
    let e = axis.map(|a| a / length);
    let dot = |v: [f64; 3]| v[0] * e[0] + v[1] * e[1] + v[2] * e[2];
    let cross = |v: [f64; 3]| [v[1] * e[2] - v[2] * e[1], v[2] * e[0] - v[0] * e[2], v[0] * e[1] - v[1] * e[0]];
    let (n1, n3) = (1.0 - 3.0 * t * t + 2.0 * t.powi(3), 3.0 * t * t - 2.0 * t.powi(3));
    let (n2, n4) = (length * t * (1.0 - t).powi(2), length * t * t * (t - 1.0));
    let (along, slopes) = ([dot(u[0]), dot(u[1])], [cross(r[0]), cross(r[1])]);
    std::array::from_fn(|c| {
        let across = n1 * (u[0][c] - along[0] * e[c]) + n3 * (u[1][c] - along[1] * e[c]);
        let stretch = (along[0] + (along[1] - along[0]) * t) * e[c];
        p[c] + axis[c] * t + across + n2 * slopes[0][c] + n4 * slopes[1][c] + stretch
    })
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
            names[..7],
            [
                "mac-before",
                "mac-after",
                "frequency-frequency",
                "cost-history",
                "parameters",
                "error-falling",
                "mode-shapes"
            ]
        );
        assert_eq!(names.len(), 10);
        for f in &list {
            assert!(f.svg.starts_with("<svg ") && f.svg.ends_with("</svg>\n"));
            assert!(!f.svg.contains("NaN") && !f.svg.contains("inf"), "{}", f.name);
            assert_eq!(f.svg.matches("<text").count(), f.svg.matches("</text>").count());
        }
        let mac = &wing::report().comparison.unwrap().mac.unwrap();
        for v in mac.values.iter().flatten() {
            assert!(list[1].svg.contains(&format!(">{v:.2}<")));
        }
    }

    #[test]
    fn an_empty_report_has_no_figure_and_names_cannot_become_markup() {
        assert!(figures(&ReportData::default()).is_empty());
        let mut data = wing::report();
        let c = data.comparison.as_mut().unwrap();
        c.mac.as_mut().unwrap().rows[0] = "<a>&\"\u{1}".into();
        let list = figures(&data);
        assert!(list[1].svg.contains("&lt;a&gt;&amp;&quot;\u{fffd}"));
    }

    /// w = P (3 L x² - x³)/(6 E I): with w(L) = 1 the end slope is 1.5/L and w(L/2) = 5/16.
    #[test]
    fn a_cantilever_under_an_end_load_bends_by_its_cubic() {
        let l = 2.0;
        let ends = [[0.0; 3], [0.0, 0.0, 1.0]];
        let turns = [[0.0; 3], [0.0, -1.5 / l, 0.0]];
        let [x, y, z] = beam_point([[0.0; 3], [l, 0.0, 0.0]], ends, turns, 0.5);
        assert!((x - 1.0).abs() < 1e-15 && y == 0.0 && (z - 5.0 / 16.0).abs() < 1e-15);
    }

    #[test]
    fn words_are_wrapped() {
        assert_eq!(wrap("+ mass-offset @ outer wing", 13), ["+ mass-offset", "@ outer wing"]);
        assert_eq!(wrap("abcdefghijklmnopqrstuvwxyz", 5), ["abcd…"]);
    }
}
