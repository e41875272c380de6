//! The model as it stands: nodes with their names, elements by kind, rigid links, masses, supports and sensors.

use super::super::data::{Element, Structure};
use super::plot::{BEFORE, Canvas, GRID, INK, MODEL, SOFT, TEST, TEXT, legend, short};
use super::view::{View, ends};
use super::{COLUMN, cut};

/// Names are written up to this many nodes: more would cover each other.
const NAMED: usize = 60;
const SENSOR: &str = "#00846a";
const RIGID: &str = "#9aa6b2";
/// Size of the letters of a name.
const NAME: f64 = TEXT - 5.0;
/// Length of the arms of the axes, and how far they reach with their names.
const ARM: f64 = 48.0;
const REACH: f64 = ARM + 24.0;
/// Inks of the groups of elements; a longer list begins again.
const GROUPS: [&str; 5] = [MODEL, TEST, "#7a3e9d", "#1a6f43", INK];

/// The structure from above where it is flat, else obliquely.
pub(super) fn plan(s: &Structure) -> Canvas {
    let view = View::plan(s);
    let points: Vec<[f64; 2]> =
        s.nodes.iter().map(|n| n.position).chain(s.sensors.iter().map(|x| x.position)).map(|p| view.at(p)).collect();
    let ((x0, x1), (y0, y1)) = (ends(&points, 0), ends(&points, 1));
    let width = 1.4 * COLUMN * 10.0;
    let groups = groups(s);
    let rows = entries(s, &groups, width);
    let (left, top) = (60.0, 40.0 + 40.0 * rows.len() as f64);
    let inside = width - 2.0 * left;
    let scale = (inside / (x1 - x0).max(1e-9)).min(900.0 / (y1 - y0).max(1e-9));
    let high = (y1 - y0) * scale;
    let reach = |down: f64| view.axes().iter().map(|(_, [_, dy])| dy * down * REACH).fold(0.0, f64::max);
    let (axes_at, foot) = (top + high + 56.0 + reach(-1.0), top + high + 110.0);
    let mut c = Canvas::new(width / 10.0, (foot + 40.0).max(axes_at + reach(1.0) + 24.0) / 10.0);
    let put = |p: [f64; 3]| {
        let q = view.at(p);
        [width / 2.0 + (q[0] - f64::midpoint(x0, x1)) * scale, top + 20.0 + (q[1] - y0) * scale]
    };
    let node = |i: usize| s.nodes.get(i).map(|n| put(n.position));
    for link in &s.rigid_links {
        for slave in &link.slaves {
            if let (Some(a), Some(b)) = (node(link.master), node(*slave)) {
                c.line(a, b, RIGID, 2.0, "8 8");
            }
        }
    }
    let held: Vec<usize> = s.rigid_links.iter().flat_map(|l| l.slaves.iter().copied().chain([l.master])).collect();
    let rigid = |e: &Element| e.nodes.len() > 1 && e.nodes.iter().all(|n| held.contains(n));
    let many = s.elements.len() > 400;
    for e in s.elements.iter().filter(|e| e.nodes.len() > 1) {
        let line: Vec<[f64; 2]> = e.nodes.iter().filter_map(|n| node(*n)).collect();
        let group = groups.iter().position(|g| *g == e.group).unwrap_or(0);
        let ink = if groups.is_empty() { MODEL } else { GROUPS[group % GROUPS.len()] };
        let pen = if many { 2.0 } else { 7.0 };
        if e.nodes.len() > 2 {
            c.polygon(&line, ink, 0.18);
            c.path(line.iter().copied().chain(line.first().copied()), ink, 2.0, "");
        } else {
            c.path(line, ink, if rigid(e) { pen * 0.6 } else { pen }, "");
        }
    }
    let largest = s.masses.iter().filter_map(|m| m.mass).fold(0.0, f64::max);
    for m in &s.masses {
        let size = m.mass.filter(|v| *v > 0.0 && largest > 0.0).map_or(0.0, |v| (v / largest).cbrt());
        if let Some(p) = node(m.node) {
            c.circle(p, 9.0 + 13.0 * size, "#e4e8ed", BEFORE);
        }
    }
    let dot = if s.nodes.len() > 400 { 2.0 } else { 6.0 };
    for n in &s.nodes {
        c.circle(put(n.position), dot, INK, "none");
    }
    for b in &s.supports {
        if let Some([x, y]) = node(b.node) {
            c.polygon(&[[x, y], [x - 14.0, y + 22.0], [x + 14.0, y + 22.0]], INK, 1.0);
        }
    }
    for x in s.sensors.iter().filter(|x| x.position.iter().all(|v| v.is_finite())) {
        let [x, y] = put(x.position);
        c.polygon(&[[x, y - 9.0], [x + 8.0, y + 6.0], [x - 8.0, y + 6.0]], SENSOR, 1.0);
    }
    for x in &s.exciters {
        c.diamond(put(x.position), 14.0, TEST);
    }
    if s.nodes.len() <= NAMED {
        let nodes: Vec<([f64; 2], String)> = s.nodes.iter().map(|n| (put(n.position), cut(&n.name, 14))).collect();
        let marks = s.sensors.iter().map(|x| put(x.position)).chain(nodes.iter().map(|n| n.0)).map(|p| around(p, 8.0));
        for ([x, y], text) in names(&nodes, marks.collect()) {
            c.halo([x, y], text, NAME, INK);
        }
    }
    let mut y = 46.0;
    for row in &rows {
        let keys: Vec<(&str, &str, &str)> = row.iter().map(|(t, ink, mark)| (t.as_str(), *ink, *mark)).collect();
        legend(&mut c, [left, y], &keys);
        y += 40.0;
    }
    scale_bar(&mut c, [left, foot], scale, inside / 4.0);
    directions(&mut c, &view, [width - left - 60.0, axes_at]);
    c
}

/// Left, top, right, bottom.
type Area = [f64; 4];

fn around([x, y]: [f64; 2], r: f64) -> Area {
    [x - r, y - r, x + r, y + r]
}

fn overlap(a: &Area, b: &Area) -> f64 {
    let side = |k: usize| (a[k + 2].min(b[k + 2]) - a[k].max(b[k])).max(0.0);
    side(0) * side(1)
}

/// Where each name goes, by the left end of its base line: at the first of eight places around its node where it covers least.
///
/// * `taken` - marks that should not be covered
fn names(nodes: &[([f64; 2], String)], mut taken: Vec<Area>) -> Vec<([f64; 2], &str)> {
    nodes
        .iter()
        .map(|([x, y], text)| {
            // 0.56: mean width of a letter of these fonts.
            let (wide, high) = (0.56 * NAME * text.chars().count() as f64, 0.75 * NAME);
            let (right, left, centre) = (x + 12.0, x - 12.0 - wide, x - wide / 2.0);
            let (above, below, level) = (y - 13.0, y + 13.0 + high, y + high / 2.0);
            let places = [
                [right, above],
                [right, below],
                [left, above],
                [left, below],
                [centre, above - 8.0],
                [centre, below + 8.0],
                [right + 12.0, level],
                [left - 12.0, level],
            ];
            let area = |[x, base]: [f64; 2]| [x, base - high, x + wide, base];
            let covered = |at| taken.iter().map(|t| overlap(&area(at), t)).sum::<f64>();
            let by_cover = places.into_iter().map(|at| (covered(at), at)).min_by(|a, b| a.0.total_cmp(&b.0));
            let at = by_cover.map_or([right, above], |c| c.1);
            taken.push(area(at));
            (at, text.as_str())
        })
        .collect()
}

fn groups(s: &Structure) -> Vec<&str> {
    let mut list: Vec<&str> = Vec::new();
    for e in s.elements.iter().filter(|e| e.nodes.len() > 1) {
        if !list.contains(&e.group.as_str()) {
            list.push(&e.group);
        }
    }
    list
}

/// Keys on as many rows as they need.
fn entries(s: &Structure, groups: &[&str], width: f64) -> Vec<Vec<(String, &'static str, &'static str)>> {
    let mut list: Vec<(String, &'static str, &'static str)> = Vec::new();
    if groups.len() <= GROUPS.len() {
        for (g, ink) in groups.iter().zip(GROUPS) {
            list.push((if g.is_empty() { "elements".into() } else { cut(g, 24) }, ink, ""));
        }
    }
    if !s.rigid_links.is_empty() {
        list.push(("rigid link".into(), RIGID, "8 8"));
    }
    if !s.masses.is_empty() {
        list.push(("point mass".into(), BEFORE, "circle"));
    }
    if !s.sensors.is_empty() {
        list.push(("sensor".into(), SENSOR, "dot"));
    }
    if !s.exciters.is_empty() {
        list.push(("exciter".into(), TEST, "diamond"));
    }
    let mut rows: Vec<Vec<_>> = vec![Vec::new()];
    let mut used = 0.0;
    for entry in list {
        let long = super::plot::key_width(&entry.0);
        if used > 0.0 && used + long > width - 100.0 {
            rows.push(Vec::new());
            used = 0.0;
        }
        used += long;
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
    }
    rows
}

/// A round length of at most `longest` units, with its value.
fn scale_bar(c: &mut Canvas, [x, y]: [f64; 2], scale: f64, longest: f64) {
    let most = longest / scale;
    let decade = 10f64.powf(most.log10().floor());
    let length = [5.0, 2.0, 1.0].map(|m| m * decade).into_iter().find(|v| *v <= most).unwrap_or(decade);
    let end = x + length * scale;
    c.line([x, y], [end, y], INK, 4.0, "");
    for at in [x, end] {
        c.line([at, y - 9.0], [at, y + 9.0], INK, 4.0, "");
    }
    c.text([end + 16.0, y + 9.0], &format!("{} m", short(length)), TEXT - 2.0, "start", INK, 0.0);
}

/// The global axes, small.
fn directions(c: &mut Canvas, view: &View, [x, y]: [f64; 2]) {
    for (name, [dx, dy]) in view.axes() {
        let length = dx.hypot(dy);
        if length < 0.1 {
            continue;
        }
        c.line([x, y], [x + ARM * dx, y + ARM * dy], SOFT, 3.0, "");
        c.circle([x, y], 3.0, GRID, SOFT);
        let out = ARM + 18.0 / length;
        c.text([x + out * dx, y + out * dy + 9.0], name, TEXT - 4.0, "middle", SOFT, 0.0);
    }
}
