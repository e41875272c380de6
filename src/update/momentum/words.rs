//! What the check of sensors by a model has found, in words.

use super::{Check, MOMENTUM_LEVEL, SensorChange, SensorCheck, ShapeMomentum};
use crate::fault::{Fault, SensorDead, SensorGain, SensorSign, SensorSwap};
use crate::identify::health::{Finding, Level};

impl Check<'_> {
    fn describe(&self, edit: &SensorChange) -> (&'static str, String, String, &'static str) {
        let name = |k: usize| self.sensors[k].name.clone();
        match edit {
            SensorChange::Turn { sensors } if sensors.len() == 1 => (
                SensorSign.name(),
                name(sensors[0]),
                format!("sensor {} has the wrong sign", name(sensors[0])),
                "reverse the direction of the sensor in the test file, and run this check again: it then finds nothing here",
            ),
            SensorChange::Turn { sensors } => {
                let list: Vec<String> = sensors.iter().map(|&k| name(k)).collect();
                let list = list.join(", ");
                (
                    "group-flipped",
                    list.clone(),
                    format!("the sensors {list}, which stand on one body, have the wrong sign together"),
                    "reverse the directions of these sensors in the test file, and run this check again: it then finds nothing here",
                )
            }
            SensorChange::Swap { sensors: [k, l] } => (
                SensorSwap.name(),
                format!("{} / {}", name(*k), name(*l)),
                format!("sensors {} and {} are swapped", name(*k), name(*l)),
                "exchange the places of the two sensors in the test file",
            ),
            SensorChange::Scale { sensor, factor } => (
                SensorGain.name(),
                name(*sensor),
                format!("sensor {} has the wrong gain: its entries times {factor:.3} fit", name(*sensor)),
                "compare the sensitivity of the channel with its calibration sheet and correct it; leave the sensor out if no cause is found",
            ),
            SensorChange::Dead { sensor } => (
                SensorDead.name(),
                name(*sensor),
                format!("sensor {} reads nothing but noise where the structure moves", name(*sensor)),
                "check the cable and the mounting; leave the sensor out of the test file",
            ),
            SensorChange::Drop { sensor } => (
                "does-not-fit",
                name(*sensor),
                format!(
                    "sensor {} does not fit the motions of the model, and no other sign or gain is clearly better",
                    name(*sensor)
                ),
                "look at its place and axis on the structure; if they are as stated, the model may lack something beside it: ask `retune diagnose` before it is left out",
            ),
            SensorChange::Structure { sensor } => (
                "structure-differs",
                name(*sensor),
                format!("the structure differs from the model at or near sensor {}", name(*sensor)),
                "none for the sensor; `retune diagnose` finds what the model lacks there",
            ),
        }
    }

    pub(super) fn findings(&self, check: &SensorCheck, rivals: &[Vec<SensorChange>], threshold: f64) -> Vec<Finding> {
        let mut findings = Vec::new();
        let dof: usize = check.momentum.iter().map(|m| m.degrees_of_freedom).sum();
        let per_dof = |of: fn(&ShapeMomentum) -> f64| check.momentum.iter().map(of).sum::<f64>() / dof.max(1) as f64;
        let (before, after) = (per_dof(|m| m.chi_squared), per_dof(|m| m.chi_squared_after));
        for ((edit, evidence), rivals) in check.changes.iter().zip(rivals) {
            let (code, subject, mut text, remedy) = self.describe(edit);
            let is_fault = !matches!(edit, SensorChange::Structure { .. });
            text += match edit {
                SensorChange::Structure { .. } => {
                    ": a mass or a spring that the model lacks there moves the shapes as they were measured, and no sensor is accused"
                }
                SensorChange::Drop { .. } => ": without it the shapes fit the motions of the model",
                _ => ": with that change the shapes fit the motions of the model",
            };
            if !rivals.is_empty() {
                let list: Vec<String> = rivals.iter().map(|r| self.describe(r).2).collect();
                text += &format!("; the data fit nearly as well if {}", list.join(", or if "));
            }
            let mut numbers = vec![("log evidence", *evidence), ("needed", threshold)];
            if dof > 0 {
                numbers.extend([("momentum, χ² per degree of freedom", before), ("after the changes", after)]);
            }
            let level = if is_fault { Level::Warning } else { Level::Info };
            findings.push(Finding { level, code, subject, evidence: numbers, text, remedy });
        }
        if dof > 0 && check.chance[1] < MOMENTUM_LEVEL {
            let worst = check.momentum.iter().max_by(|a, b| a.chi_squared_after.total_cmp(&b.chi_squared_after));
            if let Some(w) = worst {
                let hz = self.modes[w.test_mode].frequency_hz.value;
                // A remark: wrong masses of a model that was never updated do the same, and no sensor is accused.
                findings.push(Finding {
                    level: Level::Info,
                    code: "rigid-body-momentum",
                    subject: format!("{hz:.2} Hz"),
                    evidence: vec![
                        ("share of rigid-body motion", w.share_after),
                        ("share that noise and model allow", w.expected_share),
                        ("χ² per degree of freedom", after),
                        ("chance", check.chance[1]),
                    ],
                    text: format!(
                        "the shapes have momentum that a free vibration cannot have, most at {hz:.2} Hz ({:.1} % rigid-body motion, noise and model \
                         allow {:.1} %), and no change of one sensor removes it",
                        100.0 * w.share_after,
                        100.0 * w.expected_share
                    ),
                    remedy: "compare mass and centre of gravity of the model with weighings, and the suspension's frequencies with a tenth of the first \
                             elastic one; what remains then is the model's mass distribution, which `retune diagnose` examines",
                });
            }
        }
        for &m in &check.foreign {
            let hz = self.modes[m].frequency_hz.value;
            findings.push(Finding {
                level: Level::Info,
                code: "foreign-shape",
                subject: format!("{hz:.2} Hz"),
                evidence: vec![("frequency", hz)],
                text: format!("the shape at {hz:.2} Hz fits no motion of the model near this frequency, so it was not used to judge the sensors"),
                remedy: "none for the sensors; `retune compare` shows which mode of the model comes nearest",
            });
        }
        if !check.undecided.is_empty() {
            let names: Vec<&str> = check.undecided.iter().map(|&k| self.sensors[k].name.as_str()).collect();
            findings.push(Finding {
                level: Level::Info,
                code: "sign-not-decidable",
                subject: format!("{} sensors", names.len()),
                evidence: vec![("sensors", names.len() as f64)],
                text: format!("these shapes and this model cannot tell whether the sign is wrong at: {}", names.join(", ")),
                remedy: "push the structure by hand beside each of them: the first swing must have the sign of its direction",
            });
        }
        findings
    }
}
