//! A normally distributed field of variance 1 whose values at pixels d apart are correlated by exp(−d²/(2ℓ²)).
//!
//! White noise is weighted along columns and rows by exp(−i²/ℓ²), whose correlation with itself is the one wanted: for
//! ℓ = 1 to within 0.03, from ℓ = 2 on to 1e-8. The white noise goes on beyond the edges, so that the field is the same
//! everywhere.

use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;

use super::streams::Streams;

/// Reach of the weights in correlation lengths, at which they have fallen to 5e-6.
const REACH: f64 = 3.5;

/// The field at width × height pixels.
pub(super) fn correlated_field(streams: Streams, [width, height]: [usize; 2], correlation_px: f64) -> Vec<f32> {
    let weights = weights(correlation_px);
    let reach = weights.len() / 2;
    // Rows of the image and those beyond its edges, weighted along rows.
    let rows: Vec<Vec<f32>> = (0..height + 2 * reach)
        .into_par_iter()
        .map(|row| {
            let y = row as i32 - reach as i32;
            let at = |x: usize| streams.pixel(x as i32 - reach as i32, y).sample::<f32, _>(StandardNormal);
            let white: Vec<f32> = (0..width + 2 * reach).map(at).collect();
            white.windows(weights.len()).map(|w| w.iter().zip(&weights).map(|(n, weight)| n * weight).sum()).collect()
        })
        .collect();
    let mut field = vec![0.0; width * height];
    field.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, to)| {
        for (row, weight) in rows[y..].iter().zip(&weights) {
            to.iter_mut().zip(row).for_each(|(sum, n)| *sum += n * weight);
        }
    });
    field
}

/// exp(−i²/ℓ²), with squares that sum to 1.
fn weights(correlation_px: f64) -> Vec<f32> {
    let reach = (REACH * correlation_px).ceil() as i32;
    let weight = |i: i32| if i == 0 { 1.0 } else { (-f64::from(i * i) / (correlation_px * correlation_px)).exp() };
    let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
    let scale = 1.0 / weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.iter().map(|w| (w * scale) as f32).collect()
}

#[cfg(test)]
mod tests {
    use super::super::streams::Kind;
    use super::*;

    #[test]
    fn the_correlation_of_the_weights_is_the_one_stated() {
        for (correlation_px, within) in [(1.0, 0.03), (2.0, 2e-5), (5.0, 2e-5)] {
            let weights = weights(correlation_px);
            for lag in 0..weights.len() {
                let found: f64 = weights[lag..].iter().zip(&weights).map(|(a, b)| f64::from(a * b)).sum();
                let expected = (-0.5 * (lag as f64 / correlation_px).powi(2)).exp();
                assert!((found - expected).abs() < within, "{correlation_px} {lag}: {found} for {expected}");
            }
        }
        assert_eq!(weights(0.0), [1.0]);
    }

    #[test]
    fn the_field_has_the_variance_1_and_no_edges() {
        let streams = Streams::new(3, Kind::FilmGrain, 0);
        let (width, height, correlation_px) = (300, 200, 2.0f64);
        let field = correlated_field(streams, [width, height], correlation_px);
        let variance = field.iter().map(|&n| f64::from(n * n)).sum::<f64>() / field.len() as f64;
        // Correlated pixels count less: Σ over all lags of ρ² is about π·ℓ² = 12.6; 5 standard errors.
        let error = (2.0 * std::f64::consts::PI * correlation_px.powi(2) / field.len() as f64).sqrt();
        assert!((variance - 1.0).abs() < 5.0 * error, "{variance}");
        // A smaller image is a part of it.
        let small = correlated_field(streams, [7, 5], correlation_px);
        for (y, row) in small.chunks(7).enumerate() {
            assert_eq!(row, &field[y * width..y * width + 7]);
        }
    }
}
