//! Residual terms: one file each. A least-squares objective is a list of them.

mod damping;
mod frequency;
mod frf_complex;
mod frf_log;
mod mac;
mod mass_properties;
mod prior;
mod shape;
mod shape_component;
mod static_angle;
mod static_deflection;
mod targets;

pub(crate) use targets::{WIDTH, violations};

use super::comparison::Comparison;
pub use super::point::Point;
use super::prediction::PredictionDerivative;
use crate::catalogue::catalogue;
use crate::linalg::DMatrix;
use std::fmt;

catalogue! {
    /// The residual terms, in alphabetical order of their names.
    RESIDUALS: dyn Residual;
    damping::Damping,
    frequency::Frequency,
    frf_complex::FrfComplex,
    frf_log::FrfLog,
    mac::Mac,
    mass_properties::MassPropertyResidual,
    prior::Prior,
    shape::Shape,
    shape_component::ShapeComponents,
    static_angle::StaticAngle,
    static_deflection::StaticDeflection,
    targets::TargetResidual,
}

/// One term of a least-squares objective: a fixed number of rows r = (model - test)/σ.
pub trait Residual: fmt::Debug + Send + Sync {
    /// The word in settings and lists, `kebab-case`.
    fn name(&self) -> &'static str;

    /// One sentence: what it compares.
    fn summary(&self) -> &'static str;

    /// Whether it compares with the test; a prior and a target belong to the parameters instead.
    fn is_data(&self) -> bool {
        true
    }

    /// Number of rows; it depends on the test, never on θ.
    fn len(&self, comparison: &Comparison<'_>) -> usize;

    /// Whether it has no rows.
    fn is_empty(&self, comparison: &Comparison<'_>) -> bool {
        self.len(comparison) == 0
    }

    /// What a row compares, for reports.
    fn row_name(&self, comparison: &Comparison<'_>, row: usize) -> String;

    /// Whether [`evaluate`](Self::evaluate) looks at `system`, `modes` or `families` of the prediction, or at the MAC of
    /// modes that are not paired.
    ///
    /// A list of terms that do not is evaluated in batches, ten times faster; a term that does not say so is taken to look.
    fn needs_system(&self) -> bool {
        true
    }

    /// Whether [`evaluate`](Self::evaluate) looks at the shapes at the sensors: in a batch they are then copied out of the lanes.
    fn needs_shapes(&self) -> bool {
        true
    }

    /// Whether its rows are r = ln(1 + eᵗ) of constraints t <= 0, see [`Walls`](super::Walls).
    fn is_wall(&self) -> bool {
        false
    }

    /// Overwrites `out` with the residuals.
    fn evaluate(&self, at: &Point<'_>, out: &mut [f64]);

    /// Overwrites `out` (len x n_free) with ∂r/∂θ_j for the free parameters.
    fn differentiate(&self, at: &Point<'_>, derivative: &PredictionDerivative, out: &mut DMatrix<f64>);
}

/// The residual terms that an objective may name: the built-in ones and a user's own. Two lists are equal that name the same terms.
///
/// ```
/// use retune::objective::Residuals;
/// assert!(Residuals::builtin().find("frequency").is_some());
/// ```
#[derive(Debug, Clone)]
pub struct Residuals {
    terms: Vec<&'static dyn Residual>,
}

impl Residuals {
    /// The built-in ones.
    pub fn builtin() -> Self {
        Self { terms: RESIDUALS.to_vec() }
    }

    /// With one more; a term of the same name replaces the built-in one.
    #[must_use]
    pub fn with(mut self, term: &'static dyn Residual) -> Self {
        self.terms.retain(|r| r.name() != term.name());
        self.terms.push(term);
        self
    }

    /// The term of a name.
    pub fn find(&self, name: &str) -> Option<&'static dyn Residual> {
        self.iter().find(|r| r.name() == name)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &'static dyn Residual> + '_ {
        self.terms.iter().copied()
    }

    /// Those that are not built in.
    pub fn own(&self) -> impl Iterator<Item = &'static dyn Residual> + '_ {
        let is_builtin = |r: &dyn Residual| RESIDUALS.iter().any(|b| Residual::name(*b) == r.name());
        self.iter().filter(move |r| !is_builtin(*r))
    }
}

impl Default for Residuals {
    fn default() -> Self {
        Self::builtin()
    }
}

impl PartialEq for Residuals {
    fn eq(&self, other: &Self) -> bool {
        let names = |terms: &Self| terms.iter().map(Residual::name).collect::<Vec<_>>();
        names(self) == names(other)
    }
}

/// Residual of the frequency of a measured mode for which the model has too few modes, √(2 ln(1/e)) with e = 0.03 as for a mode that
/// is not of the structure: bounded, and constant. Its shape and damping, and all of a mode that is aside, have none.
pub const NO_PARTNER: f64 = 2.648;

#[cfg(test)]
mod tests;
