//! Why measurement files cannot be read.

use super::super::convert::ConvertError;
use super::super::csv::CsvError;
use super::super::uff::UffError;
use super::super::{lvm, mat, npy, npz, punch};

/// Why measurement files cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeasurementError {
    /// The operating system refuses.
    #[error("cannot read `{path}`: {reason}")]
    File {
        /// The path.
        path: String,
        /// Why.
        reason: String,
    },
    /// A file of no known kind.
    #[error(
        "`{path}` is not a universal file, a table with a column `frequency_hz` or `point`, a NumPy array, an .npz archive, a MATLAB file or a LabVIEW measurement{hint}"
    )]
    Unknown {
        /// The path.
        path: String,
        /// What it may be instead, and what to do.
        hint: String,
    },
    /// A file without a byte, or of blanks.
    #[error("`{path}` is empty")]
    Empty {
        /// The path.
        path: String,
    },
    /// A universal file.
    #[error("`{path}`: {source}")]
    Uff {
        /// The path.
        path: String,
        /// Why.
        source: UffError,
    },
    /// A table.
    #[error("`{path}`: {source}")]
    Csv {
        /// The path.
        path: String,
        /// Why.
        source: CsvError,
    },
    /// A punch file.
    #[error("`{path}`: {source}")]
    Punch {
        /// The path.
        path: String,
        /// Why.
        source: punch::PunchError,
    },
    /// An array.
    #[error("`{path}`: {source}")]
    Npy {
        /// The path.
        path: String,
        /// Why.
        source: npy::NpyError,
    },
    /// An archive of arrays.
    #[error("`{path}`: {source}")]
    Npz {
        /// The path.
        path: String,
        /// Why.
        source: npz::NpzError,
    },
    /// A MATLAB file.
    #[error("`{path}`: {source}")]
    Mat {
        /// The path.
        path: String,
        /// Why.
        source: mat::MatError,
    },
    /// A LabVIEW measurement over time.
    #[error(
        "`{path}`: channel `{channel}` is a record over time; compute its spectrum or frequency response function first"
    )]
    OverTime {
        /// The path.
        path: String,
        /// Name of the channel.
        channel: String,
    },
    /// Shapes with different points.
    #[error("`{path}` has a shape of {found} points, the other files have {expected}")]
    Shapes {
        /// The path.
        path: String,
        /// Points of the first shape.
        expected: usize,
        /// Points of this one.
        found: usize,
    },
    /// A LabVIEW measurement.
    #[error("`{path}`: {source}")]
    Lvm {
        /// The path.
        path: String,
        /// Why.
        source: lvm::LvmError,
    },
    /// Sets that cannot be joined.
    #[error("`{path}` holds functions beside those of the other files; read tables and arrays one set at a time")]
    SecondSet {
        /// The path.
        path: String,
    },
    /// Units, frequencies or pairs.
    #[error(transparent)]
    Convert(#[from] ConvertError),
}
