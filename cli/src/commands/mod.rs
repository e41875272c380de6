//! One file per verb.

pub(crate) mod add;
pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod diagnose;
pub(crate) mod explain;
pub(crate) mod learn;
pub(crate) mod list;
pub(crate) mod modes;
pub(crate) mod schema;
pub(crate) mod update;
