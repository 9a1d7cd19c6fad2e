//! Cameras with a lens from a prescription.

use std::sync::Arc;

use glam::{DAffine3, DVec2};

use super::{Camera, PixelGrid};
use crate::geometry::Ray;
use crate::optics::camera::{CameraRay, CameraSample};
use crate::optics::prescribed::PrescribedLens;
use crate::optics::{Focus, LensDescription, LensKind, Projection};
use photosite_core::Invalid;
use photosite_lens::lanes::LaneRay;

impl Camera {
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

    /// Where a pixel position is on the sensor, mm from the axis.
    #[inline]
    pub(super) fn sensor_mm(&self, pixel: DVec2) -> DVec2 {
        self.on_sensor_m(pixel) * 1e3
    }

    /// The pixel position at a place of the sensor, mm from the axis.
    pub(super) fn pixel_of(&self, sensor_mm: DVec2) -> DVec2 {
        let [width, height] = self.pitch_m.map(|pitch| pitch * 1e3);
        DVec2::new(self.intrinsics.cx - sensor_mm.x / width, self.intrinsics.cy + sensor_mm.y / height)
    }

    /// The ray of a pixel position through a prescription's glass at a wavelength in nm.
    pub(super) fn prescribed_ray(
        &self,
        lens: &PrescribedLens,
        sample: &CameraSample,
        wavelength_nm: f32,
    ) -> Option<CameraRay> {
        let (start, area) = self.prescribed_start(lens, sample, wavelength_nm)?;
        let mut rays = [start];
        lens.trace_out(&mut rays);
        self.prescribed_camera_ray(lens, sample, &rays[0], area)
    }

    /// The start of such a ray at the sensor, and the area of the region that its direction was drawn from, sr.
    #[inline]
    pub(super) fn prescribed_start(
        &self,
        lens: &PrescribedLens,
        sample: &CameraSample,
        wavelength_nm: f32,
    ) -> Option<(LaneRay, f32)> {
        let sees_light = self.cells.sees_light(sample.pixel);
        sees_light.then(|| lens.start(self.sensor_mm(sample.pixel), sample.aperture, wavelength_nm)).flatten()
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
        Some(CameraRay { ray: Ray::new(origin, direction).at_time(time), weight: area * out.passed })
    }
}
