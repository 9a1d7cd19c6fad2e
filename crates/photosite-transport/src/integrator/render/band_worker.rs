//! Worker on one band of rows, filled by one thread: camera rays are generated batch by batch, traced as wavefronts,
//! and what arrives is added to the film.

use std::ops::Range;

use super::tracer::{DrawnSample, Tracer};
use crate::film::FilmBand;
use crate::integrator::light_paths::{Splat, Splats};
use crate::integrator::path_tracer::Paths;
use crate::optics::{CameraRay, CameraSample};
use crate::sampler::{SamplePosition, Sampler};
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// Number of paths after which a thread reports them, and asks whether to go on.
pub(super) const PATHS_PER_REPORT: u64 = 1 << 13;

/// Camera rays of samples of one pixel, before they are generated.
#[derive(Default)]
struct CameraRayBatch {
    samples: Vec<CameraSample>,
    /// The random numbers that choose the wavelengths.
    u_wavelengths: Vec<f32>,
    wavelengths: Vec<Wavelengths>,
    /// Position of the sampler after these numbers.
    starts: Vec<SamplePosition>,
}

impl CameraRayBatch {
    fn clear(&mut self) {
        self.samples.clear();
        self.u_wavelengths.clear();
        self.wavelengths.clear();
        self.starts.clear();
    }
}

/// Target of the light of a path from the camera.
struct PixelTarget<'a> {
    /// Index of the pixel in the band.
    pixel: usize,
    /// Transmittance of the lens times the weight of the camera ray.
    transmitted: SampledSpectrum,
    /// Light that paths from lights bring to the same sample.
    splats: &'a [Splat],
}

/// Adds samples to a band.
pub(super) struct BandWorker<'a, 'f, P> {
    tracer: &'a Tracer<'a>,
    band: FilmBand<'f>,
    /// Index of the first pixel of the band in the film.
    first_pixel: usize,
    /// Width of the film, and the row of the image that its first row is.
    width: usize,
    first_row: usize,
    /// Number of samples that a pixel of the film shall have.
    wanted: &'a (dyn Fn(usize) -> u32 + Sync),
    splats: &'a Splats,
    sampler: Sampler,
    /// Paths of a wavefront without their branches.
    max_paths: u32,
    wavefront: P,
    /// Targets, one for each path of the wavefront.
    targets: Vec<PixelTarget<'a>>,
    batch: CameraRayBatch,
    /// Number of paths since the last report.
    paths: u64,
}

impl<'a, 'f, P: Paths> BandWorker<'a, 'f, P> {
    /// A worker for the band whose first pixel is `first_pixel` of a film of that width and first row. `wavefront` has no
    /// paths yet, and gets `max_paths` of them at most.
    pub(super) fn new(
        tracer: &'a Tracer<'a>,
        band: FilmBand<'f>,
        first_pixel: usize,
        [width, first_row]: [usize; 2],
        wanted: &'a (dyn Fn(usize) -> u32 + Sync),
        splats: &'a Splats,
        (wavefront, max_paths): (P, u32),
    ) -> Self {
        Self {
            tracer,
            band,
            first_pixel,
            width,
            first_row,
            wanted,
            splats,
            sampler: Sampler::new(tracer.job.settings.sampler, tracer.seed),
            max_paths,
            wavefront,
            targets: Vec::with_capacity(max_paths as usize),
            batch: CameraRayBatch::default(),
            paths: 0,
        }
    }

    /// Adds all missing samples of the band, pixel by pixel.
    pub(super) fn fill(mut self) {
        for pixel in 0..self.band.pixels() {
            // A pixel gets all of this pass or nothing.
            if self.tracer.go_on().is_break() {
                break;
            }
            self.add_pixel(pixel);
            self.tracer.report_paths(&mut self.paths, PATHS_PER_REPORT);
        }
        self.flush();
        self.tracer.rays.add(self.wavefront.rays());
        self.tracer.report_paths(&mut self.paths, 1);
    }

    /// Column and row in the image of a pixel of the band.
    fn position(&self, pixel: usize) -> [usize; 2] {
        [pixel % self.width, self.first_row + (self.first_pixel + pixel) / self.width]
    }

    /// Adds the missing samples of a pixel, batch by batch of as many as a wavefront holds.
    fn add_pixel(&mut self, pixel: usize) {
        let missing = self.band.samples(pixel)..(self.wanted)(self.first_pixel + pixel);
        for start in missing.clone().step_by(self.max_paths as usize) {
            let indices = start..missing.end.min(start + self.max_paths);
            if self.wavefront.len() + indices.len() > self.max_paths as usize {
                self.flush();
            }
            self.paths += indices.len() as u64;
            self.prepare(pixel, indices.clone());
            self.generate(pixel, indices.start);
        }
    }

    /// Draws the camera samples and wavelengths of samples of a pixel.
    fn prepare(&mut self, pixel: usize, indices: Range<u32>) {
        let position = self.position(pixel);
        let Self { tracer, sampler, batch, .. } = self;
        let first_sample = tracer.job.settings.samples().start;
        batch.clear();
        for index in indices {
            let DrawnSample { camera, u_wavelengths, next } = tracer.draw(position, first_sample + index, sampler);
            batch.samples.push(camera);
            batch.u_wavelengths.push(u_wavelengths);
            batch.starts.push(next);
        }
        let wavelengths = tracer.wavelengths.at(position[0], position[1]);
        batch.wavelengths.extend(batch.u_wavelengths.iter().map(|&u| wavelengths.sample(u)));
        if tracer.has_single_wavelengths {
            batch.wavelengths.iter_mut().for_each(Wavelengths::terminate_secondary);
        }
    }

    /// Generates the camera rays of the batch, and adds their paths to the wavefront.
    fn generate(&mut self, pixel: usize, first_index: u32) {
        let Self { tracer, batch, wavefront, targets, band, splats, .. } = self;
        let CameraRayBatch { samples, wavelengths, starts, .. } = batch;
        let first_sample = tracer.job.settings.samples().start + first_index;
        tracer.job.camera.generate_each(samples, wavelengths, |i, wavelengths, ray| {
            let splats = splats.of(self.first_pixel + pixel, first_sample + i as u32);
            let Some((CameraRay { ray, weight }, weights)) = ray else {
                // The lens sees nothing: the sample is what paths from lights bring
                band.add(pixel, [splats.iter().map(Splat::light)]);
                return;
            };
            wavefront.start(ray, *wavelengths, starts[i]);
            let transmitted = tracer.spectra.sample(tracer.transmittance, wavelengths) * weights * weight;
            targets.push(PixelTarget { pixel, transmitted, splats });
        });
    }

    /// Traces the paths of the wavefront, and adds what arrives along each to its pixel.
    fn flush(&mut self) {
        let Self { tracer, wavefront, targets, sampler, band, .. } = self;
        if wavefront.trace(tracer.job.scene, sampler).is_break() {
            tracer.stop();
            targets.clear();
            wavefront.clear();
            return;
        }
        let mut paths = 0..;
        for samples in targets.chunk_by(|a, b| a.pixel == b.pixel) {
            let arrived = samples.iter().zip(&mut paths).map(|(PixelTarget { transmitted, splats, .. }, path)| {
                let (light, wavelengths) = wavefront.arrived(path);
                splats.iter().map(Splat::light).chain([(light * *transmitted, wavelengths)])
            });
            band.add(samples[0].pixel, arrived);
        }
        targets.clear();
        wavefront.clear();
    }
}
