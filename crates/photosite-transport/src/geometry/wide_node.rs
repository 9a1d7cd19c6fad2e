//! A node of eight children, and which of their boxes a ray meets.

use glam::Vec3;

use super::Ray;
use super::bounds::Bounds;
use photosite_core::math::Real;
use photosite_core::math::float::gamma;
use photosite_simd::{LaneMask, Lanes, MOST_LANES, ManyLanes};

/// Children of a node, at most.
pub(super) const WIDTH: usize = 8;

/// What far planes are farther by, the bound on rounding.
const ENLARGED: f32 = 1.0 + 2.0 * gamma(3);

/// So far away a box may seem that holds what is at `t_max`.
#[inline(always)]
pub(super) fn beyond_rounding<R: Real>(t_max: R) -> R {
    t_max * R::splat(ENLARGED)
}

/// Boxes of up to eight children and where they are.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// min x, max x, min y, max y, min z, max z of each child; an absent child has an inverted box.
    planes: [[f32; WIDTH]; 6],
    /// What the children are known by.
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
    /// That of no ray.
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

    /// The same in all lanes.
    #[inline(always)]
    pub(super) fn in_lanes<L: Lanes>(&self) -> SlabLanes<L> {
        let Self { origin, inverse, enlarged, near_planes } = *self;
        SlabLanes { origin: splat(origin), inverse: splat(inverse), enlarged: splat(enlarged), near_planes }
    }
}

/// A [`SlabRay`] in lanes.
pub(super) struct SlabLanes<L> {
    origin: [L; 3],
    inverse: [L; 3],
    enlarged: [L; 3],
    near_planes: [usize; 3],
}

#[inline(always)]
fn splat<L: Lanes>(v: Vec3) -> [L; 3] {
    [L::splat(v.x), L::splat(v.y), L::splat(v.z)]
}

/// Rays whose directions have the same signs and no component of 0, one in each lane, with a beam around them.
pub(super) struct SlabPacket<L> {
    origin: [L; 3],
    inverse: [L; 3],
    enlarged: [L; 3],
    near_planes: [usize; 3],
    beam: Beam,
}

/// Of all rays, axis by axis: where one begins that comes to near planes first and to far ones last, and the least and the
/// largest factors.
#[derive(Clone, Copy, Default)]
struct Beam {
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    inverse: [[f32; 2]; 3],
    enlarged: [[f32; 2]; 3],
}

impl<L: ManyLanes> SlabPacket<L> {
    /// Without rays.
    pub(super) fn nothing() -> Self {
        let zero = [L::splat(0.0); 3];
        Self { origin: zero, inverse: zero, enlarged: zero, near_planes: [0; 3], beam: Beam::default() }
    }

    /// Of a ray for each lane.
    #[inline(always)]
    pub(super) fn new(rays: &[Ray]) -> Self {
        let mut origins = [[0.0; MOST_LANES]; 3];
        let mut directions = [[0.0; MOST_LANES]; 3];
        for lane in 0..L::COUNT {
            let Ray { origin, direction, .. } = rays[lane];
            for axis in 0..3 {
                origins[axis][lane] = origin[axis];
                directions[axis][lane] = direction[axis];
            }
        }
        let mut packet = Self::nothing();
        for axis in 0..3 {
            let inverse = L::splat(1.0) / L::load_many(&directions[axis]);
            let enlarged = inverse * L::splat(ENLARGED);
            let is_negative = directions[axis][0] < 0.0;
            packet.near_planes[axis] = 2 * axis + usize::from(is_negative);
            packet.origin[axis] = L::load_many(&origins[axis]);
            packet.inverse[axis] = inverse;
            packet.enlarged[axis] = enlarged;
            let [low, high] = extent::<L>(&origins[axis]);
            let (near, far) = if is_negative { (low, high) } else { (high, low) };
            packet.beam.near_origin[axis] = near;
            packet.beam.far_origin[axis] = far;
            packet.beam.inverse[axis] = extent::<L>(&inverse.store_many());
            packet.beam.enlarged[axis] = extent::<L>(&enlarged.store_many());
        }
        packet
    }
}

/// The smallest and the largest of the numbers in all lanes.
#[inline(always)]
fn extent<L: ManyLanes>(values: &[f32; MOST_LANES]) -> [f32; 2] {
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
    /// Which children some ray of a beam around all may enter.
    ///
    /// Rounding keeps the order of numbers: what any of the rays finds of a box lies between what the beam does.
    #[inline(always)]
    pub(super) fn enter_any<L: ManyLanes>(&self, rays: &SlabPacket<L>) -> u32 {
        let Beam { near_origin, far_origin, inverse, enlarged } = rays.beam;
        let mut near = L::Eight::splat(0.0);
        let mut far = L::Eight::splat(f32::INFINITY);
        for axis in 0..3 {
            let first = rays.near_planes[axis];
            let to_near = L::Eight::load(&self.planes[first]) - L::Eight::splat(near_origin[axis]);
            let to_far = L::Eight::load(&self.planes[first ^ 1]) - L::Eight::splat(far_origin[axis]);
            let ([low, high], [low_far, high_far]) = (inverse[axis], enlarged[axis]);
            near = (to_near * L::Eight::splat(low)).least(to_near * L::Eight::splat(high)).most(near);
            far = (to_far * L::Eight::splat(low_far)).most(to_far * L::Eight::splat(high_far)).least(far);
        }
        near.is_at_most(far).bits()
    }

    /// Which rays enter a child at t ≤ `reach`, and where.
    #[inline(always)]
    pub(super) fn enter_slot<L: ManyLanes>(&self, slot: usize, rays: &SlabPacket<L>, reach: L) -> (u32, L) {
        let mut near = L::splat(0.0);
        let mut far = reach;
        for axis in 0..3 {
            let first = rays.near_planes[axis];
            near = ((L::splat(self.planes[first][slot]) - rays.origin[axis]) * rays.inverse[axis]).most(near);
            far = ((L::splat(self.planes[first ^ 1][slot]) - rays.origin[axis]) * rays.enlarged[axis]).least(far);
        }
        (near.is_at_most(far).bits(), near)
    }

    /// Without children.
    pub(super) const EMPTY: Self = {
        let (min, max) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { planes: [min, max, min, max, min, max], children: [0; WIDTH] }
    };

    /// Of at most eight boxes, lower and upper corner.
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

    /// The same boxes, with children known by other numbers.
    pub(super) fn with_children(&self, number: impl Fn(u32) -> u32) -> Self {
        Self { children: self.children.map(number), ..*self }
    }

    /// Which children the ray enters at t ≤ `t_max` and no more than rounding farther, and where.
    ///
    /// Slabs, with the far plane widened by the bound on rounding (T. Ize, "Robust BVH Ray Traversal", JCGT 2013). A
    /// direction component of 0 gives ±∞ · 0 = NaN where the origin lies on the plane; min and max then keep their second
    /// operand, which counts the origin as inside that slab.
    #[inline(always)]
    pub(super) fn enter<L: Lanes>(&self, ray: &SlabLanes<L>, t_max: f32) -> (u32, L) {
        let mut near = L::splat(0.0);
        let mut far = L::splat(beyond_rounding(t_max));
        for axis in 0..3 {
            let first = ray.near_planes[axis];
            near = ((L::load(&self.planes[first]) - ray.origin[axis]) * ray.inverse[axis]).most(near);
            far = ((L::load(&self.planes[first ^ 1]) - ray.origin[axis]) * ray.enlarged[axis]).least(far);
        }
        (near.is_at_most(far).bits(), near)
    }
}
