//! Eight lanes in two registers of NEON, which every processor of AArch64 has: Apple's, Graviton.
//!
//! Sixteen lanes would take four registers. The 32 registers hold as many numbers as AVX2's sixteen do, so wide lanes
//! are eight here, too. Speed has not been measured on such a processor.

#![allow(unsafe_code, reason = "intrinsics; this file is compiled for targets with NEON alone")]

use std::arch::aarch64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::{IdLanes, LANES, LaneMask, Lanes, MAX_LANES, Real, Simd, WideLanes};

/// The token of lanes in registers of NEON. The target has them, so that anyone may make it.
#[derive(Clone, Copy, Debug)]
pub struct Neon;

/// Eight numbers in two registers.
#[derive(Clone, Copy, Debug)]
pub struct NeonLanes(float32x4_t, float32x4_t);

/// The results of a comparison, all bits of a lane set or none.
#[derive(Clone, Copy, Debug)]
pub struct NeonMask(uint32x4_t, uint32x4_t);

/// Eight ids in two registers.
#[derive(Clone, Copy, Debug)]
pub struct NeonIds(uint32x4_t, uint32x4_t);

/// For each lane, the numbers of its four bytes among those of eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct NeonIndices(uint8x16_t, uint8x16_t);

impl Simd for Neon {
    type Lanes = NeonLanes;
    type Wide = NeonLanes;

    #[inline(always)]
    fn broadcast(self, value: f32) -> NeonLanes {
        // SAFETY: the target has NEON.
        let half = unsafe { vdupq_n_f32(value) };
        NeonLanes(half, half)
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> NeonLanes {
        let start = values.as_ptr();
        // SAFETY: the target has NEON; this reads the eight floats behind the reference.
        unsafe { NeonLanes(vld1q_f32(start), vld1q_f32(start.add(4))) }
    }
    #[inline(always)]
    fn indices(self, indices: &[u8; LANES]) -> NeonIndices {
        /// Numbers of the four bytes of the first lane.
        const BYTES: u32 = 0x0302_0100;
        /// Factor that puts four times an index into each of four bytes.
        const FOUR_TIMES: u32 = 0x0404_0404;
        // SAFETY: the target has NEON; this reads the eight bytes behind the reference.
        unsafe {
            let indices = vmovl_u8(vld1_u8(indices.as_ptr()));
            let (first, factor) = (vdupq_n_u32(BYTES), vdupq_n_u32(FOUR_TIMES));
            let bytes = |half| vreinterpretq_u8_u32(vmlaq_u32(first, vmovl_u16(half), factor));
            NeonIndices(bytes(vget_low_u16(indices)), bytes(vget_high_u16(indices)))
        }
    }
    #[inline(always)]
    fn find(self, ids: &[u32; LANES], id: u32) -> u32 {
        let start = ids.as_ptr();
        // SAFETY: the target has NEON; this reads the eight ids behind the reference.
        let found = unsafe {
            let id = vdupq_n_u32(id);
            NeonMask(vceqq_u32(vld1q_u32(start), id), vceqq_u32(vld1q_u32(start.add(4)), id))
        };
        found.bits()
    }
    #[inline(always)]
    fn broadcast_wide(self, value: f32) -> NeonLanes {
        self.broadcast(value)
    }
    #[inline(always)]
    fn load_wide(self, values: &[f32; MAX_LANES]) -> NeonLanes {
        let ([first, _], []) = values.as_chunks::<LANES>() else { unreachable!("two times eight") };
        self.load(first)
    }
    #[inline(always)]
    fn broadcast_id(self, id: u32) -> NeonIds {
        // SAFETY: the target has NEON.
        let half = unsafe { vdupq_n_u32(id) };
        NeonIds(half, half)
    }
}

/// Operators of one operand or two, an intrinsic each for both halves. None of them adds to a product: a fused sum is
/// rounded once, where other kinds of lanes round twice.
macro_rules! operators {
    ($($kind:ident: $($trait:ident $method:ident($($other:ident)?) = $intrinsic:ident),+;)+) => { $($(
        impl $trait for $kind {
            type Output = Self;
            #[inline(always)]
            fn $method(self $(, $other: Self)?) -> Self {
                // SAFETY: the target has NEON.
                unsafe { Self($intrinsic(self.0 $(, $other.0)?), $intrinsic(self.1 $(, $other.1)?)) }
            }
        }
    )+)+ };
}

operators! {
    NeonLanes: Add add(other) = vaddq_f32, Sub sub(other) = vsubq_f32, Mul mul(other) = vmulq_f32,
        Div div(other) = vdivq_f32, Neg neg() = vnegq_f32;
    NeonMask: BitAnd bitand(other) = vandq_u32, BitOr bitor(other) = vorrq_u32, Not not() = vmvnq_u32;
}

impl LaneMask for NeonMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        /// The bit of each lane.
        const BITS: [u16; LANES] = [1, 2, 4, 8, 16, 32, 64, 128];
        // SAFETY: the target has NEON; this reads the eight numbers of the array.
        unsafe {
            let mask = vcombine_u16(vmovn_u32(self.0), vmovn_u32(self.1));
            u32::from(vaddvq_u16(vandq_u16(mask, vld1q_u16(BITS.as_ptr()))))
        }
    }
}

impl Real for NeonLanes {
    type Mask = NeonMask;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        Neon.broadcast(value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: the target has NEON.
        unsafe { Self(vsqrtq_f32(self.0), vsqrtq_f32(self.1)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: the target has NEON.
        unsafe { Self(vabsq_f32(self.0), vabsq_f32(self.1)) }
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        // SAFETY: the target has NEON.
        unsafe {
            let mask = vdupq_n_u32(1 << 31);
            Self(vbslq_f32(mask, sign.0, self.0), vbslq_f32(mask, sign.1, self.1))
        }
    }
    // The instructions for a minimum and a maximum hand on NaN, and take −0 for less than 0.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> NeonMask {
        // SAFETY: the target has NEON.
        unsafe { NeonMask(vcltq_f32(self.0, other.0), vcltq_f32(self.1, other.1)) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> NeonMask {
        // SAFETY: the target has NEON.
        unsafe { NeonMask(vcleq_f32(self.0, other.0), vcleq_f32(self.1, other.1)) }
    }
    #[inline(always)]
    fn select(mask: NeonMask, yes: Self, no: Self) -> Self {
        // SAFETY: the target has NEON.
        unsafe { Self(vbslq_f32(mask.0, yes.0, no.0), vbslq_f32(mask.1, yes.1, no.1)) }
    }
}

impl Lanes for NeonLanes {
    type Indices = NeonIndices;

    #[inline(always)]
    fn permute(self, indices: NeonIndices) -> Self {
        // SAFETY: the target has NEON.
        unsafe {
            let all = uint8x16x2_t(vreinterpretq_u8_f32(self.0), vreinterpretq_u8_f32(self.1));
            let half = |bytes| vreinterpretq_f32_u8(vqtbl2q_u8(all, bytes));
            Self(half(indices.0), half(indices.1))
        }
    }
    #[inline(always)]
    fn store(self) -> [f32; LANES] {
        let mut values = [0.0; LANES];
        let start = values.as_mut_ptr();
        // SAFETY: the target has NEON; this writes the eight floats of the array.
        unsafe {
            vst1q_f32(start, self.0);
            vst1q_f32(start.add(4), self.1);
        }
        values
    }
}

impl WideLanes for NeonLanes {
    const COUNT: usize = LANES;
    type Ids = NeonIds;

    #[inline(always)]
    fn store_wide(self) -> [f32; MAX_LANES] {
        let mut values = [0.0; MAX_LANES];
        values[..LANES].copy_from_slice(&self.store());
        values
    }
}

impl IdLanes<NeonMask> for NeonIds {
    #[inline(always)]
    fn select(mask: NeonMask, yes: Self, no: Self) -> Self {
        // SAFETY: the target has NEON.
        unsafe { Self(vbslq_u32(mask.0, yes.0, no.0), vbslq_u32(mask.1, yes.1, no.1)) }
    }
    #[inline(always)]
    fn store_wide(self) -> [u32; MAX_LANES] {
        let mut ids = [0; MAX_LANES];
        let start = ids.as_mut_ptr();
        // SAFETY: the target has NEON; this writes the first eight of the array.
        unsafe {
            vst1q_u32(start, self.0);
            vst1q_u32(start.add(4), self.1);
        }
        ids
    }
}
