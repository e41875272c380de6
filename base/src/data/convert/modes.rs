//! Datasets 55 and 2414 to modes, and back.

use super::geometry::{found, labels, placed_nodes, si};
use super::units::{note, plain_system, units_at};
use super::{ConvertError, FrfOptions};
use crate::data::uff::{AnalysisData, DataAtNodes, Dataset, Entry, Level, Note, UniversalFile};
use crate::data::{Date, ModalSet, ModeRecord, Point, ShapeChannel};
use crate::dof::Dof;
use retune_linalg::{Complex, DVector};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

const NORMAL_MODE: i64 = 2;
const COMPLEX_FIRST_ORDER: i64 = 3;
const COMPLEX_SECOND_ORDER: i64 = 7;
const DISPLACEMENT: i64 = 8;

/// A mode as it stands in a file.
struct Raw<'f> {
    /// ID lines of its dataset.
    ids: &'f [String; 5],
    frequency_hz: f64,
    damping_ratio: Option<f64>,
    modal_mass: Option<f64>,
    modal_a: Option<Complex<f64>>,
    modal_b: Option<Complex<f64>>,
    /// λ of a complex mode, rad/s.
    pole: Option<Complex<f64>>,
    values: BTreeMap<(i64, Dof), Complex<f64>>,
}

/// Reads the modes of universal files: normal and complex modes of datasets 55 and 2414 at nodes.
///
/// ```text
/// complex modes   λ = σ + iω,  f = |λ| / 2π,  ζ = -σ / |λ|
/// scale           φ in m and rad, so that modal mass, A and B carry m²: SI = file · (unit of force · unit of length)
/// ```
///
/// * `files` - files that share labels of nodes
/// * `options` - where units come from; needed only where displacements stand beside rotations or modal masses are given; and how
///   local axes are read
///
/// Channels whose value is exactly 0 in every mode count as not measured, because a file must fill unused directions
/// with zeros; a note says how many. A hysteretic damping ratio without viscous one counts half. Modes come sorted by
/// frequency. Of two conjugate poles the one with the negative imaginary part is left out, since λ, φ and λ*, φ* are one motion;
/// one without its partner is turned into it. A real pole does not vibrate and is left out.
///
/// # Errors
/// [`ConvertError::Nothing`] without modes, [`ConvertError::Questions`] for a missing unit.
pub fn modes(files: &[&UniversalFile], options: &FrfOptions) -> Result<(ModalSet, Vec<Note>), ConvertError> {
    let mut notes = Vec::new();
    let mut raw = Vec::new();
    let mut stated = None;
    for file in files {
        for (i, dataset) in file.datasets.iter().enumerate() {
            let mode = match dataset {
                Dataset::DataAtNodes(d) => of_55(d, &mut notes),
                Dataset::AnalysisData(d) => of_2414(d, &mut notes),
                _ => None,
            };
            if let Some(mode) = mode {
                if !(mode.frequency_hz.is_finite() && mode.frequency_hz >= 0.0) {
                    let seen = format!("a mode at {} Hz", mode.frequency_hz);
                    notes.push(note(Level::Warning, 55, seen, "no mode has such a frequency; it was left out"));
                    continue;
                }
                stated = stated.or_else(|| units_at(file, i));
                raw.push(mode);
            }
        }
    }
    one_of_each_pair(&mut raw, &mut notes);
    without_copies(&mut raw, &mut notes);
    if raw.is_empty() {
        return Err(ConvertError::Nothing { what: "modes (datasets 55, 2414)", found: found(files) });
    }
    let all: BTreeSet<(i64, Dof)> = raw.iter().flat_map(|m| m.values.keys().copied()).collect();
    let is_zero = |key: &&(i64, Dof)| raw.iter().all(|m| m.values.get(*key).is_none_or(|v| v.norm() == 0.0));
    let unused = all.iter().filter(is_zero).count();
    let used: Vec<(i64, Dof)> = all.iter().filter(|k| !is_zero(k)).copied().collect();
    if unused > 0 {
        let seen = format!("{unused} of {} channels are exactly 0 in every mode", all.len());
        notes.push(note(Level::Info, 55, seen, "they count as not measured"));
    }
    let is_mixed = used.iter().any(|(_, d)| d.is_rotation()) && used.iter().any(|(_, d)| !d.is_rotation());
    let has_mass = raw.iter().any(|m| m.modal_mass.is_some() || m.modal_a.is_some() || m.modal_b.is_some());
    let (length, force) = if is_mixed || has_mass {
        let what = if is_mixed { "displacements beside rotations" } else { "modal masses" };
        let system = plain_system(stated, &options.units, what).map_err(|q| ConvertError::Questions(vec![q]))?;
        (system.length, system.force)
    } else {
        // The scale of a shape is free: no unit is needed.
        (1.0, 1.0)
    };
    let nodes = placed_nodes(files, options.local_axes, &mut notes);
    if nodes.is_empty() {
        notes.push(note(Level::Info, 55, "no nodes in the files", "directions count as along global axes"));
    }
    let channels = used
        .iter()
        .map(|(node, dof)| {
            let axes = nodes.get(node).map_or(Point::GLOBAL, |n| n.axes);
            ShapeChannel { point: node.to_string(), dof: *dof, direction: axes[dof.axis()] }
        })
        .collect();
    let scale = |dof: Dof| if dof.is_rotation() { 1.0 } else { length };
    let missing = Complex::new(f64::NAN, f64::NAN);
    let value = |m: &Raw<'_>, key: &(i64, Dof)| m.values.get(key).map_or(missing, |v| v * scale(key.1));
    let line = line_of_labels(&raw);
    let mut modes: Vec<ModeRecord> = raw
        .iter()
        .map(|m| ModeRecord {
            label: line.map(|line| &m.ids[line]).filter(|id| says_something(id)).cloned(),
            frequency_hz: m.frequency_hz,
            damping_ratio: m.damping_ratio,
            shape: DVector::from_iterator(used.len(), used.iter().map(|key| value(m, key))),
            modal_mass: m.modal_mass.map(|v| v * force * length),
            modal_a: m.modal_a.map(|v| v * force * length),
            modal_b: m.modal_b.map(|v| v * force * length),
        })
        .collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok((ModalSet { channels, modes }, notes))
}

/// Whether an ID line names something.
fn says_something(id: &str) -> bool {
    !matches!(id, "" | "NONE")
}

/// The first ID line that tells the modes apart, which is what a label is for; lines that begin with a day tell when they were stored. The line of one
/// mode alone is the first; none where all modes say the same on every line, as the name of the test.
fn line_of_labels(raw: &[Raw<'_>]) -> Option<usize> {
    if raw.len() == 1 {
        return Some(0);
    }
    let is_day = |line: usize| raw.iter().any(|m| Date::of_record(&m.ids[line]).is_some());
    (0..5).find(|&line| raw.iter().any(|m| m.ids[line] != raw[0].ids[line]) && !is_day(line))
}

/// Leaves one of several datasets that hold the same mode: an export that was done twice, or in two formats.
fn without_copies(raw: &mut Vec<Raw<'_>>, notes: &mut Vec<Note>) {
    // A copy has the same numbers to the last digit; modes that are only close have not.
    let is_copy = |a: &Raw<'_>, b: &Raw<'_>| a.frequency_hz == b.frequency_hz && a.values == b.values;
    let n = raw.len();
    let mut kept: Vec<Raw<'_>> = Vec::with_capacity(n);
    for mode in raw.drain(..) {
        if mode.values.is_empty() || !kept.iter().any(|other| is_copy(other, &mode)) {
            kept.push(mode);
        }
    }
    *raw = kept;
    let n_copies = n - raw.len();
    if n_copies > 0 {
        let seen = if n_copies == 1 {
            "a mode that stands there".to_string()
        } else {
            format!("{n_copies} modes that stand there")
        };
        notes.push(note(
            Level::Info,
            55,
            seen + " a second time, with the same frequency and shape",
            "each counts once",
        ));
    }
}

/// Two poles nearer than this share of their modulus are the same number, written with six digits.
const SAME_POLE: f64 = 1e-4;

/// Leaves one mode for each pair of conjugate poles, with a positive imaginary part, and none for a real pole.
fn one_of_each_pair(raw: &mut Vec<Raw<'_>>, notes: &mut Vec<Note>) {
    let is_real = |m: &Raw<'_>| m.pole.is_some_and(|p| p.im == 0.0 && p.re != 0.0);
    let n_real = raw.iter().filter(|m| is_real(m)).count();
    raw.retain(|m| !is_real(m));
    // Each partner once: the poles of two modes at one frequency are two pairs.
    let mut has_partner = vec![false; raw.len()];
    let mut is_copy = vec![false; raw.len()];
    for k in 0..raw.len() {
        let Some(pole) = raw[k].pole.filter(|p| p.im < 0.0) else { continue };
        let distance = |j: &usize| raw[*j].pole.map_or(f64::INFINITY, |p| (p - pole.conj()).norm());
        let nearest = (0..raw.len()).filter(|j| !has_partner[*j]).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(j) = nearest.filter(|j| distance(j) <= SAME_POLE * pole.norm()) {
            (has_partner[j], is_copy[k]) = (true, true);
        }
    }
    let n_copies = is_copy.iter().filter(|c| **c).count();
    let mut is_copy = is_copy.into_iter();
    raw.retain(|_| !is_copy.next().unwrap_or(false));
    let mut n_turned = 0;
    for m in raw.iter_mut().filter(|m| m.pole.is_some_and(|p| p.im < 0.0)) {
        n_turned += 1;
        m.pole = m.pole.map(|p| p.conj());
        (m.modal_a, m.modal_b) = (m.modal_a.map(|v| v.conj()), m.modal_b.map(|v| v.conj()));
        m.values.values_mut().for_each(|v| *v = v.conj());
    }
    let counted = |n: usize, one: &str, many: &str| if n == 1 { format!("1 {one}") } else { format!("{n} {many}") };
    if n_copies > 0 {
        let seen =
            counted(n_copies, "pole that is the conjugate of another", "poles that are the conjugates of others");
        notes.push(note(Level::Info, 55, seen, "each pair is one mode"));
    }
    if n_turned > 0 {
        let seen = counted(n_turned, "pole with a negative imaginary part", "poles with a negative imaginary part");
        notes.push(note(Level::Info, 55, seen, "its conjugate, the same motion, was read instead"));
    }
    if n_real > 0 {
        let seen = counted(n_real, "real pole", "real poles");
        notes.push(note(Level::Warning, 55, seen, "a motion that does not vibrate is not a mode; left out"));
    }
}

fn of_55<'f>(d: &'f DataAtNodes, notes: &mut Vec<Note>) -> Option<Raw<'f>> {
    let r = |i: usize| d.reals.get(i).copied().unwrap_or(0.0);
    let reals = match d.analysis_type {
        NORMAL_MODE => Parameters::Normal { frequency_hz: r(0), mass: r(1), viscous: r(2), hysteretic: r(3) },
        COMPLEX_FIRST_ORDER | COMPLEX_SECOND_ORDER => Parameters::Complex([r(0), r(1), r(2), r(3), r(4), r(5)]),
        _ => return None,
    };
    let is_complex = matches!(d.data_type, 5 | 6);
    raw_mode(55, &d.ids, reals, (d.characteristic, d.specific_type, is_complex), &d.entries, notes)
}

fn of_2414<'f>(d: &'f AnalysisData, notes: &mut Vec<Note>) -> Option<Raw<'f>> {
    let r = &d.reals;
    let reals = match d.analysis_type {
        NORMAL_MODE => Parameters::Normal { frequency_hz: r[1], mass: r[3], viscous: r[4], hysteretic: r[5] },
        COMPLEX_FIRST_ORDER | COMPLEX_SECOND_ORDER => Parameters::Complex([r[6], r[7], r[8], r[9], r[10], r[11]]),
        _ => return None,
    };
    if d.location != 1 {
        notes.push(note(Level::Warning, 2414, "modes that are not given at nodes", "they were left out"));
        return None;
    }
    let is_complex = matches!(d.data_type, 5 | 6);
    raw_mode(2414, &d.ids, reals, (d.characteristic, d.result_type, is_complex), &d.entries, notes)
}

#[derive(Clone, Copy)]
enum Parameters {
    Normal { frequency_hz: f64, mass: f64, viscous: f64, hysteretic: f64 },
    Complex([f64; 6]),
}

fn raw_mode<'f>(
    number: i64,
    ids: &'f [String; 5],
    parameters: Parameters,
    (characteristic, data_type, is_complex): (i64, i64, bool),
    entries: &[Entry],
    notes: &mut Vec<Note>,
) -> Option<Raw<'f>> {
    let dofs: &[Dof] = match characteristic {
        2 => &Dof::ALL[..3],
        3 => &Dof::ALL,
        other => {
            let seen = format!("a mode with data characteristic {other}");
            notes.push(note(Level::Warning, number, seen, "only 2 and 3 are displacements; it was left out"));
            return None;
        }
    };
    if !matches!(data_type, DISPLACEMENT | 0 | 11 | 12) {
        let seen = format!("a mode of specific data type {data_type}");
        notes.push(note(Level::Warning, number, seen, "only motions are shapes; it was left out"));
        return None;
    }
    let mut values = BTreeMap::new();
    for entry in entries {
        let complex: Vec<Complex<f64>> = if is_complex {
            entry.values.chunks_exact(2).map(|v| Complex::new(v[0], v[1])).collect()
        } else {
            entry.values.iter().map(|v| Complex::new(*v, 0.0)).collect()
        };
        values.extend(dofs.iter().zip(complex).map(|(dof, v)| ((entry.head[0], *dof), v)));
    }
    let given = |v: f64| (v != 0.0).then_some(v);
    Some(match parameters {
        Parameters::Normal { frequency_hz, mass, viscous, hysteretic } => {
            if viscous == 0.0 && hysteretic != 0.0 {
                notes.push(note(Level::Info, number, "a hysteretic damping ratio", "half of it is the viscous one"));
            }
            let damping_ratio = given(viscous).or(given(hysteretic).map(|eta| 0.5 * eta));
            let (modal_a, modal_b) = (None, None);
            Raw { ids, frequency_hz, damping_ratio, modal_mass: given(mass), modal_a, modal_b, pole: None, values }
        }
        Parameters::Complex([re, im, a_re, a_im, b_re, b_im]) => {
            let omega = re.hypot(im);
            let given = |v: Complex<f64>| (v.norm() != 0.0).then_some(v);
            Raw {
                ids,
                frequency_hz: omega / TAU,
                damping_ratio: (omega > 0.0).then_some(-re / omega),
                modal_mass: None,
                modal_a: given(Complex::new(a_re, a_im)),
                modal_b: given(Complex::new(b_re, b_im)),
                pole: Some(Complex::new(re, im)),
                values,
            }
        }
    })
}

/// Writes modes as datasets 164 and 55, in SI: normal modes where frequency and damping suffice, complex modes where
/// the shape is complex or modal A is given.
///
/// Entries that were not measured are written as 0, for the format knows no other way; so are unused directions. Shapes
/// have six digits, a limit of the format.
pub fn modes_file(set: &ModalSet) -> UniversalFile {
    let labels = labels(set.channels.iter().map(|c| c.point.as_str()));
    let has_rotations = set.channels.iter().any(|c| c.dof.is_rotation());
    let width = if has_rotations { 6 } else { 3 };
    let mut datasets = vec![si()];
    for (mode, number) in set.modes.iter().zip(1..) {
        let is_complex = mode.modal_a.is_some() || mode.shape.iter().any(|v| v.im != 0.0 && !v.im.is_nan());
        let per_value = if is_complex { 2 } else { 1 };
        let mut nodes: BTreeMap<i64, Vec<f64>> = BTreeMap::new();
        for (channel, value) in set.channels.iter().zip(mode.shape.iter()) {
            let values = nodes.entry(labels[channel.point.as_str()]).or_insert_with(|| vec![0.0; width * per_value]);
            if value.re.is_nan() {
                continue;
            }
            values[channel.dof as usize * per_value] = value.re;
            if is_complex {
                values[channel.dof as usize * per_value + 1] = value.im;
            }
        }
        let zeta = mode.damping_ratio.unwrap_or(0.0);
        let omega = TAU * mode.frequency_hz;
        let reals = if is_complex {
            let zero = Complex::new(0.0, 0.0);
            let (a, b) = (mode.modal_a.unwrap_or(zero), mode.modal_b.unwrap_or(zero));
            vec![-zeta * omega, omega * (1.0 - zeta * zeta).max(0.0).sqrt(), a.re, a.im, b.re, b.im]
        } else {
            vec![mode.frequency_hz, mode.modal_mass.unwrap_or(0.0), zeta, 0.0]
        };
        let id = mode.label.clone().unwrap_or_else(|| "NONE".to_owned());
        datasets.push(Dataset::DataAtNodes(DataAtNodes {
            ids: std::array::from_fn(|i| if i == 0 { id.clone() } else { "NONE".to_owned() }),
            model_type: 1,
            analysis_type: if is_complex { COMPLEX_FIRST_ORDER } else { NORMAL_MODE },
            characteristic: if has_rotations { 3 } else { 2 },
            specific_type: DISPLACEMENT,
            data_type: if is_complex { 5 } else { 2 },
            values_per_node: width as i64,
            integers: vec![0, number],
            reals,
            entries: nodes.into_iter().map(|(node, values)| Entry { head: vec![node], values }).collect(),
        }));
    }
    UniversalFile { datasets }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::convert::UnitsFrom;

    fn channel(point: &str, dof: Dof) -> ShapeChannel {
        ShapeChannel { point: point.to_owned(), dof, direction: Point::GLOBAL[dof.axis()] }
    }

    #[test]
    fn modes_come_back_from_a_universal_file() {
        let mode = |f: f64, shape: Vec<Complex<f64>>, a: Option<Complex<f64>>| ModeRecord {
            label: Some(format!("bending at {f}")),
            frequency_hz: f,
            damping_ratio: Some(0.02),
            shape: DVector::from_vec(shape),
            modal_mass: if a.is_some() { None } else { Some(0.25) },
            modal_a: a,
            modal_b: None,
        };
        let real = [1.0, -0.5, 0.125].map(|x| Complex::new(x, 0.0)).to_vec();
        let complex = vec![Complex::new(1.0, 0.25), Complex::new(-0.5, 0.5), Complex::new(0.0, -1.0)];
        let set = ModalSet {
            channels: vec![channel("1", Dof::Uz), channel("2", Dof::Uz), channel("2", Dof::Rx)],
            modes: vec![mode(5.5, real, None), mode(8.25, complex, Some(Complex::new(0.0, 2.0)))],
        };
        let bytes = crate::data::uff::write(&modes_file(&set)).unwrap().0;
        let file = crate::data::uff::read(&bytes).unwrap().0;
        let (back, notes) = modes(&[&file], &FrfOptions::default()).unwrap();
        assert_eq!(notes.len(), 2, "{notes:?}"); // unused directions; no nodes
        assert_eq!(back.channels, set.channels);
        assert_eq!(back.modes[0], set.modes[0]);
        // Eigenvalues are written with at least seven digits.
        assert!((back.modes[1].frequency_hz / 8.25 - 1.0).abs() < 1.0e-7);
        assert!((back.modes[1].damping_ratio.unwrap() / 0.02 - 1.0).abs() < 1.0e-6);
        assert_eq!((&back.modes[1].shape, back.modes[1].modal_a), (&set.modes[1].shape, set.modes[1].modal_a));
    }

    /// Labels stand on the first line that tells modes apart; a line with the name of the test or with the day is none.
    #[test]
    fn labels_are_the_line_that_tells_modes_apart() {
        let mode = |ids: [&str; 5], f: f64| {
            Dataset::DataAtNodes(DataAtNodes {
                ids: ids.map(str::to_owned),
                model_type: 1,
                analysis_type: NORMAL_MODE,
                characteristic: 2,
                specific_type: DISPLACEMENT,
                data_type: 2,
                values_per_node: 3,
                integers: vec![0, 1],
                reals: vec![f, 0.0, 0.0, 0.0],
                entries: vec![Entry { head: vec![1], values: vec![0.0, 0.0, 1.0] }],
            })
        };
        let labels = |ids: &[[&str; 5]]| {
            let file =
                UniversalFile { datasets: ids.iter().zip(3..).map(|(ids, hz)| mode(*ids, f64::from(hz))).collect() };
            let (set, _) = modes(&[&file], &FrfOptions::default()).unwrap();
            set.modes.into_iter().map(|m| m.label).collect::<Vec<_>>()
        };
        let none = "NONE";
        let day = "22-MAY-14 10:00:0";
        let two = [["rack", none, &format!("{day}1"), "bending", none], ["rack", none, &format!("{day}2"), none, none]];
        assert_eq!(labels(&two), [Some("bending".to_owned()), None]);
        assert_eq!(labels(&[["rack", none, day, none, none]; 2]), [None, None]);
        assert_eq!(labels(&two[..1]), [Some("rack".to_owned())]);
    }

    /// What was exported twice is one mode; close modes of one shape at other frequencies, or of other shapes at one, are two.
    #[test]
    fn a_mode_that_stands_twice_counts_once() {
        let record = |f: f64, z: f64| ModeRecord {
            label: None,
            frequency_hz: f,
            damping_ratio: None,
            shape: DVector::from_vec([1.0, z].map(|x| Complex::new(x, 0.0)).to_vec()),
            modal_mass: None,
            modal_a: None,
            modal_b: None,
        };
        let channels = vec![channel("1", Dof::Uz), channel("2", Dof::Uz)];
        let count = |all: &[(f64, f64)]| {
            let set = ModalSet { channels: channels.clone(), modes: all.iter().map(|m| record(m.0, m.1)).collect() };
            let (back, notes) = modes(&[&modes_file(&set)], &FrfOptions::default()).unwrap();
            (back.modes.len(), notes.iter().filter(|n| n.seen.contains("a second time")).count())
        };
        assert_eq!(count(&[(5.0, 0.5), (7.0, -0.5), (5.0, 0.5), (7.0, -0.5)]), (2, 1));
        assert_eq!(count(&[(5.0, 0.5), (5.01, 0.5), (5.0, 0.52)]), (3, 0));
    }

    #[test]
    fn units_matter_for_rotations_beside_displacements_and_for_modal_mass() {
        // A point mass of 2 kg on a lever: 500 mm displacement and 1 rad; φᵀMφ = 2 (0.5)² = 0.5 kg m².
        let set = ModalSet {
            channels: vec![channel("1", Dof::Ux), channel("1", Dof::Rz)],
            modes: vec![ModeRecord {
                label: None,
                frequency_hz: 3.0,
                damping_ratio: None,
                shape: DVector::from_vec(vec![Complex::new(500.0, 0.0), Complex::new(1.0, 0.0)]),
                // In mm and N the unit of mass is a tonne: 0.002 t (500 mm)² = 500 t mm².
                modal_mass: Some(500.0),
                modal_a: None,
                modal_b: None,
            }],
        };
        let mut file = modes_file(&set);
        file.datasets.remove(0);
        let error = modes(&[&file], &FrfOptions::default()).unwrap_err();
        assert!(matches!(error, ConvertError::Questions(_)));
        let mm = crate::data::convert::UnitSystem::from_name("mm-N-s").unwrap();
        let options = FrfOptions { units: UnitsFrom::System(mm), ..FrfOptions::default() };
        let (si, _) = modes(&[&file], &options).unwrap();
        assert_eq!((si.modes[0].shape[0].re, si.modes[0].shape[1].re), (0.5, 1.0));
        assert!((si.modes[0].modal_mass.unwrap() - 0.5).abs() < 1.0e-15);
    }

    /// λ and λ* with φ and φ* are one mode; a negative imaginary part alone is the other half; a real pole is none. Two modes at one
    /// frequency are two pairs.
    #[test]
    fn conjugate_poles_are_one_mode() {
        let pole = |re: f64, im: f64, number: i64| {
            Dataset::DataAtNodes(DataAtNodes {
                ids: std::array::from_fn(|_| "NONE".to_owned()),
                model_type: 1,
                analysis_type: COMPLEX_FIRST_ORDER,
                characteristic: 2,
                specific_type: DISPLACEMENT,
                data_type: 5,
                values_per_node: 3,
                integers: vec![0, number],
                reals: vec![re, im, 0.0, im.signum(), 0.0, 0.0],
                entries: vec![Entry { head: vec![1], values: vec![0.0, 0.0, 0.0, 0.0, 1.0, 0.5 * im.signum()] }],
            })
        };
        let file = |poles: &[(f64, f64)]| UniversalFile {
            datasets: poles.iter().zip(1..).map(|(p, k)| pole(p.0, p.1, k)).collect(),
        };
        let si = crate::data::convert::UnitSystem::from_name("SI").unwrap();
        let options = FrfOptions { units: UnitsFrom::System(si), ..FrfOptions::default() };
        let read = |poles: &[(f64, f64)]| modes(&[&file(poles)], &options).unwrap();
        let (set, notes) = read(&[(-1.0, 100.0), (-1.0, -100.000_01), (-2.0, -300.0), (-50.0, 0.0), (3.0, 400.0)]);
        assert_eq!(set.modes.len(), 3);
        assert_eq!(notes.iter().filter(|n| n.seen.contains("pole")).count(), 3, "{notes:?}");
        for m in &set.modes {
            assert!((m.shape[0].im, m.modal_a.unwrap().im) == (0.5, 1.0), "{m:?}");
        }
        assert!(set.modes[2].damping_ratio.unwrap() < 0.0);
        let (set, _) = read(&[(-1.0, 100.0), (-1.0, -100.0), (-1.0, 100.001), (-1.0, -100.001)]);
        assert_eq!(set.modes.len(), 2);
        // What a test file could not hold is left out of it.
        let sd = crate::data::RelativeSd { frequency: 0.01, damping: 0.1, shape: 0.01 };
        let (set, _) = read(&[(-1.0, 100.0), (3.0, 400.0)]);
        let test = set.test_modes(&crate::data::Origin::Measured(String::new()), sd);
        assert!(test[0].damping_ratio.is_some() && test[1].damping_ratio.is_none());
    }

    #[test]
    fn the_sample_modes_are_read() {
        let Some(folder) = crate::data::shared_data("uff_samples") else { return };
        let open = |name: &str| crate::data::uff::read(&std::fs::read(folder.join(name)).unwrap()).unwrap().0;
        let (set, _) = modes(&[&open("uff55_translation.uff")], &FrfOptions::default()).unwrap();
        let frequencies: Vec<f64> = set.modes.iter().map(|m| m.frequency_hz).collect();
        assert_eq!((frequencies, set.channels.len()), (vec![10.0, 12.0, 13.0], 12));
        let (set, notes) = modes(&[&open("uff55_translation_rotation.uff")], &FrfOptions::default()).unwrap();
        assert_eq!((set.modes[0].frequency_hz, set.channels.len()), (97.013, 129));
        assert!(notes[0].seen.contains("129 of 258"), "{}", notes[0]);
    }
}
