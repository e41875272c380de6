//! Comma-separated values: frequency response functions in one table, or one table for each measurement.
//!
//! The layout of this crate, written by [`write_frfs`] and read by [`read_frfs`]:
//!
//! ```text
//! frequency_hz,12.+z/1.+z:re,12.+z/1.+z:im,12.+z/1.+z:coh,...     names
//! Hz,m/s2/N,m/s2/N,1,...                                          units, may be absent if stated otherwise
//! 0.5,0.001,-0.002,0.99,...                                       values
//! ```
//!
//! * A column is `<response>[.<direction>][/<reference>[.<direction>]]:<part>`; direction `+x`, `-x`, ... in global axes;
//!   part `re`, `im`, and optionally `coh` for the coherence.
//! * Delimiter `,`, `;` or tab, whichever is most frequent in the first line. With `;` or tab a decimal comma is
//!   understood. Cells may be quoted. Lines that are blank or start with `#` are skipped.
//! * The unit of a function is one of response over force, such as `m/s2/N`, `g/N`, `mm/N`; it is not guessed.
//!
//! [`read_shapes`] reads a table of shapes, points down and modes across.
//!
//! Other layouts: [`function`] reads one measurement from named columns, [`openmodal`] the export of OpenModal.
//! Errors name the line and the column.

mod frfs;
pub mod openmodal;
mod shapes;
mod sheet;

pub use frfs::{Columns, CsvFrfOptions, function, read_frfs, write_frfs};
pub(in crate::data) use shapes::frequency_of;
pub use shapes::{ShapeTable, read_shapes};
pub use sheet::{Row, Sheet};

use super::convert::ConvertError;

/// Why a table cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CsvError {
    /// No header.
    #[error("the table is empty; the first line must name the columns")]
    Empty,
    /// Text that is not UTF-8.
    #[error("line {line}: bytes that are not UTF-8; save the table as UTF-8")]
    NotUtf8 {
        /// Line of the file.
        line: usize,
    },
    /// A row of another length.
    #[error("line {line}: {found} cells, the first line has {expected}")]
    Ragged {
        /// Line of the file.
        line: usize,
        /// Cells in the row.
        found: usize,
        /// Columns.
        expected: usize,
    },
    /// A cell that is no number.
    #[error("line {line}, column {column} (`{name}`): `{text}` where {expected} should stand")]
    Cell {
        /// Line of the file.
        line: usize,
        /// Number of the column, from 1.
        column: usize,
        /// Its name.
        name: String,
        /// What stands there.
        text: String,
        /// What should.
        expected: &'static str,
    },
    /// A column that must be there.
    #[error("no column `{name}`{hint}; there are: {present}")]
    NoColumn {
        /// Its name.
        name: String,
        /// The nearest name.
        hint: String,
        /// The columns there are.
        present: String,
    },
    /// A column whose name does not say what it is.
    #[error("column `{name}`: {expected}")]
    ColumnName {
        /// Its name.
        name: String,
        /// What the name must be.
        expected: &'static str,
    },
    /// A file that cannot be opened.
    #[error("`{path}`: {reason}")]
    File {
        /// The path.
        path: String,
        /// Why.
        reason: String,
    },
    /// Something about units, frequencies or pairs.
    #[error(transparent)]
    Convert(#[from] ConvertError),
}
