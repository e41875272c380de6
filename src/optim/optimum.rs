use std::fmt::{self, Write as _};

use crate::catalogue::counted;
use serde::Serialize;

use crate::linalg::DVector;
use crate::objective::PathCounts;

/// How an optimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Termination {
    /// The points of the population or simplex agree in cost, and a restart found nothing better.
    PointsAgree,
    /// The gradient vanishes in every direction that the bounds leave open.
    GradientVanishes,
    /// Steps no longer reduce the cost by more than the tolerance.
    ReductionVanishes,
    /// The best cost reached the target.
    TargetReached,
    /// The method's own number of generations or starts is done.
    PlanDone,
    /// No step reduces the cost although the method's model of it promises so.
    Stalled,
    /// The evaluations allowed to the run are spent.
    BudgetSpent,
    /// The user stopped the run; the best point so far is kept.
    Cancelled,
}

impl Termination {
    /// Whether the method claims a minimum (of whatever kind it looks for) or the user's target.
    pub fn is_converged(self) -> bool {
        matches!(self, Self::PointsAgree | Self::GradientVanishes | Self::ReductionVanishes | Self::TargetReached)
    }

    /// Whether nothing further may be evaluated in the whole run.
    pub(crate) fn ends_the_run(self) -> bool {
        matches!(self, Self::TargetReached | Self::Cancelled)
    }

    /// One sentence fragment, fit for "the update ended: ...".
    pub fn text(self) -> &'static str {
        match self {
            Self::PointsAgree => "converged, all points agree",
            Self::GradientVanishes => "converged, the gradient vanishes inside the bounds",
            Self::ReductionVanishes => "converged, no step reduces the cost noticeably",
            Self::TargetReached => "the target cost is reached",
            Self::PlanDone => "the planned search is done",
            Self::Stalled => "stalled, no step reduces the cost",
            Self::BudgetSpent => "the evaluation budget is spent",
            Self::Cancelled => "stopped by the user",
        }
    }
}

impl fmt::Display for Termination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// One improvement of the best cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Improvement {
    /// Evaluations and linearizations spent when it was found.
    pub evaluations: u64,
    /// The best cost from then on.
    pub cost: f64,
}

/// A minimum that several starts may have found.
#[derive(Debug, Clone, PartialEq)]
pub struct LocalOptimum {
    /// The best of the points found there, in the unit box.
    pub x: DVector<f64>,
    /// Its cost.
    pub cost: f64,
    /// How many starts ended there.
    pub n_starts: usize,
}

/// One step of a workflow.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Name of the method.
    pub method: String,
    /// Best cost of this stage.
    pub cost: f64,
    /// Evaluations of this stage.
    pub evaluations: u64,
    /// Linearizations of this stage.
    pub linearizations: u64,
    /// How it ended.
    pub termination: Termination,
}

/// The best point found, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// Name of the method.
    pub method: String,
    /// The best point, in the unit box, (n_parameters).
    pub x: DVector<f64>,
    /// Its cost, finite.
    pub cost: f64,
    /// How the search ended.
    pub termination: Termination,
    /// Costs evaluated.
    pub evaluations: u64,
    /// Linearizations evaluated.
    pub linearizations: u64,
    /// Evaluations among them that failed (no finite cost).
    pub failures: u64,
    /// How many costs came by the batched kernel and how many by the reference path, repeated ones for checking included.
    pub paths: PathCounts,
    /// Every improvement of the best cost, in order.
    pub history: Vec<Improvement>,
    /// The steps of a workflow; empty for a single method.
    pub stages: Vec<Stage>,
    /// The different optima that the starts of a multistart met, best first; empty for other methods.
    pub optima: Vec<LocalOptimum>,
    /// Starts of a multistart that came to an end, whether or not they found anything; 0 for other methods.
    pub n_starts: usize,
    /// What went wrong beside the search, such as a checkpoint that could not be written any more.
    pub warnings: Vec<String>,
}

/// Costs of two optima that differ by no more than this, relatively or in all, differ by rounding.
const ROUNDING: f64 = 1e-9;
const NO_COST: f64 = 1e-8;
/// Other optima that are listed in words.
const OTHERS: usize = 4;

/// A cost with five significant digits; powers of ten where it is very small or large.
fn short(cost: f64) -> String {
    let size = cost.abs();
    if size != 0.0 && !(1e-3..1e6).contains(&size) {
        return format!("{cost:.4e}");
    }
    let decimals = if size > 0.0 { (4.0 - size.log10().floor()).clamp(0.0, 7.0) as usize } else { 0 };
    format!("{cost:.decimals$}")
}

impl Optimum {
    /// How many starts found the best optimum and which others exist, in words; nothing if there was one start.
    ///
    /// For example: "7 of 10 starts found the best optimum (cost 0.1550); other optima: 0.1586 (2 starts), 0.2010 (1 start)".
    pub fn starts_in_words(&self) -> Option<String> {
        let (best, others) = self.optima.split_first()?;
        let n_starts: usize = self.optima.iter().map(|o| o.n_starts).sum();
        let (starts, cost) = (counted(n_starts, "start"), short(best.cost));
        let mut text = match best.n_starts {
            0 => format!("none of {starts} found the best optimum (cost {cost}), another stage of the search did"),
            n => format!("{n} of {starts} found the best optimum (cost {cost})"),
        };
        for (i, other) in others.iter().take(OTHERS).enumerate() {
            let lead = if i == 0 { "; other optima: " } else { ", " };
            let is_equal = other.cost - best.cost <= ROUNDING * best.cost.abs() + NO_COST;
            let cost = if is_equal { "one with the same cost".to_string() } else { short(other.cost) };
            let _ = write!(text, "{lead}{cost} ({})", counted(other.n_starts, "start"));
        }
        if others.len() > OTHERS {
            let _ = write!(text, " and {} worse", others.len() - OTHERS);
        }
        Some(text)
    }

    /// This result as a step of a workflow.
    pub(crate) fn stage(&self) -> Stage {
        Stage {
            method: self.method.clone(),
            cost: self.cost,
            evaluations: self.evaluations,
            linearizations: self.linearizations,
            termination: self.termination,
        }
    }
}
