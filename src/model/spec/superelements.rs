//! Parts of a structure whose matrices come from files.

use super::super::exported::Loaded;
use super::{AxisName, Named, SolverSpec};
use crate::units::Scalar;
use schemars::JsonSchema;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use serde::ser::Serializer;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A part of the structure whose matrices come from files of another solver.
///
/// Paths are relative to the model file. Nodes are those of the table of dofs: `NAME.NODE` in the model, or the node of the model that they
/// are attached to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuperelementSpec {
    /// Stiffness matrix: a file, or `{file: all.op4, matrix: KAAX}` where it holds several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<MatrixSpec>,
    /// Mass matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m: Option<MatrixSpec>,
    /// Matrix of viscous damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<MatrixSpec>,
    /// Stiffness of a preload, apart from `k`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload: Option<PreloadSpec>,
    /// Table of dofs, a row for each row of the matrices, where they do not say it themselves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dofs: Option<String>,
    /// Positions of the nodes, where neither the table nor the matrices say them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<String>,
    /// Whether nodes of the table without a position are inner ones, as shells and incompatible modes of CalculiX bring: their dofs are
    /// coordinates without a place. What stands on such a superelement is to be held by supports, for rigid motions do not reach them.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub inner: bool,
    /// Units of the files; SI when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<UnitsSpec>,
    /// Whether nothing holds it by itself: what the digits of its files leave of stiffness against rigid motions is taken out, which makes its
    /// stiffness a full matrix; up to 3 000 dofs.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub free: bool,
    /// Frame in which it stands; global axes when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Mirrored in the plane through its own origin across this axis of its own, before it is placed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror: Option<AxisName>,
    /// Nodes of the model that are nodes of it: `{hub: 12}`.
    #[serde(default, skip_serializing_if = "indexmap::IndexMap::is_empty")]
    pub attach: Named<NodeLabel>,
    /// Its nodes that stand within this distance of a node of the model, or of an earlier superelement, are that node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub attach_within: Option<Scalar>,
    /// Parts of its matrices that go with parameters: the name is that of the parameter, or any where `parameter` is given.
    #[serde(default, skip_serializing_if = "indexmap::IndexMap::is_empty")]
    pub terms: Named<TermSpec>,
    /// Whole matrices at values of several parameters, which check that the terms add up.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub checks: Vec<CheckSpec>,
    /// A program that computes the matrices; `k`, `m`, `c` and `terms` follow from it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverSpec>,
    /// Points whose motion follows from its dofs by a matrix, as those inside a reduced model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recovery: Option<RecoverySpec>,
    /// Its nodes at which effects are looked for; when absent all of them, or of a large one a hundred that are spread evenly.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effect_nodes: Option<Vec<NodeLabel>>,
    /// What its files hold, once they were read.
    #[serde(skip)]
    #[schemars(skip)]
    pub(in crate::model) loaded: Loaded,
}

impl SuperelementSpec {
    /// Names of its terms: those of the entry, or those that its solver makes.
    pub fn term_names(&self) -> Vec<&str> {
        match &self.loaded.0 {
            Some(exported) => exported.terms.iter().map(|t| t.name.as_str()).collect(),
            None => self.terms.keys().map(String::as_str).collect(),
        }
    }
}

/// The stiffness of a preload.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PreloadSpec {
    /// The matrix.
    pub k: MatrixSpec,
    /// How many times the preload of the matrix; 1 when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<Scalar>,
}

/// Units of the numbers in the files.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UnitsSpec {
    /// Of lengths and positions: `mm`; m when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<String>,
    /// Of forces: `N`; that which goes with the unit of mass when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<String>,
    /// Of masses: `t`; that which goes with the unit of force when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<String>,
    /// Of time: `ms`; s when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
}

/// A part of the matrices that goes with a parameter θ: K = K0 + c(θ) K_k, and so for M and C.
///
/// ```text
/// c(θ) = θ^power                                     the files are per unit, SI
/// c(θ) = (θ/at)^power                                the files are of θ = at, and not in K0
/// c(θ) = (θ/at)^power - 1                            the same, and in K0 (`included`)
/// ```
///
/// With `exports` the part is the difference of whole matrices: those of the superelement are of θ = at, those of each export of its own.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TermSpec {
    /// The parameter, where it is not the name of the term.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter: Option<String>,
    /// Stiffness matrix of the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<MatrixSpec>,
    /// Mass matrix of the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m: Option<MatrixSpec>,
    /// Matrix of viscous damping of the part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<MatrixSpec>,
    /// Power of the parameter, 1 to 6; 1 when absent. Bending of a plate goes with the third power of its thickness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power: Option<u32>,
    /// Several powers at once, with `exports`: `[1, 3]` for membrane and bending of a plate by its thickness. As many exports are needed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub powers: Vec<u32>,
    /// Value of the parameter that the matrices are of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Scalar>,
    /// Whether the matrices of the superelement include the part already.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub included: bool,
    /// Whole matrices at other values of the parameter; those beyond one for each power check that the powers are right.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exports: Vec<ExportSpec>,
}

/// Whole matrices at a value of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExportSpec {
    /// Value of the parameter.
    pub at: Scalar,
    /// Stiffness matrix; unchanged when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<MatrixSpec>,
    /// Mass matrix; unchanged when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m: Option<MatrixSpec>,
    /// Matrix of viscous damping; unchanged when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<MatrixSpec>,
}

/// Whole matrices at values of parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckSpec {
    /// A value for the parameter of every term.
    pub at: Named<Scalar>,
    /// Stiffness matrix; not looked at when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<MatrixSpec>,
    /// Mass matrix; not looked at when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m: Option<MatrixSpec>,
    /// Matrix of viscous damping; not looked at when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<MatrixSpec>,
}

/// Points whose motion follows: u = R q.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecoverySpec {
    /// R: a row for each row of `dofs`, a column for each dof of the superelement.
    pub matrix: MatrixSpec,
    /// Table of the dofs that follow, with positions.
    pub dofs: String,
}

/// A matrix: the name of its file, or the file and its name there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct MatrixSpec {
    /// The file, relative to the model file.
    pub file: String,
    /// Its name in a file with several.
    pub matrix: Option<String>,
    /// Whether the file has one triangle and does not say that the other is its image.
    pub triangle: bool,
}

/// [`MatrixSpec`] in full.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MatrixInFile {
    /// The file, relative to the model file.
    file: String,
    /// Its name in a file with several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    matrix: Option<String>,
    /// Whether the file has one triangle and does not say that the other is its image.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    triangle: bool,
}

impl Serialize for MatrixSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.matrix.is_none() && !self.triangle {
            return serializer.serialize_str(&self.file);
        }
        let MatrixSpec { file, matrix, triangle } = self.clone();
        MatrixInFile { file, matrix, triangle }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for MatrixSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct MatrixVisitor;
        impl<'de> Visitor<'de> for MatrixVisitor {
            type Value = MatrixSpec;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a file such as `wing_K.mtx`, or `{file: wing.op4, matrix: KAAX}`")
            }
            fn visit_str<E: de::Error>(self, value: &str) -> Result<MatrixSpec, E> {
                Ok(MatrixSpec { file: value.to_string(), ..MatrixSpec::default() })
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<MatrixSpec, A::Error> {
                let MatrixInFile { file, matrix, triangle } =
                    Deserialize::deserialize(de::value::MapAccessDeserializer::new(map))?;
                Ok(MatrixSpec { file, matrix, triangle })
            }
        }
        deserializer.deserialize_any(MatrixVisitor)
    }
}

impl JsonSchema for MatrixSpec {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "MatrixSpec".into()
    }
    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let file = generator.subschema_for::<String>();
        let in_file = generator.subschema_for::<MatrixInFile>();
        schemars::json_schema!({"anyOf": [file, in_file]})
    }
}

/// Name or number of a node of a superelement, as its table has it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct NodeLabel(pub String);

impl Serialize for NodeLabel {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.parse::<u64>() {
            Ok(number) if number.to_string() == self.0 => serializer.serialize_u64(number),
            _ => serializer.serialize_str(&self.0),
        }
    }
}

impl<'de> Deserialize<'de> for NodeLabel {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct LabelVisitor;
        impl Visitor<'_> for LabelVisitor {
            type Value = NodeLabel;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name or the number of a node of the superelement")
            }
            fn visit_str<E: de::Error>(self, value: &str) -> Result<NodeLabel, E> {
                Ok(NodeLabel(value.to_string()))
            }
            fn visit_u64<E: de::Error>(self, value: u64) -> Result<NodeLabel, E> {
                Ok(NodeLabel(value.to_string()))
            }
            fn visit_i64<E: de::Error>(self, value: i64) -> Result<NodeLabel, E> {
                Ok(NodeLabel(value.to_string()))
            }
        }
        deserializer.deserialize_any(LabelVisitor)
    }
}

impl JsonSchema for NodeLabel {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "NodeLabel".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({"type": ["string", "integer"]})
    }
}
