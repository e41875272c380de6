//! Searches of the whole box find the audited optima.
//!
//! The methods are those that `retune update` takes by default. Tens of thousands of evaluations each: two seeds by default, ten with `RETUNE_SLOW=1`, none without `--release`.

use super::*;
use retune::correlation::PairFlag;
use retune::linalg::DVector;
use retune::objective::{Comparison, Objective, PaperCost, Prediction, starting_point};
use retune::optim::{Optimizer, Optimum, Run};
use retune::update::{Cost, Settings};
use std::sync::Arc;
use std::time::Instant;

/// Evaluations allowed to one search.
const BUDGET: u64 = 60_000;

/// The seeds to run, with how many of them must succeed: all by default, 8 of 10 in the slow run.
fn seeds(what: &str) -> Option<(std::ops::Range<u64>, usize)> {
    if cfg!(debug_assertions) {
        eprintln!("skipped: {what} needs --release");
        return None;
    }
    if std::env::var_os("RETUNE_SLOW").is_some_and(|v| v == "1") {
        eprintln!("RETUNE_SLOW=1: {what} from ten seeds, {BUDGET} evaluations each");
        Some((0..10, 8))
    } else {
        Some((0..2, 2))
    }
}

/// One search as `retune update` makes it.
fn search(objective: &PaperCost<'_>, cost: Cost, model: &Model, seed: u64) -> Optimum {
    let start = objective.scaling().x(&starting_point(model));
    let clock = Instant::now();
    let method = Settings { cost, ..Settings::default() }.optimizer();
    let optimum = method.minimize(&start, &mut Run::new(objective).seed(seed).budget(BUDGET)).unwrap();
    let stages: Vec<String> = optimum
        .stages
        .iter()
        .map(|s| format!("{} {:.9} after {} ({})", s.method, s.cost, s.evaluations, s.termination))
        .collect();
    eprintln!(
        "seed {seed}: {:.9e} with {} evaluations and {} linearizations, {:.1} s: {}",
        optimum.cost,
        optimum.evaluations,
        optimum.linearizations,
        clock.elapsed().as_secs_f64(),
        stages.join(", ")
    );
    assert!(optimum.evaluations + optimum.linearizations <= BUDGET);
    assert!(optimum.x.iter().all(|v| (0.0..=1.0).contains(v)));
    optimum
}

/// The prediction at an optimum.
fn prediction(comparison: &Comparison<'_>, objective: &PaperCost<'_>, x: &DVector<f64>) -> Arc<Prediction> {
    comparison.predict(&objective.scaling().theta(x)).unwrap()
}

/// B13: the global optimum of equation (4), paired by order as in the paper.
///
/// A cost below the interval would mean a violated bound or constraint, or a wrong MAC.
#[test]
fn global_optimum_of_the_papers_cost() {
    let Some((seeds, required)) = seeds("the paper's cost") else { return };
    let (model, test) = (model("bff.yaml"), gvt());
    let comparison = Comparison::new(&model, &test, BY_ORDER).unwrap();
    let objective = PaperCost::new(&comparison);
    let mut found = 0;
    for seed in seeds {
        let optimum = search(&objective, Cost::Paper, &model, seed);
        let prediction = prediction(&comparison, &objective, &optimum.x);
        let (cost, penalty) = (objective.cost_of(&prediction), objective.penalty(&prediction));
        assert!(cost + penalty >= 0.038905, "{cost} + {penalty}: below the global minimum");
        // The constraint on pitch inertia is active; it is met up to the last step of the search.
        found += usize::from(cost + penalty <= 0.03893 && penalty < 1e-6);
    }
    assert!(found >= required, "{found} searches reached the global optimum, {required} must");
}

/// The reference's optimum has the reference's cost here: the searches above look for the right point.
#[test]
fn the_references_optima_have_their_costs() {
    let Some(reference) = reference() else { return };
    let (model, test) = (model("bff.yaml"), gvt());
    let theta = |path: &str| -> Vec<f64> {
        model.parameters().names().map(|n| number(at(&reference, &format!("{path}/parameters/{n}")))).collect()
    };
    let comparison = Comparison::new(&model, &test, BY_ORDER).unwrap();
    let objective = PaperCost::new(&comparison);
    let own = objective.cost(&objective.scaling().x(&theta("virtual_gvt/eq4_over_12_global_optimum"))).unwrap();
    let expected = number(at(&reference, "virtual_gvt/eq4_over_12_global_optimum/cost"));
    assert!((own - expected).abs() <= 1e-8, "{own}, expected {expected}");

    let comparison = Comparison::new(&model, &test, BY_ORDER_IN_FAMILY).unwrap();
    let objective = PaperCost::frequencies_only(&comparison);
    let own = objective.cost(&objective.scaling().x(&theta("frequency_only"))).unwrap();
    let expected = number(at(&reference, "frequency_only/global_minimum"));
    assert!((own - expected).abs() <= 1e-8, "{own}, expected {expected}");
}

/// B14: with modes kept in their families the six frequencies cannot all be met inside box and constraints.
///
/// Four local minima, of which the lowest attracts one start in five: a population goes to the widest, at 0.0262, in nine of
/// ten runs, so this cost is searched from many starts.
#[test]
fn frequencies_cannot_all_be_met_within_families() {
    let Some((seeds, required)) = seeds("frequencies within families") else { return };
    let (model, test) = (model("bff.yaml"), gvt());
    let comparison = Comparison::new(&model, &test, BY_ORDER_IN_FAMILY).unwrap();
    let objective = PaperCost::frequencies_only(&comparison);
    let mut found = 0;
    for seed in seeds {
        let optimum = search(&objective, Cost::Frequencies, &model, seed);
        let prediction = prediction(&comparison, &objective, &optimum.x);
        assert!(optimum.cost >= 0.022716, "{}: below the global minimum", optimum.cost);
        assert!(prediction.pairs.pairs.iter().all(|p| !p.flags.contains(&PairFlag::DifferentFamily)));
        found += usize::from(optimum.cost <= 0.02275 && objective.penalty(&prediction) < 1e-6);
    }
    assert!(found >= required, "{found} searches reached the optimum, {required} must");
}

/// B14: paired by order alone they are all met, by a wrong aircraft, and the pairing says so.
#[test]
fn frequencies_by_order_are_met_by_a_wrong_aircraft() {
    let Some((seeds, required)) = seeds("frequencies by order") else { return };
    let (model, test) = (model("bff.yaml"), gvt());
    let comparison = Comparison::new(&model, &test, BY_ORDER).unwrap();
    let objective = PaperCost::frequencies_only(&comparison);
    let mut found = 0;
    for seed in seeds {
        let optimum = search(&objective, Cost::Frequencies, &model, seed);
        if optimum.cost < 1e-5 {
            found += 1;
            let prediction = prediction(&comparison, &objective, &optimum.x);
            let flagged: Vec<usize> = prediction
                .pairs
                .pairs
                .iter()
                .filter(|p| p.flags.contains(&PairFlag::DifferentFamily))
                .map(|p| p.experimental)
                .collect();
            assert_eq!(flagged, [2, 3], "S A A S S A against S A S A S A: modes 3 and 4 have swapped families");
        }
    }
    assert!(found >= required, "{found} searches met all frequencies, {required} must");
}
