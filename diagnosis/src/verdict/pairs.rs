//! The pairs of measured modes, of the fitted model and of one with what is named.

use crate::error::DiagnosisError;
use crate::result::{BasePair, BasePairs};
use retune::data::{Standing, TestMode};
use retune::objective::Comparison;

pub(crate) fn pairs_of(c: &Comparison<'_>, theta: &[f64]) -> Result<BasePairs, DiagnosisError> {
    let p = c.predict(theta)?;
    let test = c.test();
    let mode = |(m, mode): (usize, &TestMode)| {
        let partner = p.partner(m);
        BasePair {
            test_hz: mode.frequency_hz.value,
            model_mode: partner.map(|a| a + 1),
            mac: partner.filter(|_| mode.shape.is_some()).map(|a| p.mac[(a, m)]),
            probability: match mode.standing {
                Standing::Found { probability, .. } => partner.map(|_| probability),
                _ => None,
            },
            by_user: mode.standing.is_named(),
            reason: mode.standing.reason(),
        }
    };
    let mac = c.mac_of_all(&p);
    Ok(BasePairs {
        test: test.name.clone(),
        model_hz: p.frequencies_hz.clone(),
        mac: mac.row_iter().map(|r| r.iter().copied().collect()).collect(),
        modes: test.modes.iter().enumerate().map(mode).collect(),
    })
}
