//! Amplifiers: from electrons to the converter's units. They may be nonlinear, and those of columns may differ.

use super::frame::Frame;
use crate::model::{Converter, SensorModel};
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::words::{Tables, words};

impl SensorModel {
    /// The signal that leaves the amplifiers for a charge q, referred to electrons: q·(1 + c₁·q/F + c₂·(q/F)² + …),
    /// with the full well F. Beyond the full well and below zero the factor is that of the end.
    pub fn amplified(&self, charge_e: f64) -> f64 {
        charge_e * factor(&self.converter, (charge_e / self.full_well.0).clamp(0.0, 1.0))
    }

    /// The charge that leaves the amplifiers as `signal_e`, the inverse of [`Self::amplified`].
    pub fn charge_for(&self, signal_e: f64) -> f64 {
        let at_full_well = factor(&self.converter, 1.0);
        if self.converter.amplifier_nonlinearity.is_empty() || signal_e <= 0.0 {
            return signal_e;
        }
        if signal_e >= self.full_well.0 * at_full_well {
            return signal_e / at_full_well;
        }
        // It rises, so halving finds it, to a 2⁻⁶⁰th of the full well.
        let (mut low, mut high) = (0.0, self.full_well.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.amplified(middle) < signal_e { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

/// 1 + c₁·x + c₂·x² + …
#[inline]
fn factor(converter: &Converter, x: f64) -> f64 {
    1.0 + x * converter.amplifier_nonlinearity.iter().rev().fold(0.0, |sum, c| c + sum * x)
}

words! {
    /// Amplifiers whose gain depends on the signal: coefficients c₁, c₂ …; none where they are linear.
    AmplifierWords {
        coefficients: u32,
        count: u32,
        full_well_e: f32,
    }
}

/// Amplifiers whose gain depends on the signal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AmplifierNonlinearity<'a> {
    sensor: &'a SensorModel,
}

impl<'a> AmplifierNonlinearity<'a> {
    pub(crate) fn new(frame: &Frame<'a>) -> Option<Self> {
        let sensor = frame.sensor;
        let is_linear = sensor.converter.amplifier_nonlinearity.is_empty();
        (frame.stages.has(Stage::AmplifierNonlinearity) && !is_linear).then_some(Self { sensor })
    }

    /// Words of the stage.
    pub(crate) fn words(&self, tables: &mut Tables) -> AmplifierWords {
        let coefficients: Vec<f32> = self.sensor.converter.amplifier_nonlinearity.iter().map(|c| *c as f32).collect();
        AmplifierWords {
            coefficients: tables.add_numbers(&coefficients),
            count: coefficients.len() as u32,
            full_well_e: self.sensor.full_well.0 as f32,
        }
    }
}

impl RowStage for AmplifierNonlinearity<'_> {
    const MAP: NoiseMap = Stage::AmplifierNonlinearity.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|signal| *signal = self.sensor.amplified(f64::from(*signal)) as f32);
    }
}

/// The gain that turns electrons into digital numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gain {
    system_gain: f32,
}

impl Gain {
    pub(crate) fn new(frame: &Frame<'_>) -> Self {
        Self { system_gain: frame.sensor.converter.system_gain(frame.exposure.gain) as f32 }
    }

    /// Gain K, DN/e⁻.
    pub(crate) fn word(&self) -> f32 {
        self.system_gain
    }

    /// y = K·q.
    #[inline]
    pub(crate) fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().for_each(|signal| *signal *= self.system_gain);
    }
}

/// Amplifiers of columns that differ in gain and offset, always in the same way.
#[derive(Clone, Debug)]
pub(crate) struct ColumnAmplifiers {
    /// Relative deviations of the gain, empty for none.
    gains: Vec<f32>,
    /// Offsets in DN, empty for none.
    offsets: Vec<f32>,
}

impl ColumnAmplifiers {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let Converter { column_gain, column_offset_dn, .. } = frame.sensor.converter;
        let streams = frame.fixed(Stage::ColumnAmplifiers).filter(|_| column_gain > 0.0 || column_offset_dn > 0.0)?;
        Some(Self {
            gains: streams.part(0).normals_of_columns(column_gain, frame.size[0]),
            offsets: streams.part(1).normals_of_columns(column_offset_dn, frame.size[0]),
        })
    }

    /// Places of gains and offsets in the tables.
    pub(crate) fn words(&self, tables: &mut Tables) -> [u32; 2] {
        [&self.gains, &self.offsets].map(|list| tables.add_numbers(list))
    }
}

impl RowStage for ColumnAmplifiers {
    const MAP: NoiseMap = Stage::ColumnAmplifiers.map();

    /// y·(1 + g) + o with the deviation g and offset o of the column.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().zip(&self.gains).for_each(|(signal, deviation)| *signal += *signal * deviation);
        row.values.iter_mut().zip(&self.offsets).for_each(|(signal, offset)| *signal += offset);
    }
}
