//! The simplex method of Nelder and Mead, inside bounds, with restarts.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{About, OptimError, Optimizer, Optimum, Run, Stop, Termination};
use nalgebra::SymmetricEigen;

use crate::linalg::{DMatrix, DVector};

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
simplex shrinks to its best point. Points are projected onto the bounds. A simplex whose progress wanes, which in many \
dimensions or along a kink is soon, has flattened; a fresh one is built around the best point, along the principal axes of \
the old one but none of them short, and as large as the recent progress. While there is progress, parameters on a bound \
stay there and the simplex has that many dimensions less; without, all are free again. Four fresh simplices of different \
sizes that gain nothing end the search. It needs hundreds of evaluations a dimension, one after another.",
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
/// A fresh simplex after one that gained nothing is smaller by this.
const FINER: f64 = 30.0;
/// So many fresh simplices in all dimensions, each finer, must gain nothing before the search ends.
const SIZES: usize = 4;
/// Shortest axis of a fresh simplex, relative to its size.
const SLENDEREST: f64 = 1e-3;
/// A parameter this near to a bound is tried on it.
const NEAR: f64 = 1e-4;
/// A simplex has flattened if its patience is over and it gained less than this share of all it has gained.
const WANING: f64 = 0.1;
/// Moves a vertex after which the progress of a simplex is judged.
const PATIENCE: usize = 8;

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
        if !(self.size > 0.0 && self.size <= 1.0) {
            return Err(OptimError::setting(ABOUT.name, "size", self.size, "above 0 and at most 1"));
        }
        if !(0.0..1.0).contains(&self.tolerance) {
            return Err(OptimError::setting(ABOUT.name, "tolerance", self.tolerance, "at least 0 and below 1"));
        }
        Ok(())
    }

    /// Simplices, one after another, until several of different sizes in all dimensions gain nothing.
    ///
    /// While there is progress a simplex keeps to the face of the box that the best point lies on; without, the next one
    /// leaves the bounds again.
    fn search(&self, start: DVector<f64>, run: &mut Run<'_>) -> Result<Termination, Stop> {
        let cost = run.cost(&start)?;
        let mut simplex = Simplex::new(start, cost);
        let mut free: Vec<usize> = Vec::with_capacity(simplex.tried.len());
        let mut size = self.size;
        let mut idle = 0;
        let mut on_face = false;
        for _restart in 0..=self.restarts {
            let (before, cost) = (simplex.points[0].clone(), simplex.costs[0]);
            free.clear();
            free.extend((0..before.len()).filter(|&j| !on_face || (before[j] > 0.0 && before[j] < 1.0)));
            let whole = free.len() == before.len();
            if !free.is_empty() {
                simplex.surround(&free, size, run)?;
                simplex.collapse(self.tolerance, run)?;
            }
            simplex.onto_near_bounds(run)?;

            if improves(simplex.costs[0], cost, self.tolerance) {
                idle = 0;
                on_face = true;
                size = (2.0 * (&simplex.points[0] - &before).amax()).clamp(SMALLEST, self.size);
            } else if on_face && !whole {
                on_face = false;
                size = self.size;
            } else {
                on_face = false;
                idle += 1;
                size = (size / FINER).max(SMALLEST);
            }
            if idle == SIZES {
                return Ok(Termination::PointsAgree);
            }
        }
        Ok(Termination::PlanDone)
    }
}

/// m + 1 points in n dimensions, sorted by cost; m is the number of parameters that the simplex may change.
struct Simplex {
    /// n + 1 of them are kept, the first m + 1 are in use.
    points: Vec<DVector<f64>>,
    costs: Vec<f64>,
    m: usize,
    centroid: DVector<f64>,
    reflected: DVector<f64>,
    tried: DVector<f64>,
}

/// Gao and Han's coefficients: Nelder and Mead's 1, 2, ½, ½ for two dimensions, gentler for more.
struct Coefficients {
    expansion: f64,
    contraction: f64,
    shrinkage: f64,
}

impl Coefficients {
    fn new(m: usize) -> Self {
        let m = m.max(2) as f64;
        Self { expansion: 1.0 + 2.0 / m, contraction: 0.75 - 0.5 / m, shrinkage: 1.0 - 1.0 / m }
    }
}

impl Simplex {
    /// A single point.
    fn new(x: DVector<f64>, cost: f64) -> Self {
        let n = x.len();
        Self {
            points: vec![x.clone(); n + 1],
            costs: vec![cost; n + 1],
            m: 0,
            centroid: x.clone(),
            reflected: x.clone(),
            tried: x,
        }
    }

    /// Replaces all points but the best by steps from it along the principal axes of the present simplex, in the space of
    /// the `free` parameters; the longest step is `size`, none is much shorter.
    fn surround(&mut self, free: &[usize], size: f64, run: &mut Run<'_>) -> Result<(), Stop> {
        let edges = DMatrix::from_fn(free.len(), self.m, |i, j| self.points[j + 1][free[i]] - self.points[0][free[i]]);
        let SymmetricEigen { eigenvectors: axes, eigenvalues } = (&edges * edges.transpose()).symmetric_eigen();
        let longest = eigenvalues.max().max(f64::MIN_POSITIVE);

        self.m = free.len();
        let (best, others) = self.points.split_at_mut(1);
        for (j, point) in others.iter_mut().take(self.m).enumerate() {
            let length =
                if edges.is_empty() { size } else { size * (eigenvalues[j] / longest).max(0.0).sqrt().max(SLENDEREST) };
            let mut step_to = |signed: f64| {
                point.copy_from(&best[0]);
                for (i, &k) in free.iter().enumerate() {
                    point[k] = (point[k] + signed * axes[(i, j)]).clamp(0.0, 1.0);
                }
                point.metric_distance(&best[0])
            };
            // the longer of both steps inside the bounds
            let (forth, back) = (step_to(length), step_to(-length));
            if forth >= back {
                step_to(length);
            }
        }
        run.costs(&self.points[1..=self.m], &mut self.costs[1..=self.m])?;
        self.sort();
        Ok(())
    }

    /// Moves the best point onto the bounds it almost touches, one after another, where that does not cost more.
    fn onto_near_bounds(&mut self, run: &mut Run<'_>) -> Result<(), Stop> {
        for i in 0..self.tried.len() {
            let v = self.points[0][i];
            let bound = v.round();
            if v != bound && (v - bound).abs() < NEAR {
                self.tried.copy_from(&self.points[0]);
                self.tried[i] = bound;
                let cost = run.cost(&self.tried)?;
                if cost <= self.costs[0] {
                    self.points[0].copy_from(&self.tried);
                    self.costs[0] = cost;
                }
            }
        }
        Ok(())
    }

    /// Moves the worst point until the costs agree, the points agree, or the best one no longer improves.
    fn collapse(&mut self, tolerance: f64, run: &mut Run<'_>) -> Result<(), Stop> {
        let n = self.m;
        let coefficients = Coefficients::new(n);
        let first = self.costs[0];
        let mut last = first;
        let mut patience = PATIENCE * (n + 1);
        while patience > 0 && !self.agrees(tolerance) {
            self.centroid.copy_from(&self.points[0]);
            for point in &self.points[1..n] {
                self.centroid += point;
            }
            self.centroid /= n as f64;

            let Coefficients { expansion, contraction, shrinkage } = coefficients;
            along(&self.centroid, &self.points[n], -1.0, &mut self.reflected);
            let reflected = run.cost(&self.reflected)?;
            if reflected < self.costs[0] {
                along(&self.centroid, &self.points[n], -expansion, &mut self.tried);
                let expanded = run.cost(&self.tried)?;
                if expanded < reflected {
                    self.replace_worst(Tried::Other, expanded);
                } else {
                    self.replace_worst(Tried::Reflected, reflected);
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
                    self.shrink(shrinkage, run)?;
                }
            }

            // a simplex that gains little of what it gained before has flattened, or the tolerance is reached
            patience -= 1;
            if patience == 0
                && improves(self.costs[0], last, tolerance)
                && last - self.costs[0] >= WANING * (first - self.costs[0])
            {
                last = self.costs[0];
                patience = PATIENCE * (n + 1);
            }
        }
        Ok(())
    }

    fn agrees(&self, tolerance: f64) -> bool {
        let n = self.m;
        self.costs[n] - self.costs[0] <= 0.1 * tolerance * self.costs[0].abs() + NO_COST
            || self.points[1..=n].iter().all(|p| p.iter().zip(&self.points[0]).all(|(a, b)| (a - b).abs() < ROUNDING))
    }

    fn shrink(&mut self, shrinkage: f64, run: &mut Run<'_>) -> Result<(), Stop> {
        let (best, others) = self.points.split_at_mut(1);
        for point in others.iter_mut().take(self.m) {
            // written so that a coordinate which all points share keeps its bits, and a bound stays a bound
            point.zip_apply(&best[0], |v, b| *v = b + shrinkage * (*v - b));
        }
        run.costs(&self.points[1..=self.m], &mut self.costs[1..=self.m])?;
        self.sort();
        Ok(())
    }

    /// Puts the tried point in the place that its cost gives it; the worst leaves.
    fn replace_worst(&mut self, tried: Tried, cost: f64) {
        let n = self.m;
        let point = match tried {
            Tried::Reflected => &mut self.reflected,
            Tried::Other => &mut self.tried,
        };
        std::mem::swap(&mut self.points[n], point);
        self.costs[n] = cost;
        let place = self.costs[..n].partition_point(|&c| c <= cost);
        self.points[place..=n].rotate_right(1);
        self.costs[place..=n].rotate_right(1);
    }

    fn sort(&mut self) {
        // insertion: n + 1 points, mostly in order
        for i in 1..=self.m {
            let place = self.costs[..i].partition_point(|&c| c <= self.costs[i]);
            self.points[place..=i].rotate_right(1);
            self.costs[place..=i].rotate_right(1);
        }
    }
}

/// Whether a cost is noticeably below an older one.
fn improves(cost: f64, before: f64, tolerance: f64) -> bool {
    cost < before && (before.is_infinite() || before - cost > tolerance * before.abs() + NO_COST)
}

/// Which trial point is meant.
#[derive(Clone, Copy)]
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
