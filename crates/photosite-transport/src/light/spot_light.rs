//! Spot lights, with the falloff of KHR_lights_punctual.

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::sample::{LiContext, LiSample};
use photosite_core::math::Cone;
use photosite_core::spectrum::SpectrumId;

/// A light that shines within a cone. Its level is its spectral intensity on the axis, W·sr⁻¹·nm⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    inner_rad: f32,
    outer_rad: f32,
    cos_inner: f32,
    cos_outer: f32,
}

impl SpotLight {
    /// Makes a spot light from the half-angle of full intensity and the one beyond which there is none, rad, 0 ≤ inner
    /// < outer ≤ π/2.
    pub fn new(inner_rad: f32, outer_rad: f32) -> Self {
        Self { inner_rad, outer_rad, cos_inner: inner_rad.cos(), cos_outer: outer_rad.cos() }
    }

    /// Half-angle of full intensity, rad.
    pub fn inner_rad(&self) -> f32 {
        self.inner_rad
    }

    /// Half-angle beyond which there is no light, rad.
    pub fn outer_rad(&self) -> f32 {
        self.outer_rad
    }

    /// Cosines of both half-angles, that of full intensity first.
    pub(super) fn cosines(&self) -> [f32; 2] {
        [self.cos_inner, self.cos_outer]
    }

    /// The square of the clamped ramp between the cosines of both half-angles.
    #[inline]
    fn falloff(&self, cos: f32) -> f32 {
        let ramp = ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer).max(1e-4)).clamp(0.0, 1.0);
        ramp * ramp
    }
}

impl DeltaModel for SpotLight {
    fn extent(&self, pose: &LightPose) -> Option<DeltaExtent> {
        Some(DeltaExtent { radius: 0.0, directions: Cone::of(pose.axis).widened(self.cos_outer.acos()) })
    }

    /// Integral of the squared ramp over the cosine.
    fn power_factor(&self, _: f64) -> f64 {
        let ramp = f64::from(1.0 - self.cos_inner) + f64::from(self.cos_inner - self.cos_outer) / 3.0;
        std::f64::consts::TAU * ramp
    }

    #[inline]
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, _: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        let cos = (li.point - pose.position).normalize_or_zero().dot(pose.axis);
        let falloff = self.falloff(cos);
        if falloff == 0.0 {
            return None;
        }
        LiSample::from_point(li.point, pose.position, li.spectra.sample(level, li.wavelengths) * falloff)
    }
}
