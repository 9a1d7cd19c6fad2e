//! Reset noise: the thermal noise of the switch that empties the sense node stays on its capacitance.

use photosite_core::units::{BOLTZMANN, Celsius, ELEMENTARY_CHARGE, Electrons, ZERO_CELSIUS};

use super::frame::Frame;
use crate::model::Reset;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::NormalWords;

impl Reset {
    /// Standard deviation at a temperature, σ = √(k·T·C)/q with T in K, the capacitance C in F and the charge q of an
    /// electron ([Janesick01](photosite_core::references#janesick01), reset noise).
    pub fn standard_deviation(&self, temperature: Celsius) -> Electrons {
        match *self {
            Self::Cancelled => Electrons(0.0),
            Self::Fixed(noise) => noise,
            Self::Capacitance(farad) => {
                let kelvin = (temperature.0 + ZERO_CELSIUS).max(0.0);
                Electrons((BOLTZMANN * kelvin * farad).sqrt() / ELEMENTARY_CHARGE)
            }
        }
    }
}

/// Adds the noise of resetting each pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResetNoise {
    standard_deviation_e: f32,
    streams: Streams,
}

impl ResetNoise {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let noise = frame.sensor.noise.reset.standard_deviation(frame.exposure.temperature);
        let streams = frame.temporal(Stage::ResetNoise).filter(|_| noise.0 > 0.0)?;
        Some(Self { standard_deviation_e: noise.0 as f32, streams })
    }

    /// Words of the stage.
    pub(crate) fn words(&self) -> NormalWords {
        NormalWords { streams: self.streams.words(), standard_deviation_e: self.standard_deviation_e }
    }
}

impl RowStage for ResetNoise {
    const MAP: NoiseMap = Stage::ResetNoise.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        self.streams.normals(row, |_, charge, n| charge + self.standard_deviation_e * n);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_femtofarad_at_room_temperature_makes_12_7_electrons() {
        // √(1.380649e-23 J/K · 300 K · 1e-15 F) = 2.03518e-18 C; over 1.602176634e-19 C: 12.70.
        let noise = Reset::Capacitance(1e-15).standard_deviation(Celsius(300.0 - ZERO_CELSIUS));
        assert!((noise.0 - 12.7026).abs() < 1e-3, "{noise:?}");
    }
}
