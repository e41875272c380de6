//! Test data: sensors, measured modes and frequency responses, each number with its uncertainty and its origin.
//!
//! A [`TestData`] is what a test file holds after reading, in SI. Readers and writers of foreign formats stand in
//! files of their own and produce or consume the same types.

pub mod convert;
mod correction;
pub mod csv;
mod file;
mod frf;
mod geometry;
mod geometry_frame;
mod joined;
pub mod lvm;
pub mod mat;
mod measurement;
mod modal_set;
#[cfg(test)]
pub(crate) mod mutate;
pub mod npy;
pub mod npz;
pub mod punch;
mod skew;
mod spectrum;
mod test;
pub mod uff;
mod yaml;

pub use correction::Correction;
pub use file::read_file;
pub use frf::{Channel, FrfQuantity, FrfSet};
pub use geometry::{Geometry, Line, Point};
pub use geometry_frame::GeometryFrame;
pub use joined::{Joined, joined};
pub use measurement::{
    MeasurementError, MeasurementOptions, Measurements, Open, Roles, read_measurements, read_measurements_by,
};
pub use modal_set::{ModalSet, ModeRecord, RelativeSd, ShapeChannel};
pub use spectrum::{Spectrum, SpectrumKind, SpectrumUnit};
pub use test::{
    FrfFit, MassProperty, MassQuantity, Measured, Origin, Partner, Place, Sensor, Standing, StaticLoad, StaticReading,
    StaticTest, TestData, TestMode,
};
pub use yaml::{
    DEFAULT_DAMPING_SD, DEFAULT_FREQUENCY_SD, DEFAULT_FRF_SD, DEFAULT_MASS_SD, DEFAULT_SHAPE_SD, DEFAULT_STATIC_SD,
    TestSpec, family_of_label, read_test, schema, write_test,
};

/// A folder of the real data that some tests use, if it is on this machine: in `RETUNE_DATA`, or beside the project.
#[cfg(test)]
pub(crate) fn shared_data(folder: &str) -> Option<std::path::PathBuf> {
    let beside = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let root = std::env::var_os("RETUNE_DATA").map_or(beside, std::path::PathBuf::from);
    let path = root.join(folder);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there; set RETUNE_DATA to the folder of the real data", path.display());
    None
}
