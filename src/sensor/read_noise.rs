//! Read noise: what the amplifiers between pixel and converter add, referred to the charge at their input.

use super::charge_plane::{Row, RowStage};
use super::expose::Frame;
use super::noise_key::Streams;
use super::stage::Stage;

/// Adds normally distributed noise.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReadNoise {
    standard_deviation_e: f32,
    streams: Streams,
}

impl ReadNoise {
    pub(super) fn new(frame: &Frame<'_>) -> Option<Self> {
        let standard_deviation_e = frame.sensor.noise.read.0 as f32;
        let streams = frame.temporal(Stage::ReadNoise).filter(|_| standard_deviation_e > 0.0)?;
        Some(Self { standard_deviation_e, streams })
    }
}

impl RowStage for ReadNoise {
    /// The signal with noise, e⁻; below zero it stays.
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        self.streams.normals(row, |_, charge, n| charge + self.standard_deviation_e * n);
    }
}
