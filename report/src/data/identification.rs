//! Modes that were identified from functions, and the diagrams they were chosen from.

use super::Floats;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Frequency responses, their poles and the modes that were made of them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Identification {
    /// How, in words.
    pub method: String,
    /// Unit of the complex mode indicator function, that of the functions: `(m/s²)/N`.
    pub unit: String,
    /// Lines of the complex mode indicator function, Hz, ascending.
    pub frequency_hz: Floats,
    /// Its singular values, the largest first, one a line each.
    pub cmif: Vec<Floats>,
    /// Stabilisation diagrams: of each piece of the band that of the functions, then that of what its first modes leave.
    pub diagrams: Vec<Diagram>,
    /// The modes, by ascending frequency.
    pub modes: Vec<IdentifiedMode>,
}

/// A stabilisation diagram; `hz`, `damping`, `order`, `mark` and `column` have one entry a pole.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Diagram {
    /// Which: `3.0 to 30.0 Hz`, `3.0 to 30.0 Hz, remainder`.
    pub name: String,
    /// Natural frequencies, Hz.
    pub hz: Floats,
    /// Damping ratios.
    pub damping: Floats,
    /// Order of the polynomial that has the pole.
    pub order: Vec<usize>,
    /// 0: new at this order; 1: stable in frequency; 2: in frequency and damping; 3: in participation too.
    pub mark: Vec<u8>,
    /// Column that it belongs to: the same pole at several orders.
    pub column: Vec<usize>,
    /// Columns that were taken for modes.
    pub chosen: Vec<usize>,
    /// Columns that the fit rejected, and why.
    pub discarded: Vec<Rejected>,
}

/// A candidate that is not a mode.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Rejected {
    /// Its frequency, Hz.
    pub hz: f64,
    /// Its damping ratio.
    pub damping: f64,
    /// Why.
    pub reason: String,
}

/// An identified mode.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct IdentifiedMode {
    /// Natural frequency, Hz.
    pub hz: f64,
    /// Its standard deviation, Hz.
    pub hz_sd: f64,
    /// Damping ratio.
    pub damping: Option<f64>,
    /// Its standard deviation.
    pub damping_sd: Option<f64>,
    /// Modal phase collinearity, 0 to 1; 1 is a real shape.
    pub mpc: Option<f64>,
    /// Orders at which its pole came back.
    pub orders: usize,
    /// What a reader should know of it, or empty.
    pub remark: String,
}
