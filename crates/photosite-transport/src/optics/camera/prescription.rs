//! Cameras with a lens from a prescription.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::{Camera, PixelGrid};
use crate::geometry::Ray;
use crate::optics::camera::{CameraRay, CameraSample};
use crate::optics::prescribed::{PrescribedLens, Start};
use crate::optics::{Focus, LensDescription, LensKind, Projection};
use photosite_core::Invalid;
use photosite_lens::lanes::LaneRay;

/// Figures of a lens from a prescription as it stands: zoomed, focused and stopped down. They are of first order at the
/// d line unless they are traced; lengths are in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrescriptionFigures {
    /// Effective focal length, m. Where groups move for the focus, it differs from that at infinity.
    pub focal_length_m: f64,
    /// Working f-number 1/(2·sin u′) of the light that comes to the middle of the image, traced at 555 nm.
    pub working_f_number: f64,
    /// Diameter of the entrance pupil, m.
    pub entrance_pupil_m: f64,
    /// Distance from the entrance pupil, the camera's origin, to the sensor, m.
    pub entrance_pupil_to_sensor_m: f64,
    /// Diameter of the exit pupil, m.
    pub exit_pupil_m: f64,
    /// Distance from the exit pupil to the sensor, m.
    pub exit_pupil_to_sensor_m: f64,
    /// Distance from the first vertex to the sensor, m.
    pub length_m: f64,
    /// Distance from the axis up to which the chief rays of the image pass every aperture; `None` where all do.
    pub clear_radius_m: Option<f64>,
    /// Whether the point spread is that of waves, and not of the rays through the glass.
    pub spreads_waves: bool,
}

impl Camera {
    /// Figures of a lens from a prescription; `None` for other lenses.
    pub fn prescription_figures(&self) -> Option<PrescriptionFigures> {
        let lens = self.prescribed.as_deref()?;
        let first_order = lens.first_order();
        let clear_m = lens.clear_height_mm() * 1e-3;
        Some(PrescriptionFigures {
            focal_length_m: first_order.efl_mm * 1e-3,
            working_f_number: lens.working_f_number(),
            entrance_pupil_m: first_order.entrance_pupil_diameter_mm * 1e-3,
            entrance_pupil_to_sensor_m: lens.length_m() - first_order.entrance_pupil_mm * 1e-3,
            exit_pupil_m: first_order.exit_pupil_diameter_mm * 1e-3,
            exit_pupil_to_sensor_m: lens.last_gap_m() - first_order.exit_pupil_mm * 1e-3,
            length_m: lens.length_m(),
            clear_radius_m: clear_m.is_finite().then_some(clear_m),
            spreads_waves: lens.spreads_waves(),
        })
    }

    /// Line of sight along which a pixel position looks, in camera space of glTF: a point of it and its direction, a
    /// unit vector. Lines of a prescription do not meet in one point: each goes through the entrance pupil of its own
    /// field. Of a lens that sees less than a half-space, the point lies in the plane of the camera's origin. `None`
    /// where the position sees nothing.
    pub fn line_of_sight(&self, pixel: DVec2) -> Option<(DVec3, DVec3)> {
        match &self.prescribed {
            Some(lens) => lens.seen(self.sensor_mm(pixel)).map(|(origin, seen)| (origin, seen.direction)),
            None => self.seen(pixel).map(|seen| (DVec3::ZERO, seen.direction)),
        }
    }

    /// Whether both cameras share their point spreads in memory.
    #[cfg(test)]
    pub(in crate::optics) fn shares_images_of_points(&self, other: &Self) -> bool {
        let lenses = self.prescribed.as_ref().zip(other.prescribed.as_ref());
        lenses.is_some_and(|(one, other)| one.shares_images_of_points(other))
    }

    /// Distance from the middle of a point's image at which its rays land, and the distance that the image reaches, m,
    /// for a lens from a prescription that spreads points as waves are, where the image does not reach as far, so that
    /// light is folded back into it. `None` for others.
    pub fn folded_blur_m(&self) -> Option<[f64; 2]> {
        self.prescribed.as_ref()?.beyond_reach_mm().map(|both| both.map(|mm| mm * 1e-3))
    }

    /// Whether an aperture of a prescription blocks the chief ray of a pixel position, so that its light goes beside the
    /// middle of the stop. Places and ground truth are those of the chief ray all the same.
    pub fn is_vignetted(&self, pixel: DVec2) -> bool {
        let is_beyond = |lens: &PrescribedLens| self.sensor_mm(pixel).length() > lens.clear_height_mm();
        self.prescribed.as_deref().is_some_and(is_beyond)
    }

    /// Rim of the reach of a prescription in a direction about the axis. Its chief rays cross the axis in different
    /// points, so that the angle of the reach alone does not lead there.
    pub(in crate::optics) fn rim_of_prescription(&self, about: DVec2) -> Option<DVec2> {
        self.prescribed.as_deref().map(|lens| self.pixel_of(about * lens.highest_mm()))
    }

    /// The camera of a lens from a prescription. What a photographer asks of it are figures of the pinhole with the same
    /// scale on the axis, and of the entrance pupil.
    pub(super) fn of_prescription(lens: PrescribedLens, grid: &PixelGrid, to_world: DAffine3) -> Result<Self, Invalid> {
        let first_order = *lens.first_order();
        let (scale_m, pupil_m) = (lens.scale_mm() * 1e-3, first_order.entrance_pupil_diameter_mm * 1e-3);
        let equivalent = LensDescription {
            kind: LensKind::Pinhole,
            projection: if lens.is_flat() {
                Projection::Perspective
            } else {
                Projection::KannalaBrandt { k: [0.0; 4] }
            },
            max_angle_rad: Some(lens.widest_rad()),
            ..LensDescription::thin(scale_m, scale_m / pupil_m, Focus::Infinity)
        };
        let exit_to_sensor_mm = lens.last_gap_m() * 1e3 - first_order.exit_pupil_mm;
        Ok(Self {
            kind: LensKind::Prescription,
            focus_distance_m: lens.focus_distance_m(),
            image_distance_m: lens.last_gap_m(),
            image_distance_at_infinity_m: Some(first_order.efl_mm * 1e-3),
            working_f_number: exit_to_sensor_mm / first_order.exit_pupil_diameter_mm,
            prescribed: Some(Arc::new(lens)),
            ..Self::new(&equivalent, grid, to_world, f64::NAN)?
        })
    }

    /// Position of a pixel position on the sensor, mm from the axis.
    #[inline]
    pub(super) fn sensor_mm(&self, pixel: DVec2) -> DVec2 {
        self.on_sensor_m(pixel) * 1e3
    }

    /// The pixel position at a place of the sensor, mm from the axis.
    pub(super) fn pixel_of(&self, sensor_mm: DVec2) -> DVec2 {
        let [width, height] = self.pitch_m.map(|pitch| pitch * 1e3);
        DVec2::new(self.intrinsics.cx - sensor_mm.x / width, self.intrinsics.cy + sensor_mm.y / height)
    }

    /// The ray of a pixel position through a prescription's glass that starts so at the sensor.
    pub(super) fn prescribed_ray(
        &self,
        lens: &PrescribedLens,
        sample: &CameraSample,
        Start { ray, area, image }: Start,
    ) -> Option<CameraRay> {
        let mut rays = [ray];
        lens.trace_out(&mut rays);
        lens.aim(&mut rays[0], image);
        self.prescribed_camera_ray(lens, sample, &rays[0], area)
    }

    /// The start of such a ray at the sensor.
    #[inline]
    pub(super) fn prescribed_start(
        &self,
        lens: &PrescribedLens,
        sample: &CameraSample,
        wavelength_nm: f32,
    ) -> Option<Start> {
        let CameraSample { pixel, aperture, spread, .. } = *sample;
        let sees_light = self.cells.sees_light(pixel);
        let image = || lens.image(self.sensor_mm(pixel), spread, wavelength_nm);
        sees_light.then(|| lens.start(image(), aperture, wavelength_nm)).flatten()
    }

    /// A ray that has come out into the scene, if it has.
    ///
    /// E(x, λ) = ∬ L dp dq over the direction cosines (p, q) at the sensor that pass all apertures
    /// ([Kolb95](photosite_core::references#kolb95)): of directions drawn evenly from a region that contains these, each
    /// weighs the area of that region times what the surfaces let through, and 0 where it is blocked.
    #[inline]
    pub(super) fn prescribed_camera_ray(
        &self,
        lens: &PrescribedLens,
        sample: &CameraSample,
        out: &LaneRay,
        area: f32,
    ) -> Option<CameraRay> {
        if out.passed <= 0.0 {
            return None;
        }
        let (to_world, time) = self.pose(self.cells.cell_at(sample.pixel).y, sample.time);
        let (origin, direction) = lens.before_lens(out);
        let origin = to_world.transform_point3(origin).as_vec3();
        let direction = to_world.transform_vector3(direction).normalize().as_vec3();
        Some(CameraRay { ray: Ray::new(origin, direction).at_time(time as f32), weight: area * out.passed })
    }
}
