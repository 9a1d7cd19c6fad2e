//! Sixteen lanes in an AVX-512 register, and the token that proves AVX-512. Work on eight lanes stays with AVX2: the
//! masks and registers of AVX-512 made it up to 6 % slower (whole renders on an AMD EPYC, one thread).

#![allow(unsafe_code, reason = "intrinsics; the types keep them from processors without AVX-512")]

use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::avx2::{Avx2, Avx2Lanes, operators};
use crate::{IdLanes, LANES, LaneMask, MAX_LANES, Real, Simd, WideLanes, WithSimd};

/// Evidence that the processor has AVX-512 (its foundation, `avx512f`) and AVX2.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(Avx2);

/// Sixteen numbers in an AVX-512 register. They are made from an [`Avx512`] or from other lanes only.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Lanes(__m512);

/// The results of a comparison, a bit for each lane. They are made from [`Avx512Lanes`] or from other masks only.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Mask(__mmask16);

/// Sixteen ids in an AVX-512 register. They are made from an [`Avx512`] or from other ids only.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Ids(__m512i);

impl Avx512 {
    /// Token, if the processor has AVX-512.
    #[inline(always)]
    pub fn detect() -> Option<Self> {
        if is_x86_feature_detected!("avx512f") { Avx2::detect().map(Self) } else { None }
    }

    /// Runs an operation in a function that is compiled for AVX-512.
    #[inline]
    pub(crate) fn run<O: WithSimd>(self, operation: O) -> O::Output {
        #[target_feature(enable = "avx512f")]
        fn compiled_for_avx512<O: WithSimd>(simd: Avx512, operation: O) -> O::Output {
            operation.with_simd(simd)
        }
        // SAFETY: the processor has AVX-512, for which `self` is the evidence.
        unsafe { compiled_for_avx512(self, operation) }
    }
}

impl Simd for Avx512 {
    type Lanes = Avx2Lanes;
    type Wide = Avx512Lanes;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Avx2Lanes {
        self.0.broadcast(value)
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> Avx2Lanes {
        self.0.load(values)
    }
    #[inline(always)]
    fn indices(self, indices: &[u8; LANES]) -> __m256i {
        self.0.indices(indices)
    }
    #[inline(always)]
    fn find(self, ids: &[u32; LANES], id: u32) -> u32 {
        self.0.find(ids, id)
    }
    #[inline(always)]
    fn broadcast_wide(self, value: f32) -> Avx512Lanes {
        // SAFETY: `self` is the evidence of AVX-512.
        Avx512Lanes(unsafe { _mm512_set1_ps(value) })
    }
    #[inline(always)]
    fn load_wide(self, values: &[f32; MAX_LANES]) -> Avx512Lanes {
        // SAFETY: `self` is the evidence of AVX-512; this reads the sixteen floats behind the reference, at any
        // address.
        Avx512Lanes(unsafe { _mm512_loadu_ps(values.as_ptr()) })
    }
    #[inline(always)]
    fn broadcast_id(self, id: u32) -> Avx512Ids {
        // SAFETY: `self` is the evidence of AVX-512.
        Avx512Ids(unsafe { _mm512_set1_epi32(id.cast_signed()) })
    }
}

operators! {
    Avx512Lanes: Add add = _mm512_add_ps, Sub sub = _mm512_sub_ps, Mul mul = _mm512_mul_ps, Div div = _mm512_div_ps;
    Avx512Mask: BitAnd bitand = _kand_mask16, BitOr bitor = _kor_mask16;
}

impl LaneMask for Avx512Mask {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

impl Not for Avx512Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

impl Neg for Avx512Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        let flipped =
            unsafe { _mm512_xor_si512(_mm512_castps_si512(self.0), _mm512_castps_si512(self.broadcast(-0.0).0)) };
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_castsi512_ps(flipped) })
    }
}

impl Real for Avx512Lanes {
    type Mask = Avx512Mask;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_set1_ps(value) })
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        /// Truth table that takes bits of the second operand where the first has ones, and of the third elsewhere.
        const CHOOSE: i32 = 0xca;
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe {
            let [mask, sign, own] = [self.broadcast(-0.0), sign, self].map(|lanes| _mm512_castps_si512(lanes.0));
            _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<CHOOSE>(mask, sign, own))
        })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Avx512Mask {
        // SAFETY: lanes exist only where AVX-512 does.
        Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Avx512Mask {
        // SAFETY: lanes exist only where AVX-512 does.
        Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) })
    }
    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
        // SAFETY: lanes exist only where AVX-512 does.
        Self(unsafe { _mm512_mask_blend_ps(mask.0, no.0, yes.0) })
    }
}

impl WideLanes for Avx512Lanes {
    const COUNT: usize = MAX_LANES;
    type Ids = Avx512Ids;

    #[inline(always)]
    fn store_wide(self) -> [f32; MAX_LANES] {
        let mut values = [0.0; MAX_LANES];
        // SAFETY: lanes exist only where AVX-512 does; this writes the sixteen floats of the array, at any address.
        unsafe { _mm512_storeu_ps(values.as_mut_ptr(), self.0) };
        values
    }
}

impl IdLanes<Avx512Mask> for Avx512Ids {
    #[inline(always)]
    fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
        // SAFETY: ids exist only where AVX-512 does.
        Self(unsafe { _mm512_mask_blend_epi32(mask.0, no.0, yes.0) })
    }
    #[inline(always)]
    fn store_wide(self) -> [u32; MAX_LANES] {
        let mut ids = [0; MAX_LANES];
        // SAFETY: ids exist only where AVX-512 does; this writes the sixteen of the array, at any address.
        unsafe { _mm512_storeu_si512(ids.as_mut_ptr().cast(), self.0) };
        ids
    }
}
