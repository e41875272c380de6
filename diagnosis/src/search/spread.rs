//! Changes that are spread over the structure: the stiffness or the mass of every element a little different, as no single effect
//! makes them. They are what "something outside the catalogue" looks like to a model of beams.
//!
//! ```text
//! k_e = (1 + s_e) k_e,    s_e ~ N(0, τ²) for every element e;    ln Z = ln mean over τ of exp(ln Z_τ)
//! ```
//!
//! Each is fitted in full, all factors beside the parameters of the base, and its evidence pays for every factor that the data
//! determine. So a single effect is preferred where one explains the test, and a spread where it would take several.
//!
//! A spread can follow most changes of a structure, so that it brings the parameters of the base near their truth where a large effect has
//! pulled the fit into a wrong basin: hypotheses are fitted again from there.

use crate::error::{DiagnosisError, unsolvable};
use crate::problem::evidence::{ln_evidence, ln_sum};
use crate::problem::fit::Fit;
use crate::problem::race::{Pick, Round, STEPS, fit_by};
use crate::problem::scene::Scene;
use crate::screen::stage::Stage;
use crate::thresholds::{NINETY, SPREAD_FACTOR, SPREAD_SCALES};
use rayon::prelude::*;
use retune::effect::{Context, Part, PartKind, Structure};
use retune::linalg::DVector;
use retune::model::spec::{OverrideSpec, ParameterSpec};
use retune::units::Scalar;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fmt;

/// What is spread: each alone, and both.
const FIELDS: [&[Property]; 3] = [&[Property::Stiffness], &[Property::Mass], &[Property::Stiffness, Property::Mass]];

/// A property of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Property {
    /// Its whole stiffness matrix.
    Stiffness,
    /// Its whole mass matrix.
    Mass,
}

impl fmt::Display for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Property::Stiffness => "stiffness",
            Property::Mass => "mass",
        })
    }
}

/// A part that differs from the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SpreadFactor {
    /// Its name in the file.
    pub part: String,
    /// What differs.
    pub property: Property,
    /// Factor on that property.
    pub factor: f64,
    /// 90 % interval of the factor.
    pub interval: [f64; 2],
}

/// A change that is spread over the structure, fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// ln of its Bayes factor against the base.
    pub ln_bayes: f64,
    /// Σ ((model - test)/σ)² that it leaves.
    pub misfit: f64,
    /// Every part, the most changed first.
    pub factors: Vec<SpreadFactor>,
}

impl Spread {
    /// Root mean square of the changes.
    pub fn rms(&self) -> f64 {
        let sum: f64 = self.factors.iter().map(|f| (f.factor - 1.0).powi(2)).sum();
        (sum / self.factors.len().max(1) as f64).sqrt()
    }

    /// The parts that differ clearly: one is outside their interval.
    pub fn clear(&self) -> impl Iterator<Item = &SpreadFactor> {
        self.factors.iter().filter(|f| f.interval[0] > 1.0 || f.interval[1] < 1.0)
    }

    /// What differs: stiffness, mass, or both.
    pub fn properties(&self) -> BTreeSet<Property> {
        self.factors.iter().map(|f| f.property).collect()
    }
}

impl fmt::Display for Spread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 4;
        let properties = self.properties();
        let what: Vec<String> = properties.iter().map(ToString::to_string).collect();
        let (what, verb) = (what.join(" and "), if what.len() > 1 { "vary" } else { "varies" });
        let percent = 100.0 * self.rms();
        write!(
            f,
            "a model whose {what} {verb} from part to part, by {percent:.0} % rms, leaves a misfit of {:.0}",
            self.misfit
        )?;
        let most: Vec<String> = self.clear().take(SHOWN).map(SpreadFactor::in_words).collect();
        if most.is_empty() { Ok(()) } else { write!(f, ", most of all the {}", most.join(", ")) }
    }
}

impl SpreadFactor {
    /// `stiffness of left_wing.2 (+21 %)`
    fn in_words(&self) -> String {
        format!("{} of {} ({:+.0} %)", self.property, self.part, 100.0 * (self.factor - 1.0))
    }
}

/// A spread, and where it has brought the parameters of the base.
pub(crate) struct Fitted {
    pub(crate) spread: Spread,
    pub(crate) base: DVector<f64>,
}

/// Fits every spread, from where the base and the best hypotheses are; those that cannot be fitted are left out.
///
/// * `bases` - values of the parameters of the base from which to start
pub(crate) fn spreads(stage: &Stage, bases: &[DVector<f64>]) -> Result<Vec<Fitted>, DiagnosisError> {
    // A stand-in has no room for as many shapes as there are parts.
    let Some(scene) = stage.scene.by_itself()? else { return Ok(Vec::new()) };
    let base = ln_evidence(&stage.fit)?;
    let work = stage.settings.listener.work("fitting changes of every element", FIELDS.len() * SPREAD_SCALES.len());
    let of = |properties: &&[Property]| {
        let parts: Vec<(Property, String)> =
            properties.iter().flat_map(|&p| parts(stage, p).into_iter().map(move |name| (p, name))).collect();
        if parts.is_empty() {
            return None;
        }
        let mut starts: Vec<DVector<f64>> = bases.iter().map(|x| neutral(x, parts.len())).collect();
        let mut found: Vec<(f64, Fit)> = Vec::new();
        // From the middle: each is a start of the next.
        for scale in [SPREAD_SCALES[1], SPREAD_SCALES[0], SPREAD_SCALES[2]] {
            if stage.settings.until.is_over() {
                break;
            }
            if let Ok((evidence, fit)) = fit_spread(stage, &scene, &parts, scale, &starts) {
                starts = vec![fit.x.clone()];
                found.push((evidence, fit));
            }
            work.step();
        }
        let (_, fit) = found.iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        let evidences: Vec<f64> = found.iter().map(|f| f.0).collect();
        let n = fit.x.len() - parts.len();
        let ln_bayes = ln_sum(&evidences) - (SPREAD_SCALES.len() as f64).ln() - base;
        let spread = Spread { ln_bayes, misfit: fit.misfit, factors: factors(parts, fit).ok()? };
        Some(Fitted { spread, base: fit.x.rows(0, n).into_owned() })
    };
    let done: Vec<Option<Fitted>> = FIELDS.par_iter().map(of).collect();
    Ok(done.into_iter().flatten().collect())
}

/// The one with the largest evidence.
pub(crate) fn best(spreads: &[Fitted]) -> Option<&Fitted> {
    spreads.iter().max_by(|a, b| a.spread.ln_bayes.total_cmp(&b.spread.ln_bayes))
}

/// The factors of a fit with their intervals, the most changed first.
fn factors(parts: Vec<(Property, String)>, fit: &Fit) -> Result<Vec<SpreadFactor>, DiagnosisError> {
    let (_, covariance) = fit.hessian()?;
    let (theta, n) = (fit.theta.len() - parts.len(), fit.x.len() - parts.len());
    let of = |(k, (property, part)): (usize, (Property, String))| {
        let factor = fit.theta[theta + k];
        let half = NINETY * covariance[(n + k, n + k)].sqrt() * (SPREAD_FACTOR[1] - SPREAD_FACTOR[0]);
        SpreadFactor {
            part,
            property,
            factor,
            interval: [factor - half, factor + half].map(|v| v.clamp(SPREAD_FACTOR[0], SPREAD_FACTOR[1])),
        }
    };
    let mut out: Vec<SpreadFactor> = parts.into_iter().enumerate().map(of).collect();
    out.sort_by(|a, b| (b.factor - 1.0).abs().total_cmp(&(a.factor - 1.0).abs()));
    Ok(out)
}

/// Values of the base with every factor at one.
fn neutral(x: &DVector<f64>, n: usize) -> DVector<f64> {
    x.clone().resize_vertically(x.len() + n, (1.0 - SPREAD_FACTOR[0]) / (SPREAD_FACTOR[1] - SPREAD_FACTOR[0]))
}

/// ln Z_τ and the fit, factors last.
///
/// * `scene` - of the stage, without stand-ins
fn fit_spread(
    stage: &Stage,
    scene: &Scene,
    parts: &[(Property, String)],
    scale: f64,
    starts: &[DVector<f64>],
) -> Result<(f64, Fit), DiagnosisError> {
    let mut file = (*scene.file).clone();
    for (k, (property, part)) in parts.iter().enumerate() {
        // No file is expected to have such names.
        let name = format!("retune.spread.{}", k + 1);
        let parameter = ParameterSpec {
            value: Scalar::constant(1.0),
            bounds: Some(SPREAD_FACTOR.map(Scalar::constant)),
            unit: None,
            prior_sd: Some(Scalar::constant(scale)),
            description: String::new(),
        };
        let factor = Some(Scalar::parse(&name).map_err(unsolvable)?);
        let (stiffness, mass) = match property {
            Property::Stiffness => (factor, None),
            Property::Mass => (None, factor),
        };
        file.parameters.insert(name.clone(), parameter);
        file.overrides
            .insert(name, OverrideSpec { of: vec![part.clone()], stiffness, mass, ..OverrideSpec::default() });
    }
    let scene = scene.with_file(file, scene.added.clone())?;
    let effort = stage.effort();
    let rounds = vec![
        Round { pick: Pick::Lowest(effort.spread_starts), steps: effort.spread_steps },
        Round { pick: Pick::Lowest(1), steps: STEPS },
    ];
    let fit = fit_by(&scene, &[starts.to_vec()], rounds, stage.weight)?;
    let ln_priors = -(parts.len() as f64) * (scale / (SPREAD_FACTOR[1] - SPREAD_FACTOR[0])).ln();
    Ok((ln_evidence(&fit)? + ln_priors, fit))
}

/// Names of the parts that may differ: elements, of a fine mesh whole members.
fn parts(stage: &Stage, property: Property) -> Vec<String> {
    let context = Context::default();
    let structure = Structure::new(stage.scene.model(), &context);
    let has = |e: &usize| match property {
        Property::Stiffness => structure.deforms(*e),
        Property::Mass => structure.is_heavy(*e),
    };
    let of = |is_taken: &dyn Fn(&Part) -> bool| -> Vec<String> {
        let taken = structure.parts().iter().filter(|p| is_taken(p) && p.elements.iter().any(has));
        taken.map(|p| p.name.clone()).collect()
    };
    let elements = of(&|p| p.kind == PartKind::Element);
    if elements.len() <= stage.effort().spread_parts {
        elements
    } else {
        of(&|p| p.is_member && matches!(p.kind, PartKind::Chain | PartKind::Element))
    }
}
