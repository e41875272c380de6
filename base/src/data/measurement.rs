//! Measurement files of any kind, recognised by their content, as one set of functions with their geometry.
//!
//! | file | recognised by |
//! |---|---|
//! | universal file | a line `    -1` |
//! | table of functions | a column `frequency_hz`, `Frequency [Hz]`, ... |
//! | table of points | the columns `point`, `x`, `y`, `z` |
//! | table of shapes | the column `point`, and columns whose names hold a frequency, such as `bending 7.9 Hz` |
//! | punch file of Nastran or OptiStruct | `$TITLE`, `$EIGENVECTOR`: real modes, computed |
//! | OpenModal export | a folder with `measurements_index.csv` |
//! | NumPy arrays | `\x93NUMPY`, each named as its file; or an archive of them, `PK`: functions or modes, see below |
//! | MATLAB file | `MATLAB`, or the header of version 4: functions or modes, see below |
//! | LabVIEW measurement | `LabVIEW Measurement`: spectra only |
//!
//! Several universal files and OpenModal folders make one set; of tables and arrays there can be one set only. Of arrays, a vector
//! whose name says frequency belongs with a complex array of functions, (lines x responses) in either order, or with shapes, (points x
//! modes) in either order; [`Roles`] name them where their names do not.

mod arrays;
mod error;
mod labview;
mod words;

pub use arrays::Roles;
pub use error::MeasurementError;
pub use words::Answers;

use super::convert::{self, ConvertError, FrfOptions, Question, UnitsFrom};
use super::csv::{self, CsvError, CsvFrfOptions, ShapeTable, openmodal, read_frfs, read_points, read_shapes};
use super::date::{self, Date};
use super::file::read_file;
use super::uff::{Dataset, UniversalFile};
use super::{
    FrfSet, Geometry, ModalSet, ModeRecord, Point, ShapeChannel, Spectrum, lvm, mat, npy, npz, punch, skew, uff,
};
use crate::dof::Dof;
use arrays::{ModeTable, Variable, Workspace};
use labview::{is_negative, says_decibel, spectrum_of};
use retune_linalg::DVector;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Answers to what files may leave open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasurementOptions {
    /// Units, quantity, duplicates.
    pub frf: FrfOptions,
    /// The unit of the functions of a table without a row of units, such as `m/s2/N`.
    pub unit: Option<String>,
    /// The unit of lengths of the geometry, where it is not that of the functions.
    pub geometry_units: Option<UnitsFrom>,
    /// Direction of channels that do not know theirs: a unit vector in the axes of the geometry.
    pub direction: Option<[f64; 3]>,
    /// What variables of files of arrays are, where their names do not say it.
    pub variables: Roles,
}

/// What measurement files hold.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurements {
    /// Frequency response functions.
    pub frfs: Option<FrfSet>,
    /// Spectra that are not frequency response functions.
    pub spectra: Vec<Spectrum>,
    /// Modes that the files themselves hold: shapes at points.
    pub modes: Option<ModalSet>,
    /// Geometry, when the files have one with a known unit.
    pub geometry: Option<Geometry>,
    /// What was odd or assumed, each with its file.
    pub notes: Vec<(PathBuf, String)>,
    /// Whether a file says of itself that it was computed.
    pub is_synthetic: bool,
    /// The first day on which they were recorded, where universal files say it.
    pub date: Option<Date>,
    /// σ of an exponential window exp(-σ t) that the files say was laid over the signals (dataset 1858), 1/s.
    pub exponential_window: Option<f64>,
    /// Whether the functions were written for exp(-iωt), and their imaginary parts have been reversed since they were read.
    pub is_time_reversed: bool,
}

/// Files larger than this are not read: 2 GiB.
const LARGEST: u64 = 2 << 30;

/// What one path holds.
enum Content {
    Universal(UniversalFile),
    Frfs(FrfSet),
    Points(Vec<Point>),
    Arrays(Workspace),
    Shapes(ShapeTable),
    Spectra(Vec<Spectrum>),
}

/// How the bytes of a file are got: its path, and how many bytes it may have.
pub type Open<'a> = dyn FnMut(&Path, u64) -> std::io::Result<Vec<u8>> + 'a;

/// Reads measurement files.
///
/// * `files` - functions, spectra, and geometry where the same files hold it
/// * `geometry` - a file for the geometry alone, which then must be usable
///
/// # Errors
/// The first file that cannot be read; [`ConvertError::Questions`] with everything the user must state.
pub fn read_measurements(
    files: &[PathBuf],
    geometry: Option<&Path>,
    options: &MeasurementOptions,
) -> Result<Measurements, MeasurementError> {
    read_measurements_by(&mut read_file, files, geometry, options)
}

/// As [`read_measurements`], with bytes got in a way of the caller's: one who keeps account of what was read.
///
/// # Errors
/// As [`read_measurements`].
pub fn read_measurements_by(
    open: &mut Open<'_>,
    files: &[PathBuf],
    geometry: Option<&Path>,
    options: &MeasurementOptions,
) -> Result<Measurements, MeasurementError> {
    let mut found = Measurements::default();
    let mut universal: Vec<UniversalFile> = Vec::new();
    let mut arrays = Workspace::default();
    let mut has_arrays = false;
    let mut tables: Vec<ModeTable> = Vec::new();
    let mut points: Vec<Point> = Vec::new();
    let mut set: Option<FrfSet> = None;
    for path in files {
        match content(open, path, options, &mut found)? {
            Content::Universal(file) => universal.push(file),
            Content::Frfs(frfs) if set.is_none() => set = Some(frfs),
            Content::Points(list) => points.extend(list),
            // A file that is complete stands for itself; what others hold belongs together.
            Content::Arrays(own) => match own.read(options)? {
                Some(read) => take(read, path, &mut found, &mut set, &mut tables)?,
                None => {
                    has_arrays = true;
                    arrays.extend(own);
                }
            },
            Content::Shapes(table) if found.modes.is_none() => {
                points.extend(table.points);
                found.modes = Some(table.modes);
            }
            Content::Frfs(_) | Content::Shapes(_) => {
                return Err(MeasurementError::SecondSet { path: path.display().to_string() });
            }
            Content::Spectra(list) => found.spectra.extend(list),
        }
    }
    if has_arrays {
        let read = arrays.read(options)?.ok_or_else(|| arrays.question())?;
        take(read, Path::new("NumPy arrays"), &mut found, &mut set, &mut tables)?;
    }
    if let (Some(unit), None, false) = (&options.unit, &set, universal.is_empty()) {
        return Err(ConvertError::Contradiction {
            option: "unit",
            wanted: unit.clone(),
            said: "the unit of each function itself, for it is not a table".to_string(),
            remedy: "the units of universal files are answered by `--units`".to_string(),
        }
        .into());
    }
    if !tables.is_empty() {
        if found.modes.is_some() {
            return Err(MeasurementError::SecondSet { path: "arrays of modes".to_string() });
        }
        found.modes = Some(of_tables(tables, options.direction)?);
    }
    let references: Vec<&UniversalFile> = universal.iter().collect();
    let has_functions = universal.iter().any(|f| f.datasets.iter().any(|d| matches!(d, Dataset::Function(_))));
    if has_functions {
        match convert::frfs(&references, &options.frf) {
            Ok(import) => {
                if set.is_some() {
                    return Err(MeasurementError::SecondSet { path: "a universal file".to_string() });
                }
                found.spectra.extend(import.spectra);
                found.notes.extend(import.notes.iter().map(|n| (PathBuf::new(), n.to_string())));
                set = Some(import.frfs);
            }
            // Spectra alone are a result.
            Err(e @ ConvertError::Nothing { .. }) => {
                let (spectra, notes) = convert::spectra(&references, &options.frf)?;
                found.spectra.extend(spectra);
                found.notes.extend(notes.iter().map(|n| (PathBuf::new(), n.to_string())));
                if set.is_none() && found.spectra.is_empty() {
                    return Err(e.into());
                }
            }
            Err(e) => return Err(e.into()),
        }
    }
    match convert::modes(&references, &options.frf) {
        Ok((modes, notes)) => {
            found.notes.extend(notes.iter().map(|n| (PathBuf::new(), n.to_string())));
            found.modes.get_or_insert(modes);
        }
        Err(ConvertError::Nothing { .. }) => {}
        Err(e) if set.is_some() => found.notes.push((PathBuf::new(), format!("the modes are left out: {e}"))),
        Err(e) => return Err(e.into()),
    }
    if let Some(modes) = &mut found.modes {
        found.notes.extend(skew::combine_modes(modes).map(|text| (PathBuf::new(), text)));
    }
    found.date = date::of_universal_files(&universal);
    found.exponential_window = exponential_window(&universal, &mut found.notes);
    let names = own_names(&universal);
    if let Some(set) = &mut set {
        rename(set.references.iter_mut().chain(&mut set.responses).map(|c| &mut c.name), &names);
    }
    if let (Some(set), Some(direction)) = (&mut set, options.direction) {
        let mut is_used = false;
        for channel in set.references.iter_mut().chain(&mut set.responses) {
            is_used |= channel.direction.is_none();
            channel.direction.get_or_insert(direction);
        }
        if !is_used {
            let text = "every channel states its own direction: the one that you give (`--direction`) is not used";
            found.notes.push((PathBuf::new(), text.to_string()));
        }
    }
    if let Some(set) = &mut set {
        found.notes.extend(skew::combine_functions(set).map(|text| (PathBuf::new(), text)));
        let dropped = set.drop_empty_lines();
        if !dropped.is_empty() {
            found.notes.push((PathBuf::new(), super::frf::left_out(&dropped)));
        }
    }
    found.frfs = set;
    let units = options.geometry_units.as_ref().unwrap_or(&options.frf.units);
    let mut of_geometry = Measurements::default();
    found.geometry = match geometry {
        Some(path) => Some(match content(open, path, options, &mut of_geometry)? {
            Content::Universal(file) => {
                let (geometry, notes) = convert::geometry(&[&file], units, options.frf.local_axes)?;
                of_geometry.notes.extend(notes.iter().map(|n| (path.to_path_buf(), n.to_string())));
                geometry
            }
            Content::Points(points) => Geometry { points, lines: Vec::new() },
            _ => {
                let hint = "; a geometry is a universal file with nodes, or a table `point,x,y,z`".to_string();
                return Err(MeasurementError::Unknown { path: path.display().to_string(), hint });
            }
        }),
        None if !points.is_empty() => Some(Geometry { points, lines: Vec::new() }),
        None => match convert::geometry(&references, units, options.frf.local_axes) {
            Ok((geometry, notes)) => {
                found.notes.extend(notes.iter().map(|n| (PathBuf::new(), n.to_string())));
                Some(geometry)
            }
            Err(ConvertError::Nothing { .. }) => None,
            Err(e) => {
                found.notes.push((PathBuf::new(), format!("the geometry is left out: {e}")));
                None
            }
        },
    };
    if let Some(geometry) = &mut found.geometry {
        rename(geometry.points.iter_mut().map(|p| &mut p.name), &names);
    }
    found.notes.append(&mut of_geometry.notes);
    // Functions, modes and geometry look at the same nodes.
    let mut said = BTreeSet::new();
    found.notes.retain(|note| said.insert(note.clone()));
    Ok(found)
}

/// The damping factor of the exponential window, where the files state one.
fn exponential_window(files: &[UniversalFile], notes: &mut Vec<(PathBuf, String)>) -> Option<f64> {
    let rates = files.iter().flat_map(|f| &f.datasets).filter_map(|d| match d {
        Dataset::Qualifiers(q) => q.exponential_window(),
        _ => None,
    });
    let (least, most) = rates.fold((f64::INFINITY, 0.0_f64), |(a, b), r| (a.min(r), b.max(r)));
    if most <= 0.0 {
        return None;
    }
    if most / least > 1.0 + 1e-6 {
        let text = format!(
            "dataset 1858 states exponential windows with damping factors from {least} to {most} 1/s: none is taken out"
        );
        notes.push((PathBuf::new(), text));
        return None;
    }
    Some(most)
}

/// Names behind the labels of nodes, in files that this crate wrote: there the entity of a function is the name of its point.
fn own_names(files: &[UniversalFile]) -> BTreeMap<String, String> {
    let functions = files.iter().flat_map(|f| &f.datasets).filter_map(|d| match d {
        Dataset::Function(f) if f.ids[0] == "written by retune" => Some(f),
        _ => None,
    });
    functions
        .flat_map(|f| [&f.response, &f.reference])
        .filter(|e| e.node != 0 && !matches!(e.name.as_str(), "" | "NONE"))
        .map(|e| (e.node.to_string(), e.name.clone()))
        .collect()
}

fn rename<'a>(list: impl Iterator<Item = &'a mut String>, names: &BTreeMap<String, String>) {
    for name in list {
        if let Some(own) = names.get(name) {
            name.clone_from(own);
        }
    }
}

fn content(
    open: &mut Open<'_>,
    path: &Path,
    options: &MeasurementOptions,
    found: &mut Measurements,
) -> Result<Content, MeasurementError> {
    let shown = || path.display().to_string();
    let fail = |reason: String| MeasurementError::File { path: shown(), reason };
    if path.is_dir() {
        let file = openmodal::read_by(open, path).map_err(|source| MeasurementError::Csv { path: shown(), source })?;
        return Ok(Content::Universal(file));
    }
    let bytes = open(path, LARGEST).map_err(|e| fail(e.to_string()))?;
    if bytes.starts_with(b"\x93NUMPY") {
        let array = npy::read(&bytes).map_err(|source| MeasurementError::Npy { path: shown(), source })?;
        let name = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let variables = vec![Variable { name, array, is_matlab: false }];
        return Ok(Content::Arrays(Workspace { variables, others: Vec::new() }));
    }
    if npz::is_zip(&bytes) {
        let list = npz::read(&bytes).map_err(|source| MeasurementError::Npz { path: shown(), source })?;
        let variables = list.into_iter().map(|(name, array)| Variable { name, array, is_matlab: false }).collect();
        return Ok(Content::Arrays(Workspace { variables, others: Vec::new() }));
    }
    if bytes.starts_with(b"LabVIEW Measurement") {
        let channels = lvm::read(&bytes).map_err(|source| MeasurementError::Lvm { path: shown(), source })?;
        found.notes.push((path.to_path_buf(), "x is taken for frequencies in Hz; the header does not say".to_string()));
        let is_time = |c: &&lvm::LvmChannel| {
            let name = c.name.to_lowercase();
            c.x_dimension.eq_ignore_ascii_case("time") && !["fft", "spectr", "psd"].iter().any(|w| name.contains(w))
        };
        if let Some(c) = channels.iter().find(is_time) {
            return Err(MeasurementError::OverTime { path: shown(), channel: c.name.clone() });
        }
        for c in channels.iter().filter(|c| is_negative(c) && !says_decibel(&c.y_unit)) {
            let text = format!(
                "channel `{}` has the unit `{}` but only negative values: they are taken for decibels of it",
                c.name, c.y_unit
            );
            found.notes.push((path.to_path_buf(), text));
        }
        return Ok(Content::Spectra(channels.into_iter().map(spectrum_of).collect()));
    }
    if mat::is_mat(&bytes) {
        let held = mat::read(&bytes).map_err(|source| MeasurementError::Mat { path: shown(), source })?;
        found.notes.extend(held.notes.into_iter().map(|n| (path.to_path_buf(), n)));
        return Ok(Content::Arrays(arrays::of_matlab(held.variables)));
    }
    if punch::is_punch(&bytes) {
        let (file, notes) = punch::read(&bytes).map_err(|source| MeasurementError::Punch { path: shown(), source })?;
        found.notes.extend(notes.into_iter().map(|n| (path.to_path_buf(), n)));
        found.is_synthetic = true;
        return Ok(Content::Universal(file));
    }
    let names = csv::names_of(&bytes);
    let of_table = |source: CsvError| match source {
        CsvError::Convert(e @ (ConvertError::Questions(_) | ConvertError::Contradiction { .. })) => e.into(),
        source => MeasurementError::Csv { path: shown(), source },
    };
    let geometry_units = options.geometry_units.as_ref().unwrap_or(&options.frf.units);
    let has_points = names.iter().any(|n| csv::is_point(n));
    let is_shapes = has_points && names.iter().any(|n| csv::is_mode(n));
    let is_points = has_points && names.iter().filter(|n| csv::coordinate(n).is_some()).count() >= 2;
    let is_functions = !is_shapes && !is_points && names.len() > 1 && names.iter().any(|n| csv::is_frequency(n));
    if is_shapes || is_functions || is_points {
        let text = csv::text_of(&bytes).map_err(of_table)?;
        found.is_synthetic |= text.lines().take_while(|l| l.starts_with('#')).any(|l| says_synthetic(l.as_bytes()));
    }
    let mut note = |notes: Vec<String>| found.notes.extend(notes.into_iter().map(|n| (path.to_path_buf(), n)));
    if is_functions {
        let csv = CsvFrfOptions {
            unit: options.unit.clone(),
            reference: None,
            quantity: options.frf.quantity,
            frequency_unit: options.frf.frequency_unit.clone(),
            duplicates: options.frf.duplicates,
        };
        let (frfs, notes) = read_frfs(&bytes, &csv).map_err(of_table)?;
        note(notes);
        return Ok(Content::Frfs(frfs));
    }
    if is_shapes {
        let (table, notes) = read_shapes(&bytes, geometry_units, options.direction).map_err(of_table)?;
        note(notes);
        return Ok(Content::Shapes(table));
    }
    if is_points {
        let (points, notes) = read_points(&bytes, geometry_units).map_err(of_table)?;
        note(notes);
        return Ok(Content::Points(points));
    }
    if let Some(encoding) = csv::wide_without_mark(&bytes) {
        return Err(MeasurementError::Unknown {
            path: shown(),
            hint: format!("; it seems to be {encoding}: save it as UTF-8"),
        });
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(MeasurementError::Empty { path: shown() });
    }
    let mut lines = bytes.split(|b| *b == b'\n').map(<[u8]>::trim_ascii);
    if !lines.any(|l| l == b"-1") {
        return Err(MeasurementError::Unknown { path: shown(), hint: String::new() });
    }
    let (file, notes) = uff::read(&bytes).map_err(|source| MeasurementError::Uff { path: shown(), source })?;
    found.notes.extend(notes.iter().map(|n| (path.to_path_buf(), n.to_string())));
    found.is_synthetic |= file.datasets.iter().any(|d| match d {
        Dataset::Function(f) => f.ids.iter().any(|id| says_synthetic(id.as_bytes())),
        Dataset::DataAtNodes(d) => d.ids.iter().any(|id| says_synthetic(id.as_bytes())),
        _ => false,
    });
    Ok(Content::Universal(file))
}

fn says_synthetic(text: &[u8]) -> bool {
    text.to_ascii_lowercase().windows(9).any(|w| w == b"synthetic")
}

/// Takes what arrays of a file are.
fn take(
    read: arrays::Found,
    path: &Path,
    found: &mut Measurements,
    set: &mut Option<FrfSet>,
    tables: &mut Vec<ModeTable>,
) -> Result<(), MeasurementError> {
    let shown = || path.display().to_string();
    found.notes.extend(read.notes.into_iter().map(|n| (path.to_path_buf(), n)));
    if let Some(functions) = read.functions {
        if set.is_some() {
            return Err(MeasurementError::SecondSet { path: shown() });
        }
        *set = Some(functions);
    }
    if let Some(table) = read.modes {
        if let Some(first) = tables.first().filter(|first| first.points.len() != table.points.len()) {
            let (expected, found) = (first.points.len(), table.points.len());
            return Err(MeasurementError::Shapes { path: shown(), expected, found });
        }
        tables.push(table);
    }
    Ok(())
}

/// Modes of tables of one size: points with three components each along x, y, z, or all along one direction.
fn of_tables(tables: Vec<ModeTable>, direction: Option<[f64; 3]>) -> Result<ModalSet, MeasurementError> {
    let has_components = tables.iter().all(|t| t.has_components);
    let axes: Vec<(Dof, [f64; 3])> = match direction {
        _ if has_components => (0..3).map(|i| (Dof::ALL[i], Point::GLOBAL[i])).collect(),
        Some(d) => {
            let dof = Dof::ALL[(0..3).max_by(|a, b| d[*a].abs().total_cmp(&d[*b].abs())).unwrap_or(2)];
            vec![(dof, d)]
        }
        None => {
            return Err(ConvertError::Questions(vec![Question {
                option: "direction",
                text: "the direction of the shapes is not stated".to_string(),
                answers: ["+x", "+y", "+z"].map(String::from).to_vec(),
            }])
            .into());
        }
    };
    let points = tables.first().map(|t| t.points.clone()).unwrap_or_default();
    let channels: Vec<ShapeChannel> = points
        .iter()
        .flat_map(|point| {
            axes.iter().map(move |(dof, d)| ShapeChannel { point: point.clone(), dof: *dof, direction: *d })
        })
        .collect();
    let mut modes = Vec::new();
    for (hz, damping_ratio, shape) in tables.into_iter().flat_map(|t| t.modes) {
        if shape.len() != channels.len() {
            let text = "some shapes have three components a point, others one".to_string();
            return Err(ConvertError::Unusable { what: "the files of modes".to_string(), why: text }.into());
        }
        modes.push(ModeRecord { damping_ratio, ..ModeRecord::new(None, hz, DVector::from_vec(shape)) });
    }
    modes.sort_by(|a: &ModeRecord, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok(ModalSet { channels, modes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::FrfQuantity;
    use crate::data::convert::UnitSystem;
    use retune_linalg::Complex;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("retune-measurement-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn arrays_need_units_and_quantity() {
        let folder = folder("npy");
        let (f, h) = (folder.join("f.npy"), folder.join("h.npy"));
        let array = |shape: Vec<usize>, values| npy::write(&npy::Array { shape, values });
        std::fs::write(&f, array(vec![3], npy::Values::Real(vec![1.0, 2.0, 3.0]))).unwrap();
        let values = (0..6).map(|k| Complex::new(f64::from(k), 1.0)).collect();
        std::fs::write(&h, array(vec![3, 2], npy::Values::Complex(values))).unwrap();
        let files = [h, f];
        let mut options = MeasurementOptions::default();
        assert!(read_measurements(&files, None, &options).unwrap_err().to_string().contains("units"));
        options.frf.units = UnitsFrom::System(UnitSystem::from_name("mm-N-s").unwrap());
        assert!(read_measurements(&files, None, &options).unwrap_err().to_string().contains("quantity"));
        options.frf.quantity = Some(FrfQuantity::Accelerance);
        let set = read_measurements(&files, None, &options).unwrap().frfs.unwrap();
        assert_eq!((set.n_lines(), set.responses.len()), (3, 2));
        assert_eq!(set.at(2, 0, 1), Complex::new(5.0e-3, 1.0e-3));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn tables_and_points_are_recognised() {
        let folder = folder("csv");
        let (table, points) = (folder.join("h.csv"), folder.join("points.csv"));
        std::fs::write(&table, "# SYNTHETIC\nfrequency_hz,1.+z/1.+z:re,1.+z/1.+z:im\nHz,m/s2/N,m/s2/N\n1,2,3\n2,3,4\n")
            .unwrap();
        std::fs::write(&points, "point,x,y,z\n1,10,20,0\n").unwrap();
        let mut options = MeasurementOptions::default();
        let files = [table];
        let error = read_measurements(&files, Some(&points), &options).unwrap_err();
        assert!(error.to_string().contains("geometry-units"), "{error}");
        options.geometry_units = Some(UnitsFrom::System(UnitSystem::from_name("mm-N-s").unwrap()));
        let found = read_measurements(&files, Some(&points), &options).unwrap();
        assert_eq!(found.geometry.unwrap().points[0].position_m, [0.01, 0.02, 0.0]);
        assert!(found.is_synthetic);
        assert_eq!(found.frfs.unwrap().n_lines(), 2);
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn every_sample_is_read_or_explained() {
        let Some(samples) = crate::data::shared_data("uff_samples") else { return };
        let mut paths: Vec<PathBuf> = std::fs::read_dir(samples).unwrap().map(|e| e.unwrap().path()).collect();
        paths.sort();
        for path in paths {
            match read_measurements(std::slice::from_ref(&path), None, &MeasurementOptions::default()) {
                Ok(found) => eprintln!("{}: {:?} functions", path.display(), found.frfs.map(|f| f.responses.len())),
                Err(e) => assert!(e.to_string().len() > 20, "{}: {e}", path.display()),
            }
        }
    }
}
