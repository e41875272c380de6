//! A fault of your own: a channel that was recorded in g among channels in m/s².
//!
//! `cargo run --example custom_fault` makes a synthetic test of the frame with one such channel and diagnoses it: among all effects and faults of
//! the catalogue, the new one is named.

use retune::data::{Correction, TestData};
use retune::diagnosis::{Settings, diagnose};
use retune::effect::Effects;
use retune::fault::{AboutFault, At, Bench, Fault, Faults, Tests};
use retune::linalg::Complex;
use retune::model::{ParametricModel, Registry, load};
use retune::update::{TwinOptions, node_sensors, twin_modes};

/// Standard gravity, m/s².
const G: f64 = 9.80665;

/// A channel in g: its readings are 9.80665 times too small.
#[derive(Debug)]
struct SensorInG;

impl Fault for SensorInG {
    fn name(&self) -> &'static str {
        "sensor-in-g"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "A channel was recorded in g, the others in m/s².",
            signature: "Its reading is 9.80665 times too small in every mode.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.channels().map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("multiply the readings of sensor {} by 9.80665", tests.sensor(at.sensor()))
    }

    fn shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        let s = at.sensor();
        shape[s] *= G;
        if let Some(sd) = sd {
            sd[s] *= G;
        }
    }

    fn put_into_shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>]) {
        shape[at.sensor()] /= G;
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        vec![Correction::factor(&test.sensors[at.sensor()].name, 1.0 / G)]
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (model, ..) = load(include_str!("../models/frame.yaml"), &Registry::builtin()).map_err(|p| format!("{p:?}"))?;
    let options =
        TwinOptions { n_modes: 6, frequency_noise: 0.003, shape_noise: 0.02, seed: 1, ..TwinOptions::default() };
    let mut test = twin_modes(&model, &model.parameters().nominal(), &node_sensors(&model), &options, "custom_fault")?;
    let channel = test.sensors.iter().position(|s| s.name == "mid_left.ux").ok_or("no such sensor")?;
    for shape in test.modes.iter_mut().filter_map(|m| m.shape.as_mut()) {
        shape[channel] /= G;
    }
    println!("a synthetic test whose channel {} is in g", test.sensors[channel].name);
    let settings = Settings {
        faults: Faults::builtin().with(&SensorInG),
        // Effects of the structure are sought as well; a few, so that the example takes a moment.
        effects: ["point-mass", "joint-flexibility"]
            .iter()
            .filter_map(|name| Effects::builtin().find(name))
            .fold(Effects::none(), Effects::with),
        ..Settings::default()
    };
    let found = diagnose(&model, &test, &settings)?;
    println!("{}", found.sentence);
    for h in found.hypotheses.iter().take(3) {
        println!(
            "  {:<32} P = {:.3}, misfit {:.0} -> {:.0}: {}",
            h.id, h.probability, h.misfit_before, h.misfit_after, h.patch
        );
    }
    Ok(())
}
