//! The charge of all pixels on its way through the stages: one plane of electrons, changed in place.
//!
//! Most effects are a pixel's own and work row by row, all rows at once ([`RowStage`]); a row stays in the cache while
//! one stage after another passes over it. Those by which pixels touch each other get the whole [`ChargePlane`].

use rayon::prelude::*;

use super::effects::NoiseMap;
use photosite_core::rows;

/// Electrons of every pixel, row by row from the top-left one, e⁻.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ChargePlane {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Values of a pixel, one beside the other: more than one where it has several detectors.
    pub(crate) samples: usize,
    pub(crate) electrons: Vec<f32>,
}

/// One row of values: electrons, behind the amplifiers signals in DN, and behind the converter digital numbers.
#[derive(Debug)]
pub(crate) struct Row<'a, T = f32> {
    /// Index of the row, from the top.
    pub(crate) y: usize,
    pub(crate) values: &'a mut [T],
}

/// An effect that each pixel suffers by itself. A stage that is switched off or that the sensor does not have is
/// `None`, and does nothing.
pub(crate) trait RowStage<T = f32> {
    /// Noise map that records the change.
    const MAP: NoiseMap;

    /// Changes a row.
    fn apply(&self, row: &mut Row<'_, T>);
}

impl<T, S: RowStage<T>> RowStage<T> for Option<S> {
    const MAP: NoiseMap = S::MAP;

    #[inline]
    fn apply(&self, row: &mut Row<'_, T>) {
        if let Some(stage) = self {
            stage.apply(row);
        }
    }
}

/// Changes all rows of values, in any order.
pub(crate) fn for_each_row<T: Send>(values: &mut [T], width: usize, change: impl Fn(&mut Row<'_, T>) + Sync) {
    rows::for_each_row(values, width, |y, values| change(&mut Row { y, values }));
}

impl ChargePlane {
    /// A plane without charge. `width` counts values.
    pub(crate) fn empty(width: usize, height: usize, samples: usize) -> Self {
        Self { width, height, samples, electrons: vec![0.0; width * height] }
    }

    /// Changes all columns, in any order, into those of a plane that is `height` values high: values after the last row
    /// are 0 before the change.
    pub(crate) fn map_columns(&self, height: usize, change: impl Fn(usize, &mut [f64]) + Sync) -> Self {
        let mut columns = vec![0.0f32; self.width * height];
        columns.par_chunks_mut(height.max(1)).enumerate().for_each_init(Vec::new, |line, (x, column)| {
            line.clear();
            line.extend(self.electrons.iter().skip(x).step_by(self.width).map(|&e| f64::from(e)));
            line.resize(height, 0.0);
            change(x, line);
            column.iter_mut().zip(line).for_each(|(to, from)| *to = *from as f32);
        });
        let mut rows = Self::empty(self.width, height, self.samples);
        rows.for_each_row(|row| {
            row.values.iter_mut().enumerate().for_each(|(x, value)| *value = columns[x * height + row.y]);
        });
        rows
    }

    /// Changes all rows, in any order, those of each detector by themselves. They get `before` and `after` pixels more,
    /// which are 0; `change` does not see those before. It is given the column of the first value that it sees, the
    /// distance to the next, and the row.
    pub(crate) fn map_rows(
        &self,
        before: usize,
        after: usize,
        change: impl Fn([usize; 2], usize, &mut [f64]) + Sync,
    ) -> Self {
        let samples = self.samples;
        let mut wider = Self::empty(self.width + (before + after) * samples, self.height, samples);
        let rows = wider.electrons.par_chunks_mut(wider.width.max(1)).enumerate();
        rows.for_each_init(Vec::new, |line, (y, row)| {
            let own = &self.electrons[y * self.width..][..self.width];
            for detector in 0..samples {
                line.clear();
                line.extend(own.iter().skip(detector).step_by(samples).map(|&e| f64::from(e)));
                line.resize(line.len() + after, 0.0);
                let first = before * samples + detector;
                change([first, samples], y, line);
                let to = row[first..].iter_mut().step_by(samples);
                to.zip(&*line).for_each(|(to, from)| *to = *from as f32);
            }
        });
        wider
    }

    /// Changes all rows, in any order.
    pub(crate) fn for_each_row(&mut self, change: impl Fn(&mut Row<'_>) + Sync) {
        for_each_row(&mut self.electrons, self.width, change);
    }

    /// Reads all rows out, in any order, into the digital numbers of their pixels.
    pub(crate) fn read_out(mut self, read: impl Fn(&mut Row<'_>, &mut Row<'_, u16>) + Sync) -> Vec<u16> {
        let mut numbers = vec![0; self.electrons.len()];
        let width = self.width.max(1);
        let rows = self.electrons.par_chunks_mut(width).zip(numbers.par_chunks_mut(width));
        rows.enumerate()
            .for_each(|(y, (values, numbers))| read(&mut Row { y, values }, &mut Row { y, values: numbers }));
        numbers
    }
}
