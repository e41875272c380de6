//! The plane of symmetry: where the file names none, the one that pairs most of what the structure has.

use super::listing::sorted;
use crate::model::spec::SupportSpec;
use crate::model::{Geometry, Model, PlacedElement, images};
use std::collections::{BTreeMap, BTreeSet};

/// A plane across a global axis, at a coordinate in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mirror {
    pub(super) normal: usize,
    at: f64,
}

/// The share of the elements off a plane that need an image for the plane to be one of symmetry: what hangs on one side only
/// must not hide that two wings are alike.
const PAIRED: f64 = 0.5;

impl Mirror {
    /// The plane of the file; else, of the planes halfway through the structure or through the origin, the one with most images. A plane
    /// with a support on one side alone is none.
    pub(super) fn of(model: &Model) -> Option<Self> {
        let g = model.geometry();
        if let Some((normal, at)) = g.mirror {
            return Some(Self { normal, at });
        }
        let middle = |axis: usize| {
            let of = || g.positions.iter().map(|p| p[axis]);
            0.5 * (of().fold(f64::INFINITY, f64::min) + of().fold(f64::NEG_INFINITY, f64::max))
        };
        // The usual plane first: of two with as many images the first is taken.
        let planes = [1, 0, 2].into_iter().flat_map(|normal| [middle(normal), 0.0].map(|at| Self { normal, at }));
        let ranked = planes.map(|plane| (plane.paired(model), plane));
        ranked
            .filter(|(paired, _)| *paired > 0)
            .reduce(|best, next| if next.0 > best.0 { next } else { best })
            .map(|p| p.1)
    }

    fn image(self, mut p: [f64; 3]) -> [f64; 3] {
        p[self.normal] = 2.0 * self.at - p[self.normal];
        p
    }

    /// Node -> its image.
    pub(super) fn node_partners(self, g: &Geometry) -> Vec<Option<usize>> {
        images(&g.positions, |p| Some(self.image(p)))
    }

    /// The number of elements that have another as their image; zero where it is not a plane of symmetry.
    fn paired(self, model: &Model) -> usize {
        let g = model.geometry();
        let partners = self.node_partners(g);
        let supports = model.spec().supports.values().flat_map(SupportSpec::nodes);
        let held: BTreeSet<usize> = supports.filter_map(|name| g.node(name)).collect();
        if held.iter().any(|&n| partners[n].is_none_or(|image| !held.contains(&image))) {
            return 0;
        }
        let images = element_partners(model, &partners);
        let paired = images.iter().enumerate().filter(|(i, image)| image.is_some_and(|j| j != *i)).count();
        let off = images.iter().enumerate().filter(|(i, image)| **image != Some(*i)).count();
        if paired as f64 > PAIRED * off as f64 { paired } else { 0 }
    }
}

/// Element -> its image; of several on the same nodes, the first has the first on the mirrored nodes.
///
/// * `node_partners` - node -> its image
pub(super) fn element_partners(model: &Model, node_partners: &[Option<usize>]) -> Vec<Option<usize>> {
    let elements = model.elements();
    let mut by_nodes: BTreeMap<(&str, Vec<usize>), Vec<usize>> = BTreeMap::new();
    for (i, e) in elements.iter().enumerate() {
        by_nodes.entry((e.kind.name(), sorted(&e.joined()))).or_default().push(i);
    }
    let image = |(i, e): (usize, &PlacedElement)| {
        let rank = by_nodes.get(&(e.kind.name(), sorted(&e.joined())))?.iter().position(|j| *j == i)?;
        let nodes: Option<Vec<usize>> = e.joined().iter().map(|&n| node_partners[n]).collect();
        by_nodes.get(&(e.kind.name(), sorted(&nodes?)))?.get(rank).copied()
    };
    elements.iter().enumerate().map(image).collect()
}
