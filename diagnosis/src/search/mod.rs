//! Proposes hypotheses and fits them in full.
//!
//! `hypothesis` is one after its fit, `starts` and `run` fit many, `fault_number` those of the measurement, `look` and `short_fit` tell which of many
//! deserve it. `singles`
//! searches for one cause, a file for each step, on a `board`; `spread`, `nested` and `basin` are what steps stand on. `pairs`, `joint` and `several` search for more than one, by `prior` odds
//! and by what `remainder` says of the rest. `one_cause` looks whether a search is worth its time where modes look foreign.

pub(crate) mod basin;
pub(crate) mod board;
pub(crate) mod fault_first;
pub(crate) mod fault_number;
pub(crate) mod hypothesis;
pub(crate) mod joint;
mod look;
pub(crate) mod nested;
pub(crate) mod one_cause;
pub(crate) mod pairs;
pub(crate) mod prior;
mod profile;
pub(crate) mod remainder;
pub(crate) mod run;
pub(crate) mod several;
pub(crate) mod short_fit;
pub(crate) mod singles;
pub(crate) mod spread;
pub(crate) mod starts;
