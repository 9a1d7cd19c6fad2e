//! Camera rays: the point of the aperture through which a place sees the scene, and the weight of its radiance.

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::Camera;
use crate::geometry::Ray;
use crate::optics::prescribed::REFERENCE_NM;
use crate::optics::{Falloff, Intrinsics, LensKind, PointSpread, Seen};
use photosite_core::math::warp;
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// Sample from which a camera ray is made.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// Continuous pixel coordinates.
    pub pixel: DVec2,
    /// Random numbers in [0, 1) for the point of the aperture.
    pub aperture: [f32; 2],
    /// Random number in [0, 1) for the time within the exposure of the pixel's row.
    pub time: f32,
    /// Random numbers in [0, 1) for the point spread.
    pub spread: [f32; 2],
}

/// Ray into the scene with the weight of its radiance.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// Ray in world space, with a direction of unit length.
    pub ray: Ray,
    /// Weight, sr: E = weight · L for one sample of the aperture, without the lens's transmittance.
    pub weight: f32,
}

/// A ray of a place through a point of the aperture, in camera space.
pub(super) struct Aim {
    pub(super) seen: Seen,
    /// Origin on the entrance pupil.
    pub(super) origin: DVec3,
    /// Vector from the origin to the point in focus, of any length.
    pub(super) towards: DVec3,
}

impl Aim {
    /// Origin and unit direction in world space.
    #[inline(always)]
    fn in_world(&self, to_world: &DAffine3) -> (DVec3, DVec3) {
        let direction = to_world.transform_vector3(self.towards).normalize();
        (to_world.transform_point3(self.origin), direction)
    }
}

impl Camera {
    /// Generates the ray of a pixel position (continuous coordinates) and an aperture sample. `None` where the position
    /// sees nothing: its irradiance is zero.
    ///
    /// By the étendue that a lens keeps, E(x, λ) = τ(λ) ∫_A L·cosθ dA·dΩ/dA_s
    /// ([Born99](photosite_core::references#born99) §4.8), where the piece dA_s of the sensor sees the solid angle dΩ.
    /// For a rectilinear lens dΩ/dA_s = cos³θ/v², which makes E = τ ∫_A L·cos⁴θ/v² dA with θ between the axis and x →
    /// a; one uniform sample of A weighs A·cos⁴θ/v². Distortion multiplies that by the area in the ideal over that in
    /// the distorted image: a barrel is brighter at its edge. A lens that can see more than a half-space has an
    /// entrance pupil that faces each direction, so that the cosine is 1, and behind it the cone of light that it has
    /// on the axis.
    ///
    /// The only ray of a pinhole stands for all of the aperture as the axis sees it: it weighs Ω·cos⁴α at the field
    /// angle α, with the Ω of [`Self::on_axis_sr`]. Without falloff a sample of either weighs Ω everywhere, so that one
    /// f-number has one exposure on the axis.
    ///
    /// A hole of some size is a lens of no power, whose rays diverge from the sensor point. Without a lens, E = ∫ L·cosθ
    /// dΩ over all that is in front of the sensor, drawn in proportion to cosθ: each ray weighs π.
    ///
    /// Of a prescription it is the ray at 555 nm, without the point spread, and `None` also where an aperture blocks it.
    #[inline]
    pub fn generate(&self, pixel: DVec2, aperture_sample: [f32; 2]) -> Option<CameraRay> {
        if let Some(lens) = &self.prescribed {
            let sample = CameraSample { pixel, aperture: aperture_sample, time: 0.0, spread: [0.0; 2] };
            let sees_light = self.cells.sees_light(pixel);
            let start = || lens.start(self.sensor_mm(pixel), aperture_sample, REFERENCE_NM as f32);
            return self.prescribed_ray(lens, &sample, sees_light.then(start).flatten()?);
        }
        if !self.makes_image() {
            return self.bare_ray(pixel, aperture_sample, 0.0);
        }
        self.ray(pixel, self.place(pixel), aperture_sample, 0.0, self.focus_distance_m)
    }

    /// Whether a ray needs a sample of the aperture, or of the directions before a bare sensor.
    pub fn has_aperture(&self) -> bool {
        match self.kind {
            LensKind::Pinhole => false,
            LensKind::Thin | LensKind::Hole | LensKind::Bare | LensKind::Prescription => true,
        }
    }

    /// Whether each wavelength takes a way of its own through the lens, so that a path carries its hero alone.
    pub(super) fn parts_wavelengths(&self) -> bool {
        self.lateral_colour.is_some() || self.chromatic.is_some() || self.prescribed.is_some()
    }

    /// The focus distance of the hero's wavelength, m.
    #[inline]
    pub(super) fn focus_of(&self, wavelengths: &Wavelengths) -> f64 {
        match &self.chromatic {
            Some(chromatic) => chromatic.focus_distance_m(wavelengths.lambda_nm(0)),
            None => self.focus_distance_m,
        }
    }

    /// Whether a path needs a sample of the point spread.
    pub fn spreads_points(&self) -> bool {
        self.point_spread.is_some() || self.prescribed.as_ref().is_some_and(|lens| lens.spreads_waves())
    }

    /// Whether a point spreads by wavelength, so that the weights of wavelengths are right for all four together alone.
    pub fn spreads_by_wavelength(&self) -> bool {
        matches!(self.point_spread, Some(PointSpread::Airy | PointSpread::Measured(_)))
    }

    /// Generates the ray through a lens with a point spread and lateral colour, at a time within the exposure of the
    /// pixel's row, with the weight of each wavelength. Lateral colour leaves only the hero, whose direction it is.
    #[inline]
    pub fn generate_spectral(
        &self,
        sample: &CameraSample,
        wavelengths: &mut Wavelengths,
    ) -> Option<(CameraRay, SampledSpectrum)> {
        let &CameraSample { pixel, aperture, time, spread } = sample;
        if !self.makes_image() {
            return Some((self.bare_ray(pixel, aperture, time)?, SampledSpectrum::ONE));
        }
        if self.parts_wavelengths() {
            wavelengths.terminate_secondary();
        }
        if let Some(lens) = &self.prescribed {
            let start = self.prescribed_start(lens, sample, wavelengths.lambda_nm(0))?;
            return Some((self.prescribed_ray(lens, sample, start)?, SampledSpectrum::ONE));
        }
        let (place, weights) = self.spread_place(pixel, spread, wavelengths);
        Some((self.ray(pixel, place, aperture, time, self.focus_of(wavelengths))?, weights))
    }

    /// Makes the rays of several samples, see [`generate_spectral`](Self::generate_spectral), and gives `take` the
    /// index of each sample with its wavelengths and its ray.
    #[inline]
    pub fn generate_each(
        &self,
        samples: &[CameraSample],
        wavelengths: &mut [Wavelengths],
        mut take: impl FnMut(usize, &Wavelengths, Option<(CameraRay, SampledSpectrum)>),
    ) {
        if let Some(lens) = &self.prescribed {
            self.prescribed_each(lens, samples, wavelengths, take);
            return;
        }
        for (index, (sample, wavelengths)) in samples.iter().zip(wavelengths).enumerate() {
            let ray = self.generate_spectral(sample, wavelengths);
            take(index, wavelengths, ray);
        }
    }

    /// The place of a pixel position behind a lens with lateral colour and a point spread, at the hero's wavelength,
    /// and what each wavelength counts.
    #[inline]
    pub(super) fn spread_place(
        &self,
        pixel: DVec2,
        spread_sample: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> (DVec2, SampledSpectrum) {
        let mut place = self.place(pixel);
        let mut weights = SampledSpectrum::ONE;
        if let Some(lateral) = &self.lateral_colour {
            place /= lateral.magnification(f64::from(wavelengths.lambda_nm(0)));
        }
        if let Some(chromatic) = &self.chromatic {
            // Chief rays leave the elements before the main lens the steeper.
            place *= f64::from(chromatic.magnification.eval(wavelengths.lambda_nm(0)));
        }
        if let Some(spread) = &self.point_spread {
            let in_image = pixel / DVec2::from_array(self.resolution.map(f64::from)) * 2.0 - 1.0;
            let (offset, of_wavelengths) = spread.sample(spread_sample, wavelengths, self.working_f_number, in_image);
            let Intrinsics { fx, fy, .. } = self.intrinsics;
            place += offset / DVec2::new(self.pitch_m[0] * fx, self.pitch_m[1] * fy);
            weights = of_wavelengths;
        }
        (place, weights)
    }

    #[inline]
    fn ray(
        &self,
        pixel: DVec2,
        place: DVec2,
        aperture_sample: [f32; 2],
        u_time: f32,
        focus_distance_m: f64,
    ) -> Option<CameraRay> {
        if !self.cells.sees_light(pixel) {
            return None;
        }
        let (to_world, time) = self.pose(self.cells.cell_at(pixel).y, u_time);
        let opening = self.opening(aperture_sample);
        let aim = self.aim(place, opening, focus_distance_m)?;
        if !self.passes(aim.seen.chief, opening, aim.towards) {
            return None;
        }
        let (origin, direction) = aim.in_world(&to_world);
        let ray = Ray::new(origin.as_vec3(), direction.as_vec3()).at_time(time as f32);
        Some(CameraRay { ray, weight: self.weight(&aim, opening) })
    }

    /// The ray from a place of a sensor without a lens. The sensor stands as behind a lens, upside down: what is to the
    /// right of the image lies to the left.
    #[inline]
    fn bare_ray(&self, pixel: DVec2, direction_sample: [f32; 2], u_time: f32) -> Option<CameraRay> {
        if !self.cells.sees_light(pixel) {
            return None;
        }
        let (to_world, time) = self.pose(self.cells.cell_at(pixel).y, u_time);
        let origin = to_world.transform_point3(self.on_sensor_m(pixel).extend(0.0));
        let up = warp::cosine_hemisphere(direction_sample);
        let direction = DVec3::new(up.x.into(), up.y.into(), -f64::from(up.z));
        let direction = to_world.transform_vector3(direction).normalize();
        let ray = Ray::new(origin.as_vec3(), direction.as_vec3()).at_time(time as f32);
        Some(CameraRay { ray, weight: self.sample_sr as f32 })
    }

    /// A point of the aperture.
    #[inline]
    pub(super) fn opening(&self, aperture_sample: [f32; 2]) -> DVec2 {
        match self.kind {
            LensKind::Pinhole | LensKind::Bare | LensKind::Prescription => DVec2::ZERO,
            LensKind::Thin | LensKind::Hole => self.aperture.sample(aperture_sample),
        }
    }

    /// Aims the ray of a place through a point of the aperture, whatever stops are in its way.
    #[inline]
    pub(super) fn aim(&self, place: DVec2, opening: DVec2, focus_distance_m: f64) -> Option<Aim> {
        let seen = self.seen_at(place)?;
        let origin = self.in_pupil(opening, &seen);
        Some(Aim { seen, origin, towards: towards(seen.chief, origin, focus_distance_m) })
    }

    /// Weight of a ray, as [`CameraRay::weight`] has it.
    #[inline(always)]
    pub(super) fn weight(&self, aim: &Aim, opening: DVec2) -> f32 {
        (self.sample_sr * self.falloff_at(&aim.seen, opening)) as f32
    }

    /// Whether all stops let light through.
    #[inline]
    pub(super) fn passes(&self, chief: DVec3, opening: DVec2, towards: DVec3) -> bool {
        let v = self.image_distance_m;
        // The image lies upside down behind the lens.
        let sensor = DVec2::new(chief.x, chief.y) * -v;
        self.stops.iter().all(|stop| stop.passes(opening, towards, sensor, v))
    }

    /// A point of the entrance pupil in camera space: across the axis, or turned about the centre on the shortest way
    /// to face the direction seen.
    #[inline(always)]
    pub(super) fn in_pupil(&self, opening: DVec2, seen: &Seen) -> DVec3 {
        if self.projection.is_flat() {
            return (opening / self.chief_slope).extend(0.0);
        }
        DQuat::from_rotation_arc(DVec3::NEG_Z, seen.direction) * opening.extend(0.0)
    }

    /// Irradiance through a point of the opening over that through the centre on the axis.
    #[inline(always)]
    pub(super) fn falloff_at(&self, seen: &Seen, opening: DVec2) -> f64 {
        match self.falloff {
            Falloff::None => 1.0,
            Falloff::Cos4 => {
                let v = self.image_distance_m;
                let cos = -seen.direction.z;
                let (across, of_image) = if self.projection.is_flat() {
                    // The sensor point is where the undistorted chief ray, carried on behind the lens, meets z = v.
                    let sensor = seen.chief.truncate() * self.perspective_distance_m;
                    (opening + sensor, seen.solid_angle / (cos * cos * cos))
                } else {
                    (opening, seen.solid_angle)
                };
                let cos2 = v * v / (v * v + across.length_squared());
                cos2 * cos2 * of_image
            }
        }
    }
}

/// Vector from a point of the pupil to the point in focus, in units of the focus distance.
#[inline(always)]
pub(super) fn towards(chief: DVec3, origin: DVec3, focus_distance_m: f64) -> DVec3 {
    if focus_distance_m.is_finite() { chief - origin / focus_distance_m } else { chief }
}
