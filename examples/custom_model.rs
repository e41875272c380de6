//! A whole model of your own: a shear building whose matrices are written down here, fitted to measured frequencies by
//! the same workflow as a model file. Any other solver can stand in its place.
//!
//! ```text
//! [===== m3 =====]  x3      K = tridiagonal of the storey stiffnesses, M = diagonal of the floor masses
//!   |   k3     |
//! [===== m2 =====]  x2      θ = (k1, k2, k3)
//!   |   k2     |
//! [===== m1 =====]  x1
//!   |   k1     |
//! ```
//!
//! Run it with `cargo run --example custom_model`.

use retune::data::read_test;
use retune::element::Dof;
use retune::linalg::DMatrix;
use retune::model::{DofMap, ModelError, Parameter, ParameterSet, ParametricModel, System};
use retune::update::{Controls, Cost, Settings, update};

#[derive(Debug)]
pub(crate) struct ShearBuilding {
    floor_masses_kg: Vec<f64>,
    storeys: ParameterSet,
    dofs: DofMap,
}

impl ShearBuilding {
    pub(crate) fn new(floor_masses_kg: Vec<f64>, estimate_n_per_m: f64) -> Self {
        let n = floor_masses_kg.len();
        let storey = |i| Parameter {
            name: format!("k{}", i + 1),
            unit: "kN/m".to_string(),
            unit_factor: 1e3,
            value: estimate_n_per_m,
            bounds: Some([0.5 * estimate_n_per_m, 2.0 * estimate_n_per_m]),
            prior_sd: None,
            description: "stiffness of a storey".to_string(),
        };
        let nodes = (0..n).map(|i| (format!("floor_{}", i + 1), [0.0, 0.0, 3.0 * (i + 1) as f64])).collect();
        let dofs = DofMap::from_rows(nodes, (0..n).map(|i| (i, Dof::Ux)).collect());
        Self { floor_masses_kg, storeys: ParameterSet::new((0..n).map(storey).collect()), dofs }
    }
}

impl ParametricModel for ShearBuilding {
    fn parameters(&self) -> &ParameterSet {
        &self.storeys
    }
    fn dof_map(&self) -> &DofMap {
        &self.dofs
    }
    fn assemble(&self, k: &[f64]) -> Result<System, ModelError> {
        let n = self.floor_masses_kg.len();
        let mut system = System::zeros(n, false);
        system.mass = DMatrix::from_fn(n, n, |i, j| if i == j { self.floor_masses_kg[i] } else { 0.0 });
        for i in 0..n {
            system.stiffness[(i, i)] = k[i] + k.get(i + 1).unwrap_or(&0.0);
            if i > 0 {
                (system.stiffness[(i, i - 1)], system.stiffness[(i - 1, i)]) = (-k[i], -k[i]);
            }
        }
        Ok(system)
    }
}

/// The exact frequencies of storeys of 180, 160 and 120 kN/m, to six digits.
const TEST: &str = include_str!("../models/verification/shear_building_test.yaml");

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (test, _) = read_test(TEST).map_err(|problems| format!("{problems:?}"))?;
    let building = ShearBuilding::new(vec![1200.0, 1000.0, 800.0], 150e3);
    let settings = Settings { cost: Cost::LeastSquares, ..Settings::default() };
    let result = update(&building, &test, &settings, Controls::default())?;
    for p in &result.parameters {
        println!("{} {:.1} -> {:.1} {}", p.name, p.before, p.after, p.unit);
    }
    Ok(())
}
