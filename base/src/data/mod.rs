//! Test data: sensors, measured modes and frequency responses, each number with its uncertainty and its origin.
//!
//! A [`TestData`] is what a test file holds after reading, in SI. Readers and writers of foreign formats stand in
//! files of their own and produce or consume the same types.

mod channels;
pub mod convert;
mod correction;
pub mod csv;
mod damping_error;
mod date;
mod file;
mod frf;
mod geometry;
mod geometry_frame;
mod joined;
pub mod lvm;
mod measurement;
mod modal_set;
pub mod punch;
mod skew;
mod spectrum;
mod telling_lines;
mod test;
pub mod uff;
mod yaml;

pub use crate::arrays::{mat, npy, npz};
pub use channels::{PARALLEL, cosine};
pub use channels::{channel_sensor, corrected_functions};
pub use correction::Correction;
pub use damping_error::DampingError;
pub use date::{Date, NoDate};
pub use file::read_file;
pub use frf::{Channel, FrfQuantity, FrfSet};
pub use geometry::{Geometry, Line, Point};
pub use geometry_frame::GeometryFrame;
pub use joined::{Joined, joined};
pub use measurement::{
    Answers, MeasurementError, MeasurementOptions, Measurements, Open, Roles, read_measurements, read_measurements_by,
};
pub use modal_set::{ModalSet, ModeRecord, RelativeSd, ShapeChannel};
pub use spectrum::{Spectrum, SpectrumKind, SpectrumUnit};
pub use test::{
    FrfFit, MassProperty, MassQuantity, Measured, Origin, Partner, Place, Reference, Sensor, ShapeComponent, Standing,
    StaticLoad, StaticReading, StaticTest, TestData, TestMode,
};
pub use yaml::{
    DEFAULT_DAMPING_SD, DEFAULT_FREQUENCY_SD, DEFAULT_FRF_SD, DEFAULT_MASS_SD, DEFAULT_SHAPE_SD, DEFAULT_STATIC_SD,
    TestSpec, family_of_label, read_test, schema, write_test,
};

#[cfg(test)]
pub(crate) use crate::arrays::{mutate, shared_data};
