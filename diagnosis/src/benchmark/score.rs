//! The score: shares with their counts, calibration, confusion.

use super::case::{Class, Outcome};
use crate::result::Verdict;
use serde::Serialize;
use std::collections::BTreeMap;

/// So many of so many.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Share {
    /// Cases where it is so.
    pub count: usize,
    /// Cases.
    pub of: usize,
}

impl Share {
    fn of<'a>(cases: impl Iterator<Item = &'a Outcome>, is: impl Fn(&Outcome) -> bool) -> Self {
        cases.fold(Self { count: 0, of: 0 }, |s, o| Self { count: s.count + usize::from(is(o)), of: s.of + 1 })
    }

    fn sum(counts: impl Iterator<Item = [usize; 2]>) -> Self {
        counts.fold(Self { count: 0, of: 0 }, |s, [count, of]| Self { count: s.count + count, of: s.of + of })
    }

    /// The share; NaN of nothing.
    pub fn value(self) -> f64 {
        self.count as f64 / self.of as f64
    }
}

/// Stated probabilities against how often they were right.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Calibration {
    /// Per bin of the stated probability: mean stated, share right, cases.
    pub bins: Vec<(f64, f64, usize)>,
    /// Σ cases |stated - right| / Σ cases.
    pub expected_error: f64,
}

impl Calibration {
    /// Ten equal bins of the probability of the most probable answer.
    fn new<'a>(cases: impl Iterator<Item = &'a Outcome>) -> Self {
        let mut sums = [(0.0, 0.0, 0_usize); 10];
        for o in cases {
            let bin = &mut sums[((10.0 * o.stated) as usize).min(9)];
            bin.0 += o.stated;
            bin.1 += f64::from(u8::from(o.stated_right));
            bin.2 += 1;
        }
        let n: usize = sums.iter().map(|b| b.2).sum();
        let error = sums.iter().map(|b| (b.0 - b.1).abs()).sum::<f64>() / n.max(1) as f64;
        let bins = sums.iter().filter(|b| b.2 > 0).map(|b| (b.0 / b.2 as f64, b.1 / b.2 as f64, b.2)).collect();
        Self { bins, expected_error: error }
    }
}

/// The score of a benchmark.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Score {
    /// Cases with nothing missing that were not called adequate.
    pub false_alarms: Share,
    /// Effects that can be seen, among those that were hidden.
    pub visible_effects: Share,
    /// Visible effects: kind and place first.
    pub right_first: Share,
    /// The same, or an effect with the same trace in these data first.
    pub alike_first: Share,
    /// Visible effects: kind first.
    pub right_kind: Share,
    /// Visible effects: first or tied with the first.
    pub in_tie_set: Share,
    /// Visible effects: something else named, with nothing tied, and not the same trace.
    pub wrong_and_alone: Share,
    /// Visible faults.
    pub faults_visible: Share,
    /// Visible faults: kind and sensor first.
    pub faults_right: Share,
    /// Visible changes outside the catalogue that were called adequate.
    pub outside_adequate: Share,
    /// The same, called unexplained.
    pub outside_unexplained: Share,
    /// Visible effects: at least nine tenths of the error gone after the first hypothesis.
    pub error_removed: Share,
    /// Modes that are not of the structure and were named.
    pub foreign_named: Share,
    /// Modes of the structure that were called foreign.
    pub true_lost: Share,
    /// Of all that was diagnosed.
    pub calibration: Calibration,
    /// Per hidden name: what was found, how often.
    pub confusion: BTreeMap<String, BTreeMap<String, usize>>,
    /// Per structure: false alarms, kind and place first, first or tied.
    pub structures: BTreeMap<String, [Share; 3]>,
}

impl Score {
    pub(super) fn new(outcomes: &[Outcome]) -> Self {
        let class = |c: Class| outcomes.iter().filter(move |o| o.class == c);
        let seen = |c: Class| class(c).filter(|o| o.visible);
        let alarmed = |o: &Outcome| o.verdict != Some(Verdict::Adequate);
        let mut confusion: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
        for o in outcomes.iter().filter(|o| o.verdict.is_some()) {
            let answer = match o.verdict {
                Some(Verdict::Adequate) => "adequate".to_string(),
                Some(v @ (Verdict::Unexplained | Verdict::NoiseOrModel)) => v.word().to_string(),
                _ => o.found.clone(),
            };
            *confusion.entry(o.name.clone()).or_default().entry(answer).or_default() += 1;
        }
        let mut structures = BTreeMap::new();
        for name in outcomes.iter().map(|o| o.structure.clone()) {
            let here = |o: &&Outcome| o.structure == name;
            let shares = [
                Share::of(class(Class::Nothing).filter(here), alarmed),
                Share::of(seen(Class::Effect).filter(here), |o| o.right),
                Share::of(seen(Class::Effect).filter(here), |o| o.tied),
            ];
            structures.insert(name.clone(), shares);
        }
        Self {
            false_alarms: Share::of(class(Class::Nothing), alarmed),
            visible_effects: Share::of(class(Class::Effect), |o| o.visible),
            right_first: Share::of(seen(Class::Effect), |o| o.right),
            alike_first: Share::of(seen(Class::Effect), |o| o.alike),
            right_kind: Share::of(seen(Class::Effect), |o| o.right_kind),
            in_tie_set: Share::of(seen(Class::Effect), |o| o.tied),
            wrong_and_alone: Share::of(seen(Class::Effect), |o| {
                let named = matches!(o.verdict, Some(Verdict::MissingEffect | Verdict::MeasurementFault));
                named && !o.right && !o.alike && o.ties == 0
            }),
            faults_visible: Share::of(class(Class::Fault), |o| o.visible),
            faults_right: Share::of(seen(Class::Fault), |o| o.right),
            outside_adequate: Share::of(seen(Class::Outside), |o| !alarmed(o)),
            outside_unexplained: Share::of(seen(Class::Outside), |o| o.verdict == Some(Verdict::Unexplained)),
            error_removed: Share::of(seen(Class::Effect), |o| o.removed >= 0.9),
            foreign_named: Share::sum(outcomes.iter().map(|o| o.foreign_named)),
            true_lost: Share::sum(outcomes.iter().map(|o| o.true_lost)),
            calibration: Calibration::new(outcomes.iter().filter(|o| o.verdict.is_some())),
            confusion,
            structures,
        }
    }
}
