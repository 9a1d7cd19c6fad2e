//! Dark signal non-uniformity (DSNU): every pixel's read-out starts from an offset of its own. A fixed pattern, the
//! same in every frame.

use super::fixed_pattern::{Deviations, PatternWords};
use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::words::Tables;

/// The offset pattern of a sensor.
#[derive(Clone, Debug)]
pub(crate) struct DarkOffset {
    deviations: Deviations,
}

impl DarkOffset {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let streams = frame.fixed(Stage::DarkOffset)?;
        let (pattern, measured) = (frame.read_out_noise().dsnu, frame.sensor.noise.dsnu_map.as_ref());
        Some(Self { deviations: Deviations::new(&pattern, measured, frame.size[0], streams)? })
    }

    /// Words of the pattern in the columns and rows of a frame.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> PatternWords {
        self.deviations.words(frame.size, tables)
    }
}

impl RowStage for DarkOffset {
    const MAP: NoiseMap = Stage::DarkOffset.map();

    /// The signals with their offsets, which may be negative.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        self.deviations.apply(row, |charge, offset| charge + offset);
    }
}
