//! Criteria profiles: named pass marks with their source, and the judgement of a comparison against them.
//!
//! A profile is plain YAML that a user copies and edits. Its `source` says where the numbers come from and `verified`
//! whether the text of that source was read; marks that are only widely quoted say so.

use crate::yaml::{self, Problem};
use serde::{Deserialize, Serialize};

/// Marks for one class of modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeMarks {
    /// The class: "primary", "fundamental", "all", ...; the first class of a profile serves modes of unknown class.
    pub class: String,
    /// Largest |f_a - f_x|/f_x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frequency_tolerance: Option<f64>,
    /// Smallest MAC of a pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mac: Option<f64>,
    /// Smallest modulus of the cross-orthogonality of a pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_orthogonality: Option<f64>,
}

/// A named set of pass marks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CriteriaProfile {
    /// Short name.
    pub name: String,
    /// Where the marks come from.
    pub source: String,
    /// Whether that source's text was read when the profile was written.
    pub verified: bool,
    /// Marks by class of mode.
    pub modes: Vec<ModeMarks>,
    /// Largest MAC between modes that are not a pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mac_off_diagonal: Option<f64>,
    /// Largest cross-orthogonality, by modulus, between modes that are not a pair.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_orthogonality_off_diagonal: Option<f64>,
    /// Largest auto-orthogonality of the test shapes off the diagonal, by modulus.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub auto_orthogonality_off_diagonal: Option<f64>,
}

/// Why profiles cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CriteriaError {
    /// The text is not a list of profiles.
    #[error("the criteria profiles cannot be read: {0}")]
    Yaml(Problem),
    /// A mark is outside its range.
    #[error("profile `{profile}`: `{mark}` is {value}; it must be {expected}")]
    Mark {
        /// The profile.
        profile: String,
        /// The mark.
        mark: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range.
        expected: &'static str,
    },
    /// A profile has no class of modes.
    #[error("profile `{profile}` has no entry under `modes`; give at least one, for example {{class: all, mac: 0.9}}")]
    NoModes {
        /// The profile.
        profile: String,
    },
    /// A file with no profile or several, and no word on which.
    #[error("the file holds {}; name one, for example `profiles.yaml:NAME`", if known.is_empty() { "no criteria profile".to_owned() } else { format!("several criteria profiles: {known}") })]
    Several {
        /// Their names.
        known: String,
    },
    /// There is no profile of that name.
    #[error("there is no criteria profile `{name}`{hint}; there are {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// "; did you mean ...", or nothing.
        hint: String,
        /// All names.
        known: String,
    },
}

/// The built-in profiles, as YAML to copy and edit.
pub const BUILTIN_PROFILES: &str = include_str!("criteria/profiles.yaml");

/// Reads a list of profiles and checks every mark.
pub fn parse_profiles(text: &str) -> Result<Vec<CriteriaProfile>, CriteriaError> {
    let (profiles, _) =
        yaml::read::<Vec<CriteriaProfile>>(text).map_err(|mut p| CriteriaError::Yaml(p.swap_remove(0)))?;
    for profile in &profiles {
        profile.check()?;
    }
    Ok(profiles)
}

/// The profile of a name among built-in ones and others, which come first.
pub fn find_profile(name: &str, others: &[CriteriaProfile]) -> Result<CriteriaProfile, CriteriaError> {
    let builtin = parse_profiles(BUILTIN_PROFILES)?;
    let all: Vec<&CriteriaProfile> = others.iter().chain(&builtin).collect();
    if let Some(found) = all.iter().find(|p| p.name == name) {
        return Ok((*found).clone());
    }
    let names: Vec<&str> = all.iter().map(|p| p.name.as_str()).collect();
    let hint = crate::catalogue::did_you_mean(name, names.iter().copied());
    Err(CriteriaError::Unknown { name: name.to_owned(), hint, known: names.join(", ") })
}

impl CriteriaProfile {
    fn check(&self) -> Result<(), CriteriaError> {
        if self.modes.is_empty() {
            return Err(CriteriaError::NoModes { profile: self.name.clone() });
        }
        let refuse =
            |mark, value: f64, expected| Err(CriteriaError::Mark { profile: self.name.clone(), mark, value, expected });
        for marks in &self.modes {
            match marks.frequency_tolerance {
                Some(t) if !(t > 0.0 && t < 1.0) => {
                    return refuse("frequency_tolerance", t, "a fraction between 0 and 1, 0.05 for 5 %");
                }
                _ => {}
            }
        }
        let classes = self.modes.iter().flat_map(|m| [("mac", m.mac), ("cross_orthogonality", m.cross_orthogonality)]);
        let fractions = classes.chain([
            ("mac_off_diagonal", self.mac_off_diagonal),
            ("cross_orthogonality_off_diagonal", self.cross_orthogonality_off_diagonal),
            ("auto_orthogonality_off_diagonal", self.auto_orthogonality_off_diagonal),
        ]);
        for (mark, value) in fractions {
            match value {
                Some(v) if !(0.0..=1.0).contains(&v) => return refuse(mark, v, "between 0 and 1, 0.9 for 90 %"),
                _ => {}
            }
        }
        Ok(())
    }

    /// The marks for a class; the first entry for an unknown or no class.
    ///
    /// # Panics
    /// If the profile has no modes, which [`parse_profiles`] refuses.
    pub fn marks(&self, class: Option<&str>) -> &ModeMarks {
        class.and_then(|class| self.modes.iter().find(|m| m.class == class)).unwrap_or(&self.modes[0])
    }

    /// Judges a comparison.
    ///
    /// A mark that the profile sets and the evidence lacks (a cross-orthogonality without a mass, for example) is not
    /// passed: it appears with `value: None`. An unpaired target mode fails by itself.
    pub fn judge(&self, evidence: &Evidence) -> Judgement {
        let mut checks = Vec::new();
        for pair in &evidence.pairs {
            let marks = self.marks(pair.class.as_deref());
            let mut at_least = |what, mark: Option<f64>, value: Option<f64>, probability| {
                if let Some(limit) = mark {
                    let passed = value.is_some_and(|v| v >= limit);
                    checks.push(Check { subject: pair.name.clone(), what, value, limit, passed, probability });
                }
            };
            at_least("mac", marks.mac, pair.mac, pair.mac_probability.as_ref().and_then(|p| marks.mac.map(p)));
            let probability =
                pair.cross_orthogonality_probability.as_ref().and_then(|p| marks.cross_orthogonality.map(p));
            at_least("cross orthogonality", marks.cross_orthogonality, pair.cross_orthogonality, probability);
            if let Some(limit) = marks.frequency_tolerance {
                checks.push(Check {
                    subject: pair.name.clone(),
                    what: "frequency error",
                    value: Some(pair.frequency_error),
                    limit,
                    passed: pair.frequency_error.abs() <= limit,
                    probability: pair.frequency_probability.as_ref().map(|p| p(limit)),
                });
            }
        }
        for name in &evidence.unpaired {
            let (subject, what) = (name.clone(), "paired");
            checks.push(Check { subject, what, value: None, limit: 1.0, passed: false, probability: None });
        }
        for (what, mark, value) in [
            ("mac off the diagonal", self.mac_off_diagonal, evidence.mac_off_diagonal),
            (
                "cross orthogonality off the diagonal",
                self.cross_orthogonality_off_diagonal,
                evidence.cross_orthogonality_off_diagonal,
            ),
            (
                "auto orthogonality off the diagonal",
                self.auto_orthogonality_off_diagonal,
                evidence.auto_orthogonality_off_diagonal,
            ),
        ] {
            if let Some(limit) = mark {
                let passed = value.is_some_and(|v| v <= limit);
                let subject = "all modes".to_owned();
                checks.push(Check { subject, what, value, limit, passed, probability: None });
            }
        }
        let sure = |c: &Check| c.probability.unwrap_or(f64::from(u8::from(c.passed)));
        let probability = if checks.is_empty() { 0.0 } else { checks.iter().map(sure).product() };
        Judgement { passed: !checks.is_empty() && checks.iter().all(|c| c.passed), probability, checks }
    }
}

/// The probability of passing a mark, as a function of the mark.
pub type ProbabilityOf = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// What is known of one pair.
#[derive(Default)]
pub struct PairEvidence {
    /// How the pair is called in the result.
    pub name: String,
    /// Its class of mode.
    pub class: Option<String>,
    /// (f_a - f_x)/f_x.
    pub frequency_error: f64,
    /// MAC, when there are shapes.
    pub mac: Option<f64>,
    /// Modulus of the cross-orthogonality, when there is a mass.
    pub cross_orthogonality: Option<f64>,
    /// Probability that the error is within a tolerance, see [`super::probability_of_frequency`].
    pub frequency_probability: Option<ProbabilityOf>,
    /// Probability that the MAC reaches a mark, see [`super::probability_of_mac`].
    pub mac_probability: Option<ProbabilityOf>,
    /// Probability that the cross-orthogonality reaches a mark, see [`super::probability_of_cross_orthogonality`].
    pub cross_orthogonality_probability: Option<ProbabilityOf>,
}

/// What a comparison offers to a profile.
#[derive(Default)]
pub struct Evidence {
    /// The pairs.
    pub pairs: Vec<PairEvidence>,
    /// Names of target modes without a partner.
    pub unpaired: Vec<String>,
    /// Largest MAC off the pairs.
    pub mac_off_diagonal: Option<f64>,
    /// Largest modulus of the cross-orthogonality off the pairs.
    pub cross_orthogonality_off_diagonal: Option<f64>,
    /// Largest modulus of the auto-orthogonality of the test shapes off the diagonal.
    pub auto_orthogonality_off_diagonal: Option<f64>,
}

/// One mark against one value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// The pair, the unpaired mode, or "all modes".
    pub subject: String,
    /// What is compared.
    pub what: &'static str,
    /// Its value; `None` when it is missing.
    pub value: Option<f64>,
    /// The mark.
    pub limit: f64,
    /// Whether the value passes.
    pub passed: bool,
    /// Probability that the true value passes, given the uncertainty of the test, where it is known.
    pub probability: Option<f64>,
}

/// The verdict of a profile.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Judgement {
    /// Whether every check passes; false when there is nothing to check.
    pub passed: bool,
    /// Probability that all true values pass, given the uncertainty of the test: the product over the checks, whose noises
    /// are independent; a check without a probability counts as 1 or 0.
    pub probability: f64,
    /// The checks, pair by pair, then unpaired modes, then those over all modes.
    pub checks: Vec<Check>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtin_profiles_read_back_and_name_their_source() {
        let profiles = parse_profiles(BUILTIN_PROFILES).unwrap();
        assert!(profiles.iter().all(|p| p.source.len() > 10));
        let names: Vec<&str> = profiles.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names[0], "common-practice");
        for name in ["nasa-std-5002", "smc-s-004", "ecss-e-st-32-11"] {
            let profile = find_profile(name, &[]).unwrap();
            assert!(!profile.verified && profile.source.contains("not verified"), "{name}");
        }
        let text = yaml::write(&profiles);
        assert_eq!(parse_profiles(&text).unwrap(), profiles);
    }

    #[test]
    fn wrong_profiles_are_refused() {
        let error =
            parse_profiles("[{name: a, source: b, verified: true, modes: [{class: all, macc: 0.9}]}]").unwrap_err();
        let said = error.to_string();
        assert!(said.contains("`macc`") && said.contains("did you mean `mac`?"), "{said}");
        let error =
            parse_profiles("[{name: a, source: b, verified: true, modes: [{class: all, mac: 90}]}]").unwrap_err();
        assert_eq!(error.to_string(), "profile `a`: `mac` is 90; it must be between 0 and 1, 0.9 for 90 %");
        let text = "[{name: a, source: b, verified: true, modes: [{class: all, frequency_tolerance: 5}]}]";
        assert!(matches!(parse_profiles(text), Err(CriteriaError::Mark { mark: "frequency_tolerance", .. })));
        assert!(matches!(
            parse_profiles("[{name: a, source: b, verified: true, modes: []}]"),
            Err(CriteriaError::NoModes { .. })
        ));
        let error = find_profile("nasa-std-5003", &[]).unwrap_err().to_string();
        assert!(error.contains("did you mean `nasa-std-5002`?"), "{error}");
    }

    #[test]
    fn a_comparison_is_judged_class_by_class() {
        let profile = find_profile("ecss-e-st-32-11", &[]).unwrap();
        let pair = |name: &str, class: &str, frequency_error: f64, mac: f64| PairEvidence {
            name: name.to_owned(),
            class: Some(class.to_owned()),
            frequency_error,
            mac: Some(mac),
            frequency_probability: Some(Box::new(|tolerance| if tolerance > 0.04 { 0.9 } else { 0.2 })),
            ..PairEvidence::default()
        };
        let mut evidence = Evidence {
            pairs: vec![pair("mode 1", "fundamental", 0.02, 0.95), pair("mode 2", "other", -0.045, 0.82)],
            ..Evidence::default()
        };
        let verdict = profile.judge(&evidence);
        assert!(verdict.passed, "{verdict:?}");
        let frequency = |k: usize| verdict.checks.iter().filter(|c| c.what == "frequency error").nth(k).unwrap();
        assert_eq!((frequency(0).limit, frequency(0).probability), (0.03, Some(0.2)));
        assert_eq!((frequency(1).limit, frequency(1).probability), (0.05, Some(0.9)));
        evidence.unpaired.push("mode 3".to_owned());
        assert!(!profile.judge(&evidence).passed);
        // A mark without evidence is not passed.
        let nasa = find_profile("nasa-std-5002", &[]).unwrap();
        evidence.unpaired.clear();
        assert!(nasa.judge(&evidence).checks.iter().any(|c| c.what == "cross orthogonality" && c.value.is_none()));
        assert!(!nasa.judge(&Evidence::default()).passed);
    }
}
