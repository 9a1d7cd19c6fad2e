//! Lanes in an AVX register, and the token that proves AVX2.

#![allow(unsafe_code, reason = "intrinsics; the types keep them from processors without AVX2")]

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::{IdLanes, LANES, LaneMask, Lanes, MAX_LANES, Real, Simd, WideLanes, WithSimd};

/// Evidence that the processor has AVX2.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// Eight numbers in an AVX register. They are made from an [`Avx2`] or from other lanes only.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Lanes(__m256);

/// The results of a comparison, all bits of a lane set or none. They are made from [`Avx2Lanes`] or from other masks
/// only.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Mask(__m256);

/// Eight ids in an AVX register. They are made from an [`Avx2`] or from other ids only.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Ids(__m256i);

impl Avx2 {
    /// Token, if the processor has AVX2.
    #[inline(always)]
    pub fn detect() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }

    /// Runs an operation in a function that is compiled for AVX2.
    #[inline]
    pub(crate) fn run<O: WithSimd>(self, operation: O) -> O::Output {
        #[target_feature(enable = "avx2")]
        fn compiled_for_avx2<O: WithSimd>(simd: Avx2, operation: O) -> O::Output {
            operation.with_simd(simd)
        }
        // SAFETY: the processor has AVX2, for which `self` is the evidence.
        unsafe { compiled_for_avx2(self, operation) }
    }
}

impl Simd for Avx2 {
    type Lanes = Avx2Lanes;
    type Wide = Avx2Lanes;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Avx2Lanes {
        // SAFETY: `self` is the evidence of AVX2.
        Avx2Lanes(unsafe { _mm256_set1_ps(value) })
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> Avx2Lanes {
        // SAFETY: `self` is the evidence of AVX2; this reads the eight floats behind the reference, at any address.
        Avx2Lanes(unsafe { _mm256_loadu_ps(values.as_ptr()) })
    }
    #[inline(always)]
    fn indices(self, indices: &[u8; LANES]) -> __m256i {
        // SAFETY: `self` is the evidence of AVX2; this reads the eight bytes behind the reference, at any address.
        unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(indices.as_ptr().cast())) }
    }
    #[inline(always)]
    fn find(self, ids: &[u32; LANES], id: u32) -> u32 {
        // SAFETY: `self` is the evidence of AVX2; this reads the eight ids behind the reference, at any address.
        let found = unsafe {
            let ids = _mm256_loadu_si256(ids.as_ptr().cast());
            _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(ids, _mm256_set1_epi32(id.cast_signed()))))
        };
        found.cast_unsigned()
    }
    #[inline(always)]
    fn broadcast_wide(self, value: f32) -> Avx2Lanes {
        self.broadcast(value)
    }
    #[inline(always)]
    fn load_wide(self, values: &[f32; MAX_LANES]) -> Avx2Lanes {
        let ([first, _], []) = values.as_chunks::<LANES>() else { unreachable!("two times eight") };
        self.load(first)
    }
    #[inline(always)]
    fn broadcast_id(self, id: u32) -> Avx2Ids {
        // SAFETY: `self` is the evidence of AVX2.
        Avx2Ids(unsafe { _mm256_set1_epi32(id.cast_signed()) })
    }
}

/// Operators of two operands, an intrinsic each, of lanes and masks of this file and of the one of AVX-512.
macro_rules! operators {
    ($($kind:ident: $($trait:ident $method:ident = $intrinsic:ident),+;)+) => { $($(
        impl $trait for $kind {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: lanes and masks exist only where their instructions do.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    )+)+ };
}
pub(crate) use operators;

operators! {
    Avx2Lanes: Add add = _mm256_add_ps, Sub sub = _mm256_sub_ps, Mul mul = _mm256_mul_ps, Div div = _mm256_div_ps;
    Avx2Mask: BitAnd bitand = _mm256_and_ps, BitOr bitor = _mm256_or_ps;
}

impl LaneMask for Avx2Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: lanes exist only where AVX2 does.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

impl Not for Avx2Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) })
    }
}

impl Neg for Avx2Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Real for Avx2Lanes {
    type Mask = Avx2Mask;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_set1_ps(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_or_ps(self.abs().0, _mm256_and_ps(_mm256_set1_ps(-0.0), sign.0)) })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx2Mask {
        // SAFETY: lanes exist only where AVX2 does.
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx2Mask {
        // SAFETY: lanes exist only where AVX2 does.
        Avx2Mask(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask.0) })
    }
}

impl Lanes for Avx2Lanes {
    type Indices = __m256i;

    #[inline(always)]
    fn permute(self, indices: __m256i) -> Self {
        // SAFETY: lanes exist only where AVX2 does.
        Self(unsafe { _mm256_permutevar8x32_ps(self.0, indices) })
    }
    #[inline(always)]
    fn store(self) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        // SAFETY: lanes exist only where AVX2 does; this writes the eight floats of the array, at any address.
        unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) };
        values
    }
}

impl WideLanes for Avx2Lanes {
    const COUNT: usize = LANES;
    type Ids = Avx2Ids;

    #[inline(always)]
    fn store_wide(self) -> [f32; MAX_LANES] {
        let mut values = [0.0; MAX_LANES];
        values[..LANES].copy_from_slice(&self.store());
        values
    }
}

impl IdLanes<Avx2Mask> for Avx2Ids {
    #[inline(always)]
    fn select(mask: Avx2Mask, yes: Self, no: Self) -> Self {
        // SAFETY: ids exist only where AVX2 does.
        Self(unsafe { _mm256_blendv_epi8(no.0, yes.0, _mm256_castps_si256(mask.0)) })
    }
    #[inline(always)]
    fn store_wide(self) -> [u32; MAX_LANES] {
        let mut ids = [0; MAX_LANES];
        // SAFETY: ids exist only where AVX2 does; this writes the first eight of the array, at any address.
        unsafe { _mm256_storeu_si256(ids.as_mut_ptr().cast(), self.0) };
        ids
    }
}
