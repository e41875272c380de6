//! The answer to one question: the modes as they stand, at the stated noise or at larger one.

use super::error::DiagnosisError;
use super::problem::evidence::p_of_less;
use super::problem::scene::Scene;
use super::result::Diagnosis;
use super::screen::stage::{Stage, stage_begun};
use super::search::basin::in_the_lowest_basin;
use super::search::board::merge;
use super::search::hypothesis::{Refit, Tried};
use super::search::run::refit_these;
use super::search::singles::{refit, weighed_anew};
use super::settings::Settings;
use super::verdict::decide::{better_than_noise, conclude};
use crate::thresholds::{MOST_NOISE, REMAINDER};
use retune::linalg::DVector;

/// A diagnosis with what a next step needs.
pub(super) struct Investigation {
    pub(super) diagnosis: Diagnosis,
    pub(super) base: Stage,
    pub(super) refits: Vec<Refit>,
}

/// The same with the modes as they stand.
///
/// * `begun` - where the parameters came while the pairs were decided
/// * `known` - hypotheses that have explained much of the same data already: they are fitted whatever the search finds
pub(super) fn investigate_these(
    scene: Scene,
    (starts, begun): (&[DVector<f64>], Option<&DVector<f64>>),
    known: &[&Tried],
    weight: Option<f64>,
    settings: &Settings,
) -> Result<Investigation, DiagnosisError> {
    let is_aside = scene.test.modes.iter().all(|m| m.standing.is_aside());
    if is_aside && !scene.cases.iter().any(|c| c.test.has_more_than_modes()) {
        return Err(DiagnosisError::NoPartner);
    }
    let base = stage_begun(scene, starts, begun, weight.unwrap_or(1.0), settings)?;
    let mut refits = refit(&base, false)?;
    if !known.is_empty() {
        let bases: Vec<DVector<f64>> = begun.into_iter().chain([&base.fit.x]).cloned().collect();
        merge(&base, &mut refits.hypotheses, refit_these(&base, known, &bases)?);
        refits.hypotheses.sort_by(|a, b| b.ln_bayes.total_cmp(&a.ln_bayes));
    }
    let (base, mut refits) = in_the_lowest_basin(base, refits, settings)?;
    let mut at_stated_noise = None;
    // Larger noise than stated is a hypothesis like the others: it is taken where none explains the test better, and where there is time to weigh the
    // others by it.
    let may_weigh = weight.is_none() && base.scatter.s2 > 1.0 && !settings.until.is_over();
    if may_weigh && !better_than_noise(&base, &refits.hypotheses)? {
        let factor = base.scatter.s2.sqrt();
        // Noise that is hardly believable has to stand against several things that are wrong at the stated noise, too.
        if factor > MOST_NOISE {
            let diagnosis = conclude(&base, &mut refits, settings)?;
            if diagnosis.verdict.names_hypotheses() {
                return Ok(Investigation { diagnosis, base, refits: refits.hypotheses });
            }
            at_stated_noise = Some(diagnosis);
        }
        let again = base.with_on_top(base.scene.clone(), &base.fit.x, factor.recip(), settings)?;
        let mut found = weighed_anew(&again, &refits)?;
        let diagnosis = conclude(&again, &mut found, settings)?;
        // What is named may leave less than noise of that size: then the misfit of a wrong base was taken for scatter.
        if !leaves_too_little(&again, &diagnosis) {
            return Ok(Investigation { diagnosis, base: again, refits: found.hypotheses });
        }
    }
    let diagnosis = match at_stated_noise {
        Some(diagnosis) => diagnosis,
        None => conclude(&base, &mut refits, settings)?,
    };
    Ok(Investigation { diagnosis, base, refits: refits.hypotheses })
}

/// Whether what is named leaves clearly less than the noise that it was judged by.
fn leaves_too_little(base: &Stage, found: &Diagnosis) -> bool {
    let is_named = found.verdict.names_hypotheses();
    let left = found.hypotheses.first().map_or(f64::INFINITY, |h| h.misfit_after * base.weight * base.weight);
    is_named && p_of_less(left, found.degrees_of_freedom) < REMAINDER
}
