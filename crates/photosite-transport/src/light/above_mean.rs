//! Directions of an environment that are worth sampling.

/// The weights of the cells of a grid of directions by what exceeds the mean over all directions, and the part of all
/// light that exceeds it, 0–1: light sampling takes that part, and samples of the BSDF find the rest. Luminances come row
/// by row, with the sine of each row's angle from the pole.
pub(super) fn above_mean(luminances: &[f64], sines: &[f64]) -> (Vec<f32>, f64) {
    let width = luminances.len() / sines.len();
    let all = luminances.chunks(width).zip(sines).map(|(row, sine)| row.iter().sum::<f64>() * sine).sum::<f64>();
    let mean = all / (width as f64 * sines.iter().sum::<f64>());
    let above = |(i, luminance): (usize, &f64)| (luminance - mean).max(0.0) * sines[i / width];
    let weights: Vec<f32> = luminances.iter().enumerate().map(|cell| above(cell) as f32).collect();
    let excess = weights.iter().map(|&weight| f64::from(weight)).sum::<f64>() / all;
    // The rest that rounding leaves of an image of one colour is not worth a sample.
    (weights, if excess > 1e-4 { excess } else { 0.0 })
}
