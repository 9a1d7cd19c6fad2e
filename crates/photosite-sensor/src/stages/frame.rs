//! Frame: the facts about one image that every stage may know.

use crate::signal::effects::{Stage, Stages};
use crate::signal::noise_key::{NoiseKey, Streams};
use crate::{Exposure, ReadOutNoise, SensorModel};

/// Facts about one image that every stage may know.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<'a> {
    pub(crate) sensor: &'a SensorModel,
    pub(crate) exposure: &'a Exposure,
    pub(crate) stages: Stages,
    pub(crate) key: NoiseKey,
    /// Values in a row of charge, and rows.
    pub(crate) size: [usize; 2],
    /// Whether effects that differ from frame to frame take their mean, without random numbers.
    pub(crate) is_mean: bool,
}

impl Frame<'_> {
    /// Noise of the read-out at the gain of the image.
    pub(crate) fn read_out_noise(&self) -> ReadOutNoise {
        self.sensor.noise.read_out.at(self.exposure.gain)
    }

    /// Digital number of no charge at the gain of the image.
    pub(crate) fn black_level_dn(&self) -> u16 {
        self.sensor.converter.black_level_dn(self.exposure.gain)
    }

    /// Random numbers that are new in each frame, unless the stage is switched off or takes its mean.
    pub(crate) fn temporal(&self, stage: Stage) -> Option<Streams> {
        (self.stages.has(stage) && !self.is_mean).then(|| self.key.temporal(stage))
    }

    /// Random numbers that belong to the sensor, unless the stage is switched off.
    pub(crate) fn fixed(&self, stage: Stage) -> Option<Streams> {
        self.stages.has(stage).then(|| self.of_pixels(Streams::fixed(self.sensor.serial, stage)))
    }

    /// Random numbers of noise that goes on in time from frame to frame.
    pub(crate) fn in_time(&self, stage: Stage) -> Streams {
        self.of_pixels(self.key.in_time(stage))
    }

    /// Streams of the pixels: all lines of a scanning sensor are seen by the same row of them.
    fn of_pixels(&self, streams: Streams) -> Streams {
        if self.sensor.shutter.scans() { streams.of_one_row() } else { streams }
    }
}
