//! Frames, lines, and the places of nodes.

use super::NodeLabel;
use super::SignedAxis;
use crate::units::Scalar;
use schemars::JsonSchema;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A coordinate frame: an origin and turned axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrameSpec {
    /// Origin in global axes; zero when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<[Scalar; 3]>,
    /// Rotations about global axes, applied in the order x, y, z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<RotateSpec>,
    /// Direction of the frame's x axis, instead of `rotate`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[f64; 3]>,
    /// A direction in the frame's x-y plane, on the side of +y, together with `x`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xy: Option<[f64; 3]>,
}

/// Angles about the global axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotateSpec {
    /// About x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<Scalar>,
    /// About y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<Scalar>,
    /// About z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<Scalar>,
}

/// A straight line: a point and a direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LineSpec {
    /// Where distances count from.
    pub from: [Scalar; 3],
    /// Direction: an axis such as `-y`.
    pub direction: SignedAxis,
    /// The axis towards which the direction is turned by `angle`: `+x` for a wing swept aft.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toward: Option<SignedAxis>,
    /// Angle of the turn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle: Option<Scalar>,
}

/// Where a node is: `[x, y, z]` in global axes, or one of the rules of [`NodeRule`].
#[derive(Debug, Clone, PartialEq)]
pub enum NodeSpec {
    /// Global coordinates.
    At([Scalar; 3]),
    /// By a rule.
    Rule(NodeRule),
}

/// A rule for the place of a node; exactly one of `line`, `frame`, `mirror`, `from`, `between`, `coordinate`, `mesh`, `nearest`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeRule {
    /// On this line, at the distance `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<String>,
    /// In this frame, at the position `at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// A distance on the line, or a position `[x, y, z]` in the frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<OneOrThree>,
    /// The mirror image of this node in the symmetry plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror: Option<String>,
    /// Beside this node, by `offset`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<String>,
    /// Offset from the node of `from`, global axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<[Scalar; 3]>,
    /// Between two nodes, at `fraction`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between: Option<[String; 2]>,
    /// 0 at the first node of `between`, 1 at the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fraction: Option<Scalar>,
    /// No point of the structure but a coordinate, drawn here: `ux` is its one dof, and no rigid motion moves it. The scalar point of a deck.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coordinate: Option<[Scalar; 3]>,
    /// The node of the mesh with this number, which is called by this name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<NodeLabel>,
    /// The node of the mesh that is nearest to this place, global axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nearest: Option<[Scalar; 3]>,
}

/// How far a node stands from where its entry puts it; what is placed by it follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NodeOffsetSpec {
    /// The node.
    pub node: String,
    /// What is added to its place, global axes: `[x_error, 0 m, 0 m]`.
    pub offset: [Scalar; 3],
}

impl Serialize for NodeSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            NodeSpec::At(position) => position.serialize(serializer),
            NodeSpec::Rule(rule) => rule.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for NodeSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NodeVisitor;
        impl<'de> Visitor<'de> for NodeVisitor {
            type Value = NodeSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a position `[x, y, z]` or a rule such as `{line: spar, at: 0.4 m}`, `{mirror: n4}`, `{from: n4, offset: [x, y, z]}`")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<NodeSpec, A::Error> {
                Deserialize::deserialize(de::value::SeqAccessDeserializer::new(seq)).map(NodeSpec::At)
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<NodeSpec, A::Error> {
                Deserialize::deserialize(de::value::MapAccessDeserializer::new(map)).map(NodeSpec::Rule)
            }
        }
        deserializer.deserialize_any(NodeVisitor)
    }
}

impl JsonSchema for NodeSpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "NodeSpec".into()
    }
    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let at = generator.subschema_for::<[Scalar; 3]>();
        let rule = generator.subschema_for::<NodeRule>();
        schemars::json_schema!({"anyOf": [at, rule]})
    }
}

/// A number, or three of them.
#[derive(Debug, Clone, PartialEq)]
pub enum OneOrThree {
    /// A distance.
    One(Scalar),
    /// A position.
    Three([Scalar; 3]),
}

impl Serialize for OneOrThree {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            OneOrThree::One(s) => s.serialize(serializer),
            OneOrThree::Three(s) => s.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for OneOrThree {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrThreeVisitor;
        impl<'de> Visitor<'de> for OneOrThreeVisitor {
            type Value = OneOrThree;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a distance such as `0.4 m`, or a position `[x, y, z]`")
            }
            fn visit_f64<E: de::Error>(self, value: f64) -> Result<OneOrThree, E> {
                Ok(OneOrThree::One(Scalar::constant(value)))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<OneOrThree, E> {
                self.visit_f64(value as f64)
            }
            fn visit_u64<E: de::Error>(self, value: u64) -> Result<OneOrThree, E> {
                self.visit_f64(value as f64)
            }
            fn visit_str<E: de::Error>(self, value: &str) -> Result<OneOrThree, E> {
                Scalar::parse(value).map(OneOrThree::One).map_err(E::custom)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<OneOrThree, A::Error> {
                Deserialize::deserialize(de::value::SeqAccessDeserializer::new(seq)).map(OneOrThree::Three)
            }
        }
        deserializer.deserialize_any(OneOrThreeVisitor)
    }
}

impl JsonSchema for OneOrThree {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "OneOrThree".into()
    }
    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let one = generator.subschema_for::<Scalar>();
        let three = generator.subschema_for::<[Scalar; 3]>();
        schemars::json_schema!({"anyOf": [one, three]})
    }
}
