//! What all threads of a render share.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use crate::film::Film;
use crate::integrator::RenderSettings;
use crate::integrator::job::RenderJob;
use crate::integrator::light_paths::LightTracer;
use crate::integrator::path::PathLimits;
use crate::integrator::pilot::Pilot;
use crate::integrator::progress::{Listener, Step};
use crate::integrator::wavelengths::PixelWavelengths;
use crate::sampler::{PixelOrder, Sampler};
use photosite_core::spectrum::{SpectrumId, SpectrumTable};

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
    /// `None` in renders without light paths.
    pub(super) light_tracer: Option<LightTracer<'a>>,
    /// Whether a pass was broken off.
    pub(super) stopped: AtomicBool,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(job: &'a RenderJob<'a>, seed: u64, step: &'a Listener<'a>) -> Self {
        let mut spectra = SpectrumTable::default();
        let transmittance = spectra.add(job.transmittance);
        let RenderSettings { max_depth, roulette_depth, splitting, samples_per_pixel, sampler, .. } = *job.settings;
        let limits = PathLimits { max_depth, roulette_depth, splitting };
        let importance = job.importance.map_or_else(|| Cow::Owned(job.importance_for_all()), Cow::Borrowed);
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

    /// Tells that a pass is over.
    pub(super) fn tell(&self, film: &Film, pilot: Option<&Pilot>, planned_paths: Option<u64>) -> ControlFlow<()> {
        (self.step)(Step::Pass { film, pilot, elapsed: self.start.elapsed(), planned_paths })
    }

    /// Whether no pass was broken off.
    pub(super) fn go_on(&self) -> ControlFlow<()> {
        if self.stopped.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Reports paths that are traced, if there are enough.
    pub(super) fn report_paths(&self, paths: &mut u64, enough: u64) {
        if *paths >= enough && (self.step)(Step::Band { paths: std::mem::take(paths) }).is_break() {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Columns and rows of pixels that share what lies beyond their first surfaces.
    pub(super) fn block_size(&self) -> [usize; 2] {
        let may_share = !self.job.camera.moves() && self.job.scene.has_diffuse();
        if may_share { self.job.settings.reuse_columns_and_rows() } else { [1, 1] }
    }

    /// The random number that chooses the wavelengths of a sample of a pixel.
    pub(super) fn wavelength_number(&self, pixel: [usize; 2], sample: u32, sampler: &mut Sampler) -> f32 {
        let (sequence, first_index) = self.order.place(pixel.map(|n| n as u32));
        sampler.start(sequence, first_index + sample);
        sampler.skip();
        sampler.skip();
        sampler.next_1d()
    }
}
