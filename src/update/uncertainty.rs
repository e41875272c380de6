//! How certain the parameters of a fit are: standard deviations, intervals, correlations, what cannot be told apart.
//!
//! One linearisation at the optimum gives everything but the check: two costs a parameter tell whether the cost is as
//! quadratic as its linearisation says, and where it is not, the interval comes from a profile of the cost itself.

mod intervals;
mod shared;

pub use shared::Inseparable;

use super::UpdateError;
use crate::correlation::{correlations, covariance, identifiability, information};
use crate::linalg::{DMatrix, DVector};
use crate::model::ParametricModel;
use crate::objective::{Objective, Scaling};
use intervals::{End, Quadratic};

/// Rise of the cost (half a squared sum) at the ends of a 90 % interval: half the 90 % quantile of χ² with one degree.
pub(crate) const RISE_90: f64 = 1.352_771_727;

/// Singular values below this share of the largest belong to combinations that no data of this kind tell.
const UNSEEN: f64 = 1e-7;

/// A parameter on its bound counts as held by it when crossing its interval would cost at least this at first order.
const HELD: f64 = 1e-2;

/// A parameter is on its bound within this share of its interval,
const NEAR: f64 = 1e-6;
/// and within so many standard deviations, the others known.
const NEAR_IN_SD: f64 = 1e-2;

/// The check of the quadratic model: the largest part of the rise by which the cost may differ from it.
const CURVED: f64 = 0.25;

/// How certain the free parameters of a fit are.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    /// The free parameters, in the order of the model.
    pub parameters: Vec<ParameterUncertainty>,
    /// Correlations of those with a standard deviation; NaN for the others, which have none (see
    /// [`ParameterUncertainty::why_no_sd`]).
    pub correlations: DMatrix<f64>,
    /// Number of combinations of parameters that the data and priors see.
    pub rank: usize,
    /// Sets of parameters that cannot be told apart by data of this kind.
    pub inseparable: Vec<Inseparable>,
    /// Costs and linearisations spent on it.
    pub evaluations: u64,
    /// What limits the meaning of the numbers.
    pub remarks: Vec<String>,
}

/// How certain one parameter is; numbers in the unit of its tables.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterUncertainty {
    /// Its name.
    pub name: String,
    /// Standard deviation with the others free; `None` where the data do not determine it or a bound holds it.
    pub sd: Option<f64>,
    /// 90 % interval.
    pub interval: [f64; 2],
    /// Whether an end of the interval is the bound of the parameter and not a limit that the data set.
    pub ends_at_bound: [bool; 2],
    /// Where the interval comes from.
    pub method: IntervalMethod,
    /// Whether it sits on a bound: no farther from it than a hundredth of a standard deviation.
    pub on_bound: bool,
    /// The bound that holds it, if one does.
    pub held: Option<Held>,
}

impl ParameterUncertainty {
    /// Whether the data leave the whole interval between the bounds open.
    pub fn is_undetermined(&self) -> bool {
        self.ends_at_bound == [true, true]
    }

    /// Why it has no standard deviation, and so no correlation with others; `None` where it has one.
    pub fn why_no_sd(&self) -> Option<&'static str> {
        match (self.sd, self.held) {
            (Some(_), _) => None,
            (None, Some(_)) => Some("held by a bound"),
            (None, None) => Some("not seen alone"),
        }
    }
}

/// Where an interval comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalMethod {
    /// The quadratic model of the cost inside the bounds; the cost agrees with it at the ends.
    Quadratic,
    /// The profile of the cost itself, the others refitted.
    Profile,
    /// The quadratic model, although the cost differs from it: the allowance for profiles was spent, or they failed.
    Unconfirmed,
}

impl IntervalMethod {
    /// "quadratic", "profile" or "unconfirmed".
    pub fn word(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Profile => "profile",
            Self::Unconfirmed => "unconfirmed",
        }
    }
}

/// A parameter that a bound holds: without it the fit would go on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Whether it is the upper bound.
    pub is_upper: bool,
    /// Where the quadratic model of the cost would have it without this bound; `None` where nothing but the bound stops it.
    pub would_be: Option<f64>,
    /// By how much the squared misfit Σ r² would fall then.
    pub gain: f64,
}

/// What an uncertainty is the uncertainty of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// The point is the minimum of the objective.
    Minimum {
        /// Most evaluations and linearisations for profiles.
        allowance: u64,
    },
    /// The point is the minimum of another cost: the standard deviations of the data are propagated through the
    /// sensitivities of the objective there, as if the data were met, and nothing is checked.
    Propagated,
}

/// How certain the parameters are at an optimum.
///
/// ```text
/// J = ∂r/∂x at the optimum x*,   x free of bounds: covariance (JᵀJ)⁻¹,  sd_j = √[(JᵀJ)⁻¹]_jj
/// interval of x_j: { v : min over the others in the box of ½|r + J d|², d_j = v - x*_j,  <= cost* + ½ χ²₁(0.9) }
/// ```
///
/// * `objective` - residuals in standard deviations; its cost is half their squared sum
/// * `scaling` - of the objective, from the unit box to the parameters of the model
/// * `x` - the optimum, in the unit box
/// * `basis` - whether that is the minimum of this objective
///
/// Parameters that a bound holds (on it, with the cost falling outwards) have no standard deviation and are fixed in the
/// covariance of the others. The intervals do more: there every parameter may move inside its bounds, so that an interval
/// is neither cut nor widened wrongly by an active bound, and one that the data do not limit ends at the bounds. Where
/// the cost at an end of an interval differs from the quadratic model by more than a quarter of the rise, the end is
/// found on the profile of the cost itself, by Gauss-Newton steps in the other parameters.
///
/// # Errors
/// The objective cannot be linearised at `x`.
///
/// # Source
/// G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, sections 2.1, 5.4 and 5.9; D. J. Venzon, S. H. Moolgavkar, A
/// method for computing profile-likelihood-based confidence intervals, Applied Statistics 37, 1988.
pub fn uncertainty(
    objective: &dyn Objective,
    model: &dyn ParametricModel,
    scaling: &Scaling,
    x: &DVector<f64>,
    basis: Basis,
) -> Result<Uncertainty, UpdateError> {
    let mut at = objective.linearize(x)?;
    if basis == Basis::Propagated {
        at.residuals.fill(0.0);
    }
    let cost = 0.5 * at.residuals.norm_squared();
    let quadratic = Quadratic::new(&at.jacobian, &at.residuals, x);
    let n = x.len();
    let mut remarks = Vec::new();
    if quadratic.promise() > 0.05 * RISE_90 {
        remarks.push(format!(
            "the fit is not at a minimum: the quadratic model promises a misfit lower by {:.3}; the intervals are those of that model",
            2.0 * quadratic.promise()
        ));
    }
    let gradient = at.jacobian.tr_mul(&at.residuals);
    // The share alone would put 4000 N/m in 0 ... 1e12 N/m on its bound.
    let is_on = |distance: f64, j: usize| distance <= NEAR && distance * at.jacobian.column(j).norm() <= NEAR_IN_SD;
    let on: Vec<[bool; 2]> = (0..n).map(|j| [is_on(x[j], j), is_on(1.0 - x[j], j)]).collect();
    let held: Vec<bool> =
        (0..n).map(|j| (on[j][0] && gradient[j] > HELD) || (on[j][1] && gradient[j] < -HELD)).collect();
    let open: Vec<usize> = (0..n).filter(|&j| !held[j]).collect();
    let of_open = at.jacobian.select_columns(&open);
    let known = information(&of_open, None, UNSEEN)?;
    let rho = correlations(&covariance(&of_open, None, UNSEEN)?);
    let mut sd = vec![None; n];
    let mut correlation = DMatrix::from_element(n, n, f64::NAN);
    for (a, &i) in open.iter().enumerate() {
        sd[i] = known[a].sd;
        for (b, &j) in open.iter().enumerate() {
            if known[a].sd.is_some() && known[b].sd.is_some() {
                correlation[(i, j)] = rho[(a, b)];
            }
        }
    }

    let mut ends = quadratic.ends();
    let (methods, evaluations) = match basis {
        Basis::Minimum { allowance } => confirm(objective, x, cost, &mut ends, allowance, &mut remarks),
        Basis::Propagated => {
            remarks.push(
                "the cost has no standard deviations: those of the data are propagated through the sensitivities at the optimum"
                    .to_string(),
            );
            (vec![IntervalMethod::Quadratic; n], 1)
        }
    };

    let parameters = model.parameters();
    let names: Vec<String> = scaling.free().iter().map(|&i| parameters.get(i).name.clone()).collect();
    let theta = scaling.theta(x);
    let slopes = scaling.slopes(&theta);
    let in_tables = |j: usize, x_j: f64| {
        let p = parameters.get(scaling.free()[j]);
        p.display(match scaling.decades()[j] {
            Some(_) => scaling.value(j, x_j),
            None => theta[scaling.free()[j]] + (x_j - x[j]) * scaling.width()[j],
        })
    };
    let list = (0..n)
        .map(|j| {
            let p = parameters.get(scaling.free()[j]);
            let span = p.display(slopes[j]);
            ParameterUncertainty {
                name: p.name.clone(),
                sd: sd[j].map(|s| s * span.abs()),
                interval: [in_tables(j, ends[j][0].x), in_tables(j, ends[j][1].x)],
                ends_at_bound: [ends[j][0].is_bound, ends[j][1].is_bound],
                method: methods[j],
                on_bound: on[j] != [false, false],
                held: held[j].then(|| {
                    let set: Vec<usize> = open.iter().copied().chain([j]).collect();
                    let (step, gain) = beyond(&at.jacobian.select_columns(&set), gradient[j]);
                    let is_upper = on[j][1];
                    let would_be = step.map(|s| in_tables(j, x[j] + s)).filter(|v| v.is_finite());
                    Held { is_upper, would_be, gain }
                }),
            }
        })
        .collect();
    let seen = identifiability(&at.jacobian, &names, Some(&slopes), UNSEEN)?;
    let inseparable = shared::inseparable(model, &theta, scaling, &seen);
    Ok(Uncertainty { parameters: list, correlations: correlation, rank: seen.rank, inseparable, evaluations, remarks })
}

/// How far the last of the parameters would go beyond its bound, and the fall of the squared misfit; all others of the set
/// have a vanishing gradient.
fn beyond(jacobian: &DMatrix<f64>, gradient: f64) -> (Option<f64>, f64) {
    let last = jacobian.ncols() - 1;
    let sd = information(jacobian, None, UNSEEN).ok().and_then(|i| i[last].sd);
    match sd {
        Some(sd) => {
            let step = -gradient * sd * sd;
            // A model that is quadratic over ten intervals is none.
            ((step.abs() < 10.0).then_some(step), (gradient * sd).powi(2))
        }
        None => (None, 2.0 * gradient.abs()),
    }
}

/// Compares the cost at the ends with the quadratic model and replaces ends that it does not confirm.
fn confirm(
    objective: &dyn Objective,
    x: &DVector<f64>,
    cost: f64,
    ends: &mut [[End; 2]],
    allowance: u64,
    remarks: &mut Vec<String>,
) -> (Vec<IntervalMethod>, u64) {
    let places: Vec<(usize, usize)> =
        (0..ends.len()).flat_map(|j| [(j, 0), (j, 1)]).filter(|&(j, s)| ends[j][s].x != x[j]).collect();
    let points: Vec<DVector<f64>> = places.iter().map(|&(j, s)| ends[j][s].point.clone()).collect();
    let mut costs = vec![0.0; points.len()];
    objective.costs(&points, &mut costs);
    let mut evaluations = points.len() as u64;
    let mut methods = vec![IntervalMethod::Quadratic; ends.len()];
    let mut doubtful: Vec<(f64, usize, usize)> = places
        .iter()
        .zip(&costs)
        .map(|(&(j, s), c)| ((c - cost - ends[j][s].rise).abs(), j, s))
        // An end on a bound stays one as long as the cost there is no higher than the rise allows.
        .filter(|&(off, j, s)| {
            let tolerated = CURVED * RISE_90;
            off.is_nan()
                || if ends[j][s].is_bound { off > RISE_90 - ends[j][s].rise + tolerated } else { off > tolerated }
        })
        .collect();
    doubtful.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut lower = None;
    for (_, j, side) in doubtful {
        if evaluations + intervals::MOST_PER_END > allowance + points.len() as u64 {
            methods[j] = IntervalMethod::Unconfirmed;
            continue;
        }
        let (found, spent) = intervals::profile(objective, x, cost, j, side, &ends[j][side]);
        evaluations += spent;
        match found {
            Ok(end) => {
                ends[j][side] = end;
                if methods[j] == IntervalMethod::Quadratic {
                    methods[j] = IntervalMethod::Profile;
                }
            }
            Err(better) => {
                lower = better.or(lower);
                methods[j] = IntervalMethod::Unconfirmed;
            }
        }
    }
    if let Some(better) = lower {
        remarks.push(format!(
            "a profile met a lower cost ({better:.4} instead of {cost:.4}): the fit is not at its best optimum; search again with another seed or a global method"
        ));
    }
    (methods, evaluations)
}

#[cfg(test)]
mod tests;
