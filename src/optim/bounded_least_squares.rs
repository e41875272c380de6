//! Linear least squares inside a box, by active sets.

use crate::linalg::{DMatrix, DVector};

/// A multiplier below this share of |b|, which no residual exceeds, is rounding.
const ROUNDING: f64 = 1e-14;
/// Rounds in which the number of wrong variables may fail to fall.
const PATIENCE: usize = 3;

/// The minimiser of a linear model inside a box.
///
/// ```text
/// min  ½ |A d - b|²   subject to   lower <= d <= upper,     A (m × n) of full column rank, lower <= 0 <= upper
/// ```
///
/// Variables are free or fixed on a bound. The free ones solve an unconstrained problem by a QR factorisation of their
/// columns. First all that are wrong change sides at once, free ones outside the box and fixed ones whose multipliers pull inwards: a few
/// factorisations suffice, however many bounds are met. Where that makes no progress one variable changes at a time: the step is cut at the
/// first bound, which fixes its variable, and inside the box the fixed variable whose multiplier pulls inwards the most is freed. Each such round
/// lowers the objective, so the set never repeats; a limit on the rounds guards against rounding.
///
/// # Source
/// All at once: L. F. Portugal, J. J. Júdice, L. N. Vicente, A comparison of block pivoting and interior-point algorithms for linear least
/// squares problems with nonnegative variables, Mathematics of Computation 63, 1994. One at a time: P. B. Stark, R. L. Parker,
/// Bounded-variable least-squares: an algorithm and applications, Computational Statistics 10, 1995; J. Nocedal, S. J. Wright, Numerical
/// Optimization, 2nd ed., 2006, section 16.5.
pub fn bounded_least_squares(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> DVector<f64> {
    let n = a.ncols();
    let scale: Vec<f64> = a.column_iter().map(|c| c.norm()).collect();
    let (mut d, mut free) = match all_at_once(a, b, lower, upper, &scale) {
        Ok(d) => return d,
        Err(nearly) => nearly,
    };
    free_and_cut(a, b, lower, upper, &mut d, &mut free);
    // a variable that was just fixed by a step of length zero must not be freed at once
    let mut barred: Option<usize> = None;
    for _round in 0..10 * n + 10 {
        let residual = b - a * &d;
        let pull = |j: usize| {
            let multiplier = a.column(j).dot(&residual) / scale[j].max(f64::MIN_POSITIVE);
            let outwards = (multiplier > 0.0 && d[j] >= upper[j]) || (multiplier < 0.0 && d[j] <= lower[j]);
            if outwards { 0.0 } else { multiplier.abs() }
        };
        let candidate = (0..n)
            .filter(|j| !free.contains(j) && barred != Some(*j))
            .map(|j| (pull(j), j))
            .max_by(|x, y| x.0.total_cmp(&y.0).then(y.1.cmp(&x.1)));
        match candidate {
            Some((pull, j)) if pull > ROUNDING * b.norm() => free.push(j),
            _ => return d,
        }
        barred = None;

        // solve on the free variables, cutting at bounds, until the solution lies inside
        let hit_at_once = free_and_cut(a, b, lower, upper, &mut d, &mut free);
        if hit_at_once.is_some() {
            barred = hit_at_once;
        }
    }
    d
}

/// Where a variable is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Free,
    Lower,
    Upper,
}

/// The minimiser by exchanges of all that is wrong; a point in the box and its free variables, where they come to no end.
fn all_at_once(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
    scale: &[f64],
) -> Result<DVector<f64>, (DVector<f64>, Vec<usize>)> {
    let n = a.ncols();
    let least = ROUNDING * b.norm();
    let pull = a.tr_mul(b);
    let mut sides: Vec<Side> = (0..n)
        .map(|j| match pull[j] {
            p if p <= 0.0 && lower[j] >= 0.0 => Side::Lower,
            p if p >= 0.0 && upper[j] <= 0.0 => Side::Upper,
            _ => Side::Free,
        })
        .collect();
    let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
    loop {
        let mut d = DVector::from_fn(n, |j, _| match sides[j] {
            Side::Free => 0.0,
            Side::Lower => lower[j],
            Side::Upper => upper[j],
        });
        let free: Vec<usize> = (0..n).filter(|&j| sides[j] == Side::Free).collect();
        if !free.is_empty() {
            let Some(target) = solve_free(a, b, &d, &free) else { return Err((d, free)) };
            for (&j, v) in free.iter().zip(target.iter()) {
                d[j] = *v;
            }
        }
        let residual = b - a * &d;
        let mut wrong: Vec<(usize, Side)> = Vec::new();
        for j in (0..n).filter(|&j| lower[j] < upper[j]) {
            let inwards = |sign: f64| sign * a.column(j).dot(&residual) / scale[j].max(f64::MIN_POSITIVE) > least;
            match sides[j] {
                Side::Free if d[j] < lower[j] => wrong.push((j, Side::Lower)),
                Side::Free if d[j] > upper[j] => wrong.push((j, Side::Upper)),
                Side::Lower if inwards(1.0) => wrong.push((j, Side::Free)),
                Side::Upper if inwards(-1.0) => wrong.push((j, Side::Free)),
                _ => {}
            }
        }
        if wrong.is_empty() {
            return Ok(d);
        }
        if wrong.len() < fewest {
            (fewest, patience) = (wrong.len(), PATIENCE);
        } else if patience > 0 {
            patience -= 1;
        } else {
            let d = DVector::from_fn(n, |j, _| d[j].clamp(lower[j], upper[j]));
            let free = free.into_iter().filter(|&j| lower[j] < d[j] && d[j] < upper[j]).collect();
            return Err((d, free));
        }
        for (j, side) in wrong {
            sides[j] = side;
        }
    }
}

/// Moves the free variables to their least-squares values, fixing each that meets a bound on the way; gives the last one
/// that was fixed by a step of length zero.
fn free_and_cut(
    a: &DMatrix<f64>,
    b: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
    d: &mut DVector<f64>,
    free: &mut Vec<usize>,
) -> Option<usize> {
    let mut barred = None;
    while !free.is_empty() {
        let Some(target) = solve_free(a, b, d, free) else { return barred };
        let mut length = 1.0;
        let mut first_hit = None;
        for (k, &j) in free.iter().enumerate() {
            let room = if target[k] > upper[j] {
                upper[j] - d[j]
            } else if target[k] < lower[j] {
                lower[j] - d[j]
            } else {
                continue;
            };
            let share = room / (target[k] - d[j]);
            if first_hit.is_none() || share < length {
                length = share;
                first_hit = Some(k);
            }
        }
        for (k, &j) in free.iter().enumerate() {
            d[j] = (d[j] + length * (target[k] - d[j])).clamp(lower[j], upper[j]);
        }
        let Some(hit) = first_hit else { break };
        let j = free.remove(hit);
        d[j] = if target[hit] > upper[j] { upper[j] } else { lower[j] };
        if length <= 0.0 {
            barred = Some(j);
        }
    }
    barred
}

/// The free variables' least-squares values, the others kept; nothing if their columns are dependent.
fn solve_free(a: &DMatrix<f64>, b: &DVector<f64>, d: &DVector<f64>, free: &[usize]) -> Option<DVector<f64>> {
    let mut fixed = d.clone();
    for &j in free {
        fixed[j] = 0.0;
    }
    let mut right = b - a * fixed;
    let qr = a.select_columns(free).qr();
    qr.q_tr_mul(&mut right);
    qr.unpack_r().solve_upper_triangular(&right.rows(0, free.len()).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Karush-Kuhn-Tucker conditions: the gradient vanishes where d is free and points outwards where it is not.
    fn assert_optimal(
        a: &DMatrix<f64>,
        b: &DVector<f64>,
        lower: &DVector<f64>,
        upper: &DVector<f64>,
        d: &DVector<f64>,
    ) {
        let gradient = a.tr_mul(&(a * d - b));
        // rounding of a product of two vectors of about 40 numbers of order one
        let zero = 1e-12 * (1.0 + b.norm()) * a.norm();
        for j in 0..d.len() {
            assert!((lower[j]..=upper[j]).contains(&d[j]));
            assert!(d[j] <= lower[j] || gradient[j] <= zero, "{j}: gradient {}", gradient[j]);
            assert!(d[j] >= upper[j] || gradient[j] >= -zero, "{j}: gradient {}", gradient[j]);
        }
    }

    #[test]
    fn random_problems_satisfy_the_optimality_conditions() {
        let noise = |i: usize| ((i as f64 * 12.9898).sin() * 43758.5453).fract();
        for case in 0..200 {
            let n = 1 + case % 20;
            let m = n + case % 25;
            let a = DMatrix::from_fn(m, n, |i, j| noise(1000 * case + i * n + j));
            let b = DVector::from_fn(m, |i, _| 3.0 * noise(777 * case + i));
            let lower = DVector::from_fn(n, |j, _| -noise(31 * case + j).abs() * f64::from(j % 3 != 0));
            let upper = DVector::from_fn(n, |j, _| noise(37 * case + j).abs() * f64::from(j % 4 != 0));
            assert_optimal(&a, &b, &lower, &upper, &bounded_least_squares(&a, &b, &lower, &upper));
        }
    }

    #[test]
    fn an_open_box_gives_the_plain_least_squares_solution() {
        let a = DMatrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
        let b = DVector::from_row_slice(&[3.0, -8.0, 1.0]);
        let wide = DVector::from_element(2, 100.0);
        let d = bounded_least_squares(&a, &b, &-&wide, &wide);
        assert!((d - DVector::from_row_slice(&[3.0, -4.0])).amax() < 1e-14);
    }
}
