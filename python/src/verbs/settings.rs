//! What fits and samplers share.

use crate::error::Wrong;
use crate::own::{Failure, OwnOptimizer, OwnResidual};
use crate::tested::Pairing;
use pyo3::prelude::*;
use retune::catalogue::Choice as _;
use retune::objective::Residuals;
use retune::optim::{OptimizerSpec, Own};
use retune::update::{Cost, ObjectiveSpec, Settings};

/// Residual terms of the user's.
pub(crate) type OwnTerms<'py> = Vec<PyRef<'py, OwnResidual>>;

pub(crate) fn failures(terms: &OwnTerms<'_>) -> Vec<&'static Failure> {
    terms.iter().map(|own| &own.0.failure).collect()
}

/// A method by its name or settings, or one of the user's.
#[derive(FromPyObject)]
pub(crate) enum Searcher<'py> {
    /// YAML.
    Said(String),
    /// A Python object.
    Own(PyRef<'py, OwnOptimizer>),
}

/// Settings that update, sample and an objective share.
pub(crate) fn settings(
    cost: &str,
    (objective, terms): (Option<&str>, &OwnTerms<'_>),
    pairing: &Pairing,
    optimizer: Option<&Searcher<'_>>,
    seed: u64,
    reduced: Option<f64>,
) -> Result<Settings, Wrong> {
    let cost = Cost::parse(cost).map_err(|e| Wrong::text(format!("cost: {e}")))?;
    if let Some(t) = reduced.filter(|t| !(1e-9..=0.1).contains(t)) {
        return Err(Wrong::text(format!("reduced is {t}; it is a relative error of frequencies from 1e-9 to 0.1")));
    }
    let residuals = terms.iter().fold(Residuals::builtin(), |all, own| all.with(own.0));
    if cost != Cost::LeastSquares && !terms.is_empty() {
        return Err(Wrong::text(
            "residuals are terms of the cost least-squares; the other costs are whole as they are",
        ));
    }
    let objective = match objective {
        None => ObjectiveSpec { residuals, ..ObjectiveSpec::default() },
        Some(text) => ObjectiveSpec::read_with(text, residuals).map_err(|p| Wrong::problems(Some("objective"), p))?,
    };
    let method = |searcher: &Searcher<'_>| match searcher {
        Searcher::Said(text) => retune::yaml::read::<OptimizerSpec>(text).map(|(spec, _)| spec),
        Searcher::Own(own) => Ok(OptimizerSpec::Own(Own(own.0))),
    };
    let optimizer = optimizer.map(method).transpose().map_err(|p| Wrong::problems(Some("optimizer"), p))?;
    Ok(Settings { cost, pairing: pairing.how()?, optimizer, seed, objective, reduced })
}
