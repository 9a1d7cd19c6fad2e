//! Camera: rays from the sensor through the lens into the scene, and the weight that makes irradiance of their
//! radiance.
//!
//! Camera space is that of glTF: x right, y up, the camera looks along −z, the origin is the centre of the lens. The
//! sensor stands at z = +v, where the image lies upside down.

mod connection;
mod figures;
mod illumination;
mod landings;
mod lens_table;
mod packed;
mod pose_table;
mod prescription;
mod ray;
mod ways_in;

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3, Vec3};

use super::aperture::Aperture;
use super::focusing::{ChromaticFocus, Focusing};
use super::prescribed::PrescribedLens;
use super::{
    Falloff, Intrinsics, LateralColour, LensDescription, LensKind, PointSpread, Projection, Reach, Recording, Seen,
    Stop,
};
use crate::geometry::Ray;
use photosite_core::Invalid;
use photosite_core::cells::CellLayout;

pub use connection::Connection;
pub use figures::LensFigures;
pub use illumination::BeyondImageCircle;
pub use landings::{Landing, LandingRay, LensRays};
pub use lens_table::{LensTable, NODES_ALONG};
pub use packed::{PackedCamera, PackedTimes};
pub use prescription::PrescriptionFigures;
pub use ray::{CameraRay, CameraSample};
pub use ways_in::{Arrival, TowardsLens};

/// The grid of pixels behind the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    /// Numbers of columns and rows.
    pub resolution: [u32; 2],
    /// Width and height of a pixel, m.
    pub pitch_m: [f64; 2],
}

impl PixelGrid {
    /// Distance of its corners from its centre, m.
    fn corner_m(&self) -> f64 {
        let [width, height] = [0, 1].map(|i| f64::from(self.resolution[i]) * self.pitch_m[i]);
        width.hypot(height) / 2.0
    }
}

/// Camera: a lens in front of a pixel grid, placed in the world.
#[derive(Clone, Debug)]
pub struct Camera {
    to_world: DAffine3,
    kind: LensKind,
    /// Lens of [`LensKind::Prescription`], which decides in place of most fields below; `None` for other lenses.
    prescribed: Option<Arc<PrescribedLens>>,
    aperture: Aperture,
    /// Distance lens → plane of focus along the axis, m; infinite where focused at infinity, below 0 where what leaves
    /// the lens diverges.
    focus_distance_m: f64,
    /// Chromatic aberration; `None` for a lens that is the same at all wavelengths.
    chromatic: Option<ChromaticFocus>,
    /// Distance lens → sensor, m.
    image_distance_m: f64,
    /// Distance lens → sensor where the lens is focused at infinity, m; `None` where it cannot be.
    image_distance_at_infinity_m: Option<f64>,
    /// Distance that perspective is that of, m: of a lens without elements before it, lens → sensor.
    perspective_distance_m: f64,
    /// Size of the opening over that of the entrance pupil.
    chief_slope: f64,
    resolution: [u32; 2],
    /// Width and height of a pixel, m.
    pitch_m: [f64; 2],
    intrinsics: Intrinsics,
    projection: Projection,
    reach: Reach,
    falloff: Falloff,
    /// Irradiance on the axis over the mean radiance over the aperture, sr.
    on_axis_sr: f64,
    /// Weight of a sample of the aperture before the falloff, sr.
    sample_sr: f64,
    /// Distance lens → sensor over the diameter of the aperture.
    working_f_number: f64,
    point_spread: Option<PointSpread>,
    lateral_colour: Option<LateralColour>,
    stops: Vec<Stop>,
    /// Recording of the image; `None` where nothing moves.
    recording: Option<Recording>,
    /// Part of the image's time that has gone by, 0 to 1, where it is always the same.
    time: f32,
    /// Whether one row of pixels sees all lines of the image.
    scans: bool,
    cells: CellLayout,
}

/// Turns a direction from OpenCV's camera space to that of glTF.
#[inline(always)]
fn turned(seen: Seen) -> Seen {
    let turned = |d: DVec3| DVec3::new(d.x, -d.y, -d.z);
    Seen { direction: turned(seen.direction), chief: turned(seen.chief), ..seen }
}

impl Camera {
    /// Places a lens. `autofocus_distance_m` is what [`Focus::Autofocus`](crate::optics::Focus::Autofocus) found along the axis (infinite for nothing)
    /// and not looked at for other kinds of focus. A pinhole has no focus: whatever the lens is said to be focused on,
    /// its image lies one focal length behind it.
    pub fn new(
        lens: &LensDescription,
        grid: &PixelGrid,
        to_world: DAffine3,
        autofocus_distance_m: f64,
    ) -> Result<Self, Invalid> {
        lens.validate()?;
        if let (LensKind::Prescription, Some(prescription)) = (lens.kind, &lens.prescription) {
            let prescribed = PrescribedLens::new(prescription, lens, grid.corner_m() * 1e3, autofocus_distance_m)?;
            return Self::of_prescription(prescribed, grid, to_world);
        }
        let f = lens.focal_length_m;
        let focusing = Focusing::new(lens, autofocus_distance_m)?;
        let Focusing { image_distance_m: v, focus_distance_m, chief_slope, .. } = focusing;
        let perspective_distance_m = v / chief_slope;
        let [width, height] = grid.resolution.map(f64::from);
        let [fx, fy] = match lens.kind {
            LensKind::Pinhole | LensKind::Thin | LensKind::Hole | LensKind::Prescription => {
                grid.pitch_m.map(|pitch| perspective_distance_m / pitch)
            }
            // There is no direction that a pixel looks in.
            LensKind::Bare => [0.0; 2],
        };
        let intrinsics = lens.intrinsics.unwrap_or(Intrinsics { fx, fy, cx: width / 2.0, cy: height / 2.0, skew: 0.0 });
        let aperture = Aperture::new(f.abs() / lens.f_number / 2.0, lens.blades, lens.blade_rotation_deg);
        let reach = lens.projection.reach(lens.max_angle_rad);
        let middle = lens.projection.unproject(DVec2::ZERO, &reach).map_or(1.0, |seen| seen.solid_angle);
        Ok(Self {
            to_world,
            kind: lens.kind,
            prescribed: None,
            aperture,
            focus_distance_m,
            chromatic: focusing.chromatic,
            image_distance_m: v,
            image_distance_at_infinity_m: focusing.image_distance_at_infinity_m,
            perspective_distance_m,
            chief_slope,
            resolution: grid.resolution,
            pitch_m: grid.pitch_m,
            intrinsics,
            projection: lens.projection,
            reach,
            falloff: lens.falloff,
            on_axis_sr: match lens.kind {
                LensKind::Pinhole | LensKind::Thin | LensKind::Hole | LensKind::Prescription => {
                    aperture.projected_solid_angle(v) * middle
                }
                LensKind::Bare => std::f64::consts::PI,
            },
            sample_sr: match (lens.kind, lens.falloff) {
                (LensKind::Thin | LensKind::Hole, Falloff::Cos4) => aperture.area() / (v * v),
                // One ray stands for all of the aperture, as seen from the axis.
                (LensKind::Pinhole | LensKind::Prescription, Falloff::Cos4) => aperture.projected_solid_angle(v),
                (LensKind::Thin | LensKind::Pinhole | LensKind::Hole | LensKind::Prescription, Falloff::None) => {
                    aperture.projected_solid_angle(v) * middle
                }
                // Directions are drawn in proportion to their cosine.
                (LensKind::Bare, _) => std::f64::consts::PI,
            },
            working_f_number: v * lens.f_number / f.abs(),
            point_spread: lens.point_spread.clone(),
            lateral_colour: lens.lateral_colour.clone(),
            stops: lens.stops.clone(),
            recording: None,
            time: 0.0,
            scans: false,
            cells: CellLayout::default(),
        })
    }

    /// Returns the camera taking an image in whose time something moves.
    #[must_use]
    pub fn recording(self, recording: Recording) -> Self {
        Self { recording: Some(recording), ..self }
    }

    /// Returns the camera moving as another does.
    #[must_use]
    pub fn moving_as(self, other: &Self) -> Self {
        Self { recording: other.recording.clone(), ..self }
    }

    /// Returns the camera with a single row of pixels, which sees every line of the image. Its grid has one row.
    #[must_use]
    pub fn scanning(self) -> Self {
        Self { scans: true, ..self }
    }

    /// Returns the camera with pixels of another shape, or of which some see no light.
    #[must_use]
    pub fn with_cells(self, cells: CellLayout) -> Self {
        Self { cells, ..self }
    }

    /// Layout of the places in the image where each pixel collects light.
    pub fn cells(&self) -> &CellLayout {
        &self.cells
    }

    /// Whether paths start at times of their own.
    pub fn moves(&self) -> bool {
        self.recording.is_some()
    }

    /// Whether one row of pixels sees all lines of the image.
    pub fn scans(&self) -> bool {
        self.scans
    }

    /// Returns the camera as it stands, still, in the middle of the exposure of a row.
    pub fn at_row(&self, row: f64) -> Self {
        let (to_world, time) = self.pose(row, 0.5);
        Self { to_world, time: time as f32, recording: None, ..self.clone() }
    }

    /// Transform camera → world in the middle of the exposure of a row, and the part of the image's time that has gone
    /// by then, 0 to 1.
    pub fn pose_at_row(&self, row: f64) -> (DAffine3, f64) {
        self.pose(row, 0.5)
    }

    /// Returns the camera as it stands, still, at [`Recording::middle_s`]: the pose that stands for the whole image.
    pub fn halfway(&self) -> Self {
        let Some(recording) = &self.recording else { return self.clone() };
        let (to_world, time) = self.pose_at(recording, recording.middle_s());
        Self { to_world, time: time as f32, recording: None, ..self.clone() }
    }

    /// Pose of the camera at the sample u in [0, 1) of the exposure of a row, and the part of the image's time that has
    /// gone by.
    #[inline]
    fn pose(&self, row: f64, u: f32) -> (DAffine3, f64) {
        let Some(recording) = &self.recording else { return (self.to_world, f64::from(self.time)) };
        self.pose_at(recording, recording.time_s(row, u))
    }

    #[inline]
    fn pose_at(&self, recording: &Recording, time_s: f64) -> (DAffine3, f64) {
        let pose = recording.motion.as_ref().map_or(self.to_world, |motion| motion.pose(&self.to_world, time_s));
        (pose, recording.part(time_s))
    }

    /// Transform camera → world, of a moving camera at time 0.
    pub fn to_world(&self) -> DAffine3 {
        self.to_world
    }

    /// Pinhole matrix of the image, pixels.
    pub fn intrinsics(&self) -> Intrinsics {
        self.intrinsics
    }

    /// Projected solid angle Ω that the light on the axis fills, sr: of even radiance L its irradiance is Ω·L, τ aside.
    ///
    /// Ω = π·sin²θ' for a round aperture, tan θ' = D/2v, whatever the kind of lens; for one with blades, the same
    /// integral over the polygon. A projection that does not show the axis at the scale of v has its own dΩ/dA_s there
    /// as a factor. Of a prescription, all that passes its apertures, without the losses of its surfaces.
    pub fn on_axis_sr(&self) -> f64 {
        self.prescribed.as_ref().map_or(self.on_axis_sr, |lens| lens.illumination_sr(0.0))
    }

    /// Distance lens → plane of focus, m; infinite for a pinhole and a bare sensor, below 0 where what leaves the lens
    /// diverges, as from a hole: then nothing is in focus.
    pub fn focus_distance_m(&self) -> f64 {
        self.focus_distance_m
    }

    /// Distance lens → sensor, m; of a prescription, from its last surface.
    pub fn image_distance_m(&self) -> f64 {
        self.image_distance_m
    }

    /// Diameter of the entrance pupil (of the circle around the blades), m; `None` without a lens.
    pub fn entrance_pupil_m(&self) -> Option<f64> {
        let diameter = || 2.0 * self.aperture.radius() / self.chief_slope;
        (self.kind != LensKind::Bare).then(diameter)
    }

    /// Distance from the entrance pupil to a sensor of the same size that would have the same perspective behind a
    /// pinhole, m: that from the lens to the sensor where nothing stands before the lens.
    pub fn perspective_distance_m(&self) -> f64 {
        self.perspective_distance_m
    }

    /// Distance lens → sensor over the diameter of the opening, which diffraction goes by; `None` without a lens.
    pub fn working_f_number(&self) -> Option<f64> {
        (self.kind != LensKind::Bare).then_some(self.working_f_number)
    }

    /// Whether some distances are sharper than others.
    fn has_focus(&self) -> bool {
        match self.kind {
            LensKind::Thin | LensKind::Hole | LensKind::Prescription => true,
            LensKind::Pinhole | LensKind::Bare => false,
        }
    }

    /// Whether a lens or a hole forms an image.
    pub fn makes_image(&self) -> bool {
        self.kind != LensKind::Bare
    }

    /// Projection from directions to places in the image.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// Reach of the lens: the angle from the axis up to which it sees.
    pub fn reach(&self) -> &Reach {
        &self.reach
    }

    /// Numbers of columns and rows.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The place of a pixel position in normalised image coordinates.
    #[inline(always)]
    fn place(&self, pixel: DVec2) -> DVec2 {
        let i = &self.intrinsics;
        let row = if self.scans { pixel.y - pixel.y.floor() } else { pixel.y };
        let y = (row - i.cy) / i.fy;
        DVec2::new((pixel.x - i.cx - i.skew * y) / i.fx, y)
    }

    /// Position of a pixel position on the sensor, m from the axis, in camera space of glTF: the image lies upside
    /// down.
    #[inline]
    fn on_sensor_m(&self, pixel: DVec2) -> DVec2 {
        let row = if self.scans { pixel.y - pixel.y.floor() } else { pixel.y };
        let [width, height] = self.pitch_m;
        DVec2::new((self.intrinsics.cx - pixel.x) * width, (row - self.intrinsics.cy) * height)
    }

    /// Direction that a pixel position sees, in camera space of glTF (x right, y up, z backward); `None` out of the
    /// lens's reach and without a lens.
    #[inline]
    pub fn seen(&self, pixel: DVec2) -> Option<Seen> {
        match &self.prescribed {
            Some(lens) => lens.seen(self.sensor_mm(pixel)).map(|(_, seen)| seen),
            None if self.makes_image() => self.seen_at(self.place(pixel)),
            None => None,
        }
    }

    #[inline]
    fn seen_at(&self, place: DVec2) -> Option<Seen> {
        self.projection.unproject(place, &self.reach).map(turned)
    }

    /// Chief ray of a pixel position: the ray through the centre of the lens, or of its stop, in world space. Its
    /// parameter t is the distance in metres that focusing counts: along the axis, or along the ray where the lens can
    /// see more than a half-space. `None` of a place that sees nothing, or whose pixel sees no light.
    pub fn chief_ray(&self, pixel: DVec2) -> Option<Ray> {
        if !self.sees_light(pixel) {
            return None;
        }
        let (origin, seen) = match &self.prescribed {
            Some(lens) => lens.seen(self.sensor_mm(pixel))?,
            None => (DVec3::ZERO, self.seen(pixel)?),
        };
        let direction = self.to_world.transform_vector3(seen.chief);
        Some(Ray::new(self.to_world.transform_point3(origin).as_vec3(), direction.as_vec3()).at_time(self.time))
    }

    /// Number of pixels per solid angle in the middle of the image, px²·sr⁻¹.
    pub fn px2_per_sr(&self) -> f64 {
        self.intrinsics.fx * self.intrinsics.fy
    }

    /// Projects a world point to the continuous pixel coordinates of its sharp image through the whole lens model, on
    /// the sensor or beside it; `None` out of the lens's reach and without a lens. Of a moving camera at time 0.
    pub fn project(&self, point: Vec3) -> Option<DVec2> {
        self.project_camera(self.to_world.inverse().transform_point3(point.as_dvec3()))
    }

    /// Projects a point in camera space of glTF (x right, y up, z backward), as [`Self::project`] does one in the
    /// world.
    pub fn project_camera(&self, point: DVec3) -> Option<DVec2> {
        if let Some(lens) = &self.prescribed {
            return lens.place(point).map(|sensor_mm| self.pixel_of(sensor_mm));
        }
        if !self.makes_image() {
            return None;
        }
        let place = self.projection.project(DVec3::new(point.x, -point.y, -point.z), &self.reach)?;
        let i = &self.intrinsics;
        Some(DVec2::new(i.fx * place.x + i.skew * place.y + i.cx, i.fy * place.y + i.cy))
    }
}
