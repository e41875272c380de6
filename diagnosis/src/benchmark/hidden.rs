//! What a twin hides: the truth as an edit of the refined model, or as a fault of its data.

use super::Plan;
use super::structures::Specimen;
use crate::error::DiagnosisError;
use crate::error::unsolvable;
use crate::problem::mesh::build;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use retune::data::{MassProperty, MassQuantity, Measured, Origin, TestData};
use retune::effect::Candidate;
use retune::fault::{At, Bench, Number, PlacedFault, SingleTest};
use retune::linalg::Complex;
use retune::model::spec::{ModelSpec, OverrideSpec};
use retune::model::{Model, ParametricModel};
use retune::optim::Draw;
use retune::units::Scalar;
use retune::update::{TwinFault, TwinOptions, twin_modes};

/// Relative standard deviation of the weighing.
const MASS_NOISE: f64 = 0.005;
/// A noisy sensor has so many times the stated noise; a dead one nothing else.
const NOISY: f64 = 6.0;
/// The angle of turned sensors, rad.
pub(super) const TURN: f64 = 0.35;
/// The coupling of close modes over λ: of 1 % apart it turns the shapes by 15 degrees.
const MIXED: f64 = 0.005;

/// Changes that no effect of the catalogue makes.
pub(super) const OUTSIDE: &[&str] =
    &["scattered-stiffness", "scattered-mass", "alternating-stiffness", "unmodelled-brace"];

/// Streams of random numbers of a case.
pub(super) fn rng(seed: u64, stream: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream);
    rng
}

/// A random point of the box, not near its faces.
fn point(model: &Model, rng: &mut ChaCha8Rng) -> Vec<f64> {
    model
        .parameters()
        .iter()
        .map(|p| p.bounds.map_or(p.value, |[low, high]| low + (0.2 + 0.6 * rng.unit()) * (high - low)))
        .collect()
}

/// What a twin hides.
#[derive(Debug, Clone)]
pub(super) enum Hidden {
    /// Nothing: the model is right, but for its parameters and its mesh.
    Nothing,
    /// An effect of the catalogue.
    Effect(Candidate),
    /// A fault of the measurement.
    Fault(PlacedFault),
    /// A change of the structure that no effect makes.
    Outside(&'static str),
}

/// A twin with its truth.
pub(super) struct Truth {
    pub(super) test: TestData,
    /// What was measured.
    pub(super) structure: Model,
    /// θ of the model without the effect.
    pub(super) theta: Vec<f64>,
    /// Sizes of the effect.
    pub(super) sizes: Vec<f64>,
}

impl Specimen {
    /// Makes the twin of a case.
    pub(super) fn twin(&self, hidden: &Hidden, seed: u64, plan: &Plan) -> Result<Truth, DiagnosisError> {
        let theta = point(&self.model, &mut rng(seed, 11));
        let mut values = theta.clone();
        let mut sizes = Vec::new();
        let spec = match hidden {
            Hidden::Effect(candidate) => {
                sizes = size(candidate, &mut rng(seed, 12));
                values.extend(&sizes);
                candidate.patch.apply(&self.fine)?
            }
            Hidden::Outside(kind) => self.outside(kind, &mut rng(seed, 13))?,
            Hidden::Nothing | Hidden::Fault(_) => self.fine.clone(),
        };
        let truth = build(spec, self.model.registry())?;
        // The sensors stand where the real structure has them, which a fault may keep secret.
        let sensors = match hidden {
            Hidden::Fault(fault) => fault.sensors_in_truth(&self.sensors, TURN),
            _ => self.sensors.clone(),
        };
        let options = TwinOptions {
            n_modes: self.n_modes,
            damping: Some(0.0),
            frequency_noise: plan.frequency_noise * plan.noise_factor,
            shape_noise: plan.shape_noise * plan.noise_factor,
            seed,
            ..TwinOptions::default()
        };
        let options = match hidden {
            Hidden::Fault(fault) if fault.number() == Number::Mixture => {
                let faults = self.mixtures(fault, &truth, &values, &options)?;
                TwinOptions { faults, ..options }
            }
            _ => options,
        };
        let mut test =
            twin_modes(&truth, &values, &sensors, &options, "twin of the diagnosis benchmark").map_err(unsolvable)?;
        for mode in &mut test.modes {
            mode.label = None;
            mode.frequency_hz.sd /= plan.noise_factor;
            if let Some(sd) = &mut mode.shape_sd {
                *sd /= plan.noise_factor;
            }
        }
        test.sensors.clone_from(&self.sensors);
        if let Ok(Some(p)) = truth.mass_properties(&values) {
            let value = p.mass * (1.0 + MASS_NOISE * rng(seed, 14).normal());
            test.mass_properties.push(MassProperty {
                quantity: MassQuantity::Mass,
                measured: Measured { value, sd: MASS_NOISE * p.mass, sd_is_default: false },
                origin: Origin::Synthetic("twin of the diagnosis benchmark".to_string()),
            });
        }
        if let Hidden::Fault(fault) = hidden {
            spoil(&mut test, fault, plan, &mut rng(seed, 15));
        }
        Ok(Truth { test, structure: truth, theta, sizes })
    }

    /// A fault of modes that are mixed, which acts on shapes before they are scaled, where this twin has close ones.
    fn mixtures(
        &self,
        fault: &PlacedFault,
        truth: &Model,
        values: &[f64],
        options: &TwinOptions,
    ) -> Result<Vec<TwinFault>, DiagnosisError> {
        let exact = TwinOptions { frequency_noise: 0.0, shape_noise: 0.0, ..options.clone() };
        let clean = twin_modes(truth, values, &self.sensors, &exact, "for its close modes").map_err(unsolvable)?;
        let tests = SingleTest::new(&clean);
        let places = fault.fault.places(&Bench { tests: &tests, positions: None, nodes: Vec::new() });
        let id = |at: At| PlacedFault::new(fault.fault, at).id(&tests);
        Ok(places.into_iter().map(|at| TwinFault::new(&id(at)).with(MIXED)).collect())
    }

    /// The refined structure with a change that is not in the catalogue.
    fn outside(&self, kind: &str, rng: &mut ChaCha8Rng) -> Result<ModelSpec, DiagnosisError> {
        let mut spec = self.fine.clone();
        // Elements of the coarse model: what the file calls them.
        let mut names: Vec<String> = self
            .model
            .elements()
            .iter()
            .filter(|e| e.kind.name() == "beam")
            .map(|e| e.name.split('/').next().unwrap_or(&e.name).to_string())
            .collect();
        names.dedup();
        let change = |spec: &mut ModelSpec, k: usize, name: &str, stiffness: Option<f64>, mass: Option<f64>| {
            let entry = OverrideSpec {
                of: vec![name.to_string()],
                stiffness: stiffness.map(Scalar::constant),
                mass: mass.map(Scalar::constant),
                ..OverrideSpec::default()
            };
            spec.overrides.insert(format!("hidden.{k}"), entry);
        };
        match kind {
            "scattered-stiffness" => {
                for (k, name) in names.iter().enumerate() {
                    change(&mut spec, k, name, Some((0.25 * rng.normal()).exp()), None);
                }
            }
            "scattered-mass" => {
                for (k, name) in names.iter().enumerate() {
                    change(&mut spec, k, name, None, Some((0.25 * rng.normal()).exp()));
                }
            }
            "alternating-stiffness" => {
                let (a, b) = if rng.unit() < 0.5 { (0.75, 1.3) } else { (1.3, 0.75) };
                for (k, name) in names.iter().enumerate() {
                    change(&mut spec, k, name, Some(if k % 2 == 0 { a } else { b }), None);
                }
            }
            "unmodelled-brace" => return self.brace(spec, rng),
            other => return Err(unsolvable(format_args!("no change `{other}`"))),
        }
        Ok(spec)
    }

    /// A spring between two nodes that the file does not join.
    fn brace(&self, mut spec: ModelSpec, rng: &mut ChaCha8Rng) -> Result<ModelSpec, DiagnosisError> {
        let file_nodes = self.model.spec().nodes.len();
        // Stiff enough to matter: a share of what the lowest modes strain, ω² m.
        let names = &self.model.geometry().names;
        let (first, second) = (rng.below(file_nodes), rng.below(file_nodes));
        let dofs = self.model.dof_map();
        let axis = (0..3).find(|&k| {
            let dof = retune::element::Dof::ALL[(k + 2) % 3];
            !dofs.express(first, dof).is_empty() && !dofs.express(second, dof).is_empty()
        });
        let Some(axis) = axis.filter(|_| first != second) else {
            return Err(unsolvable("nothing to brace"));
        };
        let word = ["ux", "uy", "uz"][(axis + 2) % 3];
        let theta = self.model.parameters().nominal();
        let mass = self.model.mass_properties(&theta).ok().flatten().map_or(1.0, |p| p.mass);
        let context = retune::effect::Context::default();
        let omega2 = retune::effect::Structure::new(&self.model, &context).omega2();
        let k = format!("{:.6e} N/m", 0.3 * mass * omega2);
        spec.bushings.insert(
            "hidden".to_string(),
            serde_json::from_value(serde_json::json!({"nodes": [names[first], names[second]], "k": {word: k}}))
                .map_err(unsolvable)?,
        );
        Ok(spec)
    }
}

/// Half, once or twice the typical size; either sign where both make sense; a store anywhere on its grid.
fn size(candidate: &Candidate, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let factor = [0.5, 1.0, 2.0][rng.below(3)];
    let sign = if candidate.parameters.iter().all(|p| !p.one_sided()) && rng.unit() < 0.5 { -1.0 } else { 1.0 };
    candidate
        .parameters
        .iter()
        .map(|p| {
            if p.grid.is_empty() {
                (p.neutral + sign * factor * (p.typical - p.neutral)).clamp(p.bounds[0], p.bounds[1])
            } else {
                p.grid[rng.below(p.grid.len())]
            }
        })
        .collect()
}

/// Puts a fault into the data; sensors that measure elsewhere were there when the twin was made.
fn spoil(test: &mut TestData, fault: &PlacedFault, plan: &Plan, rng: &mut ChaCha8Rng) {
    let mut either = |a: f64, b: f64| if rng.unit() < 0.5 { a } else { b };
    match fault.number() {
        Number::None => fault.put_into(test, fault.number().neutral()),
        Number::Factor { .. } => fault.put_into(test, either(0.7, 1.4)),
        Number::Frequency { .. } => fault.put_into(test, either(0.95, 1.05)),
        // Where the sensors are and how modes are mixed was decided when they were measured.
        Number::Angle { .. } | Number::Mixture => {}
        Number::Scatter | Number::Silence => {
            let is_dead = fault.number() == Number::Silence;
            let s = fault.at.sensor();
            for shape in test.modes.iter_mut().filter_map(|m| m.shape.as_mut()) {
                let noise = rng.normal() * plan.shape_noise * if is_dead { 1.0 } else { NOISY };
                let kept = if is_dead { Complex::new(0.0, 0.0) } else { shape[s] };
                shape[s] = kept + Complex::new(noise, 0.0);
            }
        }
    }
}
