//! Static loads whose stresses stiffen or soften a structure.

use super::Named;
use crate::units::Scalar;
use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A static load on the structure as it is held by its supports: the forces in beams and bars, the forces by width in shells and the stresses in
/// solids that it leaves are preloads of them. They are solved for once, at the estimates of the parameters.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StaticPreloadSpec {
    /// Acceleration of gravity, global: `[0, 0, -9.81 m/s2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<[Scalar; 3]>,
    /// Steady rotation of the structure, seen from axes that turn with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spin: Option<SpinSpec>,
    /// Forces and moments on nodes.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub forces: Named<ForceSpec>,
    /// How many times all of it acts; 1 when absent. A parameter here is fitted as any other: stresses are proportional to it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Scalar>,
}

/// A steady rotation. The centrifugal load stiffens what it pulls; that it grows with the distance from the axis softens motions away from it. Coriolis
/// forces are left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpinSpec {
    /// Angular speed: `300 rpm`, `31 rad/s`, `5 Hz`.
    pub speed: Scalar,
    /// Direction of its axis, global.
    pub axis: [f64; 3],
    /// A point of the axis; the origin when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub through: Option<[Scalar; 3]>,
}

/// A force, a moment or both, shared equally by some nodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ForceSpec {
    /// The nodes, sets of a mesh among them.
    pub nodes: Vec<String>,
    /// The whole force, global: `[0, 0, -2 kN]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<[Scalar; 3]>,
    /// The whole moment, global, of nodes that turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moment: Option<[Scalar; 3]>,
}
