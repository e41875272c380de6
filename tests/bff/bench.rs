//! Section IV of the paper: the ground vibration test and the tests of the wing itself, fitted at once.

use super::*;
use retune::model::load_configuration;
use retune::update::{Controls, Settings, TestCase, Update, update, update_to_tests};

fn bench() -> Model {
    load_configuration(&text("bff.yaml"), Some("bench"), &Registry::builtin()).unwrap().0
}

fn test_of(file: &str) -> TestData {
    read_test(&text(file)).unwrap_or_else(|p| panic!("{file}: {p:?}")).0
}

/// First bending of the clamped wing at the parameters of an update, Hz.
fn clamped_bending(u: &Update) -> f64 {
    let model = bench();
    let theta: Vec<f64> = u.parameters.iter().map(|p| p.after_si).collect();
    let modes = modes(&model, &theta, 3);
    modes.frequency_hz(modes.n_rigid)
}

fn parameter<'a>(u: &'a Update, name: &str) -> &'a retune::update::ParameterUncertainty {
    u.uncertainty.parameters.iter().find(|p| p.name == name).unwrap()
}

/// The bench test measured 3.37 Hz for the first bending of the clamped wing. A fit to the ground vibration test alone puts it
/// more than 10 % above that, as the paper's own update did (18 %); with the bench tests it comes down, the modulus with it and
/// better known, and what remains is said: this model cannot meet all tests, because the virtual aircraft behind the shapes has
/// lumps behind the spar that it has not.
#[test]
fn the_ground_vibration_test_and_the_bench_tests_fit_together() {
    let (free, clamped) = (model("bff.yaml"), bench());
    let (gvt, bench, statics) = (gvt(), test_of("bff_bench.yaml"), test_of("bff_static.yaml"));
    let alone = update(&free, &gvt, &Settings::default(), Controls::default()).unwrap();
    let cases = [
        TestCase { model: &free, test: &gvt },
        TestCase { model: &clamped, test: &bench },
        TestCase { model: &clamped, test: &statics },
    ];
    let joint = update_to_tests(&cases, &Settings::default(), Controls::default()).unwrap();
    assert_eq!(joint.further.len(), 2);
    assert_eq!(joint.further[0].after.pairs.len(), 3);
    assert_eq!(joint.further[1].after.readings.len(), 2);

    let (before, after) = (clamped_bending(&alone) / 3.37, clamped_bending(&joint) / 3.37);
    eprintln!(
        "clamped first bending over the measured one: {before:.4} after the GVT alone, {after:.4} after all tests"
    );
    assert!(before > 1.10 && after < before - 0.05, "{before} {after}");
    let e_wing = |u: &Update| parameter(u, "E_wing").interval;
    eprintln!("E_wing: {:?} after the GVT alone, {:?} after all tests", e_wing(&alone), e_wing(&joint));
    assert!(e_wing(&joint)[1] - e_wing(&joint)[0] < e_wing(&alone)[1] - e_wing(&alone)[0]);
    assert!(joint.uncertainty.remarks.iter().any(|r| r.contains("BFF wing bench test")));
}

/// Perfect shapes of a rigid centre body see its eight parameters through four numbers: mass, first moment, two moments of
/// inertia. That is the exact rank 15 of 19 of the reference.
#[test]
fn the_centre_body_acts_through_its_mass_properties() {
    let u = update(&model("bff.yaml"), &gvt(), &Settings::default(), Controls::default()).unwrap().uncertainty;
    assert_eq!(u.rank, 15);
    let [group] = u.inseparable.as_slice() else { panic!("{:?}", u.inseparable) };
    assert_eq!(group.parameters, ["mu_fuselage", "m1", "m2", "m3", "m4_9", "Iz1", "Ix1", "Ix4_9"]);
    assert_eq!(group.n_numbers, 4);
    for quantity in ["total mass", "first moment of mass along x", "moment of inertia about the y axis"] {
        assert!(group.shared.iter().any(|s| s == quantity), "{:?}", group.shared);
    }
}
