//! Pairs of near nodes that the structure does not join: where a part may stand that a model lacks.
//!
//! A pair counts where the way through the structure is clearly longer than the straight line: a brace across a bay, two faces that a bolt would
//! hold together. Along a beam, or through a plate, the way is the line, and a spring there would only be a change of stiffness.

use super::Structure;
use super::places::arrange;
use crate::effect::edit::PatchError;
use crate::effect::location::{Location, LocationKind};
use crate::element::Dof;
use crate::model::{Near, ParametricModel, Vector, dot, minus, unit};
use rayon::prelude::*;
use std::collections::{BTreeMap, BinaryHeap};

/// How much longer than the line the way through the structure is, at least: 1.34 across a bay of two squares, 1.08 across two elements of a plate.
const DETOUR: f64 = 1.25;
/// Distance of faces, as a share of the size of the structure, at most.
const GAP: f64 = 0.02;
/// Pairs of a node, the nearest first.
const PER_NODE: usize = 6;
/// Pairs of a structure, the nearest first.
const MOST_PAIRS: usize = 300;
/// Largest stiffness of what joins a pair, against M ω² of the structure: rigid also where the highest modes of a test have thirty times the
/// frequency of the first.
const RIGID: f64 = 1e5;
/// Sites that share one table of ways, as long as there are nodes.
const SITES_AT_ONCE: usize = 512;
/// Nodes nearer than this share of the size of the structure are at one place.
const COINCIDENT: f64 = 1e-9;

/// A node that a search has reached, the nearest first.
#[derive(PartialEq)]
struct Reached(f64, usize);

impl Eq for Reached {}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.0.total_cmp(&self.0).then(other.1.cmp(&self.1))
    }
}

impl Structure<'_> {
    /// Near nodes with a detour between them and a motion that a spring would strain, symmetric partners together before each alone.
    pub(in crate::effect) fn near_pairs(&self) -> Vec<Location> {
        if self.is_wider { Vec::new() } else { self.pairs.get_or_find(|| self.find_near_pairs()).clone() }
    }

    fn find_near_pairs(&self) -> Vec<Location> {
        let mut pairs = self.pairs_of_nodes();
        pairs.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        pairs.truncate(MOST_PAIRS);
        let pairs: Vec<[usize; 2]> = pairs.into_iter().map(|p| p.0).collect();
        let index: BTreeMap<[usize; 2], usize> = pairs.iter().enumerate().map(|(i, p)| (*p, i)).collect();
        let partner = |i: usize| {
            let [a, b] = pairs[i].map(|n| self.node_partner[n]);
            let (a, b) = (a?, b?);
            index.get(&[a.min(b), a.max(b)]).copied()
        };
        let name = |i: usize| pairs[i].map(|n| self.node_name(n)).join(":");
        let places = arrange(0..pairs.len(), partner).into_iter();
        places.map(|at| Location::new(LocationKind::Pair, at.into_iter().map(name).collect())).collect()
    }

    /// Those of [`Self::near_pairs`] whose nodes turn and lie across a gap: what a weld, or one node in the place of two, would make one.
    pub(in crate::effect) fn pairs_across_gaps(&self) -> Vec<Location> {
        let turns = |n: usize| [Dof::Rx, Dof::Ry, Dof::Rz].into_iter().any(|dof| self.node_moves(n, dof));
        let node = |name: &str| self.model.geometry().node(name);
        let is_gap = |name: &String| {
            let Some([Some(a), Some(b)]) = self.pair(name).map(|pair| pair.map(node)) else { return false };
            turns(a) && turns(b) && self.distance(a, b) <= GAP * self.extent()
        };
        self.near_pairs().into_iter().filter(|at| at.names.iter().all(is_gap)).collect()
    }

    /// Largest stiffness of what joins a pair, N/m.
    pub(in crate::effect) fn rigid(&self) -> f64 {
        RIGID * self.generalised_stiffness(Dof::Ux)
    }

    /// The pairs of a location.
    ///
    /// # Errors
    /// One that is none, in the words of an effect.
    pub(in crate::effect) fn pairs_at<'n>(
        &self,
        effect: &str,
        at: &'n Location,
    ) -> Result<Vec<[&'n str; 2]>, PatchError> {
        let unknown = || PatchError::unknown_place(effect, &at.to_string(), &[]);
        at.names.iter().map(|name| self.pair(name).ok_or_else(unknown)).collect()
    }

    /// The nodes of a pair, by its name.
    pub(in crate::effect) fn pair<'n>(&self, name: &'n str) -> Option<[&'n str; 2]> {
        let is_node = |n: &str| self.model.geometry().node(n).is_some();
        let split = |(at, colon): (usize, &str)| [&name[..at], &name[at + colon.len()..]];
        name.match_indices(':').map(split).find(|pair| pair.iter().all(|n| is_node(n)))
    }

    /// Whether two nodes are at one place.
    pub(in crate::effect) fn coincide(&self, [a, b]: [&str; 2]) -> bool {
        let g = self.model.geometry();
        let (Some(a), Some(b)) = (g.node(a), g.node(b)) else { return false };
        self.distance(a, b) <= COINCIDENT * self.extent()
    }

    fn distance(&self, a: usize, b: usize) -> f64 {
        let positions = &self.model.geometry().positions;
        let d = minus(positions[b], positions[a]);
        dot(d, d).sqrt()
    }

    /// Pairs with their distances.
    fn pairs_of_nodes(&self) -> Vec<([usize; 2], f64)> {
        let moves = |n: usize| [Dof::Ux, Dof::Uy, Dof::Uz].into_iter().any(|dof| self.node_moves(n, dof));
        let sites: Vec<usize> = (0..self.n_nodes()).filter(|&n| self.model.is_site(n)).collect();
        let extent = self.extent();
        let mut ways = self.ways();
        // Where parts face each other, what is behind the face is as near as the face: ways cross the gaps.
        let gaps = self.pairs_within(&sites, &ways, [0.0, GAP * extent], moves);
        for (&[a, b], &d) in &gaps {
            ways[a].push((b, d));
            ways[b].push((a, d));
        }
        // The nearest are wanted: farther and farther, until there are enough.
        let mut reach = 2.0 * GAP * extent;
        loop {
            let mut found = self.pairs_within(&sites, &ways, [GAP * extent, reach], moves);
            // A structure at one point has no farther.
            if gaps.len() + found.len() >= MOST_PAIRS || reach >= 2.0 * extent {
                found.extend(gaps);
                return found.into_iter().collect();
            }
            reach *= 2.0;
        }
    }

    /// Pairs from one distance to another.
    fn pairs_within(
        &self,
        sites: &[usize],
        ways: &[Vec<(usize, f64)>],
        [least, most]: [f64; 2],
        moves: impl Fn(usize) -> bool + Sync,
    ) -> BTreeMap<[usize; 2], f64> {
        let positions: Vec<Vector> = sites.iter().map(|&n| self.model.geometry().positions[n]).collect();
        let grid = Near::new(&positions, most);
        let coincident = COINCIDENT * self.extent();
        let of = |walk: &mut Walk<'_>, place: usize, a: usize| -> Vec<([usize; 2], f64)> {
            let others = grid.within(positions[place], most).into_iter().map(|i| sites[i]).filter(|&b| b != a);
            let mut near: Vec<(f64, usize)> =
                others.map(|b| (self.distance(a, b), b)).filter(|(d, _)| (least..=most).contains(d)).collect();
            near.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
            let Some(&(farthest, _)) = near.last() else { return Vec::new() };
            let reached = walk.from(a, DETOUR * farthest);
            let is_detour = |(d, b): &&(f64, usize)| reached[*b] > DETOUR * d;
            let acts = |(_, b): &&(f64, usize)| !self.same_body(a, *b) && self.is_strained(a, *b, coincident);
            let found = near.iter().filter(is_detour).filter(acts).take(PER_NODE);
            found.map(|&(d, b)| ([a.min(b), a.max(b)], d)).collect()
        };
        let movable: Vec<(usize, usize)> = sites.iter().copied().enumerate().filter(|(_, a)| moves(*a)).collect();
        let of_some = |some: &[(usize, usize)]| {
            let mut walk = Walk::new(ways);
            some.iter().flat_map(|&(place, a)| of(&mut walk, place, a)).collect::<Vec<_>>()
        };
        movable.par_chunks(SITES_AT_ONCE).flat_map_iter(of_some).collect()
    }

    /// Whether some motion of the structure strains a spring between two nodes.
    ///
    /// * `coincident` - nodes nearer than this are at one place
    fn is_strained(&self, a: usize, b: usize, coincident: f64) -> bool {
        let positions = &self.model.geometry().positions;
        let along = minus(positions[b], positions[a]);
        let dofs = [Dof::Ux, Dof::Uy, Dof::Uz];
        let relative = |weights: [f64; 3]| {
            let mut rows: BTreeMap<usize, f64> = BTreeMap::new();
            for (node, sign) in [(a, -1.0), (b, 1.0)] {
                for (dof, weight) in dofs.into_iter().zip(weights).filter(|(_, w)| *w != 0.0) {
                    for &(row, factor) in self.model.dof_map().express(node, dof) {
                        *rows.entry(row).or_default() += sign * weight * factor;
                    }
                }
            }
            rows.values().any(|v| v.abs() > 1e-9)
        };
        match unit(along) {
            Some(axis) if dot(along, along).sqrt() > coincident => relative(axis),
            _ => (0..3).any(|i| relative(std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))),
        }
    }

    /// Node -> the nodes that it is joined to, with their distances: by an element, by an entry of matrices, or by a rigid body.
    fn ways(&self) -> Vec<Vec<(usize, f64)>> {
        let mut ways: Vec<Vec<usize>> = vec![Vec::new(); self.model.geometry().positions.len()];
        let mut join = |a: usize, b: usize| {
            if a != b {
                ways[a].push(b);
                ways[b].push(a);
            }
        };
        for e in self.model.elements() {
            if let Some(matrices) = &e.matrices {
                matrices.coupled().for_each(|(a, b)| join(a, b));
                continue;
            }
            for (i, &a) in e.nodes.iter().enumerate() {
                e.nodes[..i].iter().for_each(|&b| join(a, b));
            }
        }
        let index = |name: &String| self.model.geometry().node(name);
        for link in self.model.spec().rigid_links.values() {
            for slave in link.slaves.iter().filter_map(index) {
                if let Some(master) = index(&link.master) {
                    join(master, slave);
                }
            }
        }
        for node in self.model.spec().ties.values().flat_map(|t| &t.nodes).filter_map(index) {
            self.model.dof_map().led_by(node).into_iter().for_each(|n| join(node, n));
        }
        for link in self.model.spec().weighted_links.values() {
            let nodes: Vec<usize> = link.nodes().filter_map(index).collect();
            nodes.iter().skip(1).for_each(|&n| join(nodes[0], n));
        }
        let mut measured = Vec::with_capacity(ways.len());
        for (a, mut to) in ways.into_iter().enumerate() {
            to.sort_unstable();
            to.dedup();
            measured.push(to.into_iter().map(|b| (b, self.distance(a, b))).collect());
        }
        measured
    }
}

/// Lengths of the shortest ways from one node after the other.
struct Walk<'a> {
    ways: &'a [Vec<(usize, f64)>],
    best: Vec<f64>,
    reached: Vec<usize>,
}

impl<'a> Walk<'a> {
    fn new(ways: &'a [Vec<(usize, f64)>]) -> Self {
        Self { ways, best: vec![f64::INFINITY; ways.len()], reached: Vec::new() }
    }

    /// From a node to each that is nearer than a bound; infinite to the others.
    fn from(&mut self, from: usize, bound: f64) -> &[f64] {
        let Self { ways, best, reached } = self;
        reached.drain(..).for_each(|node| best[node] = f64::INFINITY);
        best[from] = 0.0;
        reached.push(from);
        let mut open = BinaryHeap::from([Reached(0.0, from)]);
        while let Some(Reached(way, node)) = open.pop() {
            if best[node] < way {
                continue;
            }
            for &(next, length) in &ways[node] {
                let total = way + length;
                if total <= bound && total < best[next] {
                    if best[next].is_infinite() {
                        reached.push(next);
                    }
                    best[next] = total;
                    open.push(Reached(total, next));
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Context;
    use crate::model::{Registry, load};

    fn names(text: &str) -> Vec<String> {
        let (model, _, _) = load(text, &Registry::builtin()).unwrap();
        let context = Context::default();
        Structure::new(&model, &context).near_pairs().iter().map(ToString::to_string).collect()
    }

    /// Both diagonals of a bay and nothing along its members.
    #[test]
    fn diagonals_of_a_bay_are_pairs_and_nodes_of_one_member_are_none() {
        let text = "retune: 1\nname: bay\nactive_dofs: [ux, uz, ry]\nsymmetry: {normal: x, at: 1}\nnodes: {a: [0, 0, 0], b: [0, 0, 2], m: [1, 0, 2], c: [2, 0, 2], d: [2, 0, 0]}\nsections: {s: {EA: 1 MN, EIy: 1 kN m2, EIz: 1 kN m2, mass_per_length: 1 kg/m}}\nbeams:\n  left: {nodes: [a, b], section: s}\n  beam: {chain: [b, m, c], section: s}\n  right: {nodes: [d, c], section: s}\nsupports: {feet: {nodes: [a, d]}}\n";
        let found = names(text);
        // From foot to corner across, with the mirror image and alone; and from the feet to the middle of the beam, 2.24 for a way of 3.
        for expected in ["a:m+m:d", "a:m", "m:d"] {
            assert!(found.contains(&expected.to_string()), "{found:?}");
        }
        assert!(found.iter().all(|n| !n.contains("b:c") && !n.contains("b:m") && !n.contains("a:b")), "{found:?}");
    }

    /// Two arms that meet at no end: their tips face each other.
    #[test]
    fn faces_at_one_place_are_a_pair() {
        let text = "retune: 1\nname: arms\nnodes: {a: [0, 0, 0], b: [1, 0, 0], c: [1, 0, 0], d: [2, 0, 0]}\nsections: {s: {EA: 1 MN, GJ: 1 kN m2, EIy: 1 kN m2, EIz: 1 kN m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 1e-3}}\nbeams: {left: {nodes: [a, b], section: s}, right: {nodes: [c, d], section: s}}\nsupports: {feet: {nodes: [a, d]}}\n";
        assert_eq!(names(text), ["b:c"]);
    }
}
