//! What was wrong in the readings of a test and has been taken out of it.
//!
//! Shapes and sensors of a corrected test are right as they stand. Functions that are read from files beside it still have the fault, so the
//! test keeps what has to be done to them:
//!
//! ```yaml
//! corrections:
//!   - {sensor: p11, factor: -1}            # its functions are so many times what they should be: upside down
//!   - {sensor: p3, exchanged_with: p7}     # the channels of the two are exchanged
//!   - {sensor: p5, reads_nothing: true}    # its functions are noise
//!   - {sensor: p6, stated: [0, 0, 1]}      # the direction that was stated for it; `sensors` has the right one
//!   - {sensor: p2, acted_at: p4}           # the force that was stated at p2, a sensor or a node, acted at p4
//! ```

use super::Sensor;
use crate::catalogue::did_you_mean;
use crate::yaml::Problem;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A fault of a channel that functions beside the test still have.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Correction {
    /// The sensor of the channel, by its name.
    pub sensor: String,
    /// Its functions are so many times what they should be; -1 for a sensor that is upside down.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// The sensor whose functions stand in its channel, and the other way round.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exchanged_with: Option<String>,
    /// Its functions are noise.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub reads_nothing: bool,
    /// The direction that was stated for it, a unit vector: a channel along it reads along the direction of the sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stated: Option<[f64; 3]>,
    /// The force that was stated at it, a sensor or a node, acted at this sensor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acted_at: Option<String>,
}

impl Correction {
    /// That a sensor has functions of so many times their size.
    pub fn factor(sensor: &str, factor: f64) -> Self {
        Self { sensor: sensor.to_string(), factor: Some(factor), ..Self::default() }
    }

    /// Why it says nothing, if it does: it has to say one thing, with a number that can be divided by.
    fn problem(&self) -> Option<&'static str> {
        let said = [
            self.factor.is_some(),
            self.exchanged_with.is_some(),
            self.reads_nothing,
            self.stated.is_some(),
            self.acted_at.is_some(),
        ];
        if said.iter().filter(|s| **s).count() != 1 {
            return Some("a correction says one of `factor`, `exchanged_with`, `reads_nothing`, `stated`, `acted_at`");
        }
        let is_bad = |f: f64| f == 0.0 || !f.is_finite();
        self.factor.is_some_and(is_bad).then_some("a factor is finite and not zero")
    }
}

/// What is wrong with the corrections of a test file, with their paths.
pub(super) fn problems(corrections: &[Correction], sensors: &[Sensor]) -> Vec<Problem> {
    let mut out = Vec::new();
    for (k, correction) in corrections.iter().enumerate() {
        let path = format!("corrections[{k}]");
        out.extend(correction.problem().map(|problem| Problem::error(path.clone(), problem)));
        // A force may have been stated at a node without a sensor.
        let own = Some(&correction.sensor).filter(|_| correction.acted_at.is_none());
        let others = correction.exchanged_with.iter().chain(&correction.acted_at);
        for name in own.into_iter().chain(others) {
            if !sensors.iter().any(|s| s.name == *name) {
                let suggestion = did_you_mean(name, sensors.iter().map(|s| s.name.as_str()));
                out.push(Problem::error(path.clone(), format_args!("the test has no sensor `{name}`{suggestion}")));
            }
        }
    }
    out
}
