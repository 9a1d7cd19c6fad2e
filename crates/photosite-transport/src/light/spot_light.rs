//! Spot lights, with the falloff of KHR_lights_punctual.

use glam::Vec3;

use super::lights::{LiContext, LiSample};
use photosite_core::spectrum::SpectrumId;

/// A light that shines within a cone.
#[derive(Clone, Copy, Debug)]
pub struct SpotLight {
    /// Metres.
    pub position: Vec3,
    /// Unit vector along the middle of the cone.
    pub axis: Vec3,
    /// Cosine of the half-angle of full intensity.
    pub cos_inner: f32,
    /// Cosine of the half-angle beyond which there is none.
    pub cos_outer: f32,
    /// W·sr⁻¹·nm⁻¹ on the axis.
    pub intensity: SpectrumId,
}

impl SpotLight {
    #[inline]
    pub(super) fn sample_li(&self, li: &LiContext<'_>) -> Option<LiSample> {
        let cos = (li.point - self.position).normalize_or_zero().dot(self.axis);
        let falloff = self.falloff(cos);
        if falloff == 0.0 {
            return None;
        }
        LiSample::from_point(li.point, self.position, li.spectra.sample(self.intensity, li.wavelengths) * falloff)
    }

    /// The square of the clamped ramp between the cosines of both half-angles.
    #[inline]
    fn falloff(&self, cos: f32) -> f32 {
        let ramp = ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer).max(1e-4)).clamp(0.0, 1.0);
        ramp * ramp
    }
}
