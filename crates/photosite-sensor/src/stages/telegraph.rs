//! Random telegraph signals: a single trap in a pixel's amplifier fills and empties, and the pixel's signal jumps
//! between two levels as it does.
//!
//! Each level lasts for a time that follows an exponential distribution. Such a signal is the same as one that is drawn
//! anew, high with the probability of its duty, at the moments of a Poisson process of rate 1/τ_high + 1/τ_low: the
//! rate of leaving the high level is then that rate times the probability of the low one, 1/τ_high, as it should be.
//! The state at any time is what was drawn last, and can be found for any frame without those before.

use rand::RngExt;
use rand_distr::{Exp1, Poisson};

use photosite_core::units::Seconds;

use super::frame::Frame;
use crate::Shutter;
use crate::model::TelegraphSignal;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;

/// Adds the signals of the pixels that have one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Telegraph {
    signal: TelegraphSignal,
    /// Time at which the first row is read out.
    time: Seconds,
    shutter: Shutter,
    rows: usize,
    /// Streams of the traps, by pixel: whether it has one, and how large its signal is. They belong to the sensor.
    traps: Streams,
    /// Streams of the times at which traps fill and empty.
    events: Streams,
}

/// Parts of the streams.
const AMPLITUDES: u64 = 0;
const EVENTS: u64 = 1;

impl Telegraph {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let signal = frame.sensor.noise.telegraph;
        // Its mean is nothing.
        let is_there = !frame.is_mean && signal.pixels > 0.0 && signal.amplitude.0 > 0.0;
        let traps = frame.fixed(Stage::Telegraph).filter(|_| is_there)?;
        let events = frame.in_time(Stage::Telegraph).part(EVENTS);
        let time = frame.exposure.read_out_time(frame.sensor, frame.key.frame);
        Some(Self { signal, time, shutter: frame.sensor.shutter, rows: frame.size[1], traps, events })
    }

    /// Whether a pixel is on its high level.
    fn is_high(&self, x: usize, y: usize) -> bool {
        let TelegraphSignal { high, low, .. } = self.signal;
        // Time in units of the mean distance of two draws, cut into pieces of one unit.
        let now = (self.time.0 + self.shutter.delay(y, self.rows).0) * (1.0 / high.0 + 1.0 / low.0);
        let events = self.events.part_of_pixel(x, y);
        let mut piece = now.floor();
        let mut until = now - piece;
        loop {
            // The draws in this piece: their number, then the place and outcome of each.
            let mut random = events.stream(piece as i64 as usize);
            let count: f64 = random.sample(Poisson::new(1.0).expect("a mean above 0"));
            let last = (0..count as u32)
                .map(|_| (random.random::<f64>(), random.random::<f64>()))
                .filter(|(place, _)| *place <= until)
                .max_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((_, outcome)) = last {
                return outcome < self.signal.duty();
            }
            piece -= 1.0;
            until = 1.0;
        }
    }
}

impl RowStage for Telegraph {
    const MAP: NoiseMap = Stage::Telegraph.map();

    /// Mean-free: a pixel of amplitude A is A·(1 − duty) above its mean on the high level, A·duty below it on the low
    /// one.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        for x in self.traps.chosen(self.signal.pixels, row.y, row.values.len()) {
            let relative: f64 = self.traps.part(AMPLITUDES).pixel(x, row.y).sample(Exp1);
            let state = if self.is_high(x, row.y) { 1.0 } else { 0.0 };
            row.values[x] += (self.signal.amplitude.0 * relative * (state - self.signal.duty())) as f32;
        }
    }
}
