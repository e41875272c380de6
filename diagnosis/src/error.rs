//! Why there is no diagnosis.

use retune::correlation::CorrelationError;
use retune::effect::PatchError;
use retune::linalg::LinalgError;
use retune::objective::EvalError;
use retune::optim::OptimError;

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// Nothing to compare with.
    #[error(
        "the test has nothing to compare with: no modes (`retune identify` finds them in functions), no static tests, no mass properties"
    )]
    NoData,
    /// Nothing of the test is of the model.
    #[error(
        "no measured mode has a probable partner in the model, so there is nothing to diagnose: does the test belong to this structure, in these units? `retune compare` shows the MAC, and `pair_with` in the test file names partners"
    )]
    NoPartner,
    /// The frequencies of a test are in another unit than it says.
    #[error("{slip} No diagnosis is made of them: correct the unit in the test file, or the model")]
    Unit {
        /// The common factor, and what was probably done.
        slip: String,
    },
    /// Effects were to be tried at a place that the structure does not have.
    #[error(
        "the model has no node, element, member, chain or group `{name}` at which effects could be tried{suggestion}"
    )]
    Place {
        /// The name.
        name: String,
        /// "; did you mean ...?" or nothing.
        suggestion: String,
    },
    /// Effects were chosen that have no place on the structure, or none at the places that were chosen.
    #[error("{have_no_place}, so there is nothing to try")]
    NoEffect {
        /// "the effects `a` and `b` have no place at `n3`".
        have_no_place: String,
    },
    /// A test and its model cannot be compared.
    #[error(transparent)]
    Update(#[from] retune::update::UpdateError),
    /// No start of a fit could be evaluated.
    #[error("no start of the fit can be evaluated")]
    NoStart,
    /// Parameters without any prior or data.
    #[error("parameters cannot be told apart, not even by their bounds; give them bounds of a sensible width")]
    Singular,
    /// Model and test do not fit together.
    #[error(transparent)]
    Correlation(#[from] CorrelationError),
    /// The model cannot be evaluated.
    #[error(transparent)]
    Evaluation(#[from] EvalError),
    /// The fit failed.
    #[error(transparent)]
    Optimizer(#[from] OptimError),
    /// A factorisation failed.
    #[error(transparent)]
    Linalg(#[from] LinalgError),
    /// An effect cannot be put into the model.
    #[error(transparent)]
    Patch(#[from] PatchError),
}

pub(super) fn unsolvable(reason: impl std::fmt::Display) -> DiagnosisError {
    EvalError::Unsolvable { reason: reason.to_string() }.into()
}
