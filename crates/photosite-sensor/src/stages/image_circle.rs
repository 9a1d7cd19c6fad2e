//! The image circle: pixels beyond it see no light.

use crate::SensorModel;
use crate::signal::charge_plane::ChargePlane;

impl SensorModel {
    /// Whether the pixel at a column and row sees light.
    pub fn sees_light(&self, [column, row]: [usize; 2]) -> bool {
        self.cells.sees_light(self.cells.centre([column, row]))
    }
}

/// Takes away the mean electrons of pixels beyond the circle.
pub(crate) fn cover(charge: &mut ChargePlane, sensor: &SensorModel) {
    if sensor.cells.image_circle.is_none() {
        return;
    }
    let samples = charge.samples;
    charge.for_each_row(|row| {
        for (x, pixel) in row.values.chunks_mut(samples).enumerate() {
            if !sensor.sees_light([x, row.y]) {
                pixel.fill(0.0);
            }
        }
    });
}
