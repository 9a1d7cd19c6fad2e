//! Correspondence of images: the place at which a surface that one camera sees appears to another, or to the same one
//! later.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DAffine3, DVec2, DVec3, Vec3};

use super::row_search::{Sighting, row_that_sees};
use photosite_core::image_grid::ImageGrid;
use photosite_transport::geometry::{Hit, Ray, SurfacePoint};
use photosite_transport::optics::Camera;
use photosite_transport::scene::Scene;

/// View of an image: the scene in front of a camera whose rows may be exposed one after the other, or of a partner that
/// it carries with it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Scene in front of the camera.
    pub scene: &'a Scene,
    /// Camera of the image; of a partner, with the partner's lens.
    pub camera: &'a Camera,
    /// Partner → camera, in metres; the identity for the camera itself.
    pub place: DAffine3,
    /// Pixels of the image on those of the sensor.
    pub grid: ImageGrid,
    /// Count of the points that were asked for and not found.
    pub not_found: Option<&'a NotFound>,
}

/// Number of points that were in no row of an image at the row's own time, although the lens shows them: their places
/// in it are not known, which is not to say that they have none.
#[derive(Debug, Default)]
pub struct NotFound(AtomicU64);

impl NotFound {
    /// Number of these points.
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }

    /// Warning about points that were not found, if there are any.
    pub fn warning(&self) -> Option<String> {
        let count = self.count();
        let points = if count == 1 { "point" } else { "points" };
        (count > 0).then(|| {
            format!(
                "{count} {points} of ground truth (flow, disparity, key points, corners of boxes, points of targets) could not be \
                 found: the lens shows them, but they are in no row at the time when it is exposed, as what outruns the rolling \
                 shutter, or comes into sight while it runs; they are null, nan or not valid"
            )
        })
    }

    fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }
}

/// Place of a surface point in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// Continuous pixel coordinates; they may lie beyond the image.
    pub pixel: DVec2,
    /// Continuous pixel coordinates on the sensor.
    pub on_sensor: DVec2,
    /// Whether the point is within the part of the image that sees light, with nothing in front of it.
    pub visible: bool,
}

/// Continuous pixel coordinates on the sensor of a world point that a camera alone sees, as [`View::project`] has those
/// in an image. Those that it does not find are counted.
pub fn project(camera: &Camera, point: DVec3, not_found: &NotFound) -> Option<DVec2> {
    sighting(camera, &DAffine3::IDENTITY, |_| point).counted(Some(not_found))
}

impl Sighting {
    /// Place of the point, if there is one; a point in no row is counted.
    fn counted(self, not_found: Option<&NotFound>) -> Option<DVec2> {
        match self {
            Self::At(pixel) => Some(pixel),
            Self::Unseen => None,
            Self::InNoRow => {
                not_found.inspect(|not_found| not_found.add());
                None
            }
        }
    }
}

/// Partner → world in the middle of the exposure of a row, and the part of the image's time, 0 to 1, that has gone by
/// then.
fn at_row(camera: &Camera, place: &DAffine3, row: f64) -> (DAffine3, f64) {
    let (to_world, time) = camera.pose_at_row(row);
    (to_world * *place, time)
}

/// Sighting of a point that is at `position` at each part of the image's time: the y that solves y = project(p(t(y)),
/// camera at t(y)); of a camera that scans, y = ½ of its own line: the line at whose time the point comes there.
fn sighting(camera: &Camera, place: &DAffine3, position: impl Fn(f64) -> DVec3) -> Sighting {
    let seen_at_row = |row: f64| {
        let (to_world, time) = at_row(camera, place, row);
        camera.project_camera(to_world.inverse().transform_point3(position(time)))
    };
    if !camera.moves() {
        return seen_at_row(0.0).map_or(Sighting::Unseen, Sighting::At);
    }
    let rows = f64::from(camera.resolution()[1]);
    if camera.scans() {
        let line_above = |line: f64| seen_at_row(line).map(|seen| (seen.y - 0.5, DVec2::new(seen.x, line + 0.5)));
        return row_that_sees(rows, |line, _| line + 1.0, line_above);
    }
    row_that_sees(rows, |row, missed| row + missed, |row| seen_at_row(row).map(|seen| (seen.y - 0.5 - row, seen)))
}

impl<'a> View<'a> {
    /// View of a camera itself, rather than of a partner that it carries.
    pub fn of(scene: &'a Scene, camera: &'a Camera, grid: impl Into<ImageGrid>) -> Self {
        Self { scene, camera, place: DAffine3::IDENTITY, grid: grid.into(), not_found: None }
    }

    /// The view, counting the points that it does not find.
    #[must_use]
    pub fn counting(self, not_found: &'a NotFound) -> Self {
        Self { not_found: Some(not_found), ..self }
    }

    /// Continuous pixel coordinates of a world point that is seen in the middle of the exposure of its row. `None`
    /// where the lens does not show it, and where it is in no row at the row's own time, which is
    /// [counted](Self::counting).
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        self.project_moving(|_| point).map(|place| self.grid.in_image(place))
    }

    fn at_row(&self, row: f64) -> (DAffine3, f64) {
        at_row(self.camera, &self.place, row)
    }

    fn project_moving(&self, position: impl Fn(f64) -> DVec3) -> Option<DVec2> {
        sighting(self.camera, &self.place, position).counted(self.not_found)
    }

    /// Place of a surface point of the scene in the image. `None` where it has no place in it.
    pub fn correspondence(&self, hit: &Hit) -> Option<Correspondence> {
        let position = |time| self.scene.position(hit, time);
        self.found(position, |eye, time| is_seen(self.scene, &self.scene.point(hit, time as f32), eye))
    }

    /// Place in the image of a point that is known to lie on a surface.
    pub fn landmark(&self, point: DVec3) -> Option<Correspondence> {
        self.moving_landmark(|_| point)
    }

    /// Place in the image of a point on a surface that is at `position` when a part of the image's time, 0 to 1, has
    /// gone by.
    pub fn moving_landmark(&self, position: impl Fn(f64) -> DVec3) -> Option<Correspondence> {
        self.found(&position, |eye, time| {
            let mut ray = Ray::new(eye, position(time).as_vec3() - eye).at_time(time as f32);
            // Up to just before the surface that it lies on.
            ray.t_max = 1.0 - 1e-4;
            !self.scene.occluded(&ray)
        })
    }

    /// Finds the place of a point. `is_seen` is asked of where the line of sight leaves the lens and of the part of the
    /// image's time that has gone by.
    fn found(&self, position: impl Fn(f64) -> DVec3, is_seen: impl Fn(Vec3, f64) -> bool) -> Option<Correspondence> {
        let on_sensor = self.project_moving(position)?;
        let pixel = self.grid.in_image(on_sensor);
        let within = self.grid.contains(pixel) && self.camera.sees_light(on_sensor);
        let (to_world, time) = self.at_row(on_sensor.y - 0.5);
        // Lines of sight of a lens from a prescription do not all go through the camera's origin.
        let eye = self.camera.line_of_sight(on_sensor).map_or(DVec3::ZERO, |(origin, _)| origin);
        let visible = within && is_seen(to_world.transform_point3(eye).as_vec3(), time);
        Some(Correspondence { pixel, on_sensor, visible })
    }
}

/// Whether nothing is between a surface point and the centre of a lens.
fn is_seen(scene: &Scene, point: &SurfacePoint, eye: Vec3) -> bool {
    let ray = point.spawn_ray(eye - point.position);
    let ray = Ray { direction: eye - ray.origin, t_max: 1.0, ..ray };
    !scene.occluded(&ray)
}
