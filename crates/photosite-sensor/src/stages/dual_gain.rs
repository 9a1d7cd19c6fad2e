//! Dual gain: two amplifiers with a converter each look at the charge of a pixel, one with a high gain and little
//! noise, one with a low gain that takes the full well. Their numbers are merged into one of more bits.
//!
//! The number of the high gain counts unless it lies in the top sixteenth of its range, where it may be clipped. The
//! dynamic range is then that from the noise of the one to the range of the other.

use photosite_core::units::{Decibels, Electrons};

use super::converter::{Digitiser, DigitiserWords};
use super::frame::Frame;
use super::read_noise::ReadNoiseSpread;
use crate::model::{Converter, DualGain};
use crate::signal::charge_plane::Row;
use crate::signal::effects::Stage;
use crate::signal::noise_key::Streams;
use crate::signal::words::{LogNormalWords, StreamWords, Tables, Wide, words};

impl DualGain {
    /// Threshold, DN: from this number on the high gain does not count.
    fn threshold_dn(&self) -> u16 {
        self.high.max_dn() - self.high.max_dn() / 16
    }

    /// Whether the low gain counts for an amplified charge.
    pub(crate) fn is_clipped(&self, charge_e: f64, gain: Decibels) -> bool {
        let level = f64::from(self.high.black_level_dn(gain)) + self.high.system_gain(gain) * charge_e;
        level >= self.threshold_dn().into()
    }
}

words! {
    /// Branch of one amplifier and its converter.
    BranchWords {
        streams: StreamWords,
        read_noise_e: f32,
        factors: LogNormalWords,
        system_gain: Wide,
        digitiser: DigitiserWords,
        /// Place of the merged number of each of its numbers.
        merged: u32,
    }

    /// Two gains, whose numbers are merged.
    DualGainWords {
        /// 1 for a sensor with two gains, else 0.
        is_there: u32,
        threshold_dn: u32,
        high: BranchWords,
        low: BranchWords,
    }
}

/// Both converters at one gain setting, and the merger.
#[derive(Clone, Debug)]
pub(crate) struct DualGainDigitiser {
    high: Branch,
    low: Branch,
    /// Threshold, DN: from this number on the high gain does not count.
    threshold_dn: u16,
    merged: Digitiser,
    /// System gain of the merged numbers, DN/e⁻.
    system_gain: f64,
    /// Range of mean charge that the low gain has numbers for, e⁻: least and most.
    range_of_mean_e: Option<[f32; 2]>,
}

/// Branch of one amplifier and its converter.
#[derive(Clone, Debug)]
struct Branch {
    read_noise_e: f32,
    spread: Option<ReadNoiseSpread>,
    streams: Option<Streams>,
    digitiser: Digitiser,
    system_gain: f64,
    black_level_dn: f64,
}

impl DualGainDigitiser {
    /// `None` for sensors with one gain.
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let (converter, gain) = (&frame.sensor.converter, frame.exposure.gain);
        let dual = converter.dual_gain.as_deref()?;
        let DualGain { high, low, low_read_noise } = dual;
        let steps = frame.fixed(Stage::ConverterNonlinearity);
        let spread = ReadNoiseSpread::new(frame);
        let branch = |converter: &Converter, noise: Electrons, stage, number| Branch {
            read_noise_e: noise.0 as f32,
            spread,
            streams: frame.temporal(stage),
            digitiser: Digitiser::of(converter, gain, steps.map(|streams| streams.part(number))),
            system_gain: converter.system_gain(gain),
            black_level_dn: converter.black_level_dn(gain).into(),
        };
        let low_branch = branch(low, *low_read_noise, Stage::LowGainReadNoise, 1);
        Some(Self {
            high: branch(high, frame.read_out_noise().read, Stage::ReadNoise, 0),
            range_of_mean_e: frame.is_mean.then(|| [0, low.max_dn()].map(|number| low_branch.electrons(number) as f32)),
            low: low_branch,
            threshold_dn: dual.threshold_dn(),
            merged: Digitiser::ideal(converter, gain),
            system_gain: converter.system_gain(gain),
        })
    }

    /// Words of both branches.
    pub(crate) fn words(&self, tables: &mut Tables) -> DualGainWords {
        let mut branch = |branch: &Branch| {
            let digitiser = branch.digitiser.words();
            let merged = |number: u32| self.merged(branch.electrons(number as u16), 0).into();
            BranchWords {
                streams: branch.streams.map(|streams| streams.words()).unwrap_or_default(),
                read_noise_e: branch.read_noise_e,
                factors: branch.spread.map(|spread| spread.words()).unwrap_or_default(),
                system_gain: Wide::new(branch.system_gain),
                digitiser,
                merged: tables.add((0..=digitiser.max_dn).map(merged)),
            }
        };
        DualGainWords {
            is_there: 1,
            threshold_dn: self.threshold_dn.into(),
            high: branch(&self.high),
            low: branch(&self.low),
        }
    }

    /// The merged number of a charge; its converter is ideal, and the same for all columns.
    #[inline]
    fn merged(&self, estimate_e: f64, x: usize) -> u16 {
        self.merged.number(self.system_gain * estimate_e, x)
    }

    /// Converts a row of charges twice and merges the numbers. The charges are left with the noise of the amplifier
    /// that counts; mean charge ends where their numbers do.
    pub(crate) fn convert(&self, row: &mut Row<'_>, numbers: &mut Row<'_, u16>) {
        for (x, (charge_e, number)) in row.values.iter_mut().zip(numbers.values.iter_mut()).enumerate() {
            let noisy_e = self.high.with_noise(*charge_e, x, row.y);
            let high = self.high.convert(noisy_e, x);
            let estimate_e = if high < self.threshold_dn {
                *charge_e = noisy_e;
                self.high.electrons(high)
            } else {
                *charge_e = self.low.with_noise(*charge_e, x, row.y);
                self.low.electrons(self.low.convert(*charge_e, x))
            };
            *number = self.merged(estimate_e, x);
            if let Some([least_e, most_e]) = self.range_of_mean_e {
                *charge_e = charge_e.clamp(least_e, most_e);
            }
        }
    }
}

impl Branch {
    fn with_noise(&self, charge_e: f32, x: usize, y: usize) -> f32 {
        let Some(streams) = &self.streams else { return charge_e };
        let own = self.spread.map_or(1.0, |spread| spread.factor(x, y) as f32);
        charge_e + self.read_noise_e * own * streams.normal(x, y)
    }

    fn convert(&self, charge_e: f32, x: usize) -> u16 {
        self.digitiser.number(self.system_gain * f64::from(charge_e), x)
    }

    /// The charge that a number stands for.
    fn electrons(&self, number: u16) -> f64 {
        (f64::from(number) - self.black_level_dn) / self.system_gain
    }
}
