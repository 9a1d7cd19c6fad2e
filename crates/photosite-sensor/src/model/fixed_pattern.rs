//! Spatial standard deviations of patterns that are the same in every image.

/// Spatial standard deviations of a pattern that is the same in every image, in a unit of its own. Its parts are
/// independent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FixedPattern {
    /// Standard deviation of the part that differs from pixel to pixel.
    pub pixel: f64,
    /// Standard deviation of the part that all pixels of a row share.
    pub row: f64,
    /// Standard deviation of the part that all pixels of a column share.
    pub column: f64,
}

impl FixedPattern {
    /// A pattern without rows and columns.
    pub const fn of_pixels(pixel: f64) -> Self {
        Self { pixel, row: 0.0, column: 0.0 }
    }

    /// Standard deviation of the whole pattern, √(pixel² + row² + column²).
    pub fn total(&self) -> f64 {
        (self.pixel * self.pixel + self.row * self.row + self.column * self.column).sqrt()
    }
}
