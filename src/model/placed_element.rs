//! Elements and held dofs in their places, with property values as functions of θ.

use super::geometry::{GLOBAL, Rotation, Vector, plus};
use super::moving::{Moving, Stand};
use super::placed_matrices::{PlacedMatrices, Superelement};
use super::value::Value;
use crate::element::{Element, ElementError, ElementInput};
use std::borrow::Cow;
use std::sync::Arc;

/// An element in its place.
#[derive(Debug, Clone)]
pub struct PlacedElement {
    /// Its name: that of its entry, or `entry.2` for the second of a chain, or `entry.2/1` for a part of it.
    pub name: String,
    /// Its type.
    pub kind: &'static dyn Element,
    /// Indices of its nodes.
    pub nodes: Vec<usize>,
    /// Rigid arms from its nodes to its ends, global, m; none where it is empty.
    pub arms: Vec<[f64; 3]>,
    /// Its axes.
    pub axes: Rotation,
    /// The direction near its z axis, where the file states it; else that is the default.
    pub orientation: Option<Vector>,
    /// How far its axes are turned about x from the stated or default ones, to the principal axes of its cross-section, rad.
    pub turn: f64,
    /// Positions of its nodes in its axes, relative to the first, m.
    pub points: Vec<[f64; 3]>,
    /// Its property values, in the order of the type's properties; those of an entry are shared by its elements.
    pub values: Arc<Vec<Option<Value>>>,
    /// Factor on its stiffness.
    pub stiffness_factor: Option<Value>,
    /// Factor on its mass.
    pub mass_factor: Option<Value>,
    /// Viscous damping per stiffness, s: C = ... + factor K.
    pub stiffness_damping: Option<Value>,
    /// Viscous damping per mass, 1/s: C = ... + factor M.
    pub mass_damping: Option<Value>,
    /// How its ends move, where coordinates of its nodes name parameters.
    pub(super) moving: Option<Arc<Moving>>,
    /// Path of its entry in the file.
    pub path: String,
    /// Name of its section, if any.
    pub section: Option<String>,
    /// Matrices of another solver, of a superelement or a term of one; it has no nodes of its own then, and its type no matrices.
    pub matrices: Option<PlacedMatrices>,
}

impl PlacedElement {
    /// Whether its matrices in its own axes are those of another for all values of the parameters, as far as can be seen without computing them.
    pub(super) fn is_made_as(&self, other: &Self) -> bool {
        let is_still = self.moving.is_none() && other.moving.is_none();
        let has_none = self.matrices.is_none() && other.matrices.is_none();
        is_still
            && has_none
            && self.kind.name() == other.kind.name()
            && self.points == other.points
            && self.values == other.values
            && (&self.stiffness_factor, &self.mass_factor) == (&other.stiffness_factor, &other.mass_factor)
            && (&self.stiffness_damping, &self.mass_damping) == (&other.stiffness_damping, &other.mass_damping)
    }

    /// Matrices in global axes that stand for themselves.
    ///
    /// * `factors` - of K and of M
    pub(super) fn of_matrices(
        name: String,
        path: &str,
        [stiffness_factor, mass_factor]: [Option<Value>; 2],
        matrices: PlacedMatrices,
    ) -> Self {
        Self {
            name,
            kind: &Superelement,
            nodes: Vec::new(),
            arms: Vec::new(),
            axes: GLOBAL,
            orientation: None,
            turn: 0.0,
            points: Vec::new(),
            values: Arc::default(),
            stiffness_factor,
            mass_factor,
            stiffness_damping: None,
            mass_damping: None,
            moving: None,
            path: path.to_string(),
            section: None,
            matrices: Some(matrices),
        }
    }

    /// Everything that θ may change in it: property values, factors and places of its ends.
    pub(super) fn expressions(&self) -> impl Iterator<Item = &Value> {
        self.values
            .iter()
            .flatten()
            .chain(&self.stiffness_factor)
            .chain(&self.mass_factor)
            .chain(&self.stiffness_damping)
            .chain(&self.mass_damping)
            .chain(self.moving.iter().flat_map(|m| m.expressions()))
    }

    /// Where it stands at θ.
    ///
    /// # Errors
    /// As [`Moving::stand`].
    pub(super) fn stand(&self, theta: &[f64]) -> Result<Stand<'_>, ElementError> {
        match &self.moving {
            Some(moving) => moving.stand(self.kind.axes(), (&self.points, &self.axes), self.turn, theta),
            None => Ok(Stand::still(&self.points, self.axes)),
        }
    }

    /// Whether it is one of a mesh: a shell or a solid.
    pub fn is_of_mesh(&self) -> bool {
        self.matrices.is_none() && self.nodes.len() > 2
    }

    /// How many of its nodes, the first ones, are corners: the others are middles of edges.
    pub(super) fn n_corners(&self) -> usize {
        match self.nodes.len() {
            10 => 4,
            13 => 5,
            15 => 6,
            20 => 8,
            n => n,
        }
    }

    /// All nodes that it acts on, those of a superelement among them.
    pub fn joined(&self) -> Cow<'_, [usize]> {
        self.matrices.as_ref().map_or(Cow::Borrowed(&self.nodes[..]), |m| Cow::Owned(m.nodes()))
    }

    /// Whether any of it depends on parameter `j`.
    pub(super) fn depends_on(&self, j: usize) -> bool {
        self.expressions().any(|v| v.parameters().any(|p| p == j))
    }

    /// The rigid arm at one of its nodes, global, m.
    pub(super) fn arm(&self, k: usize) -> Vector {
        self.arms.get(k).copied().unwrap_or_default()
    }

    /// Where its ends are at θ, global, m: where the dofs are that its matrices stand for.
    ///
    /// * `positions` - of the nodes of the model, at the estimates
    pub(super) fn ends_at(&self, positions: &[Vector], theta: &[f64]) -> Vec<Vector> {
        let mut ends = self.ends(positions);
        if let Some(moving) = &self.moving {
            moving.carry(&mut ends, theta);
        }
        ends
    }

    /// Where its ends are at θ, global, m, the arms of links that parameters change among it.
    ///
    /// * `positions` - of the nodes of the model, at the estimates
    pub(super) fn tips_at(&self, positions: &[Vector], theta: &[f64]) -> Vec<Vector> {
        let mut ends = self.ends(positions);
        if let Some(moving) = &self.moving {
            moving.step(&mut ends, theta);
        }
        ends
    }

    /// Where its ends are at the estimates, global, m.
    ///
    /// * `positions` - of the nodes of the model
    pub(super) fn ends(&self, positions: &[Vector]) -> Vec<Vector> {
        self.nodes.iter().enumerate().map(|(k, &n)| plus(positions[n], 1.0, self.arm(k))).collect()
    }

    /// (y, z) of the line on which its mass lies, in its axes, m.
    pub(super) fn mass_axis(&self, theta: &[f64]) -> [f64; 2] {
        self.kind.mass_axis(&ElementInput { points: &self.points, values: &self.values_at(theta) })
    }

    /// Its property values at θ.
    pub fn values_at(&self, theta: &[f64]) -> Vec<Option<f64>> {
        self.values.iter().map(|v| v.as_ref().map(|v| v.at(theta))).collect()
    }
}

/// What holds a dof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Holder {
    /// The ground.
    Support,
    /// The master of a rigid link.
    Link,
}

/// A held dof and how much it gives.
#[derive(Debug, Clone)]
pub(super) struct Compliance {
    /// What gives: a node on a link may stand on a support too.
    pub(super) holder: Holder,
    /// 6 node + dof.
    pub(super) dof: usize,
    /// m/N or rad/(N m).
    pub(super) value: Value,
}
