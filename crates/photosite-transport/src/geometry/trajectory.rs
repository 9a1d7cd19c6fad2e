//! Trajectories of cameras and objects.

use glam::{DAffine3, DMat3, DVec3};

use super::spline::Spline;
use super::timed_pose::TimedPose;
use photosite_core::Invalid;

/// Way of a camera or an object through the world.
#[derive(Clone, Debug, PartialEq)]
pub enum Trajectory {
    /// Motion at constant velocities from the pose at time 0.
    Steady {
        /// Velocity of its origin, of a camera the centre of the lens, along the world's axes, m/s.
        velocity_m_per_s: DVec3,
        /// Angular velocity about its own axes (of a camera x right, y up, z backward), rad/s.
        angular_velocity_rad_per_s: DVec3,
    },
    /// Turn of a turntable, about an axis of the world, from the pose at time 0.
    Turntable {
        /// A point of the axis, m.
        centre_m: DVec3,
        /// Direction of the axis, of unit length.
        axis: DVec3,
        /// Counter-clockwise seen against the axis, rad/s.
        speed_rad_per_s: f64,
    },
    /// Straight motion from pose to pose, one after the other in time, at rest before the first and after the last.
    Poses(Vec<TimedPose>),
    /// Smooth motion through poses, at rest before the first and after the last.
    Spline(Spline),
}

/// Interpolation between the poses of a trajectory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Interpolation {
    /// The position on a straight line at constant speed, the rotation on the shortest way at a constant rate
    /// ([Shoemake85](photosite_core::references#shoemake85)).
    #[default]
    Linear,
    /// Smooth motion along a [`Spline`].
    Spline,
}

impl Trajectory {
    /// Leads through at least two poses, one after the other in finite time. `still` is what the help says of what does
    /// not move. Keys of errors are within `poses`.
    pub fn through(poses: Vec<TimedPose>, interpolation: Interpolation, still: &str) -> Result<Self, Invalid> {
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
        Ok(match interpolation {
            Interpolation::Linear => Self::Poses(poses),
            Interpolation::Spline => Self::Spline(Spline::new(&poses)),
        })
    }

    /// Own axes → world at the time t, s, of an object that stands at `start` at time 0:
    ///
    /// - steady: p = p₀ + v·t, R = R₀·exp(\[ω\]ₓ·t);
    /// - turntable: p = c + exp(\[ω·a\]ₓ·t)·(p₀ − c), R = exp(\[ω·a\]ₓ·t)·R₀ about the axis a through c;
    /// - poses and spline: as [`Interpolation`] and [`Spline`] have it. The poses are those of the world, and `start` is
    ///   not looked at.
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
            Self::Turntable { centre_m, axis, speed_rad_per_s } => {
                let turn = DMat3::from_axis_angle(*axis, speed_rad_per_s * time_s);
                let translation = *centre_m + turn * (start.translation - *centre_m);
                DAffine3 { matrix3: turn * start.matrix3, translation }
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
            Self::Spline(spline) => spline.pose(time_s),
        }
    }

    /// Own axes → world at the time `time_s` of an object that stands at `known` at the time `known_s`.
    pub fn pose_from(&self, known: &DAffine3, known_s: f64, time_s: f64) -> DAffine3 {
        match self {
            // The velocities stay, so that any time may be the start.
            Self::Steady { .. } | Self::Turntable { .. } => self.pose(known, time_s - known_s),
            Self::Poses(_) | Self::Spline(_) => self.pose(known, time_s),
        }
    }

    /// Whether the trajectory gives poses in the world, and not relative to a start.
    pub fn is_absolute(&self) -> bool {
        match self {
            Self::Steady { .. } | Self::Turntable { .. } => false,
            Self::Poses(_) | Self::Spline(_) => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    use glam::DQuat;

    use super::*;

    #[test]
    fn steady_motion_goes_along_the_world_and_turns_about_the_camera() {
        let start = DAffine3::from_rotation_x(FRAC_PI_2);
        let motion = Trajectory::Steady {
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
        let motion = Trajectory::Poses(vec![pose(1.0, 2.0, 0.0), pose(3.0, 6.0, FRAC_PI_2), pose(4.0, 0.0, 0.0)]);
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

    #[test]
    fn a_turntable_turns_about_its_axis() {
        let start = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.3), DVec3::new(3.0, 5.0, 1.0));
        let centre_m = DVec3::new(1.0, 7.0, 1.0);
        let motion = Trajectory::Turntable { centre_m, axis: DVec3::Y, speed_rad_per_s: PI };
        // A quarter turn takes +x to −z.
        let quarter = motion.pose(&start, 0.5);
        assert!((quarter.translation - DVec3::new(1.0, 5.0, -1.0)).length() < 1e-14, "{quarter}");
        let turned = DMat3::from_rotation_y(FRAC_PI_2) * start.matrix3;
        assert!(quarter.matrix3.abs_diff_eq(turned, 1e-14), "{quarter}");
        assert!(motion.pose(&start, 2.0).abs_diff_eq(start, 1e-13));
    }

    #[test]
    fn any_time_may_be_the_start_of_constant_velocities() {
        let start = DAffine3::from_rotation_translation(DQuat::from_rotation_z(0.4), DVec3::new(1.0, 2.0, 3.0));
        let steady = Trajectory::Steady {
            velocity_m_per_s: DVec3::new(0.5, -1.0, 2.0),
            angular_velocity_rad_per_s: DVec3::new(1.0, 2.0, -0.5),
        };
        let turntable = Trajectory::Turntable { centre_m: DVec3::ONE, axis: DVec3::Z, speed_rad_per_s: -3.0 };
        for motion in [steady, turntable] {
            let known = motion.pose(&start, 0.7);
            let found = motion.pose_from(&known, 0.7, 1.9);
            assert!(found.abs_diff_eq(motion.pose(&start, 1.9), 1e-13), "{motion:?}: {found}");
        }
    }
}
