//! What is minimised: weighted residuals between model and test, as a function of scaled parameters.
//!
//! Sign and scale are the same everywhere: r = (model - test)/σ and cost = ½ rᵀr, unless an objective states another
//! cost (the paper's equation (4) does). Parameters reach an optimiser as x in the unit box, θ = lower + x (upper - lower).

mod answering;
mod answers;
mod augmented;
mod batch;
mod close_modes;
mod common_error;
mod comparison;
mod damped;
mod decision;
mod followed;
mod least_squares;
mod loss;
#[cfg(test)]
mod mast;
mod paper;
mod point;
mod prediction;
mod real_shapes;
mod recent;
pub mod residual;
mod responses;
mod scaling;
mod spaces;
mod stacked;
mod starting_point;
mod static_loads;
mod statics;
mod walls;

pub use answering::Answering;
pub use answers::{Answers, Parts};
pub use augmented::{Augmented, Wall};
pub use batch::BatchPath;
pub use comparison::Comparison;
pub(crate) use damped::Damped;
pub(crate) use decision::why_unpaired;
pub use decision::{Deciding, Decision, decide, decide_by_rule};
pub use least_squares::LeastSquares;
pub(crate) use loss::Choice;
pub use loss::Loss;
pub use paper::PaperCost;
pub use point::Point;
pub use prediction::{Prediction, PredictionDerivative};
pub use real_shapes::real_shapes;
pub use residual::{RESIDUALS, Residual, Residuals};
pub(crate) use responses::{direct_responses, loss_factor, silent_functions};
pub use scaling::Scaling;
pub use stacked::Stacked;
pub use starting_point::{is_damped, starting_point};
pub use static_loads::loads_of;
pub use statics::static_readings;
pub use walls::Walls;

use crate::linalg::{DMatrix, DVector};

/// Residuals and their Jacobian at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Linearization {
    /// r(x), (n_residuals).
    pub residuals: DVector<f64>,
    /// ∂r/∂x, (n_residuals x n_parameters).
    pub jacobian: DMatrix<f64>,
}

/// A cost over the unit box, with the residuals it is made of.
pub trait Objective: Send + Sync {
    /// Number of parameters, the length of x.
    fn n_parameters(&self) -> usize;

    /// Number of residuals; it never changes with x.
    fn n_residuals(&self) -> usize;

    /// r(x), unitless, (n_residuals).
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError>;

    /// r and ∂r/∂x together; by default by central differences of step 1e-6, one-sided at the faces of the unit box.
    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        difference(self.n_residuals(), x, |x| self.residuals(x))
    }

    /// Which residuals stand for one-sided constraints; none by default.
    fn walls(&self) -> Walls {
        Walls::default()
    }

    /// The cost at x: ½ rᵀr by default.
    fn cost(&self, x: &DVector<f64>) -> Result<f64, EvalError> {
        Ok(0.5 * self.residuals(x)?.norm_squared())
    }

    /// The costs of several points, overwriting `out`; a point that cannot be evaluated costs +∞.
    ///
    /// An objective with a batched kernel overrides this, and [`confirm`](Self::confirm) with it; the values must not depend
    /// on how points are grouped.
    ///
    /// # Panics
    /// If `out` and `points` differ in length.
    fn costs(&self, points: &[DVector<f64>], out: &mut [f64]) {
        assert_eq!(points.len(), out.len(), "one cost a point");
        for (x, cost) in points.iter().zip(out) {
            *cost = self.cost(x).unwrap_or(f64::INFINITY);
        }
    }

    /// Checks a cost from [`costs`](Self::costs) before its point becomes the best of a run: an optimiser is drawn to any
    /// point where a fast path is wrong. Gives that cost, or another one that an independent path finds.
    fn confirm(&self, x: &DVector<f64>, cost: f64) -> f64 {
        let _ = x;
        cost
    }

    /// How many costs each path has given since the objective was made, if it has two.
    fn path_counts(&self) -> PathCounts {
        PathCounts::default()
    }
}

/// Number of costs by the path that gave them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct PathCounts {
    /// By the batched kernel.
    pub batch: u64,
    /// By the reference path: candidates that the kernel does not guarantee, and new best points, checked.
    pub reference: u64,
}

/// Central differences inside the unit box, one-sided on its faces.
fn difference(
    n_residuals: usize,
    x: &DVector<f64>,
    mut r: impl FnMut(&DVector<f64>) -> Result<DVector<f64>, EvalError>,
) -> Result<Linearization, EvalError> {
    const STEP: f64 = 1e-6;
    let residuals = r(x)?;
    let mut jacobian = DMatrix::zeros(n_residuals, x.len());
    for j in 0..x.len() {
        let (mut below, mut above) = (x.clone(), x.clone());
        below[j] = (x[j] - STEP).max(x[j].min(0.0));
        above[j] = (x[j] + STEP).min(x[j].max(1.0));
        let column = (r(&above)? - r(&below)?) / (above[j] - below[j]);
        jacobian.set_column(j, &column);
    }
    Ok(Linearization { residuals, jacobian })
}

/// Why a point cannot be evaluated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// The model has no modes there.
    #[error("the model cannot be solved there: {reason}")]
    Unsolvable {
        /// What the solver says.
        reason: String,
    },
    /// A residual is NaN or infinite.
    #[error("residual `{name}` is not finite")]
    NotFinite {
        /// The residual.
        name: String,
    },
}
