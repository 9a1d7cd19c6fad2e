//! Point lights.

use glam::Vec3;

use super::lights::{LiContext, LiSample};
use photosite_core::spectrum::SpectrumId;

/// A light of the same intensity in all directions.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    /// Metres.
    pub position: Vec3,
    /// W·sr⁻¹·nm⁻¹.
    pub intensity: SpectrumId,
}

impl PointLight {
    #[inline]
    pub(super) fn sample_li(&self, li: &LiContext<'_>) -> Option<LiSample> {
        LiSample::from_point(li.point, self.position, li.spectra.sample(self.intensity, li.wavelengths))
    }
}
