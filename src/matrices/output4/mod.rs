//! OUTPUT4 files of Nastran (`.op4`): matrices by name, as text or binary, dense or sparse, with BIGMAT or without.
//!
//! ```text
//!        3       3       6       2KAA     1P,3E23.16      columns, rows (negative: BIGMAT), form, type, name, format
//!        1       1       2                                column, first row (0: sparse), number of words
//!  1.0000000000000000E+00-1.0000000000000000E+00
//! ```
//!
//! Of a sparse column each string has a head of its own: L and the first row, in one number `65536 (L + 1) + row` or with BIGMAT in two, `L + 1`
//! and the row; L counts words, of which a double has two. Columns without entries are left out; a column behind the last one ends a matrix.
//! Binary files are Fortran records of 4-byte or 8-byte words, in either byte order. A form of 6 is a symmetric matrix with both its triangles.
//!
//! Source: MSC.Nastran DMAP Programmer's Guide, OUTPUT4.

mod binary;
mod text;
mod write;

pub(super) use write::{Layout, write};

use super::{Contents, File, Matrix, MatrixError, MatrixReader};

/// OUTPUT4 of Nastran.
#[derive(Debug, Clone, Copy)]
pub struct Output4;

const FORMAT: &str = "OUTPUT4";

impl MatrixReader for Output4 {
    fn name(&self) -> &'static str {
        "output4"
    }

    fn summary(&self) -> &'static str {
        "OUTPUT4 of Nastran (.op4): text or binary, dense, sparse or BIGMAT, single or double, several matrices by name."
    }

    fn recognises(&self, file: &File<'_>) -> bool {
        binary::Words::of(file.bytes).is_some() || file.head().lines().next().is_some_and(|l| text::head(l).is_some())
    }

    fn read(&self, file: &File<'_>) -> Result<Contents, MatrixError> {
        let mut contents = Contents::default();
        match binary::Words::of(file.bytes) {
            Some(words) => binary::read(&words, file.bytes, &mut contents)?,
            None => text::read(file.bytes, &mut contents)?,
        }
        if contents.matrices.is_empty() && contents.notes.is_empty() {
            return Err(MatrixError::broken(FORMAT, "it holds no matrix"));
        }
        Ok(contents)
    }
}

/// The head of a matrix.
#[derive(Debug, Clone, PartialEq)]
struct Head {
    name: String,
    n_rows: usize,
    n_columns: usize,
    is_big: bool,
    kind: Kind,
    /// Columns of a number of a text file.
    width: usize,
}

/// What its numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Kind {
    is_double: bool,
    is_complex: bool,
}

impl Kind {
    fn of(number: i64) -> Option<Self> {
        (1..=4).contains(&number).then_some(Self { is_double: number % 2 == 0, is_complex: number > 2 })
    }
}

impl Head {
    fn new(columns: i64, rows: i64, kind: i64, name: &str, width: usize) -> Option<Self> {
        let size = |n: i64| u32::try_from(n).ok().map(|n| n as usize);
        let is_name = name.chars().all(|c| c.is_ascii_graphic());
        let (n_rows, n_columns) = (size(rows.checked_abs()?)?, size(columns)?);
        is_name.then_some(Self {
            name: name.to_string(),
            n_rows,
            n_columns,
            is_big: rows < 0,
            kind: Kind::of(kind)?,
            width,
        })
    }

    fn matrix(&self) -> Matrix {
        Matrix { name: self.name.clone(), n_rows: self.n_rows, n_columns: self.n_columns, ..Matrix::default() }
    }
}

/// A matrix that is being read; imaginary parts are only kept in mind.
struct Growing {
    matrix: Matrix,
    kind: Kind,
    has_imaginary: bool,
}

impl Growing {
    fn new(head: &Head) -> Self {
        Self { matrix: head.matrix(), kind: head.kind, has_imaginary: false }
    }

    /// Successive numbers of a column from a row on; `None` where they leave the matrix.
    fn put(&mut self, column: usize, row: usize, k: usize, value: f64) -> Option<()> {
        if self.kind.is_complex && k % 2 == 1 {
            self.has_imaginary |= value != 0.0;
            return Some(());
        }
        let row = row.checked_add(if self.kind.is_complex { k / 2 } else { k })?;
        if value == 0.0 {
            return (row < self.matrix.n_rows && column < self.matrix.n_columns).then_some(());
        }
        self.matrix.push(row, column, value)
    }

    fn finish(self, contents: &mut Contents) {
        if self.has_imaginary {
            contents
                .notes
                .push(format!("`{}` is complex and is left out: matrices of a model are real", self.matrix.name));
        } else {
            contents.matrices.push(self.matrix);
        }
    }
}
