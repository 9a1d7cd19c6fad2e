//! When each row of a picture sees light, and where the camera is then.

use super::CameraMotion;

/// A picture taken by a camera that moves: row y sees light from start + n·row time on, for the exposure time, where
/// n = |y + ½ − first row| − ½ rows come before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// How the camera moves.
    pub motion: CameraMotion,
    /// When the exposure of the first rows starts, s.
    pub start_s: f64,
    /// How long each row is exposed, s.
    pub exposure_s: f64,
    /// Time from the start of one row to that of the next, s: 0 for a global shutter.
    pub row_time_s: f64,
    /// Where the first rows are exposed: 0 for from the top on, half the rows for from the middle.
    pub first_row: f64,
    /// Time from the start of one picture to that of the next, s.
    pub frame_interval_s: f64,
}

impl Recording {
    /// The same of a picture that comes so many pictures later.
    pub fn later(&self, frames: u32) -> Self {
        Self { start_s: self.start_s + f64::from(frames) * self.frame_interval_s, ..self.clone() }
    }

    /// The time, s, of a sample u in [0, 1) of a row's exposure. Rows beyond the picture go on as those at its border do.
    #[inline]
    pub fn time_s(&self, row: f64, u: f32) -> f64 {
        let below_first = row + 0.5 - self.first_row;
        let before = if self.first_row > 0.0 { below_first.abs() } else { below_first } - 0.5;
        self.start_s + before * self.row_time_s + f64::from(u) * self.exposure_s
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn rows_start_one_after_the_other() {
        let motion = CameraMotion::Steady { velocity_m_per_s: DVec3::X, angular_velocity_rad_per_s: DVec3::ZERO };
        let (exposure_s, row_time_s, frame_interval_s) = (0.5, 0.25, 2.0);
        let top = Recording { motion, start_s: 1.0, exposure_s, row_time_s, first_row: 0.0, frame_interval_s };
        assert_eq!([top.time_s(0.0, 0.0), top.time_s(2.0, 0.5)], [1.0, 1.75]);
        assert_eq!(top.later(3).time_s(2.0, 0.5), 7.75);
        let middle = Recording { first_row: 2.0, ..top };
        assert_eq!([0.0, 1.0, 2.0, 3.0].map(|row| middle.time_s(row, 0.0)), [1.25, 1.0, 1.0, 1.25]);
    }
}
