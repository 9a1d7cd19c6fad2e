//! Light tracing: paths from lights, for what camera paths seldom find, the caustics that mirrors, glass and polished
//! metal cast on other surfaces.
//!
//! A path starts at a light, is scattered from surface to surface, and every vertex but the first is connected to the
//! camera ([Arvo86](photosite_core::references#arvo86); light tracing, or t = 1 in
//! [Veach97](photosite_core::references#veach97) §10.2). With the power β that a path carries there, what a surface
//! scatters from ωᵢ to the lens at ωₒ adds to the irradiance of the pixel that is at x in the picture, for one of N
//! paths,
//!
//! E = w·β·f(ωₒ, ωᵢ)·|n_s·ωᵢ|/|n_g·ωᵢ| · We · |dx/dA| / N,
//!
//! with the weight We of the camera's ray ([`Camera::generate`](crate::optics::Camera::generate)), the area dx of the
//! picture that shows the area dA of the surface, and the shading and the geometric normal n_s and n_g: f is that of
//! radiance, and the ratio of cosines what makes one of power of it ([Veach97](photosite_core::references#veach97)
//! §5.3). The weights w are those of [`super::mis_ratio`].
//!
//! For each sample of all pixels as many light paths start, with random numbers of their own. What they bring to a
//! pixel belongs to its sample of that index, so that the variance of samples is that of both together. A path ends at
//! the first surface if that does not [cast caustics](crate::bsdf::Bsdf::casts_caustics): camera paths find its light
//! well.

use std::ops::Range;

use glam::{DVec2, Vec3};
use rayon::prelude::*;

use super::interaction::{leaks, light_sample_context, shadow_ray, spawn_ray, terminate_secondary};
use super::job::RenderJob;
use super::mis_ratio::{MisRatio, PathVertex, delta_term, light_weight};
use super::path::PathLimits;
use crate::geometry::{Hit, Ray, SurfacePoint, offset_origin};
use crate::light::LightRay;
use crate::sampler::{SamplePosition, Sampler};
use crate::scene::{Scene, Shading};
use photosite_core::math::float::gamma;
use photosite_core::spectrum::{SampledSpectrum, Spectrum, SpectrumId, SpectrumTable, WavelengthSampler, Wavelengths};

/// Paths that are traced together.
const WAVEFRONT_PATHS: u32 = 256;
/// Number of paths whose splats are stored at once, unless one sample has more: where all is polished, 250 bytes each.
const MAX_STORED_PATHS: u32 = 1 << 20;
/// Sequence of their random numbers, beyond all that pixels have.
const SEQUENCE: u64 = 0x6c69_6768_7400_0000;

/// What light paths bring to one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splat {
    /// Number of the pixel in its film.
    pixel: u32,
    /// Number of the sample.
    sample: u32,
    /// W·m⁻²·nm⁻¹ at each wavelength.
    irradiance: SampledSpectrum,
    wavelengths: Wavelengths,
}

/// What light paths bring to a film, pixel by pixel and sample by sample.
#[derive(Debug, Default)]
pub(super) struct Splats {
    /// Pixel by pixel and sample by sample.
    splats: Vec<Splat>,
}

impl Splat {
    /// Spectral irradiance and its wavelengths.
    pub(super) fn light(&self) -> (SampledSpectrum, &Wavelengths) {
        (self.irradiance, &self.wavelengths)
    }

    fn key(&self) -> (u32, u32) {
        (self.pixel, self.sample)
    }
}

impl Splats {
    /// The splats of one sample of a pixel.
    #[inline]
    pub(super) fn of(&self, pixel: usize, sample: u32) -> &[Splat] {
        let key = (pixel as u32, sample);
        let own = &self.splats[self.splats.partition_point(|splat| splat.key() < key)..];
        &own[..own.iter().take_while(|splat| splat.key() == key).count()]
    }
}

/// Traces light paths.
pub(super) struct LightTracer<'a> {
    job: &'a RenderJob<'a>,
    limits: PathLimits,
    seed: u64,
    wavelengths: WavelengthSampler,
    spectra: SpectrumTable,
    transmittance: SpectrumId,
    /// Paths for each sample of all pixels.
    paths: u32,
    /// N/(n·κ) of [`super::mis_ratio`].
    scale: f32,
    has_single_wavelengths: bool,
}

impl<'a> LightTracer<'a> {
    /// For a render with the numbers of `seed`; `None` where there are no such paths. Their wavelengths are those of
    /// `importance`, since no one knows to which pixel they will come.
    pub(super) fn new(job: &'a RenderJob<'a>, limits: PathLimits, seed: u64, importance: &Spectrum) -> Option<Self> {
        let share = job.settings.light_paths;
        // The shortest path has three segments: light, surface that casts caustics, surface that is seen, lens.
        let is_still = !job.camera.moves() && !job.camera.scans();
        let may_find_any = job.scene.lights().has_emitters() && job.scene.may_cast_caustics();
        if share <= 0.0 || limits.max_depth < 3 || !is_still || !may_find_any {
            return None;
        }
        let paths = (share * job.pixels() as f64).ceil().min(f64::from(u32::MAX)) as u32;
        let scale = f64::from(paths) / (f64::from(limits.splitting) * job.camera.px2_per_sr());
        let mut spectra = SpectrumTable::default();
        let transmittance = spectra.add(job.transmittance);
        Some(Self {
            job,
            limits,
            seed,
            wavelengths: WavelengthSampler::new(importance),
            spectra,
            transmittance,
            paths,
            scale: scale as f32,
            has_single_wavelengths: job.has_single_wavelengths(),
        })
    }

    /// Samples whose paths are best traced at once.
    pub(super) fn samples_per_batch(&self) -> usize {
        (MAX_STORED_PATHS / self.paths).max(1) as usize
    }

    /// MIS ratio of camera paths before their first surface.
    pub(super) fn mis_ratio(&self) -> MisRatio {
        MisRatio::new(self.scale)
    }

    /// What those that belong to the samples with such numbers bring to some rows of the picture, to be kept where
    /// `wants` says so of a pixel, by its number from the first of these rows on, and a sample.
    pub(super) fn trace(
        &self,
        samples: Range<u32>,
        rows: Range<usize>,
        wants: impl Fn(usize, u32) -> bool + Sync,
    ) -> Splats {
        let paths = u64::from(self.paths);
        let all = u64::from(samples.start) * paths..u64::from(samples.end) * paths;
        let together = u64::from(WAVEFRONT_PATHS);
        // The same waves whichever samples are asked for, so that sums are of one order.
        let mut splats: Vec<Splat> = (all.start / together..all.end.div_ceil(together))
            .into_par_iter()
            .map_init(
                || LightWavefront::new(self, rows.clone()),
                |wavefront, number| {
                    let first = number * together;
                    wavefront.trace(first.max(all.start)..(first + together).min(all.end));
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
    /// Rows of the picture that matter.
    rows: Range<usize>,
    paths: Vec<LightPath>,
    /// Indices and rays of the paths that go on.
    active: (Vec<u32>, Vec<Ray>),
    next: (Vec<u32>, Vec<Ray>),
    hits: Vec<Option<Hit>>,
    /// Rays to the lens, and what comes there unless something is in the way.
    to_lens: Vec<Ray>,
    seen: Vec<Splat>,
    occluded: Vec<bool>,
    splats: Vec<Splat>,
}

/// A path that is about to go on along a ray.
struct LightPath {
    /// Number of the sample that it belongs to.
    sample: u32,
    /// Position in its random numbers.
    position: SamplePosition,
    wavelengths: Wavelengths,
    emission: LightRay,
    /// β, W·nm⁻¹ at each wavelength.
    power: SampledSpectrum,
    /// q of [`super::mis_ratio`] so far, without the factor of the surface that the camera sees.
    mis_ratio: f32,
    /// Segments so far.
    depth: u32,
    /// The absorbing medium that the path is in.
    medium: Option<SpectrumId>,
    /// Length of the path since its light, m, until a surface tells which medium that is in.
    unresolved_distance_m: Option<f32>,
}

impl<'a> LightWavefront<'a> {
    fn new(tracer: &'a LightTracer<'a>, rows: Range<usize>) -> Self {
        Self {
            tracer,
            sampler: Sampler::new(tracer.job.settings.sampler, tracer.seed),
            rows,
            paths: Vec::new(),
            active: Default::default(),
            next: Default::default(),
            hits: Vec::new(),
            to_lens: Vec::new(),
            seen: Vec::new(),
            occluded: Vec::new(),
            splats: Vec::new(),
        }
    }

    /// Traces paths by their numbers, of all samples.
    fn trace(&mut self, numbers: Range<u64>) {
        let scene = self.tracer.job.scene;
        self.paths.clear();
        numbers.for_each(|number| self.start(number));
        while !self.active.0.is_empty() {
            scene.closest_each(&self.active.1, &mut self.hits);
            let (numbers, rays) = std::mem::take(&mut self.active);
            for (i, (&number, ray)) in numbers.iter().zip(&rays).enumerate() {
                let Some(hit) = self.hits[i] else { continue };
                if let Some(ray) = self.advance(number, ray, &hit) {
                    self.next.0.push(number);
                    self.next.1.push(ray);
                }
            }
            self.active = std::mem::take(&mut self.next);
            self.next = (numbers, rays);
            self.next.0.clear();
            self.next.1.clear();
        }
        scene.occluded_each(&self.to_lens, &mut self.occluded);
        let seen = self.seen.drain(..).zip(&self.occluded);
        self.splats.extend(seen.filter(|(_, occluded)| !**occluded).map(|(splat, _)| splat));
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
        let Some(emission) = tracer.job.scene.sample_le(0.0, u, &wavelengths) else { return };
        let LightRay { position, normal, direction, radiance, density, .. } = emission;
        // As for shadow rays.
        let origin = offset_origin(position, position.abs() * gamma(8), normal, direction);
        self.active.0.push(self.paths.len() as u32);
        self.active.1.push(Ray::new(origin, direction));
        self.paths.push(LightPath {
            sample: (number / u64::from(tracer.paths)) as u32,
            position: sampler.position(),
            wavelengths,
            emission,
            power: radiance * (1.0 / density),
            mis_ratio: tracer.scale * density,
            depth: 0,
            medium: None,
            unresolved_distance_m: Some(0.0),
        });
    }

    /// Connects the vertex that a path has come to with the camera, and returns the ray along which the path goes on.
    fn advance(&mut self, number: u32, ray: &Ray, hit: &Hit) -> Option<Ray> {
        let Self { tracer, sampler, rows, paths, to_lens, seen, .. } = self;
        let scene = tracer.job.scene;
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

        // End paths that cannot become caustics
        if path.depth == 1 && !shading.bsdf.casts_caustics() {
            return None;
        }
        sampler.resume(path.position);
        let (aperture, spread) = (sampler.next_2d(), sampler.next_2d());
        if path.depth > 1
            && !shading.bsdf.is_delta()
            && let Some((ray, splat)) = path.connect_to_camera(tracer, rows, (&point, wi), aperture, spread)
        {
            to_lens.push(ray);
            seen.push(splat);
        }

        // Sample the BSDF for the next direction; one more segment leads to a surface, and one from there to the lens
        if path.depth + 2 > tracer.limits.max_depth {
            return None;
        }
        path.scatter(tracer, (&point, &shading, wi), hit.t, sampler)
    }
}

/// The cosines of a direction to the geometric and, with its sign, to the shading normal.
#[inline]
fn cosines(point: &SurfacePoint, shading: &Shading, w: Vec3) -> (f32, f32) {
    (w.dot(point.geometric_normal).abs(), w.dot(shading.frame.z))
}

impl LightPath {
    /// Absorbs along the segment to a point. A volume that is seen from within for the first time has been all around
    /// since the light, as it is for paths from the camera, which come into it before they come to the light.
    fn absorb(&mut self, scene: &Scene, point: &SurfacePoint, wi: Vec3, distance: f32) {
        let behind = scene.absorption_behind(point, wi);
        self.medium = behind.or(self.medium);
        match self.medium {
            Some(medium) => {
                let distance = distance + self.unresolved_distance_m.take().unwrap_or(0.0);
                self.power *= scene.transmittance(medium, distance, &self.wavelengths);
            }
            None => self.unresolved_distance_m = self.unresolved_distance_m.map(|untold| untold + distance),
        }
    }

    /// The shadow ray from a vertex to the lens, and what a pixel gets if nothing occludes it.
    fn connect_to_camera(
        &self,
        tracer: &LightTracer<'_>,
        rows: &Range<usize>,
        (point, wi): (&SurfacePoint, Vec3),
        aperture: [f32; 2],
        spread: [f32; 2],
    ) -> Option<(Ray, Splat)> {
        let RenderJob { scene, camera, resolution: [width, _], .. } = *tracer.job;
        let mut wavelengths = self.wavelengths;
        let connection = camera.connect(point.position, aperture, spread, &mut wavelengths)?;
        let DVec2 { x: column, y: row } = camera.cells().cell_at(connection.pixel);
        let is_in_picture =
            column >= 0.0 && column < f64::from(width) && row >= rows.start as f64 && row < rows.end as f64;
        if !(is_in_picture && camera.cells().sees_light(connection.pixel)) {
            return None;
        }
        let origin = connection.ray.ray.origin;
        let to_lens = origin - point.position;
        let distance = to_lens.length();
        let wo = to_lens / distance;
        let shading = scene.shading(point, wo, &wavelengths);
        let (wo_local, wi_local) = (shading.frame.to_local(wo), shading.frame.to_local(wi));
        let leaks = leaks(point, &shading, wo, wi, wo_local.z * wi_local.z < 0.0);
        if leaks || shading.bsdf.is_edge_on(wo_local) {
            return None;
        }
        let scattering = shading.bsdf.eval(wo_local, wi_local);
        let (cos_to_camera, _) = cosines(point, &shading, wo);
        let (cos_to_light, cos_shading) = cosines(point, &shading, wi);
        let path_vertex =
            PathVertex { cos_to_camera, cos_to_light, pdf_to_camera: 0.0, pdf_to_light: scattering.pdf.0 };
        let weight = light_weight(self.mis_ratio * path_vertex.first_term(distance));
        let px2_per_m2 = connection.px2_per_m2 * cos_to_camera;
        let of_lens = connection.ray.weight * px2_per_m2 / tracer.paths as f32;
        let mut irradiance = self.power * scattering.f * (cos_shading.abs() / cos_to_light * of_lens * weight);
        if let Some(medium) = scene.absorption_behind(point, wo) {
            irradiance *= scene.transmittance(medium, distance, &wavelengths);
        }
        irradiance *= tracer.spectra.sample(tracer.transmittance, &wavelengths) * connection.weights;
        let pixel = (row as usize - rows.start) * width as usize + column as usize;
        let is_light = irradiance.is_finite() && !irradiance.is_black();
        is_light.then(|| {
            let splat = Splat { pixel: pixel as u32, sample: self.sample, irradiance, wavelengths };
            (shadow_ray(point, wo, Some((origin, Vec3::ZERO))), splat)
        })
    }

    /// The ray along which the path goes on from a surface that it has come to from `distance`; `None` where it ends
    /// there.
    fn scatter(
        &mut self,
        tracer: &LightTracer<'_>,
        (point, shading, wi): (&SurfacePoint, &Shading, Vec3),
        distance: f32,
        sampler: &mut Sampler,
    ) -> Option<Ray> {
        let scene = tracer.job.scene;
        let wi_local = shading.frame.to_local(wi);
        let sample = shading.bsdf.sample(wi_local, sampler.next_1d(), sampler.next_2d())?;
        let wo = shading.frame.to_world(sample.wi);
        if leaks(point, shading, wi, wo, sample.is_transmission) {
            return None;
        }
        let (cos_to_camera, _) = cosines(point, shading, wo);
        let (cos_to_light, _) = cosines(point, shading, wi);
        let factor = if sample.is_delta {
            // The index is that of the camera's side over the light's. Reciprocity: f(ωₒ, ωᵢ) = η²·f(ωᵢ, ωₒ).
            let eta_squared = sample.eta * sample.eta;
            self.mis_ratio *= delta_term(1.0 / sample.eta);
            let bend = if sample.is_transmission { (wi_local.z / sample.wi.z).abs() } else { 1.0 };
            let seen = scene.shading(point, wo, &self.wavelengths);
            if seen.bsdf.is_edge_on(seen.frame.to_local(wo)) {
                return None;
            }
            sample.throughput() * (eta_squared * bend * cos_to_camera / cos_to_light)
        } else {
            // As the camera sees it: its shading normal may differ where one of both directions is beyond the horizon.
            let shading = scene.shading(point, wo, &self.wavelengths);
            let (wo_local, wi_local) = (shading.frame.to_local(wo), shading.frame.to_local(wi));
            let leaks = leaks(point, &shading, wo, wi, wo_local.z * wi_local.z < 0.0);
            if leaks || shading.bsdf.is_edge_on(wo_local) {
                return None;
            }
            let scattering = shading.bsdf.eval(wo_local, wi_local);
            let pdf_to_camera = shading.bsdf.reverse_pdf(wo_local, wi_local).0;
            let path_vertex = PathVertex { cos_to_camera, cos_to_light, pdf_to_camera, pdf_to_light: scattering.pdf.0 };
            self.mis_ratio *= if self.depth == 1 {
                path_vertex.last_term(self.light_pdf(scene, point, &shading, distance))
            } else {
                path_vertex.inner_term()
            };
            scattering.f * (wi_local.z.abs() * cos_to_camera / (cos_to_light * sample.pdf.0))
        };
        self.power *= factor;
        if sample.terminates_secondary {
            terminate_secondary(&mut self.wavelengths, &mut self.power);
        }
        if self.power.is_black() || !self.power.is_finite() {
            return None;
        }
        if sample.is_transmission {
            self.medium = scene.medium_across(point, wo, self.medium);
            self.unresolved_distance_m = None;
        }
        if self.depth >= tracer.limits.roulette_depth {
            let survival = factor.max();
            if survival < 1.0 {
                if sampler.next_1d() >= survival {
                    return None;
                }
                self.power *= 1.0 / survival;
            }
        }
        sampler.save(&mut self.position);
        Some(spawn_ray(point, wo))
    }

    /// Density with which the first surface, at that distance, samples the point that the path starts from.
    fn light_pdf(&self, scene: &Scene, point: &SurfacePoint, shading: &Shading, distance: f32) -> f32 {
        let LightRay { light, normal, direction, .. } = self.emission;
        let ctx = light_sample_context(point, shading);
        let cos = direction.dot(normal);
        scene.lights().triangle_pdf(light, &ctx, scene.geometry(), point.time, distance, cos).0
    }
}
