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
//! * A column is `<response>[.<direction>][/<reference>[.<direction>]]:<part>`; direction `+x`, `-x`, ... in global axes, also
//!   `12+z`; part `re` and `im`, or `amp` and `phase_deg` or `phase_rad`, and optionally `coh` for the coherence. Words of other
//!   programs are understood: `tip real`, `Amplitude [g/N]`, `tip phase (deg)`; a table of one function needs no name of a point. In names, what has a meaning here is
//!   written `\x2f`, with the digits of its code.
//! * The column of frequencies is `frequency_hz`, `Frequency [rad/s]`, `f`, ...; its name or the row of units states its unit, else it
//!   is asked about.
//! * Text is UTF-8, or UTF-16 with a byte order mark. A first line `sep=;` is the delimiter; else that of `,`, `;`, tab is, which cuts
//!   header and first row alike. Decimals have a point, or a comma throughout, in cells that are quoted where the comma separates.
//!   Lines that are blank or start with `#` are skipped, and so are columns at the end without name and content.
//! * The unit of a function is one of response over force, such as `m/s2/N`, `g/N`, `mm/N`; it is not guessed.
//! * A function or a point that is there twice: columns are asked about, of points the last one counts, with a note.
//!
//! [`read_shapes`] reads a table of shapes, points down and modes across.
//!
//! Other layouts: [`function`] reads one measurement from named columns, [`openmodal`] the export of OpenModal.
//! Errors name the line and the column.

mod frfs;
mod header;
mod names;
pub mod openmodal;
mod shapes;
mod sheet;

pub use frfs::{Columns, CsvFrfOptions, function, read_frfs, write_frfs};
pub(in crate::data) use header::is_mode;
pub use shapes::{ShapeTable, read_points, read_shapes};
pub(in crate::data) use shapes::{coordinate, is_point};
pub use sheet::{Row, Sheet, text_of};
pub(in crate::data) use sheet::{names_of, wide_without_mark};

/// Whether the name of a column says that it holds frequencies.
pub(in crate::data) fn is_frequency(name: &str) -> bool {
    header::frequency_column(name).is_some()
}

use super::convert::ConvertError;

/// Why a table cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CsvError {
    /// No header.
    #[error("the table is empty; the first line must name the columns")]
    Empty,
    /// Text that is not UTF-8.
    #[error("line {line}: the table is not UTF-8 but {found}; save it as UTF-8")]
    Encoding {
        /// Line of the file.
        line: usize,
        /// What it seems to be.
        found: String,
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
    /// A cell that is not a number.
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
