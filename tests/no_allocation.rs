//! The batch path allocates nothing once its memory exists, from the kernel up to the cost: shown by an allocator that counts.
#![allow(unsafe_code)]

#[path = "../benches/grillage/mod.rs"]
mod grillage;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use retune::correlation::{PairBy, PairingOptions};
use retune::data::read_test;
use retune::linalg::batch::{AffineEntry, AffinePencil, BatchModel, BatchOptions, Mirror, Workspace};
use retune::linalg::{DMatrix, DVector};
use retune::model::{Registry, load};
use retune::objective::{Comparison, LeastSquares, Objective, PaperCost};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|a| a.set(a.get() + 1));
        // SAFETY: the caller's guarantees are those of `System`.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer came from `System`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn the_batch_path_does_not_allocate() {
    let data = grillage::grillage(5);
    let entries = |terms: &[grillage::Term]| -> Vec<AffineEntry> {
        let entry =
            |&(row, col, parameter, coefficient): &grillage::Term| AffineEntry { row, col, parameter, coefficient };
        terms.iter().map(entry).collect()
    };
    let pencil = AffinePencil {
        n: data.n,
        n_parameters: data.bounds.len(),
        stiffness: entries(&data.stiffness),
        mass: entries(&data.mass),
    };
    for halves in [true, false] {
        let options = BatchOptions {
            n_modes: 9,
            rigid: DMatrix::from_fn(data.n, 3, |i, j| data.rigid[j][i]),
            mirror: halves.then(|| Mirror { permutation: data.mirror.0.clone(), signs: data.mirror.1.clone() }),
            sensors: None,
            references: None,
            shapes: true,
        };
        let model = BatchModel::new(pencil.clone(), &grillage::nominal(&data), options).expect("the model is sound");
        let thetas = grillage::candidates(&data, 40, 1);
        let slices: Vec<&[f64]> = thetas.iter().map(Vec::as_slice).collect();
        let mut workspace = Workspace::new(&model, slices.len());
        let before = ALLOCATIONS.with(Cell::get);
        let redone = model.solve(&slices, &mut workspace).expect("sizes fit").n_redone();
        let after = ALLOCATIONS.with(Cell::get);
        assert_eq!(redone, 0);
        assert_eq!(after - before, 0, "allocations in the batch path");
    }
}

#[test]
fn a_batch_of_costs_does_not_allocate() {
    let text = |name: &str| std::fs::read_to_string(format!("{}/models/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let (model, ..) = load(&text("bff.yaml"), &Registry::builtin()).unwrap();
    let (test, _) = read_test(&text("bff_gvt.yaml")).unwrap();
    let gates =
        PairingOptions { by: PairBy::Mac, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true };
    let comparison = Comparison::new(&model, &test, gates).unwrap();
    for objective in [&PaperCost::new(&comparison) as &dyn Objective, &LeastSquares::new(&comparison) as &dyn Objective]
    {
        let point = |i: usize| DVector::from_fn(objective.n_parameters(), |j, _| (0.618 * (7 * i + j) as f64).fract());
        // Points where modes must be turned to the test go by the reference path, which allocates.
        let is_batched = |x: &DVector<f64>| {
            let before = objective.path_counts().reference;
            objective.costs(std::slice::from_ref(x), &mut [0.0]);
            objective.path_counts().reference == before
        };
        let points: Vec<DVector<f64>> = (0..420).map(point).filter(is_batched).take(400).collect();
        assert_eq!(points.len(), 400, "nearly all go by the batch path");
        let by_reference = objective.path_counts().reference;
        let mut costs = vec![0.0; points.len()];
        // The first batch makes the memory.
        objective.costs(&points[..200], &mut costs[..200]);
        let before = ALLOCATIONS.with(Cell::get);
        objective.costs(&points[200..], &mut costs[200..]);
        let after = ALLOCATIONS.with(Cell::get);
        assert_eq!(objective.path_counts().reference, by_reference);
        assert!(costs.iter().all(|c| c.is_finite()));
        assert_eq!(after - before, 0, "allocations in the objective");
    }
}
