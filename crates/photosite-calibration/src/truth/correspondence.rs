//! Where a surface that one camera sees appears to another, or to the same one later.

use glam::{DAffine3, DVec2, DVec3, Vec3};

use photosite_core::image_grid::ImageGrid;
use photosite_transport::geometry::{Hit, Ray, SurfacePoint, offset_origin};
use photosite_transport::optics::Camera;
use photosite_transport::scene::Scene;

/// A picture: what is in front of a camera whose rows may be exposed one after the other, or of a partner that it
/// carries with it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// What is seen.
    pub scene: &'a Scene,
    /// The camera; of a partner, with the partner's lens.
    pub camera: &'a Camera,
    /// Partner → camera, in metres; the identity for the camera itself.
    pub place: DAffine3,
    /// Its pixels on those of the sensor.
    pub grid: ImageGrid,
}

/// Where a surface point appears in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// Continuous pixel coordinates; they may lie beyond the picture.
    pub pixel: DVec2,
    /// The same on the sensor.
    pub on_sensor: DVec2,
    /// Whether the point is within the part of the picture that sees light, with nothing in front of it.
    pub visible: bool,
}

/// Continuous pixel coordinates on the sensor of a world point that a camera alone sees, as [`View::project`] has those
/// in an image.
pub fn project(camera: &Camera, point: DVec3) -> Option<DVec2> {
    project_moving(camera, &DAffine3::IDENTITY, |_| point)
}

/// Partner → world in the middle of the exposure of a row, and which part of the picture's time has gone by then.
fn at_row(camera: &Camera, place: &DAffine3, row: f64) -> (DAffine3, f32) {
    let (to_world, time) = camera.pose_at_row(row);
    (to_world * *place, time)
}

/// Where a point appears that is at `position` at each part of the picture's time: the y that solves
/// y = project(p(t(y)), camera at t(y)); of a camera that scans, the line whose own row it comes to.
fn project_moving(camera: &Camera, place: &DAffine3, position: impl Fn(f32) -> DVec3) -> Option<DVec2> {
    let seen_at_row = |row: f64| {
        let (to_world, time) = at_row(camera, place, row);
        camera.project_camera(to_world.inverse().transform_point3(position(time)))
    };
    let mut pixel = seen_at_row(0.0)?;
    if !camera.moves() {
        return Some(pixel);
    }
    if camera.scans() {
        return line_that_sees(seen_at_row);
    }
    // Each round takes the error times (speed of the picture in rows per row time), which is far below 1 in any picture
    // that is not torn apart.
    for _ in 0..100 {
        let next = seen_at_row(pixel.y - 0.5)?;
        let change = (next - pixel).length();
        pixel = next;
        if change < 1e-9 {
            return Some(pixel);
        }
    }
    None
}

/// Where a point appears in a picture whose lines are seen by one row of pixels, at y = ½ of its own line: the line at
/// whose time the point comes there, found by secants.
fn line_that_sees(seen_at_row: impl Fn(f64) -> Option<DVec2>) -> Option<DVec2> {
    const NEAR: f64 = 1e-9;
    let (mut before, mut line) = (0.0, 1.0);
    let mut missed_before = seen_at_row(before)?.y - 0.5;
    for _ in 0..100 {
        let seen = seen_at_row(line)?;
        let missed = seen.y - 0.5;
        if missed.abs() < NEAR {
            return Some(DVec2::new(seen.x, line + 0.5));
        }
        let next = line - missed * (line - before) / (missed - missed_before);
        if !next.is_finite() {
            return None;
        }
        (before, missed_before, line) = (line, missed, next);
    }
    None
}

impl<'a> View<'a> {
    /// Motion of a camera itself.
    pub fn of(scene: &'a Scene, camera: &'a Camera, grid: impl Into<ImageGrid>) -> Self {
        Self { scene, camera, place: DAffine3::IDENTITY, grid: grid.into() }
    }

    /// Continuous pixel coordinates of a world point that is seen in the middle of the exposure of its row. `None`
    /// behind the camera, and where it moves too fast for there to be one.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        self.project_moving(|_| point).map(|place| self.grid.in_image(place))
    }

    fn at_row(&self, row: f64) -> (DAffine3, f32) {
        at_row(self.camera, &self.place, row)
    }

    fn project_moving(&self, position: impl Fn(f32) -> DVec3) -> Option<DVec2> {
        project_moving(self.camera, &self.place, position)
    }

    /// Where a surface point of the scene appears in the picture. `None` where it has no place in it.
    pub fn correspondence(&self, hit: &Hit) -> Option<Correspondence> {
        let point = |time| self.scene.point(hit, time);
        let position = |time| point(time).position.as_dvec3();
        self.found(position, |eye, time| is_seen(self.scene, &point(time), eye))
    }

    /// The same of a point that is known to lie on a surface.
    pub fn landmark(&self, point: DVec3) -> Option<Correspondence> {
        self.moving_landmark(|_| point)
    }

    /// The same of one that is at `position` when a part of the picture's time, 0 to 1, has gone by.
    pub fn moving_landmark(&self, position: impl Fn(f32) -> DVec3) -> Option<Correspondence> {
        self.found(&position, |eye, time| {
            let mut ray = Ray::new(eye, position(time).as_vec3() - eye).at_time(time);
            // Up to just before the surface that it lies on.
            ray.t_max = 1.0 - 1e-4;
            !self.scene.occluded(&ray)
        })
    }

    /// `is_seen` is asked of where the line of sight leaves the lens and of the part of the picture's time that has gone by.
    fn found(&self, position: impl Fn(f32) -> DVec3, is_seen: impl Fn(Vec3, f32) -> bool) -> Option<Correspondence> {
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
    let origin = offset_origin(point.position, point.error, point.geometric_normal, eye - point.position);
    let mut ray = Ray::new(origin, eye - origin).at_time(point.time);
    ray.t_max = 1.0;
    !scene.occluded(&ray)
}
