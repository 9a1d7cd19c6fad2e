//! Camera as plain data, for devices that make its rays: a rectilinear lens without distortion that stands still, and
//! is the same at all wavelengths.

use super::Camera;
use crate::optics::{Falloff, Intrinsics, LensKind, Projection, Stop};
use photosite_core::cells::CellLayout;

/// Camera as plain data; see the module. Lengths are in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedCamera {
    /// Axes of the camera in the world, and its origin.
    pub to_world: [[f32; 3]; 4],
    /// Camera matrix: fx, fy, cx, cy, skew, in pixels.
    pub intrinsics: [f32; 5],
    /// Cosine of the largest angle from the axis that the lens sees.
    pub reach_cos: f32,
    /// Whether rays need samples of the opening.
    pub has_aperture: bool,
    /// Radius of the opening; 0 of a pinhole.
    pub radius: f32,
    /// Corners of the opening and the first once more; none of a round one.
    pub corners: Vec<[f32; 2]>,
    /// Size of the entrance pupil over that of the opening.
    pub pupil_scale: f32,
    /// Reciprocal of the focus distance, m⁻¹; 0 at infinity.
    pub vergence: f32,
    /// Distances before the lens and radii of stops.
    pub stops: Vec<[f32; 2]>,
    /// Distance from the lens to the sensor.
    pub image_distance: f32,
    /// Distance that perspective is that of.
    pub perspective_distance: f32,
    /// Weight of a sample before the falloff, sr.
    pub sample_sr: f32,
    /// Whether light falls off by the cosine's fourth power.
    pub falls_off: bool,
}

impl Camera {
    /// Packs the camera; `None` of a camera that is none of the module's.
    pub(crate) fn packed(&self) -> Option<PackedCamera> {
        // Whatever a camera gets beside these has to be seen here.
        let Self {
            to_world,
            kind,
            prescribed,
            aperture,
            focus_distance_m,
            chromatic,
            image_distance_m,
            image_distance_at_infinity_m: _,
            perspective_distance_m,
            chief_slope,
            resolution: _,
            pitch_m: _,
            intrinsics,
            projection,
            reach,
            falloff,
            on_axis_sr: _,
            sample_sr,
            working_f_number: _,
            point_spread,
            lateral_colour,
            stops,
            recording,
            time: _,
            scans,
            cells,
        } = self;
        let is_plain = prescribed.is_none()
            && chromatic.is_none()
            && point_spread.is_none()
            && lateral_colour.is_none()
            && recording.is_none()
            && !scans
            && *cells == CellLayout::default()
            && *projection == Projection::Perspective;
        let has_opening = match kind {
            LensKind::Thin | LensKind::Hole => true,
            LensKind::Pinhole => false,
            LensKind::Bare | LensKind::Prescription => return None,
        };
        if !is_plain {
            return None;
        }
        let Intrinsics { fx, fy, cx, cy, skew } = *intrinsics;
        let [x, y, z] = [to_world.matrix3.x_axis, to_world.matrix3.y_axis, to_world.matrix3.z_axis];
        let stop = |stop: &Stop| [stop.distance_m as f32, stop.radius_m as f32];
        Some(PackedCamera {
            to_world: [x, y, z, to_world.translation].map(|axis| axis.as_vec3().to_array()),
            intrinsics: [fx, fy, cx, cy, skew].map(|number| number as f32),
            reach_cos: reach.angle.cos() as f32,
            has_aperture: has_opening,
            radius: if has_opening { aperture.radius() as f32 } else { 0.0 },
            corners: if has_opening { aperture.corners() } else { Vec::new() },
            pupil_scale: chief_slope.recip() as f32,
            vergence: focus_distance_m.recip() as f32,
            stops: stops.iter().map(stop).collect(),
            image_distance: *image_distance_m as f32,
            perspective_distance: *perspective_distance_m as f32,
            sample_sr: *sample_sr as f32,
            falls_off: match falloff {
                Falloff::None => false,
                Falloff::Cos4 => true,
            },
        })
    }
}
