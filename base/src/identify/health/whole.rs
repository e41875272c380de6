//! Every check that one test allows.

use super::modes::{Shape, pairs};
use super::{
    Finding, Level, SensorGeometry, check_functions, check_geometry, check_identification, check_modes,
    check_rigid_body, check_silent, check_suspension,
};
use crate::data::{FrfSet, Geometry, Place, Sensor, TestMode};
use crate::identify::{Identification, IdentifiedMode, IdentifyError, real_shape};
use retune_linalg::{Complex, DMatrix, DVector};

/// What the checks of a whole test take for granted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HealthOptions {
    /// How many of the lowest modes are rigid-body modes on the suspension.
    pub n_suspension: usize,
    /// Whether a model judges the sensors: their neighbours, a weaker witness, are then not asked.
    pub has_model: bool,
}

/// All findings of one test, worst first.
///
/// * `identification` - modes of the set, when there are any
/// * `geometry` - positions of the points: without them the checks of shapes are left out, and a finding says so
///
/// # Errors
/// A set whose lengths disagree.
pub fn check_test(
    frfs: &FrfSet,
    identification: Option<&Identification>,
    geometry: Option<&Geometry>,
    options: HealthOptions,
) -> Result<Vec<Finding>, IdentifyError> {
    let mut found = check_functions(frfs)?;
    if let Some(identification) = identification {
        // The identification says of missing lines what it did about them.
        found.retain(|f| f.code != "missing-lines");
        found.extend(check_identification(frfs, identification));
        let named: Vec<(&'static str, String)> = found.iter().map(|f| (f.code, f.subject.clone())).collect();
        // The functions and the modes speak of one cause once, and where the functions name another cause than a wrong point or sign, the
        // residues of the modes are of a function that is not what it says.
        let is_told = |f: &Finding| {
            f.code.starts_with("driving-point")
                && named.iter().any(|(code, subject)| {
                    *subject == f.subject
                        && (*code == f.code
                            || matches!(
                                *code,
                                "driving-point-conjugate"
                                    | "driving-point-quantity"
                                    | "driving-point-delay"
                                    | "driving-point-undecided"
                            ))
                })
        };
        found.extend(check_modes(frfs, identification).into_iter().filter(|f| !is_told(f)));
        let (suspension, elastic) = identification.modes.split_at(options.n_suspension.min(identification.modes.len()));
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
        if !options.has_model {
            found.extend(without_place(sensors.len(), frfs.responses.len()));
        }
        if !options.has_model && !sensors.is_empty() && !elastic.is_empty() {
            found.extend(check_geometry(&sensors, &shapes(elastic))?);
        }
        if !sensors.is_empty() && !suspension.is_empty() {
            found.extend(check_rigid_body(&sensors, &shapes(suspension))?);
        }
    }
    found.sort_by_key(|f| std::cmp::Reverse(f.level));
    Ok(found)
}

/// What can be checked of shapes alone, worst first: signs, gains, swaps and dead entries, modes that look alike.
///
/// * `modes` - by ascending frequency; modes without a shape are left out
///
/// # Errors
/// A shape with another number of entries than there are sensors.
pub fn check_shapes(
    sensors: &[Sensor],
    modes: &[TestMode],
    options: HealthOptions,
) -> Result<Vec<Finding>, IdentifyError> {
    let shaped: Vec<(&TestMode, &DVector<Complex<f64>>)> =
        modes.iter().filter_map(|m| Some((m, m.shape.as_ref()?))).collect();
    if let Some((_, wrong)) = shaped.iter().find(|(_, s)| s.len() != sensors.len()) {
        return Err(IdentifyError::Length { what: "a shape", expected: sensors.len(), found: wrong.len() });
    }
    let all: Vec<Shape<'_>> = shaped
        .iter()
        .map(|(m, shape)| Shape {
            hz: m.frequency_hz.value,
            zeta: m.damping_ratio.map_or(f64::NAN, |z| z.value),
            shape,
        })
        .collect();
    let directions: Vec<Option<[f64; 3]>> = sensors.iter().map(|s| Some(s.direction)).collect();
    let mut found = pairs(&all, &directions);
    found.extend(check_silent(sensors, modes));
    let hz: Vec<f64> = modes.iter().map(|m| m.frequency_hz.value).collect();
    let (low, high) = hz.split_at(options.n_suspension.min(hz.len()));
    if !low.is_empty() {
        found.extend(check_suspension(low, high));
    }
    let (rows, placed): (Vec<usize>, Vec<SensorGeometry>) = sensors
        .iter()
        .enumerate()
        .filter(|(_, s)| !s.is_rotation)
        .filter_map(|(i, s)| {
            let (Place::Node { position, .. } | Place::Element { position, .. }) = &s.place;
            Some((i, SensorGeometry { name: s.name.clone(), position: (*position)?, direction: s.direction }))
        })
        .unzip();
    if !options.has_model {
        found.extend(without_place(placed.len(), sensors.len()));
    }
    let (rigid, elastic) =
        shaped.split_at(shaped.iter().take_while(|(m, _)| low.contains(&m.frequency_hz.value)).count());
    let matrix = |list: &[(&TestMode, &DVector<Complex<f64>>)]| {
        let real: Vec<DVector<f64>> = list.iter().map(|(_, s)| real_shape(s)).collect();
        DMatrix::from_fn(rows.len(), real.len(), |i, j| real[j][rows[i]])
    };
    if !options.has_model && !placed.is_empty() && !elastic.is_empty() {
        found.extend(check_geometry(&placed, &matrix(elastic))?);
    }
    if !placed.is_empty() && !rigid.is_empty() {
        found.extend(check_rigid_body(&placed, &matrix(rigid))?);
    }
    found.sort_by_key(|f| std::cmp::Reverse(f.level));
    Ok(found)
}

/// A remark when some channels could not be checked for want of a place.
fn without_place(placed: usize, channels: usize) -> Option<Finding> {
    (placed < channels).then(|| Finding {
        level: Level::Info,
        code: "no-geometry",
        subject: "geometry".to_string(),
        evidence: vec![("channels with place and direction", placed as f64), ("channels", channels as f64)],
        text: "signs, gains and swaps of channels without place or direction were not checked".to_string(),
        remedy: "give the positions of the points with `--geometry` and directions with `--direction`, or a model whose nodes have their names with \
                 `--model`",
    })
}
