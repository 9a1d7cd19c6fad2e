//! Orthonormal frames: the local space in which BSDFs are written, with the shading normal as +Z.

use glam::Vec3;

use super::{Real, Vector};

/// A right-handed orthonormal frame (x, y, z), each of unit length in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local +X: the tangent, along which anisotropy is measured.
    pub x: Vec3,
    /// Local +Y: the bitangent.
    pub y: Vec3,
    /// Local +Z: the normal.
    pub z: Vec3,
}

impl Frame {
    /// A frame about a unit normal `z`, with its [`tangents`].
    pub fn from_normal(z: Vec3) -> Self {
        let [x, y] = tangents(Vector::from(z)).map(Vec3::from);
        Self { x, y, z }
    }

    /// A frame about a unit normal `z` whose x lies along `tangent` made perpendicular to z. It falls back to
    /// [`Self::from_normal`] where the tangent is parallel to the normal, zero or not finite.
    pub fn from_normal_tangent(z: Vec3, tangent: Vec3) -> Self {
        // y comes out imprecise where the tangent nearly lies along z; the second product makes x exactly
        // perpendicular.
        match z.cross(tangent).try_normalize().and_then(|y| y.cross(z).try_normalize()) {
            Some(x) => Self { x, y: z.cross(x), z },
            None => Self::from_normal(z),
        }
    }

    /// World → local.
    #[inline]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }

    /// Local → world.
    #[inline]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// Tangents x and y to a unit normal z, chosen without a branch on nearly parallel axes
/// (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017).
#[inline(always)]
pub fn tangents<R: Real>(z: Vector<R>) -> [Vector<R>; 2] {
    let one = z.z.broadcast(1.0);
    let sign = one.copysign(z.z);
    let a = -one / (sign + z.z);
    let b = z.x * z.y * a;
    [Vector::new(one + sign * z.x * z.x * a, sign * b, -sign * z.x), Vector::new(b, sign + z.y * z.y * a, -z.y)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::warp;
    use proptest::prelude::*;

    fn assert_orthonormal(frame: &Frame) {
        // Each product of three rounded unit vectors is off by a few ulp.
        let tolerance = 4e-6;
        assert!((frame.x.cross(frame.y) - frame.z).length() < tolerance, "{frame:?}");
        assert!((frame.x.length() - 1.0).abs() < tolerance && (frame.y.length() - 1.0).abs() < tolerance);
    }

    proptest! {
        #[test]
        fn frames_are_right_handed_and_orthonormal(u in 0f32..1.0, v in 0f32..1.0, s in 0f32..1.0, t in 0f32..1.0) {
            let normal = warp::uniform_sphere([u, v]);
            assert_orthonormal(&Frame::from_normal(normal));
            assert_orthonormal(&Frame::from_normal_tangent(normal, warp::uniform_sphere([s, t])));
            let frame = Frame::from_normal(normal);
            let direction = warp::uniform_sphere([s, t]);
            prop_assert!((frame.to_world(frame.to_local(direction)) - direction).length() < 4e-6);
        }
    }

    #[test]
    fn a_tangent_along_the_normal_still_gives_a_frame() {
        assert_orthonormal(&Frame::from_normal_tangent(Vec3::Y, Vec3::Y));
        assert_orthonormal(&Frame::from_normal_tangent(Vec3::NEG_Z, Vec3::ZERO));
    }
}
