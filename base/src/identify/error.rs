//! Why an identification has no result.

use retune_linalg::LinalgError;

/// Why an identification has no result.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IdentifyError {
    /// The limits of the band are not ascending numbers.
    #[error("the band from {low} Hz to {high} Hz is empty; give two ascending frequencies")]
    Band {
        /// Lower limit, Hz.
        low: f64,
        /// Upper limit, Hz.
        high: f64,
    },
    /// Too few lines in the band for the model order.
    #[error(
        "the band has {found} frequency lines, but the fit needs at least {needed}; widen the band or lower the model order"
    )]
    TooFewLines {
        /// Lines in the band.
        found: usize,
        /// Lines that are needed.
        needed: usize,
    },
    /// Frequencies are not ascending, not finite or negative.
    #[error("frequency line {line} is {value} Hz; the lines must be finite, not negative and ascending")]
    Lines {
        /// Index of the first bad line.
        line: usize,
        /// Its value, Hz.
        value: f64,
    },
    /// A vector of the FRF set has the wrong length.
    #[error("the FRF set holds {found} values of `{what}`, but its lines and channels need {expected}")]
    Layout {
        /// "h" or "coherence".
        what: &'static str,
        /// lines x references x responses.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// No response has been measured for every reference.
    #[error(
        "no function is measured in full: of {references} references and {responses} responses, none has finite, nonzero values in every line of the band for all partners"
    )]
    NoCompleteFunction {
        /// Number of references.
        references: usize,
        /// Number of responses.
        responses: usize,
    },
    /// An option is out of range.
    #[error("option `{name}` is {value}; it must be {expected}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// Lists that belong together differ in length.
    #[error("{what} has {found} entries, expected {expected}")]
    Length {
        /// What.
        what: &'static str,
        /// Length wanted.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A quantity that must be positive is not.
    #[error("{what} {index} is {value}; it must be positive and finite")]
    NotPositive {
        /// What.
        what: &'static str,
        /// Its index.
        index: usize,
        /// Its value.
        value: f64,
    },
    /// A channel that does not say in which direction it measures.
    #[error("channel `{channel}` has no direction; state one for the channels without (`--direction +z`)")]
    NoDirection {
        /// The channel.
        channel: String,
    },
    /// A frequency lies outside the lines.
    #[error("{frequency} Hz lies outside the frequency lines, {low} Hz to {high} Hz")]
    OutsideLines {
        /// The frequency, Hz.
        frequency: f64,
        /// First line, Hz.
        low: f64,
        /// Last line, Hz.
        high: f64,
    },
    /// The equations cannot be solved.
    #[error("the {what} are singular; the modes cannot be told apart at these sensors and lines")]
    Singular {
        /// Which equations.
        what: &'static str,
    },
    /// A numerical kernel failed.
    #[error("a numerical kernel failed")]
    Linalg(#[from] LinalgError),
}
