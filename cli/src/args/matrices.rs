//! Arguments of `matrices`.

use super::Answer;
use clap::Args;
use std::path::PathBuf;

/// What is in files of matrices: size, symmetry, definiteness, rigid-body modes, massless dofs, suspected units.
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
