//! Row and column noise: what all pixels of a row, or of a column, get from the supply and the amplifiers that they
//! share, anew in every image.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::frame::Frame;
use crate::signal::charge_plane::{Row, RowStage};
use crate::signal::effects::{NoiseMap, Stage};
use crate::signal::noise_key::Streams;
use crate::signal::words::Tables;

/// Adds to every row a number of its own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowNoise {
    standard_deviation_e: f32,
    streams: Streams,
}

impl RowNoise {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let standard_deviation_e = frame.read_out_noise().row.0 as f32;
        let streams = frame.temporal(Stage::RowNoise).filter(|_| standard_deviation_e > 0.0)?;
        Some(Self { standard_deviation_e, streams })
    }

    /// Noise that a row gets, e⁻.
    #[inline]
    fn of_row(&self, y: usize) -> f32 {
        let normal: f32 = self.streams.row(y).sample(StandardNormal);
        self.standard_deviation_e * normal
    }

    /// Place of the noise of each row in the tables.
    pub(crate) fn words(&self, frame: &Frame<'_>, tables: &mut Tables) -> u32 {
        let rows: Vec<f32> = (0..frame.size[1]).map(|y| self.of_row(y)).collect();
        tables.add_numbers(&rows)
    }
}

impl RowStage for RowNoise {
    const MAP: NoiseMap = Stage::RowNoise.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        let noise = self.of_row(row.y);
        row.values.iter_mut().for_each(|charge| *charge += noise);
    }
}

/// Adds to every column a number of its own.
#[derive(Clone, Debug)]
pub(crate) struct ColumnNoise {
    of_columns: Vec<f32>,
}

impl ColumnNoise {
    pub(crate) fn new(frame: &Frame<'_>) -> Option<Self> {
        let standard_deviation_e = frame.read_out_noise().column.0;
        let streams = frame.temporal(Stage::ColumnNoise).filter(|_| standard_deviation_e > 0.0)?;
        Some(Self { of_columns: streams.normals_of_columns(standard_deviation_e, frame.size[0]) })
    }

    /// Place of the noise of each column in the tables.
    pub(crate) fn words(&self, tables: &mut Tables) -> u32 {
        tables.add_numbers(&self.of_columns)
    }
}

impl RowStage for ColumnNoise {
    const MAP: NoiseMap = Stage::ColumnNoise.map();

    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        row.values.iter_mut().zip(&self.of_columns).for_each(|(charge, noise)| *charge += noise);
    }
}
