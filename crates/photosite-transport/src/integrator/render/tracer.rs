//! Tracer of paths, which all threads of a render share.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::film::Film;
use crate::integrator::RenderSettings;
use crate::integrator::job::RenderJob;
use crate::integrator::light_paths::LightTracer;
use crate::integrator::mis_ratio::MisRatio;
use crate::integrator::path::PathLimits;
use crate::integrator::pilot::Pilot;
use crate::integrator::progress::{Listener, Step};
use crate::integrator::ray_counts::RayCounts;
use crate::integrator::wavefront::Wavefront;
use crate::integrator::wavelengths::PixelWavelengths;
use crate::optics::{CameraSample, PackedCamera};
use crate::sampler::{PixelOrder, SamplePosition, Sampler};
use photosite_core::spectrum::{SpectrumId, SpectrumTable};

/// Cost of a sample's start and its camera ray, in rays to surfaces: camera rays go together.
const SAMPLE_COST: f64 = 0.5;

/// Number of paths in a wavefront, branches included: few enough for the caches. With 32 of them a Cornell box took 4 %
/// longer, with 8 of them 12 %.
const WAVEFRONT_PATHS: u32 = 256;

/// Traces paths into films, with the random numbers of one seed.
pub(super) struct Tracer<'a> {
    pub(super) job: &'a RenderJob<'a>,
    pub(super) seed: u64,
    pub(super) order: PixelOrder,
    pub(super) step: &'a Listener<'a>,
    pub(super) start: Instant,
    pub(super) wavelengths: PixelWavelengths,
    pub(super) spectra: SpectrumTable,
    pub(super) transmittance: SpectrumId,
    pub(super) limits: PathLimits,
    pub(super) has_single_wavelengths: bool,
    /// Tracer of light paths; `None` in renders without any.
    pub(super) light_tracer: Option<LightTracer<'a>>,
    /// The camera as plain data, once it is asked for; `None` within of a camera that devices do not have.
    pub(super) packed_camera: OnceLock<Option<PackedCamera>>,
    /// Whether a pass has been broken off.
    pub(super) stopped: AtomicBool,
    pub(super) rays: RayCounts,
}

/// Random start of a sample of a pixel.
pub(super) struct DrawnSample {
    pub(super) camera: CameraSample,
    /// The number that chooses its wavelengths.
    pub(super) u_wavelengths: f32,
    /// Position of the sampler behind these numbers.
    pub(super) next: SamplePosition,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(job: &'a RenderJob<'a>, seed: u64, step: &'a Listener<'a>) -> Self {
        let mut spectra = SpectrumTable::default();
        let transmittance = spectra.add(job.transmittance);
        let RenderSettings { max_depth, roulette_depth, samples_per_pixel, sampler, .. } = *job.settings;
        let splitting = job.settings.splitting();
        let limits = PathLimits { max_depth, roulette_depth, splitting };
        let importance = job.importance.map_or_else(|| Cow::Owned(job.importance_for_all()), Cow::Borrowed);
        let mut tracer = Self {
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
            light_tracer: None,
            packed_camera: OnceLock::new(),
            stopped: AtomicBool::new(false),
            rays: RayCounts::default(),
        };
        tracer.light_tracer = LightTracer::new(job, limits, seed, &importance, tracer.lands_wavelengths());
        tracer
    }

    /// Tells that a pass is over.
    pub(super) fn tell(&self, film: &Film, pilot: Option<&Pilot>, planned_paths: Option<u64>) -> ControlFlow<()> {
        (self.step)(Step::Pass { film, pilot, elapsed: self.start.elapsed(), planned_paths })
    }

    /// Breaks the pass off.
    pub(super) fn stop(&self) {
        self.stopped.store(true, Ordering::Relaxed);
    }

    /// Whether no pass was broken off.
    pub(super) fn go_on(&self) -> ControlFlow<()> {
        if self.stopped.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Reports paths that are traced, if there are enough.
    pub(super) fn report_paths(&self, paths: &mut u64, enough: u64) {
        if *paths >= enough && (self.step)(Step::Band { paths: std::mem::take(paths) }).is_break() {
            self.stop();
        }
    }

    /// A wavefront without paths, and how many it holds without their branches.
    pub(super) fn wavefront(&self) -> (Wavefront, u32) {
        let mis_ratio = self.light_tracer.as_ref().map_or(MisRatio::NONE, LightTracer::mis_ratio);
        let max_paths = (WAVEFRONT_PATHS / self.limits.splitting.max(1)).max(1);
        (Wavefront::new(self.limits, mis_ratio), max_paths)
    }

    /// Whether the four wavelengths of a path land in pixels of their own, see
    /// [`landings`](super::landings). Where wavelengths depend on the pixel, or a branch may lose its wavelengths and
    /// not the path, the hero goes alone.
    pub(super) fn lands_wavelengths(&self) -> bool {
        let RenderJob { scene, camera, settings, .. } = *self.job;
        camera.lands_wavelengths()
            && self.wavelengths.are_the_same_everywhere()
            && !(scene.disperses() && settings.splitting() > 1)
    }

    /// Cost of `samples` samples of pixels, which were all that were traced, without that of light paths.
    pub(super) fn cost(&self, samples: u64) -> f64 {
        (SAMPLE_COST - 1.0) * samples as f64 + self.rays.cost()
    }

    /// Draws what a sample of a pixel, column and row of the image, starts from.
    #[inline]
    pub(super) fn draw(&self, pixel: [usize; 2], sample: u32, sampler: &mut Sampler) -> DrawnSample {
        let camera = self.job.camera;
        let (sequence, first_index) = self.order.place(pixel.map(|n| n as u32));
        sampler.start(sequence, first_index + sample);

        // Sample the pixel and the aperture
        let within = sampler.next_2d();
        let aperture = if camera.has_aperture() {
            sampler.next_2d()
        } else {
            sampler.skip();
            [0.0; 2]
        };

        // Sample the wavelengths
        let u_wavelengths = sampler.next_1d();

        // Sample the time and the point spread, of cameras that have them only: the samples of others stay what they are
        let time = if camera.moves() { sampler.next_1d() } else { 0.0 };
        let spread = if camera.spreads_points() { sampler.next_2d() } else { [0.0; 2] };

        let pixel = camera.cells().place(pixel, within.map(f64::from));
        let camera = CameraSample { pixel, aperture, time, spread };
        DrawnSample { camera, u_wavelengths, next: sampler.position() }
    }
}
