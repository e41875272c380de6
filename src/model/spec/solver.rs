//! A program that computes the matrices of a superelement.

use super::{MatrixSpec, Named};
use crate::units::Scalar;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A program that writes matrices. It is run by `retune prepare` alone, a few times, at values of the parameters that its template names.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverSpec {
    /// The program and its arguments, no shell between: `ccx -i {job}`; a list where an argument has blanks. `{job}` is the name of the input
    /// file without its ending, `{file}` with it.
    pub run: WordsSpec,
    /// The input file, with `{{E_skin:MPa}}` where a parameter stands, in its unit. The ending `.tpl` is dropped.
    pub template: String,
    /// Other files that the program reads, such as a mesh that the input includes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
    /// What it writes: the name of a program whose files are known, or the files.
    pub writes: WritesSpec,
    /// How the matrices go with parameters; in proportion when absent.
    #[serde(default, skip_serializing_if = "indexmap::IndexMap::is_empty")]
    pub parameters: Named<DependenceSpec>,
    /// After which time a run is stopped: `10 min`; 1 h when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_limit: Option<Scalar>,
}

/// A command.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum WordsSpec {
    /// Words between blanks.
    Text(String),
    /// Words.
    List(Vec<String>),
}

impl WordsSpec {
    /// Its words.
    pub fn words(&self) -> Vec<String> {
        match self {
            Self::Text(text) => text.split_whitespace().map(str::to_string).collect(),
            Self::List(words) => words.clone(),
        }
    }
}

/// What a program writes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum WritesSpec {
    /// Files of a known program: `calculix`, which writes `{job}.sti`, `.mas` and `.dof` for `*FREQUENCY, SOLVER=MATRIXSTORAGE`.
    Known(KnownSolver),
    /// These files, where `{job}` is the name of the input file without its ending.
    Files(WrittenSpec),
}

/// A program whose files are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KnownSolver {
    /// CalculiX CrunchiX.
    Calculix,
}

/// Files that a program writes, in the folder where it runs.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WrittenSpec {
    /// Stiffness matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub k: Option<MatrixSpec>,
    /// Mass matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub m: Option<MatrixSpec>,
    /// Matrix of viscous damping.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<MatrixSpec>,
    /// Table of dofs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dofs: Option<String>,
    /// Positions of the nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nodes: Option<String>,
}

/// How matrices go with a parameter.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DependenceSpec {
    /// Powers of the parameter, besides what does not go with it; `[1]` when absent. The thickness of a plate: `[1, 3]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub powers: Vec<u32>,
    /// Values at which the program runs, one more than powers; when absent they are spread evenly over the bounds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<Scalar>,
}
