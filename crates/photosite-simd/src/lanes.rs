//! Numbers side by side: their construction, operations beside arithmetic, and vectors of them in memory.

use glam::Vec3;

use crate::{Real, Vector};

/// Number of lanes in [`Lanes`].
pub const LANES: usize = 8;

/// Largest number of lanes in [`WideLanes`].
pub const MAX_LANES: usize = 16;

/// Evidence that the processor has certain instructions, and so the source of lanes that use them.
///
/// The trait is implemented by zero-sized tokens: [`Portable`](crate::Portable) and, on AArch64, `Neon`, which anyone
/// may make, and `Avx2` and `Avx512`, which only a check of the processor gives out.
pub trait Simd: Copy {
    /// Type of eight numbers in lanes.
    type Lanes: Lanes;
    /// Type of as many numbers as the widest register holds, eight at least.
    type Wide: WideLanes;

    /// Lanes that all hold `value`.
    fn broadcast(self, value: f32) -> Self::Lanes;
    /// Lanes with the numbers of an array.
    fn load(self, values: &[f32; LANES]) -> Self::Lanes;
    /// Indices for [`Lanes::permute`], each below [`LANES`].
    fn indices(self, indices: &[u8; LANES]) -> <Self::Lanes as Lanes>::Indices;
    /// Bits of the lanes whose id equals `id`: bit `i` for id `i`.
    fn find(self, ids: &[u32; LANES], id: u32) -> u32;
    /// Wide lanes that all hold `value`.
    fn broadcast_wide(self, value: f32) -> Self::Wide;
    /// The first [`WideLanes::COUNT`] numbers of the array.
    fn load_wide(self, values: &[f32; MAX_LANES]) -> Self::Wide;
    /// Wide lanes that all hold `id`.
    fn broadcast_id(self, id: u32) -> <Self::Wide as WideLanes>::Ids;
}

/// Eight `f32`, one in each lane.
pub trait Lanes: Real<Mask: LaneMask> {
    /// An index of a lane in each lane.
    type Indices: Copy;

    /// Permutation: lane `i` of the result is lane `indices[i]` of `self`.
    #[must_use]
    fn permute(self, indices: Self::Indices) -> Self;
    /// Array of the numbers, from the first lane to the last.
    fn store(self) -> [f32; LANES];
}

/// Lanes of `f32` that fill a register, for work that takes rays in groups of any size.
pub trait WideLanes: Real<Mask: LaneMask> {
    /// Number of lanes, at most [`MAX_LANES`].
    const COUNT: usize;
    /// Type of an id in each lane.
    type Ids: IdLanes<Self::Mask>;

    /// Array of the numbers, followed by zeros.
    fn store_wide(self) -> [f32; MAX_LANES];
}

/// A `u32` in each of the lanes that have a mask `M`, such as the primitive that a lane's number belongs to.
pub trait IdLanes<M>: Copy {
    /// Selection of `yes` where the mask is set, and of `no` elsewhere.
    fn select(mask: M, yes: Self, no: Self) -> Self;
    /// Array of the ids, followed by zeros.
    fn store_wide(self) -> [u32; MAX_LANES];
}

/// The result of a comparison in each lane.
pub trait LaneMask {
    /// Bits of the mask: bit `i` is set where the comparison holds in lane `i`.
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

    /// Vectors of all eight lanes.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> Vector<S::Lanes> {
        Vector::new(simd.load(&self.0[0]), simd.load(&self.0[1]), simd.load(&self.0[2]))
    }

    /// Vectors in memory from lanes.
    #[inline(always)]
    pub fn store<L: Lanes>(v: Vector<L>) -> Self {
        Self([v.x.store(), v.y.store(), v.z.store()])
    }
}
