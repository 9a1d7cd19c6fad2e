//! Path tracing, surface by surface: unidirectional path tracing with next-event estimation, multiple importance
//! sampling and Russian roulette ([pbrt4](photosite_core::references#pbrt4) §14.4). [`Path::advance`] is the body of
//! its loop.

mod diffuse_batch;

use glam::Vec3;

pub(super) use self::diffuse_batch::DiffuseBatch;
use super::interaction::{leaks, light_sample_context, shadow_ray, terminate_secondary};
use super::mis_ratio::{MisRatio, PathVertex};
use crate::bsdf::BsdfSample;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::light::{LightSample, LightSampleContext};
use crate::sampler::{SamplePosition, Sampler};
use crate::scene::{Scene, Shading};
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, Wavelengths};

/// Limits of paths: the lengths at which paths end, and the number of branches.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits {
    /// Largest number of segments from the camera.
    pub max_depth: u32,
    /// Number of segments after which Russian roulette may end a path.
    pub roulette_depth: u32,
    /// Number of branches that go on from the first surface that is no mirror, at least 1.
    pub splitting: u32,
}

/// A path that is about to go on along a ray, and the light that it has gathered.
///
/// The radiance that arrives against its first ray is the expected value of its light:
///
/// L = Σ over vertices of throughput · (emission found by BSDF sampling · w_bsdf + emission found by light sampling ·
/// w_light),
///
/// with the power heuristic for the weights ([Veach97](photosite_core::references#veach97) §9.2,
/// [pbrt4](photosite_core::references#pbrt4) §14.4).
///
/// A few samples suffice for the direct light of the first rough surface; its indirect light is noisier. Paths
/// therefore split there: several branches cost less than as many paths from the camera
/// ([ArvoKirk90](photosite_core::references#arvokirk90)).
///
/// Volumes that surfaces bound absorb by the law of Beer and Lambert along every segment within them. A volume within
/// another replaces it, and the outermost boundary on the way out leads to air.
#[derive(Clone, Copy)]
pub(super) struct Path {
    /// Radiance gathered, W·m⁻²·sr⁻¹·nm⁻¹ at each wavelength.
    pub(super) light: SampledSpectrum,
    /// The wavelengths; dispersive refraction leaves only the hero.
    pub(super) wavelengths: Wavelengths,
    /// Position in its random numbers.
    position: SamplePosition,
    /// Index of the path that this one is a branch of.
    pub(super) origin: Option<u32>,
    /// Number of segments so far.
    depth: u32,
    /// Product of f·|cos θ|/pdf over the vertices; β in pbrt.
    throughput: SampledSpectrum,
    /// Density with which the BSDF of the last vertex was sampled, and that vertex; `None` where light sampling could
    /// not have found this direction.
    last_bsdf: Option<(Pdf<SolidAngle>, LightSampleContext)>,
    /// Product of squared relative indices, which roulette must not take for a loss.
    eta_scale: f32,
    /// The absorbing medium that the path is in.
    medium: Option<SpectrumId>,
    /// Ratio of the densities with which paths from lights and this path find the same.
    mis_ratio: MisRatio,
}

/// The queues that paths fill while they advance to their next surfaces.
#[derive(Default)]
pub(super) struct Queues {
    /// Shadow rays from surfaces to lights.
    pub(super) shadow_rays: Vec<Ray>,
    /// Contributions of the shadow rays, one each.
    pub(super) contributions: Vec<Contribution>,
    /// Branches of paths that have split, and their rays.
    pub(super) branches: Vec<(Path, Ray)>,
}

/// Light that a path gathers if nothing is in the way of a shadow ray.
#[derive(Clone, Copy)]
pub(super) struct Contribution {
    /// Index of the path.
    pub(super) path: u32,
    pub(super) light: SampledSpectrum,
    /// Whether the light has no surface, so that panes let it through.
    pub(super) is_delta: bool,
    /// The absorbing medium in which the ray sets out, where it is to be followed through panes.
    pub(super) medium: Option<SpectrumId>,
}

/// Data that paths need to advance.
pub(super) struct Tracing<'a> {
    pub(super) scene: &'a Scene,
    pub(super) limits: &'a PathLimits,
    pub(super) sampler: &'a mut Sampler,
    pub(super) queues: &'a mut Queues,
}

/// A surface that a path has met.
struct Vertex<'a> {
    /// Distance from the vertex before, m.
    distance: f32,
    point: &'a SurfacePoint,
    shading: &'a Shading,
    /// Direction back along the path, unit vector in world space.
    wo: Vec3,
    /// Direction back along the path, unit vector in the shading frame.
    wo_local: Vec3,
    ctx: LightSampleContext,
}

impl<'a> Vertex<'a> {
    #[inline]
    fn new(distance: f32, point: &'a SurfacePoint, shading: &'a Shading, wo: Vec3) -> Self {
        let ctx = light_sample_context(point, shading);
        Self { distance, point, shading, wo, wo_local: shading.frame.to_local(wo), ctx }
    }

    /// Cosines and densities of this vertex for the MIS ratio, with the density of scattering towards `wi`.
    #[inline]
    fn path_vertex(&self, wi: Vec3, wi_local: Vec3, pdf_to_light: f32) -> PathVertex {
        let normal = self.point.geometric_normal;
        PathVertex {
            cos_to_camera: self.wo.dot(normal).abs(),
            cos_to_light: wi.dot(normal).abs(),
            pdf_to_camera: self.shading.bsdf.reverse_pdf(self.wo_local, wi_local).0,
            pdf_to_light,
        }
    }
}

impl Path {
    /// A path from the camera, with the random numbers from a position on and the MIS ratio before the first surface.
    #[inline]
    pub(super) fn new(wavelengths: Wavelengths, position: SamplePosition, mis_ratio: MisRatio) -> Self {
        Self {
            light: SampledSpectrum::ZERO,
            wavelengths,
            position,
            origin: None,
            depth: 0,
            throughput: SampledSpectrum::ONE,
            last_bsdf: None,
            eta_scale: 1.0,
            medium: None,
            mis_ratio,
        }
    }

    /// Whether the path does nothing at diffuse surfaces but sample a light and scatter.
    #[inline]
    fn is_plain(&self, limits: &PathLimits) -> bool {
        let splits = limits.splitting > 1 && self.origin.is_none();
        !self.mis_ratio.is_shared() && !splits && self.medium.is_none() && self.depth + 1 < limits.max_depth
    }

    /// Gathers light where a ray has led, and returns the ray along which the path of this index goes on; `None` where
    /// it ends and where it splits.
    #[inline]
    pub(super) fn advance(
        &mut self,
        index: u32,
        ray: &Ray,
        hit: Option<Hit>,
        tracing: &mut Tracing<'_>,
    ) -> Option<Ray> {
        self.depth += 1;
        // Add the light of the environment where the ray leaves the scene
        let Some(hit) = hit else {
            self.add_environment(tracing.scene, ray.direction);
            return None;
        };

        // Absorb along the segment
        let scene = tracing.scene;
        let point = scene.point(&hit, ray.time);
        let wo = -ray.direction;
        self.absorb(scene, &point, wo, hit.t);

        // Add the surface's emission, weighted against light sampling and paths from lights
        self.add_emission(scene, &point, wo, hit.t);

        // End the path at its largest depth
        if self.depth == tracing.limits.max_depth {
            return None;
        }

        // Look up the BSDF, and drop the secondary wavelengths if it cannot serve them
        let shading = scene.shading(&point, wo, &self.wavelengths);
        if shading.bsdf.needs_single_wavelength() {
            terminate_secondary(&mut self.wavelengths, &mut self.throughput);
        }
        let vertex = Vertex::new(hit.t, &point, &shading, wo);

        tracing.sampler.resume(self.position);
        if !shading.bsdf.is_delta() {
            // Sample direct illumination, and queue its shadow ray
            self.sample_direct_light(index, &vertex, tracing);
            // Split at the first surface that is no mirror
            if tracing.limits.splitting > 1 && self.origin.is_none() {
                self.split(index, &vertex, tracing);
                return None;
            }
        }

        // Sample the BSDF for the next direction, and play Russian roulette
        self.scatter(&vertex, tracing)
    }

    /// Absorbs along a segment of length `distance` (m) that ends at a point.
    #[inline]
    fn absorb(&mut self, scene: &Scene, point: &SurfacePoint, wo: Vec3, distance: f32) {
        // A volume seen from behind has been crossed, whether or not its front was met before; without one, the path is
        // still in the medium that the last surface led into.
        self.medium = scene.absorption_behind(point, wo).or(self.medium);
        if let Some(medium) = self.medium {
            self.throughput *= scene.transmittance(medium, distance, &self.wavelengths);
        }
    }

    /// Gathers the emission of a surface at the end of a segment of length `distance` (m).
    #[inline]
    fn add_emission(&mut self, scene: &Scene, point: &SurfacePoint, wo: Vec3, distance: f32) {
        let emitted = scene.emitted(point, wo, &self.wavelengths);
        if !emitted.is_black() {
            self.light += self.throughput * emitted * self.emission_weight(scene, point, wo, distance);
        }
    }

    /// The light of a branch, at the wavelengths of the path that it comes from.
    #[inline]
    pub(super) fn arrived_at(&self, origin: &Self) -> SampledSpectrum {
        self.light * self.wavelengths.densities_over(&origin.wavelengths)
    }

    /// Gathers the light of the environment, weighted against light sampling.
    #[inline]
    fn add_environment(&mut self, scene: &Scene, direction: Vec3) {
        let emitted = scene.environment_radiance(direction, &self.wavelengths);
        if !emitted.is_black() {
            let weight = self
                .last_bsdf
                .map_or(1.0, |(pdf, ctx)| pdf.power_heuristic(scene.lights().environment_pdf(&ctx, direction)));
            self.light += self.throughput * emitted * weight;
        }
    }

    /// Queues several branches that go on from a surface, of which some may end there.
    // Out of the way of renders that do not split.
    #[inline(never)]
    fn split(&self, index: u32, vertex: &Vertex<'_>, tracing: &mut Tracing<'_>) {
        let (position, count) = (tracing.sampler.position(), tracing.limits.splitting);
        for branch in 0..count {
            let own = position.branch(branch, count);
            tracing.sampler.resume(own);
            let mut path = Self { origin: Some(index), light: SampledSpectrum::ZERO, position: own, ..*self };
            if let Some(ray) = path.scatter(vertex, tracing) {
                tracing.queues.branches.push((path, ray));
            }
        }
    }

    /// The ray along which the path goes on from a surface; `None` where it ends there.
    #[inline]
    fn scatter(&mut self, vertex: &Vertex<'_>, tracing: &mut Tracing<'_>) -> Option<Ray> {
        let Vertex { point, shading, wo, wo_local, ctx, .. } = vertex;
        let &mut Tracing { scene, limits, ref mut sampler, .. } = tracing;

        // Sample the BSDF
        let u_lobe = if shading.bsdf.has_lobes() {
            sampler.next_1d()
        } else {
            sampler.skip();
            0.0
        };
        let u = sampler.next_2d();
        let sample = shading.bsdf.sample(*wo_local, u_lobe, u)?;

        // Drop light that would leak through the surface
        let wi = shading.frame.to_world(sample.wi);
        if leaks(point, shading, *wo, wi, sample.is_transmission) {
            return None;
        }

        // Update the throughput, and the wavelengths after dispersion. What glass does not pass at the hero's wavelength ends
        // the path only then: otherwise the light so far would keep the others by what the hero meets.
        self.throughput *= sample.throughput();
        if sample.terminates_secondary {
            terminate_secondary(&mut self.wavelengths, &mut self.throughput);
        }
        if self.throughput.is_black() {
            return None;
        }

        // Update what weights and roulette need to know of the vertex
        if self.mis_ratio.is_shared() {
            self.mis_ratio = self.mis_ratio_after(vertex, wi, &sample);
        }
        self.eta_scale *= sample.eta * sample.eta;
        self.last_bsdf = (!sample.is_delta).then_some((sample.pdf, *ctx));
        if sample.is_transmission {
            self.medium = scene.medium_across(point, wi, self.medium);
        }

        // Play Russian roulette, and spawn the ray
        self.survives(limits, sampler).then(|| point.spawn_ray(wi))
    }

    /// Whether Russian roulette lets the path go on, with the random numbers from where the sampler is.
    #[inline]
    fn survives(&mut self, limits: &PathLimits, sampler: &mut Sampler) -> bool {
        if self.depth >= limits.roulette_depth {
            let survival = self.throughput.max() * self.eta_scale;
            if survival < 1.0 {
                if sampler.next_1d() >= survival {
                    return false;
                }
                self.throughput *= 1.0 / survival;
            }
        }
        sampler.save(&mut self.position);
        true
    }

    /// The MIS ratio beyond a surface that has scattered the path.
    // Out of the way of renders without paths from lights.
    #[inline(never)]
    fn mis_ratio_after(&self, vertex: &Vertex<'_>, wi: Vec3, sample: &BsdfSample) -> MisRatio {
        let is_first = self.depth == 1;
        let path_vertex = || vertex.path_vertex(wi, sample.wi, sample.pdf.0);
        // The shading normal is another for light that comes from there.
        if vertex.shading.bsdf.is_edge_on(vertex.wo_local) {
            return MisRatio::NONE;
        }
        match (sample.is_delta, is_first) {
            (true, true) => MisRatio::NONE,
            (true, false) => self.mis_ratio.after_delta(sample.eta),
            (false, true) => self.mis_ratio.after_first(&path_vertex(), vertex.distance),
            (false, false) => self.mis_ratio.after(&path_vertex(), vertex.shading.bsdf.casts_caustics()),
        }
    }

    /// Samples a light, and queues the shadow ray with what the path of this index gathers if nothing occludes it;
    /// pbrt's `SampleLd`.
    #[inline]
    fn sample_direct_light(&self, index: u32, vertex: &Vertex<'_>, tracing: &mut Tracing<'_>) {
        let Vertex { point, ctx, .. } = vertex;
        let u = tracing.sampler.next_2d();
        if let Some(light) = tracing.scene.sample_light(ctx, point.time, u, &self.wavelengths) {
            self.queue_direct_light(index, vertex, &light, tracing.scene, tracing.queues);
        }
    }

    /// Queues the shadow ray of a light sample.
    #[inline]
    fn queue_direct_light(
        &self,
        index: u32,
        vertex: &Vertex<'_>,
        sample: &LightSample,
        scene: &Scene,
        queues: &mut Queues,
    ) {
        if let Some((ray, light, medium)) = self.direct_light(scene, vertex, sample) {
            queues.shadow_rays.push(ray);
            let light = self.throughput * light;
            queues.contributions.push(Contribution { path: index, light, is_delta: sample.is_delta, medium });
        }
    }

    /// The shadow ray and contribution of a light sample, and the medium whose absorption is still to be counted.
    #[inline]
    fn direct_light(
        &self,
        scene: &Scene,
        vertex: &Vertex<'_>,
        light: &LightSample,
    ) -> Option<(Ray, SampledSpectrum, Option<SpectrumId>)> {
        let Vertex { point, shading, wo, wo_local, .. } = vertex;
        let wavelengths = &self.wavelengths;

        // Drop light that would leak through the surface
        let wi_local = shading.frame.to_local(light.wi);
        let is_transmission = wi_local.z * wo_local.z < 0.0;
        if light.pdf.0 <= 0.0 || leaks(point, shading, *wo, light.wi, is_transmission) {
            return None;
        }

        // Evaluate the BSDF for the direction of the light
        let scattering = shading.bsdf.eval(*wo_local, wi_local);
        let cos = wi_local.z.abs();
        let mut contribution = light.radiance * scattering.f * (cos / light.pdf.0);

        // Absorb on the way. Where shadow rays end at the boundary, light comes from within; others are followed.
        let medium = if is_transmission { scene.medium_across(point, light.wi, self.medium) } else { self.medium };
        let is_followed = light.is_delta && scene.has_panes();
        if let (false, Some(medium), Some((position, _))) = (is_followed, medium, light.position) {
            contribution *= scene.transmittance(medium, point.position.distance(position), wavelengths);
        }
        if contribution.is_black() {
            return None;
        }

        // Weight against BSDF sampling and against paths from lights
        let mut weight = if light.is_delta { 1.0 } else { light.pdf.power_heuristic(scattering.pdf) };
        let may_be_brought = self.depth > 1 && !light.is_delta;
        if may_be_brought && self.mis_ratio.holds(shading.bsdf.casts_caustics()) && !shading.bsdf.is_edge_on(*wo_local)
        {
            let path_vertex = vertex.path_vertex(light.wi, wi_local, scattering.pdf.0);
            let density = scene.emission_density(light.light, point.time);
            weight *= self.mis_ratio.mis_weight_light(&path_vertex, density, light.pdf.0);
        }
        let to = scene.lights().target_of(light.light);
        let ray = Ray { to, ..shadow_ray(point, light.wi, light.position) };
        Some((ray, contribution * weight, medium.filter(|_| is_followed)))
    }

    /// MIS weight of emission that BSDF sampling has found at `distance` (m) from the last vertex.
    #[inline]
    fn emission_weight(&self, scene: &Scene, point: &SurfacePoint, wo: Vec3, distance: f32) -> f32 {
        let Some(light) = scene.light_of(point) else { return 1.0 };
        let emission_density = || scene.emission_density(light, point.time);
        let Some((pdf, ctx)) = self.last_bsdf else { return self.mis_ratio.mis_weight_bsdf(emission_density, 0.0) };
        let cos = wo.dot(point.geometric_normal);
        let light_pdf = scene.lights().area_light_pdf(light, &ctx, scene.geometry(), point.time, distance, cos);
        pdf.power_heuristic(light_pdf) * self.mis_ratio.mis_weight_bsdf(emission_density, light_pdf.0 / pdf.0)
    }
}
