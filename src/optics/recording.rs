//! Where the camera is while it records: its motion, and when each row of the sensor sees light.

use glam::{DAffine3, DMat3, DVec3};

/// A motion at constant velocities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraMotion {
    /// Velocity of the centre of the lens along the world's axes, m/s.
    pub velocity_m_per_s: DVec3,
    /// Angular velocity about the camera's own axes (x right, y up, z backward), rad/s.
    pub angular_velocity_rad_per_s: DVec3,
}

impl CameraMotion {
    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        self.velocity_m_per_s == DVec3::ZERO && self.angular_velocity_rad_per_s == DVec3::ZERO
    }

    /// Camera → world at the time t, s, of a camera that is at `start` at time 0: p = p₀ + v·t, R = R₀·exp([ω]ₓ·t).
    #[inline]
    pub fn pose(&self, start: &DAffine3, time_s: f64) -> DAffine3 {
        let turn = self.angular_velocity_rad_per_s * time_s;
        let angle = turn.length();
        let rotation = if angle > 0.0 { DMat3::from_axis_angle(turn / angle, angle) } else { DMat3::IDENTITY };
        DAffine3 { matrix3: start.matrix3 * rotation, translation: start.translation + self.velocity_m_per_s * time_s }
    }
}

/// One exposure of a camera that moves: row y sees light from start + y·row time on, for the exposure time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recording {
    /// How the camera moves.
    pub motion: CameraMotion,
    /// When the exposure of the top row starts, s.
    pub start_s: f64,
    /// How long each row is exposed, s.
    pub exposure_s: f64,
    /// Time from the start of one row to that of the next, s: 0 for a global shutter.
    pub row_time_s: f64,
}

impl Recording {
    /// The time, s, of a sample u in [0, 1) of a row.
    #[inline]
    pub fn time_s(&self, row: f64, u: f32) -> f64 {
        self.start_s + row * self.row_time_s + f64::from(u) * self.exposure_s
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    #[test]
    fn poses_move_along_the_world_and_turn_about_the_camera() {
        let start = DAffine3::from_rotation_x(FRAC_PI_2);
        let motion =
            CameraMotion { velocity_m_per_s: DVec3::new(0.0, 2.0, 0.0), angular_velocity_rad_per_s: DVec3::Y * PI };
        let pose = motion.pose(&start, 0.5);
        assert!((pose.translation - DVec3::Y).length() < 1e-15);
        // A quarter turn to the left about its own y axis: it looked along +y of the world (−z of its own), and now along
        // −x, which both have in common.
        assert!((pose.matrix3 * DVec3::NEG_Z - DVec3::NEG_X).length() < 1e-15, "{}", pose.matrix3);
        assert_eq!(motion.pose(&start, 0.0), start);
        assert!(!motion.is_still() && CameraMotion::default().is_still());
    }

    #[test]
    fn rows_start_one_after_the_other() {
        let recording = Recording { motion: CameraMotion::default(), start_s: 1.0, exposure_s: 0.5, row_time_s: 0.25 };
        assert_eq!([recording.time_s(0.0, 0.0), recording.time_s(2.0, 0.5)], [1.0, 1.75]);
    }
}
