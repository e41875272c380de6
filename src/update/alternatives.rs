//! Other optima that explain the data as well, as far as their noise can tell.

use super::uncertainty::{Basis, RISE_90, Uncertainty, uncertainty};
use super::valley::{Valley, floor};
use super::{Controls, ParameterChange, UpdateError};
use crate::linalg::DVector;
use crate::model::ParametricModel;
use crate::objective::{Objective, Scaling};
use crate::optim::{LocalOptimum, Optimum};

/// A set of parameters away from the best one that fits as well: its chi-squared is less than 2.7 higher, and between the two it rises
/// by more.
#[derive(Debug, Clone)]
pub struct Alternative {
    /// Half its squared misfit, priors and limits included, as the cost of the best.
    pub cost: f64,
    /// How many starts ended there.
    pub n_starts: usize,
    /// Every parameter there, as in [`Update::parameters`](super::Update::parameters).
    pub parameters: Vec<ParameterChange>,
    /// How certain they are there.
    pub uncertainty: Uncertainty,
}

/// Alternatives that are looked at, and that are told.
const CANDIDATES: usize = 8;
const MOST: usize = 3;

/// The optima of the starts of a search that fit as well as the best and are not part of its valley, best first.
///
/// Two optima are one where they lie in one [`Valley`] that is not a deeper than the rise of a 90 % interval.
pub(super) fn alternatives(
    (model, scaling): (&dyn ParametricModel, &Scaling),
    objective: &dyn Objective,
    found: &Optimum,
    in_words: impl Fn(&[f64], &Uncertainty) -> Vec<ParameterChange>,
    controls: impl Fn() -> Controls<'static>,
) -> Result<Vec<Alternative>, UpdateError> {
    let refine = |x: &DVector<f64>| floor(objective, x, controls());
    let mut distinct = vec![LocalOptimum { x: found.x.clone(), cost: found.cost, n_starts: 0 }];
    let near = |o: &&LocalOptimum| o.cost <= found.cost + CLOSE * RISE_90;
    for optimum in found.optima.iter().filter(near).take(CANDIDATES) {
        let Some((x, cost)) = refine(&optimum.x) else { continue };
        if cost > found.cost + RISE_90 {
            continue;
        }
        let joins = |known: &LocalOptimum| {
            let limit = known.cost.max(cost) + RISE_90;
            (&known.x - &x).amax() < ONE || Valley { objective, limit, refine: &refine }.joins(&known.x, &x)
        };
        match distinct.iter_mut().find(|known| joins(known)) {
            Some(known) => known.n_starts += optimum.n_starts,
            None => distinct.push(LocalOptimum { x, cost, n_starts: optimum.n_starts }),
        }
    }
    let told = distinct.into_iter().skip(1).take(MOST).map(|o| {
        let basis = Basis::Minimum { allowance: 1_000 };
        let certain = uncertainty(objective, model, scaling, &o.x, basis)?;
        let parameters = in_words(&scaling.theta(&o.x), &certain);
        Ok(Alternative { cost: o.cost, n_starts: o.n_starts, parameters, uncertainty: certain })
    });
    told.collect()
}

/// Optima that differ by less than this share of every interval are one, also where the misfit jumps between them, as it does where modes change places.
const ONE: f64 = 1e-4;

/// A start that ended at so many rises above the best may not have come to its optimum.
const CLOSE: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::read_test;
    use crate::model::{Registry, load};
    use crate::update::{Settings, Update, update};

    const SPRINGS: &str = "
retune: 1
name: Two masses on springs
active_dofs: [uz]
parameters:
  k1: {value: 3000 N/m, bounds: [1000 N/m, 9000 N/m]}
  k2: {value: 900 N/m, bounds: [100 N/m, 3000 N/m]}
  m1: {value: 1 kg}
  m2: {value: 1 kg}
nodes: {a: [0, 0, 0], b: [1 m, 0, 0]}
springs:
  g: {node: a, k: {uz: k1}}
elements:
  ab: {type: bushing, nodes: [a, b], properties: {k_uz: k2}}
masses: {ma: {node: a, mass: m1}, mb: {node: b, mass: m2}}
";

    const TEST: &str = "
retune_test: 1
name: t
sources: {a: {kind: measured, text: an example}}
modes:
  - {frequency: 4.398934 Hz, frequency_sd: 0.5 %, source: a}
  - {frequency: 11.516560 Hz, frequency_sd: 0.5 %, source: a}
";

    fn fit(model: &str, settings: &Settings) -> Update {
        let (model, test) = (load(model, &Registry::builtin()).unwrap().0, read_test(TEST).unwrap().0);
        update(&model, &test, settings, Controls::default()).unwrap()
    }

    /// ω1² ω2² = k1 k2 and ω1² + ω2² = k1 + 2 k2: a quadratic with the roots (4000, 1000) and (2000, 2000).
    #[test]
    fn two_roots_of_a_quadratic_are_both_told() {
        for seed in 0..6 {
            let u = fit(SPRINGS, &Settings { seed, ..Settings::default() });
            assert_eq!(u.alternatives.len(), 1, "seed {seed}");
            let mut both: Vec<[f64; 2]> =
                [&u.parameters, &u.alternatives[0].parameters].iter().map(|p| [p[0].after, p[1].after]).collect();
            both.sort_by(|a, b| b[0].total_cmp(&a[0]));
            for (found, right) in both.iter().zip([[4000.0, 1000.0], [2000.0, 2000.0]]) {
                for k in 0..2 {
                    assert!((found[k] / right[k] - 1.0).abs() < 1e-3, "seed {seed}: {both:?}");
                }
            }
            // Each has its own intervals, which do not reach the other.
            let intervals = [&u.uncertainty, &u.alternatives[0].uncertainty].map(|c| c.parameters[0].interval);
            let [low, high] = if intervals[0][0] < intervals[1][0] { intervals } else { [intervals[1], intervals[0]] };
            assert!(low[0] < 2000.0 && 2000.0 < low[1] && low[1] < high[0] && high[0] < 4000.0 && 4000.0 < high[1]);
        }
    }

    /// One optimum, and a valley between bounds: k1 and k2 act through one number. Neither has another optimum.
    #[test]
    fn one_valley_is_one_optimum() {
        let narrow = SPRINGS.replace("[1000 N/m, 9000 N/m]", "[3000 N/m, 9000 N/m]");
        assert!(fit(&narrow, &Settings::default()).alternatives.is_empty());
        let in_series = SPRINGS.replace("masses: {ma: {node: a, mass: m1}, mb", "masses: {mb");
        let test = TEST.replace("  - {frequency: 11.516560 Hz, frequency_sd: 0.5 %, source: a}\n", "");
        let (model, test) = (load(&in_series, &Registry::builtin()).unwrap().0, read_test(&test).unwrap().0);
        let u = update(&model, &test, &Settings::default(), Controls::default()).unwrap();
        assert!(u.alternatives.is_empty(), "{:?}", u.alternatives);
    }

    /// Bounds of twelve decades: neither value is on a bound, and each method finds one of the two.
    #[test]
    fn parameters_over_many_decades_are_found_by_every_method() {
        let model = SPRINGS
            .replace("3000 N/m, bounds: [1000 N/m, 9000 N/m]", "1e9 N/m, bounds: [1 N/m, 1e12 N/m]")
            .replace("900 N/m, bounds: [100 N/m, 3000 N/m]", "1e9 N/m, bounds: [1 N/m, 1e12 N/m]");
        for optimizer in ["auto", "levenberg-marquardt", "multistart"] {
            let optimizer = crate::optim::OptimizerSpec::by_name(optimizer);
            let u = fit(&model, &Settings { optimizer: optimizer.clone(), ..Settings::default() });
            let found = [u.parameters[0].after, u.parameters[1].after];
            let is = |right: [f64; 2]| (0..2).all(|k| (found[k] / right[k] - 1.0).abs() < 1e-3);
            assert!(is([4000.0, 1000.0]) || is([2000.0, 2000.0]), "{optimizer:?}: {found:?}");
            assert!(u.parameters.iter().all(|p| !p.at_bound), "{optimizer:?}");
            assert!(u.uncertainty.parameters.iter().all(|p| p.sd.is_some() && p.held.is_none()), "{optimizer:?}");
            assert!(u.optimum.warnings.is_empty(), "{:?}", u.optimum.warnings);
        }
    }
}
