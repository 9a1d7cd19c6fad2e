//! Gain and analogue-to-digital conversion: from electrons to digital numbers.

use crate::units::Decibels;

use super::charge_plane::Row;
use super::model::Converter;

/// A converter at one gain setting.
#[derive(Clone, Copy, Debug)]
pub(super) struct Digitiser {
    system_gain: f64,
    black_level_dn: f64,
    max_dn: f64,
}

impl Digitiser {
    pub(super) fn new(converter: &Converter, gain: Decibels) -> Self {
        Self {
            system_gain: converter.system_gain(gain),
            black_level_dn: f64::from(converter.black_level_dn),
            max_dn: f64::from(converter.max_dn()),
        }
    }

    /// y = round(K·charge + black level), clamped to 0 … 2^bits − 1. Noise that goes below zero is kept by the black
    /// level.
    #[inline]
    pub(super) fn convert(&self, row: &Row<'_>, numbers: &mut [u16]) {
        for (charge, number) in row.values.iter().zip(numbers) {
            *number = self.number(f64::from(*charge));
        }
    }

    #[inline]
    fn number(&self, charge_e: f64) -> u16 {
        let level = self.system_gain * charge_e + self.black_level_dn;
        // Adding a half and cutting rounds halves up, which is right for the levels of 0 and more that are left.
        (level.clamp(0.0, self.max_dn) + 0.5) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_rounded_and_clamped() {
        let converter =
            Converter { bits: 12, conversion_gain_dn_per_e: 0.5, black_level_dn: 10, gain_range: [Decibels(0.0); 2] };
        let at = |gain, charge| Digitiser::new(&converter, Decibels(gain)).number(charge);
        assert_eq!([at(0.0, 0.0), at(0.0, 2.0), at(0.0, 2.98), at(0.0, 3.02)], [10, 11, 11, 12]);
        assert_eq!([at(0.0, -8.0), at(0.0, -1e9), at(0.0, 1e9)], [6, 0, 4095]);
        assert_eq!(at(20.0, 2.0), 20, "20 dB is a factor of 10");
    }
}
