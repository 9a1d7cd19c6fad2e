//! Field of view of a camera: its reach from the axis, and whether every pixel sees something.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Camera, ReachEnd};
use photosite_core::Invalid;

/// Field of view: the part of space that the sensor sees through the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldOfView {
    /// Angles of view between the middle of the left and the right edge, and of the top and the bottom edge, rad;
    /// `None` where an edge sees nothing, and without a lens.
    pub across_rad: [Option<f64>; 2],
    /// Largest angle from the axis that the lens reaches, rad.
    pub reach_rad: f64,
    /// Smallest and largest distance from the principal point at which the reach ends, px.
    pub radius_px: [f64; 2],
    /// A position on the edge of the image that sees nothing, the farthest from the principal point; `None` where all
    /// see something.
    pub blind_px: Option<[f64; 2]>,
}

impl FieldOfView {
    fn new(camera: &Camera) -> Self {
        if !camera.makes_image() {
            let (reach_rad, radius_px) = (TAU / 4.0, [0.0; 2]);
            return Self { across_rad: [None; 2], reach_rad, radius_px, blind_px: None };
        }
        let [width, height] = camera.resolution().map(f64::from);
        let direction_of = |[x, y]: [f64; 2]| camera.seen(DVec2::new(x, y)).map(|seen| seen.direction);
        // Turned from the axis to the right, and upwards.
        let right: fn(DVec3) -> f64 = |d| d.x.atan2(-d.z);
        let up: fn(DVec3) -> f64 = |d| d.y.atan2(-d.z);
        let across = |angle: fn(DVec3) -> f64, low, high| Some(angle(direction_of(high)?) - angle(direction_of(low)?));
        let across_rad = [
            across(right, [0.0, height / 2.0], [width, height / 2.0]),
            across(up, [width / 2.0, height], [width / 2.0, 0.0]),
        ];
        let i = camera.intrinsics();
        let centre = DVec2::new(i.cx, i.cy);
        // Just within the reach, in all directions about the axis.
        let reach_rad = camera.reach().angle;
        let rim = reach_rad * (1.0 - 1e-12);
        let ends = (0..720).filter_map(|step| {
            let about = DVec2::from_angle(TAU * f64::from(step) / 720.0);
            let point = (about * rim.sin()).extend(-rim.cos());
            let end = camera.rim_of_prescription(about).or_else(|| camera.project_camera(point));
            end.map(|pixel| (pixel - centre).length())
        });
        let [low, high] = ends.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], r| [low.min(r), high.max(r)]);
        // What is seen has no holes, so that its edge tells of all of the image.
        let edge = |n: u32| (0..=n).map(f64::from);
        let [columns, rows] = camera.resolution();
        let sides = edge(columns).flat_map(|x| [[x, 0.0], [x, height]]);
        let border = sides.chain(edge(rows).flat_map(|y| [[0.0, y], [width, y]]));
        let blind = border.filter(|&pixel| direction_of(pixel).is_none());
        let distance = |[x, y]: &[f64; 2]| (DVec2::new(*x, *y) - centre).length();
        let blind_px = blind.max_by(|a, b| distance(a).total_cmp(&distance(b)));
        Self { across_rad, reach_rad, radius_px: [low, high], blind_px }
    }
}

impl Camera {
    /// Field of view of the camera, with the part of the image that is seen.
    pub fn field_of_view(&self) -> FieldOfView {
        FieldOfView::new(self)
    }

    /// Refuses a lens whose model ends within the image, because it folds back over itself or because its image is
    /// flat and 90° are not enough; not one whose image circle is smaller than the sensor. The key is that of `[lens]`.
    pub fn check_coverage(&self) -> Result<(), Invalid> {
        if !self.makes_image() {
            return Ok(());
        }
        let what = match self.reach().end {
            ReachEnd::Sees => return Ok(()),
            ReachEnd::Folds => "folds back over its own image",
            ReachEnd::Flat => "has reached 90° from the axis",
        };
        let field = self.field_of_view();
        let Some([x, y]) = field.blind_px else { return Ok(()) };
        let from_centre = DVec2::new(x - self.intrinsics().cx, y - self.intrinsics().cy).length();
        let degrees = self.reach().angle.to_degrees();
        let message = format!(
            "the model {what} {:.1} px from the principal point, {degrees:.2}° from the axis, and the sensor goes on to \
             {from_centre:.1} px at {x:.0}, {y:.0}",
            field.radius_px[0],
        );
        let angle = (degrees * 100.0).floor() / 100.0;
        Err(Invalid::new("distortion", message).help(format!(
            "take weaker coefficients, a longer focal length or fewer pixels; or write lens.max_angle_deg = {angle} to \
             leave black what lies farther out"
        )))
    }
}
