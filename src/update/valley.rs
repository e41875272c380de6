//! Whether two points of a cost lie in one valley.

use super::Controls;
use crate::linalg::DVector;
use crate::objective::Objective;
use crate::optim::{LevenbergMarquardt, Optimizer};

/// Steps from a point to the floor of its valley.
const STEPS: usize = 60;

/// Halvings of the way between two points.
const DEPTH: usize = 4;

/// The floor below a point, and its cost; `None` where the point cannot be evaluated.
pub(super) fn floor(
    objective: &dyn Objective,
    x: &DVector<f64>,
    controls: Controls<'_>,
) -> Option<(DVector<f64>, f64)> {
    let method = LevenbergMarquardt { steps: STEPS, ..LevenbergMarquardt::default() };
    method.minimize(x, &mut controls.run(objective, 0)).ok().map(|o| (o.x, o.cost))
}

/// What lies below a cost.
pub(super) struct Valley<'a, R> {
    pub(super) objective: &'a dyn Objective,
    pub(super) limit: f64,
    /// The floor below a point, and its cost.
    pub(super) refine: &'a R,
}

impl<R: Fn(&DVector<f64>) -> Option<(DVector<f64>, f64)>> Valley<'_, R> {
    /// Whether a way below the limit is found from a to b: straight, or along the floor of a bent valley.
    pub(super) fn joins(&self, a: &DVector<f64>, b: &DVector<f64>) -> bool {
        self.leads(a, b, DEPTH)
    }

    fn leads(&self, a: &DVector<f64>, b: &DVector<f64>, depth: usize) -> bool {
        let points: Vec<DVector<f64>> = [0.25, 0.5, 0.75].iter().map(|t| a + (b - a) * *t).collect();
        let mut costs = vec![f64::INFINITY; points.len()];
        self.objective.costs(&points, &mut costs);
        if costs.iter().all(|c| *c <= self.limit) {
            return true;
        }
        if depth == 0 {
            return false;
        }
        let Some((c, cost)) = (self.refine)(&points[1]) else { return false };
        let whole = (b - a).norm();
        let is_between = (&c - a).norm().max((b - &c).norm()) < 0.9 * whole;
        cost <= self.limit && is_between && self.leads(a, &c, depth - 1) && self.leads(&c, b, depth - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::EvalError;

    struct Cost<F>(F);

    impl<F: Fn(&DVector<f64>) -> f64 + Send + Sync> Objective for Cost<F> {
        fn n_parameters(&self) -> usize {
            2
        }
        fn n_residuals(&self) -> usize {
            1
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(DVector::from_element(1, (self.0)(x)))
        }
    }

    fn is_one(residual: impl Fn(&DVector<f64>) -> f64 + Send + Sync, a: [f64; 2], b: [f64; 2]) -> bool {
        let objective = Cost(residual);
        let refine = |x: &DVector<f64>| floor(&objective, x, Controls::default());
        let [a, b] = [a, b].map(|p| DVector::from_row_slice(&p));
        Valley { objective: &objective, limit: 1.35, refine: &refine }.joins(&a, &b)
    }

    #[test]
    fn a_bent_valley_is_one_and_two_wells_are_two() {
        // x1 x2 = 0.16, seen to 0.005: the straight way from (0.2, 0.8) to (0.8, 0.2) rises to 18² / 2.
        assert!(is_one(|x| (x[0] * x[1] - 0.16) / 0.005, [0.2, 0.8], [0.8, 0.2]));
        // (x1 - 0.3)(x1 - 0.7) = 0 has two roots, whatever x2 is.
        assert!(!is_one(|x| (x[0] - 0.3) * (x[0] - 0.7) / 0.005, [0.3, 0.5], [0.7, 0.4]));
    }
}
