//! Orientation: the turn by which an image stands upright.

use photosite_core::image::{Channel, Planes};
use serde::{Deserialize, Serialize};

/// Orientation: turns and mirrors an image so that it stands upright, by the number that EXIF and TIFF have for it: 1
/// for as it is, 6 for a quarter turn clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Orientation(u8);

impl Default for Orientation {
    fn default() -> Self {
        Self(1)
    }
}

impl Orientation {
    /// The orientation of a number; `None` of what is none.
    pub fn of_number(number: f64) -> Option<Self> {
        (1..=8u8).find(|n| f64::from(*n) == number).map(Self)
    }

    /// The number of the orientation in TIFF and EXIF, 1–8.
    pub fn number(self) -> u8 {
        self.0
    }

    /// Whether the image stands upright as it is.
    pub fn is_upright(self) -> bool {
        self == Self::default()
    }

    /// Whether columns become rows.
    pub fn swaps_sides(self) -> bool {
        self.0 >= 5
    }

    /// Columns and rows of the turned image.
    pub fn turned(self, [width, height]: [usize; 2]) -> [usize; 2] {
        if self.swaps_sides() { [height, width] } else { [width, height] }
    }

    /// Width over height of a pixel of the turned image.
    pub fn pixel_aspect(self, aspect: f64) -> f64 {
        if self.swaps_sides() { 1.0 / aspect } else { aspect }
    }

    /// The image upright.
    pub fn apply(self, image: Planes) -> Planes {
        if self.is_upright() {
            return image;
        }
        let from = [image.width(), image.height()];
        let [width, height] = self.turned(from);
        let turned = |channel: Channel| {
            let places = (0..height).flat_map(|y| (0..width).map(move |x| self.source([x, y], from)));
            Channel { data: places.map(|[x, y]| channel.data[y * from[0] + x]).collect(), ..channel }
        };
        let channels = image.into_channels().into_iter().map(turned).collect();
        Planes::new(width, height, channels).expect("as many pixels as before")
    }

    /// The kernel that does to the image as it is what this one, of rows of equal length, does to the upright one.
    pub fn kernel_before(self, upright: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let size = self.turned([upright.first().map_or(0, Vec::len), upright.len()]);
        let mut kernel = vec![vec![0.0; size[0]]; size[1]];
        for (y, row) in upright.iter().enumerate() {
            for (x, &weight) in row.iter().enumerate() {
                let [column, row] = self.source([x, y], size);
                kernel[row][column] = weight;
            }
        }
        kernel
    }

    /// Source pixel of a pixel of the upright image, in an image of `width` columns and `height` rows.
    pub fn source(self, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> [usize; 2] {
        let (right, bottom) = (|x: usize| width - 1 - x, |y: usize| height - 1 - y);
        match self.0 {
            2 => [right(x), y],
            3 => [right(x), bottom(y)],
            4 => [x, bottom(y)],
            5 => [y, x],
            6 => [y, bottom(x)],
            7 => [right(y), bottom(x)],
            8 => [right(y), x],
            _ => [x, y],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of TIFF 6.0, p. 36: where row 0 and column 0 of the file are seen. The image is
    /// 0 1 2
    /// 3 4 5.
    #[test]
    fn row_0_and_column_0_come_where_the_specification_has_them() {
        for (number, columns, expected) in [
            (1.0, 3, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]),
            // Top and right.
            (2.0, 3, [2.0, 1.0, 0.0, 5.0, 4.0, 3.0]),
            // Bottom and right.
            (3.0, 3, [5.0, 4.0, 3.0, 2.0, 1.0, 0.0]),
            // Bottom and left.
            (4.0, 3, [3.0, 4.0, 5.0, 0.0, 1.0, 2.0]),
            // Left and top.
            (5.0, 2, [0.0, 3.0, 1.0, 4.0, 2.0, 5.0]),
            // Right and top.
            (6.0, 2, [3.0, 0.0, 4.0, 1.0, 5.0, 2.0]),
            // Right and bottom.
            (7.0, 2, [5.0, 2.0, 4.0, 1.0, 3.0, 0.0]),
            // Left and bottom.
            (8.0, 2, [2.0, 5.0, 1.0, 4.0, 0.0, 3.0]),
        ] {
            let data = (0..6u8).map(f32::from).collect();
            let image = Planes::new(3, 2, vec![Channel { name: "Y".to_owned(), data }]).expect("right size");
            let orientation = Orientation::of_number(number).expect("one of eight");
            let turned = orientation.apply(image);
            assert_eq!((turned.width(), turned.plane("Y")), (columns, Some(&expected[..])), "{number}");
            assert_eq!(orientation.pixel_aspect(2.0), if columns == 2 { 0.5 } else { 2.0 });
        }
        assert!([0.0, 9.0, 1.5, f64::NAN].into_iter().all(|number| Orientation::of_number(number).is_none()));
    }
}
