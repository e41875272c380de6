//! Modal identification: frequency response functions in, modes with standard deviations out, and a check of the test.
//!
//! Three ways lead to modes. [`identify`] is the one to use: poles by pLSCF over many model orders, automatic choice from
//! the stabilisation diagram, then a maximum-likelihood fit of poles, participation, shapes and residuals, which also
//! gives the standard deviations. [`quadrature_shapes`] is the quick one of ground vibration tests (imaginary parts at
//! known frequencies, with the correction for neighbouring modes); [`circle_fit`] and [`half_power_damping`] are
//! cross-checks of one mode in one function. [`cmif`] shows how many modes there are.
//!
//! [`health`] asks whether the test can be trusted, before any model is blamed.
//!
//! This module knows test data and linear algebra, no model. Start reading at [`identify`].

mod band;
mod basis;
mod causality;
mod circle;
mod cmif;
mod common;
mod complexity;
mod error;
mod exponential_window;
mod fit;
mod fitted;
mod gaps;
pub mod health;
mod identification;
mod layout;
mod mode;
mod options;
mod outside;
mod plscf;
mod poles;
mod quadrature;
mod rounds;
mod scan;
mod spectrum;
mod stabilisation;
mod to_test;

pub use causality::{forward_in_time, reversed_time};
pub use circle::{CircleFit, HalfPower, circle_fit, half_power_damping};
pub use cmif::{Cmif, cmif};
pub use complexity::{Complexity, NormalModes, complexity, normal_modes, real_shape};
pub use error::IdentifyError;
pub use exponential_window::remove_exponential_window;
pub use gaps::Gap;
pub use identification::{Identification, Segment, identify};
pub use mode::{IdentifiedMode, MassNormalised, driving_points};
pub use options::{Discarded, IdentifyOptions, Segments, Weighting};
pub use plscf::Pole;
pub use poles::ResidualTerms;
pub use quadrature::{QuadratureForm, QuadratureShapes, quadrature_matrix, quadrature_shapes};
pub use spectrum::{PeakOptions, SpectrumPeak, spectrum_peaks};
pub use stabilisation::{DiagramPole, StabilisationDiagram, Stability};
pub use to_test::{
    REPEATABILITY, add_repeatability, circle_modes, normal_shape, peak_modes, quadrature_modes, sensors, test_modes,
};

#[cfg(test)]
mod tests;
