//! Full well: the charge that a pixel holds at most; what comes on top is lost.

use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};

/// The end of what pixels can hold.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FullWell {
    pub(crate) capacity_e: f32,
}

impl FullWell {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        frame.stages.has(Stage::FullWell).then_some(Self { capacity_e: frame.sensor.full_well.0 as f32 })
    }
}

impl FullWell {
    /// Capacity of a stage, e⁻: without it more than any charge.
    pub(crate) fn word(stage: Option<&Self>) -> f32 {
        stage.map_or(f32::MAX, |full_well| full_well.capacity_e)
    }

    #[inline]
    pub(crate) fn is_full(&self, charge: f32) -> bool {
        charge >= self.capacity_e
    }
}

impl RowStage for FullWell {
    const MAP: NoiseMap = Stage::FullWell.map();

    /// The charge that stays in the pixels, e⁻.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|charge| *charge = charge.min(self.capacity_e));
    }
}
