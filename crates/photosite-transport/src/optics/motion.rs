//! How a camera moves.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use photosite_core::Invalid;

/// The way of a camera.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraMotion {
    /// At constant velocities from where it stands at time 0.
    Steady {
        /// Velocity of the centre of the lens along the world's axes, m/s.
        velocity_m_per_s: DVec3,
        /// Angular velocity about the camera's own axes (x right, y up, z backward), rad/s.
        angular_velocity_rad_per_s: DVec3,
    },
    /// From pose to pose, one after the other in time; it stands still before the first and after the last.
    Poses(Vec<TimedPose>),
}

/// Where a camera is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedPose {
    /// s, from the start of the first picture.
    pub time_s: f64,
    /// Centre of the lens in the world, m.
    pub position_m: DVec3,
    /// Camera → world.
    pub rotation: DQuat,
}

impl TimedPose {
    /// Where a camera of that pose, camera → world, is at that time, s.
    pub fn new(time_s: f64, to_world: &DAffine3) -> Self {
        Self { time_s, position_m: to_world.translation, rotation: DQuat::from_mat3(&to_world.matrix3) }
    }
}

impl CameraMotion {
    /// Through poses, of which there must be two at least, one after the other in finite time. `still` is what the help
    /// says of what does not move. Keys of errors are within `poses`.
    pub fn through(poses: Vec<TimedPose>, still: &str) -> Result<Self, Invalid> {
        let at = |i: usize, message: String| Invalid::new(format!("poses[{i}].time_s"), message);
        if poses.len() < 2 {
            return Err(Invalid::new("poses", "a motion needs at least two").help(still));
        }
        if let Some(i) = poses.iter().position(|pose| !pose.time_s.is_finite()) {
            return Err(at(i, format!("must be finite, got {}", poses[i].time_s)));
        }
        if let Some(i) = (1..poses.len()).find(|&i| poses[i].time_s <= poses[i - 1].time_s) {
            let message = format!("{} s is not after {} s", poses[i].time_s, poses[i - 1].time_s);
            return Err(at(i, message).help("write the poses in the order of their times"));
        }
        Ok(Self::Poses(poses))
    }

    /// Camera → world at the time t, s, of a camera that stands at `start` at time 0:
    ///
    /// - steady: p = p₀ + v·t, R = R₀·exp(\[ω\]ₓ·t);
    /// - poses: p linearly from one to the next, R on the shortest way at a constant rate
    ///   ([Shoemake85](photosite_core::references#shoemake85)). They are those of the world, and `start` is not looked
    ///   at.
    #[inline]
    pub fn pose(&self, start: &DAffine3, time_s: f64) -> DAffine3 {
        match self {
            Self::Steady { velocity_m_per_s, angular_velocity_rad_per_s } => {
                let turn = *angular_velocity_rad_per_s * time_s;
                let angle = turn.length();
                let rotation = if angle > 0.0 { DMat3::from_axis_angle(turn / angle, angle) } else { DMat3::IDENTITY };
                let translation = start.translation + *velocity_m_per_s * time_s;
                DAffine3 { matrix3: start.matrix3 * rotation, translation }
            }
            Self::Poses(poses) => {
                let next = poses.partition_point(|pose| pose.time_s <= time_s);
                let (Some(a), Some(b)) = (poses.get(next.saturating_sub(1)), poses.get(next).or(poses.last())) else {
                    return *start;
                };
                let span = b.time_s - a.time_s;
                let part = if span > 0.0 { ((time_s - a.time_s) / span).max(0.0) } else { 0.0 };
                let rotation = a.rotation.slerp(b.rotation, part);
                DAffine3::from_rotation_translation(rotation, a.position_m.lerp(b.position_m, part))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use super::*;

    #[test]
    fn steady_motion_goes_along_the_world_and_turns_about_the_camera() {
        let start = DAffine3::from_rotation_x(FRAC_PI_2);
        let motion = CameraMotion::Steady {
            velocity_m_per_s: DVec3::new(0.0, 2.0, 0.0),
            angular_velocity_rad_per_s: DVec3::Y * PI,
        };
        let pose = motion.pose(&start, 0.5);
        assert!((pose.translation - DVec3::Y).length() < 1e-15);
        // A quarter turn to the left about its own y axis: it looked along +y of the world (−z of its own), and now
        // along −x, which both have in common.
        assert!((pose.matrix3 * DVec3::NEG_Z - DVec3::NEG_X).length() < 1e-15, "{}", pose.matrix3);
        assert_eq!(motion.pose(&start, 0.0), start);
    }

    #[test]
    fn poses_are_passed_at_their_times() {
        let pose =
            |time_s, x, angle| TimedPose { time_s, position_m: DVec3::X * x, rotation: DQuat::from_rotation_y(angle) };
        let motion = CameraMotion::Poses(vec![pose(1.0, 2.0, 0.0), pose(3.0, 6.0, FRAC_PI_2), pose(4.0, 0.0, 0.0)]);
        for (time_s, x, angle) in [
            (0.0, 2.0, 0.0),
            (1.0, 2.0, 0.0),
            (2.0, 4.0, FRAC_PI_4),
            (3.0, 6.0, FRAC_PI_2),
            (3.5, 3.0, FRAC_PI_4),
            (4.0, 0.0, 0.0),
            (9.0, 0.0, 0.0),
        ] {
            let found = motion.pose(&DAffine3::IDENTITY, time_s);
            assert!((found.translation - DVec3::X * x).length() < 1e-12, "{time_s} s: {found}");
            let wanted = DMat3::from_rotation_y(angle);
            assert!(found.matrix3.abs_diff_eq(wanted, 1e-12), "{time_s} s: {found}");
        }
    }
}
