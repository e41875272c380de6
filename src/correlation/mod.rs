//! Comparison of mode shapes and frequency responses: where a model agrees with a test, and where it does not.
//!
//! Functions of plain matrices: shapes are columns at the sensors (or at all dofs, where a function says so), analytical
//! ones first, experimental ones second, and NaN marks what was not measured. Start reading at [`mac_matrix`].

mod assignment;
mod mac;
mod pairing;

pub use mac::{ShapeScalar, auto_mac, mac_matrix, modal_scale_factor, to_complex, weighted_mac_matrix};
pub use pairing::{
    ModeList, ModePair, PairBy, PairFlag, PairedModes, PairingOptions, Tracked, Unpaired, pair_modes, track,
};
