//! What curves ask of the luminances of a picture.

/// Luminance that counts as black where logarithms are taken, white at 1.
const BLACK: f32 = 1e-6;

/// exp(mean of ln L): the luminance that a picture's parts lie around evenly, by their ratios.
pub(super) fn logarithmic_mean(light: &[f32]) -> f64 {
    let sum: f64 = light.iter().map(|value| f64::from(value.max(BLACK)).ln()).sum();
    (sum / light.len() as f64).exp()
}

/// The largest luminance.
pub(super) fn brightest(light: &[f32]) -> f32 {
    light.iter().copied().fold(0.0, f32::max)
}
