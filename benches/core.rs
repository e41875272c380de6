//! What an update spends its time on: reading, assembly, eigen-solution, one cost, and the whole search of the paper.
//!
//! ```text
//! cargo bench --bench core
//! ```

use divan::{Bencher, black_box};
use retune::correlation::{PairBy, PairingOptions};
use retune::data::{TestData, read_test};
use retune::linalg::{DMatrix, lowest_modes};
use retune::model::{Model, ParametricModel, Registry, System, load};
use retune::objective::{Comparison, Objective, PaperCost, starting_point};
use retune::optim::{DifferentialEvolution, Optimizer, Run, Strategy};

fn main() {
    divan::main();
}

fn text(name: &str) -> String {
    let path = format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn bff() -> Model {
    load(&text("bff.yaml"), &Registry::builtin()).unwrap().0
}

fn bff_gvt() -> TestData {
    read_test(&text("bff_gvt.yaml")).unwrap().0
}

/// Pairing as an update does it: every measured mode finds a partner.
fn open_gates() -> PairingOptions {
    PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true }
}

#[divan::bench]
fn read_bff_model(bencher: Bencher<'_, '_>) {
    let (text, registry) = (text("bff.yaml"), Registry::builtin());
    bencher.bench(|| load(black_box(&text), &registry).unwrap());
}

#[divan::bench]
fn assemble_bff(bencher: Bencher<'_, '_>) {
    let model = bff();
    let theta = model.parameters().nominal();
    let mut system = System::zeros(model.dof_map().n_dof(), false);
    bencher.bench_local(|| model.assemble_into(black_box(&theta), &mut system).unwrap());
}

/// K and M of a free grillage: the BFF's size, and larger ones, from a beam in `n`/3 - 1 elements.
fn free_beam(n: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let text = format!(
        "retune: 1\nname: free beam\nactive_dofs: [uz, rx, ry]\nnodes: {{a: [0, 0, 0], b: [0.5, 3, 0]}}\nbeams: {{b: {{nodes: [a, b], subdivide: {}, properties: {{EIy: 70, GJ: 58, mass_per_length: 0.9, polar_inertia_per_length: 5e-4}}}}}}\n",
        n / 3 - 1
    );
    let model = load(&text, &Registry::builtin()).unwrap().0;
    let System { stiffness, mass, .. } = model.assemble(&[]).unwrap();
    assert_eq!(stiffness.nrows(), n);
    (stiffness, mass)
}

#[divan::bench(args = [27, 42, 120])]
fn lowest_twelve_modes(bencher: Bencher<'_, '_>, n: usize) {
    let (k, m) = free_beam(n);
    bencher.bench(|| lowest_modes(black_box(&k), black_box(&m), 12, 1e4).unwrap());
}

#[divan::bench]
fn one_bff_cost(bencher: Bencher<'_, '_>) {
    let (model, test) = (bff(), bff_gvt());
    let comparison = Comparison::new(&model, &test, open_gates()).unwrap();
    let cost = PaperCost::new(&comparison);
    let x = cost.scaling().x(&starting_point(&model));
    bencher.bench(|| cost.cost(black_box(&x)).unwrap());
}

/// The paper's search: DE/rand/1/bin, 200 members, 100 generations, one hour in the paper.
#[divan::bench(sample_count = 3, sample_size = 1)]
fn the_paper_s_20000_evaluations(bencher: Bencher<'_, '_>) {
    let (model, test) = (bff(), bff_gvt());
    let comparison = Comparison::new(&model, &test, open_gates()).unwrap();
    let cost = PaperCost::new(&comparison);
    let start = cost.scaling().x(&starting_point(&model));
    let method = DifferentialEvolution {
        strategy: Strategy::Classic,
        population: Some(200),
        generations: Some(100),
        tolerance: 0.0,
        ..Default::default()
    };
    bencher.bench_local(|| {
        let optimum = method.minimize(&start, &mut Run::new(&cost).seed(1)).unwrap();
        assert_eq!(optimum.evaluations, 20_000);
        optimum
    });
}
