//! Shards of a benchmark: its cases are independent, so that several machines may each run some of them.
//!
//! ```text
//! case at position p belongs to shard i of n where p mod n = i - 1
//! key = SHA-256 of what was asked: version, verb, options, what is tried
//! ```
//!
//! A shard states the key, what was asked, and the outcome of each of its cases with its position. [`merge`] takes the shards of one key to the
//! bits of what one run makes; JSON keeps every bit of a number. The version is all that a key knows of the program: shards are for one build.

use super::case::Outcome;
use super::structures::STRUCTURES;
use super::{Benchmark, Plan, run};
use crate::error::DiagnosisError;
use crate::settings::Settings;
use retune::catalogue::counted;
use retune::effect::Effect;
use retune::fault::Fault;
use retune::hash::sha256;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// The format of these files.
const FORMAT: u64 = 1;
/// This version.
const THIS: &str = env!("CARGO_PKG_VERSION");
/// What is sharded.
const VERB: &str = "benchmark diagnosis";

/// A part of several, counted from 1: `3/8`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    index: usize,
    of: usize,
}

impl Part {
    /// All of it.
    pub const WHOLE: Self = Self { index: 1, of: 1 };

    /// Which of so many; none unless 1 ≤ index ≤ of.
    pub fn new(index: usize, of: usize) -> Option<Self> {
        (1..=of).contains(&index).then_some(Self { index, of })
    }

    /// Which it is, from 1.
    pub fn index(self) -> usize {
        self.index
    }

    /// How many there are.
    pub fn of(self) -> usize {
        self.of
    }

    /// Its positions among so many cases.
    pub fn positions(self, cases: usize) -> impl Iterator<Item = usize> {
        (self.index - 1..cases).step_by(self.of)
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Part {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        let Some((index, of)) = numbers else {
            return Err("a part of several is expected, counted from 1: 3/8".to_string());
        };
        Self::new(index, of).ok_or_else(|| match of {
            0 => "there are no shards of 0".to_string(),
            _ => format!("the shards of {of} are 1/{of} ... {of}/{of}"),
        })
    }
}

/// A case and what came out; nothing where it could not be posed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct CaseResult {
    /// Place among all cases, from 0.
    pub(super) position: usize,
    pub(super) outcome: Option<Outcome>,
}

/// Some of the cases of a benchmark.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shard {
    /// Version of the format.
    retune_shard: u64,
    /// SHA-256 of `asked`, as hexadecimal digits.
    key: String,
    /// Everything that the result depends on.
    asked: Map<String, Value>,
    shard: Part,
    /// Cases of all shards.
    cases: usize,
    results: Vec<CaseResult>,
}

/// Everything that the outcomes of a plan depend on.
fn asked(plan: &Plan, settings: &Settings) -> Map<String, Value> {
    let structures = STRUCTURES.iter().map(|s| s.0).filter(|name| plan.wants(name)).map(String::from).collect();
    let options = Plan { structures, ..plan.clone() };
    let pairing = &settings.pairing;
    let Value::Object(asked) = json!({
        "version": THIS,
        "verb": VERB,
        "options": options,
        "tried": {
            "effects": settings.effects.iter().map(Effect::name).collect::<Vec<_>>(),
            "faults": settings.faults.iter().map(Fault::name).collect::<Vec<_>>(),
            "places": settings.places,
            "effort": settings.effort,
        },
        "pairing": {
            "by": pairing.by.map(|by| format!("{by:?}")),
            "min_mac": pairing.min_mac,
            "frequency_window": pairing.frequency_window,
        },
        "alarm_level": settings.alarm_level,
    }) else {
        unreachable!("braces make an object")
    };
    asked
}

/// SHA-256 of JSON with sorted keys, without blanks.
fn key_of(asked: &Map<String, Value>) -> String {
    let mut sorted = Value::Object(asked.clone());
    sorted.sort_all_objects();
    sha256(sorted.to_string().as_bytes())
}

/// Runs the cases of a part; `progress` is told how many of how many of them are done.
///
/// # Errors
/// A structure that cannot be prepared.
pub fn run_shard(
    plan: &Plan,
    settings: &Settings,
    part: Part,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Shard, DiagnosisError> {
    let (cases, results) = run(plan, settings, part, progress)?;
    let asked = asked(plan, settings);
    Ok(Shard { retune_shard: FORMAT, key: key_of(&asked), asked, shard: part, cases, results })
}

/// Why a file is not a shard that could be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShardError {
    /// Not a shard at all.
    #[error("it is not a file that `retune benchmark --shard` has written{0}")]
    NotOne(String),
    /// Of another version of the format or the program.
    #[error("it was written by retune {0}, and this is {THIS}; shards are merged by the version that made them")]
    OtherVersion(String),
    /// Edited or damaged.
    #[error("it is damaged: {0}")]
    Damaged(String),
    /// Of another benchmark.
    #[error("it is of another benchmark: {0}")]
    OtherBenchmark(String),
    /// Another part.
    #[error("it is shard {0}")]
    OtherPart(Part),
}

impl Shard {
    /// The text of its file.
    ///
    /// # Errors
    /// A number that is not finite, which JSON cannot hold.
    pub fn to_text(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string(self).map(|text| text + "\n")
    }

    /// Reads the text of a file.
    ///
    /// # Errors
    /// It is not a shard, of another version, or damaged.
    pub fn read(text: &str) -> Result<Self, ShardError> {
        let value: Value =
            serde_json::from_str(text).map_err(|e| ShardError::NotOne(format!(": it is not JSON ({e})")))?;
        let Some(format) = value.get("retune_shard") else {
            return Err(ShardError::NotOne(String::new()));
        };
        let version = value.pointer("/asked/version").and_then(Value::as_str).unwrap_or("of an unknown version");
        if format.as_u64() != Some(FORMAT) || version != THIS {
            return Err(ShardError::OtherVersion(version.to_string()));
        }
        let shard: Self = serde_json::from_value(value).map_err(|e| ShardError::Damaged(e.to_string()))?;
        let damaged = |what: &str| Err(ShardError::Damaged(what.to_string()));
        if key_of(&shard.asked) != shard.key {
            return damaged("its key is not that of what it says was asked");
        }
        if Part::new(shard.shard.index, shard.shard.of).is_none() {
            return damaged(&format!("there is no shard {}", shard.shard));
        }
        if !shard.shard.positions(shard.cases).eq(shard.results.iter().map(|r| r.position)) {
            return damaged(&format!("its cases are not those of shard {} of {} cases", shard.shard, shard.cases));
        }
        Ok(shard)
    }

    /// Whether it is this part of this plan, so that nothing need be run.
    ///
    /// # Errors
    /// It is another one, and what differs.
    pub fn check(&self, plan: &Plan, settings: &Settings, part: Part) -> Result<(), ShardError> {
        let wanted = asked(plan, settings);
        if key_of(&wanted) != self.key {
            return Err(ShardError::OtherBenchmark(differences(&self.asked, "there", &wanted, "here").join(", ")));
        }
        if self.shard == part { Ok(()) } else { Err(ShardError::OtherPart(self.shard)) }
    }

    /// Whether the cases were asked for by name, so that each is told of.
    pub fn has_diagnoses(&self) -> bool {
        self.asked.get("options").and_then(|o| o.get("only")).is_some_and(|only| !only.is_null())
    }
}

/// Why shards are not those of one run. The names of files are the caller's.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// None.
    #[error("there are no shards to merge")]
    Nothing,
    /// Of different runs.
    #[error("{one} and {other} are of different runs: {what}")]
    DifferentRuns {
        /// A file.
        one: String,
        /// Another.
        other: String,
        /// Which settings differ.
        what: String,
    },
    /// Cut into different numbers of shards.
    #[error("{one} is shard {a} and {other} is shard {b}: a run is cut in one way")]
    DifferentCuts {
        /// A file.
        one: String,
        /// Its part.
        a: Part,
        /// Another.
        other: String,
        /// Its part.
        b: Part,
    },
    /// A shard twice.
    #[error("{one} and {other} are both shard {part}; leave one of them out")]
    Twice {
        /// A file.
        one: String,
        /// Another.
        other: String,
        /// The part of both.
        part: Part,
    },
    /// Shards that are not there.
    #[error("{}", missing(*count, first))]
    Missing {
        /// How many.
        count: usize,
        /// The first of them.
        first: Vec<Part>,
    },
}

/// Missing shards that are told of, at most.
const TOLD: usize = 20;

fn missing(count: usize, first: &[Part]) -> String {
    let names: Vec<String> = first.iter().map(Part::to_string).collect();
    let more = if count > first.len() { " ..." } else { "" };
    format!("{} missing: {}{more}", counted(count, "shard"), names.join(", "))
}

/// The benchmark that one run of all cases gives, of all its shards in any order.
///
/// * `shards` - each with the name of its file
///
/// # Errors
/// Shards of different runs, twice the same, or not all of them.
pub fn merge(shards: Vec<(String, Shard)>) -> Result<Benchmark, MergeError> {
    let Some((first, head)) = shards.first() else { return Err(MergeError::Nothing) };
    for (name, shard) in &shards[1..] {
        let (one, other) = (first.clone(), name.clone());
        if shard.key != head.key {
            let what = differences(&head.asked, &format!("in {first}"), &shard.asked, &format!("in {name}")).join(", ");
            return Err(MergeError::DifferentRuns { one, other, what });
        }
        if shard.shard.of != head.shard.of {
            return Err(MergeError::DifferentCuts { one, a: head.shard, other, b: shard.shard });
        }
        if shard.cases != head.cases {
            let what = format!("`cases` is {} in {one} and {} in {other}", head.cases, shard.cases);
            return Err(MergeError::DifferentRuns { one, other, what });
        }
    }
    let of = head.shard.of;
    let mut holders: BTreeMap<usize, &str> = BTreeMap::new();
    for (name, Shard { shard: part, .. }) in &shards {
        if let Some(one) = holders.insert(part.index, name) {
            return Err(MergeError::Twice { one: one.to_string(), other: name.clone(), part: *part });
        }
    }
    if holders.len() < of {
        let absent = (1..=of).filter(|index| !holders.contains_key(index)).map(|index| Part { index, of });
        return Err(MergeError::Missing { count: of - holders.len(), first: absent.take(TOLD).collect() });
    }
    let mut results: Vec<CaseResult> = shards.into_iter().flat_map(|(_, s)| s.results).collect();
    results.sort_by_key(|r| r.position);
    Ok(Benchmark::of(results.into_iter().filter_map(|r| r.outcome).collect()))
}

/// Which settings differ: "`seed` is 1 in a.json and 2 in b.json".
fn differences(a: &Map<String, Value>, in_a: &str, b: &Map<String, Value>, in_b: &str) -> Vec<String> {
    let mut out = Vec::new();
    let keys = a.keys().chain(b.keys().filter(|k| !a.contains_key(*k)));
    for key in keys {
        match (a.get(key), b.get(key)) {
            (Some(x), Some(y)) if x == y => {}
            (Some(Value::Object(x)), Some(Value::Object(y))) => out.extend(differences(x, in_a, y, in_b)),
            (x, y) => {
                let said = |v: Option<&Value>| match v {
                    None | Some(Value::Null) => "not given".to_string(),
                    Some(v) => v.to_string(),
                };
                out.push(format!("`{key}` is {} {in_a} and {} {in_b}", said(x), said(y)));
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::benchmark::Class;
    use crate::result::Verdict;

    /// An outcome whose numbers have no short decimals.
    fn outcome(position: usize) -> Outcome {
        let x = 1.0 / (3.0 + position as f64);
        let class = [Class::Nothing, Class::Effect, Class::Fault, Class::Outside][position % 4];
        Outcome {
            structure: ["cantilever", "frame"][position % 2].to_string(),
            class,
            name: "point-mass".to_string(),
            id: format!("point-mass@n{position}"),
            seed: u64::MAX - position as u64,
            gain: 1e17 * x,
            visible: true,
            verdict: (position != 2).then_some(Verdict::MissingEffect),
            p_value: 5e-324,
            found: "mass-offset".to_string(),
            found_id: "mass-offset@\"a\\b\u{301}\"".to_string(),
            right: position.is_multiple_of(3),
            alike: false,
            right_kind: true,
            tied: false,
            refitted: true,
            ties: position,
            stated: 0.1 + 0.2 * x,
            stated_right: position % 3 == 1,
            removed: -0.0,
            noise_factor: 1.0 + f64::EPSILON,
            sizes: vec![x, x.powi(40), -x],
            misfit_of_truth: x.sqrt(),
            foreign_named: [position, 9],
            true_lost: [0, position],
            diagnosis: None,
        }
    }

    fn shard(plan: &Plan, index: usize, of: usize, cases: usize) -> Shard {
        let asked = asked(plan, &Settings::default());
        let part = Part::new(index, of).unwrap();
        // The case at position 4 could not be posed.
        let result = |position| CaseResult { position, outcome: (position != 4).then(|| outcome(position)) };
        let results = part.positions(cases).map(result).collect();
        Shard { retune_shard: FORMAT, key: key_of(&asked), asked, shard: part, cases, results }
    }

    fn named(shards: Vec<Shard>) -> Vec<(String, Shard)> {
        shards.into_iter().map(|s| (format!("{}.json", s.shard.to_string().replace('/', "-of-")), s)).collect()
    }

    fn through_text(s: &Shard) -> Shard {
        Shard::read(&s.to_text().unwrap()).unwrap()
    }

    /// Whatever the number of shards and their order, and through files, the merged outcomes and their score have the bits of one run.
    #[test]
    fn shards_in_any_order_are_the_whole() {
        let plan = Plan::default();
        let whole = Benchmark::of((0..11).filter(|p| *p != 4).map(outcome).collect());
        let whole = serde_json::to_string(&whole).unwrap();
        for of in [1, 2, 3, 11, 13] {
            let mut shards: Vec<Shard> = (1..=of).map(|i| through_text(&shard(&plan, i, of, 11))).collect();
            shards.reverse();
            shards.rotate_left(of / 2);
            let merged = merge(named(shards)).unwrap();
            assert_eq!(serde_json::to_string(&merged).unwrap(), whole, "{of} shards");
            assert_eq!(merged.outcomes[1].gain.to_bits(), outcome(1).gain.to_bits());
            assert!(merged.outcomes[0].removed.is_sign_negative());
        }
        assert_eq!(through_text(&shard(&plan, 2, 3, 11)), shard(&plan, 2, 3, 11));
    }

    /// What one run cannot have made is not merged, and each refusal names files and what is wrong.
    #[test]
    fn what_is_not_one_run_is_refused() {
        let plan = Plan::default();
        let seeded = Plan { seed: 2, only: Some("mass".to_string()), ..Plan::default() };
        let refused = |shards: Vec<Shard>| merge(named(shards)).unwrap_err().to_string();
        assert_eq!(
            refused(vec![shard(&plan, 1, 2, 9), shard(&seeded, 2, 2, 9)]),
            "1-of-2.json and 2-of-2.json are of different runs: `seed` is 1 in 1-of-2.json and 2 in 2-of-2.json, `only` is not given in 1-of-2.json and \"mass\" in 2-of-2.json"
        );
        assert_eq!(refused(vec![shard(&plan, 4, 5, 9), shard(&plan, 1, 5, 9)]), "3 shards missing: 2/5, 3/5, 5/5");
        assert_eq!(refused(vec![shard(&plan, 1, 2, 9)]), "1 shard missing: 2/2");
        let many = refused(vec![shard(&plan, 1, usize::MAX, 9)]);
        assert!(many.len() < 800 && many.contains("2/") && many.ends_with("..."), "{many}");
        assert_eq!(
            refused(vec![shard(&plan, 1, 2, 9), shard(&plan, 2, 2, 9), shard(&plan, 2, 2, 9)]),
            "2-of-2.json and 2-of-2.json are both shard 2/2; leave one of them out"
        );
        assert_eq!(
            refused(vec![shard(&plan, 1, 2, 9), shard(&plan, 2, 3, 9)]),
            "1-of-2.json is shard 1/2 and 2-of-3.json is shard 2/3: a run is cut in one way"
        );
        assert!(refused(vec![shard(&plan, 1, 2, 9), shard(&plan, 2, 2, 8)]).contains("`cases` is 9"));
        assert_eq!(merge(Vec::new()), Err(MergeError::Nothing));
    }

    /// A file that is not a shard, or of another version, or whose cases, part or key were changed, is told from a shard.
    #[test]
    fn what_is_no_shard_is_refused() {
        let good: Value = serde_json::to_value(shard(&Plan::default(), 1, 2, 9)).unwrap();
        assert!(Shard::read(&good.to_string()).is_ok());
        let refused = |pointer: &str, value: Value| {
            let mut bad = good.clone();
            *bad.pointer_mut(pointer).unwrap() = value;
            Shard::read(&bad.to_string()).unwrap_err().to_string()
        };
        assert!(refused("/asked/options/seed", json!(2)).contains("its key is not that"));
        assert!(refused("/asked/version", json!("0.0.1")).contains("written by retune 0.0.1"));
        assert!(refused("/retune_shard", json!(2)).contains("written by retune"));
        assert!(refused("/shard/index", json!(0)).contains("no shard 0/2"));
        assert!(refused("/shard/of", json!(0)).contains("no shard 1/0"));
        assert!(refused("/shard/index", json!(2)).contains("not those of shard 2/2 of 9 cases"));
        assert!(refused("/cases", json!(11)).contains("not those of shard 1/2 of 11 cases"));
        assert!(refused("/results/1/position", json!(3)).contains("not those"));
        assert!(refused("/results/0/outcome/gain", Value::Null).contains("damaged"));
        for text in ["", "{", "[1]", "{\"outcomes\": []}", "retune: 1"] {
            assert!(matches!(Shard::read(text), Err(ShardError::NotOne(_))), "{text}");
        }
        let half = good.to_string();
        assert!(matches!(Shard::read(&half[..half.len() / 2]), Err(ShardError::NotOne(_))));
    }

    /// The shard that is there is that of the same plan and part, by whatever words the same structures were asked for.
    #[test]
    fn a_shard_knows_what_it_is_of() {
        let (plan, settings) = (Plan::default(), Settings::default());
        let (one, half) = (shard(&plan, 1, 2, 9), Part::new(1, 2).unwrap());
        assert_eq!(one.check(&plan, &settings, half), Ok(()));
        let structures = STRUCTURES.iter().rev().map(|s| s.0.to_string()).collect();
        assert_eq!(one.check(&Plan { structures, ..plan.clone() }, &settings, half), Ok(()));
        assert_eq!(one.check(&plan, &settings, Part::WHOLE), Err(ShardError::OtherPart(half)));
        let other = one.check(&Plan { noise_factor: 2.0, ..plan.clone() }, &settings, half).unwrap_err().to_string();
        assert!(other.contains("`noise_factor` is 1.0 there and 2.0 here"), "{other}");
        let louder = Settings { alarm_level: 0.1, ..Settings::default() };
        assert!(one.check(&plan, &louder, half).is_err());
        assert!(!one.has_diagnoses() && shard(&Plan { only: Some("x".into()), ..plan }, 1, 1, 2).has_diagnoses());
    }

    #[test]
    fn parts_are_counted_from_one() {
        assert_eq!("3/8".parse(), Ok(Part { index: 3, of: 8 }));
        for (text, what) in [
            ("0/8", "the shards of 8 are 1/8 ... 8/8"),
            ("9/8", "1/8 ... 8/8"),
            ("1/0", "no shards of 0"),
            ("3", "3/8"),
            ("a/b", "3/8"),
            ("-1/2", "3/8"),
            ("", "3/8"),
        ] {
            assert!(text.parse::<Part>().is_err_and(|e| e.contains(what)), "{text}");
        }
        assert_eq!(Part::new(2, 3).unwrap().positions(9).collect::<Vec<_>>(), [1, 4, 7]);
    }
}
