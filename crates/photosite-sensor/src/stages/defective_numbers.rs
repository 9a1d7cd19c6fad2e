//! Digital numbers that are not what the converter made of a signal: those of stuck pixels, and those that are lost on
//! the way.

use rand::RngExt;

use super::frame::Frame;
use crate::model::{DefectivePixels, PixelDefect};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::Tables;

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

    /// The stuck pixels among the first `width` of a row, and their numbers.
    fn of_row(&self, y: usize, width: usize) -> impl Iterator<Item = (usize, u16)> {
        let stuck = |(x, defect)| match defect {
            PixelDefect::Stuck(dn) => Some((x, dn)),
            PixelDefect::Hot(_) | PixelDefect::Dead => None,
        };
        let known = self.known.iter().flat_map(move |pixels| pixels.row(y).filter_map(stuck));
        let part = if self.known.is_some() { 0.0 } else { self.part };
        let number = move |x| self.places.part(0).pixel(x, y).random_range(0..=self.max_dn);
        known.chain(self.places.chosen(part, y, width).map(move |x| (x, number(x))))
    }

    /// Place of the pixels and their numbers in the tables.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> u32 {
        let [width, height] = frame.size;
        tables.add_pixels(height, |y| self.of_row(y, width).map(|(x, number)| (x, number.into())))
    }
}

impl RowStage<u16> for StuckPixels {
    const MAP: NoiseMap = Stage::StuckPixels.map();

    #[inline]
    fn apply(&self, numbers: &mut Row<'_, u16>) {
        for (x, number) in self.of_row(numbers.y, numbers.values.len()) {
            numbers.values[x] = number;
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

    /// The numbers among the first `width` of a row that are lost, and what arrives in their place.
    fn of_row(&self, y: usize, width: usize) -> impl Iterator<Item = (usize, u16)> {
        self.places.chosen(self.part, y, width).map(move |x| {
            let random = &mut self.places.part(0).pixel(x, y);
            (x, if random.random() { self.max_dn } else { 0 })
        })
    }

    /// Place of the errors in the tables.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> u32 {
        let [width, height] = frame.size;
        tables.add_pixels(height, |y| self.of_row(y, width).map(|(x, number)| (x, number.into())))
    }
}

impl RowStage<u16> for TransmissionErrors {
    const MAP: NoiseMap = Stage::TransmissionErrors.map();

    #[inline]
    fn apply(&self, numbers: &mut Row<'_, u16>) {
        for (x, number) in self.of_row(numbers.y, numbers.values.len()) {
            numbers.values[x] = number;
        }
    }
}
