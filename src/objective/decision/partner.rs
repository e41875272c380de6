//! The modes of a model by the names that a user gives them.

use crate::catalogue::did_you_mean;
use crate::correlation::CorrelationError;
use crate::data::Partner;
use crate::model::{ModeLabel, label_modes};
use crate::objective::comparison::Comparison;
use crate::objective::prediction::Prediction;

/// Names of the elastic modes of a prediction; none where the model cannot tell.
pub(super) fn names(comparison: &Comparison<'_>, theta: &[f64], p: &Prediction) -> Option<Vec<ModeLabel>> {
    let characters = comparison.model().characters(theta, &p.modes.shapes, p.modes.n_rigid).ok()??;
    Some(label_modes(&characters).split_off(p.modes.n_rigid))
}

/// The elastic mode, from 0, that a user means.
pub(super) fn resolve(
    comparison: &Comparison<'_>,
    theta: &[f64],
    test_mode: usize,
    partner: &Partner,
) -> Result<usize, CorrelationError> {
    let p = comparison.predict(theta).map_err(|e| CorrelationError::Model(e.to_string()))?;
    let refused = |reason: String| CorrelationError::Partner { mode: test_mode + 1, reason };
    let n = p.frequencies_hz.len();
    let label = match partner {
        Partner::Number(k) if (1..=n).contains(k) => return Ok(k - 1),
        Partner::Number(k) => {
            return Err(refused(format!("{k} is not a mode of the model: modes 1 to {n} are compared")));
        }
        Partner::Label(label) => label,
    };
    let Some(named) = names(comparison, theta, &p) else {
        return Err(refused(format!(
            "`{label}` is not a number, and the modes of this model have no names; give the number from `retune modes`"
        )));
    };
    let is_name = |m: &ModeLabel| m.long.eq_ignore_ascii_case(label) || m.short.eq_ignore_ascii_case(label);
    if let Some(k) = named.iter().position(is_name) {
        return Ok(k);
    }
    let suggestion = did_you_mean(label, named.iter().map(|m| m.long.as_str()));
    Err(refused(format!("no mode of the model is called `{label}`{suggestion}; `retune modes` lists them")))
}
