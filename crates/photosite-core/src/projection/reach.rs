//! Reach of a lens model: the angle from the axis up to which it holds.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

/// Largest angle from the axis of a flat image, rad: 89.99°, where the image is 5730 focal lengths wide.
pub(super) const FLAT_ANGLE: f64 = FRAC_PI_2 * (1.0 - 0.01 / 90.0);

/// Range of angles from the axis in which a projection is one to one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Largest angle from the axis, rad.
    pub angle: f64,
    /// Reason why the projection ends there.
    pub end: ReachEnd,
    /// Limit in the variable that the model is a function of: a radius or an angle, as its module says.
    pub(super) radius: f64,
    /// Cosine of an angle from the axis below which directions are seen whatever the rounding.
    sure_cos: f64,
}

impl Reach {
    pub(super) fn new(angle: f64, end: ReachEnd, radius: f64) -> Self {
        Self { angle, end, radius, sure_cos: angle.cos() + 1e-9 }
    }

    /// Whether a unit direction is seen. The angle itself is computed only close to the limit, as it is costly.
    #[inline]
    pub(super) fn sees(&self, d: DVec3) -> bool {
        d.z > self.sure_cos || d.x.hypot(d.y).atan2(d.z) <= self.angle
    }
}

/// Reason why a projection ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReachEnd {
    /// End of the stated field of view, or of all directions that the model has.
    Sees,
    /// Fold: farther out, the model maps onto its own image again.
    Folds,
    /// End of a flat image, just below 90° from the axis.
    Flat,
}
