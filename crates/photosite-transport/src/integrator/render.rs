//! The loop over the pixels: passes over the whole picture, rows side by side on all threads.

use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::DVec2;
use rayon::prelude::*;

use super::RenderSettings;
use super::light_paths::{LightTracer, Splat, Splats};
use super::odds::Odds;
use super::path::{PathLimits, Sharing};
use super::pilot::Pilot;
use super::wave::Wave;
use super::wavelengths::{FilterTile, PixelWavelengths, importance_for_all};
use crate::film::{Film, FilmBand, FilmResponses, Response};
use crate::optics::{Camera, CameraRay, CameraSample};
use crate::sampler::{PixelOrder, SamplePlace, Sampler};
use crate::scene::Scene;
use photosite_core::spectrum::{SampledSpectrum, Spectrum, SpectrumId, SpectrumTable, Wavelengths};

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

/// Hears what a render tells; what it answers ends the render or lets it go on. A pass that is broken off leaves some pixels with
/// fewer samples than others, and the next render goes on from there.
pub type Listener<'a> = dyn Fn(Step<'_>) -> ControlFlow<()> + Sync + 'a;

/// Paths of a pass that takes little time, so that it need not be a smaller one.
const FEW_PATHS: u64 = 1 << 20;

/// Paths after which a thread tells that they are traced, and hears whether it shall go on.
const PATHS_TOLD: u64 = 1 << 13;

/// Largest number of samples a pixel in one pass: passes double up to it, so that there is soon something to see, and a
/// limit of time is kept well.
pub(super) const LARGEST_PASS: u32 = 16;

/// Paths that are traced together, branches included: few enough for the caches. With 32 of them a Cornell box took 4 % longer,
/// with 8 of them 12 %.
const PATHS_TOGETHER: u32 = 256;

/// Renders until the settings' samples are reached or `step` breaks off.
pub fn render(job: &RenderJob<'_>, responses: FilmResponses, step: &Listener<'_>) -> Film {
    let mut film = job.empty_film(responses);
    render_on(job, &mut film, step);
    film
}

/// The same, from a film on that holds the first samples of each pixel, of the whole picture or of some rows: it becomes
/// what it would be if all had been rendered in one go.
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

    /// Whether paths carry one wavelength from the lens on: where it spreads points by wavelength, what dispersion takes from a
    /// path later would leave the weights of all four to the one that is left.
    pub(super) fn has_lone_heroes(&self) -> bool {
        self.camera.spreads_by_wavelength() && self.scene.disperses()
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> u64 {
        self.resolution.iter().map(|&n| u64::from(n)).product()
    }
}

/// The numbers from the first to the last of ranges.
fn hull(ranges: impl Iterator<Item = Range<u32>>) -> Range<u32> {
    let all = ranges.filter(|range| !range.is_empty());
    all.reduce(|all, own| all.start.min(own.start)..all.end.max(own.end)).unwrap_or(0..0)
}

/// Paths that set out from the camera together, of samples of one pixel.
#[derive(Default)]
struct Departures {
    samples: Vec<CameraSample>,
    /// The numbers that choose the wavelengths.
    u_wavelengths: Vec<f32>,
    wavelengths: Vec<Wavelengths>,
    /// Where the sampler is then.
    places: Vec<(SamplePlace, Sharing)>,
}

impl Departures {
    fn clear(&mut self) {
        self.samples.clear();
        self.u_wavelengths.clear();
        self.wavelengths.clear();
        self.places.clear();
    }
}

/// Where the light of a path from the camera goes.
struct Destination<'a> {
    /// Its number in the band.
    pixel: usize,
    /// What the lens lets through.
    through: SampledSpectrum,
    /// What paths from lamps bring to the same sample.
    of_lamps: &'a [Splat],
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
    has_lone_heroes: bool,
    /// `None` where no paths set out from lamps.
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
            has_lone_heroes: job.has_lone_heroes(),
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
        let smallest = (FEW_PATHS / self.job.pixels().max(1)).clamp(1, u64::from(LARGEST_PASS / 2)) as u32;
        while level < samples {
            level += level.clamp(smallest, LARGEST_PASS).min(samples - level);
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
        // What many paths from lamps bring would not fit into memory.
        for start in all.clone().step_by(light_tracer.samples_together()) {
            let end = all.end.min(start + light_tracer.samples_together() as u32);
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

    /// Tells of paths that are traced, if there are enough.
    fn tell_paths(&self, paths: &mut u64, enough: u64) {
        if *paths >= enough && (self.step)(Step::Band { paths: std::mem::take(paths) }).is_break() {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }

    /// The same with what paths from lamps bring to those samples.
    fn add_samples(&self, film: &mut Film, wanted: &(dyn Fn(usize) -> u32 + Sync), splats: &Splats) {
        let job = self.job;
        let (kind, first_sample) = (job.settings.sampler, job.settings.samples().start);
        let (width, first_row) = (film.width(), film.picture_rows().start);
        let odds = self.light_tracer.as_ref().map_or(Odds::NONE, LightTracer::odds);
        let together = (PATHS_TOGETHER / self.limits.splitting.max(1)).max(1);
        let [group_columns, group_rows] = self.group_size();
        let group_size = group_columns * group_rows;
        let samples_together = (together / group_size as u32).max(1);
        let fill = |(number, mut band): (usize, FilmBand<'_>)| {
            let first_pixel = number * group_rows * width;
            let place = |pixel: usize| [pixel % width, first_row + (first_pixel + pixel) / width];
            let mut paths = 0;
            let mut sampler = Sampler::new(kind, self.seed);
            let mut wave = Wave::new(self.limits, odds);
            let mut departures = Departures::default();
            let mut destinations = Vec::with_capacity(together as usize);
            let mut missing = Vec::with_capacity(group_size);
            let mut u_wavelengths = Vec::new();
            let mut groups = 0;
            for first_column in (0..width).step_by(group_columns) {
                // Pixels that share their paths get all of this pass or nothing.
                if self.go_on().is_break() {
                    break;
                }
                let columns = first_column..width.min(first_column + group_columns);
                let pixels = (0..band.pixels()).step_by(width).flat_map(|row| columns.clone().map(move |x| row + x));
                missing.clear();
                missing.extend(pixels.map(|pixel| (pixel, band.samples(pixel)..wanted(first_pixel + pixel))));
                let all = hull(missing.iter().map(|(_, missing)| missing.clone()));
                for start in all.clone().step_by(samples_together as usize) {
                    let indices = start..all.end.min(start + samples_together);
                    if wave.len() + missing.len() * indices.len() > together as usize {
                        self.trace(&mut wave, &mut destinations, &mut sampler, &mut band);
                    }
                    if group_size > 1 {
                        let samples = indices.clone().map(|index| first_sample + index);
                        let u = samples.map(|sample| self.wavelength_of(place(first_column), sample, &mut sampler));
                        u_wavelengths.clear();
                        u_wavelengths.extend(u);
                    }
                    for &(pixel, ref missing) in &missing {
                        let own = missing.start.max(start)..missing.end.min(indices.end);
                        paths += own.len() as u64;
                        let shared = |index: u32| {
                            let number = (index - start) as usize;
                            u_wavelengths.get(number).map(|&u| (u, groups + number as u32))
                        };
                        self.prepare((place(pixel), own.clone()), shared, &mut sampler, &mut departures);
                        self.depart(&mut departures, &mut wave, |number, through| {
                            let of_lamps = splats.of(first_pixel + pixel, first_sample + own.start + number as u32);
                            match through {
                                Some(through) => destinations.push(Destination { pixel, through, of_lamps }),
                                None => band.add(pixel, [of_lamps.iter().map(Splat::light)]),
                            }
                        });
                    }
                    groups += indices.len() as u32;
                }
                self.tell_paths(&mut paths, PATHS_TOLD);
            }
            self.trace(&mut wave, &mut destinations, &mut sampler, &mut band);
            self.tell_paths(&mut paths, 1);
        };
        // One by one: of many that a thread had begun to share out, others could not take any while it was busy with the first.
        film.bands(group_rows).into_par_iter().with_max_len(1).enumerate().for_each(fill);
    }

    /// Columns and rows of pixels that share what lies beyond their first surfaces.
    fn group_size(&self) -> [usize; 2] {
        let may_share = !self.job.camera.moves() && self.job.scene.has_diffuse();
        if may_share { self.job.settings.reuse_columns_and_rows() } else { [1, 1] }
    }

    /// The number that chooses the wavelengths of a sample of a pixel.
    fn wavelength_of(&self, pixel: [usize; 2], sample: u32, sampler: &mut Sampler) -> f32 {
        let (sequence, first_index) = self.order.place(pixel.map(|n| n as u32));
        sampler.start(sequence, first_index + sample);
        sampler.skip();
        sampler.skip();
        sampler.next_1d()
    }

    /// Prepares the paths of samples of a pixel, column and row. Pixels that share have the same number for the wavelengths, and
    /// that of their group.
    fn prepare(
        &self,
        (pixel, indices): ([usize; 2], Range<u32>),
        shared: impl Fn(u32) -> Option<(f32, u32)>,
        sampler: &mut Sampler,
        departures: &mut Departures,
    ) {
        let camera = self.job.camera;
        let first_sample = self.job.settings.samples().start;
        let (sequence, first_index) = self.order.place(pixel.map(|n| n as u32));
        departures.clear();
        for index in indices {
            sampler.start(sequence, first_index + first_sample + index);
            let within = sampler.next_2d();
            let aperture = if camera.has_aperture() {
                sampler.next_2d()
            } else {
                sampler.skip();
                [0.0; 2]
            };
            let u_wavelengths = sampler.next_1d();
            let (u_wavelengths, sharing) =
                shared(index).map_or((u_wavelengths, Sharing::Nothing), |(u, group)| (u, Sharing::Group(group)));
            // A camera that stands still needs no time, and its samples stay what they are.
            let time = if camera.moves() { sampler.next_1d() } else { 0.0 };
            let spread = if camera.spreads_points() { sampler.next_2d() } else { [0.0; 2] };
            let pixel = DVec2::from_array(pixel.map(|n| n as f64)) + DVec2::from_array(within.map(f64::from));
            departures.samples.push(CameraSample { pixel, aperture, time, spread });
            departures.u_wavelengths.push(u_wavelengths);
            departures.places.push((sampler.place(), sharing));
        }
        let wavelengths = self.wavelengths.at(pixel[0], pixel[1]);
        departures.wavelengths.extend(departures.u_wavelengths.iter().map(|&u| wavelengths.sample(u)));
        if self.has_lone_heroes {
            departures.wavelengths.iter_mut().for_each(Wavelengths::terminate_secondary);
        }
    }

    /// Adds the paths that were prepared to a wave. Gives `go` the number of each with what the lens lets through of the light
    /// that arrives along it; `None` where it sees nothing.
    fn depart(&self, departures: &mut Departures, wave: &mut Wave, mut go: impl FnMut(usize, Option<SampledSpectrum>)) {
        let Departures { samples, wavelengths, places, .. } = departures;
        self.job.camera.generate_each(samples, wavelengths, |number, wavelengths, ray| {
            let through = ray.map(|(CameraRay { ray, weight }, weights)| {
                let (place, sharing) = places[number];
                wave.start(ray, *wavelengths, place, sharing);
                self.spectra.sample(self.transmittance, wavelengths) * weights * weight
            });
            go(number, through);
        });
    }

    /// Traces the paths of a wave and adds what arrives along each, by what the lens lets through, to a pixel of the band.
    fn trace(
        &self,
        wave: &mut Wave,
        destinations: &mut Vec<Destination<'_>>,
        sampler: &mut Sampler,
        band: &mut FilmBand<'_>,
    ) {
        wave.trace(self.job.scene, sampler);
        let mut numbers = 0..;
        for samples in destinations.chunk_by(|a, b| a.pixel == b.pixel) {
            let arrived = samples.iter().zip(&mut numbers).map(|(Destination { through, of_lamps, .. }, number)| {
                let (light, wavelengths) = wave.arrived(number);
                of_lamps.iter().map(Splat::light).chain([(light * *through, wavelengths)])
            });
            band.add(samples[0].pixel, arrived);
        }
        destinations.clear();
        wave.clear();
    }
}
