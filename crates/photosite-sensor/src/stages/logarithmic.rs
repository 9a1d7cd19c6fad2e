//! Logarithmic response: a transistor below threshold turns the photocurrent of a pixel into a voltage, so that equal
//! ratios of light become equal steps over many decades.

use photosite_core::units::Seconds;

use super::frame::Frame;
use crate::SensorModel;
use crate::model::Logarithmic;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::NoiseMap;

impl SensorModel {
    /// Signal of a logarithmic pixel for a charge, referred to electrons.
    pub fn pixel_signal(&self, charge_e: f64, time: Seconds) -> f64 {
        self.logarithmic.map_or(charge_e, |logarithmic| logarithmic.signal(charge_e, time))
    }

    /// The charge behind a signal of the pixel, the inverse of [`Self::pixel_signal`].
    pub fn pixel_charge(&self, signal_e: f64, time: Seconds) -> f64 {
        self.logarithmic.map_or(signal_e, |logarithmic| logarithmic.charge(signal_e, time))
    }

    /// d(signal)/d(charge) of the pixel at a charge.
    pub(crate) fn pixel_slope(&self, charge_e: f64, time: Seconds) -> f64 {
        self.logarithmic
            .map_or(1.0, |logarithmic| 1.0 / (1.0 + charge_e.max(0.0) / (logarithmic.reference_e_per_s * time.0)))
    }
}

/// The response of the pixels of one exposure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogarithmicResponse {
    logarithmic: Logarithmic,
    time: Seconds,
}

impl LogarithmicResponse {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        Some(Self { logarithmic: frame.sensor.logarithmic?, time: frame.exposure.time })
    }
}

impl RowStage for LogarithmicResponse {
    const MAP: NoiseMap = NoiseMap::LogarithmicResponseE;

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|value| *value = self.logarithmic.signal((*value).into(), self.time) as f32);
    }
}
