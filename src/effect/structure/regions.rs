//! Places of any shape: regions of a mesh, and runs of beams of any length.
//!
//! A patch is about round, and a span has a few elements: what is wrong has the shape and the length that it has. From the best of those the way leads
//! element by element.

use super::Structure;
use super::lines::LONGEST_SPAN;
use std::collections::BTreeSet;

/// Between the first and the last of successive elements in a name.
const TO: &str = "..";
/// Between the pieces of a region in a name.
const AND: char = ',';
/// Elements of a region, at most: of more, an edge of one element is nothing.
const MOST: usize = 400;

/// ln of how many times as many shapes there are for one more side along the edge: between the numbers of polygons on a net of triangles, which grow
/// by 1.85 a side, and on one of squares, by 2.64.
///
/// # Source
/// I. Jensen, A. J. Guttmann, Self-avoiding polygons on the square lattice, J. Phys. A 32, 1999; B. Nienhuis, Phys. Rev. Lett. 49, 1982.
pub const LN_OF_A_SIDE: f64 = std::f64::consts::LN_2;

/// Elements about a place of a mesh that may belong to it or not.
#[derive(Debug, Clone)]
pub struct Neighbourhood {
    /// Those of the place.
    pub inside: Vec<usize>,
    /// Those beyond its edge that are nearest: as many layers as the place is wide.
    pub outside: Vec<usize>,
    /// Per element of both lists, inside first, which others of them it touches.
    pub touching: Vec<Vec<usize>>,
}

impl Structure<'_> {
    /// The elements of `e81..e83,e91..e93`, a region of a part of a mesh: successive elements of the part, piece by piece, in file order; `None` for
    /// any other name.
    pub(super) fn region(&self, name: &str) -> Option<Vec<usize>> {
        if !name.contains(AND) {
            return None;
        }
        let element = |name: &str| match self.model.element_set(name) {
            Some(&[e]) => Some(e),
            _ => None,
        };
        let mut elements = Vec::new();
        for piece in name.split(AND) {
            let (first, last) = piece.split_once(TO).unwrap_or((piece, piece));
            let (first, last) = (element(first)?, element(last)?);
            let part = self.mesh_part_of(first).filter(|part| self.mesh_part_of(last) == Some(*part))?;
            elements.extend((first..=last).filter(|&e| self.mesh_part_of(e) == Some(part)));
        }
        elements.sort_unstable();
        elements.dedup();
        Some(elements).filter(|e| !e.is_empty())
    }

    /// The name of a region of a part of a mesh; none of fewer than two elements.
    pub fn region_name(&self, elements: &[usize]) -> Option<String> {
        let own: BTreeSet<usize> = elements.iter().copied().collect();
        let part = self.mesh_part_of(*own.first()?)?;
        let set = self.model.element_set(self.model.mesh_parts().get(part)?)?;
        let mut of_part = set.to_vec();
        of_part.sort_unstable();
        let mut runs: Vec<Vec<usize>> = of_part
            .chunk_by(|a, b| own.contains(a) == own.contains(b))
            .filter(|run| own.contains(&run[0]))
            .map(<[usize]>::to_vec)
            .collect();
        // One piece alone would have the name of a cut.
        if let [only] = runs.as_mut_slice() {
            let rest = only.split_off(1);
            runs.push(rest);
        }
        let name = |e: usize| self.model.elements()[e].name.as_str();
        let piece = |run: &Vec<usize>| match run.as_slice() {
            [] => None,
            [only] => Some(name(*only).to_string()),
            [first, .., last] => Some(format!("{}{TO}{}", name(*first), name(*last))),
        };
        let pieces: Option<Vec<String>> = runs.iter().map(piece).collect();
        Some(pieces?.join(&AND.to_string()))
    }

    /// The elements of a patch of a mesh, or of a region; `None` of other places.
    pub fn shape(&self, name: &str) -> Option<Vec<usize>> {
        let is_patch = || self.model.patches().iter().any(|p| p == name);
        let between = self.patch_about(name).or_else(|| self.region(name));
        between.or_else(|| self.model.element_set(name).filter(|_| is_patch()).map(<[usize]>::to_vec))
    }

    /// The elements of such a place, and those about it; `None` of other places, and of large ones.
    pub fn neighbourhood(&self, name: &str) -> Option<Neighbourhood> {
        let inside = self.shape(name)?;
        let part = self.mesh_part_of(*inside.first()?)?;
        if inside.len() > MOST {
            return None;
        }
        let mut known: BTreeSet<usize> = inside.iter().copied().collect();
        let mut outside = Vec::new();
        let mut layer = inside.clone();
        // A place of n elements is about √n wide: half of that on either side.
        let layers = (0.5 * (inside.len() as f64).sqrt()).ceil() as usize + 1;
        for _ in 0..layers {
            let next: BTreeSet<usize> = layer.iter().flat_map(|&e| self.beside(e, part)).collect();
            layer = next.into_iter().filter(|&e| known.insert(e)).collect();
            outside.extend_from_slice(&layer);
        }
        let all: Vec<usize> = inside.iter().chain(&outside).copied().collect();
        let touches = |&e: &usize| {
            let beside = self.beside(e, part);
            (0..all.len()).filter(|&k| all[k] != e && beside.contains(&all[k])).collect()
        };
        let touching = all.iter().map(touches).collect();
        Some(Neighbourhood { inside, outside, touching })
    }

    /// Along how many sides the elements of a region touch others of their part.
    pub(super) fn sides_of(&self, region: &[usize]) -> usize {
        let Some(part) = region.first().and_then(|&e| self.mesh_part_of(e)) else { return 0 };
        let own: BTreeSet<usize> = region.iter().copied().collect();
        region.iter().map(|&e| self.beside(e, part).iter().filter(|other| !own.contains(other)).count()).sum()
    }

    /// Elements of a part of a mesh that share an edge with one of them: two nodes at least.
    fn beside(&self, element: usize, part: usize) -> BTreeSet<usize> {
        let (at, elements) = (self.elements_at_nodes(), self.model.elements());
        let nodes = &elements[element].nodes;
        let least = if nodes.len() > 2 { 2 } else { 1 };
        let shared = |other: usize| elements[other].nodes.iter().filter(|n| nodes.contains(n)).count();
        let near: BTreeSet<usize> = nodes.iter().flat_map(|&n| at[n].iter().copied()).collect();
        let is_beside =
            |&other: &usize| other != element && self.mesh_part_of(other) == Some(part) && shared(other) >= least;
        near.into_iter().filter(is_beside).collect()
    }

    /// The elements of `b15..b20`, successive beams of the file on a line, more of them than a span of every search has; `None` for any other name.
    pub(super) fn run_between(&self, name: &str) -> Option<Vec<usize>> {
        let (first, last) = name.split_once(TO)?;
        let run = self.long_lines().iter().find_map(|line| {
            let at = |name: &str| line.iter().position(|piece| self.element_of_file(piece[0]) == name);
            let (first, last) = (at(first)?, at(last)?);
            line.get(first..=last).map(|run| (run.len(), run.concat()))
        });
        run.filter(|(length, _)| *length > LONGEST_SPAN).map(|(_, elements)| elements)
    }

    /// Names of runs about some beams of a long line: of several lengths, about several middles.
    pub(super) fn runs_about(&self, name: &str, sizes: &[f64]) -> Vec<String> {
        let elements = self.elements_of(name);
        let lines = self.long_lines();
        let holds = |piece: &Vec<usize>| piece.iter().any(|e| elements.contains(e));
        let Some(line) = lines.iter().find(|line| line.iter().any(holds)) else { return Vec::new() };
        let own: Vec<usize> = (0..line.len()).filter(|&k| holds(&line[k])).collect();
        let (Some(first), Some(last)) = (own.first(), own.last()) else { return Vec::new() };
        let length = last + 1 - first;
        // Within half of its length of its middle, twice that in half elements.
        let reach = length.max(1) as isize;
        let middle = (first + last) as isize;
        let mut names = Vec::new();
        let lengths: BTreeSet<usize> =
            sizes.iter().flat_map(|s| [(s * length as f64) as usize, (s * length as f64).ceil() as usize]).collect();
        for length in lengths.into_iter().filter(|n| (LONGEST_SPAN + 1..line.len()).contains(n)) {
            for first in 0..=line.len() - length {
                let is_near = (2 * first as isize + length as isize - 1 - middle).abs() <= reach;
                if is_near {
                    let end = |k: usize| self.element_of_file(line[k][0]);
                    names.push(format!("{}{TO}{}", end(first), end(first + length - 1)));
                }
            }
        }
        names.retain(|n| n != name && self.span(n).is_none());
        names
    }

    /// ln of how many runs a line has for each span that every search tries.
    pub(super) fn ln_of_runs(&self, run: &[usize], of_any_size: impl Fn(usize) -> f64) -> f64 {
        let lines = self.long_lines();
        let line = lines.iter().find(|line| line.iter().any(|piece| piece.contains(&run[0])));
        let Some(line) = line else { return 0.0 };
        let on_it = |elements: &[usize]| elements.first().is_some_and(|e| line.iter().any(|piece| piece.contains(e)));
        let tried = self.spans.iter().filter(|s| on_it(&s.elements)).count();
        (of_any_size(line.len()) / tried.max(1) as f64).max(1.0).ln()
    }
}
