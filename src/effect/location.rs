//! Places on a structure, by the names of the user's own file.

use crate::element::Dof;
use crate::model::AXES;
use std::fmt;

/// What kind of thing a location names.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LocationKind {
    /// Nodes.
    Node,
    /// Elements, or members of one element.
    Element,
    /// Chains of elements.
    Chain,
    /// Groups of the file.
    Group,
    /// Point masses.
    Mass,
    /// Pairs of nodes: `node:node`.
    Pair,
    /// Ends of elements at a support, a link or another element: `element:node`.
    End,
    /// The whole structure.
    Whole,
}

/// Where an effect acts: one name, or symmetric partners or both ends of a member that share the parameters, and a direction where one matters.
///
/// Written `n8`, `n8+n13.ry`, `left_wing.1:n5.ry`, `whole`; in one configuration only, `bench/n8`.
#[derive(Debug, Clone, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub struct Location {
    /// What the names are.
    pub kind: LocationKind,
    /// Names of the file; for an end `element:node`, for a pair `node:node`; none for the whole structure.
    pub names: Vec<String>,
    /// A dof such as `ry`, an axis, or a word of the effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<String>,
    /// The configuration in which alone the effect acts, [`BASE`] for the model without a configuration; none for all of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub configuration: Option<String>,
}

/// The word for the base model, where an effect acts in none of the configurations.
pub const BASE: &str = "base";

/// The direction of an end that gives about both axes of bending.
pub(super) const BENDING: &str = "bending";
/// The direction of a node or an end where an effect acts along, or about, every axis that it can, with a size for each.
pub(super) const ALL_AXES: &str = "all_axes";

/// The directions of an end that gives about an axis of the structure which is none of its member.
pub(super) const ABOUT: [&str; 3] = ["about_x", "about_y", "about_z"];

/// The directions of a node that is moved without the nodes inside of its members.
pub(super) const ALONE: [&str; 3] = ["x_alone", "y_alone", "z_alone"];

impl Location {
    /// At one or several things of a kind.
    pub fn new(kind: LocationKind, names: Vec<String>) -> Self {
        Self { kind, names, direction: None, configuration: None }
    }

    /// The whole structure.
    pub fn whole() -> Self {
        Self::new(LocationKind::Whole, Vec::new())
    }

    /// Whether it is ends that give about both axes of bending, or nodes or ends with all axes, and the other is the same with some of them.
    pub fn has_more_axes_than(&self, other: &Self) -> bool {
        let has_its_axis = match self.direction() {
            BENDING => matches!(other.direction(), "ry" | "rz"),
            ALL_AXES => {
                let axis = other.direction();
                axis == BENDING || Dof::from_name(axis).is_some() || AXES.contains(&axis)
            }
            _ => false,
        };
        has_its_axis && (&self.names, &self.configuration) == (&other.names, &other.configuration)
    }

    /// Whether it is ends that give about an axis of the structure, and the other is the same about one of the member.
    pub fn is_skew_to(&self, other: &Self) -> bool {
        let is_about =
            ABOUT.contains(&self.direction()) && Dof::from_name(other.direction()).is_some_and(Dof::is_rotation);
        is_about && (&self.names, &self.configuration) == (&other.names, &other.configuration)
    }

    /// Whether it is nodes that are moved without those inside of their members.
    pub fn leaves_those_inside(&self) -> bool {
        ALONE.contains(&self.direction())
    }

    /// Whether it is nodes that are moved along an axis, and the other is the same with those inside of their members.
    pub fn is_without_those_inside(&self, other: &Self) -> bool {
        let axis = ALONE.iter().position(|alone| *alone == self.direction());
        axis.is_some_and(|i| AXES[i] == other.direction())
            && (&self.names, &self.configuration) == (&other.names, &other.configuration)
    }

    /// Whether it is nodes or ends with all axes.
    pub fn has_all_axes(&self) -> bool {
        self.direction() == ALL_AXES
    }

    /// Whether an effect acts there along, or about, an axis.
    pub(super) fn is_along(&self, dof: Dof) -> bool {
        self.has_all_axes() || self.direction() == dof.name()
    }

    /// Whether it is of the same kind, in the same direction and configuration, at as many things.
    pub fn is_like(&self, other: &Self) -> bool {
        (self.kind, self.direction(), &self.configuration, self.names.len())
            == (other.kind, other.direction(), &other.configuration, other.names.len())
    }

    /// The same in a direction.
    #[must_use]
    pub fn along(mut self, direction: &str) -> Self {
        self.direction = Some(direction.to_string());
        self
    }

    /// The same in one configuration only.
    #[must_use]
    pub fn within(mut self, configuration: &str) -> Self {
        self.configuration = Some(configuration.to_string());
        self
    }

    /// The direction, or nothing.
    pub fn direction(&self) -> &str {
        self.direction.as_deref().unwrap_or_default()
    }

    /// Its names without the direction: `n8+n13`.
    pub fn place(&self) -> String {
        if self.names.is_empty() { "whole".to_string() } else { self.names.join("+") }
    }

    /// Whether both name a thing: `n8` and `n8+n13.ry` do, and `wing.1:n5` and `n5`.
    pub fn shares_name(&self, other: &Self) -> bool {
        let parts = |l: &Self| l.names.iter().flat_map(|n| n.split(':')).map(str::to_string).collect::<Vec<_>>();
        let own = parts(self);
        parts(other).iter().any(|n| own.contains(n))
    }

    /// As a part of names in the file, which have no `+`: `n8_and_n13.ry`.
    pub(super) fn stem(&self) -> String {
        let text = self.to_string().replace('+', "_and_");
        text.chars().map(|c| if c.is_alphanumeric() || matches!(c, '_' | '.' | ':') { c } else { '_' }).collect()
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(configuration) = &self.configuration {
            write!(f, "{configuration}/")?;
        }
        f.write_str(&self.place())?;
        match &self.direction {
            Some(direction) => write!(f, ".{direction}"),
            None => Ok(()),
        }
    }
}
