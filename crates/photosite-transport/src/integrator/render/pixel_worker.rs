//! Worker on one band of rows whose paths a device starts, and to which it responds.

use std::ops::ControlFlow;

use glam::Vec4;

use super::band_worker::PATHS_PER_REPORT;
use super::tracer::Tracer;
use crate::film::FilmBand;
use crate::integrator::LoadedDevice;
use crate::integrator::path_tracer::{PixelRun, PixelTracer};

/// Largest number of samples of a run: as many as a pass brings once passes do not double any more.
const LONGEST_RUN: u32 = 16;

/// Adds samples to a band.
pub(super) struct PixelWorker<'a, 'f> {
    tracer: &'a Tracer<'a>,
    device: &'a LoadedDevice,
    pixels: &'a dyn PixelTracer,
    band: FilmBand<'f>,
    /// Index of the first pixel of the band in the film.
    first_pixel: usize,
    /// Width of the film, and the row of the image that its first row is.
    width: usize,
    first_row: usize,
    runs: Vec<PixelRun>,
    /// Pixels of the band that the runs are of.
    of_band: Vec<usize>,
    values: Vec<Vec4>,
    /// Number of paths since the last report.
    paths: u64,
}

impl<'a, 'f> PixelWorker<'a, 'f> {
    /// A worker for the band whose first pixel is `first_pixel` of a film of that width and first row.
    pub(super) fn new(
        tracer: &'a Tracer<'a>,
        (device, pixels): (&'a LoadedDevice, &'a dyn PixelTracer),
        band: FilmBand<'f>,
        first_pixel: usize,
        [width, first_row]: [usize; 2],
    ) -> Self {
        Self {
            tracer,
            device,
            pixels,
            band,
            first_pixel,
            width,
            first_row,
            runs: Vec::new(),
            of_band: Vec::new(),
            values: Vec::new(),
            paths: 0,
        }
    }

    /// Adds all samples of the band that pixels lack of the number that `wanted` gives.
    pub(super) fn fill(mut self, wanted: &(dyn Fn(usize) -> u32 + Sync)) {
        let (first_sample, first_pixel) = (self.tracer.job.settings.samples().start, self.first_pixel);
        let missing = |band: &FilmBand<'_>, pixel: usize| band.samples(pixel)..wanted(first_pixel + pixel);
        let longest = (0..self.band.pixels()).map(|pixel| missing(&self.band, pixel).len()).max().unwrap_or(0);
        let longest = (longest as u32).clamp(1, LONGEST_RUN);
        let together = self.pixels.batch_size(longest);
        for pixel in 0..self.band.pixels() {
            let missing = missing(&self.band, pixel);
            let at = first_pixel + pixel;
            let position = [at % self.width, self.first_row + at / self.width].map(|n| n as u32);
            for start in missing.clone().step_by(longest as usize) {
                let count = longest.min(missing.end - start);
                self.runs.push(PixelRun { pixel: position, first: first_sample + start, count });
                self.of_band.push(pixel);
            }
            if self.runs.len() >= together && self.flush(longest).is_break() {
                return;
            }
        }
        // What is not traced is a smaller number of samples.
        let _ = self.flush(longest);
        self.tracer.report_paths(&mut self.paths, 1);
    }

    /// Traces the runs, and adds what arrives to their pixels, unless the render has been stopped.
    fn flush(&mut self, longest: u32) -> ControlFlow<()> {
        self.tracer.go_on()?;
        let Self { pixels, band, runs, of_band, values, .. } = self;
        if let Err(words) = pixels.trace(runs, longest, values) {
            self.device.fail(words);
            self.tracer.stop();
            return ControlFlow::Break(());
        }
        let traced: u32 = runs.iter().map(|run| run.count).sum();
        let groups = values.len() / traced.max(1) as usize;
        let mut values = values.as_slice();
        for (run, &pixel) in runs.iter().zip(of_band.iter()) {
            let (of_run, others) = values.split_at(run.count as usize * groups);
            band.add_values(pixel, of_run);
            values = others;
        }
        runs.clear();
        of_band.clear();
        self.paths += u64::from(traced);
        self.tracer.report_paths(&mut self.paths, PATHS_PER_REPORT);
        ControlFlow::Continue(())
    }
}
