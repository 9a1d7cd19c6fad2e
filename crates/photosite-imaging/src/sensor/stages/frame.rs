//! What every stage of one picture may know.

use crate::sensor::signal::effects::{Stage, Stages};
use crate::sensor::signal::noise_key::{NoiseKey, Streams};
use crate::sensor::{Exposure, SensorModel};

/// What every stage of one picture may know.
#[derive(Clone, Copy, Debug)]
pub(in crate::sensor) struct Frame<'a> {
    pub(in crate::sensor) sensor: &'a SensorModel,
    pub(in crate::sensor) exposure: &'a Exposure,
    pub(in crate::sensor) stages: Stages,
    pub(in crate::sensor) key: NoiseKey,
    /// Values in a row of charge, and rows.
    pub(in crate::sensor) size: [usize; 2],
    /// Whether what differs from frame to frame takes its mean, without random numbers.
    pub(in crate::sensor) is_mean: bool,
}

impl Frame<'_> {
    /// Random numbers that are new in each frame, unless the stage is switched off or takes its mean.
    pub(in crate::sensor) fn temporal(&self, stage: Stage) -> Option<Streams> {
        (self.stages.has(stage) && !self.is_mean).then(|| self.key.temporal(stage))
    }

    /// Random numbers that belong to the sensor, unless the stage is switched off.
    pub(in crate::sensor) fn fixed(&self, stage: Stage) -> Option<Streams> {
        self.stages.has(stage).then(|| self.of_pixels(Streams::fixed(self.sensor.serial, stage)))
    }

    /// Random numbers of noise that goes on in time from frame to frame.
    pub(in crate::sensor) fn in_time(&self, stage: Stage) -> Streams {
        self.of_pixels(self.key.in_time(stage))
    }

    /// All lines of a scanning sensor are seen by the same pixels.
    fn of_pixels(&self, streams: Streams) -> Streams {
        if self.sensor.shutter.scans() { streams.of_one_row() } else { streams }
    }
}
