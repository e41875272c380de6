use std::error::Error;
use std::fmt;
use std::path::PathBuf;

/// Why an optimisation has no result. Not converging is not an error: see [`Termination`](super::Termination).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OptimError {
    /// A setting is outside its range.
    #[error("optimizer `{method}`: `{setting}` is {value}; it must be {expected}")]
    Setting {
        /// Name of the method.
        method: &'static str,
        /// Name of the setting.
        setting: &'static str,
        /// What was given.
        value: String,
        /// What is allowed.
        expected: String,
    },
    /// The start has another length than x.
    #[error("the start has {found} values, but the objective has {expected} parameters")]
    StartLength {
        /// Length of the start.
        found: usize,
        /// Number of parameters.
        expected: usize,
    },
    /// The start is NaN or infinite somewhere.
    #[error("the start is {value} at parameter {parameter}; it must be finite")]
    StartNotFinite {
        /// Index of the parameter.
        parameter: usize,
        /// Its value.
        value: f64,
    },
    /// There is nothing to vary.
    #[error("the objective has no parameters: there is nothing to optimise")]
    NoParameters,
    /// An optimiser asked for a point outside the unit box.
    #[error("an optimizer asked for a point whose parameter {parameter} is {value}; it must be between 0 and 1")]
    OutsideBox {
        /// Index of the parameter.
        parameter: usize,
        /// Its value.
        value: f64,
    },
    /// No point had a finite cost.
    #[error("{}", without_point(*evaluations, *termination))]
    NoFinitePoint {
        /// Number of points tried.
        evaluations: u64,
        /// How the search ended.
        termination: super::Termination,
    },
    /// The user stopped what has no result before its end.
    #[error("stopped by the user before its end: it has no result yet")]
    Cancelled,
    /// The linearization fails where the cost does not.
    #[error("optimizer `{method}` needs derivatives, and they cannot be had at its start")]
    Linearization {
        /// Name of the method.
        method: &'static str,
        /// What the objective says.
        source: crate::objective::EvalError,
    },
    /// The service that evaluates batches failed.
    #[error("the evaluator failed")]
    Evaluator {
        /// What it says.
        source: Box<dyn Error + Send + Sync>,
    },
    /// The answers do not fit the question.
    #[error("{found} answers were told, but {expected} {kind} were asked for")]
    Answers {
        /// How many were told.
        found: usize,
        /// How many were asked for.
        expected: usize,
        /// "costs", "linearizations", or "answers" if nothing was asked.
        kind: &'static str,
    },
    /// The checkpoint cannot be read, written or continued.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}

impl OptimError {
    /// A setting outside its range.
    pub(super) fn setting(
        method: &'static str,
        setting: &'static str,
        value: impl fmt::Display,
        expected: &str,
    ) -> Self {
        Self::Setting { method, setting, value: value.to_string(), expected: expected.to_owned() }
    }
}

/// Why there is no point.
fn without_point(evaluations: u64, termination: super::Termination) -> String {
    if evaluations == 0 && termination == super::Termination::Cancelled {
        return "stopped by the user before the first evaluations were done: nothing was evaluated yet, and there is no best point"
            .to_string();
    }
    format!(
        "none of the {evaluations} points tried has a finite cost ({termination}); check that the model can be solved inside the bounds"
    )
}

/// Why a checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The file cannot be created, read or written.
    #[error("cannot {action} the checkpoint `{}`", path.display())]
    File {
        /// "create", "read" or "write".
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file exists.
    #[error("the checkpoint `{}` exists; resume it, or remove it to start afresh", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The file is something else.
    #[error("`{}` is not a checkpoint of this version: {reason}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What was expected.
        reason: String,
    },
    /// The run differs from the one that wrote the file.
    #[error(
        "the checkpoint `{}` belongs to another run: {difference}; resume with the model, test, optimizer and seed that wrote it, or start afresh",
        path.display()
    )]
    OtherRun {
        /// The file.
        path: PathBuf,
        /// What differs.
        difference: String,
    },
}
