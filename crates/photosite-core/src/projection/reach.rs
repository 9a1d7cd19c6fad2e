//! How far from the axis a model of a lens holds.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

/// The largest angle from the axis that a flat picture is followed to, rad: 89.99°, where it is 5730 focal lengths
/// wide.
pub(super) const FLAT_ANGLE: f64 = FRAC_PI_2 * (1.0 - 0.01 / 90.0);

/// How far from the axis a projection is one to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Angle from the axis, rad.
    pub angle: f64,
    /// What is beyond.
    pub end: ReachEnd,
    /// The same in what the model is a function of: a radius or an angle, see there.
    pub(super) radius: f64,
    /// Directions whose cosine from the axis is above this are seen, whatever rounding does.
    sure_cos: f64,
}

impl Reach {
    pub(super) fn new(angle: f64, end: ReachEnd, radius: f64) -> Self {
        Self { angle, end, radius, sure_cos: angle.cos() + 1e-9 }
    }

    /// Whether a unit direction is seen. The angle itself is asked for close to the end only, as it costs much.
    #[inline]
    pub(super) fn sees(&self, d: DVec3) -> bool {
        d.z > self.sure_cos || d.x.hypot(d.y).atan2(d.z) <= self.angle
    }
}

/// Why a projection ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReachEnd {
    /// The lens was said to see no more, or sees all directions that its model has.
    Sees,
    /// Farther out, the model folds back over its own picture.
    Folds,
    /// A flat picture ends at 90° from the axis.
    Flat,
}
