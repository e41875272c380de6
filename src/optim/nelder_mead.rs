//! The simplex method of Nelder and Mead, inside bounds, with restarts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{About, OptimError, Optimizer, Optimum, Run, Stop, Termination};
use crate::linalg::DVector;

/// Nelder-Mead: a local refiner without derivatives.
///
/// ```text
/// optimizer: {nelder-mead: {size: 0.02}}
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NelderMead {
    /// Edge of the first simplex as a share of each parameter's range, in (0, 1].
    pub size: f64,
    /// Relative reduction of the cost that still counts; the search ends when restarts bring less.
    pub tolerance: f64,
    /// New simplices after the first, at most.
    pub restarts: usize,
}

impl Default for NelderMead {
    fn default() -> Self {
        Self { size: 0.05, tolerance: 1e-10, restarts: 200 }
    }
}

/// What `retune explain nelder-mead` tells.
pub(super) const ABOUT: About = About {
    name: "nelder-mead",
    summary: "local refinement by a simplex, without derivatives; tolerates kinks such as norms and absolute values",
    theory: "A simplex of n + 1 points moves its worst point through the centroid of the others: reflected, expanded, or \
contracted, with the coefficients of Gao and Han that keep the method alive in many dimensions; if nothing helps, the \
simplex shrinks to its best point. Points are projected onto the bounds, so the simplex may flatten onto active bounds. \
A flattened or stalled simplex is replaced by a fresh one around the best point, of a size that follows the recent \
progress; two fresh simplices of different sizes that gain nothing end the search. It needs hundreds of evaluations a \
dimension, one after another.",
    sources: &[
        "J. A. Nelder, R. Mead, A simplex method for function minimization, Computer Journal 7, 1965",
        "F. Gao, L. Han, Implementing the Nelder-Mead simplex algorithm with adaptive parameters, Computational Optimization and Applications 51, 2012",
        "C. T. Kelley, Detection and remediation of stagnation in the Nelder-Mead algorithm using a sufficient decrease condition, SIAM J. Optimization 10, 1999",
    ],
};

/// A cost below this is nothing (sums of squares in units of standard deviations).
const NO_COST: f64 = 1e-20;
/// A simplex this small, relative to the parameters' ranges, has points that differ by rounding only.
const ROUNDING: f64 = 1e-14;
/// Fresh simplices are at least this large, so that they can leave a kink.
const SMALLEST: f64 = 1e-7;
/// Moves a vertex without progress of the best after which a simplex counts as degenerate.
const PATIENCE: usize = 12;

impl Optimizer for NelderMead {
    fn name(&self) -> &'static str {
        ABOUT.name
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        self.validate()?;
        let start = run.clip(start)?;
        run.conclude(self.name(), |run| self.search(start, run))
    }
}

impl NelderMead {
    fn validate(&self) -> Result<(), OptimError> {
        let setting = |setting, value: f64, expected: &str| OptimError::Setting {
            method: ABOUT.name,
            setting,
            value: value.to_string(),
            expected: expected.to_owned(),
        };
        if !(self.size > 0.0 && self.size <= 1.0) {
            return Err(setting("size", self.size, "above 0 and at most 1"));
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(setting("tolerance", self.tolerance, "at least 0 and below 1"));
        }
        Ok(())
    }

    /// Simplices, one after another, until two of different sizes gain nothing.
    fn search(&self, start: DVector<f64>, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let mut simplex = Simplex::new(start.len());
        let mut best = start;
        let mut cost = run.cost(&best)?;
        let mut size = self.size;
        let mut idle = 0;
        for restart in 0..=self.restarts {
            simplex.surround(&best, cost, size, restart, run)?;
            simplex.collapse(self.tolerance, run)?;

            let gained = cost - simplex.costs[0];
            let moved = (&simplex.points[0] - &best).amax();
            idle = if gained > self.tolerance * cost.abs() + NO_COST { 0 } else { idle + 1 };
            if gained >= 0.0 {
                best.copy_from(&simplex.points[0]);
                cost = simplex.costs[0];
            }
            if idle == 2 {
                return Ok(Termination::PointsAgree);
            }
            let next = if idle > 0 { size / 16.0 } else { 2.0 * moved };
            size = next.clamp(SMALLEST, self.size);
        }
        Ok(Termination::PlanDone)
    }
}

/// n + 1 points, sorted by cost.
struct Simplex {
    points: Vec<DVector<f64>>,
    costs: Vec<f64>,
    centroid: DVector<f64>,
    reflected: DVector<f64>,
    tried: DVector<f64>,
    coefficients: Coefficients,
}

/// Gao and Han's coefficients: Nelder and Mead's 1, 2, ½, ½ for n = 2, gentler for larger n.
struct Coefficients {
    expansion: f64,
    contraction: f64,
    shrinkage: f64,
}

impl Coefficients {
    fn new(n: usize) -> Self {
        let n = n.max(2) as f64;
        Self { expansion: 1.0 + 2.0 / n, contraction: 0.75 - 0.5 / n, shrinkage: 1.0 - 1.0 / n }
    }
}

impl Simplex {
    fn new(n: usize) -> Self {
        let zero = DVector::zeros(n);
        Self {
            points: vec![zero.clone(); n + 1],
            costs: vec![f64::INFINITY; n + 1],
            centroid: zero.clone(),
            reflected: zero.clone(),
            tried: zero,
            coefficients: Coefficients::new(n),
        }
    }

    /// A fresh simplex: `x` and one step along each axis, away from the nearer bound or, every other time, towards it.
    fn surround(
        &mut self,
        x: &DVector<f64>,
        cost: f64,
        size: f64,
        restart: usize,
        run: &mut Run<'_>,
    ) -> Result<(), Stop> {
        self.points[0].copy_from(x);
        self.costs[0] = cost;
        for j in 0..x.len() {
            let inwards = if x[j] <= 0.5 { size } else { -size };
            let step = if restart % 2 == 0 || !(0.0..=1.0).contains(&(x[j] - inwards)) { inwards } else { -inwards };
            let point = &mut self.points[j + 1];
            point.copy_from(x);
            point[j] = (x[j] + step).clamp(0.0, 1.0);
        }
        run.costs(&self.points[1..], &mut self.costs[1..])?;
        self.sort();
        Ok(())
    }

    /// Moves the worst point until the costs agree, the points agree, or the best one no longer improves.
    fn collapse(&mut self, tolerance: f64, run: &mut Run<'_>) -> Result<(), Stop> {
        let n = self.centroid.len();
        let mut last = self.costs[0];
        let mut patience = PATIENCE * (n + 1);
        while patience > 0 && !self.agrees(tolerance) {
            self.centroid.copy_from(&self.points[0]);
            for point in &self.points[1..n] {
                self.centroid += point;
            }
            self.centroid /= n as f64;

            let Coefficients { expansion, contraction, .. } = self.coefficients;
            along(&self.centroid, &self.points[n], -1.0, &mut self.reflected);
            let reflected = run.cost(&self.reflected)?;
            if reflected < self.costs[0] {
                along(&self.centroid, &self.points[n], -expansion, &mut self.tried);
                let expanded = run.cost(&self.tried)?;
                if expanded < reflected {
                    self.replace_worst(Tried::Other, expanded)
                } else {
                    self.replace_worst(Tried::Reflected, reflected)
                }
            } else if reflected < self.costs[n - 1] {
                self.replace_worst(Tried::Reflected, reflected);
            } else {
                // outside, between centroid and reflected point, if that is better than the worst; inside otherwise
                let (side, bar) =
                    if reflected < self.costs[n] { (-contraction, reflected) } else { (contraction, self.costs[n]) };
                along(&self.centroid, &self.points[n], side, &mut self.tried);
                let contracted = run.cost(&self.tried)?;
                if contracted < bar || (side < 0.0 && contracted <= bar) {
                    self.replace_worst(Tried::Other, contracted);
                } else {
                    self.shrink(run)?;
                }
            }

            patience -= 1;
            if self.costs[0] < last - tolerance * last.abs() {
                last = self.costs[0];
                patience = PATIENCE * (n + 1);
            }
        }
        Ok(())
    }

    fn agrees(&self, tolerance: f64) -> bool {
        let n = self.centroid.len();
        self.costs[n] - self.costs[0] <= 0.1 * tolerance * self.costs[0].abs() + NO_COST
            || self.points[1..].iter().all(|p| p.iter().zip(&self.points[0]).all(|(a, b)| (a - b).abs() < ROUNDING))
    }

    fn shrink(&mut self, run: &mut Run<'_>) -> Result<(), Stop> {
        let (best, others) = self.points.split_at_mut(1);
        for point in others.iter_mut() {
            point.axpy(1.0 - self.coefficients.shrinkage, &best[0], self.coefficients.shrinkage);
            point.apply(|v| *v = v.clamp(0.0, 1.0));
        }
        run.costs(&self.points[1..], &mut self.costs[1..])?;
        self.sort();
        Ok(())
    }

    /// Puts the tried point in the place that its cost gives it; the worst leaves.
    fn replace_worst(&mut self, tried: Tried, cost: f64) {
        let n = self.centroid.len();
        let point = match tried {
            Tried::Reflected => &mut self.reflected,
            Tried::Other => &mut self.tried,
        };
        std::mem::swap(&mut self.points[n], point);
        self.costs[n] = cost;
        let place = self.costs[..n].partition_point(|&c| c <= cost);
        self.points[place..].rotate_right(1);
        self.costs[place..].rotate_right(1);
    }

    fn sort(&mut self) {
        // insertion: n + 1 points, mostly in order
        for i in 1..self.costs.len() {
            let place = self.costs[..i].partition_point(|&c| c <= self.costs[i]);
            self.points[place..=i].rotate_right(1);
            self.costs[place..=i].rotate_right(1);
        }
    }
}

enum Tried {
    Reflected,
    Other,
}

/// c + t (p - c), projected onto the bounds, overwriting `out`.
fn along(c: &DVector<f64>, p: &DVector<f64>, t: f64, out: &mut DVector<f64>) {
    for j in 0..c.len() {
        out[j] = (c[j] + t * (p[j] - c[j])).clamp(0.0, 1.0);
    }
}
