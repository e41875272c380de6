//! From a Nastran deck to a model file.
//!
//! One file per family of cards; [`CARDS`] is the catalogue: what a card becomes, why it is left out, or why it is refused. A card that is
//! not in it is refused by name and place: nothing is half-read.

mod asked;
mod constraints;
mod coordinates;
mod design;
mod eigenvectors;
mod entries;
mod equations;
mod flat;
mod importer;
mod laminates;
mod masses;
mod materials;
mod members;
mod names;
mod others;
mod panels;
mod responses;
mod rigid;
mod sandwiches;
mod scalars;
mod sections;
mod shells;
mod solids;
mod springs;
mod zaero;

pub use importer::import;

use importer::Importer;
use retune::deck::{Card, DeckError};

/// How a family reads one card.
type Reader = for<'a> fn(&mut Importer<'a>, &Card<'a>) -> Result<(), DeckError>;

/// What is done with a card.
#[derive(Debug, Clone, Copy)]
pub enum Treatment {
    /// It becomes entries of the model file: of which kind.
    Read(&'static str, #[doc(hidden)] ReaderOf),
    /// Others refer to it: what it gives them.
    Used(&'static str),
    /// It says nothing of the structure: what it is for.
    LeftOut(&'static str),
    /// The model cannot hold it: why.
    Refused(&'static str),
}

/// A reader, in a type that can be shown.
#[derive(Clone, Copy)]
pub struct ReaderOf(Reader);

impl std::fmt::Debug for ReaderOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("reader")
    }
}

/// One line of the catalogue.
#[derive(Debug, Clone, Copy)]
pub struct CardRule {
    /// Name of the card.
    pub name: &'static str,
    /// What is done with it.
    pub treatment: Treatment,
    /// The last field that it may have, where that is known: what stands behind it would be lost.
    pub last: Option<usize>,
}

impl CardRule {
    const fn up_to(self, last: usize) -> Self {
        Self { last: Some(last), ..self }
    }
}

const fn read(name: &'static str, becomes: &'static str, reader: Reader) -> CardRule {
    CardRule { name, treatment: Treatment::Read(becomes, ReaderOf(reader)), last: None }
}

const fn used(name: &'static str, gives: &'static str) -> CardRule {
    CardRule { name, treatment: Treatment::Used(gives), last: None }
}

const fn left_out(name: &'static str, why: &'static str) -> CardRule {
    CardRule { name, treatment: Treatment::LeftOut(why), last: None }
}

const fn refused(name: &'static str, why: &'static str) -> CardRule {
    CardRule { name, treatment: Treatment::Refused(why), last: None }
}

/// The catalogue, family by family.
pub const CARDS: &[&[CardRule]] = &[
    coordinates::CARDS,
    scalars::CARDS,
    members::CARDS,
    sections::CARDS,
    materials::CARDS,
    springs::CARDS,
    masses::CARDS,
    rigid::CARDS,
    constraints::CARDS,
    shells::CARDS,
    panels::CARDS,
    solids::CARDS,
    design::CARDS,
    others::CARDS,
    zaero::CARDS,
];

/// The rule of a card.
fn rule(name: &str) -> Option<&'static CardRule> {
    CARDS.iter().copied().flatten().find(|r| r.name == name)
}
