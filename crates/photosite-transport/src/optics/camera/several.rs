//! Rays of several samples at a time. Through a lens without distortion that stands still they are made eight at a time: a loop
//! without branches, which a compiler turns into operations on lanes.

use glam::{DVec2, Vec3};

use super::{Camera, CameraRay, turned};
use crate::geometry::Ray;
use photosite_core::projection::{Projection, through_plane};
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};
use photosite_simd::{Simd, WithSimd, dispatch};

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

/// Samples that become rays together.
const EIGHT: usize = 8;

/// The samples, coordinate by coordinate.
#[derive(Default)]
struct Samples {
    pixel: [[f64; EIGHT]; 2],
    opening: [[f64; EIGHT]; 2],
}

/// Their rays, coordinate by coordinate.
#[derive(Default)]
struct Rays {
    origin: [[f32; EIGHT]; 3],
    direction: [[f32; EIGHT]; 3],
    weight: [f32; EIGHT],
    /// Cosines from the axis.
    cos: [f64; EIGHT],
}

impl Camera {
    /// Makes the rays of several samples, see [`generate_spectral`](Self::generate_spectral), and gives `take` the number of each
    /// sample with its wavelengths and its ray.
    #[inline]
    pub fn generate_each(
        &self,
        samples: &[CameraSample],
        wavelengths: &mut [Wavelengths],
        mut take: impl FnMut(usize, &Wavelengths, Option<(CameraRay, SampledSpectrum)>),
    ) {
        if !self.is_plain() {
            for (number, (sample, wavelengths)) in samples.iter().zip(wavelengths).enumerate() {
                let ray = self.generate_spectral(sample, wavelengths);
                take(number, wavelengths, ray);
            }
            return;
        }
        for (first, eight) in (0..).step_by(EIGHT).zip(samples.chunks(EIGHT)) {
            let rays = self.generate_eight(eight);
            for (lane, sample) in eight.iter().enumerate() {
                let ray = if rays.cos[lane] > self.reach.sure_cos() {
                    Some(rays.get(lane, self.time))
                } else {
                    self.generate(sample.pixel, sample.aperture)
                };
                take(first + lane, &wavelengths[first + lane], ray.map(|ray| (ray, SampledSpectrum::ONE)));
            }
        }
    }

    /// Whether places become rays by the shortest way.
    fn is_plain(&self) -> bool {
        self.projection == Projection::Perspective
            && self.stops.is_empty()
            && self.lateral_colour.is_none()
            && self.point_spread.is_none()
            && self.recording.is_none()
            && !self.scans
    }

    fn generate_eight(&self, samples: &[CameraSample]) -> Rays {
        let (mut from, mut to) = (Samples::default(), Rays::default());
        for (lane, sample) in samples.iter().enumerate() {
            let opening = self.opening(sample.aperture);
            [from.pixel[0][lane], from.pixel[1][lane]] = sample.pixel.to_array();
            [from.opening[0][lane], from.opening[1][lane]] = opening.to_array();
        }
        rays_of_eight(self, &from, &mut to);
        to
    }
}

impl Rays {
    #[inline]
    fn get(&self, lane: usize, time: f32) -> CameraRay {
        let vector = |of: &[[f32; EIGHT]; 3]| Vec3::new(of[0][lane], of[1][lane], of[2][lane]);
        let ray = Ray::new(vector(&self.origin), vector(&self.direction)).at_time(time);
        CameraRay { ray, weight: self.weight[lane] }
    }
}

fn rays_of_eight(camera: &Camera, samples: &Samples, rays: &mut Rays) {
    dispatch(RaysOfEight { camera, samples, rays });
}

/// The arguments of [`rays_of_eight_in`].
struct RaysOfEight<'a> {
    camera: &'a Camera,
    samples: &'a Samples,
    rays: &'a mut Rays,
}

impl WithSimd for RaysOfEight<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        rays_of_eight_in(self.camera, self.samples, self.rays);
    }
}

#[inline(always)]
fn rays_of_eight_in(camera: &Camera, samples: &Samples, rays: &mut Rays) {
    for lane in 0..EIGHT {
        let pixel = DVec2::new(samples.pixel[0][lane], samples.pixel[1][lane]);
        let opening = DVec2::new(samples.opening[0][lane], samples.opening[1][lane]);
        let aim = camera.aim_at(turned(through_plane(camera.place(pixel), 1.0)), opening);
        let (origin, direction) = aim.in_world(&camera.to_world);
        for axis in 0..3 {
            rays.origin[axis][lane] = origin[axis] as f32;
            rays.direction[axis][lane] = direction[axis] as f32;
        }
        rays.weight[lane] = camera.weight(&aim, opening);
        rays.cos[lane] = -aim.seen.direction.z;
    }
}
