//! Sparse pencils of 10⁴ to 10⁶ rows: the lowest modes by shift-invert block Lanczos on a supernodal Cholesky factor.
//!
//! [`SparsePlan`] orders and analyses a pattern once; [`lowest_sparse_modes`] solves one candidate with it. Start there.

mod across;
mod basis;
mod derivative;
mod factor;
mod kernel;
mod lanczos;
mod matrix;
mod modes;
mod plan;
mod shifted;
#[cfg(test)]
mod tests;

pub use across::solve_across_modes;
pub use derivative::solve_beside_modes;
pub use matrix::{SparseSym, on_motions};
pub use modes::{SparseModes, SparseOptions, backward_error, lowest_sparse_modes};
pub use plan::SparsePlan;
pub use shifted::{IndefinitePencil, PencilFactor, count_negative, solve_shifted};
