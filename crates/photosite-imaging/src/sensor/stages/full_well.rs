//! Full well: a pixel holds only so many electrons; what comes on top is lost.

use super::frame::Frame;
use crate::sensor::signal::charge_plane::{Row, RowStage};
use crate::sensor::signal::effects::Stage;

/// The end of what pixels can hold.
#[derive(Clone, Copy, Debug)]
pub(in crate::sensor) struct FullWell {
    pub(in crate::sensor) capacity_e: f32,
}

impl FullWell {
    pub(in crate::sensor) fn new(frame: &Frame<'_>) -> Option<Self> {
        frame.stages.has(Stage::FullWell).then_some(Self { capacity_e: frame.sensor.full_well.0 as f32 })
    }
}

impl FullWell {
    #[inline]
    pub(in crate::sensor) fn is_full(&self, charge: f32) -> bool {
        charge >= self.capacity_e
    }
}

impl RowStage for FullWell {
    /// The charge that stays in the pixels, e⁻.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|charge| *charge = charge.min(self.capacity_e));
    }
}
