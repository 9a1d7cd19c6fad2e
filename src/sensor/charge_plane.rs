//! The charge of all pixels on its way through the stages: one plane of electrons, changed in place.
//!
//! Most effects are a pixel's own and work row by row, all rows at once ([`RowStage`]); a row stays in the cache while
//! one stage after another passes over it. Those by which pixels touch each other get the whole [`ChargePlane`].

use rayon::prelude::*;

/// Electrons of every pixel, row by row from the top-left one, e⁻.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ChargePlane {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) electrons: Vec<f32>,
}

/// One row of values: electrons, and behind the amplifiers digital numbers that are not yet rounded.
#[derive(Debug)]
pub(super) struct Row<'a> {
    /// Its number from the top.
    pub(super) y: usize,
    pub(super) values: &'a mut [f32],
}

/// An effect that each pixel suffers by itself. A stage that is switched off or that the sensor does not have is `None`,
/// and does nothing.
pub(super) trait RowStage {
    /// Changes a row.
    fn apply(&self, row: &mut Row<'_>);
}

impl<S: RowStage> RowStage for Option<S> {
    #[inline]
    fn apply(&self, row: &mut Row<'_>) {
        if let Some(stage) = self {
            stage.apply(row);
        }
    }
}

impl ChargePlane {
    /// A plane without charge.
    pub(super) fn empty(width: usize, height: usize) -> Self {
        Self { width, height, electrons: vec![0.0; width * height] }
    }

    /// Changes all rows, in any order.
    pub(super) fn for_each_row(&mut self, change: impl Fn(&mut Row<'_>) + Sync) {
        let rows = self.electrons.par_chunks_mut(self.width.max(1));
        rows.enumerate().for_each(|(y, values)| change(&mut Row { y, values }));
    }

    /// Reads all rows out, in any order, into the digital numbers of their pixels.
    pub(super) fn read_out(mut self, read: impl Fn(&mut Row<'_>, &mut [u16]) + Sync) -> Vec<u16> {
        let mut numbers = vec![0; self.electrons.len()];
        let width = self.width.max(1);
        let rows = self.electrons.par_chunks_mut(width).zip(numbers.par_chunks_mut(width));
        rows.enumerate().for_each(|(y, (values, numbers))| read(&mut Row { y, values }, numbers));
        numbers
    }
}
