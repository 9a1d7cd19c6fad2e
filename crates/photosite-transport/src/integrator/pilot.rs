//! Rendering until Monte Carlo noise is low enough in each pixel, without bias.
//!
//! A pixel that stops once its own samples look quiet stops too early just where bright samples happen to be missing:
//! its mean is biased towards the dark, by tens of per cent where light is rare. So how many samples n a pixel gets is
//! found from a film of *pilot samples*, which have random numbers of their own and are no part of the image
//! [KirkArvo91](photosite_core::references#kirkarvo91). Given the pilot, n is fixed and the mean m of the n samples is
//! that of any render, so that with the pixel's true value μ
//!
//! E\[m\] = E\[E\[m | pilot\]\] = E\[μ\] = μ,
//!
//! and s²/n is an unbiased variance of it. The pilot itself may look at anything it has seen, of all pixels, as often
//! as it wants: it starts with [`START`] samples in every pixel, and grows where they call for more until it has one
//! sample for each [`SHARE`] of the image, in every pixel at least half of what that is on average. Where noise is
//! hard to tell there are thus many, and a few where all is quiet by chance.
//!
//! The alternative, two halves of a pixel's samples of which each sets the number of the other, wastes none, but may
//! look only once: halves that look again are no longer independent. An experiment with samples of which 2 % are bright
//! (4000 pixels, with 24 neighbours each): for a count of 1024 the variance was 5.9 times the wanted one with halves,
//! 2.5 times with a pilot that looks twice, for 5 % more paths, and the mean was 46 % too low where pixels stop by
//! their own samples. For a count of 16 halves need a seventh fewer paths.
//!
//! Samples of a pixel are taken for independent. Stratified ones (Sobol) do better than their variance says, so that
//! they fall below the target.

use std::ops::ControlFlow;

use crate::film::Film;

/// Samples a pixel that the pilot starts with, and that an image has at least.
pub const START: u32 = 16;
/// Number of samples of the image for each sample of the pilot.
pub const SHARE: u32 = 8;
/// Samples that an image gets for each one that seems to be needed: what a pilot tells of noise is off by some ten per
/// cent.
const MARGIN: f32 = 1.2;
/// Factor by which the pilot of a pixel may grow between two looks: noise that was seen once may be chance.
const GROWTH: u32 = 4;
/// Pilot samples, which tell how many samples each pixel of an image needs.
#[derive(Clone)]
pub struct Pilot {
    /// Film of the pilot samples.
    pub film: Film,
    /// Number of pilot samples that each pixel shall have before they are looked at again. A pass that is broken off
    /// leaves some with fewer, and looked at then, they would not tell what they tell in a render that is left alone.
    pub wanted: Vec<u32>,
}

impl Pilot {
    /// Starts a pilot from an empty film.
    pub fn new(film: Film) -> Self {
        let wanted = vec![0; film.counts().len()];
        Self { film, wanted }
    }
}

/// Finds the number of samples that each pixel needs, within limits, from a pilot that `pass` brings to as many as it
/// wants.
pub(super) fn find_counts(
    pilot: &mut Pilot,
    [least, most]: [u32; 2],
    needed: &dyn Fn(&Film) -> Option<Vec<f32>>,
    mut pass: impl FnMut(&mut Pilot) -> ControlFlow<()>,
) -> ControlFlow<(), Vec<u32>> {
    pilot.wanted.iter_mut().for_each(|wanted| *wanted = least.max(*wanted));
    loop {
        pass(pilot)?;
        // The conversion saturates at the largest number.
        let needed = needed(&pilot.film).map(|needed| needed.into_iter().map(|n| (n * MARGIN).ceil() as u32));
        let Some(needed) = needed else { return ControlFlow::Continue(vec![most; pilot.wanted.len()]) };
        let counts: Vec<u32> = needed.map(|n| n.clamp(least, most)).collect();
        // Where a pixel is quiet by chance, the others tell that it is worth another look.
        let mean = counts.iter().map(|&count| u64::from(count)).sum::<u64>() / counts.len().max(1) as u64;
        let floor = (mean / u64::from(2 * SHARE)) as u32;
        let grown =
            |(&count, &done): (&u32, &u32)| (count / SHARE).max(floor).min(done.saturating_mul(GROWTH)).max(done);
        let wanted: Vec<u32> = counts.iter().zip(pilot.film.counts()).map(grown).collect();
        // The last few samples would not change much.
        let is_enough = wanted.iter().zip(pilot.film.counts()).all(|(&wanted, &done)| wanted <= done + done / 2);
        if is_enough {
            return ControlFlow::Continue(counts);
        }
        pilot.wanted = wanted;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{FilmResponses, Response};
    use photosite_core::math::hash::{hash64, unit_f32};
    use photosite_core::spectrum::{SampledSpectrum, Spectrum, WavelengthSampler};

    /// Probability of light in a sample: rare.
    const PART: f64 = 0.02;
    /// Target variance of a pixel, in the square of the level of a sample with light.
    const VARIANCE: f64 = 1e-4;
    const PIXELS: usize = 20_000;

    fn empty() -> Film {
        Film::new(PIXELS, 1, FilmResponses::new(&[Response::new("E", Spectrum::constant(1.0))]))
    }

    /// Brings a film to the wanted numbers of samples, each of which has light by chance.
    fn fill(film: &mut Film, seed: u64, wanted: &[u32]) {
        let wavelengths = WavelengthSampler::new(&Spectrum::constant(1.0)).sample(0.5);
        let row = &mut film.bands(1)[0];
        for (pixel, &wanted) in wanted.iter().enumerate() {
            for index in row.samples(pixel)..wanted {
                let u = unit_f32(hash64(hash64(seed, pixel as u64), u64::from(index)) as u32);
                row.add(pixel, [[(SampledSpectrum::splat(if f64::from(u) < PART { 1.0 } else { 0.0 }), &wavelengths)]]);
            }
        }
    }

    /// Level of a sample with light.
    fn level() -> f64 {
        let mut film = empty();
        let wavelengths = WavelengthSampler::new(&Spectrum::constant(1.0)).sample(0.5);
        film.bands(1)[0].add(0, [[(SampledSpectrum::splat(1.0), &wavelengths)]]);
        f64::from(film.estimate(["E"]).mean.channels()[0].data[0])
    }

    fn planes(film: &Film) -> [Vec<f64>; 2] {
        let estimate = film.estimate(["E"]);
        let level = level();
        let values = |planes: &photosite_core::image::Planes, unit: f64| {
            planes.channels()[0].data.iter().map(|&v| f64::from(v) / unit).collect()
        };
        [values(&estimate.mean, level), values(&estimate.variance, level * level)]
    }

    /// Numbers of samples needed for [`VARIANCE`], each pixel by itself.
    fn needed(film: &Film) -> Option<Vec<f32>> {
        let [_, variance] = planes(film);
        Some(variance.iter().zip(film.counts()).map(|(v, &n)| (v * f64::from(n) / VARIANCE) as f32).collect())
    }

    /// Mean over the pixels in standard deviations from the truth, which is [`PART`].
    fn z_score(film: &Film) -> f64 {
        let moments: photosite_core::math::statistics::Moments = planes(film)[0].iter().copied().collect();
        (moments.mean() - PART) / moments.variance_of_mean().sqrt()
    }

    #[test]
    fn counts_from_a_pilot_leave_the_mean_unbiased_and_counts_from_the_image_do_not() {
        // p·(1 − p)/variance: 196 samples are needed. The first 16 show none in 72 % of the pixels.
        let mut pilot = Pilot::new(empty());
        let counts = find_counts(&mut pilot, [START, 4096], &needed, |pilot| {
            fill(&mut pilot.film, 1, &pilot.wanted);
            ControlFlow::Continue(())
        });
        let pilot = pilot.film;
        let ControlFlow::Continue(counts) = counts else { panic!("nothing breaks off") };
        let mut image = empty();
        fill(&mut image, 2, &counts);
        assert_eq!(image.counts(), counts);
        let z = z_score(&image);
        assert!(z.abs() < 4.0, "{z}");
        // The same numbers for the samples that they were found from, and more of their kind.
        let mut naive = pilot.clone();
        let all: Vec<u32> = pilot.counts().iter().zip(&counts).map(|(&a, &b)| a.max(b)).collect();
        fill(&mut naive, 1, &all);
        let z = z_score(&naive);
        assert!(z < -20.0, "{z}");
    }

    #[test]
    fn the_variance_is_right_where_counts_differ() {
        let mut image = empty();
        let counts: Vec<u32> = (0..PIXELS as u32).map(|pixel| 8 + pixel % 3 * 100).collect();
        fill(&mut image, 3, &counts);
        let [mean, variance] = planes(&image);
        for kind in 0..3 {
            let (mut error, mut said) = (0.0, 0.0);
            for i in (kind..PIXELS).step_by(3) {
                error += (mean[i] - PART).powi(2);
                said += variance[i];
            }
            // 6667 squared errors whose kurtosis is 3 + 1/(n·p·(1 − p)) ≤ 9.4: σ of their mean ≤ √(8.4/6667) = 3.6 %,
            // and the same for the variances.
            assert!((said / error - 1.0).abs() < 4.0 * 0.036 * 2f64.sqrt(), "{kind}: {}", said / error);
        }
    }
}
