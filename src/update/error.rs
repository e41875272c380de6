//! Why there is no comparison or no update.

use crate::correlation::CorrelationError;
use crate::identify::IdentifyError;
use crate::model::ModelError;
use crate::objective::EvalError;
use crate::optim::OptimError;
use crate::yaml::Problem;

/// Why there is no comparison or no update.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateError {
    /// Model and test do not fit together.
    #[error(transparent)]
    Correlation(#[from] CorrelationError),
    /// The model has no modes at its estimates.
    #[error("the model cannot be evaluated at its estimates: {0}")]
    Start(#[from] EvalError),
    /// The search failed.
    #[error(transparent)]
    Optimizer(#[from] OptimError),
    /// Nothing may change.
    #[error(
        "no parameter of the model has bounds, so nothing can be updated; give `bounds: [low, high]` to those that may change"
    )]
    NothingFree,
    /// Nothing to compare with.
    #[error(
        "the test has nothing to compare with: no modes, no static tests, no mass properties, no functions under `frfs`"
    )]
    NoData,
    /// Bands of functions that there are not.
    #[error("there are no functions for these bands; give their files by `--frf`, or in the test")]
    NoFunctions,
    /// Measurements without anything to identify modes from.
    #[error("the files hold no frequency response functions, but {0}")]
    NoMeasurements(String),
    /// Points that cannot be placed in a model.
    #[error("the positions of the points are not known, so they have no place in the model; give `--geometry FILE`")]
    NoPositions,
    /// Points of another place, or in another unit.
    #[error(
        "none of the {sensors} sensors lies on the model: {lengths}; are coordinates in the stated unit, and from the same origin?"
    )]
    OffTheModel {
        /// How many there are.
        sensors: usize,
        /// How far they and the nodes of the model reach.
        lengths: String,
    },
    /// Modes cannot be identified.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// Nothing of the test is of the model.
    #[error(
        "no measured mode has a probable partner in the model, so there is nothing to fit: {reasons}; does the test belong to this structure, in these units? `retune compare` shows the MAC, and `pair_with` in the test file names partners"
    )]
    NoPartner {
        /// Of the first modes, why.
        reasons: String,
    },
    /// Tests of different structures.
    #[error(
        "the model of the test `{test}` has other parameters than that of the first test; a fit to several tests needs one model with configurations"
    )]
    DifferentParameters {
        /// The test.
        test: String,
    },
    /// A model in the configuration of a test that has no modes, or no reduced model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// What a reduced model cannot predict.
    #[error(
        "the test `{test}` has static readings or frequency responses, which need more than the modes that a reduced model keeps; fit it without one"
    )]
    NotReduced {
        /// The test.
        test: String,
    },
    /// The inequalities of the objective do not fit the model.
    #[error("{}", problems_in_words(.0))]
    Limits(Vec<Problem>),
}

fn problems_in_words(problems: &[Problem]) -> String {
    problems.iter().map(|p| format!("{}: {}", p.path, p.message)).collect::<Vec<_>>().join("; ")
}
