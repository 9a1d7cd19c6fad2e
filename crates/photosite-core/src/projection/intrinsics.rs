//! Camera matrix: pixels to the normalised image coordinates of a projection, and back.

use glam::DVec2;
use serde::{Deserialize, Serialize};

/// A pinhole matrix in pixels. The principal point is in photosite's continuous coordinates (pixel centres at +0.5).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Focal length in pixel widths.
    pub fx: f64,
    /// Focal length in pixel heights.
    pub fy: f64,
    /// Principal point, columns from the left edge.
    pub cx: f64,
    /// Principal point, rows from the top edge.
    pub cy: f64,
    /// Skew, pixels.
    pub skew: f64,
}

impl Intrinsics {
    /// The normalised image coordinates of a pixel position.
    #[inline]
    pub fn place(&self, pixel: DVec2) -> DVec2 {
        let y = (pixel.y - self.cy) / self.fy;
        DVec2::new((pixel.x - self.cx - self.skew * y) / self.fx, y)
    }

    /// The pixel position of normalised image coordinates.
    #[inline]
    pub fn pixel(&self, place: DVec2) -> DVec2 {
        DVec2::new(self.fx * place.x + self.skew * place.y + self.cx, self.fy * place.y + self.cy)
    }

    /// Camera matrix on a grid that begins at `first` (columns and rows of this grid) and has `per_pixel` pixels of
    /// this grid in each of its own.
    pub fn on_grid(&self, first: [f64; 2], per_pixel: [f64; 2]) -> Self {
        let Self { fx, fy, cx, cy, skew } = *self;
        let ([left, top], [across, down]) = (first, per_pixel);
        Self { fx: fx / across, fy: fy / down, cx: (cx - left) / across, cy: (cy - top) / down, skew: skew / across }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_and_places_lead_to_each_other_on_every_grid() {
        let whole = Intrinsics { fx: 500.0, fy: 400.0, cx: 320.0, cy: 250.0, skew: 3.0 };
        let place = DVec2::new(0.2, -0.3);
        let pixel = whole.pixel(place);
        // 500·0.2 − 3·0.3 + 320 and −400·0.3 + 250.
        assert!((pixel - DVec2::new(419.1, 130.0)).length() < 1e-12, "{pixel}");
        assert!((whole.place(pixel) - place).length() < 1e-15);
        let part = whole.on_grid([100.0, 40.0], [2.0, 3.0]);
        assert!((part.pixel(place) - DVec2::new(319.1 / 2.0, 30.0)).length() < 1e-12);
    }
}
