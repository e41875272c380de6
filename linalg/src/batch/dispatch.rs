//! The one place that asks what the processor can do.
//!
//! The kernels are ordinary generic code. Here they are compiled twice, for x86-64 processors with AVX2 and fused
//! multiply-add, and for any other one. A third copy for AVX-512 gained 3 % on this source (6.9 against 7.1 us at n = 42).

use super::lane::F64x8;
use super::solve::{Buffers, Plan, solve_lanes};

/// The instructions a workspace is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    /// 256-bit vectors and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// What every processor of this architecture has.
    Baseline,
}

/// What this processor can do.
pub(super) fn level() -> Level {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return Level::Avx2;
        }
    }
    Level::Baseline
}

/// The memory of a batch, in the arithmetic of the level.
pub(super) enum AnyBuffers {
    /// With fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Fused(Buffers<F64x8<true>>),
    /// Without; on ARM, where it always exists, with.
    Plain(Buffers<F64x8<{ cfg!(target_arch = "aarch64") }>>),
}

impl AnyBuffers {
    /// Memory for the batches of one model at one level.
    pub(super) fn new(plan: &Plan, level: Level) -> Self {
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => Self::Fused(Buffers::new(plan)),
            Level::Baseline => Self::Plain(Buffers::new(plan)),
        }
    }

    /// Solves the batch in the memory.
    pub(super) fn solve(&mut self, plan: &Plan) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Fused(buffers) => fused(plan, buffers),
            Self::Plain(buffers) => solve_lanes(plan, buffers),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
fn fused(plan: &Plan, buffers: &mut Buffers<F64x8<true>>) {
    match level() {
        // SAFETY: `level` has just detected avx2 and fma on this processor.
        Level::Avx2 => unsafe { with_avx2(plan, buffers) },
        Level::Baseline => unreachable!("fused memory is made for processors with AVX2 only"),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2(plan: &Plan, buffers: &mut Buffers<F64x8<true>>) {
    solve_lanes(plan, buffers);
}
