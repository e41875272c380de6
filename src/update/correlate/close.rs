//! Close modes that agree as a space and not one by one.

use super::Assessment;
use crate::correlation::{CloseModes, ModeList, assess_close_modes, principal_angles, subspace_mac};
use crate::fault::MIXED_WITHIN;
use crate::linalg::LinalgError;
use crate::objective::Comparison;

/// A MAC that a right model keeps unless its shapes are mixed.
const AGREES: f64 = 0.95;
/// Of what the worst shape lacks alone, the share that it may lack as part of the space.
const LEFT: f64 = 0.25;
/// A mode that agrees belongs to a space if others have a MAC with it that is lower by more than this without that mode.
const HELPS: f64 = 0.005;

/// Groups of paired modes less than 5 % apart of which a MAC is below 0.95 and the space that they span lacks less than a quarter of what the worst
/// shape lacks alone: their shapes are mixtures. Those of one [space](crate::data::TestMode::space) are compared so already.
///
/// # Errors
/// Singular values that cannot be found.
pub fn mixed_modes(comparison: &Comparison<'_>, a: &Assessment) -> Result<Vec<CloseModes>, LinalgError> {
    let (p, modes) = (&a.prediction, &comparison.test().modes);
    let measured: Vec<f64> = modes.iter().map(|m| m.frequency_hz.value).collect();
    let list = |frequencies_hz| ModeList { frequencies_hz, ..ModeList::default() };
    let (model, test) = (list(&p.frequencies_hz), list(&measured));
    let mut paired = p.pairs.clone();
    paired.pairs.retain(|pair| modes[pair.experimental].shape.is_some());
    let groups = assess_close_modes(&p.at_sensors, &model, comparison.shapes(), &test, &paired, MIXED_WITHIN)?;
    let mut found = Vec::new();
    for group in groups.into_iter().filter(|g| g.lowest_mac < AGREES) {
        let mac = |k: usize| p.mac[(group.analytical[k], group.experimental[k])];
        let (wrong, right): (Vec<usize>, Vec<usize>) = (0..group.analytical.len()).partition(|&k| mac(k) < AGREES);
        let shapes = comparison.shapes().select_columns(wrong.iter().map(|&k| &group.experimental[k]));
        let with = |members: &[usize]| {
            let span = p.at_sensors.select_columns(members.iter().map(|&k| &group.analytical[k]));
            Ok::<_, LinalgError>(subspace_mac(&span, &shapes)?.into_iter().fold(1.0, f64::min))
        };
        let mut members: Vec<usize> = (0..group.analytical.len()).collect();
        for k in right {
            let without: Vec<usize> = members.iter().copied().filter(|&m| m != k).collect();
            if with(&without)? > with(&members)? - HELPS {
                members = without;
            }
        }
        let lowest_subspace_mac = with(&members)?;
        if members.len() > 1 && 1.0 - lowest_subspace_mac < LEFT * (1.0 - group.lowest_mac) {
            let of = |list: &[usize]| members.iter().map(|&k| list[k]).collect::<Vec<_>>();
            let (analytical, experimental) = (of(&group.analytical), of(&group.experimental));
            let spans = (p.at_sensors.select_columns(&analytical), comparison.shapes().select_columns(&experimental));
            let angles = principal_angles(&spans.0, &spans.1)?;
            found.push(CloseModes { analytical, experimental, angles, lowest_subspace_mac, ..group });
        }
    }
    Ok(found)
}
