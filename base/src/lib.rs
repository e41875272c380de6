//! What stands below the models of retune: test data and their files, identification, units, YAML with places, arrays, decks as text, catalogues.
//!
//! `retune` hands all of it on: `retune::data`, `retune::identify` and the others are these.

pub mod arrays;
pub mod catalogue;
pub mod data;
pub mod deck;
pub mod dof;
pub mod hash;
pub mod identify;
pub mod modal;
pub mod once;
#[cfg(test)]
mod tests;
pub mod units;
pub mod yaml;
