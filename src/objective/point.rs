//! Where a residual is evaluated.

use super::comparison::Comparison;
use super::prediction::Prediction;
use super::scaling::Scaling;

/// Where a residual is evaluated.
#[derive(Debug, Clone, Copy)]
pub struct Point<'a> {
    /// Model and test.
    pub comparison: &'a Comparison<'a>,
    /// Which parameters are free.
    pub scaling: &'a Scaling,
    /// θ.
    pub theta: &'a [f64],
    /// The prediction at θ.
    pub prediction: &'a Prediction,
}
