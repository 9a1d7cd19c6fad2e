//! Digital gain: the numbers of the converter are multiplied. Nothing is gained in precision, but the noise of all that
//! came before grows with the signal, and the range ends earlier.

use super::frame::Frame;
use crate::signal::charge_plane::Row;
use crate::{BinningMethod, Exposure, SensorModel};

impl SensorModel {
    /// System gain K of the numbers that leave the sensor at an exposure's gains, DN/e⁻, which photon transfer finds:
    ///
    /// K = K_ADC·g_digital·w,
    ///
    /// with the gain K_ADC of amplifiers and converter and the weight w of a converted number in what is read out: 1/n
    /// where the mean of n pixels is taken, else 1. Electrons are those of the pixel that is read out: of a bin, those of all
    /// its pixels together, whatever the method.
    pub fn system_gain(&self, exposure: &Exposure) -> f64 {
        let digital = exposure.digital_gain.factor() * exposure.region.binning.weight();
        self.converter.system_gain(exposure.gain) * digital
    }
}

/// Variance that rounding after a digital gain and after taking means adds, referred to electrons, (e⁻)²: 1/(12·K²)
/// with the gain K so far. Whole factors need no rounding.
pub(crate) fn rounding_variance_e2(sensor: &SensorModel, exposure: &Exposure) -> f64 {
    let (factor, binning) = (exposure.digital_gain.factor(), exposure.region.binning);
    let rounding = |gain: f64| (1.0 / 12.0) / gain.powi(2);
    let of_gain = if factor.fract() == 0.0 { 0.0 } else { rounding(sensor.system_gain(exposure)) };
    let takes_means = binning.method == BinningMethod::Mean && binning.pixels() > 1;
    of_gain + if takes_means { rounding(sensor.system_gain(exposure) / factor) } else { 0.0 }
}

/// Digital gain: the factor of the converter's numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DigitalGain {
    factor: f64,
    black_level_dn: f64,
    max_dn: f64,
}

impl DigitalGain {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let (converter, factor) = (&frame.sensor.converter, frame.exposure.digital_gain.factor());
        let (black_level_dn, max_dn) = (frame.black_level_dn().into(), converter.max_dn().into());
        (factor != 1.0).then_some(Self { factor, black_level_dn, max_dn })
    }

    pub(crate) fn factor(&self) -> f64 {
        self.factor
    }

    /// black + g·(DN − black), neither rounded nor clamped.
    #[inline]
    pub(crate) fn level(&self, number: f64) -> f64 {
        self.black_level_dn + self.factor * (number - self.black_level_dn)
    }

    /// round(black + g·(DN − black)), clamped to 0 … 2^bits − 1.
    #[inline]
    pub(crate) fn apply(&self, numbers: &mut Row<'_, u16>) {
        for number in numbers.values.iter_mut() {
            let level = self.level(f64::from(*number));
            *number = (level.clamp(0.0, self.max_dn) + 0.5) as u16;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_multiplied_from_the_black_level_on() {
        let gain = DigitalGain { factor: 1.5, black_level_dn: 64.0, max_dn: 1023.0 };
        let mut numbers = [64, 65, 66, 164, 60, 0, 900];
        gain.apply(&mut Row { y: 0, values: &mut numbers });
        // Halves are rounded up; −96 + 64 and 1254 + 64 lie outside the range.
        assert_eq!(numbers, [64, 66, 67, 214, 58, 0, 1023]);
    }
}
