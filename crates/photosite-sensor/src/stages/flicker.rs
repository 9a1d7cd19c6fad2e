//! Flicker noise: traps of many time constants make the noise of an amplifier stronger the slower it is, with a power
//! that falls as 1/f^γ.
//!
//! Samples that one amplifier reads after each other are made by drawing their Fourier coefficients: normally
//! distributed, with variances as the power, but none for the mean. So that the last sample does not meet the first,
//! the period is longer than what is used of it. Every sample has the stated variance.
//!
//! Every image is a sequence of its own: what is slower than one image is left to the dark current and its
//! temperature, and images of a series have no flicker noise in common.

use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use photosite_fft::{Complex32, Fft, inverse_f32};

use super::frame::Frame;
use crate::model::Flicker;
use crate::model::FlickerOrder;
use crate::signal::charge_plane::ChargePlane;
use crate::signal::effects::Stage;
use crate::signal::noise_key::Streams;

/// Adds 1/f noise to all signals.
pub(crate) fn add_flicker(signals: &mut ChargePlane, frame: &Frame<'_>) {
    let flicker = &frame.sensor.noise.flicker;
    let (width, height) = (signals.width, signals.height);
    let Some(streams) = frame.temporal(Stage::Flicker).filter(|_| flicker.noise.0 > 0.0 && width * height > 0) else {
        return;
    };
    match flicker.order {
        FlickerOrder::Serial => {
            let noise = sequences(flicker, 1, width * height, streams);
            signals.for_each_row(|row| {
                let samples = &noise[row.y * width..];
                row.values.iter_mut().zip(samples).for_each(|(signal, noise)| *signal += noise);
            });
        }
        FlickerOrder::ColumnParallel => {
            let noise = sequences(flicker, width, height, streams);
            signals.for_each_row(|row| {
                let samples = noise[row.y..].iter().step_by(height);
                row.values.iter_mut().zip(samples).for_each(|(signal, noise)| *signal += noise);
            });
        }
    }
}

/// `count` sequences of `length` samples, one after the other.
fn sequences(flicker: &Flicker, count: usize, length: usize, streams: Streams) -> Vec<f32> {
    let period = period(length);
    let fft = inverse_f32(period);
    let amplitudes = amplitudes(flicker, period);
    let mut samples = vec![0.0; count * length];
    // Real and imaginary parts of one transform are two sequences that know nothing of each other.
    samples.par_chunks_mut(2 * length).enumerate().for_each(|(pair, samples)| {
        let noise = complex_sequence(&*fft, &amplitudes, streams, pair);
        let (re, im) = samples.split_at_mut(length);
        re.iter_mut().zip(&noise).for_each(|(sample, z)| *sample = z.re);
        im.iter_mut().zip(&noise).for_each(|(sample, z)| *sample = z.im);
    });
    samples
}

/// A length that transforms fast, at least a quarter above `length`.
fn period(length: usize) -> usize {
    let least = (length + length / 4).max(2);
    let power = least.next_power_of_two();
    if power / 4 * 3 >= least { power / 4 * 3 } else { power }
}

/// Standard deviation of the coefficient of each frequency up to half the sampling rate, the squares of all summing to
/// the variance.
fn amplitudes(flicker: &Flicker, period: usize) -> Vec<f32> {
    let power = |k: usize| if k == 0 { 0.0 } else { (k as f64).powf(-flicker.exponent) };
    let total: f64 = (0..period).map(|k| power(k.min(period - k))).sum();
    let variance = flicker.noise.0 * flicker.noise.0 / total;
    (0..=period / 2).map(|k| (variance * power(k)).sqrt() as f32).collect()
}

fn complex_sequence(fft: &dyn Fft<f32>, amplitudes: &[f32], streams: Streams, number: usize) -> Vec<Complex32> {
    let mut random = streams.stream(number);
    let mut coefficient = |k: usize| {
        let amplitude = amplitudes[k.min(fft.len() - k)];
        Complex32::new(
            amplitude * random.sample::<f32, _>(StandardNormal),
            amplitude * random.sample::<f32, _>(StandardNormal),
        )
    };
    let mut values: Vec<Complex32> = (0..fft.len()).map(&mut coefficient).collect();
    fft.process(&mut values);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn periods_are_longer_than_what_they_hold_and_not_by_much() {
        for length in [1, 2, 3, 7, 100, 480, 1200, 3072, 24_000_000] {
            let period = period(length);
            assert!(4 * period >= 5 * length - 3 && period >= 2, "{period} for {length}");
            assert!(period <= 2 * length + 2, "{period} for {length}");
        }
    }
}
