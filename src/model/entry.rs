//! Entries of the matrices of a model: lower triangle, row ≥ column, each per unit of what its matrix is multiplied with.

pub use crate::matrices::Entry;

/// Sorts by place and sums entries of one place, in the order they came.
pub(super) fn merge(list: &mut Vec<Entry>) {
    list.sort_by_key(|e| (e.row, e.column));
    list.dedup_by(|later, kept| {
        let same = (later.row, later.column) == (kept.row, kept.column);
        if same {
            kept.value += later.value;
        }
        same
    });
}
