//! Where a surface that one camera sees appears to another, or to the same one later.

use glam::{DAffine3, DVec2, DVec3, Vec3};

use crate::geometry::{Ray, SurfacePoint, offset_origin};
use crate::optics::Camera;
use crate::scene::Scene;

/// A camera whose rows may be exposed one after the other, or its partner, which it carries with it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// Partner → camera, in metres; the identity for the camera itself.
    pub place: DAffine3,
}

/// Where a surface point appears in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// Continuous pixel coordinates; they may lie beyond the picture.
    pub pixel: DVec2,
    /// Whether the point is within the picture, with nothing in front of it.
    pub visible: bool,
}

impl<'a> View<'a> {
    /// That of a camera itself.
    pub fn of(camera: &'a Camera) -> Self {
        Self { camera, place: DAffine3::IDENTITY }
    }

    /// Partner → world in the middle of the exposure of a row, and which part of the picture's time has gone by then.
    fn at_row(&self, row: f64) -> (DAffine3, f32) {
        let (to_world, time) = self.camera.pose_at_row(row);
        (to_world * self.place, time)
    }

    /// Continuous pixel coordinates of a world point that is seen in the middle of the exposure of its row: the y that solves
    /// y = project(p, camera at t(y)). `None` behind the camera, and where it moves too fast for there to be one.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let at_row = |row: f64| {
            let (to_world, _) = self.at_row(row);
            self.camera.project_camera(to_world.inverse().transform_point3(point))
        };
        let mut pixel = at_row(0.0)?;
        if !self.camera.moves() {
            return Some(pixel);
        }
        // Each round takes the error times (speed of the picture in rows per row time), which is far below 1 in any picture
        // that is not torn apart.
        for _ in 0..100 {
            let next = at_row(pixel.y - 0.5)?;
            let change = (next - pixel).length();
            pixel = next;
            if change < 1e-9 {
                return Some(pixel);
            }
        }
        None
    }

    /// Where a surface point appears in the picture of `size` columns and rows. `None` where it has no place in it.
    pub fn correspondence(&self, scene: &Scene, point: &SurfacePoint, size: [u32; 2]) -> Option<Correspondence> {
        self.found(point.position.as_dvec3(), size, |eye, time| is_seen(scene, point, eye, time))
    }

    /// The same of a point that is known to lie on a surface.
    pub fn landmark(&self, scene: &Scene, point: DVec3, size: [u32; 2]) -> Option<Correspondence> {
        self.found(point, size, |eye, time| {
            let mut ray = Ray::new(eye, point.as_vec3() - eye).at_time(time);
            // Up to just before the surface that it lies on.
            ray.t_max = 1.0 - 1e-4;
            !scene.occluded(&ray)
        })
    }

    /// `is_seen` is asked of the centre of the lens and of the part of the picture's time that has gone by.
    fn found(&self, point: DVec3, size: [u32; 2], is_seen: impl Fn(Vec3, f32) -> bool) -> Option<Correspondence> {
        let pixel = self.project(point)?;
        let [width, height] = size.map(f64::from);
        let within = (0.0..width).contains(&pixel.x) && (0.0..height).contains(&pixel.y);
        let (to_world, time) = self.at_row(pixel.y - 0.5);
        Some(Correspondence { pixel, visible: within && is_seen(to_world.translation.as_vec3(), time) })
    }
}

/// Whether nothing is between a surface point and the centre of a lens.
fn is_seen(scene: &Scene, point: &SurfacePoint, eye: Vec3, time: f32) -> bool {
    let origin = offset_origin(point.position, point.error, point.geometric_normal, eye - point.position);
    let mut ray = Ray::new(origin, eye - origin).at_time(time);
    ray.t_max = 1.0;
    !scene.occluded(&ray)
}
