//! Deviations of pixels, rows and columns that stay from image to image.

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::model::{FixedPattern, MeasuredPattern};
use crate::signal::charge_plane::Row;
use crate::signal::noise_key::Streams;
use crate::signal::words::{NONE, StreamWords, Tables, words};

/// A pattern, normally distributed in each of its parts.
#[derive(Clone, Debug)]
pub(crate) struct Deviations {
    pixel: f32,
    row: f32,
    /// The deviation of every column, empty where they have none.
    columns: Vec<f32>,
    /// Deviations that were measured, in place of random ones.
    measured: Option<MeasuredPattern>,
    streams: Streams,
}

words! {
    /// A pattern: deviations that rows and columns share, and those of each pixel, or measured ones in place of all.
    PatternWords {
        streams: StreamWords,
        pixel: f32,
        /// Place of a deviation for each row.
        rows: u32,
        /// Place of a deviation for each column, or none.
        columns: u32,
        /// Place of a deviation for each pixel, or none.
        measured: u32,
    }
}

/// Parts of the streams of a pattern.
const ROWS: u64 = 0;
const COLUMNS: u64 = 1;

impl Deviations {
    /// The deviations of an image of `width` columns, measured or of a pattern; `None` for a pattern that is flat.
    pub(crate) fn new(
        pattern: &FixedPattern,
        measured: Option<&MeasuredPattern>,
        width: usize,
        streams: Streams,
    ) -> Option<Self> {
        let columns = streams.part(COLUMNS).normals_of_columns(pattern.column, width);
        let [pixel, row] = [pattern.pixel, pattern.row].map(|part| part as f32);
        let measured = measured.cloned();
        (pattern.total() > 0.0).then_some(Self { pixel, row, columns, measured, streams })
    }

    /// Deviation that the pixels of a row share.
    #[inline]
    fn of_row(&self, y: usize) -> f32 {
        let normal: f32 = self.streams.part(ROWS).row(y).sample(StandardNormal);
        self.row * normal
    }

    /// Words of the deviations of so many columns and rows.
    pub(crate) fn words(&self, [width, height]: [usize; 2], tables: &mut Tables) -> PatternWords {
        if let Some(measured) = &self.measured {
            let all: Vec<f32> = (0..height).flat_map(|y| &measured.row(y)[..width]).copied().collect();
            return PatternWords {
                rows: NONE,
                columns: NONE,
                measured: tables.add_numbers(&all),
                ..PatternWords::default()
            };
        }
        let rows: Vec<f32> = (0..height).map(|y| self.of_row(y)).collect();
        PatternWords {
            streams: if self.pixel > 0.0 { self.streams.words() } else { StreamWords::default() },
            pixel: self.pixel,
            rows: tables.add_numbers(&rows),
            columns: tables.add_numbers(&self.columns),
            measured: NONE,
        }
    }

    /// Hands each value of a row to `apply` with the deviation of its pixel.
    #[inline]
    pub(crate) fn apply(&self, row: &mut Row<'_>, apply: impl Fn(f32, f32) -> f32) {
        if let Some(measured) = &self.measured {
            let deviations = measured.row(row.y);
            return row.values.iter_mut().zip(deviations).for_each(|(value, own)| *value = apply(*value, *own));
        }
        let of_row = self.of_row(row.y);
        let shared = |x: usize| of_row + self.columns.get(x).unwrap_or(&0.0);
        if self.pixel > 0.0 {
            self.streams.normals(row, |x, value, n| apply(value, self.pixel * n + shared(x)));
        } else {
            row.values.iter_mut().enumerate().for_each(|(x, value)| *value = apply(*value, shared(x)));
        }
    }
}
