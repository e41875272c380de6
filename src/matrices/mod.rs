//! Matrices of other solvers: sparse numbers with labels of their dofs, and the files that they come in.
//!
//! Numbers, triplets and tables of dofs only; what they mean for a structure is the business of `model`. A [`MatrixReader`] takes the
//! bytes of one file and gives its [`Contents`]; [`MATRIX_READERS`] lists them, [`read`] finds the one of a file. Counts of headers are
//! checked against the bytes there are before anything is stored, so that memory is bounded by the size of the file.
//!
//! To add a format: a file here with a unit struct and `impl MatrixReader`, `mod` and a line in [`MATRIX_READERS`].

mod abaqus;
mod ansys;
mod bulk_data;
mod calculix;
mod coordinate_systems;
mod element_matrices;
mod error;
mod harwell_boeing;
mod inspect;
mod matlab;
mod matrix;
mod matrix_market;
mod node_lines;
mod numpy;
mod output4;
mod process;
mod table;
mod text;
mod write;

pub use error::MatrixError;
pub use inspect::{Inspection, RIGID, inspect, suspected_length};
pub use matrix::{Contents, DofRow, Entry, Label, Matrix, Symmetric, SymmetryError};
pub use process::{MARKER, Process, ProcessError};
pub use write::{MatrixFormat, write};

use crate::catalogue::catalogue;

catalogue! {
    /// Every format of matrices, of tables of dofs and of positions that is read; the first that recognises a file reads it.
    MATRIX_READERS: dyn MatrixReader;
    matrix_market::MatrixMarket,
    numpy::Numpy,
    matlab::Matlab,
    output4::Output4,
    bulk_data::BulkData,
    element_matrices::ElementMatrixOutput,
    node_lines::NodeLines,
    ansys::Mapping,
    harwell_boeing::HarwellBoeing,
    calculix::DofLines,
    abaqus::LabelledLines,
    calculix::IndexedLines,
    table::Table,
}

/// A file in memory.
#[derive(Debug, Clone, Copy)]
pub struct File<'a> {
    /// Its name, for its extension and for names of matrices that have none.
    pub name: &'a str,
    /// Its bytes.
    pub bytes: &'a [u8],
}

impl<'a> File<'a> {
    /// What stands behind the last point of its name, in small letters.
    pub fn extension(&self) -> String {
        let file = self.name.rsplit(['/', '\\']).next().unwrap_or_default();
        file.rsplit_once('.').map_or_else(String::new, |(_, e)| e.to_lowercase())
    }

    /// Its name without folder and extension.
    pub fn stem(&self) -> &'a str {
        let file = self.name.rsplit(['/', '\\']).next().unwrap_or_default();
        file.rsplit_once('.').map_or(file, |(stem, _)| stem)
    }

    /// The first bytes of it as text.
    fn head(&self) -> std::borrow::Cow<'a, str> {
        /// No comment at the top of a file is longer.
        const LOOK: usize = 16_384;
        String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(LOOK)])
    }

    /// Its first lines that hold something and are not a comment of Abaqus (`**`), of bulk data (`$`) or of tables (`#`, `%`).
    fn first_lines(&self) -> Vec<String> {
        let head = self.head();
        let lines = head.lines().map(str::trim).filter(|l| !l.is_empty());
        lines.filter(|l| !["**", "$", "#", "%"].iter().any(|c| l.starts_with(c))).take(8).map(str::to_string).collect()
    }
}

/// A format: stateless.
pub trait MatrixReader: std::fmt::Debug + Send + Sync {
    /// Its name, `kebab-case`.
    fn name(&self) -> &'static str;

    /// One sentence: what it is and which program writes it.
    fn summary(&self) -> &'static str;

    /// Whether a file is of this format, by its first bytes and its name.
    fn recognises(&self, file: &File<'_>) -> bool;

    /// Reads a file that it recognises.
    ///
    /// # Errors
    /// [`MatrixError`]: what stands where, and what was expected.
    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError>;
}

/// The format of a file.
///
/// # Errors
/// [`MatrixError::Unknown`].
pub fn reader_of(file: &File<'_>) -> Result<&'static dyn MatrixReader, MatrixError> {
    MATRIX_READERS.iter().copied().find(|r| r.recognises(file)).ok_or(MatrixError::Unknown)
}

/// Reads a file in whatever format it is.
///
/// # Errors
/// [`MatrixError`].
pub fn read(name: &str, bytes: &[u8]) -> Result<Contents, MatrixError> {
    let file = File { name, bytes };
    reader_of(&file)?.read(&file)
}

#[cfg(test)]
mod tests;
