//! Light tracing: paths from lights, for what camera paths seldom find, the caustics that mirrors, glass and polished
//! metal cast on other surfaces, and the light of lamps that most surfaces do not see.
//!
//! A path starts at a light, is scattered from surface to surface, and every vertex but the first is connected to the
//! camera ([Arvo86](photosite_core::references#arvo86); light tracing, or t = 1 in
//! [Veach97](photosite_core::references#veach97) §10.2). With the power β that a path carries there, what a surface
//! scatters from ωᵢ to the lens at ωₒ adds to the irradiance of the pixel that is at x in the image, for one of N
//! paths,
//!
//! E = w·β·f(ωₒ, ωᵢ)·|n_s·ωᵢ|/|n_g·ωᵢ| · We · |dx/dA| / N,
//!
//! with the weight We of the camera's ray ([`Camera::generate`](crate::optics::Camera::generate)), the area dx of the
//! image that shows the area dA of the surface, and the shading and the geometric normal n_s and n_g: f is that of
//! radiance, and the ratio of cosines what makes one of power of it ([Veach97](photosite_core::references#veach97)
//! §5.3). The weights w are those of [`super::mis_ratio`]. Of a prescription, light goes in through the glass, and each
//! wavelength lands in a pixel of its own ([`Camera::arrive_each`](crate::optics::Camera::arrive_each)).
//!
//! For each sample of all pixels as many light paths start, with random numbers of their own. What they bring to a
//! pixel belongs to its sample of that index, so that the variance of samples is that of both together. Paths for
//! caustics alone ([`LightPathKind`]) end at a first surface that does not
//! [cast them](crate::bsdf::Bsdf::casts_caustics).

mod light_path;
mod splats;

use std::ops::Range;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use self::light_path::{LensPoint, LightPath, LightTracing};
pub(super) use self::splats::{Splat, Splats};
use super::interaction::terminate_secondary;
use super::job::RenderJob;
use super::mis_ratio::MisRatio;
use super::path::PathLimits;
use super::ray_counts::RayCounts;
use super::settings::LightPathKind;
use crate::geometry::{Hit, Ray, SurfacePoint, offset_origin};
use crate::light::LightRay;
use crate::optics::{LensRays, TowardsLens};
use crate::sampler::Sampler;
use photosite_core::spectrum::{LANES, SampledSpectrum, Spectrum, SpectrumTable, WavelengthSampler};

/// Paths that are traced together.
const WAVEFRONT_PATHS: u32 = 256;
/// Number of paths whose splats are stored at once, unless one sample has more: where all is polished, 250 bytes each.
const MAX_STORED_PATHS: u32 = 1 << 20;
/// Cost of a path beside its rays, and of a connection to the lens beside its own, in rays to surfaces: behind a screen, where
/// nearly all is connections, a light path took 5.7 times as long as one from the camera.
const PATH_COST: f64 = 2.4;
const CONNECTION_COST: f64 = 2.5;
/// Sequence of their random numbers, beyond all that pixels have.
const SEQUENCE: u64 = 0x6c69_6768_7400_0000;

/// Traces light paths.
pub(super) struct LightTracer<'a> {
    tracing: LightTracing<'a>,
    kind: LightPathKind,
    seed: u64,
    wavelengths: WavelengthSampler,
    /// N/(n·κ) of [`super::mis_ratio`].
    scale: f32,
    has_single_wavelengths: bool,
    rays: RayCounts,
    /// Rays among these that paths for caustics alone would have, too.
    caustic_rays: RayCounts,
}

impl<'a> LightTracer<'a> {
    /// Prepares light paths with the random numbers of `seed`; `None` where there are none. Their wavelengths are those
    /// of `importance`, since no one knows to which pixel they will come. `lands_wavelengths` says whether those of
    /// paths from the camera land each in a pixel of its own.
    pub(super) fn new(
        job: &'a RenderJob<'a>,
        limits: PathLimits,
        seed: u64,
        importance: &Spectrum,
        lands_wavelengths: bool,
    ) -> Option<Self> {
        let share = job.settings.light_paths();
        // The shortest path has three segments: light, surface, surface that is seen, lens.
        let is_still = !job.camera.moves() && !job.camera.scans();
        if share <= 0.0 || limits.max_depth < 3 || !is_still || !job.scene.lights().has_emitters() {
            return None;
        }
        let paths = (share * job.pixels() as f64).ceil().min(f64::from(u32::MAX)) as u32;
        let scale = f64::from(paths) / (f64::from(limits.splitting) * job.camera.px2_per_sr());
        let mut spectra = SpectrumTable::default();
        let transmittance = spectra.add(job.transmittance);
        Some(Self {
            tracing: LightTracing { job, limits, spectra, transmittance, paths },
            kind: job.settings.light_path_kind.unwrap_or(LightPathKind::of(job.scene)[0]),
            seed,
            wavelengths: WavelengthSampler::new(importance),
            scale: scale as f32,
            // As of the paths from the camera that find the same.
            has_single_wavelengths: job.has_single_wavelengths() || job.camera.has_glass() && !lands_wavelengths,
            rays: RayCounts::default(),
            caustic_rays: RayCounts::default(),
        })
    }

    /// Samples whose paths are best traced at once.
    pub(super) fn samples_per_batch(&self) -> usize {
        (MAX_STORED_PATHS / self.tracing.paths).max(1) as usize
    }

    /// MIS ratio of camera paths before their first surface.
    pub(super) fn mis_ratio(&self) -> MisRatio {
        MisRatio::new(self.kind, self.scale, self.tracing.job.camera.least_distance_m())
    }

    /// Light that the paths of `samples` bring to some rows of the image, to be kept where `wants` says so of a pixel,
    /// by its number from the first of these rows on, and a sample.
    pub(super) fn trace(
        &self,
        samples: Range<u32>,
        rows: Range<usize>,
        wants: impl Fn(usize, u32) -> bool + Sync,
    ) -> Splats {
        let paths = u64::from(self.tracing.paths);
        self.trace_paths(u64::from(samples.start) * paths..u64::from(samples.end) * paths, rows, wants)
    }

    /// Number of paths for each sample of all pixels.
    pub(super) fn paths(&self) -> u32 {
        self.tracing.paths
    }

    /// Cost of `paths` paths, which were all that were traced, if they were of a kind.
    pub(super) fn cost(&self, paths: u64, kind: LightPathKind) -> f64 {
        let rays = match kind {
            LightPathKind::Caustics => &self.caustic_rays,
            LightPathKind::Indirect => &self.rays,
        };
        PATH_COST * paths as f64 + CONNECTION_COST * rays.shadow_rays() + rays.cost()
    }

    /// Light that paths of some numbers, counted over all samples, bring to some rows of the image; see
    /// [`trace`](Self::trace).
    pub(super) fn trace_paths(
        &self,
        all: Range<u64>,
        rows: Range<usize>,
        wants: impl Fn(usize, u32) -> bool + Sync,
    ) -> Splats {
        let together = u64::from(WAVEFRONT_PATHS);
        // The same waves whichever samples are asked for, so that sums are of one order.
        let mut splats: Vec<Splat> = (all.start / together..all.end.div_ceil(together))
            .into_par_iter()
            .map_init(
                || LightWavefront::new(self, rows.clone()),
                |wavefront, number| {
                    let first = number * together;
                    wavefront.trace(first.max(all.start)..(first + together).min(all.end));
                    self.rays.add(std::mem::take(&mut wavefront.rays));
                    self.caustic_rays.add(std::mem::take(&mut wavefront.caustic_rays));
                    wavefront
                        .splats
                        .drain(..)
                        .filter(|splat| wants(splat.pixel as usize, splat.sample))
                        .collect::<Vec<_>>()
                },
            )
            .flatten_iter()
            .collect();
        splats.par_sort_by_key(Splat::key);
        Splats { splats }
    }
}

/// A wavefront of light paths.
struct LightWavefront<'a> {
    tracer: &'a LightTracer<'a>,
    sampler: Sampler,
    /// Rows of the image that matter.
    rows: Range<usize>,
    paths: Vec<LightPath>,
    /// Indices and rays of the paths that go on.
    active: (Vec<u32>, Vec<Ray>),
    next: (Vec<u32>, Vec<Ray>),
    hits: Vec<Option<Hit>>,
    /// Vertices that are to be connected to the lens through glass.
    vertices: Vec<(LightPath, SurfacePoint, Vec3)>,
    towards_lens: Vec<TowardsLens>,
    lens_rays: LensRays,
    /// Rays to the lens, and what comes there, by the number of the ray, unless something is in the way.
    to_lens: Vec<Ray>,
    seen: Vec<(u32, Splat)>,
    occluded: Vec<bool>,
    splats: Vec<Splat>,
    /// Rays that were traced to surfaces and to the lens, and those among them of paths that bring caustics.
    rays: [u64; 2],
    caustic_rays: [u64; 2],
}

impl<'a> LightWavefront<'a> {
    fn new(tracer: &'a LightTracer<'a>, rows: Range<usize>) -> Self {
        Self {
            tracer,
            sampler: Sampler::new(tracer.tracing.job.settings.sampler, tracer.seed),
            rows,
            paths: Vec::new(),
            active: Default::default(),
            next: Default::default(),
            hits: Vec::new(),
            vertices: Vec::new(),
            towards_lens: Vec::new(),
            lens_rays: LensRays::default(),
            to_lens: Vec::new(),
            seen: Vec::new(),
            occluded: Vec::new(),
            splats: Vec::new(),
            rays: [0; 2],
            caustic_rays: [0; 2],
        }
    }

    /// Traces paths by their numbers, of all samples.
    fn trace(&mut self, numbers: Range<u64>) {
        let scene = self.tracer.tracing.job.scene;
        self.paths.clear();
        numbers.for_each(|number| self.start(number));
        while !self.active.0.is_empty() {
            self.rays[0] += self.active.1.len() as u64;
            scene.closest_each(&self.active.1, &mut self.hits);
            let (numbers, rays) = std::mem::take(&mut self.active);
            for (i, (&number, ray)) in numbers.iter().zip(&rays).enumerate() {
                self.caustic_rays[0] += u64::from(self.paths[number as usize].is_caustic);
                let Some(hit) = self.hits[i] else { continue };
                if let Some(ray) = self.advance(number, ray, &hit) {
                    self.next.0.push(number);
                    self.next.1.push(ray);
                }
            }
            self.connect_through_glass();
            self.active = std::mem::take(&mut self.next);
            self.next = (numbers, rays);
            self.next.0.clear();
            self.next.1.clear();
        }
        self.rays[1] += self.to_lens.len() as u64;
        scene.occluded_each(&self.to_lens, &mut self.occluded);
        let seen = self.seen.drain(..).filter(|(ray, _)| !self.occluded[*ray as usize]);
        self.splats.extend(seen.map(|(_, splat)| splat));
        self.to_lens.clear();
    }

    /// Starts a path.
    fn start(&mut self, number: u64) {
        let Self { tracer, sampler, .. } = self;
        sampler.start(SEQUENCE + (number >> 32), number as u32);
        let mut wavelengths = tracer.wavelengths.sample(sampler.next_1d());
        if tracer.has_single_wavelengths {
            wavelengths.terminate_secondary();
        }
        let u = (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
        let Some(emission) = tracer.tracing.job.scene.sample_le(0.0, u, &wavelengths) else { return };
        let LightRay { position, error, normal, direction, radiance, density, .. } = emission;
        let origin = offset_origin(position, error, normal, direction);
        self.active.0.push(self.paths.len() as u32);
        self.active.1.push(Ray::new(origin, direction));
        self.paths.push(LightPath {
            sample: (number / u64::from(tracer.tracing.paths)) as u32,
            position: sampler.position(),
            wavelengths,
            emission,
            power: radiance * (1.0 / density),
            mis_ratio: tracer.scale * density,
            depth: 0,
            is_caustic: true,
            medium: None,
            unresolved_distance_m: Some(0.0),
        });
    }

    /// Connects the vertex that a path has come to with the camera, and returns the ray along which the path goes on.
    fn advance(&mut self, number: u32, ray: &Ray, hit: &Hit) -> Option<Ray> {
        let Self { tracer, sampler, rows, paths, vertices, towards_lens, to_lens, seen, caustic_rays, .. } = self;
        let scene = tracer.tracing.job.scene;
        let path = &mut paths[number as usize];
        path.depth += 1;

        // Absorb along the segment
        let point = scene.point(hit, ray.time);
        let wi = -ray.direction;
        path.absorb(scene, &point, wi, hit.t);

        // Look up the BSDF, and drop the secondary wavelengths if it cannot serve them
        let shading = scene.shading(&point, wi, &path.wavelengths);
        if shading.bsdf.needs_single_wavelength() {
            terminate_secondary(&mut path.wavelengths, &mut path.power);
        }

        // End paths that bring nothing that is kept
        if path.depth == 1 {
            path.is_caustic = shading.bsdf.casts_caustics();
            if !tracer.kind.holds(path.is_caustic) {
                return None;
            }
        }
        sampler.resume(path.position);
        let (aperture, spread) = (sampler.next_2d(), sampler.next_2d());
        if path.depth > 1 && !shading.bsdf.is_delta() {
            if tracer.tracing.job.camera.has_glass() {
                towards_lens.push(TowardsLens {
                    point: point.position,
                    sample: aperture,
                    spread,
                    wavelengths: path.wavelengths,
                });
                vertices.push((*path, point, wi));
            } else if let Some((ray, splat)) = connect(&tracer.tracing, rows, path, (&point, wi), aperture, spread) {
                seen.push((to_lens.len() as u32, splat));
                to_lens.push(ray);
                caustic_rays[1] += u64::from(path.is_caustic);
            }
        }

        // Sample the BSDF for the next direction; one more segment leads to a surface, and one from there to the lens
        if path.depth + 2 > tracer.tracing.limits.max_depth {
            return None;
        }
        path.scatter(&tracer.tracing, (&point, &shading, wi), hit.t, sampler)
    }
    /// Connects the vertices at hand with a camera whose rays go through glass.
    fn connect_through_glass(&mut self) {
        let Self { tracer, rows, vertices, towards_lens, lens_rays, to_lens, seen, caustic_rays, .. } = self;
        let RenderJob { camera, resolution: [width, _], .. } = *tracer.tracing.job;
        camera.arrive_each(towards_lens, lens_rays, |i, arrival| {
            let (path, point, wi) = &vertices[i];
            let mut weights = [0.0; LANES];
            for (weight, landing) in weights.iter_mut().zip(&arrival.landings) {
                if rows.contains(&(landing.cell[1] as usize)) {
                    *weight = landing.weight;
                }
            }
            let weights = SampledSpectrum::from(weights);
            let lens = LensPoint { origin: arrival.front, weight: 1.0, px2_per_m2: 1.0, weights };
            let Some((ray, irradiance, mis_ratio)) = path.sent(&tracer.tracing, (point, *wi), &lens, &path.wavelengths)
            else {
                return;
            };
            // Wavelengths that land in one pixel go together
            for lane in 0..LANES {
                let cell = arrival.landings[lane].cell;
                let is_first = (0..lane).all(|before| weights[before] == 0.0 || arrival.landings[before].cell != cell);
                if weights[lane] == 0.0 || !is_first {
                    continue;
                }
                let here = |other: usize| if arrival.landings[other].cell == cell { irradiance[other] } else { 0.0 };
                let [column, row] = cell.map(|n| n as usize);
                let splat = Splat {
                    pixel: ((row - rows.start) * width as usize + column) as u32,
                    sample: path.sample,
                    irradiance: SampledSpectrum::from_lanes(here),
                    wavelengths: path.wavelengths,
                    mis_ratio,
                    is_caustic: path.is_caustic,
                };
                seen.push((to_lens.len() as u32, splat));
            }
            to_lens.push(ray);
            caustic_rays[1] += u64::from(path.is_caustic);
        });
        vertices.clear();
        towards_lens.clear();
    }
}

/// The shadow ray from a vertex of a path to a lens without glass, and what a pixel gets if nothing occludes it.
fn connect(
    tracing: &LightTracing<'_>,
    rows: &Range<usize>,
    path: &LightPath,
    (point, wi): (&SurfacePoint, Vec3),
    aperture: [f32; 2],
    spread: [f32; 2],
) -> Option<(Ray, Splat)> {
    let RenderJob { camera, resolution: [width, _], .. } = *tracing.job;
    let mut wavelengths = path.wavelengths;
    let connection = camera.connect(point.position, aperture, spread, &mut wavelengths)?;
    let DVec2 { x: column, y: row } = camera.cells().cell_at(connection.pixel);
    let is_in_image = column >= 0.0 && column < f64::from(width) && row >= rows.start as f64 && row < rows.end as f64;
    if !(is_in_image && camera.cells().sees_light(connection.pixel)) {
        return None;
    }
    let lens = LensPoint {
        origin: connection.ray.ray.origin,
        weight: connection.ray.weight,
        px2_per_m2: connection.px2_per_m2,
        weights: connection.weights,
    };
    let (ray, irradiance, ratio) = path.sent(tracing, (point, wi), &lens, &wavelengths)?;
    let splat = Splat {
        pixel: ((row as usize - rows.start) * width as usize + column as usize) as u32,
        sample: path.sample,
        irradiance,
        wavelengths,
        mis_ratio: ratio,
        is_caustic: path.is_caustic,
    };
    Some((ray, splat))
}
