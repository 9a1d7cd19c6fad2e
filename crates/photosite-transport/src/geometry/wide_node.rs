//! A node of eight children, and which of their boxes a ray meets.

use glam::Vec3;

use super::Ray;
use super::bounds::Bounds;
use photosite_core::math::Real;
use photosite_core::math::float::gamma;
use photosite_simd::{LaneMask, MAX_LANES, Simd, WideLanes};

/// Children of a node, at most.
pub(super) const WIDTH: usize = 8;

/// Factor by which far planes are moved away, the bound on rounding.
const ENLARGED: f32 = 1.0 + 2.0 * gamma(3);

/// Largest distance at which a box may seem to be that holds a point at `t_max`.
#[inline(always)]
pub(super) fn beyond_rounding<R: Real>(t_max: R) -> R {
    t_max * t_max.broadcast(ENLARGED)
}

/// Boxes of up to eight children and where they are.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// Planes of the boxes: min x, max x, min y, max y, min z, max z of each child; an absent child has an inverted
    /// box.
    planes: [[f32; WIDTH]; 6],
    /// Numbers by which the children are known.
    pub(super) children: [u32; WIDTH],
}

/// A ray as the boxes of nodes meet it.
#[derive(Clone, Copy)]
pub(super) struct SlabRay {
    origin: Vec3,
    /// 1/direction, and the same enlarged by the bound on rounding.
    inverse: Vec3,
    enlarged: Vec3,
    /// Index of the plane that the ray meets first, for each axis.
    near_planes: [usize; 3],
}

impl SlabRay {
    /// Placeholder of no ray.
    pub(super) const NONE: Self =
        Self { origin: Vec3::ZERO, inverse: Vec3::ZERO, enlarged: Vec3::ZERO, near_planes: [0; 3] };

    #[inline(always)]
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let inverse = direction.recip();
        let near_planes =
            [usize::from(inverse.x < 0.0), 2 + usize::from(inverse.y < 0.0), 4 + usize::from(inverse.z < 0.0)];
        let enlarged = inverse * ENLARGED;
        Self { origin, inverse, enlarged, near_planes }
    }

    /// Returns the ray repeated in all lanes.
    #[inline(always)]
    pub(super) fn in_lanes<S: Simd>(&self, simd: S) -> SlabLanes<S> {
        let Self { origin, inverse, enlarged, near_planes } = *self;
        SlabLanes {
            origin: broadcast(simd, origin),
            inverse: broadcast(simd, inverse),
            enlarged: broadcast(simd, enlarged),
            near_planes,
        }
    }
}

/// A [`SlabRay`] in lanes.
pub(super) struct SlabLanes<S: Simd> {
    origin: [S::Lanes; 3],
    inverse: [S::Lanes; 3],
    enlarged: [S::Lanes; 3],
    near_planes: [usize; 3],
}

#[inline(always)]
fn broadcast<S: Simd>(simd: S, v: Vec3) -> [S::Lanes; 3] {
    [simd.broadcast(v.x), simd.broadcast(v.y), simd.broadcast(v.z)]
}

/// Rays whose directions have the same signs and no component of 0, one in each lane, with a beam around them.
pub(super) struct SlabPacket<S: Simd> {
    origin: [S::Wide; 3],
    inverse: [S::Wide; 3],
    enlarged: [S::Wide; 3],
    near_planes: [usize; 3],
    beam: Beam,
}

/// Beam around all rays, axis by axis: the origin of a ray that comes to near planes first and to far ones last, and
/// the least and the largest factors.
#[derive(Clone, Copy, Default)]
struct Beam {
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    inverse: [[f32; 2]; 3],
    enlarged: [[f32; 2]; 3],
}

impl<S: Simd> SlabPacket<S> {
    /// Placeholder of no rays.
    pub(super) fn none(simd: S) -> Self {
        let zero = [simd.broadcast_wide(0.0); 3];
        Self { origin: zero, inverse: zero, enlarged: zero, near_planes: [0; 3], beam: Beam::default() }
    }

    /// Packs one ray into each lane.
    #[inline(always)]
    pub(super) fn new(simd: S, rays: &[Ray]) -> Self {
        let mut origins = [[0.0; MAX_LANES]; 3];
        let mut directions = [[0.0; MAX_LANES]; 3];
        for lane in 0..S::Wide::COUNT {
            let Ray { origin, direction, .. } = rays[lane];
            for axis in 0..3 {
                origins[axis][lane] = origin[axis];
                directions[axis][lane] = direction[axis];
            }
        }
        let mut packet = Self::none(simd);
        for axis in 0..3 {
            let inverse = simd.broadcast_wide(1.0) / simd.load_wide(&directions[axis]);
            let enlarged = inverse * simd.broadcast_wide(ENLARGED);
            let is_negative = directions[axis][0] < 0.0;
            packet.near_planes[axis] = 2 * axis + usize::from(is_negative);
            packet.origin[axis] = simd.load_wide(&origins[axis]);
            packet.inverse[axis] = inverse;
            packet.enlarged[axis] = enlarged;
            let [low, high] = extent::<S::Wide>(&origins[axis]);
            let (near, far) = if is_negative { (low, high) } else { (high, low) };
            packet.beam.near_origin[axis] = near;
            packet.beam.far_origin[axis] = far;
            packet.beam.inverse[axis] = extent::<S::Wide>(&inverse.store_wide());
            packet.beam.enlarged[axis] = extent::<S::Wide>(&enlarged.store_wide());
        }
        packet
    }
}

/// The smallest and the largest of the numbers in all lanes.
#[inline(always)]
fn extent<L: WideLanes>(values: &[f32; MAX_LANES]) -> [f32; 2] {
    let (mut low, mut high) = (*values, *values);
    let mut half = L::COUNT / 2;
    while half > 0 {
        for i in 0..half {
            low[i] = if low[i + half] < low[i] { low[i + half] } else { low[i] };
            high[i] = if high[i + half] > high[i] { high[i + half] } else { high[i] };
        }
        half /= 2;
    }
    [low[0], high[0]]
}

impl WideNode {
    /// Mask of the children that some ray of a beam around all may enter.
    ///
    /// Rounding keeps the order of numbers: what any of the rays finds of a box lies between what the beam does.
    #[inline(always)]
    pub(super) fn enter_any<S: Simd>(&self, simd: S, rays: &SlabPacket<S>) -> u32 {
        let Beam { near_origin, far_origin, inverse, enlarged } = rays.beam;
        let mut near = simd.broadcast(0.0);
        let mut far = simd.broadcast(f32::INFINITY);
        for axis in 0..3 {
            let first = rays.near_planes[axis];
            let to_near = simd.load(&self.planes[first]) - simd.broadcast(near_origin[axis]);
            let to_far = simd.load(&self.planes[first ^ 1]) - simd.broadcast(far_origin[axis]);
            let ([low, high], [low_far, high_far]) = (inverse[axis], enlarged[axis]);
            near = (to_near * simd.broadcast(low)).min(to_near * simd.broadcast(high)).max(near);
            far = (to_far * simd.broadcast(low_far)).max(to_far * simd.broadcast(high_far)).min(far);
        }
        near.le(far).bits()
    }

    /// Mask of the rays that enter a child at t ≤ `reach`, and the parameters at which they do.
    #[inline(always)]
    pub(super) fn enter_slot<S: Simd>(
        &self,
        simd: S,
        slot: usize,
        rays: &SlabPacket<S>,
        reach: S::Wide,
    ) -> (u32, S::Wide) {
        let mut near = simd.broadcast_wide(0.0);
        let mut far = reach;
        for axis in 0..3 {
            let first = rays.near_planes[axis];
            near = ((simd.broadcast_wide(self.planes[first][slot]) - rays.origin[axis]) * rays.inverse[axis]).max(near);
            far = ((simd.broadcast_wide(self.planes[first ^ 1][slot]) - rays.origin[axis]) * rays.enlarged[axis])
                .min(far);
        }
        (near.le(far).bits(), near)
    }

    /// Node without children.
    pub(super) const EMPTY: Self = {
        let (min, max) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { planes: [min, max, min, max, min, max], children: [0; WIDTH] }
    };

    /// Makes a node of at most eight boxes, lower and upper corner.
    pub(super) fn new(boxes: &[Bounds]) -> Self {
        let mut node = Self::EMPTY;
        for (slot, (min, max)) in boxes.iter().enumerate() {
            for axis in 0..3 {
                node.planes[2 * axis][slot] = min[axis];
                node.planes[2 * axis + 1][slot] = max[axis];
            }
        }
        node
    }

    /// Lower and upper corner of the box of a child; `None` where there is none.
    pub(super) fn bounds(&self, slot: usize) -> Option<Bounds> {
        let corner = |side: usize| Vec3::from_array([0, 2, 4].map(|axis| self.planes[axis + side][slot]));
        let (low, high) = (corner(0), corner(1));
        (low.x <= high.x).then_some((low, high))
    }

    /// Returns the boxes with children known by other numbers.
    pub(super) fn with_children(&self, number: impl Fn(u32) -> u32) -> Self {
        Self { children: self.children.map(number), ..*self }
    }

    /// Mask of the children that the ray enters at t ≤ `t_max` and no more than rounding farther, and the parameters at
    /// which it does.
    ///
    /// Slabs, with the far plane widened by the bound on rounding (T. Ize, "Robust BVH Ray Traversal", JCGT 2013). A
    /// direction component of 0 gives ±∞ · 0 = NaN where the origin lies on the plane; min and max then keep their
    /// second operand, which counts the origin as inside that slab.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, ray: &SlabLanes<S>, t_max: f32) -> (u32, S::Lanes) {
        let mut near = simd.broadcast(0.0);
        let mut far = simd.broadcast(beyond_rounding(t_max));
        for axis in 0..3 {
            let first = ray.near_planes[axis];
            near = ((simd.load(&self.planes[first]) - ray.origin[axis]) * ray.inverse[axis]).max(near);
            far = ((simd.load(&self.planes[first ^ 1]) - ray.origin[axis]) * ray.enlarged[axis]).min(far);
        }
        (near.le(far).bits(), near)
    }
}
