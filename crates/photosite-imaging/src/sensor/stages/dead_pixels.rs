//! Dead pixels: they do not see light. Dark current and read-out are theirs as of all others.

use super::frame::Frame;
use crate::sensor::signal::charge_plane::{Row, RowStage};
use crate::sensor::signal::effects::Stage;
use crate::sensor::signal::noise_key::Streams;

/// The places of pixels without response.
#[derive(Clone, Copy, Debug)]
pub(in crate::sensor) struct DeadPixels {
    part: f64,
    places: Streams,
}

impl DeadPixels {
    pub(in crate::sensor) fn new(frame: &Frame<'_>) -> Option<Self> {
        let part = frame.sensor.noise.defects.dead;
        frame.fixed(Stage::DeadPixels).filter(|_| part > 0.0).map(|places| Self { part, places })
    }
}

impl RowStage for DeadPixels {
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        for x in self.places.chosen(self.part, row.y, row.values.len()) {
            row.values[x] = 0.0;
        }
    }
}
