//! Dead pixels: they do not see light. Dark current and read-out are theirs as of all others.

use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;

/// The places of pixels without response.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeadPixels {
    part: f64,
    places: Streams,
}

impl DeadPixels {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let part = frame.sensor.noise.defects.dead;
        frame.fixed(Stage::DeadPixels).filter(|_| part > 0.0).map(|places| Self { part, places })
    }
}

impl RowStage for DeadPixels {
    const MAP: NoiseMap = Stage::DeadPixels.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        for x in self.places.chosen(self.part, row.y, row.values.len()) {
            row.values[x] = 0.0;
        }
    }
}
