//! Binning: several pixels of one colour are read out as one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use photosite_raw::Cfa;

use crate::{SensorModel, Use};

/// Binning: the number of pixels that become one, and the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binning {
    /// Columns and rows of pixels in a bin, each 1 or more.
    pub factor: [usize; 2],
    /// Quantity that is added up: charge, or digital numbers.
    pub method: BinningMethod,
}

/// Quantity that binning adds up, and the place in the signal chain where it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum BinningMethod {
    /// Charge of the pixels is added before it is read out, so that a bin has the read noise of one pixel.
    Charge,
    /// Digital numbers are added, from the black level on, and end where the converter's range does.
    Sum,
    /// Mean of the digital numbers, rounded.
    Mean,
}

/// Most pixels along a side of a bin: cameras offer up to 4, instruments up to 16.
const MAX_FACTOR: usize = 16;

impl Binning {
    /// Readout of every pixel by itself.
    pub const NONE: Self = Self { factor: [1, 1], method: BinningMethod::Mean };

    /// Pixels in a bin.
    pub fn pixels(&self) -> usize {
        self.factor[0] * self.factor[1]
    }

    pub(crate) fn is_none(&self) -> bool {
        self.pixels() == 1
    }

    /// Columns and rows of converted numbers that become one: 1, 1 where charge is binned.
    pub(crate) fn numbers(&self) -> [usize; 2] {
        match self.method {
            BinningMethod::Charge => [1, 1],
            BinningMethod::Sum | BinningMethod::Mean => self.factor,
        }
    }

    /// Pixels whose charge becomes one number.
    pub(crate) fn pixels_per_number(&self) -> f64 {
        let [across, down] = self.numbers();
        (self.pixels() / (across * down)) as f64
    }

    /// Weight of each converted number in what is read out.
    pub(crate) fn weight(&self) -> f64 {
        match self.method {
            BinningMethod::Charge | BinningMethod::Sum => 1.0,
            BinningMethod::Mean => 1.0 / self.pixels() as f64,
        }
    }

    /// Refuses what a sensor cannot do. Keys are those of the capture file's `[exposure]` table.
    pub(crate) fn validate(&self, sensor: &SensorModel) -> Result<(), Invalid> {
        if self.factor.iter().any(|n| !(1..=MAX_FACTOR).contains(n)) {
            let message = format!("must be from 1 to {MAX_FACTOR} along both sides, got {:?}", self.factor);
            return Err(Invalid::new("binning", message).help("for example binning = [2, 2]"));
        }
        if self.is_none() {
            return Ok(());
        }
        sensor.allows(Use::Binning)?;
        if self.method != BinningMethod::Charge {
            sensor.allows(Use::BinningOfNumbers)?;
        }
        let has_no_charge = sensor.architecture.spad().is_some() || sensor.logarithmic.is_some();
        if self.method == BinningMethod::Charge && has_no_charge {
            let message = format!("sensor {} has no charge to add", sensor.name);
            return Err(Invalid::new("binning_method", message).help("write \"sum\" or \"mean\""));
        }
        if self.method == BinningMethod::Charge && sensor.noise.dsnu_map.is_some() {
            let message =
                "adds charge before it is read out, and noise.dsnu_map of the sensor has offsets of single pixels";
            return Err(Invalid::new("binning_method", message).help("write \"sum\" or \"mean\""));
        }
        let prescan = sensor.architecture.ccd().map_or(0, |ccd| ccd.overscan.prescan_columns);
        let before = [prescan + sensor.masked.columns[0], sensor.masked.rows[0]];
        let cell = self.cell(&sensor.cfa);
        for (axis, what) in ["columns", "rows"].into_iter().enumerate() {
            if !before[axis].is_multiple_of(cell[axis]) {
                let message = format!("{} covered {what} before the image make no whole bins", before[axis]);
                let help = format!("change masked_{what} to a multiple of {}", cell[axis]);
                return Err(Invalid::new("binning", message).help(help));
            }
        }
        Ok(())
    }

    /// Columns and rows of whole bins in an image with these columns and rows of pixels.
    pub fn whole_bins(&self, pixels: [usize; 2], cfa: &Cfa) -> [usize; 2] {
        let cell = self.cell(cfa);
        [0, 1].map(|axis| pixels[axis] / cell[axis] * (cell[axis] / self.factor[axis]))
    }

    /// Pixels after which bins repeat, along both sides.
    pub(crate) fn cell(&self, cfa: &Cfa) -> [usize; 2] {
        let (_, step) = cfa.binned(self.factor);
        [0, 1].map(|axis| step[axis] * self.factor[axis])
    }

    /// The layout of the bins.
    pub(crate) fn layout(&self, cfa: &Cfa) -> Cfa {
        cfa.binned(self.factor).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
