//! Test data: sensors, measured modes and frequency responses, each number with its uncertainty and its origin.
//!
//! A [`TestData`] is what a test file holds after reading, in SI. Readers and writers of foreign formats stand in
//! files of their own and produce or consume the same types.

mod frf;
mod test;
mod yaml;

pub use frf::{Channel, FrfQuantity, FrfSet};
pub use test::{MassProperty, MassQuantity, Measured, Origin, Place, Sensor, TestData, TestMode};
pub use yaml::{
    DEFAULT_DAMPING_SD, DEFAULT_FREQUENCY_SD, DEFAULT_MASS_SD, DEFAULT_SHAPE_SD, TestSpec, family_of_label, read_test,
    schema, write_test,
};
