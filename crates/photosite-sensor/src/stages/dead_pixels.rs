//! Dead pixels: they do not see light. Dark current and read-out are theirs as of all others.

use super::frame::Frame;
use crate::model::{DefectivePixels, PixelDefect};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;

/// The places of pixels without response.
#[derive(Clone, Debug)]
pub(crate) struct DeadPixels {
    part: f64,
    places: Streams,
    /// Pixels whose places are known, in place of random ones.
    known: Option<DefectivePixels>,
}

impl DeadPixels {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let part = frame.sensor.noise.defects.dead;
        let known = frame.sensor.noise.defective_pixels.clone();
        frame.fixed(Stage::DeadPixels).filter(|_| part > 0.0).map(|places| Self { part, places, known })
    }
}

impl RowStage for DeadPixels {
    const MAP: NoiseMap = Stage::DeadPixels.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        if let Some(known) = &self.known {
            let dead = known.row(row.y).filter(|(_, defect)| *defect == PixelDefect::Dead);
            return dead.for_each(|(x, _)| row.values[x] = 0.0);
        }
        for x in self.places.chosen(self.part, row.y, row.values.len()) {
            row.values[x] = 0.0;
        }
    }
}
