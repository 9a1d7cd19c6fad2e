//! Hits that single precision cannot decide: those too near to be told from a surface that the ray leaves, and all of
//! slender triangles. They are decided in f64.
//!
//! Corners, origin and direction are taken as they are. In f64 their differences and products are exact to 1e-16, so
//! that the sign of the distance is that of exact arithmetic for triangles of any aspect. A ray does not meet the
//! triangle that it leaves ([`Facet`](super::Facet)); of others in the same plane, it begins on the far side
//! ([`offset_origin`](super::offset_origin)).

use glam::Vec3;

/// Half of the unit in the last place of 1 in single precision.
const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;

/// Aspect from which a triangle is slender.
const SLENDER: f64 = 16.0;

/// Whether a triangle is so long for its width that hits in single precision are not where the surface is: its square of
/// the longest edge is above [`SLENDER`] times twice its area.
///
/// With u = 2⁻²⁴, a ray from no farther than R along any axis from corners of edges up to l: shears leave their
/// coordinates within 7uR, and areas between points of at most 2l within 56uRl + 16ul² of sum 2A·cos θ. The weights of
/// three corners then move the hit in the plane by 12·(56R + 16l)·u·(l²/2A)/cos θ at most, and the distance by as much,
/// so that the height over the plane is off by 12·(56R + 16l)·16u of triangles that are not slender, a few ten-thousandths
/// where the worst of all roundings meet, whatever their distance; some hundredth of it is found.
pub(super) fn is_slender(corners: &[Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    longest > SLENDER * (b - a).cross(c - a).length()
}

/// Intersection in f64: t and the barycentric weights of the second and third corner, where a ray that passes through
/// the triangle meets it at t > 0 (T. Möller, B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997).
///
/// Corners are known to half a unit in their last place. Of an origin that is no farther from the plane than they may
/// be, by Σ |nₖ|·u·Σ bᵢ·|vᵢₖ| over axes and corners with u = 2⁻²⁴, it is not known on which side it lies: it is on the
/// surface, and the ray leaves it.
#[inline(never)]
pub(super) fn near_hit(corners: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<(f32, [f32; 2])> {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let (from_a, direction) = (origin.as_dvec3() - a, direction.as_dvec3());
    let (ab, ac) = (b - a, c - a);
    let q = from_a.cross(ab);
    // Height above the plane and fall towards it, both times the length of the normal.
    let height = ac.dot(q);
    let p = direction.cross(ac);
    let fall = ab.dot(p);
    if height * fall <= 0.0 {
        return None;
    }
    let b1 = (from_a.dot(p) / fall).clamp(0.0, 1.0);
    let b2 = (direction.dot(q) / fall).clamp(0.0, 1.0 - b1);
    let magnitude = a.abs() * (1.0 - b1 - b2) + b.abs() * b1 + c.abs() * b2;
    let is_beyond = height.abs() > ab.cross(ac).abs().dot(magnitude) * ROUNDING;
    is_beyond.then_some(((height / fall) as f32, [b1 as f32, b2 as f32]))
}
