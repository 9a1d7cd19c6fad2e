//! Passes whose paths start from a lens that parts wavelengths, and whose light lands in several pixels.
//!
//! Of a path that serves four wavelengths each lands in a pixel of its own
//! ([`Camera::land_each`](crate::optics::Camera::land_each)). What lands in a pixel from paths of sample s of all pixels is
//! its sample s: so the variance of samples is that of what a pixel gets. Rows of paths are traced side by side and kept
//! until all rows that they may land in are complete, each of which then takes what is its own in the order of the paths:
//! sums do not depend on how many threads there are. What paths from lights bring to such a sample is added then.

use std::collections::VecDeque;
use std::ops::{ControlFlow, Range};

use rayon::prelude::*;

use super::band_worker::PATHS_PER_REPORT;
use super::passes::missing_samples;
use super::tracer::{DrawnSample, Tracer};
use crate::film::{Film, FilmBand, LandingRow, OneWavelength};
use crate::integrator::light_paths::{LightTracer, Splats};
use crate::integrator::path_tracer::{DevicePaths, Paths};
use crate::optics::{CameraRay, CameraSample, Landing, LandingRay, LensRays};
use crate::sampler::{SamplePosition, Sampler};
use photosite_core::spectrum::{LANES, SampledSpectrum, Wavelengths};

/// Largest number of rows between the start of a path and the pixel in which its light lands; light that would land
/// farther away goes with its own hero alone.
const REACH: usize = 48;
/// Paths of which the light is kept at once, 80 bytes each, unless one sample of a row and all within reach has more; and
/// paths that are traced between two looks at whether to go on.
const MAX_STORED_PATHS: usize = 1 << 20;
const PATHS_OF_ROWS: usize = 1 << 19;

/// Samples of each pixel that are traced together: as many as have no more paths in all rows within reach than are kept.
fn samples_together(width: usize) -> usize {
    (MAX_STORED_PATHS / (width * (2 * REACH + 1))).clamp(1, 16)
}

/// Number of rows that are completed at once, with `samples` samples of each pixel.
fn rows_together(width: usize, samples: usize) -> usize {
    (PATHS_OF_ROWS / (width * samples)).max(1)
}

/// Largest amount of memory, bytes, for light that waits for the rows in which it lands, in an image of `width` ×
/// `height` pixels with `samples_per_pixel` samples each.
pub fn bytes_of_landings([width, height]: [usize; 2], samples_per_pixel: u32) -> u64 {
    let samples = samples_together(width).min(samples_per_pixel.max(1) as usize);
    let rows = height.min(rows_together(width, samples) + 2 * REACH);
    [width, samples, rows, LANES, size_of::<Landed>()].into_iter().fold(1, |bytes, n| bytes.saturating_mul(n as u64))
}

/// Light of one wavelength that lands in a row.
struct Landed {
    column: u32,
    sample: u32,
    light: OneWavelength,
}

/// Light that the paths of a row bring, by the row in which it lands: from `REACH` rows above it on.
struct RowOfPaths {
    by_target: Vec<Vec<Landed>>,
}

/// Task of a pass.
struct Pass<'a> {
    tracer: &'a Tracer<'a>,
    width: usize,
    /// Rows of the film.
    rows: Range<usize>,
    /// Samples that a pixel of the film shall have, and those of pixels beyond it.
    wanted: &'a (dyn Fn(usize) -> u32 + Sync),
    beyond: u32,
    /// Number of samples that all pixels shall have at least.
    least: u32,
}

impl Pass<'_> {
    /// Whether a pixel of the image shall have a sample.
    #[inline]
    fn wants(&self, pixel: [usize; 2], sample: u32) -> bool {
        sample < self.least || sample < self.wanted(pixel)
    }

    /// Traces the paths of some samples of rows of the image, of those that are asked for.
    fn trace_rows<P: Paths>(
        &self,
        rows: Range<usize>,
        samples: &Range<u32>,
        is_asked: impl Fn(usize) -> bool + Sync,
        make: impl Fn() -> (P, u32) + Sync,
    ) -> Vec<RowOfPaths> {
        let trace = |worker: &mut LandingWorker<'_, P>, row: usize| {
            if is_asked(row) && self.tracer.go_on().is_continue() {
                worker.trace(row, samples.clone())
            } else {
                RowOfPaths::new()
            }
        };
        rows.into_par_iter().with_max_len(1).map_init(|| LandingWorker::new(self, make()), trace).collect()
    }

    /// Samples that a pixel of the image shall have.
    fn wanted(&self, [column, row]: [usize; 2]) -> u32 {
        let is_of_film = self.rows.contains(&row);
        if is_of_film { (self.wanted)((row - self.rows.start) * self.width + column) } else { self.beyond }
    }
}

impl Tracer<'_> {
    /// Makes a [`pass`](Self::pass) with light that lands where its wavelength leads it.
    pub(super) fn land(&self, film: &mut Film, wanted: &(dyn Fn(usize) -> u32 + Sync), beyond: u32) -> ControlFlow<()> {
        let (width, rows) = (film.width(), film.image_rows());
        let least = (0..film.counts().len()).map(wanted).fold(beyond, u32::min);
        let pass = Pass { tracer: self, width, rows, wanted, beyond, least };
        let all = missing_samples(film, wanted);
        let together = samples_together(width);
        let light_paths = self.light_tracer.as_ref().map_or(together, LightTracer::samples_per_batch);
        let together = together.min(light_paths);
        for start in all.clone().step_by(together) {
            let samples = start..all.end.min(start + together as u32);
            self.land_samples(film, &pass, samples)?;
        }
        ControlFlow::Continue(())
    }

    /// Light that paths from lights bring to some samples of pixels that lack them.
    fn splats(&self, film: &Film, pass: &Pass<'_>, samples: Range<u32>) -> Splats {
        let Some(light_tracer) = &self.light_tracer else { return Splats::default() };
        let first = self.job.settings.samples().start;
        let counts = film.counts();
        let wants = |pixel: usize, sample: u32| {
            (counts[pixel]..(pass.wanted)(pixel).min(samples.end)).contains(&(sample - first))
        };
        light_tracer.trace(first + samples.start..first + samples.end, film.image_rows(), wants)
    }

    /// Adds some samples to all pixels that lack them.
    fn land_samples(&self, film: &mut Film, pass: &Pass<'_>, samples: Range<u32>) -> ControlFlow<()> {
        let height = self.job.resolution[1] as usize;
        let Pass { width, ref rows, wanted, .. } = *pass;
        let lacks_any = |of_row: &[u32], row: usize| {
            let first = (row - rows.start) * width;
            let lacks = |(i, &done): (usize, &u32)| done.max(samples.start) < wanted(first + i).min(samples.end);
            of_row.iter().enumerate().any(lacks)
        };
        let lacking: Vec<bool> =
            film.counts().chunks(width).zip(rows.clone()).map(|(of_row, row)| lacks_any(of_row, row)).collect();
        // Whether light of a row's paths is asked for.
        let is_asked = |row: usize| {
            let near = row.saturating_sub(REACH).max(rows.start)..(row + REACH + 1).min(rows.end);
            near.into_iter().any(|row| lacking[row - rows.start])
        };
        let splats = self.splats(film, pass, samples.clone());
        let step = rows_together(width, samples.len());
        let mut paths: VecDeque<RowOfPaths> = VecDeque::new();
        // Rows of the image whose paths are kept.
        let mut kept = rows.start.saturating_sub(REACH)..rows.start.saturating_sub(REACH);
        for first in rows.clone().step_by(step) {
            let targets = first..rows.end.min(first + step);
            // Trace the paths that may land there
            let sources = kept.end..height.min(targets.end + REACH);
            paths.extend(match self.job.device {
                None => pass.trace_rows(sources.clone(), &samples, is_asked, || self.wavefront()),
                Some(device) => {
                    let make = || (DevicePaths::new(device), device.batch_size() as u32);
                    pass.trace_rows(sources.clone(), &samples, is_asked, make)
                }
            });
            kept.end = kept.end.max(sources.end);
            self.go_on()?;

            // Complete the rows
            let band_rows = first - rows.start..targets.end - rows.start;
            let mut bands = film.bands(1);
            bands[band_rows.clone()].par_iter_mut().with_max_len(1).zip(band_rows).for_each(|(band, row_of_film)| {
                if lacking[row_of_film] {
                    let wanted = |pixel: usize| wanted(row_of_film * width + pixel);
                    let from = |source: usize| &paths[source - kept.start].by_target;
                    let mut row = band.landing_row(samples.clone());
                    gather(band, &mut row, rows.start + row_of_film, kept.clone(), from);
                    let first_pixel = row_of_film * width;
                    splat(band, &mut row, first_pixel, &splats, self.job.settings.samples().start);
                    band.add_row(&row, wanted);
                }
            });

            // Forget what lands above
            let done = (targets.end.saturating_sub(REACH)).clamp(kept.start, kept.end);
            paths.drain(..done - kept.start);
            kept.start = done;
        }
        ControlFlow::Continue(())
    }
}

/// Adds to a row of the film what has landed in it.
fn gather<'p>(
    band: &FilmBand<'_>,
    landing: &mut LandingRow,
    row: usize,
    kept: Range<usize>,
    from: impl Fn(usize) -> &'p Vec<Vec<Landed>>,
) {
    for source in row.saturating_sub(REACH).max(kept.start)..(row + REACH + 1).min(kept.end) {
        for Landed { column, sample, light } in from(source).get(row + REACH - source).into_iter().flatten() {
            band.land(landing, *column as usize, *sample, light);
        }
    }
}

/// Adds to a row of the film, whose first pixel is of that number, what paths from lights have brought there.
fn splat(band: &FilmBand<'_>, landing: &mut LandingRow, first_pixel: usize, splats: &Splats, first_sample: u32) {
    for splat in splats.of_pixels(first_pixel..first_pixel + band.pixels()) {
        let (pixel, sample) = splat.key();
        let (irradiance, wavelengths) = splat.light();
        let weighted = irradiance * wavelengths.weights();
        for lane in 0..LANES {
            if weighted[lane] != 0.0 {
                let light = one_wavelength(wavelengths, lane, weighted[lane]);
                band.land(landing, pixel as usize - first_pixel, sample - first_sample, &light);
            }
        }
    }
}

/// Light of one of several wavelengths.
#[inline]
fn one_wavelength(wavelengths: &Wavelengths, lane: usize, weighted: f32) -> OneWavelength {
    let (entry, part) = wavelengths.place_in_table(lane);
    OneWavelength { entry: entry as u32, part, weighted }
}

impl RowOfPaths {
    /// Makes rows without light.
    fn new() -> Self {
        Self { by_target: Vec::new() }
    }
}

/// Target of the light of a path.
struct PathTarget {
    sample: u32,
    /// Transmittance of the lens.
    transmittance: SampledSpectrum,
    ray: LandingRay,
    cell: [u32; 2],
}

/// Traces the paths of rows.
struct LandingWorker<'a, P> {
    pass: &'a Pass<'a>,
    sampler: Sampler,
    wavefront: P,
    /// Paths of a wavefront without their branches.
    max_paths: u32,
    rays: LensRays,
    samples: Vec<CameraSample>,
    wavelengths: Vec<Wavelengths>,
    /// Starts of the samples: number, pixel and the position of the sampler.
    starts: Vec<(u32, [u32; 2], SamplePosition)>,
    /// Targets, one for each path of the wavefront.
    targets: Vec<PathTarget>,
    paths: u64,
}

impl<'a, P: Paths> LandingWorker<'a, P> {
    fn new(pass: &'a Pass<'a>, (wavefront, max_paths): (P, u32)) -> Self {
        let Tracer { job, seed, .. } = *pass.tracer;
        Self {
            pass,
            sampler: Sampler::new(job.settings.sampler, seed),
            wavefront,
            max_paths,
            rays: LensRays::default(),
            samples: Vec::new(),
            wavelengths: Vec::new(),
            starts: Vec::new(),
            targets: Vec::new(),
            paths: 0,
        }
    }

    /// Traces the paths of some samples of a row of the image.
    fn trace(&mut self, row: usize, samples: Range<u32>) -> RowOfPaths {
        let Pass { tracer, width, .. } = *self.pass;
        let mut found = RowOfPaths { by_target: (0..=2 * REACH).map(|_| Vec::new()).collect() };
        // Most of the light lands where its path started.
        found.by_target[REACH].reserve(LANES * width * samples.len());
        let first_sample = tracer.job.settings.samples().start;
        let most = self.max_paths as usize;
        for column in 0..width {
            let pixel = [column, row];
            let wavelengths = tracer.wavelengths.at(column, row);
            for sample in samples.start..samples.end.min(self.pass.wanted(pixel)) {
                let DrawnSample { camera, u_wavelengths, next } =
                    tracer.draw(pixel, first_sample + sample, &mut self.sampler);
                let mut wavelengths = wavelengths.sample(u_wavelengths);
                if tracer.has_single_wavelengths {
                    wavelengths.terminate_secondary();
                }
                self.samples.push(camera);
                self.wavelengths.push(wavelengths);
                self.starts.push((sample, pixel.map(|n| n as u32), next));
                if self.samples.len() == most {
                    self.flush(row, &mut found);
                }
            }
        }
        self.flush(row, &mut found);
        tracer.report_paths(&mut self.paths, PATHS_PER_REPORT);
        found
    }

    /// Traces the paths of the samples at hand, and sorts their light by where it lands.
    fn flush(&mut self, row: usize, found: &mut RowOfPaths) {
        let Self { pass, sampler, wavefront, rays, samples, wavelengths, starts, targets, paths, max_paths: _ } = self;
        let tracer = pass.tracer;
        // Lead the rays through the lens
        let starts_path = |i: usize, cell: [u32; 2]| pass.wants(cell.map(|n| n as usize), starts[i].0);
        tracer.job.camera.land_each(samples, wavelengths, rays, REACH as u32, starts_path, |i, ray| {
            let Some(ray) = ray else { return };
            let (sample, cell, position) = starts[i];
            wavefront.start(ray.of_hero.ray, wavelengths[i], position);
            let transmittance = tracer.spectra.sample(tracer.transmittance, &wavelengths[i]);
            targets.push(PathTarget { sample, transmittance, ray, cell });
        });
        *paths += samples.len() as u64;
        samples.clear();
        wavelengths.clear();
        starts.clear();

        // Trace their paths
        if wavefront.trace(tracer.job.scene, sampler).is_break() {
            tracer.stop();
            targets.clear();
        }

        // Add their light
        for (path, target) in targets.drain(..).enumerate() {
            let (light, wavelengths) = wavefront.arrived(path);
            let weighted = light * target.transmittance * wavelengths.weights();
            let LandingRay { of_hero: CameraRay { weight, .. }, landings } = target.ray;
            let is_hero_alone = wavelengths.is_hero_alone();
            for lane in 0..if is_hero_alone { 1 } else { LANES } {
                let Landing { cell: [column, to], weight } =
                    if is_hero_alone { Landing { cell: target.cell, weight } } else { landings[lane] };
                let apart = (to as usize + REACH).checked_sub(row).filter(|apart| *apart <= 2 * REACH);
                let (Some(apart), true) = (apart, weight > 0.0) else { continue };
                let light = one_wavelength(wavelengths, lane, weighted[lane] * weight);
                found.by_target[apart].push(Landed { column, sample: target.sample, light });
            }
        }
        wavefront.clear();
    }
}
