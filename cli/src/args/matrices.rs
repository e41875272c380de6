//! Arguments of `matrices` and `prepare`.

use super::{Answer, Print};
use clap::Args;
use std::path::PathBuf;

/// Describe files of matrices: size, symmetry, definiteness, rigid-body modes, massless dofs, suspected units.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune matrices job.sti job.mas job.dof job.inp
  retune matrices wing.op4 --dofs wing_dofs.csv
  retune matrices superelement.pch")]
pub(crate) struct Matrices {
    /// Files of matrices, of tables of dofs, of positions.
    #[arg(required = true)]
    pub(crate) files: Vec<PathBuf>,
    /// Table of dofs of the matrices that do not say them themselves.
    #[arg(long, value_name = "FILE")]
    pub(crate) dofs: Option<PathBuf>,
    /// Positions of the nodes.
    #[arg(long, value_name = "FILE")]
    pub(crate) nodes: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) answer: Answer,
}

/// Run the solvers that a model names (`solver:` of a superelement) and keep the matrices that they write.
///
/// Each runs a few times, at values of its parameters, in a folder of its own under `.retune-solver` beside the model file. No other verb
/// runs anything: they read what is kept there.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune prepare bracket.yaml --dry-run
  retune prepare bracket.yaml")]
pub(crate) struct Prepare {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Say what would be run, and run nothing.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Run also what is kept already.
    #[arg(long)]
    pub(crate) again: bool,
    #[command(flatten)]
    pub(crate) print: Print,
}
