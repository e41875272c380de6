//! Tests of identification against closed forms, an independent reference and measured functions.

mod bff;
mod methods;
pub(super) mod synthetic;
mod truth;
mod variants;
mod weak;
pub(super) mod wing;
