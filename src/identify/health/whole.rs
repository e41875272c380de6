//! Every check that one test allows.

use super::{
    Finding, Level, SensorGeometry, check_functions, check_geometry, check_modes, check_rigid_body, check_suspension,
};
use crate::data::{FrfSet, Geometry};
use crate::identify::{Identification, IdentifiedMode, IdentifyError};
use crate::linalg::DMatrix;

/// All findings of one test, worst first.
///
/// * `identification` - modes of the set, when there are any
/// * `geometry` - positions of the points: without them the checks of shapes are left out, and a finding says so
/// * `n_suspension` - how many of the lowest modes are rigid-body modes on the suspension
///
/// # Errors
/// A set whose lengths disagree.
pub fn check_test(
    frfs: &FrfSet,
    identification: Option<&Identification>,
    geometry: Option<&Geometry>,
    n_suspension: usize,
) -> Result<Vec<Finding>, IdentifyError> {
    let mut found = check_functions(frfs)?;
    if let Some(identification) = identification {
        found.extend(check_modes(frfs, identification));
        let (suspension, elastic) = identification.modes.split_at(n_suspension.min(identification.modes.len()));
        if !suspension.is_empty() {
            let hz = |m: &[IdentifiedMode]| m.iter().map(|m| m.frequency_hz.value).collect::<Vec<_>>();
            found.extend(check_suspension(&hz(suspension), &hz(elastic)));
        }
        // Channels without place or direction are left out of the checks of shapes, not the whole check.
        let placed: Vec<(usize, SensorGeometry)> = frfs
            .responses
            .iter()
            .enumerate()
            .filter_map(|(i, c)| {
                let position = geometry?.point(&c.name)?.position_m;
                Some((i, SensorGeometry { name: c.name.clone(), position, direction: c.direction? }))
            })
            .collect();
        let (rows, sensors): (Vec<usize>, Vec<SensorGeometry>) = placed.into_iter().unzip();
        let shapes = |m: &[IdentifiedMode]| DMatrix::from_fn(rows.len(), m.len(), |i, j| m[j].normal_shape[rows[i]]);
        if sensors.len() < frfs.responses.len() {
            found.push(Finding {
                level: Level::Info,
                code: "no-geometry",
                subject: "geometry".to_string(),
                evidence: vec![
                    ("channels with place and direction", sensors.len() as f64),
                    ("channels", frfs.responses.len() as f64),
                ],
                text: "signs, gains and swaps of channels without place or direction were not checked".to_string(),
                remedy: "give the positions of the points with `--geometry`",
            });
        }
        if !sensors.is_empty() && !elastic.is_empty() {
            found.extend(check_geometry(&sensors, &shapes(elastic))?);
        }
        if !sensors.is_empty() && !suspension.is_empty() {
            found.extend(check_rigid_body(&sensors, &shapes(suspension))?);
        }
    }
    found.sort_by_key(|f| std::cmp::Reverse(f.level));
    Ok(found)
}
