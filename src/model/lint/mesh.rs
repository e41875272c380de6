//! What is doubtful in a mesh: shapes of elements, nodes at one place, thickness against size, normals that turn over.

use crate::catalogue::counted;
use crate::modal::Modes;
use crate::model::ParametricModel;
use crate::model::compile::Model;
use crate::model::dependence::interior_point;
use crate::model::geometry::{Vector, cross, dot, minus, unit};
use crate::model::mesh_error::MeshError;
use crate::model::placed_element::PlacedElement;
use crate::model::value::quantity;
use crate::yaml::{Problem, child};
use std::collections::{BTreeMap, HashSet};

/// Names that a message lists.
const LISTED: usize = 5;
/// Longest edge over shortest, above which an element says little across its width.
const SLENDER: f64 = 20.0;
/// Angle of a corner, degrees, below which or as near to 180 an element is nearly folded.
const SHARP: f64 = 15.0;
/// Height of the corners over the mean plane against the longest edge.
const WARPED: f64 = 0.1;
/// A shell is not a shell where it is thicker than its part is wide.
const THICK: f64 = 0.5;
/// Width of a part over its thickness that no structure has: the plates of a ship of 200 m are 20 mm thick.
const THIN: f64 = 5e4;
/// Thicknesses of neighbours that differ by so much are in different units: a millimetre is a thousandth of a metre.
const UNLIKE: f64 = 300.0;

/// Relative error of a frequency by the mesh that is worth a remark: tests know frequencies to some tenths of a per cent.
const COARSE: f64 = 0.01;

/// Elements in doubt, with how bad each is.
struct Doubt {
    what: &'static str,
    remedy: &'static str,
    found: Vec<(f64, String)>,
}

impl Doubt {
    fn new(what: &'static str, remedy: &'static str) -> Self {
        Self { what, remedy, found: Vec::new() }
    }

    /// The worst first.
    fn told(mut self, path: &str) -> Option<Problem> {
        if self.found.is_empty() {
            return None;
        }
        self.found.sort_by(|a, b| b.0.total_cmp(&a.0));
        let worst: Vec<&str> = self.found.iter().take(LISTED).map(|f| f.1.as_str()).collect();
        let more = if self.found.len() > LISTED { ", …" } else { "" };
        let count = counted(self.found.len(), "element");
        Some(Problem::warning(path, format_args!("{count} {}: {}{more}; {}", self.what, worst.join(", "), self.remedy)))
    }
}

/// What is doubtful in the mesh of a model; nothing where it has none.
pub(super) fn mesh(model: &Model) -> Vec<Problem> {
    let mut out = Vec::new();
    if model.mesh_parts().is_empty() {
        return out;
    }
    for name in model.mesh_parts() {
        let elements = model.element_set(name).unwrap_or_default();
        let path = model.path_of_part(name);
        out.extend(shapes(model, elements, &path));
        out.extend(thickness(model, elements, &path));
        out.extend(normals(model, elements, &path));
    }
    out.extend(unlike(model));
    out.extend(unused(model));
    out
}

fn length(v: Vector) -> f64 {
    dot(v, v).sqrt()
}

/// Pairs of corners that are joined by an edge.
pub(super) fn edges(n: usize) -> &'static [[usize; 2]] {
    match n {
        2 => &[[0, 1]],
        3 => &[[0, 1], [1, 2], [2, 0]],
        4 => &[[0, 1], [1, 2], [2, 3], [3, 0]],
        5 => &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 4], [1, 4], [2, 4], [3, 4]],
        6 => &[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
        _ => &[[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]],
    }
}

const TETRAHEDRON: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

pub(super) fn is_surface(e: &PlacedElement) -> bool {
    e.kind.properties().iter().any(|p| p.name == "bending_factor")
}

/// Corners of an element and its edges between them.
pub(super) fn corners(e: &PlacedElement) -> (usize, &'static [[usize; 2]]) {
    match e.n_corners() {
        4 if !is_surface(e) => (4, TETRAHEDRON),
        n => (n, edges(n)),
    }
}

fn shapes(model: &Model, elements: &[usize], path: &str) -> Vec<Problem> {
    let mut slender =
        Doubt::new("have edges that are more than twenty times as long as others", "mesh them more evenly");
    let mut sharp = Doubt::new("have corners sharper than 15 or flatter than 165 degrees", "mesh them more regularly");
    let mut warped = Doubt::new(
        "of four nodes are warped by more than a tenth of their edges",
        "mesh the curved part more finely, or with triangles",
    );
    for &i in elements {
        let e = &model.elements()[i];
        if e.nodes.len() < 3 {
            continue;
        }
        let (n, edges) = corners(e);
        let lengths: Vec<f64> = edges.iter().map(|[a, b]| length(minus(e.points[*b], e.points[*a]))).collect();
        let (least, most) = lengths.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), v| (l.min(*v), m.max(*v)));
        let ratio = most / least;
        if ratio > SLENDER {
            slender.found.push((ratio, format!("`{}` ({ratio:.0})", e.name)));
        }
        if is_surface(e) {
            let angle = |k: usize| {
                let (before, after) = (e.points[(k + n - 1) % n], e.points[(k + 1) % n]);
                let (a, b) = (minus(before, e.points[k]), minus(after, e.points[k]));
                (dot(a, b) / (length(a) * length(b))).clamp(-1.0, 1.0).acos().to_degrees()
            };
            let worst = (0..n).map(angle).min_by(|a, b| a.min(180.0 - a).total_cmp(&b.min(180.0 - b))).unwrap_or(90.0);
            let to_flat = worst.min(180.0 - worst);
            if to_flat < SHARP {
                sharp.found.push((-to_flat, format!("`{}` ({worst:.0}°)", e.name)));
            }
            if n == 4 {
                let (p, q) = (minus(e.points[2], e.points[0]), minus(e.points[3], e.points[1]));
                if let Some(normal) = unit(cross(p, q)) {
                    let height = 0.5 * dot(minus(e.points[1], e.points[0]), normal).abs();
                    if height > WARPED * most {
                        warped.found.push((height / most, format!("`{}` ({:.2})", e.name, height / most)));
                    }
                }
            }
        }
    }
    [slender, sharp, warped].into_iter().filter_map(|doubt| doubt.told(path)).collect()
}

/// Shells that are thicker than their part is wide, or far thinner than its size.
fn thickness(model: &Model, elements: &[usize], path: &str) -> Option<Problem> {
    let theta = interior_point(model.parameters());
    let (mut thickest, mut area) = (0.0_f64, 0.0);
    for &i in elements {
        let e = &model.elements()[i];
        thickest = thickest.max(thickness_of(e, &theta)?);
        area += e.points.windows(2).skip(1).map(|w| 0.5 * length(cross(w[0], w[1]))).sum::<f64>();
    }
    let width = area.sqrt();
    if thickest > THICK * width {
        let text = format!(
            "its shells are {thickest:.3e} m thick and cover {width:.3e} m times as much only: are `units` those of the mesh, and the thickness in its unit?"
        );
        return Some(Problem::warning(path, text));
    }
    (thickest > 0.0 && width > THIN * thickest).then(|| {
        let text = format!(
            "its shells are {thickest:.3e} m thick at most and cover {width:.3e} m times as much, {:.0e} times their thickness: are `units` those of the mesh, and the thickness in its unit?",
            width / thickest
        );
        Problem::warning(path, text)
    })
}

/// The thickness of a shell that states one.
fn thickness_of(e: &PlacedElement, theta: &[f64]) -> Option<f64> {
    if !is_surface(e) {
        return None;
    }
    let at = e.kind.properties().iter().position(|p| p.name == "thickness")?;
    e.values[at].as_ref().map(|v| v.at(theta))
}

/// Shells that share nodes with others hundreds of times as thick.
fn unlike(model: &Model) -> Option<Problem> {
    let theta = interior_point(model.parameters());
    // Node -> the thinnest and the thickest shell on it.
    let mut on: BTreeMap<usize, [(f64, usize); 2]> = BTreeMap::new();
    for (i, e) in model.elements().iter().enumerate() {
        let Some(t) = thickness_of(e, &theta) else { continue };
        for &n in &e.nodes {
            let [thin, thick] = on.entry(n).or_insert([(t, i); 2]);
            if t < thin.0 {
                *thin = (t, i);
            }
            if t > thick.0 {
                *thick = (t, i);
            }
        }
    }
    let worst = on.values().max_by(|a, b| (a[1].0 / a[0].0).total_cmp(&(b[1].0 / b[0].0)))?;
    let [(thin, a), (thick, b)] = *worst;
    (thick > UNLIKE * thin).then(|| {
        let (a, b) = (&model.elements()[a], &model.elements()[b]);
        let path = a.section.as_ref().map_or(a.path.clone(), |s| child("sections", s));
        let text = format!(
            "`{}` is {thin:.3e} m thick, and `{}`, which shares nodes with it, {thick:.3e} m: are their thicknesses in one unit?",
            a.name, b.name
        );
        Problem::warning(child(&path, "thickness"), text)
    })
}

/// Neighbours whose normals point to opposite sides, where it matters.
fn normals(model: &Model, elements: &[usize], path: &str) -> Option<Problem> {
    let theta = interior_point(model.parameters());
    let has_sides = |e: &PlacedElement| {
        let sided = ["offset", "B11", "B12", "B16", "B22", "B26", "B66", "angle"];
        let mut all = e.kind.properties().iter().zip(e.values.iter());
        all.any(|(p, v)| sided.contains(&p.name) && v.as_ref().is_some_and(|v| v.at(&theta).abs() > 0.0))
    };
    // Edge -> the elements on it, with whether they run along it upwards.
    let mut of: BTreeMap<[usize; 2], Vec<(usize, bool)>> = BTreeMap::new();
    for &i in elements {
        let e = &model.elements()[i];
        if !is_surface(e) || !has_sides(e) {
            continue;
        }
        for [a, b] in edges(e.nodes.len()) {
            let (a, b) = (e.nodes[*a], e.nodes[*b]);
            of.entry([a.min(b), a.max(b)]).or_default().push((i, a < b));
        }
    }
    let mut turned: BTreeMap<usize, usize> = BTreeMap::new();
    for on in of.values() {
        if let [(first, up), (second, also)] = on[..]
            && up == also
        {
            turned.insert(first.min(second), first.max(second));
        }
    }
    let (first, second) = turned.first_key_value()?;
    let (first, second) = (&model.elements()[*first].name, &model.elements()[*second].name);
    Some(Problem::warning(
        path,
        format_args!(
            "the normals of neighbouring shells point to opposite sides at {}, `{first}` and `{second}` first: their `offset`, `angle` and plies are then those of the other side; orient the surface in the mesher",
            counted(turned.len(), "edge")
        ),
    ))
}

/// Whether a node is one of the mesh that the file does not name.
pub(super) fn is_of_mesh(model: &Model, node: usize) -> bool {
    let loaded = model.spec().mesh.as_ref().and_then(|m| m.loaded.0.as_ref());
    loaded.is_some_and(|l| l.node(&model.geometry().names[node]).is_some())
}

/// Nodes of shells.
pub(super) fn nodes_of_shells(model: &Model) -> HashSet<usize> {
    model.elements().iter().filter(|e| is_surface(e)).flat_map(|e| e.nodes.iter().copied()).collect()
}

/// Pairs of nodes of the mesh that stand at one place and are not joined.
pub(super) fn at_one_place(model: &Model, pairs: &[[usize; 2]]) -> Option<Problem> {
    let name = |n: usize| &model.geometry().names[n];
    let [first, second] = *pairs.first()?;
    let count = if pairs.len() == 1 {
        "1 pair of nodes stands".to_string()
    } else {
        format!("{} pairs of nodes stand", pairs.len())
    };
    Some(Problem::warning(
        "mesh.file",
        format_args!(
            "{count} at one place, `{}` and `{}` first: what meets there is not joined; merge them in the mesher, or join them by `bushings` or `rigid_links`",
            name(first),
            name(second)
        ),
    ))
}

/// Frequencies that the mesh moves by more than a test of usual accuracy leaves unseen.
pub(super) fn coarse(model: &Model, modes: &Modes, errors: &[MeshError]) -> Option<Problem> {
    let worst = errors.iter().max_by(|a, b| a.relative.abs().total_cmp(&b.relative.abs()))?;
    if worst.relative.abs() < COARSE {
        return None;
    }
    let has_part = model.mesh_parts().contains(&worst.part);
    let path = if has_part { model.path_of_part(&worst.part) } else { String::new() };
    let many = errors.iter().filter(|e| e.relative.abs() >= COARSE).count();
    Some(Problem::warning(
        path,
        format_args!(
            "the mesh is coarse: by its own strains it moves the frequencies of {many} of the first {} elastic modes by more than 1 %, most that at {}, by about {:+.1} %, most of it in `{}`; elements half as long leave a quarter of that or less",
            errors.len(),
            quantity(modes.frequency_hz(worst.mode), "Hz"),
            100.0 * worst.relative,
            worst.part
        ),
    ))
}

/// Nodes of cells that are in no part.
fn unused(model: &Model) -> Option<Problem> {
    let g = model.geometry();
    let mut used = vec![false; g.names.len()];
    for e in model.elements() {
        e.joined().iter().for_each(|&n| used[n] = true);
    }
    let unused: Vec<usize> = (0..g.names.len()).filter(|&n| !used[n] && is_of_mesh(model, n)).collect();
    let first = *unused.first()?;
    Some(Problem::warning(
        "mesh.parts",
        format_args!(
            "{} of the mesh belong to cells that are in no part, `{}` first; name their sets under `parts`",
            counted(unused.len(), "node"),
            g.names[first]
        ),
    ))
}
