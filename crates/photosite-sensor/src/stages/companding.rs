//! Companding: digital numbers of many bits leave the sensor as numbers of fewer, along a curve that is steep where
//! shot noise is small. A table brings them back: [`SensorModel::linearisation`].

use super::frame::Frame;
use crate::SensorModel;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::NoiseMap;

/// The curve, number by number.
#[derive(Clone, Debug)]
pub(crate) struct Compander {
    table: Vec<u16>,
}

impl Compander {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let converter = &frame.sensor.converter;
        Some(Self { table: converter.companding.as_ref()?.table(converter.max_dn()) })
    }
}

impl RowStage<u16> for Compander {
    const MAP: NoiseMap = NoiseMap::CompandingDn;

    #[inline]
    fn apply(&self, numbers: &mut Row<'_, u16>) {
        numbers.values.iter_mut().for_each(|number| *number = self.table[usize::from(*number)]);
    }
}

impl SensorModel {
    /// Bits of the digital numbers that leave the sensor.
    pub fn output_bits(&self) -> u32 {
        self.converter.companding.as_ref().map_or(self.converter.bits, |companding| companding.bits)
    }

    /// Largest number that leaves the sensor.
    pub(crate) fn output_max_dn(&self) -> u16 {
        // At most 16 bits.
        ((1u32 << self.output_bits()) - 1) as u16
    }
}
