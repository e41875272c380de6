//! A fault of your own: a channel whose amplifier stood one step of 10 dB off.
//!
//! `cargo run --example custom_fault` makes a synthetic test of the frame with one such channel and diagnoses it: among all effects and faults of
//! the catalogue, the new one is named.

use retune::data::{Correction, TestData};
use retune::effect::Effects;
use retune::fault::{AboutFault, At, Bench, Fault, Faults, Tests};
use retune::linalg::Complex;
use retune::model::{ParametricModel, Registry, load};
use retune::update::{TwinOptions, node_sensors, twin_modes};
use retune_diagnosis::{Settings, diagnose};

/// A step of 10 dB.
const STEP: f64 = 3.162_277_660_168_379_5;

/// An amplifier one step too low: the readings of its channel are 3.16 times too small.
#[derive(Debug)]
struct AmplifierStep;

impl Fault for AmplifierStep {
    fn name(&self) -> &'static str {
        "amplifier-step"
    }

    fn about(&self) -> AboutFault {
        AboutFault {
            summary: "The amplifier of a channel stood one step of 10 dB below what the test says.",
            signature: "Its reading is 3.16 times too small in every mode.",
        }
    }

    fn places(&self, bench: &Bench<'_>) -> Vec<At> {
        bench.channels().map(At::Sensor).collect()
    }

    fn remedy(&self, tests: &dyn Tests, at: &At) -> String {
        format!("multiply the readings of sensor {} by 3.162", tests.sensor(at.sensor()))
    }

    fn shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>], sd: Option<&mut [f64]>) {
        let s = at.sensor();
        shape[s] *= STEP;
        if let Some(sd) = sd {
            sd[s] *= STEP;
        }
    }

    fn put_into_shape(&self, at: &At, _: f64, shape: &mut [Complex<f64>]) {
        shape[at.sensor()] /= STEP;
    }

    fn functions(&self, at: &At, _: f64, test: &TestData) -> Vec<Correction> {
        vec![Correction::factor(&test.sensors[at.sensor()].name, 1.0 / STEP)]
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (model, ..) = load(include_str!("../models/frame.yaml"), &Registry::builtin()).map_err(|p| format!("{p:?}"))?;
    let options =
        TwinOptions { n_modes: 6, frequency_noise: 0.003, shape_noise: 0.02, seed: 1, ..TwinOptions::default() };
    let mut test = twin_modes(&model, &model.parameters().nominal(), &node_sensors(&model), &options, "custom_fault")?;
    let channel = test.sensors.iter().position(|s| s.name == "mid_left.ux").ok_or("no such sensor")?;
    for shape in test.modes.iter_mut().filter_map(|m| m.shape.as_mut()) {
        shape[channel] /= STEP;
    }
    println!("a synthetic test whose channel {} is 10 dB too low", test.sensors[channel].name);
    let settings = Settings {
        faults: Faults::builtin().with(&AmplifierStep),
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
