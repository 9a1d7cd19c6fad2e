//! Logarithmic response: a transistor below threshold turns the photocurrent of a pixel into a voltage, so that equal ratios
//! of light become equal steps over many decades.

use photosite_core::units::Seconds;

use super::SensorModel;
use super::charge_plane::{Row, RowStage};
use super::expose::Frame;

/// Pixels whose voltage follows the logarithm of their photocurrent,
///
/// V ∝ ln(1 + i/i₀),  i = q/t
///
/// with the charge q that light and heat free during the time t, over which the pixel averages, and the reference current
/// i₀, from which on the response is more logarithmic than linear ([Kavadias00](photosite_core::references#kavadias00)). Signals
/// are referred to electrons as those of linear pixels are: s = q₀·ln(1 + q/q₀) with q₀ = i₀·t, which is q for little
/// light. What the read-out adds, it adds to s. Below zero the response is a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logarithmic {
    /// Reference current i₀, e⁻/s, above 0.
    pub reference_e_per_s: f64,
}

impl Logarithmic {
    fn signal(&self, charge_e: f64, time: Seconds) -> f64 {
        let reference = self.reference_e_per_s * time.0;
        if charge_e > 0.0 { reference * (charge_e / reference).ln_1p() } else { charge_e }
    }

    fn charge(&self, signal_e: f64, time: Seconds) -> f64 {
        let reference = self.reference_e_per_s * time.0;
        if signal_e > 0.0 { reference * (signal_e / reference).exp_m1() } else { signal_e }
    }
}

impl SensorModel {
    /// What a charge becomes in the pixel, referred to electrons.
    pub fn pixel_signal(&self, charge_e: f64, time: Seconds) -> f64 {
        self.logarithmic.map_or(charge_e, |logarithmic| logarithmic.signal(charge_e, time))
    }

    /// The charge behind a signal of the pixel, the inverse of [`Self::pixel_signal`].
    pub fn pixel_charge(&self, signal_e: f64, time: Seconds) -> f64 {
        self.logarithmic.map_or(signal_e, |logarithmic| logarithmic.charge(signal_e, time))
    }

    /// d(signal)/d(charge) of the pixel at a charge.
    pub(super) fn pixel_slope(&self, charge_e: f64, time: Seconds) -> f64 {
        self.logarithmic
            .map_or(1.0, |logarithmic| 1.0 / (1.0 + charge_e.max(0.0) / (logarithmic.reference_e_per_s * time.0)))
    }
}

/// The response of the pixels of one exposure.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogarithmicResponse {
    logarithmic: Logarithmic,
    time: Seconds,
}

impl LogarithmicResponse {
    pub(super) fn new(frame: &Frame<'_>) -> Option<Self> {
        Some(Self { logarithmic: frame.sensor.logarithmic?, time: frame.exposure.time })
    }
}

impl RowStage for LogarithmicResponse {
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|value| *value = self.logarithmic.signal((*value).into(), self.time) as f32);
    }
}
