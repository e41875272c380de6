use super::super::geometry::si;
use super::*;
use crate::data::convert::frf_file;
use crate::data::uff::Storage;
use crate::data::uff::{ByteOrder, FloatFormat, read, write};
use crate::data::{SpectrumKind, SpectrumUnit};

fn set(n_lines: usize) -> FrfSet {
    let channel = |name: &str, direction| Channel { name: name.to_owned(), direction: Some(direction) };
    let references = vec![channel("3", [0.0, 0.0, 1.0]), channel("7", [0.0, -1.0, 0.0])];
    let responses = vec![channel("1", [0.0, 0.0, -1.0]), channel("2", [0.0, 0.0, 1.0]), channel("11", [1.0, 0.0, 0.0])];
    let mut set = FrfSet {
        quantity: FrfQuantity::Accelerance,
        frequencies_hz: (0..n_lines).map(|i| i as f64 * 0.312_520_001_28).collect(),
        references,
        responses,
        h: Vec::new(),
        coherence: None,
        n_averages: None,
    };
    let cells = 6 * n_lines;
    set.h = (0..cells).map(|i| Complex::new((i as f64 * 0.37).sin(), 1.0 / (i as f64 + 3.0))).collect();
    set.coherence = Some((0..cells).map(|i| 1.0 - 1.0 / (i as f64 + 2.0)).collect());
    set
}

const BINARY: Storage = Storage::Binary { order: ByteOrder::Big, format: FloatFormat::Ieee };

fn through_bytes(file: &UniversalFile) -> UniversalFile {
    read(&write(file).unwrap().0).unwrap().0
}

fn functions(file: &mut UniversalFile) -> impl Iterator<Item = &mut Box<Function>> {
    file.datasets.iter_mut().filter_map(|d| match d {
        Dataset::Function(f) => Some(f),
        _ => None,
    })
}

#[test]
fn frfs_come_back_bit_for_bit_from_a_binary_universal_file() {
    let ours = set(9);
    let file = through_bytes(&frf_file(&ours, BINARY).unwrap());
    let back = frfs(&[&file], &FrfOptions::default()).unwrap();
    assert_eq!(back.frfs, ours);
    assert!(back.spectra.is_empty());
}

#[test]
fn text_keeps_twelve_digits() {
    let ours = set(9);
    let file = through_bytes(&frf_file(&ours, Storage::Ascii).unwrap());
    let back = frfs(&[&file], &FrfOptions::default()).unwrap().frfs;
    // 19 characters less sign, point and four of the exponent leave 13 digits; 12 for the abscissa of 13 characters.
    assert!(ours.h.iter().zip(&back.h).all(|(a, b)| (a - b).norm() <= 2.0e-12 * a.norm()));
    assert!(ours.frequencies_hz.iter().zip(&back.frequencies_hz).all(|(a, b)| (a - b).abs() <= 1.0e-9));
}

#[test]
fn a_file_without_units_asks_and_an_answer_scales() {
    let mut file = frf_file(&set(3), BINARY).unwrap();
    file.datasets.remove(0);
    let error = frfs(&[&file], &FrfOptions::default()).unwrap_err();
    let ConvertError::Questions(questions) = &error else { panic!("{error}") };
    assert_eq!(questions.len(), 1, "each question once");
    assert_eq!(questions[0].option, "units");
    let ask = |name: &str| {
        let units = UnitsFrom::System(UnitSystem::from_name(name).unwrap());
        frfs(&[&file], &FrfOptions { units, ..FrfOptions::default() }).unwrap().frfs.h[1].re
    };
    let si = set(3).h[1].re;
    assert_eq!(ask("SI"), si);
    assert!((ask("mm-N-s") / (1.0e-3 * si) - 1.0).abs() < 1.0e-14);
    // Accelerations in g over pounds-force: 9.80665 m/s² / 4.4482216 N = 2.2046226 1/kg.
    assert!((ask("in-lbf-g") / (2.204_622_621_8 * si) - 1.0).abs() < 1.0e-10);
}

#[test]
fn labels_state_units_and_may_not_contradict_dataset_164() {
    let mut file = frf_file(&set(3), BINARY).unwrap();
    for f in functions(&mut file) {
        f.axes[1].units = "g".into();
        f.axes[2].units = "N".into();
    }
    let error = frfs(&[&file], &FrfOptions::default()).unwrap_err();
    assert!(error.to_string().contains("dataset 164 says that the unit of the responses is 1 in SI"), "{error}");
    let options = FrfOptions { units: UnitsFrom::Labels, ..FrfOptions::default() };
    let by_labels = frfs(&[&file], &options).unwrap().frfs;
    assert_eq!(by_labels.h[0], set(3).h[0] * 9.80665);
    // Without dataset 164 the labels are the statement.
    file.datasets.remove(0);
    assert_eq!(frfs(&[&file], &FrfOptions::default()).unwrap().frfs, by_labels);
}

#[test]
fn repeated_functions_and_unknown_quantities_are_questions() {
    let mut file = frf_file(&set(3), BINARY).unwrap();
    let mut again = file.datasets[1].clone();
    if let Dataset::Function(f) = &mut again {
        f.ordinate = Ordinate::Complex(vec![Complex::new(9.0, 9.0); 3]);
        f.axes[1].data_type = 0;
    }
    file.datasets.push(again);
    let ConvertError::Questions(q) = frfs(&[&file], &FrfOptions::default()).unwrap_err() else { panic!() };
    assert_eq!(q.iter().map(|q| q.option).collect::<Vec<_>>(), ["quantity", "duplicates"]);
    let quantity = Some(FrfQuantity::Accelerance);
    let options = |duplicates| FrfOptions { quantity, duplicates, ..FrfOptions::default() };
    assert_eq!(frfs(&[&file], &options(Duplicates::First)).unwrap().frfs.at(0, 0, 0), set(3).at(0, 0, 0));
    assert_eq!(frfs(&[&file], &options(Duplicates::Last)).unwrap().frfs.at(0, 0, 0), Complex::new(9.0, 9.0));
}

#[test]
fn directions_turn_with_the_displacement_axes_of_nodes() {
    use crate::data::{Geometry, Point, convert::geometry_file};
    let axes = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let points = vec![Point { name: "1".into(), position_m: [0.0; 3], axes }];
    let nodes = geometry_file(&Geometry { points, lines: vec![] });
    let file = frf_file(&set(2), BINARY).unwrap();
    let back = frfs(&[&file, &nodes], &FrfOptions::default()).unwrap().frfs;
    assert_eq!(back.responses[0].direction, Some([1.0, 0.0, 0.0])); // -z of node 1
    assert_eq!(back.responses[1].direction, Some([0.0, 0.0, 1.0])); // node 2 is not defined
}

#[test]
fn missing_pairs_are_nan_and_an_almost_empty_matrix_is_refused() {
    let mut file = frf_file(&set(2), BINARY).unwrap();
    file.datasets.remove(1);
    file.datasets.remove(1);
    let back = frfs(&[&file], &FrfOptions::default()).unwrap().frfs;
    assert!(back.at(1, 0, 0).re.is_nan() && back.coherence.as_ref().unwrap()[0].is_nan());
    assert_eq!(back.at(1, 1, 0), set(2).at(1, 1, 0));

    let Dataset::Function(f) = file.datasets[1].clone() else { panic!() };
    let diagonal = (1..200).map(|i| {
        let mut f = f.clone();
        (f.response.node, f.reference.node) = (i, i);
        Dataset::Function(f)
    });
    let file = UniversalFile { datasets: std::iter::once(si()).chain(diagonal).collect() };
    assert!(matches!(frfs(&[&file], &FrfOptions::default()), Err(ConvertError::TooSparse { .. })));
}

#[test]
fn spectra_are_kept_in_si_or_as_they_are() {
    let mut file = frf_file(&set(2), BINARY).unwrap();
    file.datasets[0] = {
        let Dataset::Units(mut units) = si() else { panic!() };
        units.length = 1000.0;
        Dataset::Units(units)
    };
    let Dataset::Function(mut f) = file.datasets[1].clone() else { panic!() };
    f.function_type = 2;
    file.datasets.push(Dataset::Function(f.clone()));
    f.axes[1].units = "g²/Hz".into();
    f.function_type = 9;
    file.datasets.push(Dataset::Function(f));
    let spectra = frfs(&[&file], &FrfOptions::default()).unwrap().spectra;
    let h = set(2).h[0];
    assert_eq!((spectra[0].kind, &spectra[0].unit), (SpectrumKind::Auto, &SpectrumUnit::Si("(m/s²)²".into())));
    assert!((spectra[0].values[0] - h * 1.0e-6).norm() < 1.0e-20);
    assert_eq!(
        (spectra[1].kind, &spectra[1].unit),
        (SpectrumKind::PowerDensity, &SpectrumUnit::AsInFile("g²/Hz".into()))
    );
    assert_eq!(spectra[1].values[0], h);
}

#[test]
fn samples_are_read_or_asked_about() {
    let Some(folder) = crate::data::shared_data("uff_samples") else { return };
    let open = |name: &str| read(&std::fs::read(folder.join(name)).unwrap()).unwrap().0;
    // A function of type 4 in (m/s²)/N by its label, at an unnamed point.
    let back = frfs(&[&open("non_ascii_header.uff")], &FrfOptions::default()).unwrap();
    assert_eq!((back.frfs.quantity, back.frfs.n_lines()), (FrfQuantity::Accelerance, 6));
    assert_eq!(back.frfs.h[5], Complex::new(3.75037, 2.93363));
    let error = frfs(&[&open("sample_dataset58_psd.uff")], &FrfOptions::default()).unwrap_err();
    assert!(error.to_string().contains("1 power spectral density (type 9)"), "{error}");
}
