//! One file per verb.

pub(crate) mod add;
pub(crate) mod against;
pub(crate) mod benchmark;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod diagnose;
pub(crate) mod explain;
pub(crate) mod export;
mod export_deck;
mod export_matrices;
pub(crate) mod health;
pub(crate) mod identify;
pub(crate) mod import;
pub(crate) mod learn;
pub(crate) mod list;
pub(crate) mod map;
pub(crate) mod matrices;
pub(crate) mod measured;
pub(crate) mod modes;
pub(crate) mod pretest;
pub(crate) mod report;
pub(crate) mod sample;
pub(crate) mod schema;
pub(crate) mod sensitivity;
pub(crate) mod twin;
pub(crate) mod update;
