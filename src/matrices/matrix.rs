//! Sparse matrices with labels.

use crate::element::Dof;
use rayon::prelude::*;
use std::collections::HashMap;
use std::fmt;

/// One entry of a matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Row, from 0.
    pub row: u32,
    /// Column, from 0.
    pub column: u32,
    /// Value.
    pub value: f64,
}

impl Entry {
    /// At a row and a column that are counted as indices are.
    ///
    /// # Panics
    /// If a matrix has 2³² rows.
    pub fn new(row: usize, column: usize, value: f64) -> Self {
        let index = |i: usize| u32::try_from(i).unwrap_or_else(|_| panic!("row {i} of a matrix"));
        Self { row: index(row), column: index(column), value }
    }

    /// Row, column and value.
    pub fn triplet(&self) -> (usize, usize, f64) {
        (self.row as usize, self.column as usize, self.value)
    }

    /// Row and column as indices.
    pub fn place(&self) -> (usize, usize) {
        (self.row as usize, self.column as usize)
    }
}

/// What a row or a column of a matrix stands for.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Label {
    /// Name or number of the node; of a coordinate that is not a motion of a point its own name.
    pub node: String,
    /// The dof; `None` for a coordinate that is not a motion of a point: a modal one, a scalar point.
    pub dof: Option<Dof>,
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.dof {
            Some(dof) => write!(f, "{}.{dof}", self.node),
            None => f.write_str(&self.node),
        }
    }
}

/// A sparse matrix.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Matrix {
    /// Its name in the file, or the file's.
    pub name: String,
    /// Number of rows.
    pub n_rows: usize,
    /// Number of columns.
    pub n_columns: usize,
    /// Its entries in any order; those of one place add up.
    pub entries: Vec<Entry>,
    /// Whether the entries are of one triangle, and the other is its mirror image.
    pub is_one_triangle: bool,
    /// What its rows stand for, where the file says it.
    pub rows: Vec<Label>,
    /// What its columns stand for, where that is not the same as the rows.
    pub columns: Vec<Label>,
}

/// Why a matrix is not a symmetric one.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SymmetryError {
    /// Rectangular.
    #[error("it has {rows} rows and {columns} columns, and must be square")]
    NotSquare {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// One triangle only, and the file does not say that the other is its image.
    #[error(
        "it has entries on one side of its diagonal alone and says nothing of the other; where that is the mirror image, say `triangle: true` beside `file`"
    )]
    OneTriangle,
    /// Not symmetric.
    #[error(
        "it is not symmetric: the largest difference between mirror images is {largest:.1e} of its largest entry; gyroscopic and follower forces are not part of a model here"
    )]
    Asymmetric {
        /// Largest |a_ij - a_ji| over the largest |a_ij|.
        largest: f64,
    },
}

/// The lower triangle of a symmetric matrix, by columns, rows ascending, each place once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Symmetric {
    /// Number of rows.
    pub n: usize,
    /// Entries with row ≥ column; none of them zero.
    pub lower: Vec<Entry>,
    /// Largest |a_ij - a_ji| over the largest |a_ij| that was averaged away.
    pub asymmetry: f64,
}

/// Asymmetry up to this part of the largest entry is rounding of the solver that wrote the matrix.
const ROUNDING: f64 = 1e-8;

impl Matrix {
    /// An entry, if it lies within the matrix.
    pub(super) fn push(&mut self, row: usize, column: usize, value: f64) -> Option<()> {
        let is_inside = row < self.n_rows && column < self.n_columns;
        let entry = Entry { row: u32::try_from(row).ok()?, column: u32::try_from(column).ok()?, value };
        is_inside.then(|| self.entries.push(entry))
    }

    /// As a symmetric matrix; differences of the size of rounding are averaged.
    ///
    /// * `is_one_triangle` - whether the entries are of one triangle, whatever the file says
    ///
    /// # Errors
    /// [`SymmetryError`].
    pub fn symmetric(&self, is_one_triangle: bool) -> Result<Symmetric, SymmetryError> {
        if self.n_rows != self.n_columns {
            return Err(SymmetryError::NotSquare { rows: self.n_rows, columns: self.n_columns });
        }
        let is_one_triangle = is_one_triangle || self.is_one_triangle;
        // By place in the lower triangle; entries of the upper one come after those of the lower one.
        let mut all: Vec<(u32, u32, bool, f64)> = self
            .entries
            .iter()
            .map(|e| (e.column.min(e.row), e.row.max(e.column), e.row < e.column, e.value))
            .collect();
        all.par_sort_by_key(|e| (e.0, e.1, e.2));
        let largest = all.iter().map(|e| e.3.abs()).fold(0.0, f64::max);
        let mut out = Symmetric { n: self.n_rows, ..Symmetric::default() };
        let (mut has_lower, mut has_upper, mut difference) = (false, false, 0.0_f64);
        for place in all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let (column, row) = (place[0].0, place[0].1);
            let sum = |upper: bool| -> f64 { place.iter().filter(|e| e.2 == upper).map(|e| e.3).sum() };
            let value = if row == column || is_one_triangle {
                place.iter().map(|e| e.3).sum()
            } else {
                let (lower, upper) = (sum(false), sum(true));
                has_lower |= lower != 0.0;
                has_upper |= upper != 0.0;
                difference = difference.max((lower - upper).abs());
                // The mean of equal numbers is that number, to the last bit.
                if lower == upper { lower } else { 0.5 * (lower + upper) }
            };
            if value != 0.0 {
                out.lower.push(Entry { row, column, value });
            }
        }
        if largest > 0.0 {
            out.asymmetry = difference / largest;
        }
        if out.asymmetry > ROUNDING {
            return Err(if has_lower && has_upper {
                SymmetryError::Asymmetric { largest: out.asymmetry }
            } else {
                SymmetryError::OneTriangle
            });
        }
        Ok(out)
    }

    /// All its entries by columns, rows ascending, each place once; a triangle with its mirror image.
    pub fn full(&self) -> Vec<Entry> {
        let mut all = self.entries.clone();
        if self.is_one_triangle {
            let beside = self.entries.iter().filter(|e| e.row != e.column);
            all.extend(beside.map(|e| Entry { row: e.column, column: e.row, value: e.value }));
        }
        all.sort_by_key(|e| (e.column, e.row));
        all.dedup_by(|later, kept| {
            let same = (later.row, later.column) == (kept.row, kept.column);
            if same {
                kept.value += later.value;
            }
            same
        });
        all.retain(|e| e.value != 0.0);
        all
    }
}

impl Symmetric {
    /// As a matrix of one triangle.
    pub fn matrix(&self, name: &str, rows: Vec<Label>) -> Matrix {
        Matrix {
            name: name.to_string(),
            n_rows: self.n,
            n_columns: self.n,
            entries: self.lower.clone(),
            is_one_triangle: true,
            rows,
            columns: Vec::new(),
        }
    }
}

/// One row of a table of dofs.
#[derive(Debug, Clone, PartialEq)]
pub struct DofRow {
    /// Which dof.
    pub label: Label,
    /// Where its node is, where the table says it.
    pub position: Option<[f64; 3]>,
    /// Name of the frame whose axes its direction refers to, where the table says it.
    pub frame: Option<String>,
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Contents {
    /// Matrices, in their order.
    pub matrices: Vec<Matrix>,
    /// The dofs of matrices that do not say them themselves, in their order.
    pub dofs: Vec<DofRow>,
    /// Nodes and their positions.
    pub positions: Vec<(String, [f64; 3])>,
    /// Directions of the dofs of nodes, as rows, where they are not those of the global axes.
    pub axes: Vec<(String, [[f64; 3]; 3])>,
    /// What was odd, or left out.
    pub notes: Vec<String>,
}

impl Contents {
    pub(super) fn of(matrix: Matrix) -> Self {
        Self { matrices: vec![matrix], ..Self::default() }
    }
}

/// Numbers labels in the order in which they come.
#[derive(Debug, Default)]
pub(super) struct Numbered {
    pub(super) labels: Vec<Label>,
    index: HashMap<Label, usize>,
}

impl Numbered {
    pub(super) fn index(&mut self, label: Label) -> usize {
        if let Some(&i) = self.index.get(&label) {
            return i;
        }
        self.index.insert(label.clone(), self.labels.len());
        self.labels.push(label);
        self.labels.len() - 1
    }
}

/// A dof by its number 1 to 6, or by a word of any solver.
pub(super) fn dof(word: &str) -> Option<Dof> {
    let word = word.trim().trim_matches('"').to_lowercase();
    let names: [&[&str]; 6] = [
        &["1", "ux", "u1", "tx", "t1", "x", "dx"],
        &["2", "uy", "u2", "ty", "t2", "y", "dy"],
        &["3", "uz", "u3", "tz", "t3", "z", "dz"],
        &["4", "rx", "rotx", "ur1", "r1", "drx"],
        &["5", "ry", "roty", "ur2", "r2", "dry"],
        &["6", "rz", "rotz", "ur3", "r3", "drz"],
    ];
    Dof::ALL.into_iter().find(|d| names[*d as usize].contains(&word.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(entries: &[(u32, u32, f64)]) -> Matrix {
        let entries = entries.iter().map(|&(row, column, value)| Entry { row, column, value }).collect();
        Matrix { n_rows: 2, n_columns: 2, entries, ..Matrix::default() }
    }

    #[test]
    fn symmetry_is_checked_and_rounding_is_averaged() {
        let exact =
            matrix(&[(0, 0, 2.0), (1, 0, -1.0), (0, 1, -1.0), (1, 1, 1.5), (1, 1, 0.5)]).symmetric(false).unwrap();
        let lower: Vec<(u32, u32, f64)> = exact.lower.iter().map(|e| (e.row, e.column, e.value)).collect();
        assert_eq!((lower, exact.asymmetry), (vec![(0, 0, 2.0), (1, 0, -1.0), (1, 1, 2.0)], 0.0));
        let near = matrix(&[(0, 0, 2.0), (1, 0, -1.0), (0, 1, -1.0 - 1e-12), (1, 1, 2.0)]).symmetric(false).unwrap();
        assert!((near.asymmetry - 5e-13).abs() < 1e-15);
        let skew = matrix(&[(0, 0, 2.0), (1, 0, -1.0), (0, 1, 1.0)]).symmetric(false);
        assert_eq!(skew, Err(SymmetryError::Asymmetric { largest: 1.0 }));
        let one = matrix(&[(0, 0, 2.0), (0, 1, -1.0)]);
        assert_eq!(one.symmetric(false), Err(SymmetryError::OneTriangle));
        assert_eq!(one.symmetric(true).unwrap().lower.len(), 2);
    }
}
