//! The contract of [`Optimizer`], over the whole list.

mod checkpoints;
mod problems;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use problems::{Cost, kinked, noise};

use super::*;
use crate::objective::{EvalError, Linearization, Objective};

/// Every method, small enough for tests, and the workflow.
fn methods() -> Vec<OptimizerSpec> {
    let yaml = "
- auto: {insurance: 2000}
- differential-evolution: {strategy: classic, population: 40, generations: 300, differential_weight: 0.6}
- differential-evolution: {population: 40, generations: 250}
- nelder-mead
- levenberg-marquardt
- cma-es: {restarts: 1}
- multistart: {starts: 16}
- [differential-evolution: {population: 40, generations: 50}, nelder-mead]
";
    let OptimizerSpec::Sequence(Sequence { steps }) = serde_yaml::from_str(yaml).unwrap() else { unreachable!() };
    steps
}

/// Which of them look for the best of several minima.
fn is_global(method: &OptimizerSpec) -> bool {
    !matches!(method, OptimizerSpec::NelderMead(_) | OptimizerSpec::LevenbergMarquardt(_))
}

#[test]
fn scratch() {
    for problem in problems::all() {
        for method in methods() {
            let mut run = Run::new(&problem).seed(1);
            let optimum = method.minimize(&problem.start, &mut run);
            match optimum {
                Ok(o) => eprintln!(
                    "{:22} {:24} {:.3e} {} {} {:?} {:?}",
                    problem.name,
                    o.method,
                    o.cost - problem.minimum,
                    o.evaluations,
                    o.linearizations,
                    o.termination,
                    o.starts_in_words()
                ),
                Err(e) => eprintln!("{:22} {:24} {e}", problem.name, method.name()),
            }
        }
    }
}
