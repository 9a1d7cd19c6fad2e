//! Table of the poses of a moving camera, for devices: between two of them axes and origin are those of a straight
//! line.

use glam::DAffine3;

use super::Camera;
use super::lens_table::LARGEST_ERROR_PX;
use crate::optics::Recording;

/// Largest error of the origin, m.
const LARGEST_ERROR_M: f64 = 1e-7;

/// Numbers of steps that are tried. A motion that comes back, or is even about its middle, would look like none to fewer.
const STEPS: [u32; 3] = [64, 512, 4096];

/// Parts of a step at which poses are compared: no motion that repeats from step to step is alike at all of them.
const PARTS: [f64; 3] = [0.21, 0.5, 0.79];

/// Axes and origin of a camera in the world.
pub(super) type PackedPose = [[f32; 3]; 4];

pub(super) fn packed(pose: &DAffine3) -> PackedPose {
    let axes = pose.matrix3;
    [axes.x_axis, axes.y_axis, axes.z_axis, pose.translation].map(|axis| axis.as_vec3().to_array())
}

/// Poses of a camera at equal distances of the image's time, from its begin to its end: as few as bring each pose between
/// two of them close enough. `None` where none of these numbers does.
pub(super) fn poses(camera: &Camera, recording: &Recording) -> Option<Vec<PackedPose>> {
    let pose = |part: f64| camera.pose_at(recording, recording.start_s + part * recording.duration_s).0;
    let pixels = camera.intrinsics.fx.abs().max(camera.intrinsics.fy.abs());
    let axes = |pose: &DAffine3| [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis];
    STEPS.into_iter().find_map(|steps| {
        let at = |i: u32, part: f64| pose((f64::from(i) + part) / f64::from(steps));
        let is_close = |i: u32, part: f64| {
            let ([from, to], exact) = ([at(i, 0.0), at(i, 1.0)], at(i, part));
            let is_turned = |k: usize| axes(&from)[k].lerp(axes(&to)[k], part).distance(axes(&exact)[k]) * pixels;
            (0..3).all(|k| is_turned(k) <= LARGEST_ERROR_PX)
                && from.translation.lerp(to.translation, part).distance(exact.translation) <= LARGEST_ERROR_M
        };
        let is_exact = (0..steps).all(|i| PARTS.into_iter().all(|part| is_close(i, part)));
        is_exact.then(|| (0..=steps).map(|i| packed(&at(i, 0.0))).collect())
    })
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::geometry::{Interpolation, TimedPose, Trajectory};
    use crate::optics::{Focus, LensDescription, PixelGrid};

    /// Motions that come back, stand still for a while or are even about the middle of the image's time are those of the
    /// camera at any time.
    #[test]
    fn a_table_has_the_pose_of_every_time() {
        let at =
            |time_s: f64, x: f64| TimedPose { time_s, position_m: DVec3::new(x, 0.0, 0.0), rotation: DQuat::IDENTITY };
        let through = |poses: &[(f64, f64)], interpolation: Interpolation| {
            let poses = poses.iter().map(|&(time_s, x)| at(time_s, x)).collect();
            Trajectory::through(poses, interpolation, "").expect("poses in order")
        };
        let to_and_fro = [(0.0, 0.0), (0.2, 0.01), (0.5, 0.0), (0.7, -0.01), (1.0, 0.0)];
        let in_the_middle = [(0.0, 0.0), (0.25, 0.0), (0.75, 0.5), (1.0, 0.5)];
        let turning = |turns: f64| Trajectory::Turntable {
            centre_m: DVec3::new(0.0, 0.0, -2.0),
            axis: DVec3::Y,
            speed_rad_per_s: turns * std::f64::consts::TAU,
        };
        for (motion, has_table) in [
            (through(&to_and_fro, Interpolation::Spline), true),
            (through(&in_the_middle, Interpolation::Spline), true),
            (turning(0.01), true),
            // Its corners are at steps.
            (through(&in_the_middle, Interpolation::Linear), true),
            // Corners between steps, and turns so fast that no table has them.
            (through(&to_and_fro, Interpolation::Linear), false),
            (turning(2.0), false),
            (turning(64.0), false),
        ] {
            let lens = LensDescription::thin(0.016, 2.8, Focus::Distance(3.0));
            let grid = PixelGrid { resolution: [640, 480], pitch_m: [5e-6; 2] };
            let camera = Camera::new(&lens, &grid, DAffine3::IDENTITY, f64::NAN).expect("a lens");
            let recording = Recording {
                motion: Some(motion.clone()),
                start_s: 0.0,
                exposure_s: 1.0,
                row_time_s: 0.0,
                first_row: 0.0,
                duration_s: 1.0,
                frame_interval_s: 1.0,
            };
            let table = poses(&camera, &recording);
            assert_eq!(table.is_some(), has_table, "{motion:?}");
            let Some(table) = table else { continue };
            for part in (0..1000).map(|i| f64::from(i) / 1000.0) {
                let at = part * (table.len() - 1) as f64;
                let (step, t) = (at as usize, (at - at.floor()) as f32);
                let exact = camera.pose_at(&recording, part).0;
                let packed = packed(&exact);
                for (k, exact) in packed.into_iter().enumerate() {
                    let [from, to] = [table[step][k], table[step + 1][k]].map(glam::Vec3::from_array);
                    let error = from.lerp(to, t).distance(glam::Vec3::from_array(exact));
                    // Numbers of 32 bits of up to 2.
                    assert!(error < 4.0 * f32::EPSILON, "{motion:?} {part}: axis {k} is off by {error}");
                }
            }
        }
    }
}
