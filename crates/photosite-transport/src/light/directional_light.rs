//! Directional lights.

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::sample::{LiContext, LiSample};
use photosite_core::math::Pdf;
use photosite_core::spectrum::SpectrumId;

/// Directional light: parallel light from infinitely far. Its level is the irradiance on a plane across the direction,
/// W·m⁻²·nm⁻¹.
#[derive(Clone, Copy, Debug)]
pub struct DirectionalLight;

impl DeltaModel for DirectionalLight {
    fn extent(&self, _: &LightPose) -> Option<DeltaExtent> {
        None
    }

    fn power_factor(&self, disk_m2: f64) -> f64 {
        disk_m2
    }

    #[inline]
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, _: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        Some(LiSample {
            radiance: li.spectra.sample(level, li.wavelengths),
            wi: -pose.axis,
            position: None,
            pdf: Pdf::new(1.0),
            is_delta: true,
        })
    }
}
