//! Read noise: what the amplifiers between pixel and converter add, referred to the charge at their input.

use rand::RngExt;
use rand_distr::StudentT;

use super::frame::Frame;
use crate::sensor::signal::charge_plane::{Row, RowStage};
use crate::sensor::signal::effects::Stage;
use crate::sensor::signal::noise_key::Streams;

/// Adds noise of a stated standard deviation: normally distributed, or heavy-tailed as of pixels whose amplifiers are
/// of very different quality, with Student's t distribution of ν degrees of freedom times σ·√((ν − 2)/ν).
#[derive(Clone, Copy, Debug)]
pub(in crate::sensor) struct ReadNoise {
    standard_deviation_e: f64,
    tails: Option<Tails>,
    streams: Streams,
}

#[derive(Clone, Copy, Debug)]
struct Tails {
    distribution: StudentT<f64>,
    /// √((ν − 2)/ν), one over the standard deviation of the distribution.
    scale: f64,
}

impl ReadNoise {
    pub(in crate::sensor) fn new(frame: &Frame<'_>) -> Option<Self> {
        let noise = &frame.sensor.noise;
        let streams = frame.temporal(Stage::ReadNoise).filter(|_| noise.read.0 > 0.0)?;
        let tails = noise.read_degrees_of_freedom.and_then(|freedom| {
            let distribution = StudentT::new(freedom).ok()?;
            Some(Tails { distribution, scale: ((freedom - 2.0) / freedom).sqrt() })
        });
        Some(Self { standard_deviation_e: noise.read.0, tails, streams })
    }
}

impl RowStage for ReadNoise {
    /// The signal with noise, e⁻; below zero it stays.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        match self.tails {
            None => {
                let standard_deviation_e = self.standard_deviation_e as f32;
                self.streams.normals(row, |_, signal, n| signal + standard_deviation_e * n);
            }
            Some(Tails { distribution, scale }) => {
                let scale = self.standard_deviation_e * scale;
                self.streams.pixels(row, |_, signal, random| signal + (scale * random.sample(distribution)) as f32);
            }
        }
    }
}
