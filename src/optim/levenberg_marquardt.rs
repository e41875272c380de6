//! Damped Gauss-Newton steps inside the box.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bounded_least_squares::bounded_least_squares;
use super::{About, OptimError, Optimizer, Optimum, Run, Stop, Termination};
use crate::linalg::{DMatrix, DVector};
use crate::objective::{EvalError, Linearization, Walls};

/// Projected Levenberg-Marquardt: a local method with derivatives, for costs that are sums of squares.
///
/// ```text
/// optimizer: {levenberg-marquardt: {steps: 200}}
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LevenbergMarquardt {
    /// Accepted steps, at most.
    pub steps: usize,
    /// Ends the search when a step promises, and brings, a smaller relative reduction of the cost.
    pub tolerance: f64,
    /// First damping, relative to the squared column norms of the Jacobian.
    pub damping: f64,
    /// Ends the search also when a step promises a smaller reduction of the cost than this; the cost is half a squared sum in
    /// standard deviations.
    pub gain: f64,
}

impl Default for LevenbergMarquardt {
    fn default() -> Self {
        Self { steps: 500, tolerance: 1e-12, damping: 1e-3, gain: 0.0 }
    }
}

/// What `retune explain levenberg-marquardt` tells.
pub(super) const ABOUT: About = About {
    name: "levenberg-marquardt",
    summary: "local search with derivatives: damped Gauss-Newton steps with an active set for the bounds; the fastest",
    theory: "At x the residuals are linear, r + J d, for a small step d. Each step solves min |r + J d|² + λ |D d|² inside the \
box exactly: a bounded linear least-squares problem, by QR factorisations and an active set, never by normal equations. D \
holds the largest column norms of J met so far, and λ > 0 makes the problem solvable when parameters cannot be told apart. \
λ falls when the cost falls as the model says, and grows when not. Steps end on bounds and leave them again when the \
gradient says so; reflecting at bounds, by contrast, stalls at points that are not an optimum. The accepted cost is the \
objective's own: where that is not ½ rᵀr the residuals only propose directions, the cost still never rises, and a \
refinement without derivatives should follow. Residuals that stand for constraints t <= 0 (targets for mass properties) are \
no squares in the step but linearised constraints t + ∂t d <= 0, as in sequential quadratic programming, so that the path \
runs along a constraint instead of bouncing off it.",
    sources: &[
        "J. J. Moré, The Levenberg-Marquardt algorithm: implementation and theory, Lecture Notes in Mathematics 630, 1978",
        "J. Nocedal, S. J. Wright, Numerical Optimization, 2nd ed., Springer 2006, chapters 10 and 16",
        "C. Kanzow, N. Yamashita, M. Fukushima, Levenberg-Marquardt methods with strong local convergence properties for solving nonlinear equations with convex constraints, J. Computational and Applied Mathematics 172, 2004",
        "H. B. Nielsen, Damping parameter in Marquardt's method, Technical University of Denmark, IMM-REP-1999-05, 1999",
    ],
};

/// A cost below this is nothing (sums of squares in units of standard deviations).
const NO_COST: f64 = 1e-28;
/// The smallest ratio of achieved to promised reduction that a step needs.
const WORTHWHILE: f64 = 1e-4;
/// Below this damping, parameters that cannot be told apart would be moved by rounding.
const SMALLEST_DAMPING: f64 = 1e-12;
/// Above this damping a step is rounding.
const LARGEST_DAMPING: f64 = 1e16;
/// Where a start that cannot be evaluated is moved, as shares of the way to the middle of the box.
const TOWARDS_MIDDLE: [f64; 5] = [0.0, 0.01, 0.1, 0.3, 1.0];
/// A column is scaled at least as one of this relative norm, so that a parameter without influence stays put.
const SMALLEST_COLUMN: f64 = 1e-10;
/// Cosine between the residual and the model's reachable directions at which nothing is left to gain.
const ORTHOGONAL: f64 = 1e-12;

impl Optimizer for LevenbergMarquardt {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        self.validate()?;
        let start = run.clip(start)?;
        run.conclude(self.name(), |run| self.search(start, run))
    }
}

impl LevenbergMarquardt {
    fn validate(&self) -> Result<(), OptimError> {
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(OptimError::setting(ABOUT.name, "tolerance", self.tolerance, "at least 0 and below 1"));
        }
        if !(self.damping > 0.0 && self.damping <= 1e6) {
            return Err(OptimError::setting(ABOUT.name, "damping", self.damping, "above 0 and at most 1e6"));
        }
        if self.gain.is_nan() || self.gain < 0.0 {
            return Err(OptimError::setting(ABOUT.name, "gain", self.gain, "at least 0"));
        }
        Ok(())
    }

    fn search(&self, start: DVector<f64>, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let walls = run.walls();
        let (mut x, mut cost, mut model) = Self::begin(start, &walls, run)?;
        let mut scale = DVector::zeros(x.len());
        let (mut damping, mut growth) = (self.damping, 2.0);
        let mut trial = x.clone();

        for _step in 0..self.steps {
            if model.gradient_vanishes(&x) {
                return Ok(Termination::GradientVanishes);
            }
            model.enlarge(&mut scale);
            let next = loop {
                let step = model.step(&x, &scale, damping);
                for j in 0..x.len() {
                    trial[j] = (x[j] + step[j]).clamp(0.0, 1.0);
                }
                let promised = model.relative_reduction(&step);
                if promised <= f64::EPSILON || promised * cost < self.gain || trial == x {
                    return Ok(Termination::ReductionVanishes);
                }
                let trial_cost = run.cost(&trial)?;
                // relative reductions, so that a cost other than ½ rᵀr can be compared with the model of ½ rᵀr
                let achieved = if cost.is_finite() { (cost - trial_cost) / cost.abs().max(NO_COST) } else { 1.0 };
                if trial_cost < cost && achieved >= WORTHWHILE * promised {
                    if promised.max(achieved) <= self.tolerance || trial_cost <= NO_COST {
                        return Ok(Termination::ReductionVanishes);
                    }
                    // A point without derivatives is not a place to go on from: a shorter step may reach another.
                    if let Ok(next) = run.linearize(&trial)?.and_then(|l| Model::new(l, &walls)) {
                        let gain = achieved / promised;
                        damping *= (1.0 - (2.0 * gain - 1.0).powi(3)).clamp(1.0 / 9.0, 2.0);
                        damping = damping.max(SMALLEST_DAMPING);
                        growth = 2.0;
                        cost = trial_cost;
                        break next;
                    }
                }
                if promised <= self.tolerance {
                    return Ok(Termination::ReductionVanishes);
                }
                damping *= growth;
                growth *= 2.0;
                if damping > LARGEST_DAMPING {
                    return Ok(Termination::Stalled);
                }
            };
            x.copy_from(&trial);
            model = next;
        }
        Ok(Termination::PlanDone)
    }

    /// The start, or the nearest point towards the middle of the box that can be evaluated.
    #[expect(clippy::needless_pass_by_value, reason = "the start is given away")]
    fn begin(start: DVector<f64>, walls: &Walls, run: &mut Run<'_>) -> Result<(DVector<f64>, f64, Model), Stop> {
        let mut failure = None;
        for share in TOWARDS_MIDDLE {
            let x = start.map(|v| v + share * (0.5 - v));
            let cost = run.cost(&x)?;
            match run.linearize(&x)?.and_then(|l| Model::new(l, walls)) {
                Ok(model) => return Ok((x, cost, model)),
                Err(source) => failure = failure.or(Some(source)),
            }
        }
        let source = failure.unwrap_or(EvalError::NotFinite { name: "residuals or Jacobian".into() });
        Err(OptimError::Linearization { method: ABOUT.name, source }.into())
    }
}

/// The model of the cost at one point: linear residuals, reduced to n rows by a QR factorisation, and linear walls.
///
/// ```text
/// ½ |r + J d|² + Σ ψ(t + g d) = ½ |R d + Qᵀ r|² + Σ ψ(t + g d) + const
/// ```
struct Model {
    /// R, (min(m, n) × n).
    r: DMatrix<f64>,
    /// Qᵀ r, (min(m, n)).
    qtr: DVector<f64>,
    residual_norm: f64,
    columns: DVector<f64>,
    walls: Vec<Wall>,
}

/// A linearised constraint t + g d <= 0, and the slope of its share of the cost; none where that is ½ ln(1 + eᵗ)².
struct Wall {
    t: f64,
    g: DVector<f64>,
    slope: Option<f64>,
}

/// A constraint that the cost holds with a slope is met within this t by a step.
const EDGE: f64 = 1e-6;
/// Newton steps on the convex model of one step.
const NEWTON: usize = 25;

impl Model {
    fn new(Linearization { residuals, jacobian }: Linearization, walls: &Walls) -> Result<Self, EvalError> {
        if residuals.is_empty() {
            return Err(EvalError::Unsolvable { reason: "the objective has no residuals".into() });
        }
        if !residuals.iter().chain(jacobian.iter()).all(|v| v.is_finite()) {
            return Err(EvalError::NotFinite { name: "residuals or Jacobian".into() });
        }
        let linear = |&(row, slope): &(usize, Option<f64>)| {
            let r = residuals[row];
            Walls::excess(r).map(|t| Wall { t, g: jacobian.row(row).transpose() * Walls::stretch(r), slope })
        };
        let linearised = walls.rows().iter().filter_map(linear).filter(|w| w.g.iter().all(|v| v.is_finite())).collect();
        let rows: Vec<usize> = walls.rows().iter().map(|w| w.0).collect();
        let (mut residuals, jacobian) = if rows.is_empty() {
            (residuals, jacobian)
        } else {
            (residuals.remove_rows_at(&rows), jacobian.remove_rows_at(&rows))
        };
        let columns = DVector::from_iterator(jacobian.ncols(), jacobian.column_iter().map(|c| c.norm()));
        let rows = jacobian.nrows().min(jacobian.ncols());
        let residual_norm = residuals.norm();
        let qr = jacobian.qr();
        qr.q_tr_mul(&mut residuals);
        let qtr = residuals.rows(0, rows).into_owned();
        Ok(Self { r: qr.unpack_r(), qtr, residual_norm, columns, walls: linearised })
    }

    /// Whether no direction inside the box is noticeably correlated with the residuals.
    fn gradient_vanishes(&self, x: &DVector<f64>) -> bool {
        // Beside a wall the gradient means nothing: there a step tells.
        if self.walls.iter().any(|w| w.t > -30.0) {
            return false;
        }
        let gradient = self.r.tr_mul(&self.qtr);
        (0..x.len()).all(|j| {
            let open = (gradient[j] > 0.0 && x[j] > 0.0) || (gradient[j] < 0.0 && x[j] < 1.0);
            !open || gradient[j].abs() <= ORTHOGONAL * self.columns[j] * self.residual_norm
        })
    }

    /// D: the largest column norms so far, none negligible beside the others.
    fn enlarge(&self, scale: &mut DVector<f64>) {
        let smallest = (SMALLEST_COLUMN * self.columns.max()).max(f64::MIN_POSITIVE);
        for j in 0..scale.len() {
            scale[j] = scale[j].max(self.columns[j]).max(smallest);
        }
    }

    /// min ½ |R d + Qᵀr|² + ½ λ |D d|² + Σ ψ(t + g d) with x + d in the unit box.
    ///
    /// ψ is convex: Newton's method, each step a bounded least-squares problem with one row per wall that is felt.
    fn step(&self, x: &DVector<f64>, scale: &DVector<f64>, damping: f64) -> DVector<f64> {
        let (rows, n) = self.r.shape();
        let mut a = DMatrix::zeros(rows + n + self.walls.len(), n);
        a.rows_mut(0, rows).copy_from(&self.r);
        let mut b = DVector::zeros(a.nrows());
        b.rows_mut(0, rows).copy_from(&-&self.qtr);
        for j in 0..n {
            a[(rows + j, j)] = damping.sqrt() * scale[j];
        }
        let (lower, upper) = (-x, x.map(|v| 1.0 - v));
        if self.walls.is_empty() {
            return bounded_least_squares(&a, &b, &lower, &upper);
        }
        let value = |d: &DVector<f64>| {
            let damped: f64 = (0..n).map(|j| (scale[j] * d[j]).powi(2)).sum();
            let walls: f64 = self.walls.iter().map(|w| w.barrier(w.t + w.g.dot(d)).0).sum();
            0.5 * (&self.r * d + &self.qtr).norm_squared() + 0.5 * damping * damped + walls
        };
        let mut d = DVector::zeros(n);
        let mut best = (value(&d), d.clone());
        for _ in 0..NEWTON {
            for (k, wall) in self.walls.iter().enumerate() {
                let along = wall.g.dot(&d);
                let (_, first, second) = wall.barrier(wall.t + along);
                let weight = second.sqrt();
                let row = rows + n + k;
                a.set_row(row, &(wall.g.transpose() * weight));
                b[row] = if weight > 0.0 { weight * along - first / weight } else { 0.0 };
            }
            let next = bounded_least_squares(&a, &b, &lower, &upper);
            let change = (&next - &d).amax();
            d = next;
            let found = value(&d);
            if found < best.0 {
                best = (found, d.clone());
            }
            if change <= 1e-12 {
                break;
            }
        }
        best.1
    }

    /// The reduction of the cost that the step promises, relative to the cost.
    fn relative_reduction(&self, step: &DVector<f64>) -> f64 {
        let change = &self.r * step;
        let mut reduction = -change.dot(&self.qtr) - 0.5 * change.norm_squared();
        let mut cost = 0.5 * self.residual_norm.powi(2);
        for wall in &self.walls {
            let before = wall.penalty(wall.t);
            reduction += before - wall.penalty(wall.t + wall.g.dot(step));
            cost += before;
        }
        reduction / cost.max(f64::MIN_POSITIVE)
    }
}

impl Wall {
    /// What it adds to the model that a step minimises, with its first and second derivative by t.
    fn barrier(&self, t: f64) -> (f64, f64, f64) {
        match self.slope {
            // ½ κ max(0, t)²: a multiplier up to the slope is balanced within the edge.
            Some(slope) => {
                let (stiffness, beyond) = (slope / EDGE, t.max(0.0));
                let second = if t > 0.0 { stiffness } else { 0.0 };
                (0.5 * stiffness * beyond * beyond, stiffness * beyond, second)
            }
            // ½ s², s = ln(1 + eᵗ)
            None => {
                let s = t.max(0.0) + (-t.abs()).exp().ln_1p();
                let slope = if t >= 0.0 { 1.0 / (1.0 + (-t).exp()) } else { t.exp() / (1.0 + t.exp()) };
                (0.5 * s * s, s * slope, slope * slope + s * slope * (1.0 - slope))
            }
        }
    }

    /// What it adds to the cost.
    fn penalty(&self, t: f64) -> f64 {
        self.slope.map_or_else(|| self.barrier(t).0, |slope| slope * t.max(0.0))
    }
}
