//! Images of the same light, taken apart into what changes from image to image and what stays, each for pixels, rows
//! and columns.

use photosite_core::Invalid;

use super::measured::Measured;

/// Variances of three kinds that add up: of each pixel for itself, of rows and of columns as a whole; DN².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parts {
    /// Single pixels.
    pub pixel: Measured,
    /// Whole rows.
    pub row: Measured,
    /// Whole columns.
    pub column: Measured,
}

impl Parts {
    /// The parts with a function applied to each.
    pub(super) fn map(self, f: impl Fn(Measured) -> Measured) -> Self {
        Self { pixel: f(self.pixel), row: f(self.row), column: f(self.column) }
    }

    /// The parts of the sum of two independent images.
    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            pixel: self.pixel.plus(other.pixel),
            row: self.row.plus(other.row),
            column: self.column.plus(other.column),
        }
    }
}

/// Sums over images of the same light, filled one image after the other.
#[derive(Clone, Debug)]
pub(super) struct FrameStack {
    size: [usize; 2],
    /// Σ y and Σ y² of each pixel.
    sums: Vec<u32>,
    squares: Vec<u64>,
    /// Σ y of each image.
    totals: Vec<u64>,
    /// Σ over images of the squared sums of rows, and of columns.
    row_squares: u128,
    column_squares: u128,
    /// Numbers that are the converter's largest.
    clipped: u64,
    largest: u16,
}

/// Statistics of a stack, DN and DN².
#[derive(Clone, Debug, PartialEq)]
pub struct StackStatistics {
    /// Number of images.
    pub images: usize,
    /// Mean of all pixels. Its error is that of temporal noise alone.
    pub mean: Measured,
    /// Variance of temporal noise.
    pub temporal: Parts,
    /// Means of the single images.
    pub image_means: Vec<f64>,
    /// Standard error of the mean of one image.
    pub image_mean_error: f64,
    /// Part of the numbers that are the largest of the converter.
    pub clipped: f64,
}

impl StackStatistics {
    /// Images of the stack whose means differ most, the difference in DN and its standard error.
    pub(super) fn drift(&self) -> (usize, usize, f64, f64) {
        let at = |order: fn(&f64, &f64) -> bool| {
            let means = self.image_means.iter().enumerate();
            means.reduce(|best, next| if order(next.1, best.1) { next } else { best }).map_or(0, |(i, _)| i)
        };
        let (low, high) = (at(|a, b| a < b), at(|a, b| a > b));
        let error = 2f64.sqrt() * self.image_mean_error;
        (low, high, self.image_means[high] - self.image_means[low], error)
    }
}

impl FrameStack {
    /// An empty stack of images of this size; `largest` is the largest number of the converter.
    pub(super) fn new(size: [usize; 2], largest: u16) -> Self {
        let pixels = size[0] * size[1];
        Self {
            size,
            sums: vec![0; pixels],
            squares: vec![0; pixels],
            totals: Vec::new(),
            row_squares: 0,
            column_squares: 0,
            clipped: 0,
            largest,
        }
    }

    /// Adds an image of the stack's size.
    pub(super) fn add(&mut self, image: &[u16]) -> Result<(), Invalid> {
        const MOST: usize = 1 << 16;
        let [width, height] = self.size;
        if image.len() != width * height {
            return Err(Invalid::new("", format!("{} pixels instead of {width} × {height}", image.len())));
        }
        if self.totals.len() == MOST {
            return Err(Invalid::new("", format!("a stack holds at most {MOST} images")));
        }
        let mut columns = vec![0u64; width];
        let mut total = 0;
        let lines = image.chunks_exact(width);
        let sums = self.sums.chunks_exact_mut(width).zip(self.squares.chunks_exact_mut(width));
        for (line, (sums, squares)) in lines.zip(sums) {
            let mut row = 0u64;
            for (x, &y) in line.iter().enumerate() {
                sums[x] += u32::from(y);
                squares[x] += u64::from(y).pow(2);
                columns[x] += u64::from(y);
                row += u64::from(y);
                self.clipped += u64::from(y >= self.largest);
            }
            self.row_squares += u128::from(row).pow(2);
            total += row;
        }
        self.column_squares += columns.iter().map(|&sum| u128::from(sum).pow(2)).sum::<u128>();
        self.totals.push(total);
        Ok(())
    }

    /// Number of images.
    pub(super) fn count(&self) -> usize {
        self.totals.len()
    }

    /// Average image, DN, row by row.
    pub(super) fn average(&self) -> Vec<f64> {
        let count = self.count().max(1) as f64;
        self.sums.iter().map(|&sum| f64::from(sum) / count).collect()
    }

    /// Sample variance of every pixel over the images, DN².
    pub(super) fn pixel_variances(&self) -> impl Iterator<Item = f64> {
        let count = self.count() as u64;
        let scale = 1.0 / (count * (count - 1)).max(1) as f64;
        let of_pixel = move |(&sum, &squares): (&u32, &u64)| (count * squares - u64::from(sum).pow(2)) as f64 * scale;
        self.sums.iter().zip(&self.squares).map(of_pixel)
    }

    /// Temporal variances of at least two images of at least 3 × 3 pixels, as an analysis of variance of images × rows ×
    /// columns finds them. With y_lij, a dot for the mean over an index, and L images, M rows, N columns:
    ///
    /// - rows from image to image: MS_r = N·Σ(y_li· − y_·i· − y_l·· + y_···)²/((L − 1)(M − 1)), expected N·σ²_row + σ²
    /// - columns alike: MS_c, expected M·σ²_column + σ²
    /// - what is left, MS_e, has (L − 1)(M − 1)(N − 1) degrees of freedom and expects σ².
    ///
    /// Mean squares are independent; one of f degrees of freedom has a relative standard error of √(2/f) for normal
    /// noise. That of MS_e follows how the pixels' variances spread, heavy tails and unequal pixels included.
    pub(super) fn statistics(&self) -> Result<StackStatistics, Invalid> {
        let [width, height] = self.size;
        let images = self.count();
        if images < 2 || width < 3 || height < 3 {
            let message = format!("{images} images of {width} × {height} pixels tell no noise");
            return Err(Invalid::new("", message).help("take at least two images of at least 3 × 3 pixels"));
        }
        let [l, m, n] = [images, height, width].map(|count| count as f64);
        let pixels = m * n;
        // Whole numbers, so that nothing cancels.
        let int = |count: usize| count as i128;
        let of_images: i128 = self.totals.iter().map(|&total| int(total as usize).pow(2)).sum();
        let all: i128 = int(self.totals.iter().sum::<u64>() as usize).pow(2);
        let (mut rows, mut columns, mut each) = (0, vec![0u64; width], 0i128);
        for line in self.sums.chunks_exact(width) {
            rows += int(line.iter().map(|&sum| u64::from(sum)).sum::<u64>() as usize).pow(2);
            columns.iter_mut().zip(line).for_each(|(column, &sum)| *column += u64::from(sum));
            each += line.iter().map(|&sum| i128::from(sum).pow(2)).sum::<i128>();
        }
        let columns: i128 = columns.iter().map(|&sum| int(sum as usize).pow(2)).sum();
        let squares: i128 = self.squares.iter().map(|&y| i128::from(y)).sum();
        // Of k lines of a direction: k·L·(…), over the number of pixels of a line and k·L.
        let interaction = |by_image: u128, by_line: i128, lines: usize, length: f64| {
            let (l, k) = (int(images), int(lines));
            let exact = l * k * by_image as i128 - k * by_line - l * of_images + all;
            exact as f64 / (length * l as f64 * k as f64)
        };
        let of_rows = interaction(self.row_squares, rows, height, n);
        let of_columns = interaction(self.column_squares, columns, width, m);
        let between = (int(images) * of_images - all) as f64 / (l * pixels);
        let within = (int(images) * squares - each) as f64 / l;
        let freedom = (l - 1.0) * (m - 1.0) * (n - 1.0);
        let pixel = ((within - between - of_rows - of_columns) / freedom).max(0.0);
        let mut pixel = mean_square(pixel * freedom, freedom);
        let row = mean_square(of_rows, (l - 1.0) * (m - 1.0)).minus(pixel).times(1.0 / n);
        let column = mean_square(of_columns, (l - 1.0) * (n - 1.0)).minus(pixel).times(1.0 / m);
        let shared = row.value.max(0.0) + column.value.max(0.0);
        pixel.standard_error = self.error_of_pixels(pixel.value, shared, between / (l - 1.0) / pixels);
        let of_mean = pixel.value / pixels + row.value.max(0.0) / m + column.value.max(0.0) / n;
        let image_means: Vec<f64> = self.totals.iter().map(|&total| total as f64 / pixels).collect();
        Ok(StackStatistics {
            images,
            mean: Measured::new(image_means.iter().sum::<f64>() / l, (of_mean / l).sqrt()),
            temporal: Parts { pixel, row, column },
            image_means,
            image_mean_error: of_mean.sqrt(),
            clipped: self.clipped as f64 / (pixels * l),
        })
    }

    /// Standard error of the variance σ² of pixels, from the variance V of their sample variances over n pixels: √(V/n),
    /// less what noise that they share (σ_s²) and images that differ as a whole (σ_i²) add to V. Of normal noise it is
    ///
    /// V = 2·(σ² + σ_s²)²/(L − 1) + 4·σ²·σ_i²/(L − 1).
    fn error_of_pixels(&self, variance: f64, shared: f64, between_images: f64) -> f64 {
        let pixels = self.sums.len() as f64;
        let mean = self.pixel_variances().sum::<f64>() / pixels;
        let spread = self.pixel_variances().map(|v| (v - mean).powi(2)).sum::<f64>() / (pixels - 1.0);
        let freedom = (self.count() - 1) as f64;
        let normal = 2.0 * variance.powi(2) / freedom;
        let expected = 2.0 * (variance + shared).powi(2) / freedom + 4.0 * variance * between_images.max(0.0) / freedom;
        // Light tails, as of few levels, take some away; but never most of it.
        ((normal + spread - expected).max(0.25 * normal) / pixels).sqrt()
    }
}

/// Mean square of a sum of squares of normal numbers.
pub(super) fn mean_square(sum: f64, freedom: f64) -> Measured {
    let value = sum.max(0.0) / freedom;
    Measured::new(value, value * (2.0 / freedom).sqrt())
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    #[test]
    fn parts_of_temporal_noise_are_told_apart() {
        const SIZE: [usize; 2] = [120, 80];
        let [row, column, pixel] = [5.0, 8.0, 20.0];
        let normal = |key: u64, i: usize| Philox::new(key, i as u64).sample::<f64, _>(StandardNormal);
        let mut stack = FrameStack::new(SIZE, 4095);
        for image in 0..6u64 {
            let value = |i: usize| {
                let [x, y] = [i % SIZE[0], i / SIZE[0]];
                // A fixed pattern and an offset of each image, which both count for nothing.
                let fixed = 2000.0 + 60.0 * normal(1, i) + 30.0 * normal(2, y) + 10.0 * image as f64;
                let [a, b, c] = [0, 1, 2].map(|part| 100 + 3 * image + part);
                (fixed + row * normal(a, y) + column * normal(b, x) + pixel * normal(c, i)).round() as u16
            };
            stack.add(&(0..SIZE[0] * SIZE[1]).map(value).collect::<Vec<u16>>()).expect("fits");
        }
        let found = stack.statistics().expect("images");
        for (part, expected, relative) in [
            // √(2/(5·79·119)), √(2/(5·79)) and √(2/(5·119)) of the mean squares.
            (found.temporal.pixel, 400.0 + 1.0 / 12.0, 0.0065),
            (found.temporal.row, 25.0, 0.071 * (25.0 + 400.0 / 120.0) / 25.0),
            (found.temporal.column, 64.0, 0.058 * (64.0 + 400.0 / 80.0) / 64.0),
        ] {
            assert!((part.value - expected).abs() < 4.0 * part.standard_error, "{part:?} instead of {expected}");
            let told = part.standard_error / expected;
            assert!((told / relative - 1.0).abs() < 0.3, "standard error {told} instead of {relative}");
        }
        let (low, high, drift, error) = found.drift();
        assert_eq!((low, high), (0, 5));
        assert!((drift - 50.0).abs() < 5.0 * error && error < 2.0, "{drift} ± {error}");
    }

    #[test]
    fn pairs_by_hand() {
        // Differences of 2, −2, … leave neither rows nor columns nor a shift: each pixel has a variance of 2.
        let mut stack = FrameStack::new([4, 4], 15);
        let sign = |i: usize| if (i / 4 + i % 4).is_multiple_of(2) { 1 } else { -1 };
        stack.add(&[10; 16]).expect("fits");
        stack.add(&(0..16).map(|i| (10 + 2 * sign(i)) as u16).collect::<Vec<_>>()).expect("fits");
        let found = stack.statistics().expect("a pair");
        // Σ of squares 16·2 over 9 degrees of freedom.
        assert!((found.temporal.pixel.value - 32.0 / 9.0).abs() < 1e-12, "{found:?}");
        assert_eq!((found.mean.value, found.clipped), (10.0, 0.0));
        assert!(FrameStack::new([4, 4], 15).statistics().is_err());
    }
}
