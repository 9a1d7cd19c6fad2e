//! Full well: a pixel holds only so many electrons; what comes on top is lost.

use crate::units::Electrons;

/// The charge that stays in the pixel, e⁻.
#[inline]
pub(super) fn clip(charge_e: f64, full_well: Electrons) -> f64 {
    charge_e.min(full_well.0)
}
