//! How modes are paired: one answer for every verb.
//!
//! Pairs are inferred, see [`decide`]. A user may ask for a rule instead, give gates to either, and name partners, foreign modes and
//! unused ones in the test file.

use super::{SensorCheck, UpdateError, trust};
use crate::catalogue::Choice;
use crate::correlation::{CorrelationError, PairBy, PairingOptions};
use crate::data::{Standing, TestData};
use crate::linalg::DVector;
use crate::objective::{Comparison, Deciding, Decision, Scaling, decide, decide_by_rule, starting_point};

/// Share of frequencies that tell nothing in a comparison: its model has not been updated, and may be off by any factor. Shapes pair then.
const FAR_OFF: f64 = 0.05;

/// How modes are paired.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HowToPair {
    /// The rule; none where pairs are inferred, with modes that are not of the structure among them.
    pub by: Option<PairBy>,
    /// Smallest MAC of a pair.
    pub min_mac: Option<f64>,
    /// g of the relative frequency window: f_a/f_x within [1/(1+g), 1+g].
    pub frequency_window: Option<f64>,
}

impl Default for HowToPair {
    fn default() -> Self {
        Self::probable()
    }
}

impl HowToPair {
    /// The word and the meaning of pairs that are inferred, beside the rules of [`PairBy`].
    pub const PROBABLE: (&str, &str) = (
        "probable",
        "The most probable pairs by shape, frequency, label and symmetry together; what is not of the structure has none",
    );

    /// The rule of a word; none is that of the most probable pairs.
    ///
    /// # Errors
    /// For any other word: the list.
    pub fn by_word(word: &str) -> Result<Option<PairBy>, String> {
        if word == Self::PROBABLE.0 { Ok(None) } else { PairBy::parse(word).map(Some) }
    }

    /// Pairs that are inferred.
    pub const fn probable() -> Self {
        Self { by: None, min_mac: None, frequency_window: None }
    }

    /// Pairs by a rule.
    pub const fn by_rule(by: PairBy) -> Self {
        Self { by: Some(by), min_mac: None, frequency_window: None }
    }

    /// The rule by which a fit pairs, at every point, what was found to be of the structure.
    pub fn rule(&self, test: &TestData) -> PairingOptions {
        let has_likeness = test.modes.iter().any(|m| m.shape.is_some() || m.standing.is_followed());
        let by = match self.by {
            None | Some(PairBy::Mac | PairBy::NearMac) if !has_likeness => PairBy::Order,
            None => PairBy::NearMac,
            Some(by) => by,
        };
        PairingOptions { by, min_mac: 0.0, frequency_window: f64::INFINITY, same_family_only: true }
    }

    /// The same for a comparison, where the gates of a rule flag or forbid a pair: the usual ones where none are given.
    pub(crate) fn gated_rule(&self, test: &TestData) -> PairingOptions {
        let usual = PairingOptions::default();
        let gates = if self.infers() { (0.0, f64::INFINITY) } else { (usual.min_mac, usual.frequency_window) };
        PairingOptions {
            min_mac: self.min_mac.unwrap_or(gates.0),
            frequency_window: self.frequency_window.unwrap_or(gates.1),
            ..self.rule(test)
        }
    }

    /// Whether pairs are inferred.
    pub fn infers(&self) -> bool {
        self.by.is_none()
    }

    /// How inference is asked.
    pub(crate) fn deciding(&self, moves: bool, misread: f64) -> Deciding {
        Deciding {
            min_mac: self.min_mac.unwrap_or(0.0),
            frequency_window: self.frequency_window.unwrap_or(f64::INFINITY),
            misread,
            moves,
        }
    }

    /// Decides which modes of some tests are of the structure, for a fit, without the readings of sensors that the motions of the model
    /// contradict.
    ///
    /// * `misread` - share of frequencies that may be noted wrongly
    ///
    /// # Errors
    /// As [`decide`].
    pub fn settle(
        &self,
        comparisons: &[Comparison<'_>],
        start: &DVector<f64>,
        misread: f64,
    ) -> Result<SettledPairs, CorrelationError> {
        let n = comparisons.len();
        let (decision, checks) = if self.infers() {
            by_trusted_sensors(comparisons, start, self.deciding(true, misread))?
        } else {
            (decide_by_rule(comparisons, start, self.deciding(false, 0.0))?, vec![None; n])
        };
        let tests = comparisons.iter().enumerate().map(|(k, c)| decision.applied(k, c.test())).collect();
        Ok(SettledPairs {
            tests,
            contradicted: checks.iter().map(|c| contradicted(c.as_ref())).collect(),
            x: decision.x,
        })
    }
}

/// Tests with the standing of their modes.
pub struct SettledPairs {
    /// All readings in them.
    pub tests: Vec<TestData>,
    /// Of every test, the sensors that took no part.
    pub contradicted: Vec<Vec<usize>>,
    /// Where the parameters have gone for it, in the unit box.
    pub x: DVector<f64>,
}

fn contradicted(check: Option<&SensorCheck>) -> Vec<usize> {
    check.map_or_else(Vec::new, SensorCheck::contradicted)
}

/// [`decide`] without the readings of sensors that the motions of the model at the start contradict, and what these motions say of every test.
fn by_trusted_sensors(
    comparisons: &[Comparison<'_>],
    start: &DVector<f64>,
    options: Deciding,
) -> Result<(Decision, Vec<Option<SensorCheck>>), CorrelationError> {
    let Some(first) = comparisons.first() else { return Ok((decide(comparisons, start, options)?, Vec::new())) };
    let theta = Scaling::new(first.model()).theta(start);
    let checks: Vec<_> = comparisons.iter().map(|c| trust::check(c, &theta)).collect::<Result<_, _>>()?;
    if checks.iter().all(|check| contradicted(check.as_ref()).is_empty()) {
        return Ok((decide(comparisons, start, options)?, checks));
    }
    let without =
        |(c, check): (&Comparison<'_>, &Option<SensorCheck>)| trust::without(c.test(), &contradicted(check.as_ref()));
    let tests: Vec<TestData> = comparisons.iter().zip(&checks).map(without).collect();
    let trusted: Vec<Comparison<'_>> =
        comparisons.iter().zip(&tests).map(|(c, test)| c.with_test(test)).collect::<Result<_, _>>()?;
    Ok((decide(&trusted, start, options)?, checks))
}

/// A test with the standing of its modes.
#[derive(Debug, Clone)]
pub struct PairedTest {
    /// The test.
    pub test: TestData,
    /// What the motions of the model say of its sensors, where pairs were inferred from shapes.
    pub check: Option<SensorCheck>,
}

/// A test with the standing of its modes at a θ, for a comparison.
///
/// # Errors
/// As [`decide`].
pub fn paired_at(comparison: &Comparison<'_>, theta: &[f64], how: &HowToPair) -> Result<PairedTest, UpdateError> {
    let scaling = Scaling::new(comparison.model());
    let x = scaling.x(theta);
    let (decision, check) = if how.infers() {
        let (decision, mut checks) =
            by_trusted_sensors(std::slice::from_ref(comparison), &x, how.deciding(false, FAR_OFF))?;
        (decision, checks.pop().flatten())
    } else {
        let deciding = Deciding { moves: false, ..Deciding::default() };
        (decide_by_rule(std::slice::from_ref(comparison), &x, deciding)?, None)
    };
    Ok(PairedTest { test: decision.applied(0, comparison.test()), check })
}

/// A model and a test made comparable as `how` says, at the estimates of the model: what a comparison shows.
///
/// The test that comes back has the standing of its modes; compare with that.
///
/// # Errors
/// As [`decide`]; the sensors have no place on the model.
pub fn paired_test(
    model: &dyn crate::model::ParametricModel,
    theta: Option<&[f64]>,
    test: &TestData,
    how: &HowToPair,
) -> Result<PairedTest, UpdateError> {
    if test.modes.iter().all(|m| m.standing.is_aside()) {
        return Ok(PairedTest { test: test.clone(), check: None });
    }
    let comparison = Comparison::new(model, test, how.gated_rule(test))?;
    let estimates = starting_point(model);
    paired_at(&comparison, theta.unwrap_or(&estimates), how)
}

/// The model's own comparison for a test that was paired: by the rule and gates of `how`.
///
/// # Errors
/// The sensors have no place on the model.
pub fn compared<'a>(
    model: &'a dyn crate::model::ParametricModel,
    test: &'a TestData,
    how: &HowToPair,
) -> Result<Comparison<'a>, UpdateError> {
    Ok(Comparison::new(model, test, how.gated_rule(test))?)
}

/// A test whose pairs were found at one θ, for others: the rule pairs anew at each, as in a fit, what was found to be of the structure.
pub fn freed(test: &TestData) -> TestData {
    let mut out = test.clone();
    for mode in &mut out.modes {
        if let Standing::Found { is_fixed, by_user: false, .. } = &mut mode.standing {
            *is_fixed = false;
        }
    }
    out
}

/// A test whose modes stand as its user says, whatever was found.
pub fn as_given(test: &TestData) -> TestData {
    let mut out = test.clone();
    for mode in &mut out.modes {
        if matches!(mode.standing, Standing::Aside { .. } | Standing::Found { is_fixed: false, .. }) {
            mode.standing = Standing::Open;
        }
    }
    out
}
