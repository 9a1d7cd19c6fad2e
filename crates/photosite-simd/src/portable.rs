//! Lanes in an array, for any processor.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use crate::{IdLanes, LANES, LaneMask, Lanes, MAX_LANES, Real, Simd, WideLanes};

/// The token of lanes that need no special instructions.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl Simd for Portable {
    type Lanes = PortableLanes;
    type Wide = PortableLanes;

    #[inline(always)]
    fn broadcast(self, value: f32) -> PortableLanes {
        PortableLanes([value; LANES])
    }
    #[inline(always)]
    fn load(self, values: &[f32; LANES]) -> PortableLanes {
        PortableLanes(*values)
    }
    #[inline(always)]
    fn indices(self, indices: &[u8; LANES]) -> [u8; LANES] {
        *indices
    }
    #[inline(always)]
    fn find(self, ids: &[u32; LANES], id: u32) -> u32 {
        (0..).zip(ids).fold(0, |found, (lane, other)| found | u32::from(*other == id) << lane)
    }
    #[inline(always)]
    fn broadcast_wide(self, value: f32) -> PortableLanes {
        self.broadcast(value)
    }
    #[inline(always)]
    fn load_wide(self, values: &[f32; MAX_LANES]) -> PortableLanes {
        let ([first, _], []) = values.as_chunks::<LANES>() else { unreachable!("two times eight") };
        self.load(first)
    }
    #[inline(always)]
    fn broadcast_id(self, id: u32) -> PortableIds {
        PortableIds([id; LANES])
    }
}

/// Eight numbers in an array.
#[derive(Clone, Copy, Debug)]
pub struct PortableLanes([f32; LANES]);

/// The results of a comparison in an array.
#[derive(Clone, Copy, Debug)]
pub struct PortableMask([bool; LANES]);

impl PortableLanes {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f32, f32) -> bool) -> PortableMask {
        PortableMask(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl LaneMask for PortableMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..LANES).fold(0, |mask, i| mask | u32::from(self.0[i]) << i)
    }
}

impl BitAnd for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] & other.0[i]))
    }
}

impl BitOr for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}

impl Not for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|is_set| !is_set))
    }
}

impl Add for PortableLanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for PortableLanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for PortableLanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for PortableLanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl Neg for PortableLanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Real for PortableLanes {
    type Mask = PortableMask;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.zip(sign, f32::copysign)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, Real::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, Real::max)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn select(mask: PortableMask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if mask.0[i] { yes.0[i] } else { no.0[i] }))
    }
}

impl Lanes for PortableLanes {
    type Indices = [u8; LANES];

    #[inline(always)]
    fn permute(self, indices: [u8; LANES]) -> Self {
        Self(indices.map(|i| self.0[usize::from(i) % LANES]))
    }
    #[inline(always)]
    fn store(self) -> [f32; LANES] {
        self.0
    }
}

impl WideLanes for PortableLanes {
    const COUNT: usize = LANES;
    type Ids = PortableIds;

    #[inline(always)]
    fn store_wide(self) -> [f32; MAX_LANES] {
        let mut values = [0.0; MAX_LANES];
        values[..LANES].copy_from_slice(&self.store());
        values
    }
}

/// Eight ids in an array.
#[derive(Clone, Copy, Debug)]
pub struct PortableIds([u32; LANES]);

impl IdLanes<PortableMask> for PortableIds {
    #[inline(always)]
    fn select(mask: PortableMask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if mask.0[i] { yes.0[i] } else { no.0[i] }))
    }
    #[inline(always)]
    fn store_wide(self) -> [u32; MAX_LANES] {
        let mut ids = [0; MAX_LANES];
        ids[..LANES].copy_from_slice(&self.0);
        ids
    }
}
