//! A posterior, parameter by parameter, in the units of the model file.

use crate::correlation::correlations;
use crate::linalg::DMatrix;
use crate::model::ParametricModel;
use crate::objective::Scaling;
use crate::optim::Posterior;

/// Quantiles that are told.
pub const QUANTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// The posterior of one parameter, in its unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Marginal {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub sd: f64,
    /// At [`QUANTILES`].
    pub quantiles: [f64; 5],
    /// Correlations with all free parameters, in their order, its own among them.
    pub correlations: Vec<f64>,
}

/// The posterior of every free parameter.
pub fn marginals(posterior: &Posterior, model: &dyn ParametricModel) -> Vec<Marginal> {
    let scaling = Scaling::new(model);
    let covariance = posterior.covariance();
    let rho = correlations(&covariance);
    let mean = posterior.mean();
    let one = |j: usize| {
        let p = model.parameters().get(scaling.free()[j]);
        let shown = |x: f64| shown(model, &scaling, j, x);
        Marginal {
            name: p.name.clone(),
            unit: p.unit.clone(),
            mean: shown(mean[j]),
            sd: (shown(covariance[(j, j)].sqrt()) - shown(0.0)).abs(),
            quantiles: QUANTILES.map(|q| shown(posterior.quantile(j, q))),
            correlations: (0..mean.len()).map(|k| rho[(j, k)]).collect(),
        }
    };
    (0..mean.len()).map(one).collect()
}

/// The samples in the units of the parameters, (n_samples x n_free).
pub fn sampled_values(posterior: &Posterior, model: &dyn ParametricModel) -> DMatrix<f64> {
    let scaling = Scaling::new(model);
    DMatrix::from_fn(posterior.samples.len(), scaling.len(), |i, j| shown(model, &scaling, j, posterior.samples[i][j]))
}

/// A coordinate of the unit box as a value in the unit of its parameter.
fn shown(model: &dyn ParametricModel, scaling: &Scaling, j: usize, x: f64) -> f64 {
    let p = model.parameters().get(scaling.free()[j]);
    let [lower, _] = p.bounds.unwrap_or([p.value; 2]);
    p.display(lower + x * scaling.width()[j])
}
