//! retune updates finite-element models of structures to vibration tests and finds the physics that the models miss.
//!
//! One pipeline with four joints, each knowing only the one before it:
//!
//! ```text
//! Element -> ParametricModel -> Objective -> Optimizer
//! (beam)     (YAML, K(θ) M(θ))  (model - test)  (differential evolution, ...)
//! ```
//!
//! Where to start reading: [`element`] for the textbook matrices, [`model`] for the YAML file and its assembly,
//! [`objective`] for what is compared, [`optim`] for how it is minimised. `ARCHITECTURE.md` draws the whole house.

pub mod correlation;
pub mod effect;
pub mod element;
pub mod fault;
pub mod matrices;
pub mod mesh;
pub mod model;
pub mod objective;
pub mod optim;
pub mod samples;
#[cfg(test)]
#[path = "../base/src/tests.rs"]
mod tests;
pub mod update;

/// Symmetric matrices, modes of pencils, one or many at once: a package of its own, because it takes long to compile.
pub use retune_linalg as linalg;

/// What stands below the models, a package of its own: test data, identification, units, files.
pub use retune_base::{arrays, catalogue, data, deck, hash, identify, modal, once, units, yaml};
