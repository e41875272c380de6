//! Modal analysis.
pub mod reduction;
