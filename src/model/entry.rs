//! Entries of sparse matrices on the rows of a model.

/// One entry of a basis matrix: lower triangle, row ≥ column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Row.
    pub row: usize,
    /// Column.
    pub column: usize,
    /// Its value per unit of the parameter (or, in the constant part, its value).
    pub value: f64,
}

/// Sorts by place and sums entries of one place, in the order they came.
pub(super) fn merge(list: &mut Vec<Entry>) {
    list.sort_by_key(|e| (e.row, e.column));
    list.dedup_by(|later, kept| {
        let same = later.row == kept.row && later.column == kept.column;
        if same {
            kept.value += later.value;
        }
        same
    });
}
