//! Windows of an EXR file: the data window that is stored, and the display window that is the image.

use exr::math::Vec2;

/// A rectangle of the pixel plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    x: i64,
    y: i64,
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Window {
    pub(super) fn of(Vec2(x, y): Vec2<i32>, Vec2(width, height): Vec2<usize>) -> Self {
        Self { x: x.into(), y: y.into(), width, height }
    }

    pub(super) fn pixels(self) -> usize {
        self.width.saturating_mul(self.height)
    }

    /// Columns or rows from `first` on that lie in both of two windows, counted within the first.
    fn common(start: i64, length: usize, other_start: i64, other_length: usize) -> std::ops::Range<usize> {
        let low = (other_start - start).clamp(0, length as i64);
        let high = (other_start + other_length as i64 - start).clamp(low, length as i64);
        low as usize..high as usize
    }

    /// Warnings of a data window that differs from the display window; an error where they do not overlap.
    pub(super) fn compared_with(self, display: Self) -> Result<Vec<String>, String> {
        let stored = Self::common(self.x, self.width, display.x, display.width).len()
            * Self::common(self.y, self.height, display.y, display.height).len();
        if stored == 0 {
            return Err("lies outside of the display window: the file holds nothing of the image".to_owned());
        }
        let mut said = Vec::new();
        if stored < display.pixels() {
            said.push(format!(
                "its data window holds {stored} of the {} pixels of its display window; the others are taken to be 0",
                display.pixels()
            ));
        }
        if stored < self.pixels() {
            let outside = self.pixels() - stored;
            said.push(format!(
                "{outside} pixels of its data window lie outside of its display window and are left out"
            ));
        }
        Ok(said)
    }

    /// Pixel values of this window placed in another, 0 where there are none.
    pub(super) fn placed_in(self, other: Self, values: Vec<f32>) -> Vec<f32> {
        if self == other {
            return values;
        }
        let mut placed = vec![0.0; other.pixels()];
        let columns = Self::common(self.x, self.width, other.x, other.width);
        let left = (self.x + columns.start as i64 - other.x).max(0) as usize;
        let rows = Self::common(self.y, self.height, other.y, other.height);
        let top = (self.y + rows.start as i64 - other.y).max(0) as usize;
        let stored = values.chunks_exact(self.width).skip(rows.start).take(rows.len());
        for (row, stored) in placed.chunks_exact_mut(other.width).skip(top).zip(stored) {
            let filled = row.iter_mut().skip(left);
            filled.zip(stored.iter().skip(columns.start).take(columns.len())).for_each(|(to, from)| *to = *from);
        }
        placed
    }
}
