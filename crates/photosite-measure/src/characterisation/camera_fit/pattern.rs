//! The fixed pattern of an averaged image: variances of pixels, rows and columns, and the shading that is no pattern.

use super::decomposition::Decomposition;
use super::frame_stack::{Parts, mean_square};
use super::measured::Measured;

/// Fixed pattern of an averaged image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pattern {
    /// Variances, without what temporal noise has left in the average.
    pub variances: Parts,
    /// Mean of the image with the error that the pattern leaves: that of the mean of all pixels that could be.
    pub mean: Measured,
    /// Deviation of the smooth part from the mean, largest minus smallest: shading of the light or the lens.
    pub shading: f64,
    /// Whether the shading is more than the pattern's own chance.
    pub is_shaded: bool,
}

impl Pattern {
    /// Pattern of an image, DN, whose temporal noise left these variances in it. With the image's mean squares of
    /// rows, columns and the rest (MS_R, MS_C, MS_P of M rows and N columns) after its smooth part is subtracted,
    ///
    /// s²_pixel = MS_P − σ²_pixel, s²_row = (MS_R − MS_P)/N − σ²_row, s²_column = (MS_C − MS_P)/M − σ²_column.
    ///
    /// The smooth part is a polynomial in x and y, orthogonal over the pixels: it costs each mean square a few degrees
    /// of freedom.
    pub(super) fn of(image: &[f64], size: [usize; 2], noise: Parts) -> Self {
        let parts = Decomposition::of(image, size);
        let Decomposition { rows, columns, mean, row_means, column_means, .. } = &parts;
        let (m, n) = (size[1] as f64, size[0] as f64);
        let pixels = m * n;
        let (low, high) = (0..image.len())
            .map(|i| parts.smooth(i))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s), high.max(s)));

        let [of_rows, of_columns, of_pixels] = parts.rough();
        let freedom = [m - 1.0 - rows.degrees(), n - 1.0 - columns.degrees()];
        let row_square = mean_square(n * of_rows.map(|value| value * value).sum::<f64>(), freedom[0]);
        let column_square = mean_square(m * of_columns.map(|value| value * value).sum::<f64>(), freedom[1]);
        let squares = of_pixels.map(|value| value * value);
        let (sum, fourth) = squares.fold((0.0, 0.0), |(sum, fourth), square| (sum + square, fourth + square * square));
        let rest_freedom = (m - 1.0) * (n - 1.0) - rows.degrees() * columns.degrees();
        let spread = (fourth / pixels - (sum / pixels).powi(2)).max(0.0).sqrt();
        let pixel_square = Measured::new(sum / rest_freedom, spread / pixels.sqrt());
        let variances = Parts {
            pixel: pixel_square.minus(noise.pixel),
            row: row_square.minus(pixel_square).times(1.0 / n).minus(noise.row),
            column: column_square.minus(pixel_square).times(1.0 / m).minus(noise.column),
        };
        let of_mean = pixel_square.value / pixels
            + (row_square.value - pixel_square.value).max(0.0) / pixels
            + (column_square.value - pixel_square.value).max(0.0) / pixels;
        // A smooth term takes a mean square of the pattern by chance; 24 terms of normal numbers reach 5 σ never.
        let by_chance = row_square.value.max(column_square.value).max(pixel_square.value);
        let largest_term = rows.largest_term(row_means, n).max(columns.largest_term(column_means, m));
        Self {
            variances,
            mean: Measured::new(*mean, of_mean.sqrt()),
            shading: if high > low { high - low } else { 0.0 },
            is_shaded: largest_term > 25.0 * by_chance,
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    const SIZE: [usize; 2] = [160, 120];

    fn image(shading: f64) -> Vec<f64> {
        let normal = |key: u64, i: usize| Philox::new(key, i as u64).sample::<f64, _>(StandardNormal);
        let value = |i: usize| {
            let [x, y] = [i % SIZE[0], i / SIZE[0]];
            let [u, v] = [x as f64 / 80.0 - 1.0, y as f64 / 60.0 - 1.0];
            let light = 1.0 - shading * (u * u + v * v + 0.3 * u * v * v);
            1000.0 * light + 5.0 * normal(1, y) + 7.0 * normal(2, x) + 12.0 * normal(3, i)
        };
        (0..SIZE[0] * SIZE[1]).map(value).collect()
    }

    #[test]
    fn shading_is_no_pattern() {
        for shading in [0.0, 0.1] {
            let found = Pattern::of(&image(shading), SIZE, Parts::default());
            // √(2/f) of the mean squares of 19 000 pixels, 115 rows, 155 columns; 4 σ.
            for (part, expected) in
                [(found.variances.pixel, 144.0), (found.variances.row, 25.0), (found.variances.column, 49.0)]
            {
                assert!((part.value - expected).abs() < 4.0 * part.standard_error, "{part:?}: not {expected}");
                assert!(part.standard_error < 0.2 * expected, "{part:?}");
            }
            assert_eq!(found.is_shaded, shading > 0.0);
            if shading > 0.0 {
                // From 1000 at the middle to 0.77 of it at two of the corners.
                assert!((found.shading - 230.0).abs() < 20.0, "{}", found.shading);
            }
        }
    }

    #[test]
    fn noise_that_averaging_leaves_is_subtracted() {
        let noise =
            Parts { pixel: Measured::new(44.0, 1.0), row: Measured::new(5.0, 3.0), column: Measured::new(9.0, 4.0) };
        let [with, without] = [noise, Parts::default()].map(|noise| Pattern::of(&image(0.0), SIZE, noise).variances);
        let less = |part: fn(&Parts) -> Measured| part(&without).value - part(&with).value;
        for (found, expected) in [(less(|p| p.pixel), 44.0), (less(|p| p.row), 5.0), (less(|p| p.column), 9.0)] {
            assert!((found - expected).abs() < 1e-9);
        }
        assert!(with.row.standard_error > without.row.standard_error);
    }
}
