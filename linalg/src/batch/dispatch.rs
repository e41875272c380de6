//! The one place that asks what the processor can do.
//!
//! The kernels are ordinary generic code. Here they are compiled three times: for x86-64 processors with AVX-512, for those with
//! AVX2 and fused multiply-add, and for any other one. The first two give the same bits.

use super::lane::F64x8;
use super::solve::{Buffers, Plan, solve_batches};
#[cfg(target_arch = "x86_64")]
use super::wide::Wide;

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

/// What this processor can do, the fastest first.
pub(super) fn levels() -> impl Iterator<Item = Level> {
    #[cfg(target_arch = "x86_64")]
    let more = {
        let has_fma = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        let has_wide = has_fma && is_x86_feature_detected!("avx512f");
        [has_wide.then_some(Level::Avx512), has_fma.then_some(Level::Avx2)]
    };
    #[cfg(not(target_arch = "x86_64"))]
    let more: [Option<Level>; 0] = [];
    more.into_iter().flatten().chain([Level::Baseline])
}

/// The fastest that this processor can do.
pub(super) fn level() -> Level {
    levels().next().unwrap_or(Level::Baseline)
}

/// The memory of two batches, in the arithmetic of the level.
pub(super) enum AnyBuffers {
    /// In registers of 512 bits.
    #[cfg(target_arch = "x86_64")]
    Wide([Buffers<Wide>; 2]),
    /// With fused multiply-add.
    #[cfg(target_arch = "x86_64")]
    Fused([Buffers<F64x8<true>>; 2]),
    /// Without; on ARM, where it always exists, with.
    Plain([Buffers<F64x8<{ cfg!(target_arch = "aarch64") }>>; 2]),
}

impl AnyBuffers {
    /// Memory for the batches of one model at one level.
    pub(super) fn new(plan: &Plan, level: Level) -> Self {
        match level {
            #[cfg(target_arch = "x86_64")]
            Level::Avx512 => Self::Wide([Buffers::new(plan), Buffers::new(plan)]),
            #[cfg(target_arch = "x86_64")]
            Level::Avx2 => Self::Fused([Buffers::new(plan), Buffers::new(plan)]),
            Level::Baseline => Self::Plain([Buffers::new(plan), Buffers::new(plan)]),
        }
    }

    /// Solves the first batch in the memory, or both.
    #[allow(unsafe_code)]
    pub(super) fn solve(&mut self, plan: &Plan, batches: usize) {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Wide(buffers) => {
                assert!(has(Level::Avx512), "wide memory is made for processors with AVX-512 only");
                // SAFETY: avx512f, avx2 and fma have just been detected on this processor.
                unsafe { with_avx512(plan, &mut buffers[..batches]) }
            }
            #[cfg(target_arch = "x86_64")]
            Self::Fused(buffers) => {
                assert!(has(Level::Avx2), "fused memory is made for processors with AVX2 only");
                // SAFETY: avx2 and fma have just been detected on this processor.
                unsafe { with_avx2(plan, &mut buffers[..batches]) }
            }
            Self::Plain(buffers) => solve_batches(plan, &mut buffers[..batches]),
        }
    }
}

#[cfg(target_arch = "x86_64")]
fn has(level: Level) -> bool {
    levels().any(|l| l == level)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn with_avx512(plan: &Plan, buffers: &mut [Buffers<Wide>]) {
    solve_batches(plan, buffers);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn with_avx2(plan: &Plan, buffers: &mut [Buffers<F64x8<true>>]) {
    solve_batches(plan, buffers);
}
