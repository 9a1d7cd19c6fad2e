//! Dead pixels: they do not see light. Dark current and read-out are theirs as of all others.

use super::charge_plane::{Row, RowStage};
use super::expose::Frame;
use super::noise_key::Streams;
use super::stage::Stage;

/// The places of pixels without response.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeadPixels {
    part: f64,
    places: Streams,
}

impl DeadPixels {
    pub(super) fn new(frame: &Frame<'_>) -> Option<Self> {
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
