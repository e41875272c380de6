//! Places inside of elements that the file subdivides: what is wrong with a beam need not be wrong with all of it, nor stand at its ends.

use super::{Part, PartKind, Structure};
use crate::model::stretch_name;

/// Pieces of an element, at most: a test of a few modes tells a tenth of a beam from the next.
const MOST_PIECES: usize = 10;
/// Of a structure: one with more has beams enough.
const MOST_OF_ALL: usize = 400;

impl Structure<'_> {
    /// The subdivided elements of the file, each cut into about equal pieces of one or more of its parts.
    pub(super) fn pieces(&self) -> Vec<(&str, Vec<&[usize]>)> {
        let is_cut = |part: &&Part| part.kind == PartKind::Element && part.elements.len() > 1;
        let whole: Vec<&Part> = self.parts.iter().filter(is_cut).collect();
        let into = |most: usize| -> Vec<(&str, Vec<&[usize]>)> {
            let cut = |p: &&'_ Part| p.elements.len().div_ceil(most);
            whole.iter().map(|p| (p.name.as_str(), p.elements.chunks(cut(p)).collect())).collect()
        };
        let fits =
            |cut: &Vec<(&str, Vec<&[usize]>)>| cut.iter().map(|(_, pieces)| pieces.len()).sum::<usize>() <= MOST_OF_ALL;
        (2..=MOST_PIECES).rev().map(into).find(fits).unwrap_or_default()
    }

    /// Nodes between those pieces.
    pub(super) fn inner_nodes(&self) -> Vec<usize> {
        let first = |piece: &&[usize]| self.model.elements()[piece[0]].nodes[0];
        self.pieces().iter().flat_map(|(_, pieces)| pieces.iter().skip(1).map(first)).collect()
    }

    /// The name of successive parts of a subdivided element.
    pub(super) fn name_inside(&self, element: &str, parts: &[usize]) -> String {
        let all = self.model.element_set(element).unwrap_or_default();
        let first = all.iter().position(|e| Some(e) == parts.first()).unwrap_or_default();
        stretch_name(element, [first as u32, (first + parts.len()) as u32], all.len() as u32)
    }

    /// Whether the file subdivides elements, so that there are places inside of them.
    pub fn has_places_inside(&self) -> bool {
        !self.pieces().is_empty()
    }
}
