//! Numbers side by side: what makes them, what they do beside arithmetic, and vectors of them in memory.

use glam::Vec3;

use crate::{Real, Vector};

/// Numbers in [`Lanes`].
pub const LANES: usize = 8;

/// Numbers in the widest [`WideLanes`].
pub const MAX_LANES: usize = 16;

/// Evidence that the processor has certain instructions, and so the source of lanes that use them.
///
/// Implemented by zero-sized tokens: [`Portable`](crate::Portable), which anyone may make, and `Avx2` and `Avx512`,
/// which only a check of the processor gives out.
pub trait Simd: Copy {
    /// Eight numbers.
    type Lanes: Lanes;
    /// As many numbers as a register has room for.
    type Wide: WideLanes;

    /// `value` in all lanes.
    fn broadcast(self, value: f32) -> Self::Lanes;
    /// A number of the array in each lane.
    fn load(self, values: &[f32; LANES]) -> Self::Lanes;
    /// Indices for [`Lanes::permute`], each below [`LANES`].
    fn indices(self, indices: &[u8; LANES]) -> <Self::Lanes as Lanes>::Indices;
    /// Bit `i` is set where id `i` is this one.
    fn find(self, ids: &[u32; LANES], id: u32) -> u32;
    /// `value` in all wide lanes.
    fn broadcast_wide(self, value: f32) -> Self::Wide;
    /// The first [`WideLanes::COUNT`] numbers of the array.
    fn load_wide(self, values: &[f32; MAX_LANES]) -> Self::Wide;
    /// `id` in all wide lanes.
    fn broadcast_id(self, id: u32) -> <Self::Wide as WideLanes>::Ids;
}

/// Eight `f32`, one in each lane.
pub trait Lanes: Real<Mask: LaneMask> {
    /// An index of a lane in each lane.
    type Indices: Copy;

    /// Lane `i` of the result is lane `indices[i]` of `self`.
    #[must_use]
    fn permute(self, indices: Self::Indices) -> Self;
    /// The numbers, from the first lane to the last.
    fn store(self) -> [f32; LANES];
}

/// As many `f32` as a register has room for, for work that takes rays in groups of any size.
pub trait WideLanes: Real<Mask: LaneMask> {
    /// Number of lanes, at most [`MAX_LANES`].
    const COUNT: usize;
    /// An id in each of as many lanes.
    type Ids: IdLanes<Self::Mask>;

    /// The numbers, and then zeros.
    fn store_wide(self) -> [f32; MAX_LANES];
}

/// A `u32` in each of the lanes that have a mask `M`: which primitive a lane's number belongs to.
pub trait IdLanes<M>: Copy {
    /// `yes` where the mask is set, `no` elsewhere.
    fn select(mask: M, yes: Self, no: Self) -> Self;
    /// The ids, and then zeros.
    fn store_wide(self) -> [u32; MAX_LANES];
}

/// The result of a comparison in each lane.
pub trait LaneMask {
    /// Bit `i` is set where the comparison holds in lane `i`.
    fn bits(self) -> u32;
}

/// Eight vectors in memory: all x, all y, all z.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vectors([[f32; LANES]; 3]);

impl Vectors {
    /// Puts a vector into a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        [self.0[0][lane], self.0[1][lane], self.0[2][lane]] = v.to_array();
    }

    /// The vector of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.0[0][lane], self.0[1][lane], self.0[2][lane])
    }

    /// All eight, in lanes.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> Vector<S::Lanes> {
        Vector::new(simd.load(&self.0[0]), simd.load(&self.0[1]), simd.load(&self.0[2]))
    }

    /// From lanes.
    #[inline(always)]
    pub fn store<L: Lanes>(v: Vector<L>) -> Self {
        Self([v.x.store(), v.y.store(), v.z.store()])
    }
}
