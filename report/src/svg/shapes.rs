//! Mode shapes: test over model, pair by pair.

use super::super::data::{ReportData, Structure};
use super::cut;
use super::plot::{Canvas, INK, MODEL, SOFT, TEST, TEXT, legend};
use super::view::{View, ends};

/// Test over model, seen obliquely from above, one panel a pair (or a mode, where nothing is paired).
pub(super) fn mode_shapes(data: &ReportData, s: &Structure) -> Canvas {
    let view = View::oblique(s);
    let flat = |p: [f64; 3]| view.at(p);
    let cos = view.upright();
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
    let (columns, wide, high) = (2.min(panels.len().max(1)), 850.0, 460.0);
    let rows = panels.len().div_ceil(columns).max(1);
    let mut canvas = Canvas::new(columns as f64 * wide / 10.0, (rows as f64 * high + 100.0) / 10.0);
    let points: Vec<[f64; 2]> =
        s.nodes.iter().map(|n| n.position).chain(s.sensors.iter().map(|x| x.position)).map(flat).collect();
    let ((x0, x1), (y0, y1)) = (ends(&points, 0), ends(&points, 1));
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
            let at = |values: &super::super::data::Floats, n: usize| -> [f64; 3] {
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
                let sensor = &s.sensors[i];
                if let Some(a) = at.filter(|a| a.0[i].is_finite()) {
                    let v = f64::from(a.0[i]) * reach / cos / unit.max(1e-300);
                    let model = put(std::array::from_fn(|c| sensor.position[c] + v * sensor.direction[c]));
                    canvas.line(model, moved(i), SOFT, 2.0, "");
                    canvas.circle(model, 6.0, "#ffffff", MODEL);
                }
                canvas.circle(moved(i), 6.0, TEST, "none");
            }
        }
    }
    let mut keys = Vec::new();
    if !data.modes.model.is_empty() {
        keys.push(("model", MODEL, ""));
    }
    if data.modes.model.iter().any(|m| m.at_sensors.is_some()) && !data.modes.test.is_empty() {
        keys.push(("model at the sensors", MODEL, "ring"));
    }
    if !data.modes.test.is_empty() {
        keys.push(("test", TEST, if s.trace_lines.is_empty() { "dot" } else { "14 8" }));
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
    use super::*;

    /// w = P (3 L x² - x³)/(6 E I): with w(L) = 1 the end slope is 1.5/L and w(L/2) = 5/16.
    #[test]
    fn a_cantilever_under_an_end_load_bends_by_its_cubic() {
        let l = 2.0;
        let ends = [[0.0; 3], [0.0, 0.0, 1.0]];
        let turns = [[0.0; 3], [0.0, -1.5 / l, 0.0]];
        let [x, y, z] = beam_point([[0.0; 3], [l, 0.0, 0.0]], ends, turns, 0.5);
        assert!((x - 1.0).abs() < 1e-15 && y == 0.0 && (z - 5.0 / 16.0).abs() < 1e-15);
    }
}
