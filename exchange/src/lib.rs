//! Models and the decks of other programs: import, proof that both are one model, and export of what was learnt.
//!
//! [`import`] turns a Nastran deck, [`import_keywords`] one of Abaqus or CalculiX, into the text of a model file and says what was read, left
//! out and approximated. [`read_results`] reads what the solver itself computed (.f06, .op2, .pch, .dat, .frd), [`compare_results`] holds a model against it. [`export`] writes the values of an
//! updated model back into the fields of the deck, every other byte kept.

mod abaqus;
mod against;
mod coord;
mod export;
mod imported;
mod listed;
mod motions;
mod names;
mod nastran;
mod patches;
mod report;
mod results;
mod shapes;
mod system;
mod text;
mod walls;
mod writer;

#[cfg(test)]
#[path = "../../base/src/arrays/mutate.rs"]
mod mutate;

pub use abaqus::{KEYWORDS, KeywordRule, KeywordUse, import_keywords};
pub use against::{Agreement, MassAgreement, ModeAgreement, compare_results};
pub use export::{ExportError, Exported, export, export_keywords};
pub use imported::{ImportOptions, Imported, Solver};
pub use listed::MeshFile;
pub use nastran::{CARDS, CardRule, Treatment, import};
pub use report::ImportReport;
pub use results::{ResultMode, ResultsError, SolverResults, read_results};
pub use system::{Quantity, SYSTEMS, System, system_by_name};
