//! Seam between the starts of paths and what arrives along them. Waves on the processor trace paths as they come
//! ([`Wavefront`](super::wavefront::Wavefront)); a device takes many at once, and sends back what arrives.

use std::fmt::Debug;
use std::ops::ControlFlow;
use std::sync::Mutex;

use glam::Vec4;

use super::packed_film::PackedFilm;
use super::path::PathLimits;
use super::settings::RenderSettings;
use crate::geometry::Ray;
use crate::sampler::{SamplePosition, Sampler, SamplerKind};
use crate::scene::Scene;
use photosite_core::Invalid;
use photosite_core::spectrum::{SampledSpectrum, Wavelengths};

/// Start of a path from the camera.
#[derive(Clone, Copy, Debug)]
pub struct PathStart {
    /// First ray of the path.
    pub ray: Ray,
    /// Wavelengths that the path carries.
    pub wavelengths: Wavelengths,
    /// Position of its random numbers behind those of the camera.
    pub position: SamplePosition,
}

/// Arrival of light at the camera along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// Radiance that arrives, W·m⁻²·sr⁻¹·nm⁻¹ at each wavelength.
    pub light: SampledSpectrum,
    /// Whether dispersion has left the path its hero wavelength alone.
    pub is_hero_alone: bool,
}

/// Tracer of plain paths through one scene, many at once: paths that do not split.
///
/// Light that arrives along a path is a function of its start alone, whatever paths are traced beside it. Several threads may
/// call it at the same time, so that some prepare starts while others wait.
pub trait PathTracer: Send + Sync {
    /// Traces paths to their ends, and puts what arrives along each in the place of `arrivals`, in the order of `starts`.
    ///
    /// # Errors
    ///
    /// Words on why the device does not go on; nothing of these paths is to be used then.
    fn trace(&self, starts: &[PathStart], arrivals: &mut Vec<Arrival>) -> Result<(), String>;

    /// Number of paths that are traced together best, and at most.
    fn batch_size(&self) -> usize;

    /// Numbers of rays that were traced to surfaces and to lights so far, where the tracer counts them.
    fn rays(&self) -> [u64; 2];

    /// Takes the film of a render, to start the paths of its pixels and to respond to what they bring by itself; `None`
    /// where it has no room for it.
    ///
    /// # Errors
    ///
    /// Words on why the device does not go on.
    fn pixels<'a>(&'a self, film: &PackedFilm<'_>) -> Result<Option<Box<dyn PixelTracer + 'a>>, String>;
}

/// Samples of one pixel that follow each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRun {
    /// Column and row of the pixel in the image.
    pub pixel: [u32; 2],
    /// Number of the first sample.
    pub first: u32,
    /// Number of samples, at least one.
    pub count: u32,
}

/// Tracer of the samples of pixels, with the camera, the wavelengths and the responses of one film.
pub trait PixelTracer: Send + Sync {
    /// Traces runs of at most `longest` samples each, and puts the values of their samples in the place of `values`, of each
    /// sample group by group of four channels. They are a function of the sample alone, whatever is traced beside it.
    ///
    /// # Errors
    ///
    /// Words on why the device does not go on; nothing of these runs is to be used then.
    fn trace(&self, runs: &[PixelRun], longest: u32, values: &mut Vec<Vec4>) -> Result<(), String>;

    /// Number of runs of at most that many samples that are traced together.
    fn batch_size(&self, longest: u32) -> usize;
}

/// Device that traces paths in place of the processor.
pub trait Device: Debug + Send + Sync {
    /// Name, interface and driver, which decide the last bits of an image.
    fn name(&self) -> String;

    /// Takes a scene for paths within these limits, with numbers of that kind.
    ///
    /// # Errors
    ///
    /// Something of the scene that the device cannot do, or has no room for.
    fn load(&self, scene: &Scene, limits: PathLimits, sampler: SamplerKind) -> Result<Box<dyn PathTracer>, Invalid>;
}

/// Device of a render with the scene that it has taken, and what went wrong on it.
pub struct LoadedDevice {
    tracer: Box<dyn PathTracer>,
    failure: Mutex<Option<String>>,
}

impl LoadedDevice {
    /// Loads a scene on a device, for the paths of these settings.
    ///
    /// # Errors
    ///
    /// Something of the scene that the device cannot do, or has no room for.
    pub fn new(device: &dyn Device, scene: &Scene, settings: &RenderSettings) -> Result<Self, Invalid> {
        let &RenderSettings { max_depth, roulette_depth, sampler, .. } = settings;
        let limits = PathLimits { max_depth, roulette_depth, splitting: 1 };
        Ok(Self { tracer: device.load(scene, limits, sampler)?, failure: Mutex::new(None) })
    }

    /// Words on why the device has ended a render, if it has.
    pub fn failure(&self) -> Option<String> {
        self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone()
    }

    /// Tracer of the samples of a film's pixels; `None` where the device has no room for it, or has failed.
    pub(super) fn pixels(&self, film: &PackedFilm<'_>) -> Option<Box<dyn PixelTracer + '_>> {
        self.tracer.pixels(film).map_err(|words| self.fail(words)).ok().flatten()
    }

    /// Number of paths that are traced together.
    pub(super) fn batch_size(&self) -> usize {
        self.tracer.batch_size()
    }

    /// Notes words on why the device has ended a render.
    pub(super) fn fail(&self, words: String) {
        // What went wrong first says most.
        self.failure.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(words);
    }
}

/// Paths that are started one by one and traced together.
pub(super) trait Paths {
    /// Adds a path from the camera, with the random numbers from a position on.
    fn start(&mut self, ray: Ray, wavelengths: Wavelengths, position: SamplePosition);
    /// Number of paths that were started, before they are traced.
    fn len(&self) -> usize;
    /// Traces all paths that were started to their ends. Breaks where that has failed, and nothing has arrived.
    fn trace(&mut self, scene: &Scene, sampler: &mut Sampler) -> ControlFlow<()>;
    /// The radiance that has arrived along a path that was started, and its wavelengths.
    fn arrived(&self, index: usize) -> (SampledSpectrum, &Wavelengths);
    /// Removes all paths.
    fn clear(&mut self);
    /// Numbers of rays that were traced to surfaces and to lights, as far as they are known here.
    fn rays(&self) -> [u64; 2];
}

/// Paths that a device traces.
pub(super) struct DevicePaths<'a> {
    device: &'a LoadedDevice,
    starts: Vec<PathStart>,
    arrivals: Vec<Arrival>,
}

impl<'a> DevicePaths<'a> {
    /// No paths yet.
    pub(super) fn new(device: &'a LoadedDevice) -> Self {
        Self { device, starts: Vec::new(), arrivals: Vec::new() }
    }
}

impl Paths for DevicePaths<'_> {
    fn start(&mut self, ray: Ray, wavelengths: Wavelengths, position: SamplePosition) {
        self.starts.push(PathStart { ray, wavelengths, position });
    }

    fn len(&self) -> usize {
        self.starts.len()
    }

    fn trace(&mut self, _: &Scene, _: &mut Sampler) -> ControlFlow<()> {
        let Self { device, starts, arrivals } = self;
        if let Err(words) = device.tracer.trace(starts, arrivals) {
            device.fail(words);
            return ControlFlow::Break(());
        }
        for (start, arrival) in starts.iter_mut().zip(arrivals) {
            if arrival.is_hero_alone {
                start.wavelengths.terminate_secondary();
            }
        }
        ControlFlow::Continue(())
    }

    fn arrived(&self, index: usize) -> (SampledSpectrum, &Wavelengths) {
        (self.arrivals[index].light, &self.starts[index].wavelengths)
    }

    fn clear(&mut self) {
        self.starts.clear();
    }

    fn rays(&self) -> [u64; 2] {
        // Costs are those of the planner, which devices do not ask.
        [0; 2]
    }
}
