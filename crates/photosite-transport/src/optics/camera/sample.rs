//! What a camera ray is sampled from, and the rays of several samples.

use glam::DVec2;

use super::{Camera, CameraRay};
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// What a ray of the camera is made from.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// Continuous pixel coordinates.
    pub pixel: DVec2,
    /// Numbers in [0, 1) for the point of the aperture.
    pub aperture: [f32; 2],
    /// The same for the time within the exposure of the pixel's row.
    pub time: f32,
    /// The same for the point spread.
    pub spread: [f32; 2],
}

impl Camera {
    /// Makes the rays of several samples, see [`generate_spectral`](Self::generate_spectral), and gives `take` the index of each
    /// sample with its wavelengths and its ray.
    #[inline]
    pub fn generate_each(
        &self,
        samples: &[CameraSample],
        wavelengths: &mut [Wavelengths],
        mut take: impl FnMut(usize, &Wavelengths, Option<(CameraRay, SampledSpectrum)>),
    ) {
        for (index, (sample, wavelengths)) in samples.iter().zip(wavelengths).enumerate() {
            let ray = self.generate_spectral(sample, wavelengths);
            take(index, wavelengths, ray);
        }
    }
}
