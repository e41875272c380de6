//! The paper's search, 20 000 evaluations of the BFF's cost, for `benches/peers/scipy_search.py`.
//!
//! ```text
//! cargo run --release -p retune-tools --bin paper_search -- dump FILE              # the problem as JSON, with costs to compare
//! cargo run --release -p retune-tools --bin paper_search -- run THREADS REPEATS    # seconds of wall time for each search
//! ```
#![allow(missing_docs, clippy::print_stdout)]

use retune::correlation::{PairBy, PairingOptions};
use retune::data::read_test;
use retune::linalg::{DMatrix, DVector};
use retune::model::{AffinePart, Basis, Entry, ParametricModel, Registry, load};
use retune::objective::{Comparison, Objective, PaperCost, starting_point};
use retune::optim::{DifferentialEvolution, Optimizer, Run, Strategy};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let text = |name: &str| std::fs::read_to_string(format!("{}/../models/{name}", env!("CARGO_MANIFEST_DIR")));
    let (model, ..) = load(&text("bff.yaml")?, &Registry::builtin()).map_err(|p| format!("{p:?}"))?;
    let (test, ..) = read_test(&text("bff_gvt.yaml")?).map_err(|p| format!("{p:?}"))?;
    let gates =
        PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true };
    let comparison = Comparison::new(&model, &test, gates)?;
    let cost = PaperCost::new(&comparison);
    let start = cost.scaling().x(&starting_point(&model));
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["dump", file] => {
            let affine = model.affine().ok_or("the model is not affine")?;
            let n = model.dof_map().n_dof();
            // Random points of a small generator: their quality does not matter here.
            let mut state = 1_u64;
            let mut random = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            };
            let points: Vec<DVector<f64>> = (0..500).map(|_| DVector::from_fn(start.len(), |_, _| random())).collect();
            let mut costs = vec![0.0; points.len()];
            cost.costs(&points, &mut costs);
            let masses = model.affine_mass().ok_or("no mass properties")?;
            let targets = model.targets();
            let rows = |a: &DMatrix<f64>| a.row_iter().map(|r| r.iter().copied().collect()).collect::<Vec<Vec<f64>>>();
            let problem = serde_json::json!({
                "stiffness": basis(affine, n, |b| &b.stiffness),
                "mass": basis(affine, n, |b| &b.mass),
                "rigid_mass": masses.linear.iter().map(|m| rows(&m.to_dense())).collect::<Vec<_>>(),
                "bounds": model.parameters().iter().map(|p| p.bounds).collect::<Vec<_>>(),
                "sensors": rows(comparison.sensors()),
                "shapes": rows(comparison.shapes()),
                "frequencies": test.modes.iter().map(|m| m.frequency_hz.value).collect::<Vec<_>>(),
                "labels": test.modes.iter().map(|m| m.label.clone()).collect::<Vec<_>>(),
                "mirror": model.mirror(),
                "targets": {
                    "mass": targets.mass.map(|t| [t.value, t.tolerance]),
                    "cg_x": targets.cg[0].map(|t| [t.value, t.tolerance]),
                    "inertia_yy": targets.inertia[1].map(|t| [t.value, t.tolerance]),
                },
                "points": points.iter().map(|x| x.as_slice().to_vec()).collect::<Vec<_>>(),
                "costs": costs,
            });
            std::fs::write(file, problem.to_string())?;
        }
        ["run", threads, repeats] => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.parse()?).build()?;
            let method = DifferentialEvolution {
                strategy: Strategy::Classic,
                population: Some(200),
                generations: Some(100),
                tolerance: 0.0,
                ..Default::default()
            };
            for seed in 0..repeats.parse()? {
                let clock = Instant::now();
                let optimum = pool.install(|| method.minimize(&start, &mut Run::new(&cost).seed(seed)))?;
                println!(
                    "{:.4} s, cost {:.9}, {} evaluations, {} by the kernel, {} by the reference path",
                    clock.elapsed().as_secs_f64(),
                    optimum.cost,
                    optimum.evaluations,
                    optimum.paths.batch,
                    optimum.paths.reference
                );
            }
        }
        _ => return Err("usage: paper_search dump FILE | run THREADS REPEATS".into()),
    }
    Ok(())
}

/// The dense matrices of the constant part and of every parameter.
fn basis(affine: &AffinePart, n: usize, of: fn(&Basis) -> &[Entry]) -> Vec<Vec<Vec<f64>>> {
    let dense = |basis: &Basis| {
        let mut a = vec![vec![0.0; n]; n];
        for e in of(basis) {
            let (row, column) = e.place();
            a[row][column] += e.value;
            if row != column {
                a[column][row] += e.value;
            }
        }
        a
    };
    std::iter::once(&affine.constant).chain(&affine.parameters).map(dense).collect()
}
