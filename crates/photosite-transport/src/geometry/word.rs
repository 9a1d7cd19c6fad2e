//! Words of packed tables.

use glam::Vec3;

/// Sixteen bytes, the unit of all packed tables.
pub type Word = [u32; 4];

/// Number that stands for nothing.
pub const NONE: u32 = u32::MAX;

/// Words of a quadric: place with the radius, three vectors, kind with the mesh.
pub const QUADRIC_WORDS: usize = 5;

/// Words of a key of a motion: rotation, and the quaternion across it on the way to the next one, x y z w; translation
/// with the angle between the rotation and the next one as quaternions, in turns; of the stretch, which is symmetric,
/// the diagonal, and yz, xz, xy.
pub const KEY_WORDS: usize = 5;

/// Word of a point with something beside it.
pub(crate) fn word(v: Vec3, beside: u32) -> Word {
    [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), beside]
}
