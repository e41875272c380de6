//! One number per candidate: the arithmetic all kernels of this folder are written in.
//!
//! A kernel is generic over [`Lane`] and never branches on a value: comparisons give a mask, masks choose with
//! [`Lane::select`]. What happens in one lane is therefore exactly what would happen were it alone.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of candidates solved together.
pub(super) const LANES: usize = 8;

/// An array of one expression per lane, written out: a closure would be compiled for the baseline processor wherever it
/// is not inlined, and a loop costs the compiler a minute.
macro_rules! each {
    ($l:ident => $value:expr) => {
        each!($l => $value; 0 1 2 3 4 5 6 7)
    };
    ($l:ident => $value:expr; $($lane:literal)*) => {
        [$({
            let $l: usize = $lane;
            $value
        }),*]
    };
}

/// Largest number of recurrences that run side by side, to hide their latency.
pub(super) const ABREAST: usize = 8;

/// [`LANES`] numbers of type f64, one per candidate, with elementwise arithmetic.
pub(super) trait Lane:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Send
    + Sync
    + 'static
{
    /// The same number in every lane.
    fn splat(value: f64) -> Self;
    /// The lanes as numbers.
    fn array(&self) -> &[f64; LANES];
    /// The lanes as numbers, to be overwritten.
    fn array_mut(&mut self) -> &mut [f64; LANES];
    /// a b + c.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// c - a b.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The larger one; a NaN in `self` gives `other`.
    fn max(self, other: Self) -> Self;
    /// a < b, false where one is NaN.
    fn lt(self, other: Self) -> Mask;
    /// `yes` where the mask is set, `no` elsewhere.
    fn select(mask: Mask, yes: Self, no: Self) -> Self;
    /// Adds one to the counters of the lanes where the signs of `self` and `other` differ.
    fn count_sign_change(self, other: Self, counter: &mut Counter);
}

/// One truth value per lane, all bits set or none.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Mask(pub(super) [u64; LANES]);

impl Mask {
    /// The mask with this value in every lane.
    #[inline(always)]
    pub(super) fn splat(value: bool) -> Self {
        Self([u64::from(value).wrapping_neg(); LANES])
    }

    /// Set where both are.
    #[inline(always)]
    pub(super) fn and(self, other: Self) -> Self {
        Self(each!(l => self.0[l] & other.0[l]))
    }

    /// Set where one is.
    #[inline(always)]
    pub(super) fn or(self, other: Self) -> Self {
        Self(each!(l => self.0[l] | other.0[l]))
    }

    /// Set where `self` is not.
    #[inline(always)]
    pub(super) fn not(self) -> Self {
        Self(each!(l => !self.0[l]))
    }

    /// Whether any lane is set.
    #[inline(always)]
    pub(super) fn any(self) -> bool {
        let mut bits = 0;
        for l in 0..LANES {
            bits |= self.0[l];
        }
        bits != 0
    }
}

/// One whole number per lane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub(super) struct Counter(pub(super) [u64; LANES]);

impl Counter {
    /// Zero in every lane.
    pub(super) const ZERO: Self = Self([0; LANES]);

    /// Set where the count is above `j`.
    #[inline(always)]
    pub(super) fn above(self, j: usize) -> Mask {
        // Counts are far below 2^63, so the sign bit of the difference decides; shifts and masks vectorise everywhere.
        Mask(each!(l => (((j as u64).wrapping_sub(self.0[l])) >> 63).wrapping_neg()))
    }

    /// `yes` where the mask is set, `no` elsewhere.
    #[inline(always)]
    pub(super) fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self(each!(l => (yes.0[l] & mask.0[l]) | (no.0[l] & !mask.0[l])))
    }

    /// Set where the count is that of `other` and one more.
    #[inline(always)]
    pub(super) fn is_one_above(self, other: Self) -> Mask {
        Mask(each!(l => u64::from(self.0[l] == other.0[l] + 1).wrapping_neg()))
    }

    /// Sum of two counts.
    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self(each!(l => self.0[l] + other.0[l]))
    }

    /// The largest count of the lanes.
    #[inline(always)]
    pub(super) fn largest(self) -> usize {
        self.0.iter().copied().max().unwrap_or(0) as usize
    }
}

/// Eight f64; `FUSED` says whether a b + c is rounded once (machines with fused multiply-add) or twice.
///
/// Written as plain loops over arrays: inside a function compiled for AVX2 the compiler turns each into two vector
/// instructions.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct F64x8<const FUSED: bool>([f64; LANES]);

macro_rules! elementwise {
    ($($trait:ident :: $method:ident $op:tt;)*) => {$(
        impl<const FUSED: bool> $trait for F64x8<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(each!(l => self.0[l] $op other.0[l]))
            }
        }
    )*};
}
elementwise! { Add::add +; Sub::sub -; Mul::mul *; Div::div /; }

impl<const FUSED: bool> Neg for F64x8<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(each!(l => -self.0[l]))
    }
}

impl<const FUSED: bool> Lane for F64x8<FUSED> {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn array(&self) -> &[f64; LANES] {
        &self.0
    }
    #[inline(always)]
    fn array_mut(&mut self) -> &mut [f64; LANES] {
        &mut self.0
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(each!(l => {
            if FUSED { self.0[l].mul_add(b.0[l], c.0[l]) } else { self.0[l] * b.0[l] + c.0[l] }
        }))
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(each!(l => {
            if FUSED { (-self.0[l]).mul_add(b.0[l], c.0[l]) } else { c.0[l] - self.0[l] * b.0[l] }
        }))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(each!(l => self.0[l].sqrt()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(each!(l => self.0[l].abs()))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(each!(l => if self.0[l] > other.0[l] { self.0[l] } else { other.0[l] }))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask {
        Mask(each!(l => u64::from(self.0[l] < other.0[l]).wrapping_neg()))
    }
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self(each!(l => if mask.0[l] != 0 { yes.0[l] } else { no.0[l] }))
    }
    #[inline(always)]
    fn count_sign_change(self, other: Self, counter: &mut Counter) {
        for l in 0..LANES {
            counter.0[l] += (self.0[l].to_bits() ^ other.0[l].to_bits()) >> 63;
        }
    }
}
