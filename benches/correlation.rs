//! One comparison of a model of 100 dofs with 34 sensors and 10 modes, as a whole and in parts; and all that `retune compare`
//! tells by default of a model file of that size.

use divan::{Bencher, black_box};
use retune::correlation::{
    ElementMatrix, ExpandedMode, Expander, ModeList, PairingOptions, comac, cross_orthogonality, enhanced_comac,
    localize, mac_matrix, pair_modes, shape_residual, spoiling_sensors,
};
use retune::data::TestData;
use retune::linalg::{DMatrix, DVector, Eigenpairs, lowest_modes};
use retune::modal::reduction::{selection, serep};
use retune::model::{Model, ParametricModel, Registry, load};
use retune::objective::Comparison;
use retune::update::{
    Assessment, MassReduction, PlacesOptions, TwinOptions, assess, mode_agreement, node_sensors,
    orthogonality as mass_orthogonality, places, sensor_agreement, twin_modes,
};

fn main() {
    divan::main();
}

struct Case {
    k: DMatrix<f64>,
    m: DMatrix<f64>,
    s: DMatrix<f64>,
    modes: Eigenpairs,
    phi_a: DMatrix<f64>,
    phi_x: DMatrix<f64>,
    frequencies: Vec<f64>,
    elements: Vec<ElementMatrix>,
}

/// A fixed-free chain of 100 masses, every third of the first 34 triples measured, 1 % of pseudo-noise.
fn case() -> Case {
    let n = 100;
    let k = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => 1e6 * if i == n - 1 { 1.0 } else { 2.0 },
        1 => -1e6,
        _ => 0.0,
    });
    let m = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 + 0.3 * (i as f64).sin() } else { 0.0 });
    let dofs: Vec<usize> = (0..34).map(|i| (3 * i + 1).min(n - 1)).collect();
    let s = selection(n, &dofs).unwrap_or_else(|e| unreachable!("{e}"));
    let modes = lowest_modes(&k, &m, 10, 100.0).unwrap_or_else(|e| unreachable!("{e}"));
    let phi_a = &s * &modes.vectors;
    let largest = phi_a.amax();
    let phi_x = DMatrix::from_fn(34, 10, |i, j| phi_a[(i, j)] + 0.01 * largest * ((7 * i + 13 * j) as f64).sin());
    let frequencies = modes.values.iter().map(|l| l.sqrt() / std::f64::consts::TAU).collect();
    let elements = (0..n)
        .map(|e| ElementMatrix {
            name: format!("e{e}"),
            group: None,
            dofs: if e == 0 { vec![0] } else { vec![e - 1, e] },
            matrix: if e == 0 {
                DMatrix::from_element(1, 1, 1e6)
            } else {
                DMatrix::from_row_slice(2, 2, &[1e6, -1e6, -1e6, 1e6])
            },
        })
        .collect();
    Case { k, m, s, modes, phi_a, phi_x, frequencies, elements }
}

fn criteria(case: &Case) -> usize {
    let mac = mac_matrix(&case.phi_a, &case.phi_x);
    let list = ModeList { frequencies_hz: &case.frequencies, ..ModeList::default() };
    let paired = pair_modes(&mac, &list, &list, &PairingOptions::default());
    let sensors = comac(&case.phi_a, &case.phi_x).len() + enhanced_comac(&case.phi_a, &case.phi_x).len();
    let removed = spoiling_sensors(&case.phi_a, &case.phi_x, 3).len();
    let sd = vec![0.01; 34];
    let residuals = (0..10)
        .filter(|&j| shape_residual(case.phi_a.column(j).as_slice(), case.phi_x.column(j).as_slice(), &sd).is_ok())
        .count();
    paired.pairs.len() + sensors + removed + residuals
}

fn orthogonality(case: &Case) -> f64 {
    serep(&case.k, &case.m, &case.s, &case.modes.vectors)
        .ok()
        .and_then(|reduced| cross_orthogonality(&case.phi_a, &reduced.mass, &case.phi_x).ok())
        .map_or(f64::NAN, |xor| xor[(0, 0)])
}

fn location(case: &Case) -> f64 {
    let Ok(expander) = Expander::new(&case.k, &case.m, &case.s, 100.0) else { return f64::NAN };
    let sd = DVector::from_element(34, 0.001);
    let expanded: Vec<_> = (0..10)
        .filter_map(|j| {
            let lambda = case.modes.values[j];
            let weight = expander.weight(expander.model_error(0.1, 100), lambda, 1.0);
            expander.expand(&case.phi_x.column(j).into_owned(), &sd, lambda, weight).ok().map(|e| (e, 1.0 / lambda))
        })
        .collect();
    let modes: Vec<_> = expanded
        .iter()
        .map(|(expanded, weight)| ExpandedMode { expanded, sd: &sd, weight: *weight, omega_squared_sd: 0.0 })
        .collect();
    localize(&modes, &case.elements).map_or(f64::NAN, |found| found.p_family)
}

#[divan::bench]
fn mac_only(bencher: Bencher<'_, '_>) {
    let case = case();
    bencher.bench(|| mac_matrix(black_box(&case.phi_a), black_box(&case.phi_x)));
}

#[divan::bench]
fn criteria_and_pairing(bencher: Bencher<'_, '_>) {
    let case = case();
    bencher.bench(|| criteria(black_box(&case)));
}

#[divan::bench]
fn orthogonality_by_serep(bencher: Bencher<'_, '_>) {
    let case = case();
    bencher.bench(|| orthogonality(black_box(&case)));
}

#[divan::bench]
fn expansion_preparation(bencher: Bencher<'_, '_>) {
    let case = case();
    bencher.bench(|| Expander::new(black_box(&case.k), &case.m, &case.s, 100.0));
}

#[divan::bench]
fn expansion_and_localization(bencher: Bencher<'_, '_>) {
    let case = case();
    bencher.bench(|| location(black_box(&case)));
}

#[divan::bench]
fn whole_comparison(bencher: Bencher<'_, '_>) {
    let case = case();
    bencher.bench(|| {
        let case = black_box(&case);
        criteria(case) as f64 + orthogonality(case) + location(case)
    });
}

/// A free beam of 33 members, 102 dofs, and a synthetic test of a stiffer one: a deflection at each of its 34 nodes, 10 modes.
fn from_files() -> (Model, TestData) {
    let at = |i: i32| format!("  n{i}: [{}, {}, 0]", 0.01 * f64::from(i), 0.1 * f64::from(i));
    let nodes = (0..34).map(at).collect::<Vec<_>>().join("\n");
    let chain: Vec<String> = (0..34).map(|i| format!("n{i}")).collect();
    let model = format!(
        "retune: 1\nname: free beam\nactive_dofs: [uz, rx, ry]\nparameters: {{EI: {{value: 70 N m^2}}, GJ: {{value: 5800 N m^2}}}}\nnodes:\n{nodes}\nbeams: {{b: {{chain: [{}], properties: {{EIy: EI, GJ: GJ, mass_per_length: 0.9, polar_inertia_per_length: 5e-4}}}}}}\n",
        chain.join(", ")
    );
    let model = load(&model, &Registry::builtin()).unwrap_or_else(|e| panic!("{e:?}")).0;
    assert_eq!(model.dof_map().n_dof(), 102);
    let options = TwinOptions { frequency_noise: 0.005, shape_noise: 0.01, ..TwinOptions::default() };
    let mut truth = model.parameters().nominal();
    truth[0] *= 1.05;
    let test =
        twin_modes(&model, &truth, &node_sensors(&model), &options, "a stiffer beam").unwrap_or_else(|e| panic!("{e}"));
    (model, test)
}

fn with_comparison<T>(of: impl FnOnce(&Model, &Comparison<'_>, &Assessment) -> T) -> T {
    let (model, test) = from_files();
    let comparison = Comparison::new(&model, &test, PairingOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    let assessment = assess(&comparison, &model.parameters().nominal()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((test.sensors.len(), test.modes.len(), assessment.pairs.len()), (34, 10, 10));
    of(&model, &comparison, &assessment)
}

#[divan::bench]
fn file_assess(bencher: Bencher<'_, '_>) {
    with_comparison(|_, comparison, a| bencher.bench_local(|| assess(comparison, black_box(&a.theta)).is_ok()));
}

#[divan::bench]
fn file_modes_and_sensors(bencher: Bencher<'_, '_>) {
    with_comparison(|_, comparison, a| {
        bencher.bench_local(|| {
            mode_agreement(comparison, black_box(a)).is_ok() && sensor_agreement(comparison, a, 3).is_ok()
        });
    });
}

#[divan::bench]
fn file_orthogonality(bencher: Bencher<'_, '_>) {
    with_comparison(|_, comparison, a| {
        bencher.bench_local(|| mass_orthogonality(comparison, black_box(a), MassReduction::Auto).is_ok());
    });
}

#[divan::bench]
fn file_places(bencher: Bencher<'_, '_>) {
    with_comparison(|model, comparison, a| {
        bencher.bench_local(|| places(model, comparison, black_box(a), PlacesOptions::default()).is_ok());
    });
}

#[divan::bench]
fn file_whole_comparison(bencher: Bencher<'_, '_>) {
    let (model, test) = from_files();
    let theta = model.parameters().nominal();
    bencher.bench_local(|| {
        let comparison = Comparison::new(&model, &test, PairingOptions::default()).ok()?;
        let a = assess(&comparison, black_box(&theta)).ok()?;
        let modes = mode_agreement(&comparison, &a).ok()?;
        let sensors = sensor_agreement(&comparison, &a, 3).ok()?;
        let mass = mass_orthogonality(&comparison, &a, MassReduction::Auto).ok()?;
        let places = places(&model, &comparison, &a, PlacesOptions::default()).ok()?;
        Some((modes, sensors, mass, places))
    });
}
