//! Analogue-to-digital conversion: from signals to digital numbers.

use photosite_core::math::hash::{hash64, unit_f32};
use photosite_core::units::Decibels;

use super::frame::Frame;
use crate::model::Converter;
use crate::model::Converters;
use crate::signal::charge_plane::Row;
use crate::signal::effects::Stage;
use crate::signal::noise_key::Streams;
use crate::signal::words::words;

/// The converters of a sensor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Digitiser {
    black_level_dn: f64,
    max_dn: f64,
    nonlinearity: Option<Nonlinearity>,
}

words! {
    /// A converter, or one for each column.
    DigitiserWords {
        black_level_dn: u32,
        max_dn: u32,
        /// 1 where steps are not of equal width, else 0.
        is_nonlinear: u32,
        inl_dn: f32,
        displacement_dn: f32,
        /// 1 where every column has a converter of its own, else 0.
        per_column: u32,
        key_low: u32,
        key_high: u32,
    }
}

/// Steps that are not of equal width.
#[derive(Clone, Copy, Debug)]
struct Nonlinearity {
    /// Integral nonlinearity in the middle of the range, DN.
    inl_dn: f64,
    /// Largest displacement of the threshold between two numbers, DN.
    displacement_dn: f64,
    per_column: bool,
    key: u64,
}

impl Nonlinearity {
    /// `None` for equal steps, and where the stage is switched off (`streams`).
    fn new(converter: &Converter, streams: Option<Streams>) -> Option<Self> {
        let is_ideal = converter.inl_dn == 0.0 && converter.dnl_dn == 0.0;
        let streams = streams.filter(|_| !is_ideal)?;
        Some(Self {
            inl_dn: converter.inl_dn,
            displacement_dn: displacement_dn(converter.dnl_dn),
            per_column: match converter.converters {
                Converters::PerColumn => true,
                Converters::One => false,
            },
            key: streams.key(),
        })
    }

    /// Displacement of the threshold below a number from its place, DN, the same every time.
    #[inline]
    fn displacement(&self, x: usize, number: f64) -> f64 {
        let converter = if self.per_column { x as u64 + 1 } else { 0 };
        let random = hash64(hash64(self.key, converter), number as i64 as u64);
        self.displacement_dn * (2.0 * f64::from(unit_f32((random >> 32) as u32)) - 1.0)
    }

    /// Digital number of a level, which may lie outside the converter's range.
    #[inline]
    fn number(&self, level: f64, max_dn: f64, x: usize) -> f64 {
        let part = level / max_dn;
        let nonlinear = level + bow_dn(self.inl_dn, part);
        let nearest = (nonlinear + 0.5).floor();
        if nonlinear < nearest - 0.5 + self.displacement(x, nearest) {
            nearest - 1.0
        } else if nonlinear >= nearest + 0.5 + self.displacement(x, nearest + 1.0) {
            nearest + 1.0
        } else {
            nearest
        }
    }
}

/// Integral nonlinearity at a part of the range, DN: a bow that is nothing at both ends.
pub(crate) fn bow_dn(inl_dn: f64, part: f64) -> f64 {
    if (0.0..1.0).contains(&part) { inl_dn * 4.0 * part * (1.0 - part) } else { 0.0 }
}

/// Thresholds are displaced evenly by up to u to both sides; the width of a step, a difference of two, then has the
/// standard deviation u·√(2/3), the differential nonlinearity.
fn displacement_dn(dnl_dn: f64) -> f64 {
    dnl_dn * 1.5f64.sqrt()
}

/// Variance of the error of a number from steps of unequal width, DN², on top of the 1/12 of rounding: a threshold
/// displaced by d adds d², on average u²/3.
pub(crate) fn dnl_variance_dn2(dnl_dn: f64) -> f64 {
    displacement_dn(dnl_dn).powi(2) / 3.0
}

impl Digitiser {
    pub(crate) fn new(frame: &Frame<'_>) -> Self {
        Self::of(&frame.sensor.converter, frame.exposure.gain, frame.fixed(Stage::ConverterNonlinearity))
    }

    /// A converter at an analogue gain, of unequal steps, which `streams` decide on; equal without.
    pub(crate) fn of(converter: &Converter, gain: Decibels, streams: Option<Streams>) -> Self {
        Self { nonlinearity: Nonlinearity::new(converter, streams), ..Self::ideal(converter, gain) }
    }

    /// A converter at an analogue gain, of equal steps.
    pub(crate) fn ideal(converter: &Converter, gain: Decibels) -> Self {
        let (black_level_dn, max_dn) = (converter.black_level_dn(gain).into(), converter.max_dn().into());
        Self { black_level_dn, max_dn, nonlinearity: None }
    }

    /// Words of the converter.
    pub(crate) fn words(&self) -> DigitiserWords {
        // Both are whole numbers of at most 16 bits.
        let [black_level_dn, max_dn] = [self.black_level_dn, self.max_dn].map(|number| number as u32);
        let equal = DigitiserWords { black_level_dn, max_dn, ..DigitiserWords::default() };
        self.nonlinearity.map_or(equal, |steps| DigitiserWords {
            is_nonlinear: 1,
            inl_dn: steps.inl_dn as f32,
            displacement_dn: steps.displacement_dn as f32,
            per_column: steps.per_column.into(),
            key_low: steps.key as u32,
            key_high: (steps.key >> 32) as u32,
            ..equal
        })
    }

    /// round(y + black level), clamped to 0 … 2^bits − 1. Noise that goes below zero is kept by the black level.
    #[inline]
    pub(crate) fn convert(&self, row: &Row<'_>, numbers: &mut Row<'_, u16>) {
        match &self.nonlinearity {
            None => {
                for (signal, number) in row.values.iter().zip(numbers.values.iter_mut()) {
                    *number = self.clamp(f64::from(*signal) + self.black_level_dn);
                }
            }
            Some(_) => {
                for (x, (signal, number)) in row.values.iter().zip(numbers.values.iter_mut()).enumerate() {
                    *number = self.number(f64::from(*signal), x);
                }
            }
        }
    }

    /// Digital number of one signal, DN, in column x.
    #[inline]
    pub(crate) fn number(&self, signal_dn: f64, x: usize) -> u16 {
        let level = signal_dn + self.black_level_dn;
        self.clamp(self.nonlinearity.map_or(level, |nonlinearity| nonlinearity.number(level, self.max_dn, x)))
    }

    #[inline]
    fn clamp(&self, level: f64) -> u16 {
        // Adding a half and cutting rounds halves up, which is right for the levels of 0 and more that are left.
        (level.clamp(0.0, self.max_dn) + 0.5) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDEAL: Digitiser = Digitiser { black_level_dn: 10.0, max_dn: 4095.0, nonlinearity: None };

    fn numbers(digitiser: &Digitiser, signals: &mut [f32]) -> Vec<u16> {
        let mut numbers = vec![0; signals.len()];
        digitiser.convert(&Row { y: 0, values: signals }, &mut Row { y: 0, values: &mut numbers });
        numbers
    }

    #[test]
    fn levels_are_rounded_and_clamped() {
        assert_eq!(numbers(&IDEAL, &mut [0.0, 1.0, 1.49, 1.51]), [10, 11, 11, 12]);
        assert_eq!(numbers(&IDEAL, &mut [-4.0, -1e9, 1e9, f32::INFINITY]), [6, 0, 4095, 4095]);
    }

    #[test]
    fn unequal_steps_have_the_stated_spread_and_keep_their_order() {
        let dnl_dn = 0.3;
        for per_column in [false, true] {
            let nonlinearity =
                Nonlinearity { inl_dn: 0.0, displacement_dn: displacement_dn(dnl_dn), per_column, key: 5 };
            let digitiser = Digitiser { nonlinearity: Some(nonlinearity), ..IDEAL };
            // Thresholds to a 64th of a DN, in the first column or the only converter.
            const FINE: f32 = 64.0;
            let number = |i: u32| numbers(&digitiser, &mut [i as f32 / FINE])[0];
            let mut widths = photosite_core::math::statistics::Moments::default();
            let (mut last, mut since) = (number(0), 0);
            for i in 1..(4000.0 * FINE) as u32 {
                let next = number(i);
                assert!(next >= last, "{next} after {last}");
                if next > last {
                    widths.add(f64::from(i - since) / f64::from(FINE));
                    (last, since) = (next, i);
                }
            }
            // 4000 widths, of which neighbours share a threshold; the resolution adds 2/12/64². 5 σ of 1/√(2·4000·⅔).
            let ratio = widths.variance().sqrt() / dnl_dn;
            assert!((ratio - 1.0).abs() < 0.07, "{ratio}");
        }
    }

    #[test]
    fn the_bow_is_highest_in_the_middle() {
        let nonlinearity = Nonlinearity { inl_dn: 20.0, displacement_dn: 0.0, per_column: false, key: 5 };
        let digitiser = Digitiser { black_level_dn: 0.0, max_dn: 4095.0, nonlinearity: Some(nonlinearity) };
        // 20·4·x·(1 − x) at 0, ¼, ½, ¾ and 1.
        assert_eq!(numbers(&digitiser, &mut [0.0, 1023.75, 2047.5, 3071.25, 4095.0]), [0, 1039, 2068, 3086, 4095]);
    }
}
