//! Samples of lights, and the context that they are drawn in.

use glam::Vec3;

use crate::geometry::Geometry;
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::{SampledSpectrum, SpectrumTable, Wavelengths};

/// A sampled direction to a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Handle of the light.
    pub light: u32,
    /// Radiance that arrives along the direction; of lights without extent, irradiance across the direction.
    pub radiance: SampledSpectrum,
    /// Unit vector to the light.
    pub wi: Vec3,
    /// Point on the light, with its normal; `None` where it is infinitely far.
    pub position: Option<(Vec3, Vec3)>,
    /// Density of the direction times the probability of the light; of lights without extent, that probability.
    pub pdf: Pdf<SolidAngle>,
    /// Whether no BSDF sample could have found the direction.
    pub is_delta: bool,
}

/// Context in which a light is sampled: point, time and wavelengths.
#[derive(Clone, Copy)]
pub(crate) struct LiContext<'a> {
    /// The point that samples, in the space of the light, m.
    pub(crate) point: Vec3,
    /// Time from 0 to 1.
    pub(crate) time: f32,
    pub(crate) wavelengths: &'a Wavelengths,
    pub(crate) spectra: &'a SpectrumTable,
    pub(crate) geometry: &'a Geometry,
}

/// A sampled direction to one light, as [`LightSample`] has it but for the choice of the light.
#[derive(Clone, Copy)]
pub(super) struct LiSample {
    pub(super) radiance: SampledSpectrum,
    pub(super) wi: Vec3,
    pub(super) position: Option<(Vec3, Vec3)>,
    pub(super) pdf: Pdf<SolidAngle>,
    pub(super) is_delta: bool,
}

impl LiSample {
    /// The direction from a point to another, from where light comes with that intensity.
    #[inline]
    pub(super) fn from_point(point: Vec3, position: Vec3, intensity: SampledSpectrum) -> Option<Self> {
        let to_light = position - point;
        let distance_squared = to_light.length_squared();
        (distance_squared > 0.0).then(|| Self {
            radiance: intensity / distance_squared,
            wi: to_light / distance_squared.sqrt(),
            position: Some((position, Vec3::ZERO)),
            pdf: Pdf::new(1.0),
            is_delta: true,
        })
    }
}
