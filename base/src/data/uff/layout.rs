//! How the values of dataset 58 are laid out.

use super::Precision;

/// Columns of record 7.
pub(super) const RECORD_7: [usize; 6] = [10, 10, 10, 13, 13, 13];

/// What the numbers of record 12 are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    pub(super) precision: Precision,
    pub(super) is_complex: bool,
    pub(super) is_even: bool,
}

impl Layout {
    /// From fields 1 and 3 of record 7.
    pub(super) fn of(ordinate_type: i64, spacing: i64) -> Option<Self> {
        let (precision, is_complex) = match ordinate_type {
            2 => (Precision::Single, false),
            4 => (Precision::Double, false),
            5 => (Precision::Single, true),
            6 => (Precision::Double, true),
            _ => return None,
        };
        Some(Self { precision, is_complex, is_even: spacing != 0 })
    }

    pub(super) fn ordinate_type(self) -> i64 {
        match (self.precision, self.is_complex) {
            (Precision::Single, false) => 2,
            (Precision::Double, false) => 4,
            (Precision::Single, true) => 5,
            (Precision::Double, true) => 6,
        }
    }

    pub(super) fn ordinates_per_point(self) -> usize {
        1 + usize::from(self.is_complex)
    }

    /// Numbers per point.
    pub(super) fn per_point(self) -> usize {
        self.ordinates_per_point() + usize::from(!self.is_even)
    }

    /// Possible lengths of a point in binary; an uneven abscissa beside double ordinates is double by custom, and
    /// single by the letter of the standard.
    pub(super) fn bytes_per_point(self) -> Vec<usize> {
        match (self.precision, self.is_even) {
            (Precision::Single, _) => vec![4 * self.per_point()],
            (Precision::Double, true) => vec![8 * self.per_point()],
            (Precision::Double, false) => vec![8 * self.per_point(), 4 + 8 * self.ordinates_per_point()],
        }
    }

    /// Columns of the text form, repeated along the record.
    pub(super) fn widths(self) -> &'static [usize] {
        match (self.precision, self.is_even, self.is_complex) {
            (Precision::Single, ..) => &[13; 6],
            (Precision::Double, true, _) => &[20; 4],
            (Precision::Double, false, false) => &[13, 20, 13, 20],
            (Precision::Double, false, true) => &[13, 20, 20],
        }
    }
}
