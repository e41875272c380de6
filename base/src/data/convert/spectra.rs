//! Functions of universal files that are spectra.

use super::ends::{EXCITATION_FORCE, End, Naming, REACTION_FORCE, quantity_of};
use super::frequency::{AxisNotes, hertz, points_hz};
use super::options::FrfOptions;
use super::units::{Question, UnitSystem, UnitsFrom, units_at};
use crate::data::uff::{Axis, Function, UniversalFile};
use crate::data::{Channel, Spectrum, SpectrumKind, SpectrumUnit};

/// A function that is a spectrum; in SI where types and units say so. A question where the unit of its frequencies is not understood.
pub(super) fn spectrum(
    file: &UniversalFile,
    index: usize,
    f: &Function,
    options: &FrfOptions,
    channel: &dyn Fn(&End) -> Channel,
    notes: &mut AxisNotes,
) -> Option<Result<Spectrum, Question>> {
    let kind = match f.function_type {
        2 => SpectrumKind::Auto,
        3 => SpectrumKind::Cross,
        9 => SpectrumKind::PowerDensity,
        12 => SpectrumKind::Linear,
        _ => return None,
    };
    let own = units_at(file, index).and_then(UnitSystem::from_dataset);
    let system = match &options.units {
        UnitsFrom::System(system) => Some(system),
        _ => own.as_ref(),
    };
    let signal = |axis: &Axis| -> Option<(f64, &'static str)> {
        let s = system?;
        match axis.data_type {
            EXCITATION_FORCE | REACTION_FORCE => Some((s.force, "N")),
            t => quantity_of(t).map(|q| (s.response(q), ["m", "m/s", "m/s²"][q.order() as usize])),
        }
    };
    // A label that says more than dataset 164 would have to agree with it; such a spectrum stays as it is.
    let label = f.axes[1].units.as_str();
    let is_labelled = !matches!(label, "" | "NONE") && !matches!(options.units, UnitsFrom::System(_));
    let numerator = if is_labelled { None } else { signal(&f.axes[1]) };
    let si = match kind {
        SpectrumKind::Linear => numerator.map(|(a, u)| (a, u.to_owned())),
        SpectrumKind::Auto => numerator.map(|(a, u)| (a * a, format!("({u})²"))),
        SpectrumKind::PowerDensity => numerator.map(|(a, u)| (a * a, format!("({u})²/Hz"))),
        SpectrumKind::Cross => numerator.zip(signal(&f.axes[2])).map(|((a, u), (b, v))| (a * b, format!("({u})({v})"))),
    };
    let (scale, unit) = match si {
        Some((scale, unit)) => (scale, SpectrumUnit::Si(unit)),
        None => (1.0, SpectrumUnit::AsInFile(label.to_owned())),
    };
    let hertz = match hertz(&f.axes[0], options.frequency_unit.as_ref(), notes) {
        Ok(hertz) => hertz,
        Err(question) => return Some(Err(question)),
    };
    Some(Ok(Spectrum {
        kind,
        response: channel(&End::of(&f.response, Naming::Number)),
        reference: (f.reference.node != 0).then(|| channel(&End::of(&f.reference, Naming::Number))),
        frequencies_hz: points_hz(f, hertz),
        values: f.ordinate.to_complex().into_iter().map(|v| v * scale).collect(),
        unit,
    }))
}
