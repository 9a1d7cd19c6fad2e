//! Table of the poses of a moving camera, for devices: between two of them axes and origin are those of a straight
//! line.

use glam::DAffine3;

use super::Camera;
use super::lens_table::LARGEST_ERROR_PX;
use crate::optics::Recording;

/// Largest error of the origin, m.
const LARGEST_ERROR_M: f64 = 1e-7;

/// Numbers of steps that are tried.
const STEPS: [u32; 4] = [1, 64, 512, 4096];

/// Axes and origin of a camera in the world.
pub(super) type PackedPose = [[f32; 3]; 4];

pub(super) fn packed(pose: &DAffine3) -> PackedPose {
    let axes = pose.matrix3;
    [axes.x_axis, axes.y_axis, axes.z_axis, pose.translation].map(|axis| axis.as_vec3().to_array())
}

/// Poses of a camera at equal distances of the image's time, from its begin to its end: as few as bring each pose in
/// the middle between two close enough. `None` where none of these numbers does.
pub(super) fn poses(camera: &Camera, recording: &Recording) -> Option<Vec<PackedPose>> {
    let pose = |part: f64| camera.pose_at(recording, recording.start_s + part * recording.duration_s).0;
    let pixels = camera.intrinsics.fx.abs().max(camera.intrinsics.fy.abs());
    let is_close = |[from, middle, to]: [DAffine3; 3]| {
        let error = |axis: fn(&DAffine3) -> glam::DVec3| (0.5 * (axis(&from) + axis(&to)) - axis(&middle)).length();
        [error(|p| p.matrix3.x_axis), error(|p| p.matrix3.y_axis), error(|p| p.matrix3.z_axis)]
            .iter()
            .all(|error| error * pixels <= LARGEST_ERROR_PX)
            && error(|p| p.translation) <= LARGEST_ERROR_M
    };
    STEPS.into_iter().find_map(|steps| {
        let part = |i: u32, beyond: f64| (f64::from(i) + beyond) / f64::from(steps);
        let is_exact = (0..steps).all(|i| is_close([0.0, 0.5, 1.0].map(|beyond| pose(part(i, beyond)))));
        is_exact.then(|| (0..=steps).map(|i| packed(&pose(part(i, 0.0)))).collect())
    })
}
