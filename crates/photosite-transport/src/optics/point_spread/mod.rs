//! Point spread, at ray level: the offsets around a point of the sensor from which its light comes. E of a pixel is the
//! mean over these offsets of what the lens would give without them, so that nothing is resampled.
//!
//! | kind | density over the offset r on the sensor | module |
//! |---|---|---|
//! | Gaussian | exp(−r²/2σ²)/(2πσ²), the same at all wavelengths | here |
//! | Airy | (π/λN)²/(4π)·(2J₁(x)/x)² with x = πr/(λN) | `airy.rs` |
//! | measured | an image of it, of the nearest of several places | `kernel.rs` |
//! | wave | that of the wave fronts of a prescription, by place and wavelength | `photosite_lens::wave` |
//!
//! All have a sum of 1: light is moved, not lost. A density that depends on wavelength is drawn for the hero and
//! weighted for each wavelength by the balance heuristic over which one could have been the hero
//! ([Wilkie14](photosite_core::references#wilkie14) §3.3).

mod airy;
mod kernel;

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec2;

pub use kernel::{Kernel, KernelField};

use photosite_core::spectrum::{LANES, SampledSpectrum, Wavelengths};

/// Point spread of a lens: the image of a point.
#[derive(Clone, Debug, PartialEq)]
pub enum PointSpread {
    /// A Gaussian.
    Gaussian {
        /// Standard deviation along each axis, m.
        sigma_m: f64,
    },
    /// Diffraction at a round aperture ([Born99](photosite_core::references#born99) §8.5.2).
    Airy,
    /// Measured kernels, the nearest of several places.
    Measured(Arc<KernelField>),
    /// Aberrations and diffraction of a prescription, in the plane of focus. It alone has it, and draws from it itself.
    Wave,
}

impl PointSpread {
    /// An offset on the sensor, m, from two numbers in [0, 1), and the weights of the path's wavelengths. `f_number` is
    /// the distance lens → sensor over the diameter of the opening; `place` is the position in the image, from −1 at
    /// the left and the top edge to 1 at the opposite ones.
    #[inline]
    pub(super) fn sample(
        &self,
        u: [f32; 2],
        wavelengths: &Wavelengths,
        f_number: f64,
        place: DVec2,
    ) -> (DVec2, SampledSpectrum) {
        match self {
            Self::Gaussian { sigma_m } => {
                let [u, v] = u.map(f64::from);
                (DVec2::from_angle(TAU * v) * (sigma_m * (-2.0 * (1.0 - u).ln()).sqrt()), SampledSpectrum::ONE)
            }
            Self::Airy => {
                let scale =
                    |lane: usize| std::f64::consts::PI / (f64::from(wavelengths.lambda_nm(lane)) * 1e-9 * f_number);
                let [u, v] = u.map(f64::from);
                let radius = airy::radius(u) / scale(0);
                let offset = DVec2::from_angle(TAU * v) * radius;
                if wavelengths.is_hero_alone() {
                    return (offset, SampledSpectrum::ONE);
                }
                let densities: [f64; LANES] =
                    std::array::from_fn(|lane| scale(lane).powi(2) * airy::intensity(radius * scale(lane)));
                let sum: f64 = densities.iter().sum();
                // In the common zero of all there is no light to be weighted.
                let weight = |lane: usize| if sum > 0.0 { LANES as f64 * densities[lane] / sum } else { 0.0 };
                (offset, SampledSpectrum::from_lanes(|lane| weight(lane) as f32))
            }
            Self::Measured(field) => (field.nearest(place).sample(u), SampledSpectrum::ONE),
            Self::Wave => (DVec2::ZERO, SampledSpectrum::ONE),
        }
    }
}
