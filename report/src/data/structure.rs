//! The structure as the 3-D views draw it.

use super::Floats;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Nodes, elements and everything attached to them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Structure {
    /// Global axis that points up on the screen: 0, 1 or 2; 2 when missing.
    pub up: Option<usize>,
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Elements.
    pub elements: Vec<Element>,
    /// Property sets that elements share, such as sections.
    pub property_sets: Vec<PropertySet>,
    /// Rigid links.
    pub rigid_links: Vec<RigidLink>,
    /// Point masses.
    pub masses: Vec<PointMass>,
    /// Supports.
    pub supports: Vec<Support>,
    /// Sensors, in the order of every test shape.
    pub sensors: Vec<Sensor>,
    /// Exciters.
    pub exciters: Vec<Exciter>,
    /// Lines through sensors (indices) that show the shape of the test.
    pub trace_lines: Vec<Vec<usize>>,
    /// Scalars that colour the structure: localisation error, energy, COMAC.
    pub fields: Vec<Field>,
}

/// A node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Node {
    /// Its name in the model file.
    pub name: String,
    /// Global coordinates, m.
    pub position: [f64; 3],
}

/// An element: one node (a spring to ground), two (a line) or three and more (a face).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Element {
    /// Its name in the model file.
    pub name: String,
    /// Its type: `beam`, `bar`, `spring`.
    pub kind: String,
    /// Its nodes, as indices.
    pub nodes: Vec<usize>,
    /// Group that it belongs to, such as the chain that made it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub group: String,
    /// Names of the updating parameters that act on it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<String>,
    /// Index of its shared property set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub property_set: Option<usize>,
    /// Its own properties.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub properties: Vec<Property>,
    /// Direction of the z axis of the section of a beam.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_axis: Option<[f64; 3]>,
}

/// A property as it is shown: name and value with unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Property {
    /// Its name: `E`.
    pub name: String,
    /// Its value with unit: `56.0 GPa`.
    pub value: String,
}

impl Property {
    /// A property as it is shown.
    pub fn new(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.into() }
    }
}

/// Properties that several elements share.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PropertySet {
    /// Its name, such as that of a section.
    pub name: String,
    /// Its properties.
    pub properties: Vec<Property>,
}

/// Nodes that follow a master rigidly.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RigidLink {
    /// Its name.
    pub name: String,
    /// Index of the master node.
    pub master: usize,
    /// Indices of the nodes that follow.
    pub slaves: Vec<usize>,
}

/// A mass at a node.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PointMass {
    /// Its name.
    pub name: String,
    /// Index of its node.
    pub node: usize,
    /// Its mass, kg.
    pub mass: Option<f64>,
    /// Where it sits relative to the node, m.
    pub offset: Option<[f64; 3]>,
    /// Names of the updating parameters that act on it.
    pub parameters: Vec<String>,
    /// Its other properties, such as inertias.
    pub properties: Vec<Property>,
}

/// A supported node.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Support {
    /// Index of its node.
    pub node: usize,
    /// Which degrees of freedom it holds: `ux uy uz`.
    pub dofs: String,
}

/// A sensor of the test.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sensor {
    /// Its name in the test.
    pub name: String,
    /// Where it sits, m.
    pub position: [f64; 3],
    /// Its unit direction.
    pub direction: [f64; 3],
    /// Whether it reads a rotation about the direction.
    pub is_rotation: bool,
    /// What it is attached to, as text.
    pub attached_to: String,
}

/// A point of excitation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Exciter {
    /// Its name.
    pub name: String,
    /// Where it acts, m.
    pub position: [f64; 3],
    /// Its unit direction.
    pub direction: [f64; 3],
}

/// What a field has one value for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Carrier {
    /// Every element.
    #[default]
    Elements,
    /// Every node.
    Nodes,
    /// Every sensor.
    Sensors,
}

/// How a field is coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// From the smallest value to the largest.
    #[default]
    Sequential,
    /// Symmetric about zero.
    Diverging,
    /// From 0 to 1.
    Unit,
}

/// A scalar over the structure.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Field {
    /// What it is: `localisation error`, `strain energy, mode 3`, `COMAC`.
    pub name: String,
    /// Its unit, or empty.
    pub unit: String,
    /// What it has one value for.
    pub on: Carrier,
    /// How it is coloured.
    pub scale: Scale,
    /// The value that means neither good nor bad, as 1 of a ratio to what noise leaves: the middle of the colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anchor: Option<f64>,
    /// One sentence: how it was computed and how to read it.
    pub about: String,
    /// The values; NaN where there is none.
    pub values: Floats,
}
