//! Silhouettes: the pixels that would see an object without occluders.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::super::camera_files::{CalibratedCamera, opencv_pose};
use photosite_transport::geometry::Ray;
use photosite_transport::optics::Intrinsics;
use photosite_transport::scene::Scene;

/// Pixels whose centres see an object, also beyond the image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Silhouette {
    /// First column and row of the box of pixels that were tested; negative to the left of the image or above.
    pub(super) corner: [i64; 2],
    /// Columns and rows of the box.
    pub(super) size: [usize; 2],
    /// Whether each of these pixels, row by row, sees the object.
    pub(super) inside: Vec<bool>,
}

impl Silhouette {
    /// Silhouette of a whole scene through a camera without distortion, on a canvas of three times the image's width
    /// and height with the image in its middle. `corners` are points in the world that enclose the scene, m.
    pub(super) fn new(scene: &Scene, corners: &[DVec3], camera: &CalibratedCamera) -> Self {
        let [width, height] = camera.resolution.map(i64::from);
        let canvas = [-width, -height, 2 * width, 2 * height];
        let [left, top, right, bottom] = covered(corners, camera, canvas);
        let size = [right - left, bottom - top].map(|n| usize::try_from(n).unwrap_or(0));
        let pose = opencv_pose(&camera.to_world);
        let Intrinsics { fx, fy, cx, cy, skew } = camera.intrinsics;
        let row = |row: usize| {
            let y = ((top + row as i64) as f64 + 0.5 - cy) / fy;
            (0..size[0]).map(move |column| {
                let x = ((left + column as i64) as f64 + 0.5 - cx - skew * y) / fx;
                let direction = pose.matrix3 * DVec3::new(x, y, 1.0).normalize();
                let ray = Ray::new(pose.translation.as_vec3(), direction.as_vec3());
                scene.closest(&ray).is_some()
            })
        };
        let inside = (0..size[1]).into_par_iter().flat_map_iter(row).collect();
        Self { corner: [left, top], size, inside }
    }

    /// Columns and rows of the pixels inside.
    pub(super) fn pixels(&self) -> impl Iterator<Item = [i64; 2]> {
        let (width, [left, top]) = (self.size[0], self.corner);
        let place = move |i: usize| [left + (i % width) as i64, top + (i / width) as i64];
        self.inside.iter().enumerate().filter(|(_, inside)| **inside).map(move |(i, _)| place(i))
    }
}

/// Part of the canvas (left, top, right, bottom) that a body enclosed by points can cover.
fn covered(corners: &[DVec3], camera: &CalibratedCamera, canvas: [i64; 4]) -> [i64; 4] {
    let from_world = camera.from_world();
    let Intrinsics { fx, fy, cx, cy, skew } = camera.intrinsics;
    let project = |point: &DVec3| {
        let p = from_world.transform_point3(*point);
        // What reaches behind the camera may cover everything.
        (p.z > 1e-6).then(|| DVec2::new((fx * p.x + skew * p.y) / p.z + cx, fy * p.y / p.z + cy))
    };
    let Some(points) = corners.iter().map(project).collect::<Option<Vec<DVec2>>>() else { return canvas };
    let low = points.iter().copied().fold(DVec2::INFINITY, DVec2::min).floor() - 1.0;
    let high = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max).ceil() + 1.0;
    let [left, top, right, bottom] = canvas;
    let within = |x: f64, low: i64, high: i64| (x as i64).clamp(low, high);
    let [x, y] = [within(low.x, left, right), within(low.y, top, bottom)];
    [x, y, within(high.x, left, right).max(x), within(high.y, top, bottom).max(y)]
}
