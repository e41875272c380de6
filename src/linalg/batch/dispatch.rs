//! The one place that asks what the processor can do.
//!
//! The kernels are ordinary generic code. Here they are compiled three times, for processors with AVX-512, with AVX2 and
//! fused multiply-add, and for any other one; the first two give the same bits, because a lane is the same sequence of
//! correctly rounded operations in both.

use super::lane::F64x8;
use super::solve::{Buffers, Plan, solve_lanes};

/// The instructions a workspace is made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    /// 512-bit vectors and fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Avx512,
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
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") && is_x86_feature_detected!("fma") {
            return Level::Avx512;
        }
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
    Fused(Level, Buffers<F64x8<true>>),
    /// Without; on ARM, where it always exists, with.
    Plain(Buffers<F64x8<{ cfg!(target_arch = "aarch64") }>>),
}

impl AnyBuffers {
    /// Memory for the batches of one model at one level.
    pub(super) fn new(plan: &Plan, level: Level) -> Self {
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 | Level::Avx2 => Self::Fused(level, Buffers::new(plan)),
            Level::Baseline => Self::Plain(Buffers::new(plan)),
        }
    }

    /// Solves the batch in the memory.
    pub(super) fn solve(&mut self, plan: &Plan) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Fused(level, buffers) => fused(*level, plan, buffers),
            Self::Plain(buffers) => solve_lanes(plan, buffers),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
fn fused(made_for: Level, plan: &Plan, buffers: &mut Buffers<F64x8<true>>) {
    // Memory for fewer features than the processor has stays with them, memory for more falls back.
    match (made_for, level()) {
        // SAFETY: `level` has just detected avx512f, avx512dq, avx512vl and fma on this processor.
        (Level::Avx512, Level::Avx512) => unsafe { with_avx512(plan, buffers) },
        // SAFETY: `level` has just detected avx2 and fma; a processor with AVX-512 has AVX2 too.
        (_, Level::Avx2 | Level::Avx512) => unsafe { with_avx2(plan, buffers) },
        (_, Level::Baseline) => solve_lanes(plan, buffers),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
fn with_avx512(plan: &Plan, buffers: &mut Buffers<F64x8<true>>) {
    solve_lanes(plan, buffers);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2(plan: &Plan, buffers: &mut Buffers<F64x8<true>>) {
    solve_lanes(plan, buffers);
}
