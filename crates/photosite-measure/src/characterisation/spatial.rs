//! Spatial non-uniformity from a stack of images of the same light: what stays when temporal noise is averaged out.

use photosite_core::Invalid;

/// Sums over a stack of images, filled one image after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct SpatialStack {
    width: usize,
    height: usize,
    /// Images added.
    count: u32,
    /// Σ y for each pixel, DN.
    sums: Vec<u32>,
    /// Σ y² over all pixels and images, DN².
    squares: u128,
}

/// Spatial variances of a stack, DN², corrected for the temporal noise that averaging leaves
/// ([Emva1288](photosite_core::references#emva1288) release 4.0, section on spatial nonuniformity).
///
/// With the average ⟨y⟩ of L images of M rows and N columns, its sample variance s²_measured and the mean σ²_stack of
/// the pixels' temporal variances,
///
/// - s² = s²_measured − σ²_stack/L
/// - s²_cav = Σ(column means − μ)²/N − σ²_stack/(L·M), s²_rav = Σ(row means − μ)²/M − σ²_stack/(L·N)
///
/// and as s² = s²_row + s²_col + s²_pixel, s²_cav = s²_col + s²_pixel/M, s²_rav = s²_row + s²_pixel/N, the parts
/// follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialVariances {
    /// μ_y, DN.
    pub mean: f64,
    /// σ²_stack, the mean temporal variance of a pixel.
    pub temporal: f64,
    /// Total s².
    pub total: f64,
    /// s²_row: each row deviates as a whole.
    pub row: f64,
    /// s²_col: each column deviates as a whole.
    pub column: f64,
    /// s²_pixel: each pixel deviates for itself.
    pub pixel: f64,
}

impl SpatialStack {
    /// An empty stack of images of this size.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, count: 0, sums: vec![0; width * height], squares: 0 }
    }

    /// Adds an image of the stack's size.
    pub fn add(&mut self, image: &[u16]) -> Result<(), Invalid> {
        const MOST: u32 = 1 << 16;
        if image.len() != self.sums.len() {
            let message = format!("{} pixels in a stack of {} × {}", image.len(), self.width, self.height);
            return Err(Invalid::new("", message));
        }
        if self.count == MOST {
            return Err(Invalid::new("", format!("a stack holds at most {MOST} images")));
        }
        self.count += 1;
        let mut squares = 0u64;
        for (sum, &y) in self.sums.iter_mut().zip(image) {
            *sum += u32::from(y);
            squares += u64::from(y).pow(2);
        }
        self.squares += u128::from(squares);
        Ok(())
    }

    /// Images added so far.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// The average image ⟨y⟩, DN, row by row.
    pub fn average(&self) -> Vec<f64> {
        let count = f64::from(self.count.max(1));
        self.sums.iter().map(|&sum| f64::from(sum) / count).collect()
    }

    /// The variances. The stack must hold at least two images of at least 3 × 3 pixels.
    pub fn variances(&self) -> Result<SpatialVariances, Invalid> {
        if self.count < 2 || self.width < 3 || self.height < 3 {
            let message = format!("{} images of {} × {} pixels tell no patterns", self.count, self.width, self.height);
            return Err(Invalid::new("", message).help("take at least two images of at least 3 × 3 pixels"));
        }
        let (columns, rows) = (self.width as f64, self.height as f64);
        let (pixels, images) = (columns * rows, f64::from(self.count));
        let average = self.average();
        let mean = average.iter().sum::<f64>() / pixels;
        let measured = average.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / (pixels - 1.0);
        // Σ over pixels of (L·Σy² − (Σy)²), an exact integer.
        let of_sums: u128 = self.sums.iter().map(|&sum| u128::from(sum).pow(2)).sum();
        let temporal = (u128::from(self.count) * self.squares - of_sums) as f64 / (pixels * images * (images - 1.0));

        let mut of_columns = vec![0.0; self.width];
        let mut row_average = -temporal / (images * columns);
        for row in average.chunks_exact(self.width) {
            row_average += (row.iter().sum::<f64>() / columns - mean).powi(2) / rows;
            of_columns.iter_mut().zip(row).for_each(|(sum, y)| *sum += y);
        }
        let squares = of_columns.iter().map(|sum| (sum / rows - mean).powi(2)).sum::<f64>();
        let column_average = squares / columns - temporal / (images * rows);

        let total = measured - temporal / images;
        let rest = pixels - rows - columns;
        let row = ((pixels - columns) * row_average - rows * (total - column_average)) / rest;
        let column = ((pixels - rows) * column_average - columns * (total - row_average)) / rest;
        let pixel = pixels / rest * (total - column_average - row_average);
        Ok(SpatialVariances { mean, temporal, total, row, column, pixel })
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use rand::RngExt;
    use rand_distr::StandardNormal;

    use super::*;
    use photosite_core::math::philox::Philox;

    #[test]
    fn a_stack_by_hand() {
        // The second image is brighter by 2 in its first pixel, and the averages are 8, 9, 11, 13 and 10.
        let mut stack = SpatialStack::new(3, 3);
        stack.add(&[7, 9, 11, 13, 10, 10, 10, 10, 10]).expect("fits");
        stack.add(&[9, 9, 11, 13, 10, 10, 10, 10, 10]).expect("fits");
        assert_eq!(stack.average()[..4], [8.0, 9.0, 11.0, 13.0]);
        let found = stack.variances().expect("two images");
        // The only pixel that changes has a variance of 2.
        assert_relative_eq!(found.temporal, 2.0 / 9.0, max_relative = 1e-12);
        assert_relative_eq!(found.mean, 91.0 / 9.0, max_relative = 1e-12);
        // Σy² − 91²/9 = 64 + 81 + 121 + 169 + 500 − 8281/9 = 134/9, over 8, less a half of 2/9: 1.75.
        assert_relative_eq!(found.total, 1.75, max_relative = 1e-12);
        assert!(SpatialStack::new(3, 3).variances().is_err());
        assert!(stack.add(&[1, 2, 3]).is_err());
    }

    #[test]
    fn rows_columns_and_pixels_are_told_apart() {
        const SIZE: [usize; 2] = [240, 160];
        let [row, column, pixel, temporal] = [20.0, 30.0, 50.0, 40.0];
        let normal = |key: u64, i: usize| Philox::new(key, i as u64).sample::<f64, _>(StandardNormal);
        let mut stack = SpatialStack::new(SIZE[0], SIZE[1]);
        for image in 0..8 {
            let value = |i: usize| {
                let [x, y] = [i % SIZE[0], i / SIZE[0]];
                let pattern = row * normal(1, y) + column * normal(2, x) + pixel * normal(3, i);
                (2000.0 + pattern + temporal * normal(4 + image, i)).round() as u16
            };
            stack.add(&(0..SIZE[0] * SIZE[1]).map(value).collect::<Vec<u16>>()).expect("fits");
        }
        let found = stack.variances().expect("images");
        assert_relative_eq!(found.row + found.column + found.pixel, found.total, max_relative = 1e-9);
        // The pattern itself is a sample: a variance of n numbers spreads by √(2/n) of itself, 5 times that; columns
        // and rows have 50²/160 and 50²/240 of the pixels' pattern, and what averaging leaves of the noise, on top.
        let pixels = (SIZE[0] * SIZE[1]) as f64;
        let left = temporal * temporal / 8.0;
        for (name, value, expected, on_top, n) in [
            ("temporal", found.temporal, temporal * temporal + 1.0 / 12.0, 0.0, 7.0 * pixels),
            ("row", found.row, row * row, (pixel * pixel + left) / 240.0, 160.0),
            ("column", found.column, column * column, (pixel * pixel + left) / 160.0, 240.0),
            ("pixel", found.pixel, pixel * pixel, left, pixels),
        ] {
            let within = 5.0 * (2.0f64 / n).sqrt() * (expected + on_top);
            assert!((value - expected).abs() < within, "{name}: {value} instead of {expected} ± {within}");
        }
    }
}
