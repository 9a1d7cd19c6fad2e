//! Photo response non-uniformity (PRNU): pixels differ in size, thickness and filter, so each turns a little more or
//! less of the light into charge. A fixed pattern, the same in every frame.

use super::fixed_pattern::{Deviations, PatternWords};
use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::words::Tables;

/// The response pattern of a sensor.
#[derive(Clone, Debug)]
pub(crate) struct PhotoResponse {
    deviations: Deviations,
}

impl PhotoResponse {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let streams = frame.fixed(Stage::PhotoResponse)?;
        let noise = &frame.sensor.noise;
        Some(Self { deviations: Deviations::new(&noise.prnu, noise.prnu_map.as_ref(), frame.size[0], streams)? })
    }

    /// Words of the pattern in the columns and rows of a frame.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> PatternWords {
        self.deviations.words(frame.size, tables)
    }
}

impl RowStage for PhotoResponse {
    const MAP: NoiseMap = Stage::PhotoResponse.map();

    /// Scales mean electrons to those of each pixel: μ·(1 + δ) with the pattern's deviation δ. No pixel responds
    /// negatively.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        self.deviations.apply(row, |mean, deviation| mean * (1.0 + deviation).max(0.0));
    }
}
