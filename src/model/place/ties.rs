//! Surface ties: nodes that follow the nearest point of surfaces or volumes.
//!
//! ```text
//! u_s = u(ξ) + θ(ξ) × a      θ_s = θ(ξ)      ξ: the point of the leading elements nearest to the node, a: from it to the node
//! ```
//!
//! u and θ are those by which sensors on surfaces move (`Element::nearest`): θ of a shell by its nodes, of a solid half the curl. Every rigid motion of the
//! leading side is followed exactly, across any gap. Source: P. Wriggers, Computational Contact Mechanics, 2006, section 9.2, node to segment.

use super::{Entry, Placer};
use crate::catalogue::did_you_mean;
use crate::element::{Dof, ElementInput};
use crate::model::dof_map::rigid_motion;
use crate::model::geometry::{Vector, constant, dot, minus, plus};
use crate::model::placed_element::PlacedElement;
use crate::model::spec::{SectionSpec, SectionValue, TieSpec};
use crate::yaml::child;
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Nodes further from an element than this share of its size are not taken for tied, unless the file says how far they may be.
const NEAR: f64 = 0.05;

/// Nodes nearer to an element than this share of its size lie on it: an arm of rounding would join them to its other nodes.
const ON_IT: f64 = 1e-9;

/// An element that leads: its index, the box around it and its size.
struct Leader {
    element: usize,
    low: Vector,
    high: Vector,
    size: f64,
}

impl Leader {
    /// No point of it is nearer than this.
    fn at_least(&self, p: Vector) -> f64 {
        let off: Vector = std::array::from_fn(|k| (self.low[k] - p[k]).max(p[k] - self.high[k]).max(0.0));
        dot(off, off).sqrt()
    }
}

/// Where a node is tied: how far away, and the sums of dofs that are its six.
struct Found {
    gap: f64,
    leader: usize,
    rows: [Vec<(usize, f64)>; 6],
}

impl Placer<'_> {
    pub(super) fn ties(&mut self) {
        let mut tied: HashMap<usize, &str> = HashMap::new();
        for (name, tie) in &self.spec.ties {
            let path = child("ties", name);
            if !self.claim(name, &path) {
                continue;
            }
            let followers = self.followers(tie, &path);
            let Some(leaders) = self.leaders(tie, &path) else { continue };
            if followers.is_empty() || leaders.is_empty() {
                continue;
            }
            let within = tie.within.as_ref().map(|w| constant(w, "m", &child(&path, "within"), self.problems));
            if within.is_some_and(|w| w.is_nan() || w <= 0.0) {
                self.error(child(&path, "within"), "it must be a length above zero");
                continue;
            }
            let Ok(springs) = self.springs_of_tie(tie, &path) else { continue };
            let turning = self.turning();
            let mut far: Vec<(f64, usize)> = Vec::new();
            for node in followers {
                if let Some(other) = tied.get(&node) {
                    let of = &self.geometry.names[node];
                    let text = format!("node `{of}` follows in tie `{other}` already; leave it out of one of them");
                    self.error(child(&path, "nodes"), text);
                    return;
                }
                let found = match self.nearest_leader(node, &leaders) {
                    Ok(Some(found)) => found,
                    Ok(None) => continue,
                    Err(text) => {
                        self.error(&path, text);
                        return;
                    }
                };
                let allowed = within.unwrap_or(NEAR * leaders[found.leader].size);
                if found.gap > allowed * (1.0 + 1e-9) {
                    far.push((found.gap, node));
                    continue;
                }
                tied.insert(node, name);
                let turns = tie.rotations.unwrap_or(true) && turning.contains(&node);
                self.tie(name, node, found.rows, turns, springs.as_ref());
            }
            if let Some((gap, node)) = far.iter().copied().max_by(|a, b| a.0.total_cmp(&b.0)) {
                let (count, of) = (far.len(), self.geometry.names[node].clone());
                let text = format!(
                    "{count} of its nodes stand too far from what they are to follow, `{of}` by {gap:.4e} m; `within` says how far they may"
                );
                self.error(&path, text);
            }
        }
    }

    fn followers(&mut self, tie: &TieSpec, path: &str) -> Vec<usize> {
        if tie.nodes.is_empty() {
            self.error(child(path, "nodes"), "a tie needs nodes that follow: their names, or sets of a mesh");
        }
        let mut seen = HashSet::new();
        let found = |(i, n): (usize, &String)| self.node(n, &format!("{path}.nodes[{i}]")).filter(|n| seen.insert(*n));
        tie.nodes.iter().enumerate().filter_map(found).collect()
    }

    /// The elements to which nodes are tied; `None` where one has neither surface nor volume.
    fn leaders(&mut self, tie: &TieSpec, path: &str) -> Option<Vec<Leader>> {
        if tie.to.is_empty() {
            self.error(child(path, "to"), "a tie needs what its nodes follow: parts of the mesh, groups or elements");
        }
        let mut all: Vec<usize> = Vec::new();
        for (i, name) in tie.to.iter().enumerate() {
            let Some(set) = self.sets.get(name) else {
                let suggestion = did_you_mean(name, self.sets.keys().map(String::as_str));
                let text = format!("there is no part, group or element `{name}`{suggestion}");
                self.error(format!("{path}.to[{i}]"), text);
                return None;
            };
            if let Some(e) = set.iter().find(|e| self.elements[**e].nodes.len() < 3) {
                let e = &self.elements[*e];
                let text = format!("`{}` is a {}; nodes follow shells and solids", e.name, e.kind.name());
                self.error(format!("{path}.to[{i}]"), text);
                return None;
            }
            all.extend(set);
        }
        all.sort_unstable();
        all.dedup();
        let leader = |element: usize| {
            let at = self.elements[element].ends(&self.geometry.positions);
            let bound = |pick: fn(f64, f64) -> f64, from| -> Vector {
                std::array::from_fn(|k| at.iter().map(|p| p[k]).fold(from, pick))
            };
            let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
            let d = minus(high, low);
            Leader { element, low, high, size: dot(d, d).sqrt() }
        };
        Some(all.into_iter().map(leader).collect())
    }

    /// Nodes of elements that resist their rotations.
    fn turning(&self) -> HashSet<usize> {
        let of = |e: &PlacedElement| {
            let has = |dofs: &&[Dof]| dofs.iter().any(|d| d.is_rotation());
            let turns: Vec<bool> = e.kind.nodes().iter().map(has).collect();
            e.nodes.iter().copied().zip(turns).filter(|(_, t)| *t).map(|(n, _)| n).collect::<Vec<_>>()
        };
        self.elements.iter().flat_map(of).collect()
    }

    fn nearest_leader(&self, node: usize, leaders: &[Leader]) -> Result<Option<Found>, String> {
        let place = self.geometry.positions[node];
        let mut order: Vec<(f64, usize)> = leaders.iter().enumerate().map(|(i, l)| (l.at_least(place), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<(f64, usize, crate::element::PointWithin)> = None;
        let nominal = self.parameters.nominal();
        for (least, i) in order {
            if best.as_ref().is_some_and(|b| b.0 <= least) {
                break;
            }
            let element = &self.elements[leaders[i].element];
            if element.nodes.contains(&node) {
                continue;
            }
            let first = element.ends(&self.geometry.positions)[0];
            let from = minus(place, first);
            let values = element.values_at(&nominal);
            let input = ElementInput { points: &element.points, values: &values };
            let found = element.kind.nearest(&input, element.axes.map(|axis| dot(axis, from)));
            let found = found.map_err(|e| format!("element `{}`: {e}", element.name))?;
            let Some(found) = found else {
                return Err(format!("`{}` has neither a surface nor a volume that nodes could follow", element.name));
            };
            let at = (0..3).fold(first, |sum, k| plus(sum, found.at[k], element.axes[k]));
            let off = minus(place, at);
            let gap = dot(off, off).sqrt();
            if best.as_ref().is_none_or(|b| gap < b.0) {
                best = Some((gap, i, found));
            }
        }
        let found = best.map(|(gap, leader, point)| {
            let element = &self.elements[leaders[leader].element];
            let first = element.ends(&self.geometry.positions)[0];
            let at = (0..3).fold(first, |sum, k| plus(sum, point.at[k], element.axes[k]));
            let arm = if gap <= ON_IT * leaders[leader].size { [0.0; 3] } else { minus(place, at) };
            Found { gap, leader, rows: followed(element, &point.rows, arm) }
        });
        Ok(found)
    }

    /// What is soft in a tie: the properties of a bushing, and which of its dofs have some; `None` where nothing is. Errors are said.
    fn springs_of_tie(&mut self, tie: &TieSpec, path: &str) -> Result<Option<Springs>, ()> {
        if tie.k.is_empty() {
            return Ok(None);
        }
        let mut properties = SectionSpec::new();
        let mut soft = [false; 6];
        for (direction, scalar) in &tie.k {
            let Some(dof) = Dof::from_name(direction) else {
                let suggestion = did_you_mean(direction, Dof::ALL.iter().map(|d| d.name()));
                let text = format!(
                    "unknown direction `{direction}`, expected `ux`, `uy`, `uz`, `rx`, `ry` or `rz`{suggestion}"
                );
                self.error(format!("{path}.k.{direction}"), text);
                return Err(());
            };
            soft[dof as usize] = true;
            properties.insert(format!("k_{direction}"), SectionValue::Scalar(scalar.clone()));
        }
        let Some(kind) = self.registry.find("bushing") else { return Ok(None) };
        let before = self.problems.len();
        let values = Arc::new(self.values(kind, &[(&properties, path.to_string())]));
        for p in &mut self.problems[before..] {
            p.path = p.path.replacen(&format!("{path}.k_"), &format!("{path}.k."), 1);
        }
        Ok(Some(Springs { values, soft, path: path.to_string() }))
    }

    fn tie(&mut self, name: &str, node: usize, rows: [Vec<(usize, f64)>; 6], turns: bool, springs: Option<&Springs>) {
        let count = if turns { 6 } else { 3 };
        let Some(springs) = springs else {
            for (d, row) in rows.into_iter().enumerate().take(count) {
                self.rows.push(equal(6 * node + d, row));
            }
            return;
        };
        // A point of the leading side at the node, and springs between both.
        let own = format!("{name}.{}", self.geometry.names[node]);
        let at = self.geometry.positions[node];
        let point = self.geometry.add(format!("{own}/led"), at);
        for (d, row) in rows.into_iter().enumerate() {
            self.rows.push(equal(6 * point + d, row));
            if d < count && !springs.soft[d] {
                self.rows.push(vec![(6 * node + d, 1.0), (6 * point + d, -1.0)]);
            }
        }
        let Some(kind) = self.registry.find("bushing") else { return };
        let entry = Entry {
            path: &springs.path,
            kind,
            section: None,
            values: Arc::clone(&springs.values),
            orientation: None,
            frame: None,
            arms: Vec::new(),
            turn: 0.0,
        };
        if let Some(e) = self.add(own, &entry, vec![point, node]) {
            self.sets.entry(name.to_string()).or_default().push(e);
        }
    }
}

struct Springs {
    values: Arc<Vec<Option<crate::model::value::Value>>>,
    soft: [bool; 6],
    path: String,
}

/// dof - Σ factor · dof = 0.
fn equal(dof: usize, sum: Vec<(usize, f64)>) -> Vec<(usize, f64)> {
    std::iter::once((dof, 1.0)).chain(sum.into_iter().map(|(d, f)| (d, -f))).collect()
}

/// The six motions of a point that is carried rigidly by a point of an element, as sums of dofs of its nodes.
///
/// * `rows` - those of the point of the element, in its axes, by its dofs
/// * `arm` - from there to the point that is carried, global
fn followed(element: &PlacedElement, rows: &[Vec<f64>; 6], arm: Vector) -> [Vec<(usize, f64)>; 6] {
    let n = 6 * element.nodes.len();
    // Global dofs of the nodes, and of the point.
    let mut global = vec![[0.0; 6]; n];
    for (k, &axes_arm) in element.arms.iter().chain(std::iter::repeat(&[0.0; 3])).take(element.nodes.len()).enumerate()
    {
        for motion in 0..6 {
            let moved = rigid_motion(axes_arm, motion);
            for (i, row) in rows.iter().enumerate() {
                let own: f64 = (0..6)
                    .map(|d| {
                        let axis = element.axes[d % 3];
                        let along: f64 = (0..3).map(|g| axis[g] * moved[3 * (d / 3) + g]).sum();
                        row[6 * k + d] * along
                    })
                    .sum();
                for g in 0..3 {
                    global[6 * k + motion][3 * (i / 3) + g] += element.axes[i % 3][g] * own;
                }
            }
        }
    }
    let mut out: [Vec<(usize, f64)>; 6] = Default::default();
    for (j, motion) in global.into_iter().enumerate() {
        for (d, list) in out.iter_mut().enumerate() {
            // u + θ × a
            let factor: f64 = (0..6).map(|m| motion[m] * rigid_motion(arm, m)[d]).sum();
            if factor.abs() > 1e-14 {
                list.push((6 * element.nodes[j / 6] + j % 6, factor));
            }
        }
    }
    out
}
