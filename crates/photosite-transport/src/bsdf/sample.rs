//! Results of a BSDF: its value for two directions, and a direction that it draws.

use glam::Vec3;

use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::SampledSpectrum;

/// Value and density for a pair of directions. Zero for lobes that are a single direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfEval {
    /// Value f of the BSDF, sr⁻¹, without cosine.
    pub f: SampledSpectrum,
    /// Density with which [`Bsdf::sample`](super::Bsdf::sample) finds `wi`.
    pub pdf: Pdf<SolidAngle>,
}

impl BsdfEval {
    /// Absence of scattering.
    pub const ZERO: Self = Self { f: SampledSpectrum::ZERO, pdf: Pdf::new(0.0) };
}

/// A direction drawn by [`Bsdf::sample`](super::Bsdf::sample). The path's throughput is to be multiplied by f·|cos
/// θᵢ|/pdf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Value f of the BSDF, sr⁻¹, without cosine. Where `is_delta`, the reflected or transmitted part over |cos θᵢ|.
    pub f: SampledSpectrum,
    /// The direction drawn.
    pub wi: Vec3,
    /// Density of the direction. Where `is_delta`, the probability of having chosen it.
    pub pdf: Pdf<SolidAngle>,
    /// Whether the direction is the only one of its lobe, so that no light can be sampled towards it.
    pub is_delta: bool,
    /// Whether `wi` and `wo` are on different sides of the surface.
    pub is_transmission: bool,
    /// Whether the path is right for the hero wavelength alone from here on; the other lanes of `f` are then zero.
    pub terminates_secondary: bool,
    /// Index on the side of `wi` over that on the side of `wo`; 1 where reflected.
    pub eta: f32,
}

impl BsdfSample {
    /// A reflected direction of a lobe of some width.
    #[inline]
    pub(super) fn reflected(f: SampledSpectrum, wi: Vec3, pdf: Pdf<SolidAngle>) -> Self {
        Self { f, wi, pdf, is_delta: false, is_transmission: false, terminates_secondary: false, eta: 1.0 }
    }

    /// The one direction of a mirror, of which a part `reflectance` comes back, chosen with `probability`.
    #[inline]
    pub(super) fn mirrored(reflectance: SampledSpectrum, wi: Vec3, probability: f32) -> Self {
        Self { is_delta: true, ..Self::reflected(reflectance / wi.z.abs(), wi, Pdf::new(probability)) }
    }

    /// Factor of the path's throughput: f·|cos θᵢ|/pdf.
    #[inline]
    pub fn throughput(&self) -> SampledSpectrum {
        self.f * (self.wi.z.abs() / self.pdf.0)
    }
}
