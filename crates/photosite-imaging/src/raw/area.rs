//! Rectangles of pixels.

use serde::{Deserialize, Serialize};

use std::fmt;

/// Pixels x … x + width − 1 of rows y … y + height − 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelArea {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl fmt::Display for PixelArea {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} × {} at {}, {}", self.width, self.height, self.x, self.y)
    }
}

/// Which pixels of a raw picture are looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// Pixels that see light.
    Active,
    /// The masked ones, too.
    All,
}
