//! Measured patterns, for a twin of this very camera.

use super::decomposition::Decomposition;
use super::frame_stack::Parts;
use super::linearity::Bend;
use super::measured::Measured;
use super::patterns::{Averages, Patterns};

/// Patterns of the pixels but for defective ones, with the shading of the flats.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatternMaps {
    /// Response of each pixel over the mean of all; `None` without flats.
    pub response: Option<PatternMap>,
    /// Offset of each pixel's dark signal from the mean of all, at no exposure time where that is known, DN.
    pub dark_dn: PatternMap,
}

/// Pattern of the pixels, as averaged images tell it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatternMap {
    /// Values row by row.
    pub values: Vec<f32>,
    /// Correlation of single pixels with the camera's own, as the noise that averaging leaves allows it; 0 where
    /// the averages tell no pixel from another.
    pub correlation: f64,
}

impl PatternMaps {
    /// Patterns of averages in which defective pixels are mended: defects are figures of their own.
    pub(super) fn new(averages: &Averages, patterns: &Patterns, bend: Option<Bend>, size: [usize; 2]) -> Self {
        let (image, noise) = averages.offsets(patterns);
        let dark_dn = Found { image: &image, noise, pattern: patterns.offsets(), size }.map(|_, d| d);
        let response = averages.response.as_ref().zip(patterns.response.as_ref()).map(|((image, noise), pattern)| {
            let scale = |mean: f64| bend.map_or(mean, |bend| bend.scale_of_deviations(mean));
            Found { image, noise: *noise, pattern: pattern.variances, size }.map(|mean, d| 1.0 + d / scale(mean))
        });
        Self { response, dark_dn }
    }
}

/// Averaged image, the variances that noise left in it, and those of the pattern.
struct Found<'a> {
    image: &'a [f64],
    noise: Parts,
    pattern: Parts,
    size: [usize; 2],
}

impl Found<'_> {
    /// Deviations d of the pixels from the mean as `value` (mean, d). Deviations of rows, columns and pixels have a variance
    /// s² + σ² of pattern and remaining noise; times √(s²/(s² + σ²)), which is also their correlation with the
    /// camera's own, they vary as the pattern does.
    fn map(&self, value: impl Fn(f64, f64) -> f64) -> PatternMap {
        let share = |pattern: Measured, noise: Measured| match pattern.root() {
            Ok(_) => (pattern.value / (pattern.value + noise.value)).sqrt(),
            Err(_) => 0.0,
        };
        let (s, sigma) = (&self.pattern, &self.noise);
        let shares = [share(s.row, sigma.row), share(s.column, sigma.column), share(s.pixel, sigma.pixel)];
        let parts = Decomposition::of(self.image, self.size);
        let of = |d: f64| value(parts.mean, d) as f32;
        let values = (0..self.image.len()).map(|i| of(parts.weighted(i, shares))).collect();
        PatternMap { values, correlation: shares[2] }
    }
}
