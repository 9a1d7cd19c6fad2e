//! Where a surface that one camera sees appears to another, or to the same one later.

use glam::{DVec2, Vec3};

use crate::geometry::{Ray, SurfacePoint, offset_origin};
use crate::optics::Camera;
use crate::scene::Scene;

/// Where a surface point appears in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// Continuous pixel coordinates; they may lie beyond the picture.
    pub pixel: DVec2,
    /// Whether the point is within the picture, with nothing in front of it.
    pub visible: bool,
}

/// Continuous pixel coordinates of a world point in a picture whose rows may be exposed one after the other, each in the
/// middle of its exposure: the y that solves y = project(p, camera at t(y)). `None` behind the camera, and where a camera
/// moves too fast for there to be one.
pub fn project(camera: &Camera, point: Vec3) -> Option<DVec2> {
    if !camera.moves() {
        return camera.project(point);
    }
    let mut pixel = camera.at_row(0.0).project(point)?;
    // Each round takes the error times (speed of the picture in rows per row time), which is far below 1 in any picture
    // that is not torn apart.
    for _ in 0..100 {
        let next = camera.at_row(pixel.y - 0.5).project(point)?;
        let change = (next - pixel).length();
        pixel = next;
        if change < 1e-9 {
            return Some(pixel);
        }
    }
    None
}

/// Where a surface point appears in another picture of `size` columns and rows. `None` where it has no place in it.
pub fn correspondence(scene: &Scene, point: &SurfacePoint, camera: &Camera, size: [u32; 2]) -> Option<Correspondence> {
    let pixel = project(camera, point.position)?;
    let [width, height] = size.map(f64::from);
    let within = (0.0..width).contains(&pixel.x) && (0.0..height).contains(&pixel.y);
    Some(Correspondence { pixel, visible: within && is_seen(scene, point, &camera.at_row(pixel.y - 0.5)) })
}

/// Whether nothing is between a surface point and the centre of a lens.
fn is_seen(scene: &Scene, point: &SurfacePoint, camera: &Camera) -> bool {
    let eye = camera.to_world().translation.as_vec3();
    let origin = offset_origin(point.position, point.error, point.geometric_normal, eye - point.position);
    let mut ray = Ray::new(origin, eye - origin);
    ray.t_max = 1.0;
    !scene.occluded(&ray)
}
