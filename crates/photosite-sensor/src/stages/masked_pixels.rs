//! Masked pixels: columns and rows around the image that are covered. They have all noise but see no light, and tell
//! a developer what darkness looks like.

use crate::model::MaskedPixels;
use crate::signal::charge_plane::ChargePlane;

impl MaskedPixels {
    /// The light of the image, with none around it.
    pub(crate) fn surround(&self, light: ChargePlane) -> ChargePlane {
        if *self == Self::default() {
            return light;
        }
        let [left, right] = self.columns.map(|columns| columns * light.samples);
        let [above, below] = self.rows;
        let mut all = ChargePlane::empty(left + light.width + right, above + light.height + below, light.samples);
        all.for_each_row(|row| {
            let y = row.y.wrapping_sub(above);
            if y < light.height {
                row.values[left..left + light.width]
                    .copy_from_slice(&light.electrons[y * light.width..][..light.width]);
            }
        });
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_lies_inside() {
        let mut light = ChargePlane::empty(4, 1, 2);
        light.electrons = vec![1.0, 2.0, 3.0, 4.0];
        let all = MaskedPixels { columns: [1, 0], rows: [1, 2] }.surround(light);
        assert_eq!((all.width, all.height), (6, 4));
        let mut expected = vec![0.0; 24];
        expected[8..12].copy_from_slice(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!(all.electrons, expected);
    }
}
