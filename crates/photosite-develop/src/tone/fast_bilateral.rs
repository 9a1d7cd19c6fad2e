//! A bilateral filter of large windows ([Durand02](photosite_core::references#durand02), section 5).
//!
//! For a level l all pixels have weights g(v − l), g being the Gaussian of differences, so that a Gaussian in space of
//! g·v over one of g is the filter's result at every pixel of the value l. Pixels between two levels take the result in
//! proportion to how near they lie. Levels are σ_r/4 apart: a straight line between results that bend by no more than
//! 1/σ_r misses them by σ_r/128 at most. The Gaussians in space are taken of means of blocks, which are σ_s/4 wide at
//! most and add (σ_s/4)²/12 to the variance σ_s², 0.5 %.

use photosite_core::rows::for_each_row;

use crate::window::{gaussian_weights, separable};

/// The filter's result, for a plane of finite numbers and standard deviations in pixels and in the plane's unit.
pub(super) fn smoothed(plane: &[f32], size: [usize; 2], sigma_px: f64, sigma_range: f64) -> Vec<f32> {
    let low = plane.iter().copied().fold(f32::INFINITY, f32::min);
    let high = plane.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    if low >= high {
        return plane.to_vec();
    }
    let levels = (f64::from(high - low) / (0.25 * sigma_range)).ceil() as usize;
    let spacing = (high - low) / levels as f32;
    let block = ((sigma_px / 4.0) as usize).max(1);
    let blocks = size.map(|side| side.div_ceil(block));
    let sigma = sigma_px / block as f64;
    let weights = gaussian_weights(sigma, (3.0 * sigma).ceil() as usize);
    let range = -0.5 / (sigma_range * sigma_range) as f32;
    let mut result = vec![0.0; plane.len()];
    for level in (0..=levels).map(|i| low + i as f32 * spacing) {
        let like = |value: f32| (range * (value - level).powi(2)).exp();
        let near = separable(&means(plane, size, block, like), blocks, [&weights; 2]);
        let sums = separable(&means(plane, size, block, |value| value * like(value)), blocks, [&weights; 2]);
        for_each_row(&mut result, size[0], |y, to| {
            for (x, (to, value)) in to.iter_mut().zip(&plane[y * size[0]..]).enumerate() {
                let share = 1.0 - (value - level).abs() / spacing;
                if share > 0.0 {
                    let at = [x, y].map(|i| (i as f32 + 0.5) / block as f32 - 0.5);
                    *to += share * between(&sums, blocks, at) / between(&near, blocks, at);
                }
            }
        });
    }
    result
}

/// Means over square blocks of what `number` makes of the values; those at the edges may be cut off.
fn means(plane: &[f32], [width, height]: [usize; 2], block: usize, number: impl Fn(f32) -> f32 + Sync) -> Vec<f32> {
    let mut result = vec![0.0; width.div_ceil(block) * height.div_ceil(block)];
    for_each_row(&mut result, width.div_ceil(block), |y, to| {
        let from = &plane[y * width * block..];
        let from = &from[..from.len().min(width * block)];
        for row in from.chunks(width) {
            to.iter_mut()
                .zip(row.chunks(block))
                .for_each(|(to, part)| *to += part.iter().map(|v| number(*v)).sum::<f32>());
        }
        let in_column = from.len() / width;
        for (x, to) in to.iter_mut().enumerate() {
            *to /= (in_column * block.min(width - x * block)) as f32;
        }
    });
    result
}

/// The value between four blocks, whose centres lie at whole coordinates; beyond the last that of the last.
fn between(plane: &[f32], [width, height]: [usize; 2], [x, y]: [f32; 2]) -> f32 {
    let split = |place: f32, n: usize| {
        let place = place.clamp(0.0, (n - 1) as f32);
        let first = place as usize;
        (first, (first + 1).min(n - 1), place - first as f32)
    };
    let ((left, right, s), (top, bottom, t)) = (split(x, width), split(y, height));
    let row = |y: usize| plane[y * width + left] * (1.0 - s) + plane[y * width + right] * s;
    row(top) * (1.0 - t) + row(bottom) * t
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::window::mirror;

    /// The sum of the definition.
    fn exact(plane: &[f32], [width, height]: [usize; 2], sigma_px: f64, sigma_range: f64) -> Vec<f32> {
        let r = (3.0 * sigma_px).ceil() as usize;
        let of = |i: usize| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (dy, dx) in (0..=2 * r).flat_map(|dy| (0..=2 * r).map(move |dx| (dy, dx))) {
                let j = mirror(i / width + dy, r, height) * width + mirror(i % width + dx, r, width);
                let square = (dx as f64 - r as f64).powi(2) + (dy as f64 - r as f64).powi(2);
                let difference = f64::from(plane[j] - plane[i]);
                let weight = (-0.5 * (square / sigma_px.powi(2) + (difference / sigma_range).powi(2))).exp();
                (sum, weights) = (sum + weight * f64::from(plane[j]), weights + weight);
            }
            (sum / weights) as f32
        };
        (0..plane.len()).map(of).collect()
    }

    #[test]
    fn the_fast_way_is_near_the_sum() {
        let size = [60, 50];
        let value = |i: usize| {
            let (x, y) = ((i % 60) as f32, (i / 60) as f32);
            (if x > 30.0 { 1.5 } else { 0.0 }) + 0.2 * (0.9 * x).sin() * (0.7 * y).cos()
        };
        let plane: Vec<f32> = (0..60 * 50).map(value).collect();
        for (sigma_px, tolerance) in [(3.0, 0.4 / 128.0), (9.0, 0.02)] {
            let fast = smoothed(&plane, size, sigma_px, 0.4);
            let sum = exact(&plane, size, sigma_px, 0.4);
            let apart = fast.iter().zip(&sum).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart < tolerance, "sigma {sigma_px}: {apart}");
        }
    }
}
