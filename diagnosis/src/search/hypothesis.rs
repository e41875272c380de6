//! A hypothesis after its refit.

use crate::error::DiagnosisError;
use crate::problem::evidence::goodness_of_fit;
use crate::problem::fit::Fit;
use crate::problem::scene::Scene;
use crate::thresholds::{NINETY, REMAINDER};
use retune::effect::{Candidate, NewParameter};
use retune::fault::PlacedFault;
use retune::linalg::DVector;
use retune::objective::Scaling;
use serde::{Deserialize, Serialize};

/// A hypothesis as it was tried.
#[derive(Debug, Clone)]
pub(crate) enum Tried {
    Effect(Candidate),
    Fault(PlacedFault),
}

/// A point of the box without the sizes that stand between the first parameters and the last: those of another hypothesis.
///
/// * `first`, `last` - how many stay of each
pub(crate) fn without_between(x: &DVector<f64>, first: usize, last: usize) -> DVector<f64> {
    let rest = x.len() - last;
    DVector::from_fn(first + last, |i, _| if i < first { x[i] } else { x[rest + i - first] })
}

/// An estimate with its 90 % interval, SI.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Name of the parameter.
    pub parameter: String,
    /// Value.
    pub value: f64,
    /// SI unit.
    pub unit: String,
    /// 90 % interval.
    pub interval: [f64; 2],
}

/// A refitted hypothesis.
#[derive(Debug, Clone)]
pub(crate) struct Refit {
    pub(crate) tried: Tried,
    /// The scene with the hypothesis in it, and its optimum.
    pub(crate) scene: Scene,
    pub(crate) fit: Fit,
    pub(crate) ln_bayes: f64,
    pub(crate) estimates: Vec<Estimate>,
    pub(crate) held_out: f64,
    /// Misfit including the cost of data that a fault declares worthless.
    pub(crate) misfit: f64,
    /// Modes that it brings and that the test should have seen.
    pub(crate) missed: usize,
    /// ln of its odds against those of its kind.
    pub(crate) ln_odds: f64,
    /// Ids of wider hypotheses that say the same with more numbers, and were left out for it.
    pub(crate) limit_of: Vec<String>,
}

impl Refit {
    pub(crate) fn id(&self, original: &Scene) -> String {
        match &self.tried {
            Tried::Effect(c) => c.id(),
            Tried::Fault(f) => f.id(original),
        }
    }

    /// The parameters that an effect brings, which stand last in its fit; `None` of a fault.
    pub(crate) fn own_sizes(&self) -> Option<&[NewParameter]> {
        match &self.tried {
            Tried::Effect(c) => Some(&c.parameters),
            Tried::Fault(_) => None,
        }
    }

    /// The probability that noise alone gives as much as it leaves.
    pub(crate) fn p_value(&self) -> Result<f64, DiagnosisError> {
        Ok(goodness_of_fit(&self.fit, &self.fit.basis()?))
    }

    /// Whether noise alone gives as much as it leaves, and the test need not have missed a mode.
    pub(crate) fn leaves_noise(&self) -> Result<bool, DiagnosisError> {
        Ok(self.missed == 0 && self.p_value()? > REMAINDER)
    }

    pub(crate) fn name(&self) -> &'static str {
        match &self.tried {
            Tried::Effect(c) => c.effect.name(),
            Tried::Fault(f) => f.name(),
        }
    }
}

/// The first of some hypotheses that leaves noise.
pub(crate) fn leaving_noise<'a>(of: impl IntoIterator<Item = &'a Refit>) -> Result<Option<&'a Refit>, DiagnosisError> {
    for r in of {
        if r.leaves_noise()? {
            return Ok(Some(r));
        }
    }
    Ok(None)
}

/// Estimates of all free parameters with 90 % intervals, clipped to the bounds; in the order of the model.
pub(crate) fn all_estimates(scene: &Scene, fit: &Fit) -> Result<Vec<Estimate>, DiagnosisError> {
    let (_, covariance) = fit.hessian()?;
    let parameters = scene.solved().parameters();
    let one = |(k, &index): (usize, &usize)| {
        let p = parameters.get(index);
        let [low, high] = p.bounds?;
        let value = fit.theta[index];
        let half = NINETY * covariance[(k, k)].sqrt() * (high - low);
        let interval = [(value - half).max(low), (value + half).min(high)];
        Some(Estimate { parameter: p.name.clone(), value, unit: p.unit.clone(), interval })
    };
    Ok(Scaling::new(scene.solved()).free().iter().enumerate().filter_map(one).collect())
}

/// Estimates with 90 % intervals, clipped to the bounds.
pub(crate) fn estimates(scene: &Scene, fit: &Fit, of: &[NewParameter]) -> Result<Vec<Estimate>, DiagnosisError> {
    let (_, covariance) = fit.hessian()?;
    let parameters = scene.solved().parameters();
    let free = Scaling::new(scene.solved()).free().to_vec();
    let mut out = Vec::new();
    for p in of {
        let Some(index) = parameters.index_of(&p.name) else { continue };
        let Some(k) = free.iter().position(|&f| f == index) else { continue };
        let value = fit.theta[index];
        let half = NINETY * covariance[(k, k)].sqrt() * (p.bounds[1] - p.bounds[0]);
        out.push(Estimate {
            parameter: p.name.clone(),
            value,
            unit: p.unit.clone(),
            interval: [(value - half).max(p.bounds[0]), (value + half).min(p.bounds[1])],
        });
    }
    Ok(out)
}
