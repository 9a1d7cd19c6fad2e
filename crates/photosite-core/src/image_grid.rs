//! Pixel grid of a delivered image relative to the sensor's, after regions of interest, binning, frame grabbers, video
//! line delays, pixel-aspect correction, resizing and zooming.
//!
//! Along each axis s = a + d·p, where p is a place in the image and s the same place on the sensor, both in continuous
//! coordinates from the top-left corner of the first pixel that sees light, px; a is the image's origin on the sensor,
//! and d the number of sensor pixels per image pixel. Ground truth, points, camera files and layouts of data sets are
//! all in pixels of this grid.

use glam::DVec2;

use crate::cells::shift;
use crate::projection::Intrinsics;

/// The pixels of an image on the grid of the sensor that it was taken with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageGrid {
    /// Columns and rows.
    pub resolution: [u32; 2],
    /// Origin of the image on the sensor, px.
    pub first: DVec2,
    /// Sensor pixels per image pixel, along rows and across.
    pub per_pixel: DVec2,
    /// Whether every second row lies half a pixel farther to the right.
    pub is_staggered: bool,
}

impl From<[u32; 2]> for ImageGrid {
    /// Grid of all pixels of a sensor with cells in columns.
    fn from(resolution: [u32; 2]) -> Self {
        Self { resolution, first: DVec2::ZERO, per_pixel: DVec2::ONE, is_staggered: false }
    }
}

impl ImageGrid {
    /// The centre of a pixel, column and row, in the image.
    #[inline]
    pub fn centre(&self, [column, row]: [usize; 2]) -> DVec2 {
        let right = if self.is_staggered { shift(row as f64) } else { 0.0 };
        DVec2::new(column as f64 + right, row as f64) + 0.5
    }

    /// Place in the image → place on the sensor.
    #[inline]
    pub fn on_sensor(&self, place: DVec2) -> DVec2 {
        self.first + place * self.per_pixel
    }

    /// Place on the sensor → place in the image, or beside it.
    #[inline]
    pub fn in_image(&self, place: DVec2) -> DVec2 {
        (place - self.first) / self.per_pixel
    }

    /// Whether a place in the image lies within its edges.
    #[inline]
    pub fn contains(&self, place: DVec2) -> bool {
        let [width, height] = self.resolution.map(f64::from);
        (0.0..width).contains(&place.x) && (0.0..height).contains(&place.y)
    }

    /// Camera matrix on this grid, from the camera matrix on the sensor's grid.
    pub fn intrinsics(&self, on_sensor: &Intrinsics) -> Intrinsics {
        on_sensor.on_grid(self.first.to_array(), self.per_pixel.to_array())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_matrices_go_to_the_grid_and_back() {
        let grid = ImageGrid {
            resolution: [100, 80],
            first: DVec2::new(20.0, -3.5),
            per_pixel: DVec2::new(2.0, 0.75),
            is_staggered: true,
        };
        let place = DVec2::new(31.25, 17.5);
        // 20 + 2·31.25 and −3.5 + ¾·17.5, exact in binary.
        assert_eq!(grid.on_sensor(place), DVec2::new(82.5, 9.625));
        assert_eq!(grid.in_image(grid.on_sensor(place)), place);
        assert_eq!(grid.centre([3, 2]), DVec2::new(3.5, 2.5));
        assert_eq!(grid.centre([3, 5]), DVec2::new(4.0, 5.5));
        let whole = Intrinsics { fx: 500.0, fy: 400.0, cx: 320.0, cy: 250.0, skew: 3.0 };
        let direction = DVec2::new(0.2, -0.3);
        let moved = grid.in_image(whole.pixel(direction));
        assert!((grid.intrinsics(&whole).pixel(direction) - moved).length() < 1e-12);
    }
}
