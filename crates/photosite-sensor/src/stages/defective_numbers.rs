//! Digital numbers that are not what the converter made of a signal: those of stuck pixels, and those that are lost on
//! the way.

use rand::RngExt;

use super::frame::Frame;
use crate::model::{DefectivePixels, PixelDefect};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;

/// Pixels that always read the same number, evenly distributed over the converter's range.
#[derive(Clone, Debug)]
pub(crate) struct StuckPixels {
    part: f64,
    max_dn: u16,
    places: Streams,
    /// Pixels whose places are known, in place of random ones.
    known: Option<DefectivePixels>,
}

impl StuckPixels {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let part = frame.sensor.noise.defects.stuck;
        let places = frame.fixed(Stage::StuckPixels).filter(|_| part > 0.0)?;
        let known = frame.sensor.noise.defective_pixels.clone();
        Some(Self { part, max_dn: frame.sensor.converter.max_dn(), places, known })
    }
}

impl RowStage<u16> for StuckPixels {
    const MAP: NoiseMap = Stage::StuckPixels.map();

    #[inline]
    fn apply(&self, numbers: &mut Row<'_, u16>) {
        if let Some(known) = &self.known {
            for (x, defect) in known.row(numbers.y) {
                if let PixelDefect::Stuck(dn) = defect {
                    numbers.values[x] = dn;
                }
            }
            return;
        }
        for x in self.places.chosen(self.part, numbers.y, numbers.values.len()) {
            numbers.values[x] = self.places.part(0).pixel(x, numbers.y).random_range(0..=self.max_dn);
        }
    }
}

/// Errors of transmission: digital numbers that arrive as 0 or as the largest one, one as often as the other (salt and
/// pepper).
#[derive(Clone, Copy, Debug)]
pub(crate) struct TransmissionErrors {
    part: f64,
    max_dn: u16,
    places: Streams,
}

impl TransmissionErrors {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let part = frame.sensor.noise.transmission_errors;
        let places = frame.temporal(Stage::TransmissionErrors).filter(|_| part > 0.0)?;
        Some(Self { part, max_dn: frame.sensor.output_max_dn(), places })
    }
}

impl RowStage<u16> for TransmissionErrors {
    const MAP: NoiseMap = Stage::TransmissionErrors.map();

    #[inline]
    fn apply(&self, numbers: &mut Row<'_, u16>) {
        for x in self.places.chosen(self.part, numbers.y, numbers.values.len()) {
            let random = &mut self.places.part(0).pixel(x, numbers.y);
            numbers.values[x] = if random.random() { self.max_dn } else { 0 };
        }
    }
}
