//! Single-photon avalanche diodes (SPAD): every detected photon is counted, with no amplifier noise, but after each
//! count the diode is dead for a while.
//!
//! A photon that reaches the diode is detected with a probability, the quantum efficiency here. Dark counts add to the
//! photons', at a rate of each pixel's own where they are uneven or it is a hot one. A count is followed by another
//! one, without light, with the afterpulsing probability p.

use rand::RngExt;
use rand::distr::Distribution;
use rand_distr::{Binomial, Exp1, Gamma};

use photosite_core::math::philox::Philox;
use photosite_core::units::Seconds;

use super::dark_current::{DarkElectrons, HotPixels};
use super::frame::Frame;
use crate::model::{Counting, Spad};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;

impl Spad {
    /// Counts of an exposure, drawn at random. `mean`: photons and dark counts that are detectable in it on average.
    fn count(&self, mean: f64, time: Seconds, random: &mut Philox) -> f64 {
        match self.counting {
            Counting::FreeRunning { dead_time } => free_running(mean, time, dead_time, self.afterpulsing, random),
            Counting::OneBit { frames } => one_bit_frames(mean, frames, self.afterpulsing, random),
        }
    }

    /// Mean counts of an exposure, but for the first and last of its time.
    fn mean_count(&self, mean: f64, time: Seconds) -> f64 {
        match self.counting {
            Counting::FreeRunning { dead_time } => mean / (1.0 - self.afterpulsing + mean * dead_time.0 / time.0),
            Counting::OneBit { frames } => {
                // The share of bright frames to which the chain of frames tends: p₁ = P + p·(1 − P)·p₁.
                let dark = (-mean / f64::from(frames)).exp();
                f64::from(frames) * (1.0 - dark) / (1.0 - self.afterpulsing * dark)
            }
        }
    }
}

/// Turns the detectable photons of all pixels into counts.
#[derive(Clone, Debug)]
pub(crate) struct PhotonCounter<'a> {
    spad: &'a Spad,
    time: Seconds,
    dark_counts: Option<DarkElectrons>,
    hot_pixels: Option<HotPixels>,
    /// `None` for mean counts.
    streams: Option<Streams>,
}

impl<'a> PhotonCounter<'a> {
    /// `None` for sensors that do not count photons.
    pub(crate) fn new(frame: &Frame<'a>) -> Option<Self> {
        let Frame { sensor, exposure, stages, .. } = frame;
        let spad = sensor.architecture.spad().filter(|_| stages.has(Stage::PhotonCounting))?;
        Some(Self {
            spad,
            time: exposure.time,
            dark_counts: DarkElectrons::new(frame),
            hot_pixels: HotPixels::new(frame),
            streams: frame.temporal(Stage::ShotNoise),
        })
    }
}

impl RowStage for PhotonCounter<'_> {
    const MAP: NoiseMap = Stage::PhotonCounting.map();

    fn apply(&self, row: &mut Row<'_>) {
        if let Some(hot_pixels) = &self.hot_pixels {
            hot_pixels.of_row(row.y, row.values.len()).for_each(|(x, mean)| row.values[x] += mean as f32);
        }
        let y = row.y;
        let mean =
            |x, light: f32| f64::from(light) + self.dark_counts.map_or(0.0, |dark_counts| dark_counts.of_pixel(x, y));
        match &self.streams {
            Some(streams) => {
                streams.pixels(row, |x, light, random| self.spad.count(mean(x, light), self.time, random) as f32)
            }
            None => {
                for (x, value) in row.values.iter_mut().enumerate() {
                    *value = self.spad.mean_count(mean(x, *value), self.time) as f32;
                }
            }
        }
    }
}

/// Counts of a diode that is free to fire whenever it is not dead, during a time.
///
/// At a rate n of what could be counted and with the dead time τ, which further photons do not prolong, it counts at
/// the rate
///
/// m = n / (1 + n·τ)
///
/// and never above 1/τ ([Knoll10](photosite_core::references#knoll10), §4.VII, nonparalyzable). An afterpulse fires at
/// the end of the dead time, so m = n/(1 − p + n·τ) with afterpulsing. `mean`: photons and dark counts that would be
/// counted during `time` without dead time.
pub(crate) fn free_running(
    mean: f64,
    time: Seconds,
    dead_time: Seconds,
    afterpulsing: f64,
    random: &mut Philox,
) -> f64 {
    if mean <= 0.0 {
        return 0.0;
    }
    // All times in units of the mean waiting time 1/n. The diode waits for its first count, and from each count to the
    // next it is dead for `dead` and then waits again, unless it afterpulses.
    let dead = dead_time.0 / time.0 * mean;
    let waits = 1.0 - afterpulsing;
    let (mut left, mut counts) = (mean - random.sample::<f64, _>(Exp1), 0.0);
    if left < 0.0 {
        return 0.0;
    }
    counts += 1.0;
    // As many intervals at once as fit for certain: eight standard deviations of their sum are exceeded with a
    // probability of 10⁻¹⁵. A wait that takes place with the probability w has the variance 2w − w².
    let deviation = ((2.0 * waits - waits * waits).sqrt() / (dead + waits)).max(1.0);
    loop {
        let fit = left / (dead + waits);
        let sure = (fit - 8.0 * deviation * (fit.max(0.0) + 16.0).sqrt()).floor();
        if sure < 32.0 {
            break;
        }
        left -= sure * dead + sum_of_waits(sure, waits, random);
        counts += sure;
    }
    loop {
        left -= dead;
        if afterpulsing == 0.0 || random.random::<f64>() >= afterpulsing {
            left -= random.sample::<f64, _>(Exp1);
        }
        if left < 0.0 {
            return counts;
        }
        counts += 1.0;
    }
}

/// The sum of `intervals` waiting times, exponentially distributed with mean 1, of which each takes place with the
/// probability `waits`.
fn sum_of_waits(intervals: f64, waits: f64, random: &mut Philox) -> f64 {
    let take_place = match waits < 1.0 {
        true => Binomial::new(intervals as u64, waits).map_or(intervals, |d| d.sample(random) as f64),
        false => intervals,
    };
    Gamma::new(take_place, 1.0).map_or(0.0, |distribution| distribution.sample(random))
}

/// The sum of `frames` one-bit frames, each of which tells whether there was any count in it.
///
/// A frame in which H photons and dark counts are detectable on average is 1 with the probability
///
/// P = 1 − exp(−H)
///
/// ([Ma20](photosite_core::references#ma20), eq. 3), and with 1 − (1 − P)·(1 − p) after a frame that was 1. `mean`:
/// detectable photons and dark counts of all frames together.
pub(crate) fn one_bit_frames(mean: f64, frames: u32, afterpulsing: f64, random: &mut Philox) -> f64 {
    let per_frame = mean.max(0.0) / f64::from(frames);
    let detected = -(-per_frame).exp_m1();
    if afterpulsing == 0.0 {
        return Binomial::new(frames.into(), detected).map_or(0.0, |d| d.sample(random) as f64);
    }
    if detected <= 0.0 {
        return 0.0;
    }
    // Runs of zeros end with the probability `detected`, runs of ones with (1 − P)·(1 − p); their lengths are
    // geometric, drawn by inversion. The chain begins after a zero.
    let run = |log_go_on: f64, random: &mut Philox| {
        let uniform = 1.0 - random.random::<f64>();
        (uniform.ln() / log_go_on).floor() + 1.0
    };
    let log_zero = -per_frame;
    let log_one = (-(1.0 - afterpulsing) * (-per_frame).exp()).ln_1p();
    let (mut left, mut ones) = (f64::from(frames), 0.0);
    loop {
        // The frame that ends a run belongs to the next one.
        left -= run(log_zero, random) - 1.0;
        if left <= 0.0 {
            return ones;
        }
        let bright = run(log_one, random).min(left);
        ones += bright;
        left -= bright;
        if left <= 0.0 {
            return ones;
        }
        // A run of ones ends with a zero for certain; it is the first of the next run.
        left -= 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::math::statistics::Moments;

    const TIME: Seconds = Seconds(1e-3);

    fn counts(trials: u64, mut one: impl FnMut(&mut Philox) -> f64) -> Moments {
        (0..trials).map(|i| one(&mut Philox::new(3, i))).collect()
    }

    #[test]
    fn dead_time_law_of_nonparalyzable_counters() {
        for (mean, dead_ns) in [(80.0, 100.0), (5000.0, 100.0), (5000.0, 1000.0), (1e6, 100.0)] {
            let dead = Seconds(dead_ns * 1e-9);
            let trials = 4000;
            let m = counts(trials, |random| free_running(mean, TIME, dead, 0.0, random));
            let (n, x) = (mean / TIME.0, mean / TIME.0 * dead.0);
            let law = n / (1.0 + x) * TIME.0;
            // Renewal theory for intervals of mean τ + 1/n and standard deviation 1/n, of which the first lacks its τ:
            // the mean is the law's and x²/(2·(1 + x)²), less than half a count, the variance law/(1 + x)² and less
            // than one.
            let mean_count = law + x * x / (2.0 * (1.0 + x).powi(2));
            let variance = law / (1.0 + x).powi(2);
            // 5 σ of the mean, and of the variance, of 4000 nearly normal numbers.
            let spread = 5.0 * (variance / trials as f64).sqrt();
            assert!((m.mean() - mean_count).abs() < spread, "{mean}, {dead_ns} ns: {} for {mean_count}", m.mean());
            assert!((m.mean() / law - 1.0).abs() < 0.01);
            let tolerance = 5.0 * variance * (2.0 / trials as f64).sqrt() + 1.0;
            assert!((m.variance() - variance).abs() < tolerance, "{mean}, {dead_ns} ns: {}", m.variance());
        }
    }

    #[test]
    fn without_dead_time_counts_are_poisson() {
        for mean in [0.2, 30.0, 4000.0] {
            let m = counts(20_000, |random| free_running(mean, TIME, Seconds(0.0), 0.0, random));
            let n = 20_000.0;
            assert!((m.mean() - mean).abs() < 5.0 * (mean / n).sqrt(), "{} for {mean}", m.mean());
            let spread = ((mean + 2.0 * mean * mean) / n).sqrt();
            assert!((m.variance() - mean).abs() < 5.0 * spread, "{} for {mean}", m.variance());
        }
    }

    #[test]
    fn steps_of_many_and_of_one_count_alike() {
        // The same law, one event at a time.
        let (mean, dead, afterpulsing) = (3000.0, Seconds(2e-7), 0.05);
        let slow = |random: &mut Philox| {
            let (mut left, mut counts) = (mean - random.sample::<f64, _>(Exp1), 0.0);
            while left >= 0.0 {
                counts += 1.0;
                left -= dead.0 / TIME.0 * mean;
                left -= if random.random::<f64>() < afterpulsing { 0.0 } else { random.sample::<f64, _>(Exp1) };
            }
            counts
        };
        let trials = 10_000;
        let a = counts(trials, |random| free_running(mean, TIME, dead, afterpulsing, random));
        let b = (0..trials).map(|i| slow(&mut Philox::new(77, i))).collect::<Moments>();
        let spread = ((a.variance() + b.variance()) / trials as f64).sqrt();
        assert!((a.mean() - b.mean()).abs() < 5.0 * spread, "{} and {}", a.mean(), b.mean());
        assert!((a.variance() / b.variance() - 1.0).abs() < 5.0 * (4.0 / trials as f64).sqrt());
        // And m = n/(1 − p + nτ).
        let expected = mean / (1.0 - afterpulsing + mean * dead.0 / TIME.0);
        assert!((a.mean() / expected - 1.0).abs() < 1e-3, "{} for {expected}", a.mean());
    }

    #[test]
    fn one_bit_frames_saturate_exponentially() {
        for (mean, frames) in [(0.3, 1), (100.0, 255), (900.0, 255), (5000.0, 255)] {
            let m = counts(20_000, |random| one_bit_frames(mean, frames, 0.0, random));
            let n = f64::from(frames);
            let p = 1.0 - (-mean / n).exp();
            // Binomial: variance n·p·(1 − p); 5 σ of the mean of 20 000.
            let spread = 5.0 * (n * p * (1.0 - p) / 20_000.0).sqrt() + 1e-12;
            assert!((m.mean() - n * p).abs() < spread, "{} for {}", m.mean(), n * p);
        }
        assert_eq!(one_bit_frames(0.0, 255, 0.0, &mut Philox::new(0, 0)), 0.0);
        assert_eq!(one_bit_frames(0.0, 255, 0.1, &mut Philox::new(0, 0)), 0.0);
        assert_eq!(one_bit_frames(1e9, 255, 0.1, &mut Philox::new(0, 0)), 255.0);
    }

    #[test]
    fn afterpulses_follow_bright_frames() {
        let (mean, frames, afterpulsing) = (60.0, 200, 0.15);
        let m = counts(40_000, |random| one_bit_frames(mean, frames, afterpulsing, random));
        // The chain by its transition probabilities, frame by frame.
        let p = 1.0 - (-mean / f64::from(frames)).exp();
        let after_one = 1.0 - (1.0 - p) * (1.0 - afterpulsing);
        let (mut one, mut expected) = (0.0, 0.0);
        for _ in 0..frames {
            one = one * after_one + (1.0 - one) * p;
            expected += one;
        }
        let spread = (m.variance() / 40_000.0).sqrt();
        assert!((m.mean() - expected).abs() < 5.0 * spread, "{} for {expected}", m.mean());
        assert!(expected > 1.05 * p * f64::from(frames), "the test could not tell it from no afterpulses");
    }
}
