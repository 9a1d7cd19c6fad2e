//! Passes over the whole image, until every pixel has its samples.

use std::ops::{ControlFlow, Range};

use rayon::prelude::*;

use super::band_worker::BandWorker;
use super::pixel_worker::PixelWorker;
use super::tracer::Tracer;
use crate::film::{Film, FilmBand};
use crate::integrator::light_paths::Splats;
use crate::integrator::packed_film::PackedFilm;
use crate::integrator::path_tracer::{DevicePaths, Paths, PixelTracer};
use crate::integrator::{LoadedDevice, RenderJob};

/// Number of paths of a pass so short that smaller ones are pointless.
const SMALL_PASS_PATHS: u64 = 1 << 20;

/// Largest number of samples a pixel in one pass: passes double up to it, so that there is soon something to see, and a
/// limit of time is kept well.
pub(super) const MAX_PASS_SAMPLES: u32 = 16;

/// Number of paths below which it is not worth a device's while.
const FEWEST_DEVICE_PATHS: u64 = 1 << 15;

impl Tracer<'_> {
    /// Brings every pixel to `samples` samples, in passes that double, and tells of each.
    pub(super) fn fill(
        &self,
        film: &mut Film,
        samples: u32,
        tell: impl Fn(&Film) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut level = film.samples();
        // The numbers of the sampler come eight at a time, of which a pass of fewer samples leaves some.
        let smallest = (SMALL_PASS_PATHS / self.job.pixels().max(1)).clamp(1, u64::from(MAX_PASS_SAMPLES / 2)) as u32;
        while level < samples {
            level += level.clamp(smallest, MAX_PASS_SAMPLES).min(samples - level);
            let passed = self.pass(film, &|_| level, level);
            tell(film)?;
            passed?;
        }
        ControlFlow::Continue(())
    }

    /// Brings each pixel of a film that has fewer to as many samples as `wanted` says of it, unless that is broken off.
    /// Pixels of the image beyond the film get `beyond`, elsewhere.
    pub(super) fn pass(&self, film: &mut Film, wanted: &(dyn Fn(usize) -> u32 + Sync), beyond: u32) -> ControlFlow<()> {
        if self.lands_wavelengths() {
            return self.land(film, wanted, beyond);
        }
        let Some(light_tracer) = &self.light_tracer else {
            self.add_samples(film, wanted, &Splats::default());
            return self.go_on();
        };
        let all = missing_samples(film, wanted);
        let first = self.job.settings.samples().start;
        // The splats of many light paths would not fit into memory.
        for start in all.clone().step_by(light_tracer.samples_per_batch()) {
            let end = all.end.min(start + light_tracer.samples_per_batch() as u32);
            let wanted = |pixel: usize| wanted(pixel).min(end);
            let counts = film.counts();
            let wants = |pixel: usize, sample: u32| (counts[pixel]..wanted(pixel)).contains(&(sample - first));
            let splats = light_tracer.trace(first + start..first + end, film.image_rows(), wants);
            self.add_samples(film, &wanted, &splats);
            self.go_on()?;
        }
        ControlFlow::Continue(())
    }

    /// Adds the missing samples to all pixels of a film, with what paths from lights bring to them.
    pub(super) fn add_samples(&self, film: &mut Film, wanted: &(dyn Fn(usize) -> u32 + Sync), splats: &Splats) {
        match self.job.device {
            None => self.fill_bands(film, 1, wanted, splats, || self.wavefront()),
            Some(device) => {
                let rows = self.rows_of_batch(film, wanted, device.batch_size());
                let pixels = self.packed_film(film).and_then(|packed| device.pixels(&packed));
                match pixels {
                    Some(pixels) => self.fill_pixels((device, &*pixels), film, rows, wanted),
                    None if device.failure().is_some() => self.stop(),
                    None => {
                        let paths = || (DevicePaths::new(device), device.batch_size() as u32);
                        self.fill_bands(film, rows, wanted, splats, paths);
                    }
                }
            }
        }
    }

    /// The film as plain data, for a device that starts its paths; `None` where the processor has to start them.
    fn packed_film(&self, film: &Film) -> Option<PackedFilm<'_>> {
        let RenderJob { camera, transmittance, resolution: [_, rows], .. } = *self.job;
        if self.light_tracer.is_some() || self.limits.max_depth == 0 {
            return None;
        }
        let packed = self.packed_camera.get_or_init(|| camera.packed()).as_ref()?;
        let wavelengths = (self.wavelengths.tile(), self.has_single_wavelengths);
        PackedFilm::new(packed, rows, (&self.order, self.seed), wavelengths, transmittance, film.responses())
    }

    /// Fills bands of `rows` rows side by side, with samples that a device responds to.
    fn fill_pixels(
        &self,
        device: (&LoadedDevice, &dyn PixelTracer),
        film: &mut Film,
        rows: usize,
        wanted: &(dyn Fn(usize) -> u32 + Sync),
    ) {
        let size = [film.width(), film.image_rows().start];
        let fill = |(index, band): (usize, FilmBand<'_>)| {
            PixelWorker::new(self, device, band, index * rows * size[0], size).fill(wanted);
        };
        film.bands(rows).into_par_iter().with_max_len(1).enumerate().for_each(fill);
    }

    /// Fills bands of `rows` rows side by side, with paths that `make` makes for each.
    fn fill_bands<P: Paths>(
        &self,
        film: &mut Film,
        rows: usize,
        wanted: &(dyn Fn(usize) -> u32 + Sync),
        splats: &Splats,
        make: impl Fn() -> (P, u32) + Sync,
    ) {
        let (width, first_row) = (film.width(), film.image_rows().start);
        let fill = |(index, band): (usize, FilmBand<'_>)| {
            let first_pixel = index * rows * width;
            BandWorker::new(self, band, first_pixel, [width, first_row], wanted, splats, make()).fill();
        };
        // One by one: of many that a thread had begun to share out, others could not take any while it was busy with
        // the first.
        film.bands(rows).into_par_iter().with_max_len(1).enumerate().for_each(fill);
    }

    /// Number of rows that lack as many samples as are traced together, or fewer where threads would be left without any:
    /// no path depends on those beside it.
    fn rows_of_batch(&self, film: &Film, wanted: &(dyn Fn(usize) -> u32 + Sync), batch_size: usize) -> usize {
        let lacking = |(pixel, &done): (usize, &u32)| u64::from(wanted(pixel).saturating_sub(done));
        let paths = film.counts().iter().enumerate().map(lacking).sum::<u64>().max(1);
        let of_thread = paths.div_ceil(rayon::current_num_threads() as u64).max(FEWEST_DEVICE_PATHS);
        let together = (batch_size as u64).min(of_thread);
        (film.height() as u64 * together / paths).clamp(1, film.height().max(1) as u64) as usize
    }
}

/// The smallest range that holds all samples that pixels of a film lack.
pub(super) fn missing_samples(film: &Film, wanted: impl Fn(usize) -> u32) -> Range<u32> {
    let of_pixels = (0..).zip(film.counts()).map(|(pixel, &done)| done..wanted(pixel));
    let all = of_pixels.filter(|missing| !missing.is_empty());
    all.reduce(|all, own| all.start.min(own.start)..all.end.max(own.end)).unwrap_or(0..0)
}
