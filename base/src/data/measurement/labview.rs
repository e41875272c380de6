//! Channels of a LabVIEW measurement as spectra.

use crate::data::lvm::LvmChannel;
use crate::data::{Channel, Spectrum, SpectrumKind, SpectrumUnit};
use retune_linalg::Complex;

pub(super) fn says_decibel(unit: &str) -> bool {
    unit.to_lowercase().starts_with("db")
}

/// An amplitude is never negative; decibels of a small one are.
pub(super) fn is_negative(channel: &LvmChannel) -> bool {
    !channel.y.is_empty() && channel.y.iter().all(|y| *y < 0.0)
}

/// A channel whose x is frequency; decibels become amplitudes.
pub(super) fn spectrum_of(channel: LvmChannel) -> Spectrum {
    let is_decibel = says_decibel(&channel.y_unit) || is_negative(&channel);
    let amplitude = |y: f64| if is_decibel { 10.0_f64.powf(y / 20.0) } else { y };
    Spectrum {
        kind: SpectrumKind::Linear,
        response: Channel { name: channel.name, direction: None },
        reference: None,
        frequencies_hz: channel.x,
        values: channel.y.into_iter().map(|y| Complex::new(amplitude(y), 0.0)).collect(),
        unit: SpectrumUnit::AsInFile(channel.y_unit),
    }
}
