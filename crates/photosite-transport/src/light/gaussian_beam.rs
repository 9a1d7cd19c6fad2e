//! Laser beams, also those that a lens spreads to a line.

use std::f32::consts::FRAC_2_PI;

use glam::{Vec2, Vec3};

use super::delta_model::{DeltaExtent, DeltaModel, LightPose};
use super::sample::{LiContext, LiSample};
use photosite_core::math::{Cone, Pdf};
use photosite_core::spectrum::SpectrumId;

/// Radii beyond this multiple of the beam's radius get no light: a part e⁻¹⁸ = 1.5·10⁻⁸ of the flux.
const CUT: f32 = 3.0;

/// Half-angle of the narrowest cone that the light tree is told of, rad. The tree takes a light for a point whose intensity
/// fills its cone: that of a collimated beam would outshine all lights that are its neighbours in the tree, also at points
/// that it does not reach, where samples of it are lost.
const NARROWEST: f32 = 0.5;

/// Simple astigmatic Gaussian beam (ISO 11146-1:2021 §3) that leaves the plane z = 0 of its space along −z. Its level
/// is its spectral flux Φ, W·nm⁻¹.
///
/// Along each of the two axes across the beam, its radius (to 1/e² of the irradiance on the axis) after z metres is
///
///   w² = w₀² + (z·tan θ)²,
///
/// w₀ the radius of the waist, m, and θ the divergence, half an angle, rad. The irradiance on a plane across the beam
/// is
///
///   E = 2Φ/(π·wₓ·w_y)·exp(−2·x²/wₓ² − 2·y²/w_y²),
///
/// and light travels along the straight lines on which x/wₓ and y/w_y stay what they are where the beam is wide, with
/// the slope of the wavefront x·z·tan²θ/w² ([Siegman86](photosite_core::references#siegman86) §17.1). Two equal axes
/// make a beam, one that diverges and one that does not a line. Rays know no diffraction: that θ is at least λ/(π·w₀)
/// is left to who describes the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GaussianBeam {
    waist: Vec2,
    tan_divergence: Vec2,
}

impl GaussianBeam {
    /// Makes a beam from the radii of the waist, m, and the divergences, rad, along the beam's x and y. Along each of
    /// them one may be 0; both must be finite and below π/2.
    pub fn new(waist_radius_m: [f64; 2], divergence_rad: [f64; 2]) -> Self {
        let pair = |[x, y]: [f64; 2]| Vec2::new(x as f32, y as f32);
        Self { waist: pair(waist_radius_m), tan_divergence: pair(divergence_rad.map(f64::tan)) }
    }

    /// Radii of the waist, m, and tangents of the divergences, along the beam's x and y.
    pub(super) fn numbers(&self) -> [f32; 4] {
        let Self { waist, tan_divergence } = *self;
        [waist.x, waist.y, tan_divergence.x, tan_divergence.y]
    }
}

impl DeltaModel for GaussianBeam {
    fn extent(&self, pose: &LightPose) -> Option<DeltaExtent> {
        // No slope is above that of the beam's edge far away.
        let steepest = (CUT * self.tan_divergence.length()).atan();
        let directions = Cone::of(pose.axis).widened(steepest.max(NARROWEST));
        Some(DeltaExtent { radius: CUT * self.waist.length(), directions })
    }

    fn power_factor(&self, _: f64) -> f64 {
        1.0
    }

    #[inline]
    fn sample_li(&self, pose: &LightPose, level: SpectrumId, _: [f32; 2], li: &LiContext<'_>) -> Option<LiSample> {
        let local = pose.world_to_light * (li.point - pose.position);
        let (across, z) = (local.truncate(), -local.z);
        if z <= 0.0 {
            return None;
        }

        // Irradiance on the plane across the beam, for a flux of 1
        let spread = self.tan_divergence * z;
        let radius_squared = self.waist * self.waist + spread * spread;
        let exponent = 2.0 * (across * across / radius_squared).element_sum();
        if exponent.is_nan() || exponent > 2.0 * CUT * CUT {
            return None;
        }
        let irradiance = FRAC_2_PI / (radius_squared.x * radius_squared.y).sqrt() * (-exponent).exp();

        // The ray through the point, back to the plane that it leaves
        let slope = across * spread * self.tan_divergence / radius_squared;
        let from = pose.world_to_light.inverse() * (across - slope * z).extend(0.0);
        let to_light = pose.world_to_light.inverse() * Vec3::new(-slope.x, -slope.y, 1.0);
        let per_cosine = to_light.length();
        Some(LiSample {
            radiance: li.spectra.sample(level, li.wavelengths) * (irradiance * per_cosine),
            wi: to_light / per_cosine,
            position: Some((pose.position + from, Vec3::ZERO)),
            pdf: Pdf::new(1.0),
            is_delta: true,
        })
    }
}
