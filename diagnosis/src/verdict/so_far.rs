//! What is said of a search that was stopped before its end.

use super::words::number;
use crate::error::DiagnosisError;
use crate::result::{Diagnosis, Together, Verdict};
use crate::screen::stage::Stage;
use crate::search::hypothesis::{Refit, leaving_noise};
use crate::thresholds::STRONG;

/// How many effects are told that the screening alone puts first.
const TOLD: usize = 3;

/// The sentence of an answer, as far as the search has come.
///
/// # Errors
/// A hypothesis has no evidence.
pub(crate) fn so_far(base: &Stage, refits: &[Refit], found: &Diagnosis) -> Result<String, DiagnosisError> {
    if found.verdict != Verdict::Unexplained {
        return Ok(found.sentence.clone());
    }
    let believed = "give it more time before it is believed";
    let strong = || refits.iter().filter(|r| r.ln_bayes > STRONG);
    if let Some(r) = leaving_noise(strong())? {
        let id = r.id(&base.scene);
        return Ok(format!("{id} leaves no more than noise, but what else does was not asked: {believed}"));
    }
    let two = |t: &Together| Some((<&[String; 2]>::try_from(t.best.as_slice()).ok()?.clone(), t.misfit_after?));
    if let Some(([first, second], left)) = found.together.as_ref().and_then(two) {
        return Ok(format!(
            "{first} and {second} together take the misfit from {} to {}, but what else does was not asked: {believed}",
            number(base.fit.misfit),
            number(left)
        ));
    }
    if let Some(best) = strong().max_by(|a, b| a.ln_bayes.total_cmp(&b.ln_bayes)) {
        return Ok(format!(
            "of what was fitted by then {} explains most and takes the misfit from {} to {}: give it more time before anything is believed",
            best.id(&base.scene),
            number(base.fit.misfit),
            number(best.misfit)
        ));
    }
    let first: Vec<String> = base.effects.iter().take(TOLD).map(|s| base.id(s)).collect();
    Ok(match first.split_last() {
        Some((last, others)) if refits.is_empty() => {
            let all = if others.is_empty() { last.clone() } else { format!("{} and {last}", others.join(", ")) };
            format!(
                "nothing was fitted by then; by its slopes the test asks first for {all}: give it more time, or choose among the effects and places"
            )
        }
        _ => {
            "nothing that was tried by then explains the test: give it more time before anything else is doubted".into()
        }
    })
}
