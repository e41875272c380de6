//! What to minimise, how modes are paired, by which method.

use super::{HowToPair, ObjectiveSpec};
use crate::correlation::{PairBy, PairingOptions};
use crate::data::TestData;
use crate::model::ParametricModel;
use crate::optim::{Auto, OptimizerSpec, Sequence};
use serde::{Deserialize, Serialize};

/// The cost to minimise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cost {
    /// Weighted least squares: residuals over their standard deviations.
    #[default]
    LeastSquares,
    /// Equation (4) of Gupta et al. divided by 2n: MAC and relative frequencies.
    Paper,
    /// The norm of the relative frequency errors.
    Frequencies,
}

crate::catalogue::choice! { Cost, "cost";
    LeastSquares "least-squares" "Residuals over their standard deviations",
    Paper "paper" "Equation (4) of Gupta et al.: MAC and relative frequencies",
    Frequencies "frequencies" "Norm of the relative frequency errors",
}

/// Parameters up to which a small model is searched from so many starts that an optimum is missed with a probability of 3 % if a tenth of
/// them lead to it.
const FEW: usize = 6;
const THOROUGH: usize = 32;

/// Settings of an update.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// The cost.
    pub cost: Cost,
    /// How modes are paired: inferred for least squares; for the paper's cost by MAC alone, and for frequencies, or for lack of shapes,
    /// by order within symmetry families, as published.
    pub pairing: HowToPair,
    /// The method; `auto` for least squares, [`Sequence::global_then_local`] for the paper's cost,
    /// [`Sequence::many_starts_then_local`] for frequencies.
    pub optimizer: Option<OptimizerSpec>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Terms, loss, regularisation and limits of the cost `least-squares`; the other costs take its limits only.
    pub objective: ObjectiveSpec,
    /// Search on reduced models whose frequencies are right to this part, then refine on the full ones: for models so large that
    /// their solutions are what a search takes its time for.
    pub reduced: Option<f64>,
}

impl Settings {
    /// How modes are paired under this cost.
    pub(super) fn how(&self, test: &TestData) -> HowToPair {
        let has_shapes = test.modes.iter().any(|m| m.shape.is_some());
        let published = match self.cost {
            Cost::LeastSquares => None,
            Cost::Paper if has_shapes => Some(PairBy::Mac),
            Cost::Paper | Cost::Frequencies => Some(PairBy::Order),
        };
        HowToPair { by: self.pairing.by.or(published), ..self.pairing }
    }

    /// The rule with open gates: a fit sees every mode that was found to be of the structure, at every θ.
    pub fn pairing(&self, test: &TestData) -> PairingOptions {
        match self.how(test).by {
            Some(by) => PairingOptions { by, ..self.pairing.rule(test) },
            None => self.pairing.rule(test),
        }
    }

    /// The method for a model: of a small one with few parameters more starts than of others.
    pub(super) fn optimizer_for(&self, model: &dyn ParametricModel) -> OptimizerSpec {
        let is_small = !super::is_large(model) && model.parameters().free().len() <= FEW;
        match (&self.optimizer, self.cost) {
            (None, Cost::LeastSquares) if is_small => {
                OptimizerSpec::Auto(Auto { starts: THOROUGH, fewest: THOROUGH, ..Auto::default() })
            }
            _ => self.optimizer(),
        }
    }

    /// The method.
    pub fn optimizer(&self) -> OptimizerSpec {
        self.optimizer.clone().unwrap_or_else(|| match self.cost {
            Cost::LeastSquares => OptimizerSpec::default(),
            // The paper's dispatch: a global search without derivatives, then a local refiner.
            Cost::Paper => OptimizerSpec::Sequence(Sequence::global_then_local()),
            Cost::Frequencies => OptimizerSpec::Sequence(Sequence::many_starts_then_local()),
        })
    }
}
