//! The dark signal and its noise over exposure time.

use photosite_core::units::Seconds;

use super::frame_stack::{Parts, StackStatistics};
use super::lines::{MeasuredLine, weighted_mean};
use super::measured::Measured;

/// Dark images of one exposure time.
#[derive(Clone, Debug)]
pub struct DarkFrames {
    /// Exposure time, where it is known.
    pub time: Option<Seconds>,
    /// Statistics of the images.
    pub statistics: StackStatistics,
}

/// Dark signal and noise of a camera at one temperature.
#[derive(Clone, Debug)]
pub struct DarkModel {
    frames: Vec<DarkFrames>,
    /// Dark signal over time, DN; `None` where fewer than two exposure times are known.
    pub mean: Option<MeasuredLine>,
    /// Variance of the pixels' temporal noise over time, DN²; `None` alike.
    pub variance: Option<MeasuredLine>,
}

/// Dark signal and noise at one exposure time.
#[derive(Clone, Copy, Debug)]
pub struct DarkAt {
    /// Mean, DN.
    pub mean: Measured,
    /// Variance of the pixels' temporal noise, DN².
    pub variance: Measured,
    /// Whether dark images of this very time were there.
    pub is_measured: bool,
}

impl DarkModel {
    /// Model of dark images, of which there must be some.
    pub fn new(frames: Vec<DarkFrames>) -> Self {
        let over_time = |value: fn(&StackStatistics) -> Measured| {
            let point = |frames: &DarkFrames| Some((frames.time?.0, value(&frames.statistics)));
            MeasuredLine::through(&frames.iter().map(point).collect::<Option<Vec<_>>>()?)
        };
        let mean = over_time(|s| s.mean);
        // Errors follow the values; so that weights do not prefer those that are too small by chance, errors are those of
        // a first line.
        let first = over_time(|s| s.temporal.pixel);
        let variance = first.and_then(|line| {
            let point = |frames: &DarkFrames| {
                let Measured { value, standard_error } = frames.statistics.temporal.pixel;
                let x = frames.time?.0;
                Some((x, Measured::new(value, standard_error / value * line.at(x).value.abs())))
            };
            MeasuredLine::through(&frames.iter().map(point).collect::<Option<Vec<_>>>()?)
        });
        Self { mean, variance, frames }
    }

    /// The images.
    pub fn frames(&self) -> &[DarkFrames] {
        &self.frames
    }

    /// Dark signal and noise at an exposure time: of images of that time where there are some, else of the lines, else
    /// of all dark images.
    pub fn at(&self, time: Option<Seconds>) -> DarkAt {
        let same: Vec<&DarkFrames> = self.frames.iter().filter(|frames| frames.time == time).collect();
        if same.is_empty()
            && let (Some(time), Some(mean), Some(variance)) = (time, self.mean, self.variance)
        {
            return DarkAt { mean: mean.at(time.0), variance: variance.at(time.0), is_measured: false };
        }
        let all: Vec<&DarkFrames> = self.frames.iter().collect();
        let of = if same.is_empty() { &all } else { &same };
        let mean = |value: fn(&StackStatistics) -> Measured| {
            weighted_mean(of.iter().map(|f| (value(&f.statistics), freedom(&f.statistics))))
        };
        DarkAt { mean: mean(|s| s.mean), variance: mean(|s| s.temporal.pixel), is_measured: !same.is_empty() }
    }

    /// Black level at no exposure time, DN, or of all dark images where their times are not known.
    pub fn black(&self) -> Measured {
        self.mean.map_or_else(|| self.at(None).mean, |line| line.offset)
    }

    /// Variance of the pixels' temporal noise at no exposure time, DN², or of the shortest.
    pub fn read_variance(&self) -> Measured {
        self.variance.map_or_else(|| self.at(self.shortest()).variance, |line| line.offset)
    }

    /// Variance of the noise that rows and columns share, DN²; that of the pixels is left at no time.
    pub fn line_variances(&self) -> Parts {
        let mean = |value: fn(&Parts) -> Measured| {
            weighted_mean(self.frames.iter().map(|f| (value(&f.statistics.temporal), freedom(&f.statistics))))
        };
        Parts { pixel: self.read_variance(), row: mean(|p| p.row), column: mean(|p| p.column) }
    }

    fn shortest(&self) -> Option<Seconds> {
        let times = self.frames.iter().filter_map(|frames| frames.time);
        times.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// Weight of a stack: its degrees of freedom.
fn freedom(statistics: &StackStatistics) -> f64 {
    (statistics.images - 1) as f64
}
