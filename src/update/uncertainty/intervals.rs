//! Intervals of single parameters inside the box: of the quadratic model, and of the cost itself.

use super::RISE_90;
use crate::linalg::{DMatrix, DVector};
use crate::objective::Objective;
use crate::optim::bounded_least_squares;

/// Most evaluations and linearisations of one profiled end.
pub(super) const MOST_PER_END: u64 = 60;

/// One end of an interval.
#[derive(Debug, Clone)]
pub(super) struct End {
    /// The parameter there.
    pub(super) x: f64,
    /// Whether the bound ends it and not the data.
    pub(super) is_bound: bool,
    /// All parameters there: the others at their best.
    pub(super) point: DVector<f64>,
    /// Rise of the cost there, by the model that found it.
    pub(super) rise: f64,
}

/// The quadratic model of the cost around a point, inside the unit box.
#[derive(Debug)]
pub(super) struct Quadratic {
    /// J, compressed to a triangle, over a slight damping that gives it full rank.
    a: DMatrix<f64>,
    /// -r, compressed.
    b: DVector<f64>,
    x: DVector<f64>,
    /// Where the model is lowest in the box, and how much lower than at x.
    best: DVector<f64>,
    promise: f64,
    /// (JᵀJ)⁻¹ J-wise solver of the plain case: columns of the covariance of parameters inside the box, if regular.
    inside: Option<(Vec<usize>, DMatrix<f64>)>,
}

/// J and -r with the same |J d + r|² up to a constant, n rows, over ε I.
fn compressed(jacobian: &DMatrix<f64>, residuals: &DVector<f64>) -> (DMatrix<f64>, DVector<f64>) {
    let n = jacobian.ncols();
    let (mut a, mut b) = if jacobian.nrows() > n {
        let qr = jacobian.clone().qr();
        let mut right = -residuals;
        qr.q_tr_mul(&mut right);
        (qr.unpack_r(), right.rows(0, n).into_owned())
    } else {
        (jacobian.clone(), -residuals)
    };
    let rows = a.nrows();
    let size = a.column_iter().map(|c| c.norm()).fold(0.0, f64::max);
    // Far too weak to be seen in an interval: crossing the box costs at most 5e-5.
    let epsilon = (1e-7 * size).clamp(1e-12, 1e-2);
    a = a.resize_vertically(rows + n, 0.0);
    b = b.resize_vertically(rows + n, 0.0);
    for j in 0..n {
        a[(rows + j, j)] = epsilon;
    }
    (a, b)
}

impl Quadratic {
    pub(super) fn new(jacobian: &DMatrix<f64>, residuals: &DVector<f64>, x: &DVector<f64>) -> Self {
        let n = x.len();
        let (a, b) = compressed(jacobian, residuals);
        let best = bounded_least_squares(&a, &b, &-x, &x.map(|v| 1.0 - v));
        let promise = 0.5 * (b.norm_squared() - (&a * &best - &b).norm_squared());
        let inner: Vec<usize> = (0..n).filter(|&j| x[j] > 1e-6 && x[j] < 1.0 - 1e-6).collect();
        let columns = a.select_columns(&inner);
        let inverse = columns.tr_mul(&columns).cholesky().map(|c| c.inverse());
        let inside = inverse.filter(|c| c.iter().all(|v| v.is_finite())).map(|c| (inner, c));
        Self { a, b, x: x.clone(), best, promise: promise.max(0.0), inside }
    }

    /// How much lower than at x the model is at its lowest point in the box.
    pub(super) fn promise(&self) -> f64 {
        self.promise
    }

    /// The rise over the lowest point of the model, with x_j fixed and the others at their best in the box.
    fn at(&self, j: usize, x_j: f64) -> (f64, DVector<f64>) {
        let step = x_j - self.x[j];
        let b = &self.b - self.a.column(j) * step;
        let (mut lower, mut upper) = (-&self.x, self.x.map(|v| 1.0 - v));
        (lower[j], upper[j]) = (0.0, 0.0);
        let mut d = bounded_least_squares(&self.a, &b, &lower, &upper);
        d[j] = step;
        (self.rise(&d), d)
    }

    fn rise(&self, d: &DVector<f64>) -> f64 {
        0.5 * ((&self.a * d - &self.b).norm_squared() - self.b.norm_squared()) + self.promise
    }

    /// The ends of all intervals.
    pub(super) fn ends(&self) -> Vec<[End; 2]> {
        (0..self.x.len()).map(|j| [self.end(j, 0), self.end(j, 1)]).collect()
    }

    /// The plain case: the other parameters that are inside the box stay inside, those on bounds stay held.
    fn plain(&self, j: usize, side: usize) -> Option<End> {
        let (inner, covariance) = self.inside.as_ref()?;
        if self.promise > 1e-3 * RISE_90 {
            return None;
        }
        let k = inner.iter().position(|&i| i == j)?;
        let reach = (2.0 * RISE_90 * covariance[(k, k)]).sqrt() * if side == 0 { -1.0 } else { 1.0 };
        let mut d = DVector::zeros(self.x.len());
        for (i, &parameter) in inner.iter().enumerate() {
            d[parameter] = reach * covariance[(i, k)] / covariance[(k, k)];
        }
        let point = &self.x + &d;
        if point.iter().any(|v| !(0.0..=1.0).contains(v)) {
            return None;
        }
        let gradient = self.a.tr_mul(&(&self.a * &d - &self.b));
        let stays = |i: usize| {
            inner.contains(&i) || (self.x[i] < 0.5 && gradient[i] >= 0.0) || (self.x[i] > 0.5 && gradient[i] <= 0.0)
        };
        (0..self.x.len()).all(stays).then(|| End { x: point[j], is_bound: false, rise: self.rise(&d), point })
    }

    fn end(&self, j: usize, side: usize) -> End {
        if let Some(end) = self.plain(j, side) {
            return end;
        }
        let bound = side as f64;
        let end_at = |x_j: f64, is_bound: bool, (rise, d): (f64, DVector<f64>)| {
            let point = (&self.x + d).map(|v| v.clamp(0.0, 1.0));
            End { x: x_j, is_bound, point, rise }
        };
        let at_bound = self.at(j, bound);
        if at_bound.0 <= RISE_90 {
            return end_at(bound, true, at_bound);
        }
        // √rise is convex and nearly linear in x_j: false position with Illinois halving.
        let f = |rise: f64| rise.max(0.0).sqrt() - RISE_90.sqrt();
        let (mut low, mut f_low) = (self.x[j] + self.best[j], f(0.0));
        let (mut high, mut f_high) = (bound, f(at_bound.0));
        let mut last = (high, at_bound);
        let mut side_kept = 0;
        for _ in 0..40 {
            let x_j = high - f_high * (high - low) / (f_high - f_low);
            let found = self.at(j, x_j);
            let value = f(found.0);
            last = (x_j, found);
            if value.abs() < 1e-5 {
                break;
            }
            if value > 0.0 {
                (high, f_high) = (x_j, value);
                f_low *= if side_kept == 1 { 0.5 } else { 1.0 };
                side_kept = 1;
            } else {
                (low, f_low) = (x_j, value);
                f_high *= if side_kept == -1 { 0.5 } else { 1.0 };
                side_kept = -1;
            }
        }
        end_at(last.0, false, last.1)
    }
}

/// An end on the profile of the cost itself, and what it took; the error is a lower cost that was met, if any.
///
/// √(profile - cost*) is followed by secants from the end of the quadratic model, each profile point by Gauss-Newton
/// steps in the other parameters.
pub(super) fn profile(
    objective: &dyn Objective,
    x: &DVector<f64>,
    cost: f64,
    j: usize,
    side: usize,
    start: &End,
) -> (Result<End, Option<f64>>, u64) {
    let mut spent = 0;
    let bound = side as f64;
    let goal = RISE_90.sqrt();
    let (mut inner, mut f_inner) = (x[j], -goal);
    let mut outer: Option<(f64, f64)> = None;
    let mut from = start.point.clone();
    let mut x_j = start.x;
    let mut lowest: Option<f64> = None;
    for _ in 0..10 {
        from[j] = x_j;
        let Some((found, point)) = refit(objective, &from, j, MOST_PER_END.saturating_sub(spent), &mut spent) else {
            break;
        };
        let rise = found - cost;
        if rise < -0.05 * RISE_90 {
            lowest = Some(lowest.map_or(found, |l: f64| l.min(found)));
            break;
        }
        let f = rise.max(0.0).sqrt() - goal;
        let is_bound = x_j == bound;
        if f.abs() < 0.02 * goal || (is_bound && f < 0.0) {
            let ends_at_bound = is_bound && f < 0.0;
            return (Ok(End { x: x_j, is_bound: ends_at_bound, point, rise }), spent);
        }
        if f < 0.0 {
            (inner, f_inner) = (x_j, f);
        } else {
            outer = Some((x_j, f));
        }
        from = point;
        x_j = match outer {
            // Inside a bracket, a secant kept off its ends.
            Some((outer, f_outer)) => {
                let share = (-f_inner / (f_outer - f_inner)).clamp(0.1, 0.9);
                inner + share * (outer - inner)
            }
            // No bracket yet: outwards by a secant through the optimum, at most three times as far.
            None => {
                let slope = (f + goal) / (x_j - x[j]).abs();
                let reach = (goal / slope.max(1e-12)).min(3.0 * (x_j - x[j]).abs());
                (x[j] + reach * if side == 0 { -1.0 } else { 1.0 }).clamp(0.0, 1.0)
            }
        };
        if spent >= MOST_PER_END {
            break;
        }
    }
    (Err(lowest), spent)
}

/// The lowest cost with x_j fixed, by Gauss-Newton steps in the box, and the point; `None` where it cannot be evaluated.
fn refit(
    objective: &dyn Objective,
    start: &DVector<f64>,
    j: usize,
    allowance: u64,
    spent: &mut u64,
) -> Option<(f64, DVector<f64>)> {
    let first = *spent;
    let mut x = start.clone();
    let mut cost = objective.cost(&x).ok()?;
    *spent += 1;
    for _ in 0..8 {
        if *spent - first >= allowance {
            break;
        }
        let at = objective.linearize(&x).ok()?;
        *spent += 1;
        let (a, b) = compressed(&at.jacobian, &at.residuals);
        let (mut lower, mut upper) = (-&x, x.map(|v| 1.0 - v));
        (lower[j], upper[j]) = (0.0, 0.0);
        let d = bounded_least_squares(&a, &b, &lower, &upper);
        let promise = 0.5 * (b.norm_squared() - (&a * &d - &b).norm_squared());
        if promise < 2e-3 * RISE_90 {
            break;
        }
        let mut length = 1.0;
        let mut better = None;
        for _ in 0..4 {
            let trial = (&x + &d * length).map(|v| v.clamp(0.0, 1.0));
            *spent += 1;
            if let Some(c) = objective.cost(&trial).ok().filter(|c| *c < cost) {
                better = Some((c, trial));
                break;
            }
            length *= 0.4;
        }
        let Some((c, trial)) = better else { break };
        (cost, x) = (c, trial);
    }
    Some((cost, x))
}
