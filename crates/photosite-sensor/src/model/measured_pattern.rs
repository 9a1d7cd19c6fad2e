//! Measured patterns: a value for each pixel of one sensor, from a file, in place of standard deviations.

use std::sync::Arc;

use photosite_core::Invalid;
use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::fixed_pattern::FixedPattern;

/// An image of one channel, EXR, NPY or TIFF, with a value for each pixel.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(deny_unknown_fields)]
pub struct PatternFile {
    /// Path of the file, relative to the file that names it.
    pub file: String,
}

/// Pattern of a sensor, measured: deviations of its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredPattern {
    size: [usize; 2],
    /// Deviations row by row, shared between the copies of a sensor.
    deviations: Arc<[f32]>,
}

impl MeasuredPattern {
    /// Values of an image of these columns and rows.
    ///
    /// # Errors
    ///
    /// Values that are not finite, or not of so many pixels.
    pub fn new(size: [usize; 2], values: Vec<f32>) -> Result<Self, Invalid> {
        let [width, height] = size;
        if values.len() != width * height {
            return Err(Invalid::new("", format!("{} values for {width} × {height} pixels", values.len())));
        }
        if let Some(pixel) = values.iter().position(|value| !value.is_finite()) {
            let message = format!("holds {} at column {}, row {}", values[pixel], pixel % width, pixel / width);
            return Err(Invalid::new("", message).help("write finite numbers"));
        }
        Ok(Self { size, deviations: values.into() })
    }

    /// Deviations of a row.
    pub(crate) fn row(&self, y: usize) -> &[f32] {
        &self.deviations[y * self.size[0]..][..self.size[0]]
    }

    pub(super) fn mean(&self) -> f64 {
        self.deviations.iter().map(|&value| f64::from(value)).sum::<f64>() / self.deviations.len() as f64
    }

    /// The pattern with each value replaced.
    pub(super) fn map(&self, change: impl Fn(f64) -> f64) -> Self {
        let deviations = self.deviations.iter().map(|&value| change(f64::from(value)) as f32).collect();
        Self { size: self.size, deviations }
    }

    /// Standard deviations of rows, columns and single pixels; the mean of the deviations is 0. Means of rows hold their share of
    /// the pixels' variance, s²/N of N columns, which is none of theirs.
    pub(super) fn statistics(&self) -> FixedPattern {
        let [width, height] = self.size;
        let mut sums = [vec![0.0; height], vec![0.0; width]];
        for (i, &value) in self.deviations.iter().enumerate() {
            sums[0][i / width] += f64::from(value) / width as f64;
            sums[1][i % width] += f64::from(value) / height as f64;
        }
        let [rows, columns] = sums;
        let rest = |(i, &value): (usize, &f32)| (f64::from(value) - rows[i / width] - columns[i % width]).powi(2);
        let freedom = ((width - 1) * (height - 1)).max(1) as f64;
        let pixel = self.deviations.iter().enumerate().map(rest).sum::<f64>() / freedom;
        let of_lines = |means: &[f64], length: usize| {
            let square = means.iter().map(|mean| mean * mean).sum::<f64>() / (means.len() - 1).max(1) as f64;
            (square - pixel / length as f64).max(0.0).sqrt()
        };
        FixedPattern { pixel: pixel.sqrt(), row: of_lines(&rows, width), column: of_lines(&columns, height) }
    }

    /// Columns and rows.
    pub(super) fn size(&self) -> [usize; 2] {
        self.size
    }
}
