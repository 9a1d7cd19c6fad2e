//! Dead pixels: they do not see light. Dark current and read-out are theirs as of all others.

use super::frame::Frame;
use crate::model::{DefectivePixels, PixelDefect};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::Tables;

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

    /// Columns of the dead pixels among the first `width` of a row.
    fn of_row(&self, y: usize, width: usize) -> impl Iterator<Item = usize> {
        let dead = |(x, defect)| (defect == PixelDefect::Dead).then_some(x);
        let known = self.known.iter().flat_map(move |pixels| pixels.row(y).filter_map(dead));
        let part = if self.known.is_some() { 0.0 } else { self.part };
        known.chain(self.places.chosen(part, y, width))
    }

    /// Place of the pixels in the tables.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> u32 {
        let [width, height] = frame.size;
        tables.add_pixels(height, |y| self.of_row(y, width).map(|x| (x, 0)))
    }
}

impl RowStage for DeadPixels {
    const MAP: NoiseMap = Stage::DeadPixels.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        for x in self.of_row(row.y, row.values.len()) {
            row.values[x] = 0.0;
        }
    }
}
