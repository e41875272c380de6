//! Modes of K and M: frequencies, mass-normalised shapes, rigid-body modes that are exactly zero, and FRF synthesis.
//!
//! Matrices in, modes out: nothing here knows nodes or parameters. Start at [`solve`].

mod frf;
pub mod reduction;
mod solve;

pub use frf::{ModalDamping, accelerance, synthesize};
pub use solve::{ModalError, Modes, SolveOptions, solve, typical_shift};
