//! Monte Carlo noise of light beside the noise of the sensor that sees it: what is worth another sample.
//!
//! In: electron rates with the variance of their mean (e⁻·s⁻¹ and its square), and the samples of each pixel. Out:
//! ratios of standard deviations, and numbers of samples that bring a ratio down.

use super::noise_model::NoiseModel;
use crate::{Exposure, SensorModel, Stages};
use photosite_core::image::{Estimate, Planes};
use photosite_core::units::Electrons;

/// Half the side of the neighbourhood in which noise is taken to be alike, pixels.
const RADIUS: usize = 2;
/// Samples of a pixel at which its own noise counts as much as that of its neighbourhood.
const TRUSTED: f32 = 64.0;

/// The pixels whose noise that of a pixel is taken to be like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbours {
    /// All near pixels, where light of all colours is known as well in each.
    All,
    /// Near pixels that see the same channel, where light of the others is known less well.
    OfTheSameChannel,
}

impl Neighbours {
    /// 1 for those that count in a channel, 0 for others.
    fn counted(self, channel: usize, sensor: &SensorModel, [width, height]: [usize; 2]) -> Vec<f32> {
        let counts = |i| self == Self::All || sees(sensor, channel, i, width);
        (0..width * height).map(|i| if counts(i) { 1.0 } else { 0.0 }).collect()
    }
}

/// Whether the i-th pixel of an image has a channel.
fn sees(sensor: &SensorModel, channel: usize, i: usize, width: usize) -> bool {
    let samples = sensor.cfa.samples_per_pixel();
    (0..samples).any(|sample| sensor.cfa.channel_at(i % width * samples + sample, i / width) == channel)
}

/// Monte Carlo noise of an image beside the noise of the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightNoise {
    /// Ratio of the root-mean-square Monte Carlo noise to that of the sensor, over each pixel's own channel. Pixels that
    /// saturate or see no light do not count: no noise shows there. `None` where nothing counts.
    pub ratio: Option<f64>,
    /// Part of the pixels that see light, 0–1, that saturate.
    pub saturated_part: f64,
}

impl LightNoise {
    /// Noise of light at an exposure. The bandwidth of a video line and the samples of a frame grabber leave as much of
    /// both kinds.
    pub fn new(rates: &Estimate, sensor: &SensorModel, exposure: &Exposure) -> Self {
        let (width, time) = (rates.mean.width(), exposure.time.0);
        let samples = sensor.cfa.samples_per_pixel();
        let row_length = width * samples;
        let saturation = sensor.pixel_saturation(exposure).0;
        let pixels = exposure.region.binning.pixels() as f64;
        let model = NoiseModel::new(sensor, exposure, Stages::ALL);
        let (mut of_light, mut of_sensor) = (0.0, 0.0);
        let (mut lit, mut saturated) = (0usize, 0usize);
        for i in 0..row_length * rates.mean.height() {
            if !sensor.sees_light([i % row_length / samples, i / row_length]) {
                continue;
            }
            let channel = sensor.cfa.channel_at(i % row_length, i / row_length);
            let at = |planes: &Planes| f64::from(planes.channels()[channel].data[i / samples]);
            let mean = at(&rates.mean) * time;
            lit += 1;
            if mean < saturation {
                of_light += at(&rates.variance) * time * time * pixels;
                of_sensor += model.variance(Electrons(mean * pixels));
            } else {
                saturated += 1;
            }
        }
        Self {
            ratio: (of_sensor > 0.0).then(|| (of_light / of_sensor).sqrt()),
            saturated_part: saturated as f64 / lit.max(1) as f64,
        }
    }
}

/// Variance of the sensor's noise in each channel at those electron rates, as a variance of rates; ∞ where a pixel
/// saturates, since no noise shows there.
pub fn sensor_noise(rates: &Planes, sensor: &SensorModel, exposure: &Exposure) -> Planes {
    let (time, saturation) = (exposure.time.0, sensor.pixel_saturation(exposure).0);
    let pixels = exposure.region.binning.pixels() as f64;
    let model = NoiseModel::new(sensor, exposure, Stages::ALL);
    let mut variance = rates.clone();
    for value in variance.channels_mut().iter_mut().flat_map(|channel| &mut channel.data) {
        let electrons = f64::from(*value) * time;
        let of_rate = model.variance(Electrons(electrons * pixels)) / (pixels * time * time);
        *value = if electrons < saturation { of_rate as f32 } else { f32::INFINITY };
    }
    variance
}

/// Number of samples that brings the Monte Carlo noise of each pixel down to `target` times the sensor's noise there
/// (standard deviations), row by row:
///
/// n = b·s²·t²/(target²·σ²(b·μ·t))
///
/// with the variance s² of one sample and the mean μ in the pixel's own channel (the worst of those that it has), the
/// exposure time t, b pixels in a bin, and the sensor's variance σ² ([`SensorModel::noise_variance`]). Few samples tell
/// little of s², least where bright ones are rare: both s² and μ are those of the pixel's N samples with a weight of
/// N and of its neighbours among the 5 × 5 pixels about it with a weight of 64. Saturated pixels need none, and are
/// nobody's neighbours.
pub fn samples_needed(
    rates: &Estimate,
    counts: &[u32],
    sensor: &SensorModel,
    exposure: &Exposure,
    target: f64,
    neighbours: Neighbours,
) -> Vec<f32> {
    let size @ [width, _] = [rates.mean.width(), rates.mean.height()];
    let mut needed = vec![0f32; counts.len()];
    for (channel, (mean, variance)) in rates.mean.channels().iter().zip(rates.variance.channels()).enumerate() {
        let of_channel = Needed { mean: &mean.data, variance: &variance.data, counts, sensor, exposure, target };
        let of_channel = of_channel.samples(width, neighbours.counted(channel, sensor, size));
        for (i, (needed, of_channel)) in needed.iter_mut().zip(of_channel).enumerate() {
            if sees(sensor, channel, i, width) {
                *needed = needed.max(of_channel);
            }
        }
    }
    needed
}

/// Electron rates whose pixels are those of `rates` and their neighbourhoods, as in [`samples_needed`], so that an
/// automatic exposure does not take the noise of few samples for bright parts.
pub fn smoothed_mean(rates: &Estimate, counts: &[u32], sensor: &SensorModel, neighbours: Neighbours) -> Planes {
    let mut mean = rates.mean.clone();
    let size @ [width, _] = [mean.width(), mean.height()];
    for (index, channel) in mean.channels_mut().iter_mut().enumerate() {
        channel.data = shrunk(&channel.data, counts, &neighbours.counted(index, sensor, size), width);
    }
    mean
}

/// Data for the number of samples that one channel needs.
struct Needed<'a> {
    mean: &'a [f32],
    variance: &'a [f32],
    counts: &'a [u32],
    sensor: &'a SensorModel,
    exposure: &'a Exposure,
    target: f64,
}

impl Needed<'_> {
    /// `counted` is 1 for pixels that may be neighbours.
    fn samples(&self, width: usize, mut counted: Vec<f32>) -> Vec<f32> {
        let Self { mean, variance, counts, sensor, exposure, target } = *self;
        let time = exposure.time.0;
        let saturation = sensor.pixel_saturation(exposure).0;
        let pixels = exposure.region.binning.pixels() as f64;
        // One bright sample among a few does not make a pixel that saturates.
        let surely = |(&mean, &variance): (&f32, &f32)| f64::from(mean) - 2.0 * f64::from(variance).sqrt();
        for (counted, pixel) in counted.iter_mut().zip(mean.iter().zip(variance)) {
            *counted *= if surely(pixel) * time < saturation { 1.0 } else { 0.0 };
        }
        let of_one: Vec<f32> = variance.iter().zip(counts).map(|(&v, &n)| v * n as f32).collect();
        let of_one = shrunk(&of_one, counts, &counted, width);
        let mean = shrunk(mean, counts, &counted, width);
        let model = NoiseModel::new(sensor, exposure, Stages::ALL);
        let of_pixel = |((&mean, &of_one), &counted): ((&f32, &f32), &f32)| {
            if counted == 0.0 {
                return 0.0;
            }
            let of_sensor = model.variance(Electrons(f64::from(mean) * time * pixels));
            (f64::from(of_one) * time * time * pixels / (target * target * of_sensor)) as f32
        };
        mean.iter().zip(&of_one).zip(&counted).map(of_pixel).collect()
    }
}

/// The values of pixels of N samples with a weight of N, and the mean of their neighbourhoods with that of [`TRUSTED`].
fn shrunk(values: &[f32], counts: &[u32], counted: &[f32], width: usize) -> Vec<f32> {
    let weighted: Vec<f32> = values.iter().zip(counted).map(|(value, counted)| value * counted).collect();
    let (sums, weights) = (box_sums(&weighted, width), box_sums(counted, width));
    let of_pixel = |((&value, &count), (&sum, &weight)): ((&f32, &u32), (&f32, &f32))| {
        let around = if weight > 0.0 { sum / weight } else { value };
        (value * count as f32 + around * TRUSTED) / (count as f32 + TRUSTED)
    };
    values.iter().zip(counts).zip(sums.iter().zip(&weights)).map(of_pixel).collect()
}

/// Sums over squares of 2·[`RADIUS`] + 1 pixels a side, as far as they lie in the image.
fn box_sums(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width.max(1);
    let within = |i: usize, size: usize| i.saturating_sub(RADIUS)..(i + RADIUS + 1).min(size);
    let along_rows: Vec<f32> =
        values.chunks(width).flat_map(|row| (0..width).map(|x| row[within(x, width)].iter().sum())).collect();
    let down = |i: usize| within(i / width, height).map(|y| along_rows[y * width + i % width]).sum();
    (0..values.len()).map(down).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets;
    use photosite_core::units::Seconds;

    const SIZE: [usize; 2] = [12, 10];
    const COUNT: u32 = 16;
    const EXPOSURE: Exposure = Exposure::of(Seconds(0.1));
    const TARGET: f64 = 0.05;

    fn sensor() -> SensorModel {
        presets::model("generic-cmos-color").expect("a preset")
    }

    /// Rates of 1000 e⁻/s whose mean has a variance of 50, but for that of red.
    fn light() -> Estimate {
        let filled = |value: f32| {
            let mut planes = Planes::zeros(SIZE[0], SIZE[1], ["R", "G", "B"]);
            planes.channels_mut().iter_mut().for_each(|channel| channel.data.fill(value));
            planes
        };
        let mut variance = filled(50.0);
        variance.channels_mut()[0].data.fill(20.0);
        Estimate { mean: filled(1000.0), variance }
    }

    fn needed(light: &Estimate, count: u32) -> Vec<f64> {
        let counts = vec![count; SIZE[0] * SIZE[1]];
        let needed = samples_needed(light, &counts, &sensor(), &EXPOSURE, TARGET, Neighbours::All);
        needed.into_iter().map(f64::from).collect()
    }

    /// Expected number of samples for a variance of the mean, (e⁻/s)².
    fn expected(variance: f64) -> f64 {
        let of_sensor = sensor().noise_variance(Electrons(100.0), &EXPOSURE);
        variance * f64::from(COUNT) * 0.01 / (TARGET * TARGET * of_sensor)
    }

    fn assert_near(value: f64, expected: f64) {
        // Sums of 25 numbers of 24 bits.
        assert!((value / expected - 1.0).abs() < 1e-5, "{value} instead of {expected}");
    }

    #[test]
    fn noise_that_is_alike_needs_what_its_variance_says_in_the_channel_of_each_pixel() {
        // RGGB: the first pixel is red, its neighbours are not.
        let needed = needed(&light(), COUNT);
        assert_near(needed[0], expected(20.0));
        assert_near(needed[1], expected(50.0));
        assert_near(needed[SIZE[0] + 1], expected(50.0));
        // This number of samples brings the ratio of the image to the target.
        let mut light = light();
        for channel in light.variance.channels_mut() {
            let factor = f64::from(COUNT) / expected(f64::from(channel.data[0]));
            channel.data.iter_mut().for_each(|v| *v = (f64::from(*v) * factor) as f32);
        }
        assert_near(LightNoise::new(&light, &sensor(), &EXPOSURE).ratio.expect("a ratio"), TARGET);
    }

    #[test]
    fn the_noise_ratio_is_that_of_pixels_that_do_not_saturate() {
        let noise = |light: &Estimate| LightNoise::new(light, &sensor(), &EXPOSURE);
        let mut light = light();
        let calm = noise(&light);
        assert_eq!(calm.saturated_part, 0.0);
        // Rows of either kind are left in equal number, as they are in the whole image.
        let mut saturate = |rows: usize| {
            for channel in light.mean.channels_mut() {
                channel.data[..rows * SIZE[0]].fill(1e9);
            }
            noise(&light)
        };
        let some = saturate(6);
        assert_eq!(some.saturated_part, 0.6);
        assert_near(some.ratio.expect("a ratio"), calm.ratio.expect("a ratio"));
        assert_eq!(saturate(SIZE[1]), LightNoise { ratio: None, saturated_part: 1.0 });
    }

    #[test]
    fn a_pixel_is_trusted_by_its_samples() {
        let mut light = light();
        let noisy = 5 * SIZE[0] + 5;
        light.variance.channels_mut()[2].data[noisy] = 5000.0;
        let around = (24.0 * 50.0 + 5000.0) / 25.0;
        for count in [16, 4096] {
            let n = f64::from(count);
            let needed = needed(&light, count);
            assert_near(needed[noisy], expected((5000.0 * n + around * 64.0) / (n + 64.0)) * n / 16.0);
            // The next blue pixel lies within its neighbourhood, the one after that beyond.
            assert_near(needed[noisy + 2], expected((50.0 * n + around * 64.0) / (n + 64.0)) * n / 16.0);
            assert_near(needed[noisy + 4], expected(50.0) * n / 16.0);
        }
    }

    #[test]
    fn saturated_pixels_need_none_and_do_not_count() {
        let mut light = light();
        let lamp = 5 * SIZE[0] + 5;
        for channel in light.mean.channels_mut() {
            channel.data[lamp] = 1e9;
        }
        for channel in light.variance.channels_mut() {
            channel.data[lamp] = 1e12;
        }
        let found = needed(&light, COUNT);
        assert_eq!(found[lamp], 0.0);
        assert_near(found[lamp + 2], expected(50.0));
        // A pixel that one bright sample may have made does not saturate for sure.
        light.variance.channels_mut()[2].data[lamp] = 1e18;
        assert!(needed(&light, COUNT)[lamp] > 1e6);
        assert!(needed(&light, COUNT)[lamp + 2] > expected(50.0) * 2.0);
    }

    #[test]
    fn what_pixels_tell_badly_of_other_channels_does_not_count() {
        let (calm, counts) = (light(), vec![COUNT; SIZE[0] * SIZE[1]]);
        let mut light = light();
        for (channel, (mean, variance)) in
            light.mean.channels_mut().iter_mut().zip(light.variance.channels_mut()).enumerate()
        {
            for i in (0..SIZE[0] * SIZE[1]).filter(|&i| !sees(&sensor(), channel, i, SIZE[0])) {
                (mean.data[i], variance.data[i]) = (3000.0, 1e6);
            }
        }
        let needed = |light, neighbours| samples_needed(light, &counts, &sensor(), &EXPOSURE, TARGET, neighbours);
        let alike = |a: &[f32], b: &[f32]| a.iter().zip(b).all(|(a, b)| (a / b - 1.0).abs() < 1e-5);
        let wanted = needed(&calm, Neighbours::All);
        assert!(alike(&needed(&light, Neighbours::OfTheSameChannel), &wanted));
        assert!(!alike(&needed(&light, Neighbours::All), &wanted));
        let mean = smoothed_mean(&light, &counts, &sensor(), Neighbours::OfTheSameChannel);
        let own = |i: usize| mean.channels()[sensor().cfa.channel_at(i % SIZE[0], i / SIZE[0])].data[i];
        assert!((0..counts.len()).all(|i| (own(i) / 1000.0 - 1.0).abs() < 1e-5));
    }

    #[test]
    fn few_bright_samples_do_not_shorten_an_exposure() {
        let mut light = light();
        light.mean.channels_mut()[1].data[40] = 26_000.0;
        let mean = smoothed_mean(&light, &vec![8; SIZE[0] * SIZE[1]], &sensor(), Neighbours::All);
        // (8·26 000 + 64·2000)/72.
        assert_near(f64::from(mean.channels()[1].data[40]), 336_000.0 / 72.0);
        assert_near(f64::from(mean.channels()[0].data[40]), 1000.0);
    }
}
