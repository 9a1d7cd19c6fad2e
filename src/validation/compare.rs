//! The comparison of two pictures in numbers.

use serde::Serialize;

use crate::Invalid;
use crate::math::normal;
use crate::math::statistics::sidak_p_value;

use super::pair::{Pair, once, pairs};
use super::picture::Picture;
use super::z_scores::ZScores;

/// How to compare.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The channels to compare; `None`: all, which both pictures must then have.
    pub channels: Option<Vec<String>>,
    /// The probability α, 0–1, with which pictures that agree are said to differ.
    pub alpha: f64,
    /// ε of the relative mean squared error, not negative.
    pub epsilon: f64,
    /// The value that counts as white for the PSNR; `None`: the reference's full scale, or else its largest value.
    pub peak: Option<f64>,
    /// How many of the pixels that differ most are listed.
    pub worst: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { channels: None, alpha: 0.01, epsilon: 0.01, peak: None, worst: 5 }
    }
}

/// How two pictures a and b differ; b is the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Columns and rows.
    pub resolution_px: [usize; 2],
    /// ε of the relative mean squared errors.
    pub epsilon: f64,
    /// Channel by channel.
    pub channels: Vec<ChannelDifference>,
    /// The pixels that differ most, the worst first: those that are no numbers, then by |z|, or by |a − b| where no
    /// variances are known.
    pub worst: Vec<PixelDifference>,
    /// Whether noise explains the differences; `None` where no variances are known.
    pub verdict: Option<Verdict>,
}

/// How a channel differs. Errors are those of the finite pixels, in the pictures' unit. Numbers that do not exist or are
/// infinite are `null` in JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelDifference {
    /// Name of the channel.
    pub channel: String,
    /// Pixels of the channel.
    pub pixels: usize,
    /// Pixels left out because one side is no finite number, or its variance none that is possible.
    pub non_finite: usize,
    /// Mean of a.
    pub mean_a: f64,
    /// Mean of b.
    pub mean_b: f64,
    /// Mean of a − b.
    pub mean_difference: f64,
    /// The same in percent of the mean of b.
    pub mean_difference_percent: f64,
    /// Root of the mean squared error, √(mean of (a − b)²).
    pub rmse: f64,
    /// Mean of (a − b)²/(b² + ε·(mean of b)²): that of [Rousselle11](crate::references#rousselle11), whose ε is a
    /// radiance squared, made independent of the unit.
    pub relative_mse: f64,
    /// Mean of |a − b|.
    pub mae: f64,
    /// The value that counts as white for the PSNR.
    pub peak: f64,
    /// Peak signal-to-noise ratio 20·log₁₀(peak/RMSE), dB; infinite for equal pictures.
    pub psnr_db: f64,
    /// Where variances are known.
    pub z_scores: Option<ZScores>,
}

/// How a pixel differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PixelDifference {
    /// Column, from the left.
    pub x: usize,
    /// Row, from the top.
    pub y: usize,
    /// Name of the channel.
    pub channel: String,
    /// Its value in a.
    pub a: f64,
    /// Its value in b.
    pub b: f64,
    /// z-score, where it is known; infinite (`null` in JSON) where values without variance differ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z: Option<f64>,
    /// Two-sided p-value of z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub p_value: Option<f64>,
}

/// Whether noise explains the differences: all pixels of all channels are tested at once, so that pictures that agree
/// are said to differ with probability α, however many pixels they have (Šidák's correction,
/// [Sidak67](crate::references#sidak67)). Valid for variances from many samples; see [`ZScores`] for few.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The probability of a wrong "differ".
    pub alpha: f64,
    /// Number n of z-scores tested.
    pub tests: usize,
    /// A pixel fails below this two-sided p-value, 1 − (1 − α)^(1/n).
    pub p_bound: f64,
    /// The same as |z|: a pixel fails above it.
    pub z_bound: f64,
    /// Pixels that fail.
    pub past_bound: usize,
    /// Whether none does.
    pub agree: bool,
}

/// Compares two pictures of one size and unit that have the same channels. The second is the reference.
pub fn compare(a: &Picture, b: &Picture, settings: &Settings) -> Result<Comparison, Invalid> {
    let pairs = pairs(a, b, settings.channels.as_deref())?;
    let channels: Vec<_> = pairs.iter().map(|pair| channel_difference(pair, b.full_scale, settings)).collect();
    let width = a.mean.width();
    Ok(Comparison {
        resolution_px: [width, a.mean.height()],
        epsilon: settings.epsilon,
        verdict: verdict(&pairs, &channels, settings.alpha),
        channels,
        worst: worst(&pairs, width, settings.worst),
    })
}

fn channel_difference(pair: &Pair<'_>, full_scale: Option<f64>, settings: &Settings) -> ChannelDifference {
    let pixels = pair.pixels().count();
    let finite = pair.finite_pixels().count();
    let n = finite as f64;
    let mean = |value: &dyn Fn(usize) -> f64| pair.finite_pixels().map(value).sum::<f64>() / n;
    let (mean_a, mean_b) = (mean(&|i| pair.a(i)), mean(&|i| pair.b(i)));
    let mean_difference = mean(&|i| pair.difference(i));
    let rmse = mean(&|i| pair.difference(i).powi(2)).sqrt();
    let largest = || pair.finite_pixels().map(|i| pair.b(i)).fold(f64::NEG_INFINITY, f64::max);
    let peak = settings.peak.or(full_scale).unwrap_or_else(largest);
    ChannelDifference {
        channel: pair.name.to_owned(),
        pixels,
        non_finite: pixels - finite,
        mean_a,
        mean_b,
        mean_difference,
        mean_difference_percent: if mean_difference == 0.0 { 0.0 } else { 100.0 * mean_difference / mean_b.abs() },
        rmse,
        relative_mse: mean(&|i| relative_difference(pair, i, mean_b, settings.epsilon).powi(2)),
        mae: mean(&|i| pair.difference(i).abs()),
        peak,
        psnr_db: 20.0 * (peak / rmse).log10(),
        z_scores: pair.has_variance().then(|| ZScores::new(pair.finite_pixels().map(|i| pair.z(i)))),
    }
}

/// (a − b)/√(b² + ε·(mean of b)²), the signed root of what the relative mean squared error is the mean of.
pub(super) fn relative_difference(pair: &Pair<'_>, i: usize, mean_b: f64, epsilon: f64) -> f64 {
    let difference = pair.difference(i);
    if difference == 0.0 { 0.0 } else { difference / (pair.b(i).powi(2) + epsilon * mean_b.powi(2)).sqrt() }
}

fn verdict(pairs: &[Pair<'_>], channels: &[ChannelDifference], alpha: f64) -> Option<Verdict> {
    if !pairs.iter().any(Pair::has_variance) {
        return None;
    }
    let tests = channels.iter().filter_map(|c| c.z_scores.as_ref()).map(|z| z.tests).sum();
    let p_bound = sidak_p_value(alpha, tests);
    let z_bound = normal::two_sided_bound(p_bound);
    let past = |pair: &Pair<'_>| pair.finite_pixels().filter(|&i| pair.z(i).is_some_and(|z| z.abs() > z_bound)).count();
    let past_bound = pairs.iter().map(past).sum();
    Some(Verdict { alpha, tests, p_bound, z_bound, past_bound, agree: past_bound == 0 })
}

/// The `count` pixels that differ most.
fn worst(pairs: &[Pair<'_>], width: usize, count: usize) -> Vec<PixelDifference> {
    let tested = pairs.iter().any(Pair::has_variance);
    let mut found: Vec<(f64, &Pair<'_>, usize)> = Vec::new();
    for pair in once(pairs).filter(|pair| pair.has_variance() == tested) {
        for i in pair.pixels() {
            let difference = if tested { pair.z(i).unwrap_or(0.0) } else { pair.difference(i) };
            let badness = if pair.is_finite(i) { difference.abs() } else { f64::INFINITY };
            if badness > 0.0 && (found.len() < count || found.last().is_some_and(|last| badness > last.0)) {
                let place = found.partition_point(|other| other.0 >= badness);
                found.insert(place, (badness, pair, i));
                found.truncate(count);
            }
        }
    }
    let pixel = |(_, pair, i): (f64, &Pair<'_>, usize)| {
        let z = if pair.is_finite(i) { pair.z(i) } else { None };
        PixelDifference {
            x: i % width,
            y: i / width,
            channel: pair.name.to_owned(),
            a: pair.a(i),
            b: pair.b(i),
            z,
            p_value: z.map(normal::two_sided_p_value),
        }
    };
    found.into_iter().map(pixel).collect()
}
