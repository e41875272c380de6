//! The two ends of a function: which point and direction, how it is called, and what its numbers say that it measures.

use crate::data::FrfQuantity;
use crate::data::uff::{Entity, Function};
use std::collections::BTreeMap;

pub(super) const FRF: i64 = 4;
pub(super) const COHERENCE: i64 = 6;
pub(super) const FREQUENCY: i64 = 18;
pub(super) const REACTION_FORCE: i64 = 9;
pub(super) const EXCITATION_FORCE: i64 = 13;

/// One end: name of the point and direction code; sorted by component and label.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct End {
    pub(super) component: String,
    pub(super) node: i64,
    pub(super) name: String,
    pub(super) direction: i64,
}

/// How points are called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Naming {
    /// By the number of the node.
    Number,
    /// By component and number, `wing.12`: the same number is there under several names.
    ComponentAndNumber,
}

impl Naming {
    /// Components count where one number stands under several names, among the responses or among the references; a name that says what
    /// a signal is (`Force`, `Acc`) stands at one side only.
    #[expect(clippy::needless_pass_by_value, reason = "an iterator that is cloned for each pass")]
    pub(super) fn of<'a>(functions: impl Iterator<Item = &'a Function> + Clone) -> Self {
        let is_repeated = |side: fn(&Function) -> &Entity| {
            let mut names: BTreeMap<i64, &str> = BTreeMap::new();
            functions.clone().map(side).filter(|e| e.node != 0 && is_named(e)).any(|e| {
                let first = *names.entry(e.node).or_insert(&e.name);
                first != e.name
            })
        };
        if is_repeated(|f| &f.response) || is_repeated(|f| &f.reference) {
            Self::ComponentAndNumber
        } else {
            Self::Number
        }
    }
}

fn is_named(entity: &Entity) -> bool {
    !matches!(entity.name.as_str(), "" | "NONE")
}

impl End {
    pub(super) fn of(entity: &Entity, naming: Naming) -> Self {
        let (node, direction) = (entity.node, entity.direction);
        if !is_named(entity) || (node != 0 && naming == Naming::Number) {
            return Self { component: String::new(), node, name: node.to_string(), direction };
        }
        let name = if node == 0 { entity.name.clone() } else { format!("{}.{node}", entity.name) };
        Self { component: entity.name.clone(), node, name, direction }
    }

    pub(super) fn title(&self) -> String {
        format!("{}:{}", self.name, self.direction)
    }
}

pub(super) fn quantity_of(data_type: i64) -> Option<FrfQuantity> {
    match data_type {
        8 => Some(FrfQuantity::Receptance),
        11 => Some(FrfQuantity::Mobility),
        12 => Some(FrfQuantity::Accelerance),
        _ => None,
    }
}
