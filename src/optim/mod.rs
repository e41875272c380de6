//! Optimisers: one trait, one file each, all bounded to the unit box and all seeded.
//!
//! A method knows a cost over [0, 1]ⁿ and nothing of models. It asks a [`Run`] for batches of costs; the run counts,
//! stops, keeps the best point, tells observers, and writes a [`Checkpoint`]. Who evaluates is an [`Evaluator`]: threads
//! by default. Start reading at [`Run`], then [`LevenbergMarquardt`] for the method that does most of the work.
//!
//! ```
//! use retune::linalg::DVector;
//! use retune::objective::{EvalError, Objective};
//! use retune::optim::{Auto, Optimizer, Run};
//!
//! struct Valley;
//!
//! impl Objective for Valley {
//!     fn n_parameters(&self) -> usize {
//!         2
//!     }
//!     fn n_residuals(&self) -> usize {
//!         2
//!     }
//!     fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
//!         Ok(DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 0.5 - x[0]]))
//!     }
//! }
//!
//! let start = DVector::from_element(2, 0.9);
//! let optimum = Auto::default().minimize(&start, &mut Run::new(&Valley).seed(7).budget(5_000))?;
//! assert!((optimum.x[1] - 0.25).abs() < 1e-6);
//! assert_eq!(optimum.starts_in_words().as_deref(), Some("8 of 8 starts found the best optimum (cost 0)"));
//! # Ok::<(), retune::optim::OptimError>(())
//! ```

mod ask_tell;
mod auto;
mod bounded_least_squares;
mod checkpoint;
mod cma_es;
mod differential_evolution;
mod error;
mod evaluator;
mod genealogy;
mod levenberg_marquardt;
mod multistart;
mod nelder_mead;
mod observer;
mod optimum;
mod posterior;
mod random;
mod run;
mod sequence;
mod shared;
mod spec;
#[cfg(test)]
mod tests;

use std::fmt;

pub use ask_tell::{Ask, AskTell, Problem};
pub use auto::Auto;
pub use bounded_least_squares::bounded_least_squares;
pub use checkpoint::Checkpoint;
pub use cma_es::CmaEs;
pub use differential_evolution::{DifferentialEvolution, Strategy};
pub use error::{CheckpointError, OptimError};
pub use evaluator::{Evaluator, Threads};
pub use levenberg_marquardt::LevenbergMarquardt;
pub use multistart::Multistart;
pub use nelder_mead::NelderMead;
pub use observer::{Observer, Pace, Progress};
pub use optimum::{Improvement, LocalOptimum, Optimum, Stage, Termination};
pub use posterior::{Posterior, Tmcmc};
pub use random::Draw;
pub use run::{Run, Stop};
pub use sequence::{Sequence, in_sequence};
pub use shared::Shared;
pub use spec::{ABBREVIATIONS, OPTIMIZERS, OptimizerSpec, Own, full_name, schema};

use crate::linalg::DVector;

/// A method that minimises a cost over the unit box.
pub trait Optimizer: fmt::Debug + Send + Sync {
    /// The word for it in YAML.
    fn name(&self) -> &'static str;

    /// Searches from `start` (clipped to the unit box) for as long as `run` answers.
    ///
    /// The typical body is `run.conclude(self.name(), |run| ...)` around a loop that asks `run.costs(...)?`. The same
    /// answers must lead to the same questions: all randomness from [`Run::rng`], no clock.
    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError>;
}

/// What a method is, for lists, `explain` and the reference pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// The word for it in YAML.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// How it works and when to use it.
    pub theory: &'static str,
    /// Authors, title, place, year.
    pub sources: &'static [&'static str],
}
