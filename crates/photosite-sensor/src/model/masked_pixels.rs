//! Columns and rows of pixels around the image that see no light.

/// Numbers of covered columns and rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MaskedPixels {
    /// Columns to the left and to the right.
    pub columns: [usize; 2],
    /// Rows above and below.
    pub rows: [usize; 2],
}
