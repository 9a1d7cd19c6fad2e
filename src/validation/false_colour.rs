//! Differences as a picture: blue where a lies below b, white where they agree, red where it lies above.

use crate::Invalid;

use super::compare::{Settings, relative_difference};
use super::pair::{Pair, once, pairs};
use super::picture::Picture;

/// ColorBrewer's eleven classes RdBu ([Brewer03](crate::references#brewer03)), from blue to red, sRGB. They include color
/// specifications and designs developed by Cynthia Brewer (<https://colorbrewer.org/>), under the Apache License 2.0.
const BLUE_TO_RED: [[u8; 3]; 11] = [
    [5, 48, 97],
    [33, 102, 172],
    [67, 147, 195],
    [146, 197, 222],
    [209, 229, 240],
    [247, 247, 247],
    [253, 219, 199],
    [244, 165, 130],
    [214, 96, 77],
    [178, 24, 43],
    [103, 0, 31],
];
/// Pixels that are no numbers.
const NON_FINITE: [u8; 3] = [255, 255, 0];
/// Around the channels, and pixels that are not compared.
const NOTHING: [u8; 3] = [64, 64, 64];
/// Pixels between channels.
const GAP: usize = 4;

/// What the colours show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// z-scores (a − b)/√(var a + var b), where variances are known for all channels.
    ZScores,
    /// (a − b)/√(b² + ε·(mean of b)²), whose square the relative mean squared error is the mean of.
    RelativeDifference,
}

impl Shown {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::ZScores => "z-score",
            Self::RelativeDifference => "relative difference",
        }
    }

    /// The difference that reaches the ends of the map unless another is asked for: 4 standard deviations, which one
    /// pixel in 16 000 exceeds by chance, or 10 %.
    fn usual_range(self) -> f64 {
        match self {
            Self::ZScores => 4.0,
            Self::RelativeDifference => 0.1,
        }
    }
}

/// A picture of differences: the channels side by side, more than four in a grid, in the order of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct FalseColour {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// width × height colours, sRGB.
    pub pixels: Vec<[u8; 3]>,
    /// What they show.
    pub shown: Shown,
    /// The darkest blue is −range and below, the darkest red +range and above.
    pub range: f64,
}

/// Pictures the differences of two pictures. Pixels that are no numbers are yellow; a mosaic is shown as a whole.
pub fn false_colour(a: &Picture, b: &Picture, settings: &Settings, range: Option<f64>) -> Result<FalseColour, Invalid> {
    let pairs = pairs(a, b, settings.channels.as_deref())?;
    let shown = if pairs.iter().all(Pair::has_variance) { Shown::ZScores } else { Shown::RelativeDifference };
    let range = range.unwrap_or(shown.usual_range());
    let (columns, cell) = (columns(once(&pairs).count()), [a.mean.width() + GAP, a.mean.height() + GAP]);
    let width = columns * cell[0] - GAP;
    let height = once(&pairs).count().div_ceil(columns) * cell[1] - GAP;
    let mut pixels = vec![NOTHING; width * height];
    for (index, pair) in once(&pairs).enumerate() {
        let corner = index / columns * cell[1] * width + index % columns * cell[0];
        let mean_b = pair.finite_pixels().map(|i| pair.b(i)).sum::<f64>() / pair.finite_pixels().count() as f64;
        for i in pair.pixels() {
            let value = match shown {
                Shown::ZScores => pair.z(i).unwrap_or(0.0),
                Shown::RelativeDifference => relative_difference(pair, i, mean_b, settings.epsilon),
            };
            let place = corner + i / a.mean.width() * width + i % a.mean.width();
            pixels[place] = if pair.is_finite(i) { colour(value / range) } else { NON_FINITE };
        }
    }
    Ok(FalseColour { width, height, pixels, shown, range })
}

/// The colour of a number between −1 and 1, and of numbers beyond.
fn colour(value: f64) -> [u8; 3] {
    let last = (BLUE_TO_RED.len() - 1) as f64;
    let place = (value.clamp(-1.0, 1.0) + 1.0) / 2.0 * last;
    let class = (place as usize).min(BLUE_TO_RED.len() - 2);
    let t = place - class as f64;
    let mix = |c: usize| f64::from(BLUE_TO_RED[class][c]) * (1.0 - t) + f64::from(BLUE_TO_RED[class + 1][c]) * t;
    [0, 1, 2].map(|c| mix(c).round() as u8)
}

/// How many channels stand beside each other.
fn columns(channels: usize) -> usize {
    if channels <= 4 { channels } else { (channels as f64).sqrt().ceil() as usize }
}
