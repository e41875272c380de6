//! Arguments of `export`.

use super::{Overwrite, values};
use clap::{ArgGroup, Args, ValueEnum};
use retune::catalogue::Choice;
use retune::matrices::MatrixFormat;
use std::path::PathBuf;

/// How matrices are reduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Reduction {
    /// Static: exact in statics.
    Guyan,
    /// By modes: exact in the modes that are kept.
    Serep,
    /// Static modes of the nodes, and modes with them held.
    CraigBampton,
}

/// Write a model for other programs: its new values into the deck that it was imported from, or its matrices.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("what").required(true).args(["matrices", "into"]), after_help = "Examples:
  retune export updated.yaml --into wing.bdf -o updated.bdf
  retune export models/garteur.yaml --matrices -o garteur
  retune export models/garteur.yaml --matrices --format op4-binary -o garteur
  retune export models/garteur.yaml --matrices --reduce craig-bampton --at wing_root,tail --modes 20 -o garteur_cb

Into a deck: every byte that states no changed value stays: formats, comments, order. Files that the deck includes are written beside the output
under their own names, where they changed or the folder is another. What has no card is refused by name, and nothing is written.")]
pub(crate) struct Export {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Write the matrices.
    #[arg(long)]
    pub(crate) matrices: bool,
    /// The deck that the model was imported from.
    #[arg(long, value_name = "DECK")]
    pub(crate) into: Option<PathBuf>,
    /// Where to write the deck; of matrices the first part of the names of the files: STEM_K.mtx, STEM_M.mtx, STEM_dofs.csv, and so on.
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Format of the matrices.
    #[arg(long, value_name = "FORMAT", default_value = MatrixFormat::MatrixMarket.word(), conflicts_with = "into", value_parser = values::choice::<MatrixFormat>())]
    pub(crate) format: MatrixFormat,
    /// Reduce the matrices to some nodes.
    #[arg(long, value_enum, value_name = "HOW", conflicts_with = "into")]
    pub(crate) reduce: Option<Reduction>,
    /// Nodes that stay.
    #[arg(long, value_name = "NODE", value_delimiter = ',', requires = "reduce")]
    pub(crate) at: Vec<String>,
    /// Tests whose sensors' nodes stay.
    #[arg(long, value_name = "TEST", requires = "reduce", conflicts_with = "at", num_args = 1..)]
    pub(crate) test: Vec<PathBuf>,
    /// Number of modes of SEREP or Craig-Bampton.
    #[arg(long, default_value_t = 20, value_parser = values::count(1, 2000))]
    pub(crate) modes: u16,
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME", conflicts_with = "into")]
    pub(crate) configuration: Option<String>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
}
