//! The verbs: arguments in, results out, everything between by the library. One file each.

pub(crate) mod compare;
pub(crate) mod diagnose;
pub(crate) mod identify;
pub(crate) mod pretest;
pub(crate) mod report;
pub(crate) mod settings;
mod shared;
pub(crate) mod twin;
pub(crate) mod update;
