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

/// The pixel values that an opcode changes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AreaSpec {
    /// A part of the image.
    pub area: PixelArea,
    /// Distance from one changed pixel to the next, along rows and along columns, pixels.
    pub pitch: [usize; 2],
    /// The first of a pixel's values that are changed.
    pub plane: usize,
    /// Number of a pixel's values that are changed.
    pub planes: usize,
}

impl AreaSpec {
    /// Whether the area has changed pixels in this row.
    pub fn has_row(&self, y: usize) -> bool {
        is_step(y, self.area.y, self.area.height, self.pitch[1])
    }

    /// Whether a value of the pixels of this column is changed.
    pub fn has_number(&self, x: usize, plane: usize) -> bool {
        is_step(x, self.area.x, self.area.width, self.pitch[0]) && is_step(plane, self.plane, self.planes, 1)
    }
}

/// Whether a place is one of those that begin at `first`, `pitch` apart, over `length`.
fn is_step(place: usize, first: usize, length: usize, pitch: usize) -> bool {
    place.checked_sub(first).is_some_and(|from| from < length && from.is_multiple_of(pitch))
}

/// Selection of pixels of a raw image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pixels {
    /// Pixels that see light.
    Active,
    /// The masked ones, too.
    All,
}
