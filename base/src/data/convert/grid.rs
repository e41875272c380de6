//! Common frequency lines of several functions.

use super::ConvertError;

/// Lines whose distance is below this part of their spacing are the same line.
///
/// Headers of text files give start and step in six digits, so that the same line may differ by some 1e-5 of its value.
const SAME_LINE: f64 = 0.01;

/// One function's lines.
#[derive(Debug)]
pub(super) struct GridOf {
    pub(super) name: String,
    pub(super) points: Vec<f64>,
}

/// Refuses lines that do not ascend.
pub(super) fn check(grid: &GridOf) -> Result<(), ConvertError> {
    let bad = (0..grid.points.len())
        .find(|i| !grid.points[*i].is_finite() || (*i > 0 && grid.points[*i] <= grid.points[*i - 1]));
    match bad {
        Some(line) => Err(ConvertError::NotAscending { function: grid.name.clone(), line }),
        None => Ok(()),
    }
}

/// The lines that all functions have, at the values of the first; for each function the index of each line.
pub(super) fn common(grids: &[GridOf]) -> Result<(Vec<f64>, Vec<Vec<usize>>), ConvertError> {
    let Some(first) = grids.first() else { return Ok((Vec::new(), Vec::new())) };
    let mut lines = first.points.clone();
    for grid in &grids[1..] {
        let before = lines;
        lines = matches(&before, &grid.points).into_iter().map(|(i, _)| before[i]).collect();
        if lines.is_empty() {
            return Err(ConvertError::NoCommonLines { first: first.name.clone(), second: grid.name.clone() });
        }
    }
    let indices = grids.iter().map(|g| matches(&lines, &g.points).into_iter().map(|(_, j)| j).collect()).collect();
    Ok((lines, indices))
}

/// Pairs of equal lines of two ascending lists.
fn matches(a: &[f64], b: &[f64]) -> Vec<(usize, usize)> {
    let spacing = |v: &[f64]| {
        let n = v.len();
        if n > 1 { (v[n - 1] - v[0]) / (n - 1) as f64 } else { v.first().copied().unwrap_or(0.0).abs() * 1.0e-3 }
    };
    let tolerance = SAME_LINE * spacing(b).min(spacing(a));
    let (mut i, mut j) = (0, 0);
    let mut found = Vec::with_capacity(a.len().min(b.len()));
    while i < a.len() && j < b.len() {
        let difference = a[i] - b[j];
        if difference.abs() <= tolerance {
            found.push((i, j));
            i += 1;
            j += 1;
        } else if difference < 0.0 {
            i += 1;
        } else {
            j += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(points: Vec<f64>) -> GridOf {
        GridOf { name: "h".to_owned(), points }
    }

    #[test]
    fn common_lines_are_the_intersection_at_the_values_of_the_first() {
        let a = grid((0..10).map(|i| f64::from(i) * 0.5).collect());
        let b = grid((2..20).map(|i| f64::from(i) * 0.5 * (1.0 + 1.0e-5)).collect());
        let (lines, indices) = common(&[a, b]).unwrap();
        assert_eq!(lines, (2..10).map(|i| f64::from(i) * 0.5).collect::<Vec<_>>());
        assert_eq!((indices[0][0], indices[1][0], indices[1].len()), (2, 0, 8));
    }

    #[test]
    fn grids_without_common_lines_are_refused() {
        let a = grid(vec![1.0, 2.0, 3.0]);
        let b = grid(vec![1.3, 2.3, 3.3]);
        assert!(matches!(common(&[a, b]), Err(ConvertError::NoCommonLines { .. })));
        assert!(matches!(check(&grid(vec![0.0, 1.0, 1.0])), Err(ConvertError::NotAscending { line: 2, .. })));
    }
}
