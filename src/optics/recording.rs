//! When each row of a picture sees light, and where the camera is then.

use super::CameraMotion;

/// A picture taken by a camera that moves: row y sees light from start + y·row time on, for the exposure time.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// How the camera moves.
    pub motion: CameraMotion,
    /// When the exposure of the top row starts, s.
    pub start_s: f64,
    /// How long each row is exposed, s.
    pub exposure_s: f64,
    /// Time from the start of one row to that of the next, s: 0 for a global shutter.
    pub row_time_s: f64,
    /// Time from the start of one picture to that of the next, s.
    pub frame_interval_s: f64,
}

impl Recording {
    /// The same of a picture that comes so many pictures later.
    pub fn later(&self, frames: u32) -> Self {
        Self { start_s: self.start_s + f64::from(frames) * self.frame_interval_s, ..self.clone() }
    }

    /// The time, s, of a sample u in [0, 1) of a row's exposure.
    #[inline]
    pub fn time_s(&self, row: f64, u: f32) -> f64 {
        self.start_s + row * self.row_time_s + f64::from(u) * self.exposure_s
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn rows_start_one_after_the_other() {
        let motion = CameraMotion::Steady { velocity_m_per_s: DVec3::X, angular_velocity_rad_per_s: DVec3::ZERO };
        let recording = Recording { motion, start_s: 1.0, exposure_s: 0.5, row_time_s: 0.25, frame_interval_s: 2.0 };
        assert_eq!([recording.time_s(0.0, 0.0), recording.time_s(2.0, 0.5)], [1.0, 1.75]);
        assert_eq!(recording.later(3).time_s(2.0, 0.5), 7.75);
    }
}
