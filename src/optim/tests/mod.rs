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

fn minimize(method: &OptimizerSpec, problem: &problems::Problem, seed: u64) -> Optimum {
    method.minimize(&problem.start, &mut Run::new(problem).seed(seed)).unwrap()
}

/// Relative tolerances are 1e-10 and costs are of order one: the simplex and population methods stop that near.
const AGREED: f64 = 1e-10;

#[test]
fn every_method_finds_the_minimum_of_every_problem() {
    for problem in problems::all() {
        for method in methods() {
            if problem.name == "two minima" && !is_global(&method) {
                continue;
            }
            for seed in 1..4 {
                let optimum = minimize(&method, &problem, seed);
                let above = optimum.cost - problem.minimum;
                // the minima are known to rounding
                assert!((-1e-15..AGREED).contains(&above), "{}, {}: {above:e}", problem.name, method.name());
                let planned = matches!(method, OptimizerSpec::Multistart(_));
                assert!(optimum.termination.is_converged() || planned, "{}: {}", method.name(), optimum.termination);
            }
        }
    }
}

#[test]
fn local_methods_end_in_the_basin_they_start_in() {
    let problem = problems::two_minima();
    for method in methods().iter().filter(|m| !is_global(m)) {
        let optimum = minimize(method, &problem, 1);
        assert!(optimum.x[0] < 0.5 && optimum.termination.is_converged(), "{optimum:?}");
    }
}

#[test]
fn multistart_says_how_many_starts_found_which_optimum() {
    let optimum = minimize(&OptimizerSpec::by_name("multistart").unwrap(), &problems::two_minima(), 1);
    assert_eq!(optimum.optima.len(), 2);
    assert_eq!(optimum.optima.iter().map(|o| o.n_starts).sum::<usize>(), optimum.n_starts);
    let words = optimum.starts_in_words().unwrap();
    assert!(words.contains("starts found the best optimum (cost 0.045000); other optima: 0.12419 ("), "{words}");
    // parameters that cannot be told apart do not multiply optima
    let flat = minimize(&OptimizerSpec::by_name("multistart").unwrap(), &problems::rank_deficient(), 1);
    assert_eq!(flat.starts_in_words().unwrap(), "8 of 8 starts found the best optimum (cost 0.50000)");
    let mut elsewhere = flat.clone();
    elsewhere.optima.push(elsewhere.optima[0].clone());
    elsewhere.optima[0].n_starts = 0;
    let words = elsewhere.starts_in_words().unwrap();
    assert!(words.starts_with("none of 8 starts found the best optimum (cost 0.50000), another stage"), "{words}");
}

#[test]
fn equal_minima_at_different_places_are_two_optima() {
    let problem = Cost { n: 1, cost: |x: &DVector<f64>| ((x[0] - 0.5).powi(2) - 0.1).powi(2) };
    let method: OptimizerSpec = serde_yaml::from_str("{multistart: {local: nelder-mead}}").unwrap();
    let optimum = method.minimize(&DVector::from_element(1, 0.3), &mut Run::new(&problem)).unwrap();
    assert_eq!(optimum.optima.len(), 2, "{:?}", optimum.optima);
}

#[test]
fn active_bounds_are_met_exactly() {
    let problem = problems::active_bounds();
    for name in ["levenberg-marquardt", "nelder-mead"] {
        let x = minimize(&OptimizerSpec::by_name(name).unwrap(), &problem, 1).x;
        assert_eq!((x[0], x[2], x[4]), (0.0, 1.0, 0.0), "{name}");
    }
}

#[test]
fn a_kinked_cost_is_polished_to_nine_digits() {
    // the minimum as found by long runs of differential evolution and cma-es, which agree to 12 digits
    for (n, minimum) in [(10, 0.66591479055), (20, 0.87868116824)] {
        let problem = kinked(n);
        for seed in 0..3 {
            let search = DifferentialEvolution { generations: Some(60), ..DifferentialEvolution::default() };
            let polish = NelderMead { size: 0.01, ..NelderMead::default() };
            let mut run = Run::new(&problem).seed(seed).budget(14_000);
            let optimum = in_sequence(&[&search, &polish], &DVector::from_element(n, 0.5), &mut run).unwrap();
            let above = optimum.cost / minimum - 1.0;
            assert!((-1e-10..1e-9).contains(&above), "{n} {seed}: {above:e}");
        }
    }
}

/// Numbers of our own past. They change when a method's arithmetic or its draws do: then check that they do not grow
/// without reason, and pin the new ones. (Another mathematical library may round a logarithm or cosine otherwise, and
/// methods that draw normal numbers then take another path: those counts are compared within a tenth.)
#[test]
fn snapshot_evaluation_counts() {
    let pinned: [(&str, [[u64; 2]; 8]); 6] = [
        ("linear least squares", [[841, 27], [4720, 0], [4476, 0], [492, 0], [4, 3], [2353, 0], [39, 24], [2157, 0]]),
        ("Rosenbrock", [[534, 100], [5160, 0], [6121, 0], [572, 0], [24, 18], [3061, 0], [104, 80], [2367, 0]]),
        ("active bounds", [[1042, 29], [9160, 0], [4619, 0], [814, 0], [4, 3], [7113, 0], [39, 24], [2440, 0]]),
        ("rank deficient", [[841, 26], [2920, 0], [3476, 0], [372, 0], [4, 3], [2369, 0], [39, 24], [2027, 0]]),
        ("infeasible region", [[523, 89], [5200, 0], [6401, 0], [573, 0], [11, 9], [2479, 0], [107, 79], [2416, 0]]),
        ("two minima", [[594, 138], [2520, 0], [3611, 0], [208, 0], [7, 6], [1795, 0], [127, 87], [1992, 0]]),
    ];
    let mut wrong = Vec::new();
    for (problem, (name, counts)) in problems::all().iter().zip(pinned) {
        assert_eq!(problem.name, name);
        let found: Vec<[u64; 2]> =
            methods().iter().map(|m| minimize(m, problem, 1)).map(|o| [o.evaluations, o.linearizations]).collect();
        let is_near = |(found, expected): (&u64, &u64)| found.abs_diff(*expected) * 10 <= *expected;
        let is_here = cfg!(all(target_os = "linux", target_arch = "x86_64"));
        if !found.iter().flatten().zip(counts.iter().flatten()).all(is_near) || (is_here && found != counts) {
            wrong.push(format!("{name}: {found:?}, not {counts:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let problem = problems::active_bounds();
    for method in methods() {
        let with_threads = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| minimize(&method, &problem, 5))
        };
        let one = with_threads(1);
        assert_eq!(one, with_threads(2), "{}", method.name());
        assert_eq!(one, minimize(&method, &problem, 5), "{}", method.name());
    }
}

#[test]
fn different_seeds_give_different_paths() {
    let problem = problems::rosenbrock();
    let method = OptimizerSpec::by_name("differential-evolution").unwrap();
    assert_ne!(minimize(&method, &problem, 1).history, minimize(&method, &problem, 2).history);
}

#[test]
fn the_budget_is_never_exceeded_and_is_counted_right() {
    for method in methods() {
        for budget in [1, 2, 7, 50, 333] {
            let problem = problems::rosenbrock();
            let mut run = Run::new(&problem).budget(budget);
            let optimum = method.minimize(&problem.start, &mut run).unwrap();
            assert_eq!(problem.asked.load(Ordering::Relaxed), optimum.evaluations, "{}", method.name());
            assert!(optimum.evaluations + optimum.linearizations <= budget, "{}: {optimum:?}", method.name());
            let spent = optimum.evaluations + optimum.linearizations == budget;
            assert!(!spent || optimum.termination != Termination::PlanDone, "{}", method.name());
        }
    }
}

#[test]
fn history_falls_and_ends_at_the_optimum() {
    for method in methods() {
        let optimum = minimize(&method, &problems::rosenbrock(), 1);
        assert!(optimum.history.windows(2).all(|w| w[1].cost < w[0].cost && w[1].evaluations >= w[0].evaluations));
        assert_eq!(optimum.history.last().map(|i| i.cost), Some(optimum.cost));
    }
}

#[test]
fn a_start_outside_the_box_is_moved_into_it() {
    let problem = problems::linear();
    let start = DVector::from_row_slice(&[-3.0, 0.5, 7.0, 0.5]);
    for method in methods() {
        let optimum = method.minimize(&start, &mut Run::new(&problem)).unwrap();
        assert!(optimum.cost - problem.minimum < AGREED, "{}", method.name());
    }
}

#[test]
fn one_parameter_is_enough_and_none_is_refused() {
    let problem = Cost { n: 1, cost: |x: &DVector<f64>| (x[0] - 0.7).powi(2) };
    for method in methods() {
        if !matches!(method, OptimizerSpec::LevenbergMarquardt(_) | OptimizerSpec::Multistart(_)) {
            let optimum = method.minimize(&DVector::zeros(1), &mut Run::new(&problem)).unwrap();
            assert!(optimum.cost < AGREED, "{}: {}", method.name(), optimum.cost);
        }
        let nothing = Cost { n: 0, cost: |_: &DVector<f64>| 0.0 };
        let error = method.minimize(&DVector::zeros(0), &mut Run::new(&nothing)).unwrap_err();
        assert_eq!(error.to_string(), "the objective has no parameters: there is nothing to optimise");
    }
}

#[test]
fn a_target_ends_the_run() {
    for method in methods() {
        let problem = problems::active_bounds();
        let optimum = method.minimize(&problem.start, &mut Run::new(&problem).target(0.1)).unwrap();
        assert_eq!(optimum.termination, Termination::TargetReached, "{}", method.name());
        assert!(optimum.cost <= 0.1);
    }
}

#[test]
fn cancelling_keeps_the_best_point() {
    for method in methods() {
        let flag = Arc::new(AtomicBool::new(false));
        let mut seen: Vec<f64> = Vec::new();
        let mut stop_soon = |p: &Progress<'_>| {
            seen.push(p.cost);
            if p.evaluations > 60 {
                flag.store(true, Ordering::Relaxed);
            }
        };
        let problem = problems::two_minima();
        let mut run = Run::new(&problem).cancel(Arc::clone(&flag)).observer(&mut stop_soon);
        let optimum = method.minimize(&problem.start, &mut run).unwrap();
        drop(run);
        if method.name() == "levenberg-marquardt" {
            continue; // it has converged before
        }
        assert_eq!(optimum.termination, Termination::Cancelled, "{}", method.name());
        assert_eq!(optimum.cost, seen.iter().copied().fold(f64::INFINITY, f64::min), "{}", method.name());
    }
}

#[test]
fn a_run_cancelled_before_it_began_has_no_result() {
    let problem = problems::linear();
    for method in methods() {
        let mut run = Run::new(&problem).cancel(Arc::new(AtomicBool::new(true)));
        let error = method.minimize(&problem.start, &mut run).unwrap_err();
        assert!(matches!(error, OptimError::NoFinitePoint { evaluations: 0, .. }), "{error}");
    }
}

#[test]
fn evaluations_that_fail_at_random_are_survived() {
    let problem = Cost {
        n: 3,
        cost: |x: &DVector<f64>| {
            let fails = noise((x[0] * 1e9) as usize % 100_000).abs() < 0.2;
            if fails { f64::NAN } else { x.iter().map(|v| (v - 0.3).abs()).sum() }
        },
    };
    for method in methods() {
        let mut run = Run::new(&problem).budget(20_000);
        let outcome = method.minimize(&DVector::from_element(3, 0.9), &mut run);
        if matches!(method, OptimizerSpec::LevenbergMarquardt(_)) {
            let error = outcome.unwrap_err().to_string();
            assert_eq!(error, "optimizer `levenberg-marquardt` needs derivatives, and they cannot be had at its start");
        } else if !matches!(method, OptimizerSpec::Multistart(_)) {
            let optimum = outcome.unwrap();
            assert!(optimum.cost < 1e-3 && optimum.failures > 0, "{}: {}", method.name(), optimum.cost);
        }
    }
}

#[test]
fn an_objective_that_always_fails_is_an_error() {
    let problem = Cost { n: 2, cost: |_: &DVector<f64>| f64::NAN };
    for method in methods() {
        let error = method.minimize(&DVector::from_element(2, 0.5), &mut Run::new(&problem).budget(3000)).unwrap_err();
        let expected = matches!(error, OptimError::NoFinitePoint { .. } | OptimError::Linearization { .. });
        assert!(expected, "{}: {error}", method.name());
    }
}

#[test]
fn unusable_starts_and_settings_are_refused_with_the_reason() {
    let problem = problems::linear();
    for (start, message) in [
        (vec![0.5; 3], "the start has 3 values, but the objective has 4 parameters"),
        (vec![0.5, f64::NAN, 0.5, 0.5], "the start is NaN at parameter 1; it must be finite"),
    ] {
        for method in methods() {
            let error = method.minimize(&DVector::from_vec(start.clone()), &mut Run::new(&problem)).unwrap_err();
            assert_eq!(error.to_string(), message);
        }
    }
    for (yaml, message) in [
        ("differential-evolution: {population: 3}", "`population` is 3; it must be between 4 and 100000"),
        ("differential-evolution: {crossover_rate: 0.9}", "`crossover_rate` is 0.9; it must be left out"),
        ("differential-evolution: {strategy: classic, differential_weight: .nan}", "`differential_weight` is NaN"),
        ("nelder-mead: {size: 0}", "`size` is 0; it must be above 0 and at most 1"),
        ("nelder-mead: {tolerance: -1}", "`tolerance` is -1; it must be at least 0 and below 1"),
        ("levenberg-marquardt: {damping: .inf}", "`damping` is inf; it must be above 0 and at most 1e6"),
        ("cma-es: {sigma: 2}", "`sigma` is 2; it must be above 0 and at most 1"),
        ("multistart: {starts: 0}", "`starts` is 0; it must be between 1 and 10000"),
        ("auto: {starts: 0}", "`starts` is 0; it must be between 1 and 10000"),
    ] {
        let method: OptimizerSpec = serde_yaml::from_str(yaml).unwrap();
        let error = method.minimize(&problem.start, &mut Run::new(&problem)).unwrap_err().to_string();
        assert!(error.contains(message), "{yaml}: {error}");
    }
}

#[test]
fn asking_and_telling_walks_the_same_path() {
    for method in methods() {
        let problem = problems::active_bounds();
        let mut search = AskTell::new(
            Arc::new(method.clone()),
            problem.start.clone(),
            Problem { n_parameters: 5, n_residuals: 5, seed: 3, budget: Some(5000) },
        );
        let found = loop {
            match search.ask().unwrap() {
                Ask::Costs(points) => {
                    let costs: Vec<f64> = points.iter().map(|x| problem.cost(x).unwrap_or(f64::NAN)).collect();
                    search.tell_costs(&costs).unwrap();
                }
                Ask::Linearizations(points) => {
                    let answers = points.iter().map(|x| problem.linearize(x)).collect();
                    search.tell_linearizations(answers).unwrap();
                }
                Ask::Done(optimum) => break optimum.clone(),
            }
        };
        let called = method.minimize(&problem.start, &mut Run::new(&problem).seed(3).budget(5000)).unwrap();
        assert_eq!(found, called);
    }
}

#[test]
fn answers_that_do_not_fit_the_question_are_refused() {
    let about = Problem { n_parameters: 2, n_residuals: 0, seed: 0, budget: None };
    let mut search = AskTell::new(Arc::new(NelderMead::default()), DVector::from_element(2, 0.5), about);
    assert!(search.tell_costs(&[1.0]).is_err());
    assert!(matches!(search.ask(), Ok(Ask::Costs([_]))));
    let error = search.tell_costs(&[1.0, 2.0]).unwrap_err();
    assert_eq!(error.to_string(), "2 answers were told, but 1 costs were asked for");
    assert!(search.tell_linearizations(Vec::new()).is_err());
    search.tell_costs(&[1.0]).unwrap();
    assert!(matches!(search.ask(), Ok(Ask::Costs([_, _]))));
    // dropped with an open question: the waiting thread ends
}

/// Counts batches; fails at the given one.
#[derive(Default)]
struct Service {
    batches: AtomicU64,
    fails_at: Option<u64>,
}

impl Evaluator for Service {
    fn costs(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        out: &mut [f64],
        cancel: &AtomicBool,
    ) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        if Some(self.batches.fetch_add(1, Ordering::Relaxed)) == self.fails_at {
            return Err("connection lost".into());
        }
        Threads.costs(objective, points, out, cancel)
    }

    fn linearizations(
        &self,
        objective: &dyn Objective,
        points: &[DVector<f64>],
        cancel: &AtomicBool,
    ) -> Result<Vec<Result<Linearization, EvalError>>, Box<dyn std::error::Error + Send + Sync>> {
        Threads.linearizations(objective, points, cancel)
    }
}

#[test]
fn another_service_may_evaluate_and_its_failure_is_an_error() {
    let problem = problems::rosenbrock();
    let method = DifferentialEvolution::default();
    let service = Service::default();
    let served = method.minimize(&problem.start, &mut Run::new(&problem).evaluator(&service)).unwrap();
    assert_eq!(served, method.minimize(&problem.start, &mut Run::new(&problem)).unwrap());
    assert!(service.batches.load(Ordering::Relaxed) > 10);

    let broken = Service { fails_at: Some(3), ..Service::default() };
    let error = method.minimize(&problem.start, &mut Run::new(&problem).evaluator(&broken)).unwrap_err();
    assert_eq!(error.to_string(), "the evaluator failed");
}

/// A user's own method: points at random.
#[derive(Debug)]
struct RandomSearch;

impl Optimizer for RandomSearch {
    fn name(&self) -> &'static str {
        "random-search"
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        let mut x = run.clip(start)?;
        run.conclude(self.name(), |run| {
            let mut rng = run.rng(0);
            loop {
                run.cost(&x)?;
                x.apply(|v| *v = rng.unit());
            }
        })
    }
}

#[test]
fn a_users_own_method_takes_part_in_a_sequence() {
    let problem = problems::rosenbrock();
    let mut run = Run::new(&problem).budget(1000);
    let optimum = in_sequence(&[&RandomSearch, &LevenbergMarquardt::default()], &problem.start, &mut run).unwrap();
    assert_eq!(
        optimum.stages.iter().map(|s| s.method.as_str()).collect::<Vec<_>>(),
        ["random-search", "levenberg-marquardt"]
    );
    assert_eq!(optimum.stages[0].evaluations, 900);
    assert!(optimum.cost < AGREED);
}

/// A user's mistake: a point outside the box.
#[derive(Debug)]
struct Careless;

impl Optimizer for Careless {
    fn name(&self) -> &'static str {
        "careless"
    }

    fn minimize(&self, start: &DVector<f64>, run: &mut Run<'_>) -> Result<Optimum, OptimError> {
        run.conclude(self.name(), |run| {
            run.cost(&start.map(|v| v + 1.0))?;
            Ok(Termination::PlanDone)
        })
    }
}

#[test]
fn a_point_outside_the_box_is_refused() {
    let problem = problems::rosenbrock();
    let error = Careless.minimize(&problem.start, &mut Run::new(&problem)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "an optimizer asked for a point whose parameter 0 is 1.2; it must be between 0 and 1"
    );
}

/// r = exp(x) - exp(½), which has a cost everywhere and derivatives only where the function says so.
struct Patchy<F>(F);

impl<F: Fn(f64) -> bool + Send + Sync> Objective for Patchy<F> {
    fn n_parameters(&self) -> usize {
        1
    }
    fn n_residuals(&self) -> usize {
        1
    }
    fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
        Ok(DVector::from_element(1, x[0].exp() - 0.5_f64.exp()))
    }
    fn linearize(&self, x: &DVector<f64>) -> Result<Linearization, EvalError> {
        if !(self.0)(x[0]) {
            return Err(EvalError::NotFinite { name: "slope".into() });
        }
        let slope = crate::linalg::DMatrix::from_element(1, 1, x[0].exp());
        Ok(Linearization { residuals: self.residuals(x)?, jacobian: slope })
    }
}

/// A start without derivatives is moved towards the middle, and a step to a point without them is a rejected one: neither ends the search.
#[test]
fn points_without_derivatives_do_not_end_a_descent() {
    let from = |x: f64, objective: &dyn Objective| {
        LevenbergMarquardt::default().minimize(&DVector::from_element(1, x), &mut Run::new(objective)).unwrap()
    };
    let found = from(0.05, &Patchy(|x: f64| x > 0.08));
    assert!((found.x[0] - 0.5).abs() < 1e-9, "{}", found.x[0]);
    // From 0.95 the first step leads to 0.587, where there is no slope.
    let found = from(0.95, &Patchy(|x: f64| !(0.56..0.62).contains(&x)));
    assert!((found.x[0] - 0.5).abs() < 1e-9, "{}", found.x[0]);
}
