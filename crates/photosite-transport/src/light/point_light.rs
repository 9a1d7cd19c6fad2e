//! Point lights.

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::sample::{LiContext, LiSample};
use photosite_core::math::Cone;
use photosite_core::spectrum::SpectrumId;

/// A light of the same intensity in all directions. Its level is its spectral intensity, W·sr⁻¹·nm⁻¹.
#[derive(Clone, Copy, Debug)]
pub struct PointLight;

impl DeltaModel for PointLight {
    fn extent(&self, _: &LightPose) -> Option<DeltaExtent> {
        Some(DeltaExtent { radius: 0.0, directions: Cone::ALL })
    }

    fn power_factor(&self, _: f64) -> f64 {
        4.0 * std::f64::consts::PI
    }

    #[inline]
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, _: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        LiSample::from_point(li.point, pose.position, li.spectra.sample(level, li.wavelengths))
    }
}
