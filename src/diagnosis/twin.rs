//! Synthetic tests of a model: its modes at the sensors of a test, with seeded noise, labelled synthetic.

use super::DiagnosisError;
use crate::correlation::observation_matrix;
use crate::data::{Measured, Origin, Sensor, TestData, TestMode};
use crate::linalg::{Complex, DVector};
use crate::modal::{SolveOptions, solve};
use crate::model::{Model, ParametricModel};
use crate::objective::EvalError;
use crate::optim::Draw;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Noise of a twin, relative: of frequencies, and of shapes to their largest entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation stated in the test for frequencies.
    pub frequency: f64,
    /// Standard deviation stated in the test for shapes.
    pub shape: f64,
    /// The noise that is really added is so many times the stated one.
    pub factor: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self { frequency: 0.003, shape: 0.02, factor: 1.0 }
    }
}

/// The lowest elastic modes of a model at θ as a test would give them.
///
/// * `sensors` - where it is measured
/// * `n_modes` - number of elastic modes
/// * `seed` - of the noise
pub fn twin(
    model: &Model,
    theta: &[f64],
    sensors: &[Sensor],
    n_modes: usize,
    noise: Noise,
    seed: u64,
) -> Result<TestData, DiagnosisError> {
    let failed = |e: &dyn std::fmt::Display| EvalError::Unsolvable { reason: e.to_string() };
    let system = model.assemble(theta).map_err(|e| failed(&e))?;
    let rows = observation_matrix(model, sensors)?;
    let options = SolveOptions { n_elastic: n_modes, shift: None };
    let modes =
        solve(&system.stiffness, &system.mass, &model.dof_map().rigid_motions(), options).map_err(|e| failed(&e))?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let origin = Origin::Synthetic(format!("twin of `{}`, seed {seed}", model.spec().name));
    let list = modes
        .elastic()
        .map(|i| {
            let exact = modes.frequency_hz(i);
            let shape = &rows * modes.shapes.column(i);
            let largest = shape.amax().max(f64::MIN_POSITIVE);
            let frequency = exact * (1.0 + noise.factor * noise.frequency * rng.normal());
            let shape = DVector::from_fn(shape.len(), |k, _| {
                Complex::new(shape[k] / largest + noise.factor * noise.shape * rng.normal(), 0.0)
            });
            TestMode {
                label: None,
                frequency_hz: Measured { value: frequency, sd: noise.frequency * exact, sd_is_default: false },
                damping_ratio: None,
                origin: origin.clone(),
                shape_sd: Some(DVector::from_element(shape.len(), noise.shape)),
                shape: Some(shape),
                shape_origin: Some(origin.clone()),
            }
        })
        .collect();
    Ok(TestData {
        name: format!("twin of {}", model.spec().name),
        description: "computed by a model, with noise".to_string(),
        configuration: None,
        sensors: sensors.to_vec(),
        modes: list,
        mass_properties: Vec::new(),
        static_tests: Vec::new(),
        frfs: None,
        frf_fit: None,
    })
}
