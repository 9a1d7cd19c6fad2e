//! Binning: charge or digital numbers of several pixels of one colour become one.

use photosite_core::rows::for_each_row;

use photosite_raw::Cfa;

use crate::signal::charge_plane::ChargePlane;
use crate::{Binning, BinningMethod};

impl Binning {
    /// Adds charge; what makes no whole bin at the end of rows and columns is lost.
    pub(crate) fn add_charge(&self, charge: ChargePlane, cfa: &Cfa) -> ChargePlane {
        if self.is_none() || self.method != BinningMethod::Charge {
            return charge;
        }
        let size = [charge.width, charge.height];
        let (electrons, [width, height]) = self.bins(&charge.electrons, size, cfa, |sum| sum as f32);
        ChargePlane { width, height, samples: charge.samples, electrons }
    }

    /// Adds digital numbers above the black level, up to the largest, or takes their mean; returns them with their
    /// columns and rows.
    pub(crate) fn add_numbers(
        &self,
        numbers: Vec<u16>,
        size: [usize; 2],
        cfa: &Cfa,
        [black, max]: [u16; 2],
    ) -> (Vec<u16>, [usize; 2]) {
        let [black, max] = [black, max].map(i64::from);
        let pixels = self.pixels() as i64;
        let divisor = match self.method {
            BinningMethod::Charge => return (numbers, size),
            BinningMethod::Sum => 1,
            BinningMethod::Mean => pixels,
        };
        if self.is_none() {
            return (numbers, size);
        }
        self.bins(&numbers, size, cfa, |sum| {
            let sum = sum as i64 - pixels * black;
            // The nearest number, halves upwards.
            (black + (2 * sum + divisor).div_euclid(2 * divisor)).clamp(0, max) as u16
        })
    }

    /// Values of all bins: `value` of the sum of each, which is exact for digital numbers. `size`: values in a row, and
    /// rows.
    pub(crate) fn bins<T: Copy + Send + Sync + Default + Into<f64>>(
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
        for_each_row(&mut binned, width, |y, row| {
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
        // Every other pixel, in the Bayer tile's places: R 0 + 2 + 12 + 14, G 1 + 3 + 13 + 15; a column pair is left
        // over.
        assert_eq!(binned("RGGB", [2, 2], 6, &ramp), [28.0, 32.0, 52.0, 56.0]);
        // The blocks of a Quad Bayer are neighbours again.
        assert_eq!(binned("quad-bayer", [2, 2], 4, &ramp[..16]), [10.0, 18.0, 42.0, 50.0]);
        // Detectors of a pixel stay apart.
        assert_eq!(binned("full:RGB", [2, 1], 6, &ramp[..12]), [3.0, 5.0, 7.0, 15.0, 17.0, 19.0]);
    }

    #[test]
    fn numbers_are_added_above_the_black_level() {
        let numbers = |method, values: &[u16]| {
            let size = [values.len(), 1];
            Binning { factor: [2, 1], method }.add_numbers(values.to_vec(), size, &Cfa::mono(), [100, 4095]).0
        };
        assert_eq!(numbers(BinningMethod::Sum, &[101, 103, 90, 95, 4000, 4000]), [104, 85, 4095]);
        // Halves are rounded up: 1.5 and −7.5.
        assert_eq!(numbers(BinningMethod::Mean, &[101, 102, 90, 95, 4000, 4000]), [102, 93, 4000]);
    }
}
