//! Tests of identification against closed forms, an independent reference and measured functions.

mod bff;
mod synthetic;
mod truth;
mod wing;
