//! Optimal assignment of rows to columns, rectangular, for real costs.
//!
//! Shortest augmenting paths with dual prices: every row in turn finds the cheapest way to a free column, other rows
//! moving aside on the way. O(rows² columns), exact, deterministic.
//!
//! Sources: R. Jonker, A. Volgenant, A shortest augmenting path algorithm for dense and sparse linear assignment
//! problems, Computing 38 (1987) 325-340; D. F. Crouse, On implementing 2D rectangular assignment algorithms, IEEE
//! Transactions on Aerospace and Electronic Systems 52 (2016) 1679-1696.

use crate::linalg::DMatrix;

/// The assignment of min(rows, columns) pairs with the least total cost.
///
/// ```text
/// min Σ cost[i, a(i)]    over all one-to-one maps a of the shorter side into the longer
/// ```
///
/// * `cost` - finite numbers of any sign, (rows x columns)
///
/// Returns the column of every row; `None` for the rows left over when there are more rows than columns. Among equal
/// optima the one found first is taken, rows in order, lower columns first: the same input gives the same answer.
pub(super) fn assign(cost: &DMatrix<f64>) -> Vec<Option<usize>> {
    let (n_rows, n_cols) = cost.shape();
    let mut assigner = Assigner::default();
    if n_rows > n_cols {
        let mut columns = vec![None; n_rows];
        for (column, row) in assigner.assign(n_cols, n_rows, |i, j| cost[(j, i)]).iter().enumerate() {
            columns[*row] = Some(column);
        }
        return columns;
    }
    assigner.assign(n_rows, n_cols, |i, j| cost[(i, j)]).iter().copied().map(Some).collect()
}

/// The memory of an assignment, for many of them.
#[derive(Debug, Default)]
pub(super) struct Assigner {
    row_price: Vec<f64>,
    col_price: Vec<f64>,
    row_of: Vec<Option<usize>>,
    distance: Vec<f64>,
    previous: Vec<Option<usize>>,
    done: Vec<bool>,
    columns: Vec<usize>,
}

/// Overwrites a buffer.
fn refill<T: Clone>(buffer: &mut Vec<T>, n: usize, value: T) {
    buffer.clear();
    buffer.resize(n, value);
}

impl Assigner {
    /// The column of every row; rows must not outnumber columns. Allocates nothing once it has met the sizes.
    pub(super) fn assign(&mut self, n_rows: usize, n_cols: usize, cost: impl Fn(usize, usize) -> f64) -> &[usize] {
        let Self { row_price, col_price, row_of, distance, previous, done, columns } = self;
        refill(row_price, n_rows, 0.0);
        refill(col_price, n_cols, 0.0);
        refill(row_of, n_cols, None);
        for start in 0..n_rows {
            // Dijkstra over reduced costs from row `start` to the nearest free column.
            refill(distance, n_cols, f64::INFINITY);
            refill(previous, n_cols, None); // the column before, on the path; None: `start` itself
            refill(done, n_cols, false);
            let (mut row, mut from, mut travelled) = (start, None, 0.0);
            let sink = loop {
                let mut nearest: Option<usize> = None;
                for j in 0..n_cols {
                    if done[j] {
                        continue;
                    }
                    let through = travelled + cost(row, j) - row_price[row] - col_price[j];
                    if through < distance[j] {
                        (distance[j], previous[j]) = (through, from);
                    }
                    if nearest.is_none_or(|best| distance[j] < distance[best]) {
                        nearest = Some(j);
                    }
                }
                let Some(j) = nearest else { unreachable!("a free column exists: rows do not outnumber columns") };
                (done[j], travelled, from) = (true, distance[j], Some(j));
                match row_of[j] {
                    Some(owner) => row = owner,
                    None => break j,
                }
            };
            row_price[start] += travelled;
            for j in (0..n_cols).filter(|&j| done[j] && j != sink) {
                col_price[j] += distance[j] - travelled;
                if let Some(owner) = row_of[j] {
                    row_price[owner] += travelled - distance[j];
                }
            }
            // Everyone on the path moves one column on.
            let mut j = sink;
            while let Some(before) = previous[j] {
                row_of[j] = row_of[before];
                j = before;
            }
            row_of[j] = Some(start);
        }
        refill(columns, n_rows, 0);
        for (j, row) in row_of.iter().enumerate() {
            if let Some(row) = *row {
                columns[row] = j;
            }
        }
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn total(cost: &DMatrix<f64>, columns: &[Option<usize>]) -> f64 {
        columns.iter().enumerate().filter_map(|(i, j)| j.map(|j| cost[(i, j)])).sum()
    }

    /// The least cost by trying everything.
    fn exhaustive(cost: &DMatrix<f64>, row: usize, used: &mut Vec<bool>) -> f64 {
        if row == cost.nrows() {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for j in 0..cost.ncols() {
            if !used[j] {
                used[j] = true;
                best = best.min(cost[(row, j)] + exhaustive(cost, row + 1, used));
                used[j] = false;
            }
        }
        best
    }

    #[test]
    fn a_greedy_choice_is_undone() {
        // Greedy takes 1 and is left with 100: total 101. The optimum is 2 + 3.
        let cost = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 100.0]);
        assert_eq!(assign(&cost), [Some(1), Some(0)]);
    }

    #[test]
    fn empty_sides_give_no_pairs() {
        assert!(assign(&DMatrix::zeros(0, 3)).is_empty());
        assert_eq!(assign(&DMatrix::zeros(2, 0)), [None, None]);
    }

    proptest! {
        #[test]
        fn the_total_is_the_exhaustive_minimum(
            rows in 1usize..6, cols in 1usize..6, values in prop::collection::vec(-3.0..5.0f64, 36)
        ) {
            let cost = DMatrix::from_fn(rows, cols, |i, j| values[6 * i + j]);
            let columns = assign(&cost);
            let wide = if rows > cols { cost.transpose() } else { cost.clone() };
            let best = exhaustive(&wide, 0, &mut vec![false; wide.ncols()]);
            prop_assert_eq!(columns.iter().flatten().count(), rows.min(cols));
            prop_assert!((total(&cost, &columns) - best).abs() < 1e-12);
        }
    }
}
