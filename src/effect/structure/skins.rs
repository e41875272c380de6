//! Surfaces of a mesh: shells, and supports of many nodes along their edges.

use super::{PartKind, Structure};
use crate::effect::location::{Location, LocationKind};
use crate::element::Dof;
use crate::model::spec::SupportSpec;
use crate::model::{cross, dot};

impl Structure<'_> {
    /// Whether an element is a shell.
    pub fn is_shell(&self, element: usize) -> bool {
        self.model.elements()[element].kind.properties().iter().any(|p| p.name == "bending_factor")
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
        let spec = self.model.spec();
        if self.model.mesh_parts().is_empty() || self.is_wider {
            return Vec::new();
        }
        let mut all = Vec::new();
        for (name, support) in &spec.supports {
            let nodes = self.nodes_of_support(name);
            if nodes.len() < 2 || support.fixed.as_ref().is_some_and(Vec::is_empty) {
                continue;
            }
            let holds = |dof: Dof| support.holds(dof) && nodes.iter().all(|&n| !self.node_moves(n, dof));
            let gives = |dof: &Dof| holds(*dof) && self.any_node_moves(*dof) && self.generalised_stiffness(*dof) > 0.0;
            let along = |dof: Dof| Location::new(LocationKind::Group, vec![name.clone()]).along(dof.name());
            all.extend(Dof::ALL.into_iter().filter(gives).map(along));
        }
        all
    }

    /// The nodes of a support of the file.
    pub(in crate::effect) fn nodes_of_support(&self, name: &str) -> Vec<usize> {
        let support = self.model.spec().supports.get(name);
        support.into_iter().flat_map(SupportSpec::nodes).filter_map(|n| self.model.geometry().node(n)).collect()
    }

    /// How a file names some nodes: by the set of the mesh that has just these, or one by one.
    pub(in crate::effect) fn written_nodes(&self, nodes: &[usize]) -> Vec<String> {
        match self.model.mesh_set_of(nodes) {
            Some(set) => vec![set.to_string()],
            None => nodes.iter().map(|&n| self.node_name(n).to_string()).collect(),
        }
    }
}
