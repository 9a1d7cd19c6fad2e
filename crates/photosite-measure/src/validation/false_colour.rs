//! Differences as an image: blue where a lies below b, white where they agree, red where it lies above.

use photosite_core::Invalid;

use super::compare::{ComparisonSettings, relative_difference};
use super::compared_image::ComparedImage;
use super::pair::{Pair, once, pairs};

/// ColorBrewer's eleven classes RdBu ([Brewer03](photosite_core::references#brewer03)), from blue to red, sRGB. They
/// include color specifications and designs developed by Cynthia Brewer (<https://colorbrewer.org/>), under the Apache
/// License 2.0.
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
/// Colour of pixels that are not finite.
const NON_FINITE: [u8; 3] = [255, 255, 0];
/// Around the channels, and pixels that are not compared.
const NOTHING: [u8; 3] = [64, 64, 64];
/// Pixels between channels.
const GAP: usize = 4;

/// Quantity that the colours show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// z-scores (a − b)/√(var a + var b), where the variances of both are known for all channels.
    ZScores,
    /// (a − b)/√(b² + ε·(mean of b)²), whose square the relative mean squared error is the mean of.
    RelativeDifference,
}

impl Shown {
    /// Name of the quantity, in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::ZScores => "z-scores",
            Self::RelativeDifference => "relative differences",
        }
    }
}

/// An image of differences: the channels side by side, more than four in a grid, in the order of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct FalseColour {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// width × height colours, sRGB.
    pub pixels: Vec<[u8; 3]>,
    /// Quantity that the colours show.
    pub shown: Shown,
    /// The darkest blue is −range and below, the darkest red +range and above. Unless another is asked for: 4 standard
    /// deviations, which one pixel in 16 000 exceeds by chance; of relative differences twice their root mean square,
    /// rounded up to 1, 2 or 5 times a power of ten.
    pub range: f64,
}

/// Shows the differences of two images. Pixels that are not finite are yellow; a mosaic is shown as a whole.
pub fn false_colour(
    a: &ComparedImage,
    b: &ComparedImage,
    settings: &ComparisonSettings,
    range: Option<f64>,
) -> Result<FalseColour, Invalid> {
    let pairs = pairs(a, b, settings.channels.as_deref())?;
    let shown = if pairs.iter().all(Pair::has_variance) { Shown::ZScores } else { Shown::RelativeDifference };
    let planes: Vec<_> = once(&pairs).map(|pair| (pair, values(pair, shown, settings.epsilon))).collect();
    let range = range.unwrap_or_else(|| match shown {
        Shown::ZScores => 4.0,
        Shown::RelativeDifference => round_range(&planes),
    });
    let columns = if planes.len() <= 4 { planes.len() } else { (planes.len() as f64).sqrt().ceil() as usize };
    let cell = [a.mean.width() + GAP, a.mean.height() + GAP];
    let width = columns * cell[0] - GAP;
    let height = planes.len().div_ceil(columns) * cell[1] - GAP;
    let mut pixels = vec![NOTHING; width * height];
    for (index, (pair, values)) in planes.iter().enumerate() {
        let corner = index / columns * cell[1] * width + index % columns * cell[0];
        for (i, value) in pair.pixels().zip(values) {
            let place = corner + i / a.mean.width() * width + i % a.mean.width();
            pixels[place] = value.map_or(NON_FINITE, |value| colour(value / range));
        }
    }
    Ok(FalseColour { width, height, pixels, shown, range })
}

/// Values that the colours show, one for every pixel; `None` where it is no number.
fn values(pair: &Pair<'_>, shown: Shown, epsilon: f64) -> Vec<Option<f64>> {
    let mean_b = pair.finite_pixels().map(|i| pair.b(i)).sum::<f64>() / pair.finite_pixels().count() as f64;
    let value = |i| match shown {
        Shown::ZScores => pair.z(i).unwrap_or(0.0),
        Shown::RelativeDifference => relative_difference(pair, i, mean_b, epsilon),
    };
    pair.pixels().map(|i| pair.is_finite(i).then(|| value(i))).collect()
}

/// Twice the root mean square, rounded up to 1, 2 or 5 times a power of ten; 1 where there are no differences.
fn round_range(planes: &[(&Pair<'_>, Vec<Option<f64>>)]) -> f64 {
    let finite = planes.iter().flat_map(|(_, values)| values).flatten().filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    let twice = 2.0 * (sum / f64::max(count, 1.0)).sqrt();
    if twice == 0.0 {
        return 1.0;
    }
    let power = 10f64.powf(twice.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|digit| digit * power).find(|&range| range >= twice).unwrap_or(10.0 * power)
}

/// Colour of a value from −1 to 1; values beyond have the colours of the ends.
fn colour(value: f64) -> [u8; 3] {
    let last = (BLUE_TO_RED.len() - 1) as f64;
    let place = (value.clamp(-1.0, 1.0) + 1.0) / 2.0 * last;
    let class = (place as usize).min(BLUE_TO_RED.len() - 2);
    let t = place - class as f64;
    let mix = |c: usize| f64::from(BLUE_TO_RED[class][c]) * (1.0 - t) + f64::from(BLUE_TO_RED[class + 1][c]) * t;
    [0, 1, 2].map(|c| mix(c).round() as u8)
}

#[cfg(test)]
mod tests {
    use rstest::rstest;

    use super::*;
    use crate::validation::compared_image::tests::image;

    const BLUE: [u8; 3] = [5, 48, 97];
    const WHITE: [u8; 3] = [247, 247, 247];
    const RED: [u8; 3] = [103, 0, 31];

    #[test]
    fn colours_go_from_blue_through_white_to_red() {
        let colours = [-1e9, -1.0, -0.2, 0.0, 0.1, 1.0, f64::INFINITY].map(colour);
        // Halfway between the middle and the class beside it: (247 + 253)/2, (247 + 219)/2, (247 + 199)/2.
        assert_eq!(colours, [BLUE, BLUE, [209, 229, 240], WHITE, [250, 233, 223], RED, RED]);
    }

    #[test]
    fn z_scores_are_shown_where_variances_are_known() {
        let a = image(3, 1, &[("R", &[1.0, 9.0, 5.0]), ("G", &[5.0, 5.0, f32::NAN])]);
        let a = a.with_variances(&[("R", &[1.0, 1.0, 0.0]), ("G", &[0.0, 1.0, 1.0])]);
        let b = image(3, 1, &[("R", &[5.0, 5.0, 5.0]), ("G", &[4.0, 5.0, 5.0])]).with_constant_variance(0.0);
        let shown = false_colour(&a, &b, &ComparisonSettings::default(), None).expect("comparable");
        assert_eq!((shown.shown, shown.range, shown.width, shown.height), (Shown::ZScores, 4.0, 3 + 4 + 3, 1));
        let gap = [NOTHING; 4];
        let expected = [&[BLUE, RED, WHITE], &gap[..], &[RED, WHITE, NON_FINITE]].concat();
        assert_eq!(shown.pixels, expected);
    }

    #[test]
    fn without_variances_relative_differences_are_shown() {
        let a = image(2, 1, &[("Y", &[1.5, 1.0])]);
        let b = image(2, 1, &[("Y", &[1.0, 1.0])]);
        let exact = ComparisonSettings { epsilon: 0.0, ..ComparisonSettings::default() };
        let shown = false_colour(&a, &b, &exact, None).expect("comparable");
        // 2·√(0.5²/2) = 0.71.
        assert_eq!((shown.shown, shown.range), (Shown::RelativeDifference, 1.0));
        let shown = false_colour(&a, &b, &exact, Some(0.5)).expect("comparable");
        assert_eq!(shown.pixels, [RED, WHITE]);
        assert_eq!(false_colour(&b, &b, &exact, None).expect("comparable").pixels, [WHITE, WHITE]);
    }

    #[rstest]
    #[case(1, 1, 1)]
    #[case(4, 4, 1)]
    #[case(5, 3, 2)]
    #[case(75, 9, 9)]
    fn many_channels_stand_in_a_grid(#[case] channels: usize, #[case] columns: usize, #[case] rows: usize) {
        let names: Vec<String> = (0..channels).map(|i| i.to_string()).collect();
        let planes: Vec<(&str, &[f32])> = names.iter().map(|name| (&name[..], &[0.0; 6][..])).collect();
        let black = image(3, 2, &planes);
        let shown = false_colour(&black, &black, &ComparisonSettings::default(), None).expect("comparable");
        assert_eq!((shown.width, shown.height), (7 * columns - 4, 6 * rows - 4));
        let white = shown.pixels.iter().filter(|&&pixel| pixel == WHITE).count();
        assert_eq!(white, 6 * channels);
    }
}
