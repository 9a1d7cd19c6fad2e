//! Camera as plain data, for devices that make its rays: a lens that is the same at all wavelengths.

use std::f64::consts::{FRAC_PI_4, PI};

use super::pose_table::{packed, poses};
use super::{Camera, LensTable};
use crate::optics::{Falloff, Intrinsics, LensKind, Projection, Recording, Stop};
use photosite_core::cells::{CellLayout, CellShape, ImageCircle};

/// Camera as plain data; see the module. Lengths are in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedCamera {
    /// Axes of the camera in the world and its origin: at equal distances of the image's time, or once where it stands
    /// still.
    pub poses: Vec<[[f32; 3]; 4]>,
    /// Camera matrix: fx, fy, cx, cy, skew, in pixels.
    pub intrinsics: [f32; 5],
    /// Table of what places see; `None` of a rectilinear lens without distortion.
    pub table: Option<LensTable>,
    /// Whether the lens is focused on a plane, with a pupil across the axis.
    pub is_flat: bool,
    /// Cosine of the largest angle from the axis that the lens sees; −2 of one that sees all round.
    pub reach_cos: f32,
    /// Sine of that angle, by which narrow ones are told; 2 beyond 45°.
    pub reach_sin: f32,
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
    /// Centre and radii of the circle whose pixels see light, px; `None` where all do.
    pub image_circle: Option<[f32; 4]>,
    /// Times of paths, as parts of the image's time; `None` where all set out at `time`.
    pub times: Option<PackedTimes>,
    /// Part of the image's time that has gone by.
    pub time: f32,
}

/// Times at which the rows of an image see light, as parts of the image's time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedTimes {
    /// Position of the rows that are exposed first; 0 for from the top on.
    pub first_row: f32,
    /// Time from the start of one row to that of the next.
    pub row_time: f32,
    /// Exposure time of a row.
    pub exposure: f32,
}

impl PackedTimes {
    fn new(recording: &Recording) -> Self {
        let part = |time_s: f64| if recording.duration_s > 0.0 { (time_s / recording.duration_s) as f32 } else { 0.0 };
        Self {
            first_row: recording.first_row as f32,
            row_time: part(recording.row_time_s),
            exposure: part(recording.exposure_s),
        }
    }
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
            time,
            scans,
            cells,
        } = self;
        let is_plain =
            prescribed.is_none() && chromatic.is_none() && point_spread.is_none() && lateral_colour.is_none() && !scans;
        let CellLayout { shape: CellShape::Rectangular, image_circle } = cells else { return None };
        let has_opening = match kind {
            LensKind::Thin | LensKind::Hole => true,
            LensKind::Pinhole => false,
            LensKind::Bare | LensKind::Prescription => return None,
        };
        if !is_plain {
            return None;
        }
        let table = match projection {
            Projection::Perspective => None,
            Projection::BrownConrady(_)
            | Projection::Polynomial { .. }
            | Projection::Division { .. }
            | Projection::KannalaBrandt { .. }
            | Projection::ClassicalFisheye(_)
            | Projection::Equirectangular
            | Projection::Omnidirectional { .. } => Some(LensTable::new(self)?),
        };
        let circle = |circle: &ImageCircle| [circle.centre_px, circle.radii_px].map(|v| v.as_vec2().to_array());
        let Intrinsics { fx, fy, cx, cy, skew } = *intrinsics;
        let poses = match recording.as_ref().filter(|recording| recording.motion.is_some()) {
            Some(recording) => poses(self, recording)?,
            None => vec![packed(to_world)],
        };
        let stop = |stop: &Stop| [stop.distance_m as f32, stop.radius_m as f32];
        Some(PackedCamera {
            poses,
            intrinsics: [fx, fy, cx, cy, skew].map(|number| number as f32),
            table,
            is_flat: projection.is_flat(),
            reach_cos: if reach.angle < PI { reach.angle.cos() as f32 } else { -2.0 },
            reach_sin: if reach.angle < FRAC_PI_4 { reach.angle.sin() as f32 } else { 2.0 },
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
            image_circle: image_circle.as_ref().map(circle).map(|[[x, y], [across, down]]| [x, y, across, down]),
            times: recording.as_ref().map(PackedTimes::new),
            time: *time,
        })
    }
}
