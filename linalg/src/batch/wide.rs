//! Eight f64 in one register of a processor with AVX-512.
//!
//! The operations of [`F64x8<true>`](super::lane::F64x8) with the same rounding, so that results have the same bits. Of arrays the
//! compiler makes no faster code than for AVX2, even where it may use these instructions (docs/performance.md).

#![allow(unsafe_code)]

use super::lane::{Counter, LANES, Lane, Mask};
use std::arch::x86_64::{
    __m512d, __m512i, _CMP_LT_OQ, _mm512_abs_pd, _mm512_add_epi64, _mm512_add_pd, _mm512_castpd_si512,
    _mm512_castsi512_pd, _mm512_cmp_pd_mask, _mm512_div_pd, _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_mask_blend_pd,
    _mm512_maskz_set1_epi64, _mm512_max_pd, _mm512_mul_pd, _mm512_set1_epi64, _mm512_set1_pd, _mm512_sqrt_pd,
    _mm512_srli_epi64, _mm512_sub_pd, _mm512_test_epi64_mask, _mm512_xor_si512,
};
use std::mem::transmute;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight f64. Only `dispatch` makes memory of them, where it has detected AVX-512: what each `unsafe` below relies on.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(super) struct Wide(__m512d);

macro_rules! elementwise {
    ($($trait:ident :: $method:ident $instruction:ident;)*) => {$(
        impl $trait for Wide {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: the processor has AVX-512, see `Wide`.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    )*};
}
elementwise! { Add::add _mm512_add_pd; Sub::sub _mm512_sub_pd; Mul::mul _mm512_mul_pd; Div::div _mm512_div_pd; }

impl Neg for Wide {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`.
        Self(unsafe {
            let sign = _mm512_set1_epi64(i64::MIN);
            _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(self.0), sign))
        })
    }
}

impl Lane for Wide {
    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`.
        Self(unsafe { _mm512_set1_pd(value) })
    }
    #[inline(always)]
    fn array(&self) -> &[f64; LANES] {
        // SAFETY: eight f64 of 64 bytes, aligned more strictly than the array.
        unsafe { &*std::ptr::from_ref(self).cast() }
    }
    #[inline(always)]
    fn array_mut(&mut self) -> &mut [f64; LANES] {
        // SAFETY: as in `array`; every array of eight f64 is a register.
        unsafe { &mut *std::ptr::from_mut(self).cast() }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`.
        Self(unsafe { _mm512_fmadd_pd(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`.
        Self(unsafe { _mm512_fnmadd_pd(self.0, b.0, c.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`. The instruction gives its second operand where one is NaN.
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask {
        // SAFETY: the processor has AVX-512, see `Wide`; a mask is 64 bytes, and any bytes are one.
        unsafe {
            let less = _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0);
            transmute::<__m512i, Mask>(_mm512_maskz_set1_epi64(less, -1))
        }
    }
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        // SAFETY: the processor has AVX-512, see `Wide`; a mask is 64 bytes.
        unsafe {
            let bits = transmute::<Mask, __m512i>(mask);
            Self(_mm512_mask_blend_pd(_mm512_test_epi64_mask(bits, bits), no.0, yes.0))
        }
    }
    #[inline(always)]
    fn count_sign_change(self, other: Self, counter: &mut Counter) {
        // SAFETY: the processor has AVX-512, see `Wide`; a counter is 64 bytes, and any bytes are one.
        unsafe {
            let differ = _mm512_xor_si512(_mm512_castpd_si512(self.0), _mm512_castpd_si512(other.0));
            let before = transmute::<Counter, __m512i>(*counter);
            *counter = transmute::<__m512i, Counter>(_mm512_add_epi64(before, _mm512_srli_epi64::<63>(differ)));
        }
    }
}
