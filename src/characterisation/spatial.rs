//! Spatial non-uniformity from a stack of images of the same light: what stays when temporal noise is averaged out.

use crate::Invalid;

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
/// ([Emva1288](crate::references#emva1288) release 4.0, section on spatial nonuniformity).
///
/// With the average ⟨y⟩ of L images of M rows and N columns, its sample variance s²_measured and the mean σ²_stack of the
/// pixels' temporal variances,
///
/// - s² = s²_measured − σ²_stack/L
/// - s²_cav = Σ(column means − μ)²/N − σ²_stack/(L·M), s²_rav = Σ(row means − μ)²/M − σ²_stack/(L·N)
///
/// and as s² = s²_row + s²_col + s²_pixel, s²_cav = s²_col + s²_pixel/M, s²_rav = s²_row + s²_pixel/N, the parts follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialVariances {
    /// μ_y, DN.
    pub mean: f64,
    /// σ²_stack, the mean temporal variance of a pixel.
    pub temporal: f64,
    /// s², all of it.
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

    /// The variances. The stack must hold at least two images of at least 2 × 2 pixels.
    pub fn variances(&self) -> Result<SpatialVariances, Invalid> {
        if self.count < 2 || self.width < 2 || self.height < 2 {
            let message = format!("{} images of {} × {} pixels tell no patterns", self.count, self.width, self.height);
            return Err(Invalid::new("", message).help("take at least two images of at least 2 × 2 pixels"));
        }
        let (columns, rows) = (self.width as f64, self.height as f64);
        let (pixels, images) = (columns * rows, f64::from(self.count));
        let average = self.average();
        let mean = average.iter().sum::<f64>() / pixels;
        let measured = average.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / (pixels - 1.0);
        // Σ over pixels of (L·Σy² − (Σy)²), an exact integer.
        let of_sums: u128 = self.sums.iter().map(|&sum| u128::from(sum).pow(2)).sum();
        let temporal =
            (u128::from(self.count) * self.squares - of_sums) as f64 / (pixels * images * (images - 1.0));

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
