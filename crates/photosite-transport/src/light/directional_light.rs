//! Directional lights.

use glam::Vec3;

use super::lights::{LiContext, LiSample};
use photosite_core::math::Pdf;
use photosite_core::spectrum::SpectrumId;

/// Parallel light from infinitely far.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalLight {
    /// Unit vector to where it comes from.
    pub towards: Vec3,
    /// Irradiance on a plane across the direction, W·m⁻²·nm⁻¹.
    pub irradiance: SpectrumId,
}

impl DirectionalLight {
    #[inline]
    pub(super) fn sample_li(&self, li: &LiContext<'_>) -> Option<LiSample> {
        Some(LiSample {
            radiance: li.spectra.sample(self.irradiance, li.wavelengths),
            wi: self.towards,
            position: None,
            pdf: Pdf::new(1.0),
            is_delta: true,
        })
    }
}
