//! How many evaluations a search needs, over several seeds: what is reached, when, and which optima the starts found.
//!
//! ```text
//! cargo run --release -p retune-tools --bin search_check -- MODEL TEST COST OPTIMIZER SEEDS [KNOWN]
//! cargo run --release -p retune-tools --bin search_check -- models/bff.yaml models/bff_gvt.yaml paper auto 10 0.0389057
//! ```
//!
//! COST is `paper`, `frequencies` or `least-squares`; OPTIMIZER is YAML, as for `retune update`. KNOWN is the best known
//! cost, by default the best of these seeds. A value with sensitivities counts as one evaluation, and a value as one.
#![allow(missing_docs, clippy::print_stdout)]

use retune::data::read_test;
use retune::model::{Registry, load};
use retune::update::{Controls, Cost, Settings, update};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [model, test, cost, optimizer, seeds, known @ ..] = arguments.as_slice() else {
        return Err("usage: search_check MODEL TEST COST OPTIMIZER SEEDS [KNOWN]".into());
    };
    let (model, ..) = load(&std::fs::read_to_string(model)?, &Registry::builtin()).map_err(|p| format!("{p:?}"))?;
    let (test, ..) = read_test(&std::fs::read_to_string(test)?).map_err(|p| format!("{p:?}"))?;
    let cost = match cost.as_str() {
        "paper" => Cost::Paper,
        "frequencies" => Cost::Frequencies,
        _ => Cost::LeastSquares,
    };
    let optimizer = retune::yaml::read(optimizer).map_err(|p| format!("{p:?}"))?.0;
    let mut runs = Vec::new();
    for seed in 0..seeds.parse()? {
        let clock = Instant::now();
        let settings = Settings { cost, seed, optimizer: Some(Clone::clone(&optimizer)), ..Settings::default() };
        let optimum = update(&model, &test, &settings, Controls::default())?.optimum;
        runs.push((seed, optimum, clock.elapsed().as_secs_f64()));
    }
    let best = runs.iter().map(|r| r.1.cost).fold(f64::INFINITY, f64::min);
    let known: f64 = known.first().map_or(Ok(best), |k| k.parse())?;
    let mut reached: Vec<u64> = Vec::new();
    for (seed, optimum, seconds) in &runs {
        let at = optimum.history.iter().find(|h| h.cost <= 1.01 * known).map(|h| h.evaluations);
        reached.push(at.unwrap_or(u64::MAX));
        println!(
            "seed {seed}: cost {:.9e}, within 1 % after {}, {} evaluations and {} linearizations in {seconds:.2} s; {}; {} by the kernel, {} by the reference path",
            optimum.cost,
            at.map_or("-".to_owned(), |n| n.to_string()),
            optimum.evaluations,
            optimum.linearizations,
            optimum.starts_in_words().unwrap_or_default(),
            optimum.paths.batch,
            optimum.paths.reference,
        );
    }
    reached.sort_unstable();
    let within = reached.iter().filter(|n| **n < u64::MAX).count();
    println!(
        "best {best:.9e}; {within} of {} within 1 % of {known:.9e}, median after {} evaluations",
        runs.len(),
        reached[(reached.len() - 1) / 2]
    );
    Ok(())
}
