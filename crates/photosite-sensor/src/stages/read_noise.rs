//! Read noise: what the amplifiers between pixel and converter add, referred to the charge at their input.

use rand::RngExt;
use rand_distr::{StandardNormal, StudentT};

use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::{LogNormalWords, StreamWords, Wide, words};

/// Adds noise of a stated standard deviation: normally distributed, or heavy-tailed as of pixels whose amplifiers are
/// of very different quality, with Student's t distribution of ν degrees of freedom times σ·√((ν − 2)/ν). Pixels may
/// have standard deviations of their own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadNoise {
    standard_deviation_e: f64,
    tails: Option<Tails>,
    spread: Option<ReadNoiseSpread>,
    streams: Streams,
}

words! {
    /// Normal read noise, the same in all pixels but for a factor of each.
    ReadNoiseWords {
        streams: StreamWords,
        standard_deviation_e: f32,
        standard_deviation: Wide,
        factors: LogNormalWords,
    }
}

/// Read noise of each pixel over the root mean square of all, always the same: exp(t·n − t²), n standard normal, with
/// t² = ln(1 + s²). The mean square of the factor is 1, its standard deviation s times its mean.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ReadNoiseSpread {
    t: f64,
    streams: Streams,
}

impl ReadNoiseSpread {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let spread = frame.sensor.noise.read_spread;
        let streams = frame.fixed(Stage::ReadNoise).filter(|_| spread > 0.0)?;
        Some(Self { t: (spread * spread).ln_1p().sqrt(), streams })
    }

    /// Words of the factors.
    pub(crate) fn words(&self) -> LogNormalWords {
        let shift = self.t * self.t;
        LogNormalWords { streams: self.streams.words(), scale: Wide::new(self.t), shift: Wide::new(shift) }
    }

    #[inline]
    pub(crate) fn factor(&self, x: usize, y: usize) -> f64 {
        let normal: f64 = self.streams.pixel(x, y).sample(StandardNormal);
        (self.t * normal - self.t * self.t).exp()
    }
}

#[derive(Clone, Copy, Debug)]
struct Tails {
    distribution: StudentT<f64>,
    /// √((ν − 2)/ν), one over the standard deviation of the distribution.
    scale: f64,
}

impl ReadNoise {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let noise = &frame.sensor.noise;
        let standard_deviation_e = frame.read_out_noise().read.0;
        let streams = frame.temporal(Stage::ReadNoise).filter(|_| standard_deviation_e > 0.0)?;
        let tails = noise.read_degrees_of_freedom.and_then(|freedom| {
            let distribution = StudentT::new(freedom).ok()?;
            Some(Tails { distribution, scale: ((freedom - 2.0) / freedom).sqrt() })
        });
        Some(Self { standard_deviation_e, tails, spread: ReadNoiseSpread::new(frame), streams })
    }

    /// Words of noise that is normally distributed.
    pub(crate) fn words(&self) -> ReadNoiseWords {
        ReadNoiseWords {
            streams: self.streams.words(),
            standard_deviation_e: self.standard_deviation_e as f32,
            standard_deviation: Wide::new(self.standard_deviation_e),
            factors: self.spread.map(|spread| spread.words()).unwrap_or_default(),
        }
    }
}

impl RowStage for ReadNoise {
    const MAP: NoiseMap = Stage::ReadNoise.map();

    /// The signal with noise, e⁻; below zero it stays.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        let y = row.y;
        match (self.tails, self.spread) {
            (None, None) => {
                let standard_deviation_e = self.standard_deviation_e as f32;
                self.streams.normals(row, |_, signal, n| signal + standard_deviation_e * n);
            }
            (None, Some(spread)) => {
                let own = |x| (self.standard_deviation_e * spread.factor(x, y)) as f32;
                self.streams.normals(row, |x, signal, n| signal + own(x) * n);
            }
            (Some(Tails { distribution, scale }), spread) => {
                let scale = self.standard_deviation_e * scale;
                let own = |x| scale * spread.map_or(1.0, |spread| spread.factor(x, y));
                self.streams.pixels(row, |x, signal, random| signal + (own(x) * random.sample(distribution)) as f32);
            }
        }
    }
}
