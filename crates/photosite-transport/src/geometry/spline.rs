//! Smooth ways through poses.

use glam::{DAffine3, DQuat, DVec3};

use super::timed_pose::TimedPose;

/// A smooth way through poses at times: position and rotation have velocities that do not jump at any pose between the
/// first and the last. It stands still before the first and after the last.
///
/// The velocity at a pose is that of the parabola through it and its neighbours, which for evenly spaced times makes it
/// the spline of Catmull and Rom ([Catmull74](photosite_core::references#catmull74)); constant velocity and constant
/// acceleration are kept. Positions go on the cubic that has the positions and velocities of both ends. Rotations go on
/// the cumulative Bézier curve that has their rotations and angular velocities
/// ([Kim95](photosite_core::references#kim95), equations 16 and 18):
///
/// q(u) = q_a·exp(β₁w₁)·exp(β₂w₂)·exp(β₃w₃), where β₁ = 1 − (1 − u)³, β₂ = 3u² − 2u³, β₃ = u³, w₁ = ω_a·h/3,
/// w₃ = ω_b·h/3, and w₂ makes q(1) = q_b; h is the time between both poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    /// Knots in the order of their times; at least two.
    knots: Vec<Knot>,
}

/// A pose, and how fast it is passed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    pose: TimedPose,
    velocity_m_per_s: DVec3,
    /// Angular velocity about its own axes, rad/s.
    angular_velocity_rad_per_s: DVec3,
}

impl Spline {
    /// Leads through at least two poses in the order of their times.
    pub(super) fn new(poses: &[TimedPose]) -> Self {
        let between = |a: &TimedPose, b: &TimedPose| b.time_s - a.time_s;
        let spans: Vec<f64> = poses.windows(2).map(|pair| between(&pair[0], &pair[1])).collect();
        let mean = |rate: &dyn Fn(&TimedPose, &TimedPose) -> DVec3| -> Vec<DVec3> {
            poses.windows(2).map(|pair| rate(&pair[0], &pair[1]) / between(&pair[0], &pair[1])).collect()
        };
        let velocities = mean(&|a, b| b.position_m - a.position_m);
        let spins = mean(&|a, b| logarithm(a.rotation.inverse() * b.rotation));
        let knot = |(i, pose): (usize, &TimedPose)| Knot {
            pose: *pose,
            velocity_m_per_s: at_pose(i, &velocities, &spans),
            angular_velocity_rad_per_s: at_pose(i, &spins, &spans),
        };
        Self { knots: poses.iter().enumerate().map(knot).collect() }
    }

    /// Poses that the spline goes through.
    pub fn poses(&self) -> impl ExactSizeIterator<Item = &TimedPose> {
        self.knots.iter().map(|knot| &knot.pose)
    }

    /// Own axes → world at that time, s.
    #[inline]
    pub(super) fn pose(&self, time_s: f64) -> DAffine3 {
        let next = self.knots.partition_point(|knot| knot.pose.time_s <= time_s);
        let (Some(a), Some(b)) = (next.checked_sub(1).and_then(|i| self.knots.get(i)), self.knots.get(next)) else {
            // Before the first or after the last
            return self.knots[next.min(self.knots.len() - 1)].pose.to_world();
        };
        let span = b.pose.time_s - a.pose.time_s;
        let u = (time_s - a.pose.time_s) / span;
        let bend = u * u * (3.0 - 2.0 * u);
        let position = a.pose.position_m.lerp(b.pose.position_m, bend)
            + (a.velocity_m_per_s * (1.0 - u) - b.velocity_m_per_s * u) * (span * u * (1.0 - u));
        let [first, last] = [a, b].map(|knot| knot.angular_velocity_rad_per_s * (span / 3.0));
        let [to_second, to_third] = [a.pose.rotation * exponential(first), b.pose.rotation * exponential(-last)];
        let middle = logarithm(to_second.inverse() * to_third);
        let rotation = a.pose.rotation
            * exponential(first * (1.0 - (1.0 - u).powi(3)))
            * exponential(middle * bend)
            * exponential(last * u.powi(3));
        DAffine3::from_rotation_translation(rotation.normalize(), position)
    }
}

/// The velocity at pose number i of the parabola through it and its neighbours, or through those next to an end. `means`
/// are the mean velocities between the poses, and `spans` the times.
fn at_pose(i: usize, means: &[DVec3], spans: &[f64]) -> DVec3 {
    let last = means.len();
    // The slope of a parabola changes evenly, and halfway between two poses it is their mean.
    let slope = |before: usize, from_middle: f64| {
        let rise = (means[before + 1] - means[before]) / (0.5 * (spans[before] + spans[before + 1]));
        means[before] + rise * from_middle
    };
    match i {
        _ if last == 1 => means[0],
        0 => slope(0, -0.5 * spans[0]),
        i if i == last => slope(last - 2, 0.5 * spans[last - 2] + spans[last - 1]),
        i => slope(i - 1, 0.5 * spans[i - 1]),
    }
}

/// The rotation vector, axis times angle, of the shortest way that turns so.
fn logarithm(rotation: DQuat) -> DVec3 {
    let shortest = if rotation.w < 0.0 { -rotation } else { rotation };
    shortest.normalize().to_scaled_axis()
}

/// The turn about a rotation vector.
fn exponential(vector: DVec3) -> DQuat {
    DQuat::from_scaled_axis(vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spline(times: &[f64], pose: impl Fn(f64) -> (DVec3, DQuat)) -> Spline {
        let pose = |&time_s: &f64| {
            let (position_m, rotation) = pose(time_s);
            TimedPose { time_s, position_m, rotation }
        };
        Spline::new(&times.iter().map(pose).collect::<Vec<_>>())
    }

    #[test]
    fn constant_acceleration_and_constant_turns_are_kept() {
        let [start, velocity, acceleration] =
            [DVec3::new(1.0, 2.0, 3.0), DVec3::new(-0.4, 0.1, 2.0), DVec3::new(0.3, -0.2, 0.5)];
        let spin = DVec3::new(0.2, 0.9, -0.4);
        let first = DQuat::from_rotation_x(0.3);
        let pose = |t: f64| (start + velocity * t + acceleration * t * t, first * DQuat::from_scaled_axis(spin * t));
        let spline = spline(&[0.0, 0.7, 1.1, 2.0, 2.3], pose);
        for t in [0.0, 0.2, 0.7, 0.9, 1.5, 2.1, 2.29] {
            let (position, rotation) = pose(t);
            let found = spline.pose(t);
            assert!((found.translation - position).length() < 1e-14, "{t} s: {found}");
            assert!(DQuat::from_mat3(&found.matrix3).dot(rotation).abs() > 1.0 - 1e-14, "{t} s: {found}");
        }
        for (beyond, end) in [(-1.0, 0.0), (9.0, 2.3)] {
            assert!(spline.pose(beyond).abs_diff_eq(spline.pose(end), 1e-15), "{beyond} s");
        }
    }

    #[test]
    fn velocities_do_not_jump_at_a_pose() {
        let times = [0.0, 0.4, 1.0, 1.3, 2.0];
        let turn = |t: f64| DQuat::from_euler(glam::EulerRot::XYZ, (3.0 * t).sin(), t * t, (1.0 + t).ln());
        let spline = spline(&times, |t| (DVec3::new((5.0 * t).sin(), t.exp(), 1.0 / (1.0 + t)), turn(t)));
        const STEP: f64 = 1e-6;
        for (i, &time) in times.iter().enumerate() {
            let at = spline.pose(time);
            let knot = spline.knots[i].pose;
            assert!(at.abs_diff_eq(knot.to_world(), 1e-14), "{time} s");
            if i == 0 || i == times.len() - 1 {
                continue;
            }
            let [before, after] = [spline.pose(time - STEP), spline.pose(time + STEP)];
            let jump = (after.translation - at.translation) - (at.translation - before.translation);
            assert!(jump.length() < 1e-9, "{time} s: {jump}");
            let turned = |a: &DAffine3, b: &DAffine3| logarithm(DQuat::from_mat3(&(a.matrix3.transpose() * b.matrix3)));
            let [before, after] = [turned(&before, &at), turned(&at, &after)];
            assert!(before.length() > 1e-7 && (after - before).length() < 1e-9, "{time} s: {before} {after}");
        }
    }

    #[test]
    fn two_poses_are_joined_evenly() {
        let spline = spline(&[1.0, 3.0], |t| (DVec3::X * t, DQuat::from_rotation_y(0.5 * t)));
        let found = spline.pose(1.5);
        assert!((found.translation - DVec3::X * 1.5).length() < 1e-15);
        assert!(DQuat::from_mat3(&found.matrix3).abs_diff_eq(DQuat::from_rotation_y(0.75), 1e-14));
    }
}
