//! The wider places of a structure: a few successive elements, larger patches, ends that give about both axes of bending or in all directions, nodes and
//! masses with all axes, nodes that are moved without those inside of their members, nodes inside of elements.

use super::Structure;
use crate::effect::location::{ABOUT, ALL_AXES, BENDING, Location, LocationKind};

impl Structure<'_> {
    /// The same structure with other places for effects: spans and larger patches for parts, ends that give about both axes of bending or in all
    /// directions, nodes and masses with all axes, nodes inside of elements.
    #[must_use]
    pub fn on_wider_places(mut self) -> Self {
        self.is_wider = true;
        let areas = self.list_areas();
        if !areas.is_empty() {
            let mut spans = [std::mem::take(&mut self.spans), areas].concat();
            self.pair_up(&mut spans);
            for (i, span) in spans.iter().enumerate() {
                self.part_of.entry(span.name.clone()).or_insert(self.parts.len() + i);
            }
            self.spans = spans;
        }
        self
    }

    /// Whether these are those other places.
    pub(in crate::effect) fn is_wider(&self) -> bool {
        self.is_wider
    }

    /// Whether a location is one of [`Self::on_wider_places`], and has one of these nodes or masses, or an element of one of these.
    ///
    /// * `near` - names of nodes, masses, elements, members, spans or ends; none for all
    pub(in crate::effect) fn is_wide_and_near(&self, at: &Location, near: Option<&[String]>) -> bool {
        if at.kind == LocationKind::Node {
            let of_near = |node: usize| {
                let has = |e: usize| self.model.elements()[e].nodes.contains(&node);
                near.into_iter().flatten().any(|name| self.elements_of(name).into_iter().any(has))
            };
            let node = |name: &String| self.model.geometry().node(name);
            let is_inside = |name: &String| node(name).is_some_and(|n| n >= self.n_nodes());
            let is_near = |name: &String| {
                near.is_none_or(|near| near.contains(name)) || is_inside(name) && node(name).is_some_and(of_near)
            };
            let is_wide = at.direction() == ALL_AXES || at.leaves_those_inside() || at.names.iter().any(is_inside);
            return is_wide && at.names.iter().any(is_near);
        }
        if at.kind == LocationKind::Mass {
            let is_near = |name: &String| near.is_none_or(|near| near.contains(name));
            return at.direction() == ALL_AXES && at.names.iter().any(is_near);
        }
        let is_wide_end = || matches!(at.direction(), BENDING | ALL_AXES) || ABOUT.contains(&at.direction());
        let elements_of = |name: &String| match self.end(name) {
            Some(end) => is_wide_end().then(|| vec![end.element]),
            None => self.span(name).map(|s| s.elements.clone()),
        };
        let of_near = |e: usize| near.is_none_or(|near| near.iter().any(|name| self.elements_of(name).contains(&e)));
        let elements: Option<Vec<Vec<usize>>> = at.names.iter().map(elements_of).collect();
        elements.is_some_and(|all| all.into_iter().flatten().any(of_near))
    }

    /// Whether a location is one of [`Self::on_wider_places`].
    pub fn is_wide(&self, at: &Location) -> bool {
        self.is_wide_and_near(at, None)
    }
}
