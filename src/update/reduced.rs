//! A search on reduced models, and the refinement of what it finds on the full ones.

use super::{Cost, Settings, TestCase, UpdateError};
use crate::data::TestData;
use crate::model::{ParametricModel, ReducedModel, ReducedOptions};
use crate::optim::{Improvement, LevenbergMarquardt, NelderMead, OptimizerSpec, Optimum};

/// Modes beside those of the test that a reduced model must have right: partners may sit between others.
const MORE_MODES: usize = 4;

/// From so many dofs on a search is on reduced models without being asked for it.
const FROM: usize = 10_000;
/// Largest relative error of a frequency then, and as a part of the smallest standard deviation of one.
const TOLERANCE: f64 = 1e-4;
const PART_OF_SD: f64 = 0.1;
/// Least that is asked for: an estimate of a smaller one is rounding.
const LEAST: f64 = 1e-6;

/// To which relative error of frequencies models are reduced for a search; `None` where it is on the full ones.
pub(super) fn tolerance(cases: &[TestCase<'_>], settings: &Settings) -> Option<f64> {
    let is_large = |c: &TestCase<'_>| c.model.dof_map().n_dof() >= FROM;
    let can_be = |c: &TestCase<'_>| c.model.affine().is_some() && is_of_modes(c.test);
    settings.reduced.or_else(|| {
        let sds = cases.iter().flat_map(|c| &c.test.modes).map(|m| m.frequency_hz.sd / m.frequency_hz.value);
        let by_sd = PART_OF_SD * sds.filter(|sd| *sd > 0.0).fold(f64::INFINITY, f64::min);
        cases.iter().all(|c| is_large(c) && can_be(c)).then(|| by_sd.clamp(LEAST, TOLERANCE))
    })
}

/// Whether a test asks for modes and mass alone.
fn is_of_modes(test: &TestData) -> bool {
    test.static_tests.is_empty() && test.frfs.is_none()
}

/// What a search on reduced models had to do with.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedSearch {
    /// Dofs of the model and of its reduced one, for each test.
    pub dofs: Vec<(usize, usize)>,
    /// Values of the parameters whose modes and derivatives the reduced models are made of, in all.
    pub n_samples: usize,
    /// Largest estimated relative error of a frequency within the bounds.
    pub accuracy: f64,
    /// What was asked for.
    pub tolerance: f64,
    /// Costs and linearizations of the reduced models.
    pub evaluations: u64,
    /// The cost at the best point of the search, of the reduced models and of the full ones.
    pub costs: [f64; 2],
}

/// The models of some tests, reduced.
#[derive(Debug)]
pub(super) struct ReducedCases<'a> {
    models: Vec<ReducedModel<'a>>,
    tests: Vec<&'a TestData>,
    full: Vec<usize>,
    tolerance: f64,
}

impl<'a> ReducedCases<'a> {
    /// * `tolerance` - of the relative error of frequencies
    pub(super) fn new(cases: &[TestCase<'a>], tolerance: f64) -> Result<Self, UpdateError> {
        let reduce = |case: &TestCase<'a>| {
            if !is_of_modes(case.test) {
                return Err(UpdateError::NotReduced { test: case.test.name.clone() });
            }
            let n_modes = case.test.modes.len() + MORE_MODES;
            let options = ReducedOptions { n_modes, tolerance, ..ReducedOptions::default() };
            Ok(ReducedModel::new(case.model, options)?)
        };
        Ok(Self {
            models: cases.iter().map(reduce).collect::<Result<_, _>>()?,
            tests: cases.iter().map(|c| c.test).collect(),
            full: cases.iter().map(|c| c.model.dof_map().n_dof()).collect(),
            tolerance,
        })
    }

    pub(super) fn cases(&self) -> Vec<TestCase<'_>> {
        self.models.iter().zip(&self.tests).map(|(model, test)| TestCase { model, test }).collect()
    }

    pub(super) fn summary(&self, evaluations: u64, costs: [f64; 2]) -> ReducedSearch {
        ReducedSearch {
            dofs: self.full.iter().zip(&self.models).map(|(&full, m)| (full, m.dof_map().n_dof())).collect(),
            n_samples: self.models.iter().map(|m| m.samples().len()).sum(),
            accuracy: self.models.iter().map(ReducedModel::accuracy).fold(0.0, f64::max),
            tolerance: self.tolerance,
            evaluations,
            costs,
        }
    }
}

/// A reduction of half a squared misfit for which the full models are not solved again.
const NO_GAIN: f64 = 1e-4;

/// What refines on the full models.
pub(super) fn refiner(cost: Cost) -> OptimizerSpec {
    match cost {
        Cost::LeastSquares => {
            let method = LevenbergMarquardt { gain: NO_GAIN, ..LevenbergMarquardt::default() };
            OptimizerSpec::LevenbergMarquardt(method)
        }
        Cost::Paper | Cost::Frequencies => OptimizerSpec::NelderMead(NelderMead::default()),
    }
}

/// Both searches as one: the optimum of the second, and what the first tells of other optima.
pub(super) fn joined(found: Optimum, refined: Optimum) -> Optimum {
    let stages = [found.stages.clone(), vec![found.stage(), refined.stage()]].concat();
    let before = found.evaluations + found.linearizations;
    let mut history = found.history;
    for step in refined.history {
        if history.last().is_none_or(|last| step.cost < last.cost) {
            history.push(Improvement { evaluations: before + step.evaluations, cost: step.cost });
        }
    }
    Optimum {
        method: format!("{} on a reduced model, then {}", found.method, refined.method),
        history,
        stages,
        optima: found.optima,
        n_starts: found.n_starts,
        warnings: [found.warnings, refined.warnings].concat(),
        ..refined
    }
}
