//! A node of eight children, and which of their boxes a ray meets.

use glam::Vec3;

use super::bounds::Bounds;
use crate::math::float::gamma;
use crate::math::simd::{LaneMask, Lanes};

/// Children of a node, at most.
pub(super) const WIDTH: usize = 8;

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
        let enlarged = inverse * (1.0 + 2.0 * gamma(3));
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

impl WideNode {
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

    /// Which children the ray enters at t < `t_max`, and where.
    ///
    /// Slabs, with the far plane widened by the bound on rounding (T. Ize, "Robust BVH Ray Traversal", JCGT 2013). A
    /// direction component of 0 gives ±∞ · 0 = NaN where the origin lies on the plane; min and max then keep their second
    /// operand, which counts the origin as inside that slab.
    #[inline(always)]
    pub(super) fn enter<L: Lanes>(&self, ray: &SlabLanes<L>, t_max: f32) -> (u32, L) {
        let mut near = L::splat(0.0);
        let mut far = L::splat(t_max);
        for axis in 0..3 {
            let first = ray.near_planes[axis];
            near = ((L::load(&self.planes[first]) - ray.origin[axis]) * ray.inverse[axis]).most(near);
            far = ((L::load(&self.planes[first ^ 1]) - ray.origin[axis]) * ray.enlarged[axis]).least(far);
        }
        (near.is_at_most(far).bits(), near)
    }
}
