//! Spectra that are not frequency response functions.

use super::Channel;
use retune_linalg::Complex;

/// What a spectrum is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpectrumKind {
    /// Linear spectrum of one signal.
    Linear,
    /// Auto spectrum.
    Auto,
    /// Cross spectrum.
    Cross,
    /// Power spectral density.
    PowerDensity,
}

/// The unit of the values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SpectrumUnit {
    /// SI, as text.
    Si(String),
    /// What the file says, which is not understood or not stated: the values are those of the file.
    AsInFile(String),
}

/// A spectrum.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// What it is.
    pub kind: SpectrumKind,
    /// The signal.
    pub response: Channel,
    /// The other signal of a cross spectrum.
    pub reference: Option<Channel>,
    /// Frequency lines, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Values.
    pub values: Vec<Complex<f64>>,
    /// Their unit.
    pub unit: SpectrumUnit,
}
