//! Lines: members that lie end to end. A file may hold one beam in several entries, and what acts along a beam acts on all of them.

use super::listing::sorted;
use super::{Part, PartKind, Structure};
use crate::element::Dof;
use crate::model::dot;
use std::collections::{BTreeMap, BTreeSet};

/// Cosine of the largest angle at which members still make one line, 30 degrees: an axial force keeps 87 % of itself there.
const STRAIGHT: f64 = 0.866;
/// Elements of a span, at most, but for halves and quarters.
pub(super) const LONGEST_SPAN: usize = 4;
/// Into how many pieces a longer line is cut: what a person builds, stiffens or spoils is half of a wing as often as four of its ribs.
const PIECES: [usize; 2] = [2, 4];

impl Structure<'_> {
    /// Entries of beams that lie end to end, from one branch, support or free end to the next, `first..last` by name; and elements of such a line
    /// between bars, which do not bend it and change the force in it.
    pub(super) fn list_lines(&self) -> Vec<Part> {
        let mut entry_of: BTreeMap<usize, &str> = BTreeMap::new();
        for (name, member) in &self.model.spec().beams {
            for &e in self.model.element_set(name).into_iter().flatten() {
                entry_of.insert(e, if member.pairs.is_some() { self.element_of_file(e) } else { name });
            }
        }
        let mut lines = Vec::new();
        for elements in self.lines_of_beams() {
            let mut of: Vec<String> = elements.iter().map(|e| entry_of[e].to_string()).collect();
            of.dedup();
            let whole =
                |name: &String| self.model.element_set(name).is_some_and(|s| s.iter().all(|e| elements.contains(e)));
            if let [start, .., end] = of.as_slice()
                && of.iter().all(whole)
            {
                let name = format!("{start}..{end}");
                lines.push(Part { name, kind: PartKind::Line, of, elements, partner: None, is_member: true });
            }
        }
        lines.extend(self.list_stretches());
        lines
    }

    /// Two and more elements of the file between nodes of a line at which bars end.
    fn list_stretches(&self) -> Vec<Part> {
        let bars = self.model.spec().bars.keys().filter_map(|name| self.model.element_set(name)).flatten();
        let tied: BTreeSet<usize> = bars.flat_map(|&e| self.model.elements()[e].nodes.iter().copied()).collect();
        if tied.is_empty() {
            return Vec::new();
        }
        let nodes = |e: usize| &self.model.elements()[e].nodes;
        let goes_on = |&a: &usize, &b: &usize| !nodes(a).iter().any(|n| nodes(b).contains(n) && tied.contains(n));
        let mut out = Vec::new();
        for line in self.lines_of_beams() {
            let stretches: Vec<&[usize]> = line.chunk_by(goes_on).collect();
            for stretch in stretches.iter().filter(|_| stretches.len() > 1) {
                let mut of: Vec<String> = stretch.iter().map(|&e| self.element_of_file(e).to_string()).collect();
                of.dedup();
                if let [start, .., end] = of.as_slice() {
                    let (name, elements) = (format!("{start}..{end}"), stretch.to_vec());
                    out.push(Part { name, kind: PartKind::Span, of, elements, partner: None, is_member: true });
                }
            }
        }
        out
    }

    /// Two to [`LONGEST_SPAN`] successive elements of the file on a line, and its halves and quarters: what is changed need not end where an
    /// entry does. Inside of an element that is subdivided the same of its pieces. Those that are a place already are left out.
    pub(super) fn list_spans(&self) -> Vec<Part> {
        let span = |name: String, of: Vec<String>, run: &[&[usize]]| Part {
            name,
            kind: PartKind::Span,
            of,
            elements: run.concat(),
            partner: None,
            is_member: false,
        };
        let mut spans: Vec<Part> = Vec::new();
        for line in self.lines_of_elements() {
            let elements: Vec<&[usize]> = line.iter().map(Vec::as_slice).collect();
            for run in runs_of(&elements, 2) {
                let of: Vec<String> = run.iter().map(|e| self.element_of_file(e[0]).to_string()).collect();
                spans.push(span(format!("{}..{}", of[0], of[of.len() - 1]), of, run));
            }
        }
        for (element, pieces) in self.pieces() {
            for run in runs_of(&pieces, 1) {
                let name = self.name_inside(element, &run.concat());
                spans.push(span(name.clone(), vec![name], run));
            }
        }
        let mut known: BTreeSet<Vec<usize>> = self.parts.iter().map(|p| sorted(&p.elements)).collect();
        spans.retain(|span| known.insert(sorted(&span.elements)));
        spans
    }

    /// Elements of the file on every line of beams, and on every chain: a chain goes on where something thin branches off.
    fn lines_of_elements(&self) -> Vec<Vec<Vec<usize>>> {
        let chains = self.parts.iter().filter(|p| p.kind == PartKind::Chain && p.is_member).map(|p| p.elements.clone());
        let by_element = |line: Vec<usize>| {
            line.chunk_by(|&a, &b| self.element_of_file(a) == self.element_of_file(b)).map(<[usize]>::to_vec).collect()
        };
        self.lines_of_beams().into_iter().chain(chains).map(by_element).collect()
    }

    /// Those with more elements than a span of every search.
    pub(super) fn long_lines(&self) -> &[Vec<Vec<usize>>] {
        self.long_lines.get_or_find(|| {
            let all = self.lines_of_elements();
            all.into_iter().filter(|line| line.len() > LONGEST_SPAN).collect()
        })
    }

    /// Whether a line has more elements than a span of every search.
    pub fn has_long_lines(&self) -> bool {
        !self.long_lines().is_empty()
    }

    /// Beams that lie end to end, in order, from one branch, support or free end to the next.
    fn lines_of_beams(&self) -> Vec<Vec<usize>> {
        let spec = self.model.spec();
        let beams: BTreeSet<usize> =
            spec.beams.keys().flat_map(|name| self.model.element_set(name).into_iter().flatten().copied()).collect();
        let all: Vec<usize> = beams.into_iter().collect();
        let at = self.beams_at(&all);
        let (mut lines, mut taken) = (Vec::new(), BTreeSet::new());
        for first in all {
            if !taken.insert(first) {
                continue;
            }
            let mut line = vec![first];
            let mut next = 0;
            while let Some(&e) = line.get(next) {
                for &node in &self.model.elements()[e].nodes {
                    let Some(&[a, b]) = at.get(&node).map(Vec::as_slice) else { continue };
                    let other = if a == e { b } else { a };
                    let may_be = !taken.contains(&other) && self.goes_on(a, b, node);
                    if may_be && !self.branches(node, &at) {
                        taken.insert(other);
                        line.push(other);
                    }
                }
                next += 1;
            }
            lines.extend(self.path(&line));
        }
        lines
    }

    /// These elements in order from one end to the other, from the end that stands first in the file, if they are beams
    /// that lie end to end.
    pub(in crate::effect) fn path(&self, elements: &[usize]) -> Option<Vec<usize>> {
        let all = self.model.elements();
        let at = self.beams_at(elements);
        let is_end = |e: usize| all[e].nodes.iter().any(|n| at.get(n).is_some_and(|b| b.len() == 1));
        let mut known = BTreeSet::new();
        let mut path = vec![elements.iter().copied().filter(|&e| self.is_beam(e) && is_end(e)).min()?];
        loop {
            let last = *path.last()?;
            known.insert(last);
            let on = |&node: &usize| match at.get(&node).map(Vec::as_slice) {
                Some(&[a, b]) if self.goes_on(a, b, node) => Some(if a == last { b } else { a }),
                _ => None,
            };
            match all[last].nodes.iter().filter_map(on).find(|next| !known.contains(next)) {
                Some(next) => path.push(next),
                None => break,
            }
        }
        (path.len() == elements.len()).then_some(path)
    }

    /// The longest stretch of beams that lie end to end on which nothing else holds them, m, and whether both its ends are held: by
    /// another part, or by a support.
    pub(in crate::effect) fn free_span(&self, elements: &[usize]) -> (f64, bool) {
        let whole = || (elements.iter().map(|&e| self.length(e)).sum(), false);
        let Some(path) = self.path(elements) else { return whole() };
        let all = self.model.elements();
        let own: BTreeSet<usize> = path.iter().copied().collect();
        let at = self.elements_at_nodes();
        // What slides along the line holds it all the same.
        let Some(along) = path.first().map(|&e| all[e].axes[0]) else { return whole() };
        let across: Vec<Dof> = [Dof::Ux, Dof::Uy, Dof::Uz]
            .into_iter()
            .zip(along)
            .filter(|(_, along)| along.abs() < STRAIGHT)
            .map(|(dof, _)| dof)
            .collect();
        let is_fixed = |node: usize| across.iter().all(|&dof| !self.node_moves(node, dof));
        let is_held = |node: usize| {
            let mut there = self.body_of(node).iter().flat_map(|&n| &at[n]);
            is_fixed(node) || there.any(|&e| !own.contains(&e) && self.deforms(e))
        };
        let shared = |a: usize, b: usize| all[a].nodes.iter().copied().find(|n| all[b].nodes.contains(n));
        let other_end = |e: usize, from: usize| all[e].nodes.iter().copied().find(|&n| n != from);
        let first = match path.as_slice() {
            &[only] => all[only].nodes.first().copied(),
            &[a, b, ..] => shared(a, b).and_then(|n| other_end(a, n)),
            [] => None,
        };
        let Some(mut node) = first else { return whole() };
        let (mut best, mut length, mut begins_held) = ((0.0, false), 0.0, is_held(node));
        for (k, &e) in path.iter().enumerate() {
            let Some(next) = other_end(e, node) else { return whole() };
            length += self.length(e);
            let ends_held = is_held(next);
            if ends_held || k + 1 == path.len() {
                let span = (length, begins_held && ends_held);
                if span.0 > best.0 {
                    best = span;
                }
                (length, begins_held) = (0.0, ends_held);
            }
            node = next;
        }
        best
    }

    fn beams_at(&self, elements: &[usize]) -> BTreeMap<usize, Vec<usize>> {
        let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &e in elements.iter().filter(|&&e| self.is_beam(e)) {
            self.model.elements()[e].nodes.iter().for_each(|&n| at.entry(n).or_default().push(e));
        }
        at
    }

    /// Whether two beams that meet at a node go straight on there.
    fn goes_on(&self, a: usize, b: usize, node: usize) -> bool {
        let away = |e: usize| {
            let element = &self.model.elements()[e];
            element.axes[0].map(|x| if element.nodes[0] == node { x } else { -x })
        };
        dot(away(a), away(b)) < -STRAIGHT
    }

    /// Whether a node that two beams share holds something else that takes a force out of the line: a clamp, or another
    /// beam by a rigid link.
    fn branches(&self, node: usize, at: &BTreeMap<usize, Vec<usize>>) -> bool {
        let clamped = Dof::ALL.into_iter().all(|dof| !self.node_moves(node, dof));
        clamped || self.body_of(node).iter().any(|&other| other != node && at.contains_key(&other))
    }
}

/// Successive ones of a line: some up to [`LONGEST_SPAN`], and halves and quarters of what is longer.
fn runs_of<'r, 'e>(line: &'r [&'e [usize]], shortest: usize) -> impl Iterator<Item = &'r [&'e [usize]]> {
    let n = line.len();
    let piece = move |(pieces, k): (usize, usize)| &line[k * n / pieces..(k + 1) * n / pieces];
    let pieces = PIECES.into_iter().flat_map(|pieces| (0..pieces).map(move |k| (pieces, k))).map(piece);
    let runs = (shortest..=LONGEST_SPAN).flat_map(move |length| line.windows(length));
    runs.chain(pieces.filter(|piece| piece.len() > LONGEST_SPAN))
}
