//! A fit does not end worse than it began, and says where it could have ended.

use super::uncertainty::RISE_90;
use super::{Assessment, Controls, ParameterChange};
use crate::linalg::{DVector, symmetric_eigen};
use crate::objective::Objective;
use crate::optim::{Multistart, Optimizer, OptimizerSpec, Optimum, Termination};

/// Relative rise of a squared misfit that is rounding.
const ROUNDING: f64 = 1e-9;
/// A squared misfit that is nothing.
const NOTHING: f64 = 1e-6;

/// The optimum; where modes have found other partners there, and the data are explained worse than at the start, the best one of which
/// that is not so, or the start.
///
/// A cost that is not the misfit may fall while the misfit rises. With the same partners that is what was asked for. Where a mode finds
/// another partner it is an accident: the cost of MAC and frequencies is lower beside a partner of twice the frequency than beside none.
///
/// * `judge` - half the squared misfit with priors and limits
/// * `start` - with its cost
/// * `partners` - of all test modes at a point
///
/// Gives the misfits of start and refused optimum with it, where one was refused.
pub(super) fn no_worse<P: PartialEq>(
    mut optimum: Optimum,
    judge: &dyn Objective,
    (start, cost): (&DVector<f64>, f64),
    partners: impl Fn(&DVector<f64>) -> P,
) -> (Optimum, Option<[f64; 2]>) {
    let misfit = |x: &DVector<f64>| judge.cost(x).map_or(f64::INFINITY, |c| 2.0 * c);
    let (before, after) = (misfit(start), misfit(&optimum.x));
    let is_worse = |after: f64| after > before * (1.0 + ROUNDING) + NOTHING;
    if !is_worse(after) {
        return (optimum, None);
    }
    let own = partners(start);
    let is_accident = |x: &DVector<f64>| is_worse(misfit(x)) && partners(x) != own;
    if !is_accident(&optimum.x) {
        return (optimum, None);
    }
    let kept = optimum.optima.iter().find(|o| !is_accident(&o.x)).map(|o| (o.x.clone(), o.cost));
    (optimum.x, optimum.cost) = kept.unwrap_or_else(|| (start.clone(), cost));
    if optimum.x == *start {
        optimum.termination = Termination::Stalled;
    }
    (optimum, Some([before, after]))
}

/// Directions in which the misfit bends less than this share of the stiffest are seen by no datum.
const UNSEEN: f64 = 1e-14;

/// The optimum with what no datum sees as it was at the start: a search from several points leaves it anywhere.
///
/// ```text
/// x - N Nᵀ (x - x_start),    N the null space of the Jacobian at x
/// ```
///
/// It is taken where the cost stays, as it need not where the null space is curved.
pub(super) fn unseen_as_before(mut optimum: Optimum, objective: &dyn Objective, start: &DVector<f64>) -> Optimum {
    let Ok(seen) = objective.linearize(&optimum.x) else { return optimum };
    let gram = seen.jacobian.tr_mul(&seen.jacobian);
    let Ok(eigen) = symmetric_eigen(&gram) else { return optimum };
    let least = UNSEEN * eigen.values.amax();
    let moved = &optimum.x - start;
    let mut x = optimum.x.clone();
    for (_, n) in eigen.values.iter().zip(eigen.vectors.column_iter()).filter(|(v, _)| **v <= least) {
        x.axpy(-n.dot(&moved), &n, 1.0);
    }
    let x = x.map(|v| v.clamp(0.0, 1.0));
    if x != optimum.x
        && let Ok(cost) = objective.cost(&x)
        && cost <= optimum.cost * (1.0 + ROUNDING) + NOTHING
    {
        (optimum.x, optimum.cost) = (x, cost);
    }
    optimum
}

/// What was refused, in words.
///
/// * `refused` - the comparison there with every test, `before` that at the start
pub(super) fn refusal([from, to]: [f64; 2], before: &[Assessment], refused: &[Assessment], is_start: bool) -> String {
    let mut why = String::new();
    for (old, new) in before.iter().zip(refused) {
        let partner = |a: &Assessment, mode: usize| a.pairs.iter().find(|p| p.test_mode == mode).map(|p| p.model_mode);
        let moved = new.pairs.iter().filter(|p| partner(old, p.test_mode) != Some(p.model_mode));
        if let Some(p) = moved.max_by(|a, b| a.error_percent.abs().total_cmp(&b.error_percent.abs())) {
            why = format!(
                ", where mode {} ({:.2} Hz) is paired with another one, {:+.0} % off",
                p.test_mode + 1,
                p.test_hz,
                p.error_percent
            );
        }
    }
    let kept = if is_start {
        "no point of the search explains them as well as the start, so the parameters stay as they were"
    } else {
        "the lowest optimum that explains them no worse was taken"
    };
    format!(
        "the cost is lowest where the model explains the data worse than before, chi-squared {to:.0} in place of {from:.0}{why}: {kept}"
    )
}

/// A misfit of the data that rose for the sake of what the cost counts beside it, or in place of it.
///
/// * `is_misfit` - whether the cost is the misfit with priors, targets and limits
pub(super) fn pulled(before: &[Assessment], after: &[Assessment], is_misfit: bool) -> Option<String> {
    let sum = |a: &[Assessment]| a.iter().map(|a| a.misfit.chi_squared).sum::<f64>();
    let (from, to) = (sum(before), sum(after));
    (to > from * (1.0 + ROUNDING) + NOTHING).then(|| {
        let why = if is_misfit {
            "priors, targets or limits, which the cost counts beside the data, asked for it"
        } else {
            "the cost that was minimised does not weigh the data by their standard deviations; `--cost least-squares` does"
        };
        format!("chi-squared of the data rose from {from:.1} to {to:.1}: {why}")
    })
}

/// To four digits.
fn significant(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    let unit = 10f64.powi(3 - value.abs().log10().floor() as i32);
    (value * unit).round() / unit
}

/// Starts beside the end of a local search.
const OTHERS: usize = 9;

/// Where other starts lead, if that is lower than a method that knows but one valley has found.
///
/// * `in_words` - the parameters at a point
pub(super) fn lower_elsewhere(
    objective: &dyn Objective,
    found: &Optimum,
    method: &OptimizerSpec,
    in_words: impl Fn(&DVector<f64>) -> Vec<ParameterChange>,
    controls: Controls<'_>,
    seed: u64,
) -> Option<String> {
    if !matches!(method, OptimizerSpec::LevenbergMarquardt(_) | OptimizerSpec::NelderMead(_)) {
        return None;
    }
    let many = Multistart { starts: OTHERS, ..Multistart::default() };
    let other = many.minimize(&found.x, &mut controls.run(objective, seed)).ok()?;
    (other.cost < found.cost - RISE_90).then(|| {
        let values = in_words(&other.x);
        let values = values.iter().filter(|p| p.lower.is_some()).take(4);
        let values: Vec<String> =
            values.map(|p| format!("{} = {} {}", p.name, crate::units::plain(significant(p.after)), p.unit)).collect();
        format!(
            "other starts lead lower: cost {:.4} in place of {:.4}, at {}; leave `--optimizer` away, or take `multistart`",
            other.cost,
            found.cost,
            values.iter().map(|v| v.trim_end()).collect::<Vec<_>>().join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objective::{EvalError, PathCounts};
    use crate::optim::LocalOptimum;

    /// r = 10 (x - ½).
    struct Judge;

    impl Objective for Judge {
        fn n_parameters(&self) -> usize {
            1
        }
        fn n_residuals(&self) -> usize {
            1
        }
        fn residuals(&self, x: &DVector<f64>) -> Result<DVector<f64>, EvalError> {
            Ok(DVector::from_element(1, 10.0 * (x[0] - 0.5)))
        }
    }

    fn at(x: f64) -> DVector<f64> {
        DVector::from_element(1, x)
    }

    fn found(x: f64, others: &[f64]) -> Optimum {
        let optima = others.iter().map(|&v| LocalOptimum { x: at(v), cost: 5.0, n_starts: 1 }).collect();
        Optimum {
            method: "test".into(),
            x: at(x),
            cost: 1.0,
            termination: Termination::PlanDone,
            evaluations: 0,
            linearizations: 0,
            failures: 0,
            paths: PathCounts::default(),
            history: Vec::new(),
            stages: Vec::new(),
            optima,
            n_starts: 1,
            warnings: Vec::new(),
        }
    }

    /// From 0.4 with a misfit of 1; beyond 0.7 modes have other partners.
    #[test]
    fn an_optimum_that_is_worse_with_other_partners_is_refused() {
        let start = at(0.4);
        let judged = |x: f64, others: &[f64]| {
            let partners = |x: &DVector<f64>| x[0] > 0.7;
            let (optimum, refused) = no_worse(found(x, others), &Judge, (&start, 9.0), partners);
            (optimum.x[0], optimum.cost, refused)
        };
        // Better, and worse with the same partners: as it was found.
        assert_eq!(judged(0.5, &[]), (0.5, 1.0, None));
        assert_eq!(judged(0.2, &[]), (0.2, 1.0, None));
        // Worse with others: the next optimum that is not, or the start.
        let (x, cost, refused) = judged(0.9, &[0.8, 0.55]);
        assert!((x, cost) == (0.55, 5.0) && refused.is_some_and(|[a, b]| (a - 1.0).abs() + (b - 16.0).abs() < 1e-9));
        let (x, cost, refused) = judged(0.9, &[0.8]);
        assert!((x, cost) == (0.4, 9.0) && refused.is_some());
    }
}
