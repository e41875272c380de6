//! From a deck of Abaqus or CalculiX to a model file.
//!
//! [`KEYWORDS`] is the catalogue: what a keyword becomes, why it is left out, or why it is refused; `kinds` that of types of elements. `gather`
//! puts what is read into its part or instance, `pass` goes through it, with one file per family of keywords; `importer` is what these know and
//! write to. A keyword or a type that is in
//! no catalogue is refused by name and place: nothing is half-read.

mod axes;
mod connectors;
mod elastic;
mod gather;
mod importer;
mod keywords;
mod kinds;
mod layers;
mod links;
mod materials;
mod members;
mod pass;
mod points;
mod profile;
mod scopes;
mod shells;
mod solids;
mod supports;
mod surfaces;
#[cfg(test)]
mod tests;
mod tied;
mod ties;
mod trapezoid;

pub use keywords::{KEYWORDS, KeywordRule, KeywordUse};
pub use pass::import_keywords;
