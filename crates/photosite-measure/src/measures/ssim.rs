//! Structural similarity of two images ([Wang04](photosite_core::references#wang04)).

/// Standard deviation of the window's weights, pixels.
const SIGMA: f64 = 1.5;
/// Pixels from the middle of the window to its edge.
const RADIUS: usize = 5;

/// Mean structural similarity of two planes of one size, 1 where they are the same; `None` where they are smaller than
/// the window of 11 × 11 pixels.
///
/// SSIM = (2μₐμ_b + c₁)(2σ_ab + c₂)/((μₐ² + μ_b² + c₁)(σₐ² + σ_b² + c₂)), with means, variances and covariance under a
/// Gaussian window, c₁ = (0.01·L)², c₂ = (0.03·L)² and L the range of values; the mean is over windows that lie in the
/// image.
pub fn ssim(a: &[f32], b: &[f32], [width, height]: [usize; 2], range: f64) -> Option<f64> {
    let side = 2 * RADIUS + 1;
    if width < side || height < side || a.len() != width * height || b.len() != a.len() {
        return None;
    }
    let weights: Vec<f64> = (0..side).map(|i| (-0.5 * ((i as f64 - RADIUS as f64) / SIGMA).powi(2)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let weights: Vec<f64> = weights.iter().map(|w| w / sum).collect();
    let (c1, c2) = ((0.01 * range).powi(2), (0.03 * range).powi(2));
    // Moments of a row of windows: first down the columns, then along the row.
    let columns = |y: usize| -> Vec<[f64; 5]> {
        (0..width)
            .map(|x| {
                let mut moments = [0.0; 5];
                for (k, w) in weights.iter().enumerate() {
                    let (a, b) = (f64::from(a[(y + k) * width + x]), f64::from(b[(y + k) * width + x]));
                    for (moment, value) in moments.iter_mut().zip([a, b, a * a, b * b, a * b]) {
                        *moment += w * value;
                    }
                }
                moments
            })
            .collect()
    };
    let mut total = 0.0;
    for y in 0..=height - side {
        let columns = columns(y);
        for x in 0..=width - side {
            let mut moments = [0.0; 5];
            for (column, w) in columns[x..x + side].iter().zip(&weights) {
                moments.iter_mut().zip(column).for_each(|(moment, value)| *moment += w * value);
            }
            let [mean_a, mean_b, aa, bb, ab] = moments;
            let (variance_a, variance_b) = (aa - mean_a * mean_a, bb - mean_b * mean_b);
            let covariance = ab - mean_a * mean_b;
            total += (2.0 * mean_a * mean_b + c1) * (2.0 * covariance + c2)
                / ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
        }
    }
    Some(total / ((width - side + 1) * (height - side + 1)) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_is_1_and_even_planes_differ_by_their_means() {
        let plane: Vec<f32> = (0..20 * 15).map(|i| ((i * 37) % 101) as f32).collect();
        assert!((ssim(&plane, &plane, [20, 15], 100.0).expect("large enough") - 1.0).abs() < 1e-12);
        // Even planes have no variance: what is left is (2ab + c₁)/(a² + b² + c₁), here with c₁ = 1.
        let found = ssim(&[30.0; 300], &[60.0; 300], [20, 15], 100.0).expect("large enough");
        assert!((found - (2.0 * 1800.0 + 1.0) / (900.0 + 3600.0 + 1.0)).abs() < 1e-9, "{found}");
        assert_eq!(ssim(&[0.0; 100], &[0.0; 100], [10, 10], 1.0), None);
    }

    #[test]
    fn the_opposite_is_negative() {
        let plane: Vec<f32> = (0..400).map(|i| if (i % 20 + i / 20) % 2 == 0 { 40.0 } else { 60.0 }).collect();
        let opposite: Vec<f32> = plane.iter().map(|v| 100.0 - v).collect();
        // Variance 100 about the mean of 50, covariance −100, c₂ = 9.
        let found = ssim(&plane, &opposite, [20, 20], 100.0).expect("large enough");
        assert!((found + 191.0 / 209.0).abs() < 1e-2, "{found}");
    }
}
