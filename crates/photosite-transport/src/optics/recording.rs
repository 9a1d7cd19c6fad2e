//! Exposure times of the rows of an image, and the motion of the camera.

use crate::geometry::Trajectory;

/// Recording of an image in whose time the camera or the scene moves: row y sees light from start + n·row time on, for
/// the exposure time, where n = |y + ½ − first row| − ½ rows come before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Motion of the camera; `None` if it stands still.
    pub motion: Option<Trajectory>,
    /// Time at which the exposure of the first rows starts, s.
    pub start_s: f64,
    /// Exposure time of each row, s.
    pub exposure_s: f64,
    /// Time from the start of one row to that of the next, s: 0 for a global shutter.
    pub row_time_s: f64,
    /// Position of the rows that are exposed first: 0 for from the top on, half the rows for from the middle.
    pub first_row: f64,
    /// Time from the start of the first row's exposure to the end of the last one's, s.
    pub duration_s: f64,
    /// Time from the start of one image to that of the next, s.
    pub frame_interval_s: f64,
}

impl Recording {
    /// Returns the recording of the image that comes `frames` images later.
    pub fn later(&self, frames: u32) -> Self {
        Self { start_s: self.start_s + f64::from(frames) * self.frame_interval_s, ..self.clone() }
    }

    /// Time, s, of a sample u in [0, 1) of a row's exposure. Rows beyond the image go on as those at its border do.
    #[inline]
    pub fn time_s(&self, row: f64, u: f32) -> f64 {
        let below_first = row + 0.5 - self.first_row;
        let before = if self.first_row > 0.0 { below_first.abs() } else { below_first } - 0.5;
        self.start_s + before * self.row_time_s + f64::from(u) * self.exposure_s
    }

    /// Whether a row sees light at a time, s.
    #[inline]
    pub fn is_exposed(&self, row: f64, time_s: f64) -> bool {
        let start_s = self.time_s(row, 0.0);
        (start_s..start_s + self.exposure_s).contains(&time_s)
    }

    /// Time, s, halfway between the start of the first row's exposure and the end of the last one's: the one time that
    /// stands for the image. With a global shutter it is the middle of the exposure, with rows one after the other that
    /// of the middle row.
    pub fn middle_s(&self) -> f64 {
        self.start_s + 0.5 * self.duration_s
    }

    /// Part of the image's duration that has gone by at a time, 0 to 1.
    #[inline]
    pub fn part(&self, time_s: f64) -> f64 {
        if self.duration_s > 0.0 { ((time_s - self.start_s) / self.duration_s).clamp(0.0, 1.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn rows_start_one_after_the_other() {
        let motion = Trajectory::Steady { velocity_m_per_s: DVec3::X, angular_velocity_rad_per_s: DVec3::ZERO };
        let (exposure_s, row_time_s, frame_interval_s) = (0.5, 0.25, 2.0);
        let duration_s = 1.5;
        let (start_s, first_row, motion) = (1.0, 0.0, Some(motion));
        let top = Recording { motion, start_s, exposure_s, row_time_s, first_row, duration_s, frame_interval_s };
        assert_eq!([top.time_s(0.0, 0.0), top.time_s(2.0, 0.5)], [1.0, 1.75]);
        assert_eq!(top.later(3).time_s(2.0, 0.5), 7.75);
        let at_1_6_s = [0.0, 1.0, 2.0, 3.0].map(|row| top.is_exposed(row, 1.6));
        assert_eq!(at_1_6_s, [false, true, true, false]);
        // Of five rows, that of the middle one.
        assert_eq!([top.middle_s(), top.later(3).middle_s()], [top.time_s(2.0, 0.5), 7.75]);
        assert_eq!([1.0, 1.75, 2.5, 9.0].map(|time_s| top.part(time_s)), [0.0, 0.5, 1.0, 1.0]);
        let middle = Recording { first_row: 2.0, ..top };
        assert_eq!([0.0, 1.0, 2.0, 3.0].map(|row| middle.time_s(row, 0.0)), [1.25, 1.0, 1.0, 1.25]);
    }
}
