//! Arguments of `matrices` and `export`.

use clap::{Args, ValueEnum};
use retune::matrices::MatrixFormat;
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
    /// Print JSON instead of text.
    #[arg(long)]
    pub(crate) json: bool,
}

/// A format of matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Matrix Market, a file a matrix.
    Mtx,
    /// Sparse matrices of SciPy, a file a matrix.
    Npz,
    /// OUTPUT4 of Nastran as text.
    Op4,
    /// OUTPUT4 of Nastran, binary.
    Op4Binary,
    /// DMIG and GRID cards of Nastran, with ten digits.
    Dmig,
}

impl Format {
    /// For the library.
    pub(crate) fn format(self) -> MatrixFormat {
        match self {
            Self::Mtx => MatrixFormat::MatrixMarket,
            Self::Npz => MatrixFormat::Npz,
            Self::Op4 => MatrixFormat::Output4,
            Self::Op4Binary => MatrixFormat::Output4Binary,
            Self::Dmig => MatrixFormat::Dmig,
        }
    }
}

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

/// Writes K, M and C of a model at its estimates, with a table of dofs, for other programs.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  retune export models/garteur.yaml --matrices -o garteur
  retune export models/garteur.yaml --matrices --format op4-binary -o garteur
  retune export models/garteur.yaml --matrices --reduce craig-bampton --at wing_root,tail --modes 20 -o garteur_cb")]
pub(crate) struct Export {
    /// Model file.
    pub(crate) model: PathBuf,
    /// Write the matrices.
    #[arg(long, required = true)]
    pub(crate) matrices: bool,
    /// First part of the names of the files: STEM_K.mtx, STEM_M.mtx, STEM_dofs.csv, and so on.
    #[arg(short, long, value_name = "STEM")]
    pub(crate) output: PathBuf,
    /// Format of the matrices.
    #[arg(long, value_enum, default_value = "mtx")]
    pub(crate) format: Format,
    /// Reduce them to some nodes.
    #[arg(long, value_enum, value_name = "HOW")]
    pub(crate) reduce: Option<Reduction>,
    /// Nodes that stay.
    #[arg(long, value_name = "NODE", value_delimiter = ',', requires = "reduce")]
    pub(crate) at: Vec<String>,
    /// Test whose sensors' nodes stay.
    #[arg(long, value_name = "TEST", requires = "reduce", conflicts_with = "at")]
    pub(crate) test: Option<PathBuf>,
    /// Number of modes of SEREP or Craig-Bampton.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=2000))]
    pub(crate) modes: u16,
    /// Configuration of the model: a name under its `configurations`.
    #[arg(long, value_name = "NAME")]
    pub(crate) configuration: Option<String>,
    /// Overwrite files that exist.
    #[arg(long)]
    pub(crate) force: bool,
}
