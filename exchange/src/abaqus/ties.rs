//! TIE: nodes of one surface follow the faces of another.
//!
//! ```text
//! u_s = Σ N_i(ξ) (u_i + θ_i × a)        ξ: the nearest point of the nearest face, a: from it to the node; rotations of shells alone
//! ```
//!
//! Source: P. Wriggers, Computational Contact Mechanics, 2006, section 9.2, node to segment.

use super::importer::{Importer, word};
use super::surfaces::{Face, Surface};
use super::tied::Tied;
use crate::motions::Term;
use crate::text::{exact, list, map};
use crate::writer::Block;
use indexmap::IndexMap;
use retune::deck::{DeckError, Keyword};
use retune::element::Dof;
use retune::linalg::vector3::{dot, minus, plus};
use retune::model::rigid_motion;
use std::collections::{BTreeSet, HashMap};

type Vector = [f64; 3];

/// Nodes further from a face than this part of its edges are not tied, unless the deck says how far.
const NEAR: f64 = 0.05;

/// The nearest point of a face: its distance, the point, and the shares of the face's nodes.
fn nearest(p: Vector, face: &Face, at: &[Vector]) -> (f64, Vector, Vec<f64>) {
    let shares = match face.corners {
        2 => {
            let along = minus(at[1], at[0]);
            let f = (dot(minus(p, at[0]), along) / dot(along, along).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            if face.nodes.len() == 3 {
                vec![(1.0 - f) * (1.0 - 2.0 * f), f * (2.0 * f - 1.0), 4.0 * f * (1.0 - f)]
            } else {
                vec![1.0 - f, f]
            }
        }
        3 => triangle(barycentric(p, [at[0], at[1], at[2]]), face.nodes.len()),
        _ => quadrilateral(natural(p, &at[..4]), face.nodes.len()),
    };
    let point = shares.iter().zip(at).fold([0.0; 3], |sum, (n, x)| plus(sum, *n, *x));
    let d = minus(p, point);
    (dot(d, d).sqrt(), point, shares)
}

/// Area coordinates of the point of a triangle nearest to `p`.
///
/// Source: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
fn barycentric(p: Vector, [a, b, c]: [Vector; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (minus(b, a), minus(c, a), minus(p, a));
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = minus(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = d1 / (d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = minus(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let sum = va + vb + vc;
    [va / sum, vb / sum, vc / sum]
}

/// Shares of three or six nodes at area coordinates.
fn triangle([a, b, c]: [f64; 3], nodes: usize) -> Vec<f64> {
    if nodes == 6 {
        vec![a * (2.0 * a - 1.0), b * (2.0 * b - 1.0), c * (2.0 * c - 1.0), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a]
    } else {
        vec![a, b, c]
    }
}

/// Coordinates in [-1, 1]² of the point of a bilinear face nearest to `p`: Gauss-Newton, kept inside.
fn natural(p: Vector, at: &[Vector]) -> [f64; 2] {
    const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut q = [0.0_f64; 2];
    for _ in 0..30 {
        let (mut x, mut gx, mut ge) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for (s, a) in SIGNS.iter().zip(at) {
            let (f, g) = (1.0 + s[0] * q[0], 1.0 + s[1] * q[1]);
            x = plus(x, 0.25 * f * g, *a);
            gx = plus(gx, 0.25 * s[0] * g, *a);
            ge = plus(ge, 0.25 * s[1] * f, *a);
        }
        let r = minus(p, x);
        let (a, b, c) = (dot(gx, gx), dot(gx, ge), dot(ge, ge));
        let det = a * c - b * b;
        if det <= 1e-14 * a * c {
            break;
        }
        let (u, v) = (dot(gx, r), dot(ge, r));
        let next = [q[0] + (c * u - b * v) / det, q[1] + (a * v - b * u) / det];
        let mut kept = next.map(|v| v.clamp(-1.0, 1.0));
        // On an edge the other coordinate has its own minimum.
        if kept[0] != next[0] && kept[1] == next[1] {
            kept[1] = (q[1] + (v - b * (kept[0] - q[0])) / c).clamp(-1.0, 1.0);
        } else if kept[1] != next[1] && kept[0] == next[0] {
            kept[0] = (q[0] + (u - b * (kept[1] - q[1])) / a).clamp(-1.0, 1.0);
        }
        let step = (kept[0] - q[0]).abs().max((kept[1] - q[1]).abs());
        q = kept;
        if step < 1e-14 {
            break;
        }
    }
    q
}

/// Shares of four or eight nodes at natural coordinates.
fn quadrilateral([x, e]: [f64; 2], nodes: usize) -> Vec<f64> {
    const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corner = |s: &[f64; 2]| 0.25 * (1.0 + s[0] * x) * (1.0 + s[1] * e);
    if nodes != 8 {
        return SIGNS.iter().map(corner).collect();
    }
    let mut out: Vec<f64> = SIGNS.iter().map(|s| corner(s) * (s[0] * x + s[1] * e - 1.0)).collect();
    out.push(0.5 * (1.0 - x * x) * (1.0 - e));
    out.push(0.5 * (1.0 + x) * (1.0 - e * e));
    out.push(0.5 * (1.0 - x * x) * (1.0 + e));
    out.push(0.5 * (1.0 - x) * (1.0 - e * e));
    out
}

/// Faces by the cells of a grid that they and what is near to them touch.
struct Cells {
    size: f64,
    cells: HashMap<[i64; 3], Vec<u32>>,
}

impl Cells {
    fn new(faces: &[(Vec<Vector>, f64)]) -> Self {
        let extents: Vec<f64> = faces.iter().map(|f| extent(&f.0) + 2.0 * f.1).collect();
        let mean = extents.iter().sum::<f64>() / extents.len().max(1) as f64;
        let size = if mean > 0.0 { mean } else { 1.0 };
        let mut out = Self { size, cells: HashMap::new() };
        for (i, (points, near)) in faces.iter().enumerate() {
            let low: Vector = std::array::from_fn(|k| points.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min) - near);
            let high: Vector =
                std::array::from_fn(|k| points.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max) + near);
            let (a, b) = (out.cell(low), out.cell(high));
            // One face that is much larger than the others is looked at always.
            let count: i64 = (0..3).map(|k| (b[k] - a[k]).saturating_add(1)).fold(1, i64::saturating_mul);
            if count > 4096 {
                out.cells.entry([i64::MIN; 3]).or_default().push(i as u32);
                continue;
            }
            for x in a[0]..=b[0] {
                for y in a[1]..=b[1] {
                    for z in a[2]..=b[2] {
                        out.cells.entry([x, y, z]).or_default().push(i as u32);
                    }
                }
            }
        }
        out
    }

    fn cell(&self, p: Vector) -> [i64; 3] {
        p.map(|v| (v / self.size).floor() as i64)
    }

    fn near(&self, p: Vector) -> impl Iterator<Item = usize> {
        let of = |key| self.cells.get(&key).into_iter().flatten().map(|i| *i as usize);
        of(self.cell(p)).chain(of([i64::MIN; 3]))
    }
}

fn extent(points: &[Vector]) -> f64 {
    let span = |k: usize| {
        let (low, high) =
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        high - low
    };
    (0..3).map(span).fold(0.0, f64::max)
}

/// Mean length of the edges of a face.
fn edge(face: &Face, at: &[Vector]) -> f64 {
    let n = face.corners;
    let count = if n == 2 { 1 } else { n };
    let length = |i: usize| {
        let d = minus(at[(i + 1) % n], at[i]);
        dot(d, d).sqrt()
    };
    (0..count).map(length).sum::<f64>() / count as f64
}

/// Finds what follows what, and moves nodes onto the faces where the deck says so.
pub(super) fn tie(importer: &mut Importer<'_>, k: &Keyword<'_>, instance: u32) -> Result<(), DeckError> {
    if let Some(p) = ["CYCLICSYMMETRY", "MULTIPHYSICS", "FLUIDSURFACE"].into_iter().find(|p| k.parameter(p).is_some()) {
        return Err(k.error(format_args!("ties with {p} are not read")));
    }
    let given = match k.parameter("POSITIONTOLERANCE").map(str::parse::<f64>) {
        None => None,
        Some(Ok(v)) if v >= 0.0 && v.is_finite() => Some(v),
        Some(_) => return Err(k.error("POSITION TOLERANCE must be a number, zero or above")),
    };
    let adjust = match k.label("ADJUST").as_deref() {
        None | Some("YES") => true,
        Some("NO") => false,
        Some(_) => return Err(k.error("ADJUST must be YES or NO")),
    };
    let name = word(&k.label("NAME").unwrap_or_default(), "tie");
    for line in k.lines().filter(|l| !l.is_empty()) {
        let get = |i: usize, what| {
            let text = line.text(i);
            if text.is_empty() {
                return Err(line.error(Some((i, what)), "the name of a surface is missing"));
            }
            importer.surface(instance, text).map_err(|m| line.error(Some((i, what)), m))
        };
        let slave = get(0, "surface that follows")?;
        let Surface::Faces(faces) = get(1, "surface that leads")? else {
            return Err(line.error(Some((1, "surface that leads")), "a surface of faces is expected to lead"));
        };
        let slave_is_shell = matches!(&slave, Surface::Faces(f) if f.iter().any(|f| f.is_shell));
        let both_faces = matches!(slave, Surface::Faces(_));
        if both_faces && k.label("TYPE").is_none_or(|t| t != "NODETOSURFACE") {
            importer
                .report
                .approximate("ties hold node to surface; Abaqus weighs over the faces where both surfaces have some");
        }
        let placed: Vec<(Vec<Vector>, f64)> = faces
            .iter()
            .map(|f| {
                let at: Vec<Vector> = f.nodes.iter().map(|n| importer.position(*n)).collect();
                let near = given.unwrap_or_else(|| NEAR * edge(f, &at));
                (at, near)
            })
            .collect();
        let cells = Cells::new(&placed);
        let (mut far, mut moved, mut largest, mut count) = (0, 0, 0.0_f64, 0);
        for node in slave.nodes() {
            if importer.is_tied(node) {
                importer.report.note("a node of two ties follows the first");
                continue;
            }
            let p = importer.position(node);
            let best = cells
                .near(p)
                .filter(|i| !faces[*i].nodes.contains(&node))
                .map(|i| (i, nearest(p, &faces[i], &placed[i].0)))
                .filter(|(i, found)| found.0 <= placed[*i].1 * (1.0 + 1e-9))
                .min_by(|a, b| a.1.0.total_cmp(&b.1.0));
            let Some((i, (gap, point, shares))) = best else {
                far += 1;
                continue;
            };
            count += 1;
            let face = &faces[i];
            let is_flat = !face.is_shell && !slave_is_shell;
            let mut arm = face.is_shell.then(|| minus(p, point));
            if adjust && is_flat {
                if gap > 0.0 {
                    importer.moved.insert(node, point);
                }
                if gap > 1e-9 * edge(face, &placed[i].0) {
                    moved += 1;
                    largest = largest.max(gap);
                }
            }
            if arm == Some([0.0; 3]) {
                arm = None;
            }
            let turns = face.is_shell && slave_is_shell && k.parameter("NOROTATION").is_none();
            let lies_on_it = (adjust || gap <= 1e-9 * edge(face, &placed[i].0)) && is_flat;
            let on = (lies_on_it && face.nodes.len() == face.corners).then_some(face.of);
            let masters = face.nodes.iter().copied().zip(shares).filter(|m| m.1.abs() > 1e-12).collect();
            importer.tied(Tied { slave: node, masters, arm, turns, on, name: name.clone() });
        }
        if count == 0 {
            return Err(line.error(
                Some((0, "surface that follows")),
                "no node of it lies near a face of the other surface; POSITION TOLERANCE says how far one may be",
            ));
        }
        if far > 0 {
            importer.report.note(format!(
                "tie {name}: {far} of {} nodes lie further from the faces than the tolerance and are not tied",
                far + count
            ));
        }
        if moved > 0 {
            let unit = importer.unit(crate::system::Quantity::Length);
            importer.report.note(format!(
                "tie {name}: {moved} nodes were moved onto the faces (ADJUST), by {} {unit} at most",
                exact(largest)
            ));
        }
    }
    Ok(())
}

/// Writes the ties of nodes that lie on faces of solids as ties, the others as constraints.
pub(super) fn write(importer: &mut Importer<'_>) {
    let mut on_faces: IndexMap<String, (Vec<String>, BTreeSet<String>)> = IndexMap::new();
    for tied in std::mem::take(&mut importer.ties) {
        let node = importer.node_name(tied.slave);
        let leading = tied.on.map(|at| importer.names_of(at)).unwrap_or_default();
        if leading.is_empty() {
            for (component, terms) in rows(importer, &tied) {
                importer.constraint(&format!("{}_{node}_{}", tied.name, component + 1), terms);
            }
        } else {
            let (nodes, elements) = on_faces.entry(tied.name).or_default();
            nodes.push(node);
            elements.extend(leading);
        }
    }
    for (name, (nodes, elements)) in on_faces {
        let name = importer.element_names.unique(&name);
        let faces = importer.element_names.unique(&format!("{name}_faces"));
        importer.out.group(&faces, &elements.into_iter().collect::<Vec<_>>());
        // Solids turn nothing there.
        let items = [("nodes", list(&nodes)), ("to", format!("[{faces}]")), ("rotations", "false".to_string())];
        importer.out.entry(Block::Ties, &name, &map(&items), "");
    }
}

/// The rows of a node that follows a face.
fn rows(importer: &Importer<'_>, tied: &Tied) -> Vec<(usize, Vec<Term>)> {
    let own = importer.node_name(tied.slave);
    let masters: Vec<(String, f64)> = tied.masters.iter().map(|m| (importer.node_name(m.0), m.1)).collect();
    let mut out = Vec::new();
    for c in 0..3 {
        let mut terms = vec![(own.clone(), Dof::ALL[c], 1.0)];
        for (name, n) in &masters {
            terms.push((name.clone(), Dof::ALL[c], -n));
            if let Some(arm) = tied.arm {
                for motion in 3..6 {
                    let factor = rigid_motion(arm, motion)[c];
                    if factor != 0.0 {
                        terms.push((name.clone(), Dof::ALL[motion], -n * factor));
                    }
                }
            }
        }
        out.push((c, terms));
    }
    if tied.turns {
        for c in 3..6 {
            let mut terms = vec![(own.clone(), Dof::ALL[c], 1.0)];
            terms.extend(masters.iter().map(|(name, n)| (name.clone(), Dof::ALL[c], -n)));
            out.push((c, terms));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::scopes::At;
    use super::*;

    /// The nearest point of a face is the one that a search over the whole face finds; shares sum to one and give the point back.
    #[test]
    fn the_nearest_point_of_a_face_is_found() {
        let at = |i: u32| At { instance: 0, index: i };
        let quad = [[0.0, 0.0, 0.0], [2.0, 0.1, 0.3], [2.2, 1.5, 0.1], [-0.1, 1.2, -0.2]];
        for corners in [3_usize, 4] {
            let face = Face { of: at(0), nodes: (0..corners as u32).map(at).collect(), corners, is_shell: false };
            for p in [[0.7, 0.6, 0.5], [-1.0, 0.5, 0.2], [3.0, 3.0, 0.0], [1.0, -0.4, -0.3], [1.1, 2.0, 0.4]] {
                let (distance, point, shares) = nearest(p, &face, &quad[..corners]);
                assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
                let back = minus(p, point);
                assert!((dot(back, back).sqrt() - distance).abs() < 1e-12);
                let n = 400;
                let mut least = f64::INFINITY;
                for i in 0..=n {
                    for j in 0..=n {
                        let (a, b) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                        if corners == 3 && a + b > 1.0 {
                            continue;
                        }
                        let shares = if corners == 3 {
                            vec![1.0 - a - b, a, b]
                        } else {
                            quadrilateral([2.0 * a - 1.0, 2.0 * b - 1.0], 4)
                        };
                        let x = shares.iter().zip(&quad).fold([0.0; 3], |s, (f, q)| plus(s, *f, *q));
                        let d = minus(p, x);
                        least = least.min(dot(d, d).sqrt());
                    }
                }
                // The search has steps of 1/400 of faces two wide.
                assert!(distance <= least + 1e-9 && distance > least - 0.01, "{corners} {p:?}: {distance} {least}");
            }
        }
    }

    #[test]
    fn quadratic_shares_are_one_at_their_own_node() {
        for (i, q) in
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [0.0, -1.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]
                .into_iter()
                .enumerate()
        {
            let shares = quadrilateral(q, 8);
            assert!((0..8).all(|k| (shares[k] - f64::from(u8::from(k == i))).abs() < 1e-15), "{i} {shares:?}");
        }
    }
}
