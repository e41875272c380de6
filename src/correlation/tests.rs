//! Hostile input: empty sets, values that are not numbers, sizes that do not fit. Nothing panics beyond what is documented.

use super::*;
use crate::linalg::{DMatrix, DVector, thin_svd};
use crate::modal::reduction::{guyan, irs, selection, serep};

#[test]
fn empty_sets_have_empty_answers() {
    let none = DMatrix::<f64>::zeros(0, 0);
    assert_eq!(mac_matrix(&none, &none).len(), 0);
    assert!(comac(&none, &none).is_empty() && enhanced_comac(&none, &none).is_empty());
    let list = ModeList::default();
    for by in [PairBy::Mac, PairBy::Order, PairBy::Label] {
        let options = PairingOptions { by, ..PairingOptions::default() };
        assert_eq!(pair_modes(&none, &list, &list, &options), PairedModes::default());
    }
    assert_eq!(thin_svd(&none).unwrap().rank(0.1), 0);
    assert_eq!(identifiability(&none, &[], None, 0.1).unwrap().rank, 0);
    let silent = identifiability(&DMatrix::zeros(0, 2), &["a".to_owned(), "b".to_owned()], None, 0.1).unwrap();
    assert_eq!((silent.rank, silent.groups.len()), (0, 2));
    assert_eq!(
        silent.to_string(),
        "the data determine 0 of 2 combinations of parameters\na has no effect\nb has no effect"
    );
    assert!(collinear_groups(&none, 0.9).is_empty());
    assert!(sensor_misfits::<f64>(&[]).unwrap().is_empty());
    assert_eq!(shape_residual::<f64>(&[], &[], &[]).unwrap().misfit.n_data, 0);
    assert_eq!(probability_of_mac::<f64>(&[], &[], &[], 0.9, 10, 1), 0.0);
    assert!(localize(&[], &[]).unwrap().places.is_empty());
    assert!(rank_driving_points(&none, &[]).is_empty());
    assert!(rank_next_measurements(&none, &[], &[]).unwrap().is_empty());
    assert!(effective_independence(&none, 0).unwrap().kept.is_empty());
    assert!(sensors_by_auto_mac(&none, &[], 0).unwrap().kept.is_empty());
    assert!(guyan(&none, &none, &none).unwrap().transformation.is_empty());
    let expander = Expander::new(&none, &none, &none, 1.0).unwrap();
    assert!(expander.expand(&DVector::zeros(0), &DVector::zeros(0), 1.0, 1.0).unwrap().shape.is_empty());
}

#[test]
fn numbers_that_are_none_give_errors_or_nothing() {
    let nan = DMatrix::from_element(3, 2, f64::NAN);
    let one = DMatrix::from_element(3, 2, 1.0);
    assert_eq!(mac_matrix(&nan, &one).max(), 0.0);
    assert_eq!(mac_matrix(&(&one * f64::INFINITY), &one).max(), 0.0);
    assert!(comac(&nan, &one).iter().all(Option::is_none));
    let paired = pair_modes(&nan, &ModeList::default(), &ModeList::default(), &PairingOptions::default());
    assert!(paired.pairs.is_empty() && paired.unpaired_analytical[0].best.is_none());
    assert!(spoiling_sensors(&nan, &one, 2).is_empty());
    assert!(identifiability(&nan, &["a".to_owned(), "b".to_owned()], None, 0.1).is_err());
    assert!(information(&nan, None, 0.1).is_err());
    assert!(effective_independence(&nan, 2).is_err());
    assert!(rank_next_measurements(&one, &[1.0, 1.0], std::slice::from_ref(&nan)).is_err());
    assert!(generalized_mass(&nan, &DMatrix::identity(3, 3), &one).is_err());
    let (k, s) = (DMatrix::identity(3, 3), selection(3, &[0, 1]).unwrap());
    assert!(serep(&k, &k, &s, &nan).is_err());
    assert!(irs(&k, &DMatrix::zeros(3, 3), &s, 3).is_err());
    assert!(guyan(&k, &k, &DMatrix::zeros(4, 3)).is_err());
}

/// A sensor on a rigid support reads nothing, which is said; on one that gives it does.
#[test]
fn a_sensor_on_a_support_that_gives_is_not_called_silent() {
    let on = |support: &str| {
        let text = format!(
            "retune: 1\nname: beam\nactive_dofs: [uz, ry]\nnodes:\n  a: [0, 0, 0]\n  b: [1, 0, 0]\n  c: [2, 0, 0]\n\
             beams:\n  deck: {{chain: [a, b, c], properties: {{EIy: 1e4, mass_per_length: 10}}}}\n\
             supports:\n  ends: {{nodes: [a, c], fixed: [uz]}}\n  pier: {support}\n"
        );
        let model = crate::model::load(&text, &crate::model::Registry::builtin()).unwrap().0;
        let place = crate::data::Place::Node { node: "b".into(), position: None };
        let direction = [0.0, 0.0, 1.0];
        let sensor =
            crate::data::Sensor { name: "s".into(), place, offset: None, direction, is_rotation: false, mass: None };
        check_sensors(&model, &[sensor]).len()
    };
    assert_eq!(on("{node: b, fixed: [uz]}"), 1);
    assert_eq!(on("{node: b, fixed: [uz], compliance: {uz: 1e-6 m/N}}"), 0);
}

/// Positions that were read as metres where they are millimetres, or the other way round, are told once for all sensors.
#[test]
fn sensors_that_stand_at_one_place_are_told() {
    const BEAM: &str = "
retune: 1
name: beam
nodes: {a: [0, 0, 0], b: [1 m, 0, 0]}
beams: {w: {nodes: [a, b], properties: {EA: 1e6 N, EIy: 50 N m2, EIz: 80 N m2, GJ: 20 N m2, mass_per_length: 1 kg/m, polar_inertia_per_length: 0.01 kg m}}}
supports: {wall: {node: a}}
";
    let model = crate::model::load(BEAM, &crate::model::Registry::builtin()).unwrap_or_else(|p| panic!("{p:?}")).0;
    let told = |scale: f64| {
        let at = |k: i32| crate::data::Sensor {
            name: format!("p{k}"),
            place: crate::data::Place::Node { node: "b".into(), position: Some([scale * f64::from(k), 0.0, 0.0]) },
            direction: [0.0, 0.0, 1.0],
            offset: None,
            is_rotation: false,
            mass: None,
        };
        check_sensors(&model, &[0, 1, 2, 3].map(at))
    };
    assert!(told(0.3).is_empty(), "{:?}", told(0.3));
    let found = told(0.3e-3);
    assert!(found.iter().any(|p| p.path == "sensors" && p.message.contains("another unit of length")), "{found:?}");
}
