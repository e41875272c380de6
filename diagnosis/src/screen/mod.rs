//! A fit as all hypotheses see it, to first order.
//!
//! `effects` and `traces` are what every effect and every fault would change, `adjoint` the same of a large model, `robust` the fits that gross faults cannot pull, `noise` the null
//! distributions; `stage` has them all of one fit.

pub(crate) mod adjoint;
pub(crate) mod effects;
pub(crate) mod noise;
pub(crate) mod robust;
pub(crate) mod stage;
pub(crate) mod traces;
