//! Cones of directions.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::Vec3;

/// All unit vectors within an angle of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Axis, a unit vector.
    pub axis: Vec3,
    /// Largest angle from the axis, rad, from 0 to π.
    pub angle: f32,
}

impl Cone {
    /// All directions.
    pub const ALL: Self = Self { axis: Vec3::Z, angle: PI };

    /// Cone of a single direction, a unit vector.
    pub const fn of(axis: Vec3) -> Self {
        Self { axis, angle: 0.0 }
    }

    /// A cone with the same axis and a wider angle.
    pub fn widened(self, angle: f32) -> Self {
        Self { angle: (self.angle + angle).min(PI), ..self }
    }

    /// Smallest cone that holds both cones ([pbrt4](crate::references#pbrt4) §3.8.4), up to rounding.
    pub fn union(self, other: Self) -> Self {
        let (wide, narrow) = if self.angle >= other.angle { (self, other) } else { (other, self) };
        // Of meshes most normals are alike.
        if wide.axis == narrow.axis {
            return wide;
        }
        let between = angle_between(wide.axis, narrow.axis);
        if between + narrow.angle <= wide.angle {
            return wide;
        }
        let angle = 0.5 * (wide.angle + between + narrow.angle);
        if angle >= PI {
            return Self::ALL;
        }
        let turn = angle - wide.angle;
        let upright = |v: Vec3| v - wide.axis * wide.axis.dot(v);
        // Twice, since of axes that are nearly opposite the first leaves little but rounding.
        let across = upright(upright(narrow.axis).normalize_or_zero());
        let across = if across.length_squared() > 0.25 { across } else { wide.axis.any_orthonormal_vector() };
        Self { axis: (wide.axis * turn.cos() + across * turn.sin()).normalize(), angle }
    }

    /// Smallest cone that holds all sums of its directions with positive weights: all directions where the cone is
    /// wider than a half space.
    pub fn hull(self) -> Self {
        if self.angle < FRAC_PI_2 { self } else { Self::ALL }
    }
}

/// Angle between unit vectors, rad, exact where they are near (W. Kahan, "How Futile are Mindless Assessments of
/// Roundoff", 2006, §12).
pub fn angle_between(a: Vec3, b: Vec3) -> f32 {
    2.0 * (a - b).length().atan2((a + b).length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::hash::{hash64, unit_f32};
    use crate::math::warp;

    #[test]
    fn a_union_holds_both_and_no_more() {
        let number = |key: u64, i: u64| unit_f32(hash64(key, i) as u32);
        let direction = |key: u64| warp::uniform_sphere([number(key, 0), number(key, 1)]);
        for key in 0..2000 {
            let [a, b] = [key, key + 10_000].map(|k| {
                let near = if k % 3 == 0 { direction(key) } else { direction(k) };
                let opposite = if k % 7 == 0 { -direction(key) } else { near };
                Cone { axis: opposite, angle: number(k, 2).powi(3) * PI }
            });
            let union = a.union(b);
            let mut farthest = 0.0f32;
            for cone in [a, b] {
                // The point of the cone that is farthest from the union's axis.
                let reach = angle_between(union.axis, cone.axis) + cone.angle;
                // A few roundings of angles up to π.
                assert!(reach <= union.angle + 2e-6 || union == Cone::ALL, "{a:?} {b:?} {union:?}");
                farthest = farthest.max(reach);
            }
            assert!(union == Cone::ALL || (farthest - union.angle).abs() < 2e-6, "{a:?} {b:?} {union:?}");
        }
    }
}
