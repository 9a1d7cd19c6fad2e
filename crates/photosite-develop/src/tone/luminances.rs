//! Statistics of an image's luminances for tone curves.

/// Luminance that counts as black where logarithms are taken, white at 1.
const BLACK: f32 = 1e-6;

/// Noise of black: the distance below 0 of the lowest thousandth of the pixels; 0 where they are not below. Light has
/// nothing below black, so that what lies as little above it is noise as well, whose logarithms say nothing.
pub(super) fn noise_of_black(luminance: &[f32]) -> f32 {
    let mut values: Vec<f32> = luminance.iter().copied().filter(|value| value.is_finite()).collect();
    let lowest = values.len() / 1000;
    if values.is_empty() {
        return 0.0;
    }
    (-*values.select_nth_unstable_by(lowest, f32::total_cmp).1).max(0.0)
}

/// Logarithmic mean exp(mean of ln L): the luminance that an image's parts lie around evenly, by their ratios. What is
/// darker than `black` counts as that.
pub(super) fn logarithmic_mean(light: &[f32], black: f32) -> f64 {
    let black = black.max(BLACK);
    let sum: f64 = light.iter().map(|value| f64::from(value.max(black)).ln()).sum();
    (sum / light.len() as f64).exp()
}

/// The largest luminance.
pub(super) fn brightest(light: &[f32]) -> f32 {
    light.iter().copied().fold(0.0, f32::max)
}
