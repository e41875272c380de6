//! Tests of real structures against their models: the bench test of the BFF wing, the clamped cruise-missile wing, the spectrum
//! of a cantilever.
//!
//! Real data are found through the environment variable `RETUNE_DATA`, or in `../shared/data` beside this package; tests
//! that need them say so and pass when they are absent.

use retune::correlation::{PairBy, PairingOptions};
use retune::data::convert::{FrfOptions, UnitSystem, UnitsFrom};
use retune::data::{MeasurementOptions, Origin, Place, TestData, read_measurements, read_test};
use retune::identify::health::{HealthOptions, Level, check_test};
use retune::identify::{Identification, IdentifyOptions, identify, sensors, test_modes};
use retune::modal::{SolveOptions, solve};
use retune::model::{Model, ParametricModel, Registry, load_configuration};
use retune::objective::Comparison;
use retune::update::assess;
use std::path::{Path, PathBuf};

fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models").join(file);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn model(file: &str, configuration: Option<&str>) -> Model {
    match load_configuration(&text(file), configuration, &Registry::builtin()) {
        Ok((model, _, _)) => model,
        Err(problems) => panic!("{}", problems.iter().map(|p| p.render(file)).collect::<String>()),
    }
}

fn data(folder: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let path = std::env::var_os("RETUNE_DATA").map_or(beside, PathBuf::from).join(folder);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there; set RETUNE_DATA to the folder of the real data", path.display());
    None
}

fn first_modes(model: &Model, n: usize) -> Vec<f64> {
    let system = model.assemble(&model.parameters().nominal()).unwrap();
    let motions = model.dof_map().rigid_motions();
    let modes = solve(&system.stiffness, &system.mass, &motions, SolveOptions { n_elastic: n, shift: None }).unwrap();
    modes.elastic().map(|r| modes.frequency_hz(r)).collect()
}

/// First bending, torsion and second bending of the wing clamped at node 5, as an independent program gives them from
/// the same numbers: 3.25, 30.4, 20.3 Hz initially and 3.99, 20.7, 24.5 Hz updated. Given to three digits, so within half
/// of the last.
#[test]
fn the_bench_configuration_has_the_known_frequencies() {
    for (file, expected) in [("bff.yaml", [3.25, 20.3, 30.4]), ("bff_updated.yaml", [3.99, 20.7, 24.5])] {
        let found = first_modes(&model(file, Some("bench")), 3);
        for (f, e) in found.iter().zip(expected) {
            let half = if e < 10.0 { 0.005 } else { 0.05 };
            assert!((f - e).abs() <= half + 1e-9, "{file}: {found:?}, expected {expected:?}");
        }
    }
}

#[test]
fn the_bench_test_names_its_configuration() {
    let (test, _) = read_test(&text("bff_bench.yaml")).unwrap();
    let updated = model("bff_updated.yaml", test.configuration.as_deref());
    let options = PairingOptions { by: PairBy::Order, min_mac: 0.0, frequency_window: 0.5, same_family_only: false };
    let comparison = Comparison::new(&updated, &test, options).unwrap();
    let a = assess(&comparison, &updated.parameters().nominal()).unwrap();
    // The ground vibration test alone drove the wing's own first bending 18 % too high.
    assert!((a.pairs[0].error_percent - 18.4).abs() < 0.5, "{}", a.pairs[0].error_percent);
}

/// Modes, geometry and findings of the clamped wing; FRFs in SI, geometry in inches.
fn wing() -> Option<(retune::data::Measurements, Identification)> {
    let folder = data("cruise_missile_wing/frf_csv")?;
    let units = |name| UnitsFrom::System(UnitSystem::from_name(name).unwrap());
    let options = MeasurementOptions {
        frf: FrfOptions { units: units("SI"), ..FrfOptions::default() },
        geometry_units: Some(units("in-lbf-s")),
        ..MeasurementOptions::default()
    };
    let found = read_measurements(&[folder], None, &options).unwrap();
    let options = IdentifyOptions { band_hz: Some((5.0, 750.0)), ..IdentifyOptions::default() };
    let identification = identify(found.frfs.as_ref().unwrap(), &options).unwrap();
    Some((found, identification))
}

#[test]
fn the_wing_has_nine_modes_and_a_wrong_driving_point() {
    let Some((found, identification)) = wing() else { return };
    // The first six as the authors of the measurement used them (SOURCE.md).
    for f in [13.54, 51.81, 125.19, 167.76, 228.05, 328.41, 362.2, 496.3, 681.9] {
        let near = identification.modes.iter().map(|m| (m.frequency_hz.value / f - 1.0).abs()).fold(1.0, f64::min);
        assert!(near < 0.01, "no mode near {f} Hz");
    }
    let findings = check_test(
        found.frfs.as_ref().unwrap(),
        Some(&identification),
        found.geometry.as_ref(),
        HealthOptions::default(),
    )
    .unwrap();
    let driving: Vec<_> = findings.iter().filter(|f| f.code.contains("driving-point")).collect();
    assert!(driving.iter().any(|f| f.level == Level::Fault && f.subject.contains('1')), "{findings:#?}");
}

/// The six lowest shapes against the beam grid: MAC at least 0.96 but for the fifth (0.908), the third and fourth in the
/// other order, both torsion modes about 40 % low.
#[test]
fn the_wing_and_its_beam_grid() {
    let Some((found, identification)) = wing() else { return };
    let frfs = found.frfs.as_ref().unwrap();
    let origin = Origin::Measured("accelerances".to_string());
    let mut sensors = sensors(frfs, None, None).unwrap();
    for s in &mut sensors {
        // Points are numbered as the nodes of the model.
        s.place = Place::Node { node: format!("n{}", s.name), position: None };
    }
    let near = |f: f64| {
        identification
            .modes
            .iter()
            .min_by(|a, b| (a.frequency_hz.value - f).abs().total_cmp(&(b.frequency_hz.value - f).abs()))
            .unwrap()
            .clone()
    };
    let modes = [13.4, 51.9, 125.0, 167.8, 228.1, 328.5].map(near);
    let test = TestData {
        name: "wing".to_string(),
        description: String::new(),
        date: None,
        configuration: None,
        sensors,
        modes: test_modes(&modes, &origin),
        mass_properties: Vec::new(),
        static_tests: Vec::new(),
        frfs: None,
        frf_fit: None,
        corrections: Vec::new(),
    };
    let grid = model("cruise_missile_wing.yaml", None);
    let options = PairingOptions { by: PairBy::Mac, min_mac: 0.3, frequency_window: 1.0, same_family_only: false };
    let comparison = Comparison::new(&grid, &test, options).unwrap();
    let a = assess(&comparison, &grid.parameters().nominal()).unwrap();
    for p in &a.pairs {
        eprintln!(
            "{:.2} {:.2} {:+.1} % {:?} model mode {}",
            p.test_hz,
            p.model_hz,
            p.error_percent,
            p.mac,
            p.model_mode + 1
        );
    }
    assert_eq!(a.pairs.len(), 6);
    assert!(a.pairs.iter().all(|p| p.mac.unwrap() >= if p.test_mode == 4 { 0.90 } else { 0.96 }));
    assert!(a.swapped.contains(&(2, 3)), "{:?}", a.swapped);
    let low = a.pairs.iter().filter(|p| (-50.0..-30.0).contains(&p.error_percent)).count();
    assert_eq!(low, 2);
}
