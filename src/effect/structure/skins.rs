//! Surfaces of a mesh: shells, and supports of many nodes along their edges.

use super::finer::ABOUT;
use super::{PartKind, Structure};
use crate::effect::location::{Location, LocationKind};
use crate::element::Dof;
use crate::model::spec::SupportSpec;
use crate::model::{cross, dot, minus, plus, spread};
use std::collections::BTreeSet;

/// Shares of the nodes of a support that are looked at as stretches of it.
const SHARES: [usize; 3] = [2, 4, 8];
/// Nodes of such a stretch, at least.
const LEAST_STRETCH: usize = 2;

impl Structure<'_> {
    /// Whether a shell or a solid that deforms is at a node.
    pub(in crate::effect) fn lies_on_a_skin(&self, node: usize) -> bool {
        let is_skin = |&e: &usize| self.model.elements()[e].is_of_mesh() && self.deforms(e);
        self.elements_at_nodes()[node].iter().any(is_skin)
    }

    /// Whether an element is a shell.
    pub fn is_shell(&self, element: usize) -> bool {
        self.model.elements()[element].kind.properties().iter().any(|p| p.name == "bending_factor")
    }

    /// Whether an element is a solid.
    pub fn is_solid(&self, element: usize) -> bool {
        /// Fewest nodes of a solid.
        const FEWEST: usize = 4;
        let e = &self.model.elements()[element];
        e.nodes.len() >= FEWEST && e.matrices.is_none() && !self.is_shell(element)
    }

    /// Area of the shells among these elements by their corners, m².
    pub(in crate::effect) fn area(&self, elements: &[usize]) -> f64 {
        let of = |&e: &usize| {
            let points = &self.model.elements()[e].points;
            let triangles = points.windows(2).skip(1).map(|w| cross(w[0], w[1]));
            triangles.map(|n| 0.5 * dot(n, n).sqrt()).sum::<f64>()
        };
        elements.iter().filter(|&&e| self.is_shell(e)).map(of).sum()
    }

    /// Parts that are shells alone, with a property each, and deform.
    pub(in crate::effect) fn skins(&self, accept: impl Fn(usize) -> bool) -> Vec<Location> {
        self.places(|p| {
            p.kind != PartKind::Mass
                && p.elements.iter().all(|&e| self.is_shell(e) && accept(e))
                && p.elements.iter().any(|&e| self.deforms(e))
        })
    }

    /// Supports of several nodes of a mesh, in each direction that they hold and in which others move.
    pub(in crate::effect) fn supports_of_edges(&self) -> Vec<Location> {
        let mut all = Vec::new();
        for name in self.names_of_edges() {
            let along = |dof: Dof| Location::new(LocationKind::Group, vec![name.to_string()]).along(dof.name());
            all.extend(self.dofs_held_at(name).into_iter().map(along));
        }
        all
    }

    /// Stretches of such supports, as far as they hold anything: the halves, quarters and eighths of their nodes that are nearest to some of them,
    /// and those that the context names.
    pub(in crate::effect) fn stretches_of_edges(&self) -> Vec<Location> {
        let mut names: Vec<String> =
            self.names_of_edges().into_iter().flat_map(|support| self.stretches_of(support)).collect();
        names.extend(self.context.further.iter().filter(|n| self.stretch(n).is_some()).cloned());
        let mut known = BTreeSet::new();
        names.retain(|n| self.stretch(n).is_some_and(|nodes| known.insert(nodes)) && !self.dofs_held_at(n).is_empty());
        names.into_iter().map(|n| Location::new(LocationKind::Group, vec![n])).collect()
    }

    /// The stretches of a support at which every search looks.
    pub(super) fn stretches_of(&self, support: &str) -> Vec<String> {
        let nodes = self.nodes_of_support(support);
        let of_share = |share: usize| {
            let number = nodes.len() / share;
            let most = if number >= LEAST_STRETCH { 2 * share } else { 0 };
            let middles = spread(&self.model.geometry().positions, &nodes, most).into_iter();
            middles.map(move |n| self.stretch_name(support, n, number))
        };
        SHARES.into_iter().flat_map(of_share).collect()
    }

    /// Supports of several nodes of a mesh.
    fn names_of_edges(&self) -> Vec<&str> {
        if self.model.mesh_parts().is_empty() || self.is_wider {
            return Vec::new();
        }
        let is_edge = |(name, support): &(&String, &SupportSpec)| {
            self.nodes_of_support(name).len() > 1 && !support.fixed.as_ref().is_some_and(Vec::is_empty)
        };
        self.model.spec().supports.iter().filter(is_edge).map(|(name, _)| name.as_str()).collect()
    }

    /// The directions that a support, or a stretch of one, holds and in which others move.
    pub(in crate::effect) fn dofs_held_at(&self, name: &str) -> Vec<Dof> {
        let whole = name.split_once(ABOUT).map_or(name, |(support, _)| support);
        let (Some(support), nodes) = (self.model.spec().supports.get(whole), self.nodes_of_support(name)) else {
            return Vec::new();
        };
        let holds = |dof: Dof| support.holds(dof) && nodes.iter().all(|&n| !self.node_moves(n, dof));
        let gives = |dof: &Dof| holds(*dof) && self.any_node_moves(*dof) && self.generalised_stiffness(*dof) > 0.0;
        Dof::ALL.into_iter().filter(gives).collect()
    }

    /// The nodes of a support of the file, or of a stretch of one.
    pub(in crate::effect) fn nodes_of_support(&self, name: &str) -> Vec<usize> {
        let Some(support) = self.model.spec().supports.get(name) else { return self.stretch(name).unwrap_or_default() };
        support.nodes().filter_map(|n| self.model.geometry().node(n)).collect()
    }

    /// `clamp~n81~12`.
    fn stretch_name(&self, support: &str, node: usize, number: usize) -> String {
        format!("{support}{ABOUT}{}{ABOUT}{number}", self.node_name(node))
    }

    /// The nodes of `clamp~n81~12`, the twelve of a support that are nearest to one of them, in file order; `None` for any other name, and for all of
    /// them.
    pub(super) fn stretch(&self, name: &str) -> Option<Vec<usize>> {
        let (of, number) = name.rsplit_once(ABOUT)?;
        let (support, node) = of.split_once(ABOUT)?;
        let mut nodes = self.nodes_of_support(self.model.spec().supports.get_key_value(support)?.0);
        let (middle, number) = (self.model.geometry().node(node)?, number.parse::<usize>().ok()?);
        if !nodes.contains(&middle) || !(1..nodes.len()).contains(&number) {
            return None;
        }
        nodes.sort_unstable();
        let positions = &self.model.geometry().positions;
        let off = |n: usize| {
            let d = minus(positions[n], positions[middle]);
            // Of two that are as near the first is meant, whatever rounding makes of it.
            (dot(d, d).sqrt() / self.extent() * 1e9).round() as u64
        };
        nodes.sort_by_key(|&n| off(n));
        nodes.truncate(number);
        nodes.sort_unstable();
        Some(nodes)
    }

    /// Stretches about a stretch of a support: about nodes in and around it, of several sizes.
    pub(super) fn stretches_about(&self, name: &str, sizes: &[f64], reach: f64, most: usize) -> Option<Vec<String>> {
        let own = self.stretch(name)?;
        let (support, _) = name.split_once(ABOUT)?;
        let all = self.nodes_of_support(support);
        let positions = &self.model.geometry().positions;
        let share = 1.0 / own.len() as f64;
        let middle = own.iter().fold([0.0; 3], |sum, &n| plus(sum, share, positions[n]));
        let off = |n: usize| {
            let d = minus(positions[n], middle);
            dot(d, d).sqrt()
        };
        let far = reach * own.iter().map(|&n| off(n)).fold(0.0, f64::max);
        let near: Vec<usize> = all.iter().copied().filter(|&n| off(n) <= far).collect();
        // One more or one less matters on a support of few nodes.
        let shares = sizes.iter().map(|s| (s * own.len() as f64).round() as usize);
        let numbers: BTreeSet<usize> =
            shares.chain([own.len() - 1, own.len() + 1]).map(|n| n.clamp(1, all.len() - 1)).collect();
        let about = |n: usize| numbers.iter().map(move |&number| self.stretch_name(support, n, number));
        Some(spread(positions, &near, most).into_iter().flat_map(about).filter(|n| n != name).collect())
    }

    /// How a file names some nodes: by the set of the mesh that has just these, or one by one.
    pub(in crate::effect) fn written_nodes(&self, nodes: &[usize]) -> Vec<String> {
        match self.model.mesh_set_of(nodes) {
            Some(set) => vec![set.to_string()],
            None => nodes.iter().map(|&n| self.node_name(n).to_string()).collect(),
        }
    }
}
