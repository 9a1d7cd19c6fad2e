//! The loop over the pixels: passes over the whole picture, bands of rows side by side on all threads.

mod band_worker;

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use self::band_worker::BandWorker;
use super::RenderSettings;
use super::light_paths::{LightTracer, Splats};
use super::path::PathLimits;
use super::pilot::Pilot;
use super::wavelengths::{FilterTile, PixelWavelengths, importance_for_all};
use crate::film::{Film, FilmBand, FilmResponses, Response};
use crate::optics::Camera;
use crate::sampler::{PixelOrder, Sampler};
use crate::scene::Scene;
use photosite_core::spectrum::{Spectrum, SpectrumId, SpectrumTable};

/// Everything that a render reads.
pub struct RenderJob<'a> {
    /// What is in front of the camera.
    pub scene: &'a Scene,
    /// The lens.
    pub camera: &'a Camera,
    /// The lens's spectral transmittance τ.
    pub transmittance: &'a Spectrum,
    /// What is made of each wavelength: what the planes of the film hold.
    pub responses: &'a [Response],
    /// The filters of the pixels; `None` where all pixels have the same.
    pub filters: Option<&'a FilterTile>,
    /// Columns and rows.
    pub resolution: [u32; 2],
    /// Depth, seed, sampler, limits.
    pub settings: &'a RenderSettings,
}

/// What a render tells while it runs.
pub enum Step<'a> {
    /// Some pixels have got their samples of this pass. Called from any thread, some times a second.
    Band {
        /// Camera paths of those pixels.
        paths: u64,
    },
    /// A pass is over, or was broken off.
    Pass {
        /// The film so far.
        film: &'a Film,
        /// The pilot, of a render that has one.
        pilot: Option<&'a Pilot>,
        /// Time since the start.
        elapsed: Duration,
        /// Camera paths of the whole render, once they are known.
        planned_paths: Option<u64>,
    },
}

/// Hears what a render tells; what it answers ends the render or lets it go on. A pass that is broken off leaves some
/// pixels with fewer samples than others, and the next render goes on from there.
pub type Listener<'a> = dyn Fn(Step<'_>) -> ControlFlow<()> + Sync + 'a;

/// Number of paths of a pass so short that smaller ones are pointless.
const SMALL_PASS_PATHS: u64 = 1 << 20;

/// Number of paths after which a thread reports them, and asks whether to go on.
const PATHS_PER_REPORT: u64 = 1 << 13;

/// Largest number of samples a pixel in one pass: passes double up to it, so that there is soon something to see, and a
/// limit of time is kept well.
pub(super) const MAX_PASS_SAMPLES: u32 = 16;

/// Number of paths in a wavefront, branches included: few enough for the caches. With 32 of them a Cornell box took 4 %
/// longer, with 8 of them 12 %.
const WAVEFRONT_PATHS: u32 = 256;

/// Renders until the settings' samples are reached or `step` breaks off.
pub fn render(job: &RenderJob<'_>, responses: FilmResponses, step: &Listener<'_>) -> Film {
    let mut film = job.empty_film(responses);
    render_on(job, &mut film, step);
    film
}

/// The same, from a film on that holds the first samples of each pixel, of the whole picture or of some rows: it
/// becomes what it would be if all had been rendered in one go.
pub fn render_on(job: &RenderJob<'_>, film: &mut Film, step: &Listener<'_>) {
    let tracer = Tracer::new(job, job.settings.seed, step);
    let samples = job.settings.samples().len() as u32;
    let planned = Some(film.counts().len() as u64 * u64::from(samples));
    // A render that is broken off is one of fewer samples.
    let _ = tracer.fill(film, samples, |film| tracer.tell(film, None, planned));
}

impl RenderJob<'_> {
    /// A film of the picture's size.
    pub fn empty_film(&self, responses: FilmResponses) -> Film {
        let [width, height] = self.resolution.map(|n| n as usize);
        Film::new(width, height, responses)
    }

    /// Whether paths carry one wavelength from the lens on: where it spreads points by wavelength, what dispersion
    /// takes from a path later would leave the weights of all four to the one that is left.
    pub(super) fn has_single_wavelengths(&self) -> bool {
        self.camera.spreads_by_wavelength() && self.scene.disperses()
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        self.resolution.iter().map(|&n| u64::from(n)).product()
    }
}

/// The smallest range that holds all that are not empty.
fn hull(ranges: impl Iterator<Item = Range<u32>>) -> Range<u32> {
    let all = ranges.filter(|range| !range.is_empty());
    all.reduce(|all, own| all.start.min(own.start)..all.end.max(own.end)).unwrap_or(0..0)
}

/// Traces paths into films, with the random numbers of one seed.
pub(super) struct Tracer<'a> {
    job: &'a RenderJob<'a>,
    seed: u64,
    order: PixelOrder,
    step: &'a Listener<'a>,
    start: Instant,
    wavelengths: PixelWavelengths,
    spectra: SpectrumTable,
    transmittance: SpectrumId,
    limits: PathLimits,
    has_single_wavelengths: bool,
    /// `None` in renders without light paths.
    light_tracer: Option<LightTracer<'a>>,
    /// Whether a pass was broken off.
    stopped: AtomicBool,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(job: &'a RenderJob<'a>, seed: u64, step: &'a Listener<'a>) -> Self {
        let mut spectra = SpectrumTable::default();
        let transmittance = spectra.add(job.transmittance);
        let RenderSettings { max_depth, roulette_depth, splitting, samples_per_pixel, sampler, .. } = *job.settings;
        let limits = PathLimits { max_depth, roulette_depth, splitting };
        let importance = importance_for_all(job);
        Self {
            job,
            seed,
            order: PixelOrder::new(sampler, job.resolution[0], samples_per_pixel, splitting),
            step,
            start: Instant::now(),
            wavelengths: PixelWavelengths::new(job, &importance),
            spectra,
            transmittance,
            limits,
            has_single_wavelengths: job.has_single_wavelengths(),
            light_tracer: LightTracer::new(job, limits, seed, &importance),
            stopped: AtomicBool::new(false),
        }
    }

    /// Brings every pixel to so many samples, in passes that double, and tells of each.
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
            let passed = self.pass(film, &|_| level);
            tell(film)?;
            passed?;
        }
        ControlFlow::Continue(())
    }

    /// Tells that a pass is over.
    pub(super) fn tell(&self, film: &Film, pilot: Option<&Pilot>, planned_paths: Option<u64>) -> ControlFlow<()> {
        (self.step)(Step::Pass { film, pilot, elapsed: self.start.elapsed(), planned_paths })
    }

    /// Brings each pixel of a film that has fewer to as many samples as `wanted` says of it, unless that is broken off.
    pub(super) fn pass(&self, film: &mut Film, wanted: &(dyn Fn(usize) -> u32 + Sync)) -> ControlFlow<()> {
        let Some(light_tracer) = &self.light_tracer else {
            self.add_samples(film, wanted, &Splats::default());
            return self.go_on();
        };
        let all = hull((0..).zip(film.counts()).map(|(pixel, &done)| done..wanted(pixel)));
        let first = self.job.settings.samples().start;
        // The splats of many light paths would not fit into memory.
        for start in all.clone().step_by(light_tracer.samples_per_batch()) {
            let end = all.end.min(start + light_tracer.samples_per_batch() as u32);
            let wanted = |pixel: usize| wanted(pixel).min(end);
            let counts = film.counts();
            let wants = |pixel: usize, sample: u32| (counts[pixel]..wanted(pixel)).contains(&(sample - first));
            let splats = light_tracer.trace(first + start..first + end, film.picture_rows(), wants);
            self.add_samples(film, &wanted, &splats);
            self.go_on()?;
        }
        ControlFlow::Continue(())
    }

    /// Whether no pass was broken off.
    fn go_on(&self) -> ControlFlow<()> {
        if self.stopped.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Reports paths that are traced, if there are enough.
    fn report_paths(&self, paths: &mut u64, enough: u64) {
        if *paths >= enough && (self.step)(Step::Band { paths: std::mem::take(paths) }).is_break() {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Adds the missing samples to all pixels of a film, with what paths from lights bring to them.
    fn add_samples(&self, film: &mut Film, wanted: &(dyn Fn(usize) -> u32 + Sync), splats: &Splats) {
        let [block_columns, block_rows] = self.block_size();
        let (width, first_row) = (film.width(), film.picture_rows().start);
        let fill = |(index, band): (usize, FilmBand<'_>)| {
            let first_pixel = index * block_rows * width;
            BandWorker::new(self, band, first_pixel, [width, first_row], wanted, splats).fill(block_columns);
        };
        // One by one: of many that a thread had begun to share out, others could not take any while it was busy with
        // the first.
        film.bands(block_rows).into_par_iter().with_max_len(1).enumerate().for_each(fill);
    }

    /// Columns and rows of pixels that share what lies beyond their first surfaces.
    fn block_size(&self) -> [usize; 2] {
        let may_share = !self.job.camera.moves() && self.job.scene.has_diffuse();
        if may_share { self.job.settings.reuse_columns_and_rows() } else { [1, 1] }
    }

    /// The random number that chooses the wavelengths of a sample of a pixel.
    fn wavelength_number(&self, pixel: [usize; 2], sample: u32, sampler: &mut Sampler) -> f32 {
        let (sequence, first_index) = self.order.place(pixel.map(|n| n as u32));
        sampler.start(sequence, first_index + sample);
        sampler.skip();
        sampler.skip();
        sampler.next_1d()
    }
}
