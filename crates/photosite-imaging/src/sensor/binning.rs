//! Binning: several pixels of one colour are read out as one.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::raw::Cfa;
use photosite_core::Invalid;

use super::SensorModel;
use super::charge_plane::ChargePlane;

/// How many pixels become one, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binning {
    /// Columns and rows of pixels in a bin, each 1 or more.
    pub factor: [usize; 2],
    /// What is added up.
    pub method: BinningMethod,
}

/// Where in the chain pixels are binned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BinningMethod {
    /// Their charge is added before it is read out, so that a bin has the read noise of one pixel.
    Charge,
    /// Their numbers are added, from the black level on, and end where the converter's range does.
    Sum,
    /// The mean of their numbers, rounded.
    Mean,
}

/// Most pixels along a side of a bin: cameras offer up to 4, instruments up to 16.
const MAX_FACTOR: usize = 16;

impl Binning {
    /// Every pixel by itself.
    pub const NONE: Self = Self { factor: [1, 1], method: BinningMethod::Mean };

    /// Pixels in a bin.
    pub fn pixels(&self) -> usize {
        self.factor[0] * self.factor[1]
    }

    fn is_none(&self) -> bool {
        self.pixels() == 1
    }

    /// What the signal of an amplifier is, over that of a single pixel.
    pub(super) fn charge_gain(&self) -> f64 {
        match self.method {
            BinningMethod::Charge => self.pixels() as f64,
            BinningMethod::Sum | BinningMethod::Mean => 1.0,
        }
    }

    /// What a number is, over the mean of the numbers of its pixels.
    pub(super) fn digital_gain(&self) -> f64 {
        match self.method {
            BinningMethod::Sum => self.pixels() as f64,
            BinningMethod::Charge | BinningMethod::Mean => 1.0,
        }
    }

    /// Refuses what a sensor cannot do. Keys are those of the capture file's `[exposure]` table.
    pub(super) fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        if self.factor.iter().any(|n| !(1..=MAX_FACTOR).contains(n)) {
            let message = format!("must be from 1 to {MAX_FACTOR} along both sides, got {:?}", self.factor);
            return Err(Invalid::new("binning", message).help("for example binning = [2, 2]"));
        }
        if self.is_none() {
            return Ok(());
        }
        let has_no_charge = sensor.architecture.spad().is_some() || sensor.logarithmic.is_some();
        if self.method == BinningMethod::Charge && has_no_charge {
            let message = format!("sensor {} has no charge to add", sensor.name);
            return Err(Invalid::new("binning_method", message).help("write \"sum\" or \"mean\""));
        }
        let prescan = sensor.architecture.ccd().map_or(0, |ccd| ccd.overscan.prescan_columns);
        let before = [prescan + sensor.masked.columns[0], sensor.masked.rows[0]];
        let cell = self.cell(&sensor.cfa);
        for (axis, what) in ["columns", "rows"].into_iter().enumerate() {
            if !before[axis].is_multiple_of(cell[axis]) {
                let message = format!("{} covered {what} before the picture make no whole bins", before[axis]);
                let help = format!("change masked_{what} to a multiple of {}", cell[axis]);
                return Err(Invalid::new("binning", message).help(help));
            }
        }
        Ok(())
    }

    /// Columns and rows of whole bins among so many of pixels.
    pub(super) fn whole_bins(&self, pixels: [usize; 2], cfa: &Cfa) -> [usize; 2] {
        let cell = self.cell(cfa);
        [0, 1].map(|axis| pixels[axis] / cell[axis] * (cell[axis] / self.factor[axis]))
    }

    /// Pixels after which bins repeat, along both sides.
    pub(super) fn cell(&self, cfa: &Cfa) -> [usize; 2] {
        let (_, step) = cfa.binned(self.factor);
        [0, 1].map(|axis| step[axis] * self.factor[axis])
    }

    /// The layout of the bins.
    pub(super) fn layout(&self, cfa: &Cfa) -> Cfa {
        cfa.binned(self.factor).0
    }

    /// Adds charge; what makes no whole bin at the end of rows and columns is lost.
    pub(super) fn add_charge(&self, charge: ChargePlane, cfa: &Cfa) -> ChargePlane {
        if self.is_none() || self.method != BinningMethod::Charge {
            return charge;
        }
        let size = [charge.width, charge.height];
        let (electrons, [width, height]) = self.bins(&charge.electrons, size, cfa, |sum| sum as f32);
        ChargePlane { width, height, samples: charge.samples, electrons }
    }

    /// Adds numbers or takes their mean, and says how many there are then in a row, and rows.
    pub(super) fn add_numbers(
        &self,
        numbers: Vec<u16>,
        size: [usize; 2],
        sensor: &SensorModel,
    ) -> (Vec<u16>, [usize; 2]) {
        let black = i64::from(sensor.converter.black_level_dn);
        let max = i64::from(sensor.converter.max_dn());
        let pixels = self.pixels() as i64;
        let divisor = match self.method {
            BinningMethod::Charge => return (numbers, size),
            BinningMethod::Sum => 1,
            BinningMethod::Mean => pixels,
        };
        if self.is_none() {
            return (numbers, size);
        }
        self.bins(&numbers, size, &sensor.cfa, |sum| {
            let sum = sum as i64 - pixels * black;
            // The nearest number, halves upwards.
            (black + (2 * sum + divisor).div_euclid(2 * divisor)).clamp(0, max) as u16
        })
    }

    /// What `value` makes of the sum of every bin, which is exact for numbers. `size`: values in a row, and rows.
    pub(super) fn bins<T: Copy + Send + Sync + Default + Into<f64>>(
        &self,
        values: &[T],
        size: [usize; 2],
        cfa: &Cfa,
        value: impl Fn(f64) -> T + Sync,
    ) -> (Vec<T>, [usize; 2]) {
        let samples = cfa.samples_per_pixel();
        let pixels = [size[0] / samples, size[1]];
        let (_, step) = cfa.binned(self.factor);
        let cell = self.cell(cfa);
        let bins = self.whole_bins(pixels, cfa);
        // The first pixel of a bin; the others follow at distances of a step.
        let first = |bin: usize, axis: usize| bin / step[axis] * cell[axis] + bin % step[axis];
        let width = bins[0] * samples;
        let mut binned = vec![T::default(); width * bins[1]];
        binned.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (i, bin) in row.iter_mut().enumerate() {
                let (x, sample) = (first(i / samples, 0), i % samples);
                let y = first(y, 1);
                let sum = (0..self.pixels()).map(|n| -> f64 {
                    let (x, y) = (x + n % self.factor[0] * step[0], y + n / self.factor[0] * step[1]);
                    values[y * size[0] + x * samples + sample].into()
                });
                *bin = value(sum.sum());
            }
        });
        (binned, [width, bins[1]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::presets;

    fn binned(cfa: &str, factor: [usize; 2], width: usize, values: &[f32]) -> Vec<f32> {
        let cfa = Cfa::parse(cfa).expect("a layout");
        let binning = Binning { factor, method: BinningMethod::Charge };
        let samples = cfa.samples_per_pixel();
        let charge = ChargePlane { width, height: values.len() / width, samples, electrons: values.to_vec() };
        binning.add_charge(charge, &cfa).electrons
    }

    #[test]
    fn pixels_of_one_colour_are_added() {
        let ramp: Vec<f32> = (0..24).map(|i| i as f32).collect();
        // Neighbours: 0 + 1 + 6 + 7 …
        assert_eq!(binned("mono", [2, 2], 6, &ramp), [14.0, 22.0, 30.0, 62.0, 70.0, 78.0]);
        // Every other pixel, in the Bayer tile's places: R 0 + 2 + 12 + 14, G 1 + 3 + 13 + 15; a column pair is left over.
        assert_eq!(binned("RGGB", [2, 2], 6, &ramp), [28.0, 32.0, 52.0, 56.0]);
        // The blocks of a Quad Bayer are neighbours again.
        assert_eq!(binned("quad-bayer", [2, 2], 4, &ramp[..16]), [10.0, 18.0, 42.0, 50.0]);
        // Detectors of a pixel stay apart.
        assert_eq!(binned("full:RGB", [2, 1], 6, &ramp[..12]), [3.0, 5.0, 7.0, 15.0, 17.0, 19.0]);
    }

    #[test]
    fn numbers_are_added_above_the_black_level() {
        let mut sensor = presets::model("sony-imx249-mono").expect("a preset");
        sensor.converter.black_level_dn = 100;
        let numbers = |method, values: &[u16]| {
            Binning { factor: [2, 1], method }.add_numbers(values.to_vec(), [values.len(), 1], &sensor).0
        };
        assert_eq!(numbers(BinningMethod::Sum, &[101, 103, 90, 95, 4000, 4000]), [104, 85, 4095]);
        // Halves are rounded up: 1.5 and −7.5.
        assert_eq!(numbers(BinningMethod::Mean, &[101, 102, 90, 95, 4000, 4000]), [102, 93, 4000]);
    }

    #[test]
    fn layouts_keep_their_colours_or_shrink() {
        for (cfa, factor, bins) in [
            ("mono", [3, 2], "mono"),
            ("RGGB", [2, 2], "RGGB"),
            ("GBRG", [3, 1], "GBRG"),
            ("x-trans", [2, 2], "x-trans"),
            ("quad-bayer", [2, 2], "RGGB"),
            ("nona-bayer", [3, 3], "RGGB"),
            ("quad-bayer", [4, 4], "quad-bayer"),
            ("full:RGB", [2, 2], "full:RGB"),
        ] {
            let layout = Cfa::parse(cfa).expect("a layout").binned(factor).0;
            assert_eq!(layout, Cfa::parse(bins).expect("a layout"), "{cfa} by {factor:?}");
        }
    }
}
