//! What a path does at each surface that it meets: unidirectional path tracing with next-event estimation, multiple importance
//! sampling and Russian roulette.

mod matt;

use glam::Vec3;

pub(super) use self::matt::MattSurfaces;
use super::odds::{Crossing, Odds};
use super::reuse::{FirstSurface, Place, SecondSurface, Side};
use crate::bsdf::{Bsdf, BsdfSample, Diffuse};
use crate::geometry::{Hit, Ray, SurfacePoint, offset, offset_origin};
use crate::light::{Facing, LightSample, Receiver};
use crate::sampler::{SamplePlace, Sampler};
use crate::scene::{Scene, Shading};
use photosite_core::math::float::gamma;
use photosite_core::math::{Pdf, Real, SolidAngle, Vector};
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, Wavelengths};

/// How long paths grow, and how many.
#[derive(Clone, Copy, Debug)]
pub struct PathLimits {
    /// Largest number of segments from the camera.
    pub max_depth: u32,
    /// Number of segments after which roulette may end a path.
    pub roulette_depth: u32,
    /// Number of paths that go on from the first surface that is no mirror, at least 1.
    pub splitting: u32,
}

/// A path that is about to go on along a ray, and the light that it has gathered.
///
/// What arrives against the ray that it began with is, on average, the light at its end:
///
/// L = Σ over vertices of throughput · (emission found by scattering · w_bsdf + emission found by looking at a light ·
/// w_light), with the power heuristic for the weights ([Veach97](photosite_core::references#veach97) §9.2,
/// [pbrt4](photosite_core::references#pbrt4) §14.4).
///
/// What the first rough surface gets from lamps is known well after a few samples, what it gets from other surfaces is not.
/// It is worth a mean of several paths from there, which cost less than as many from the camera
/// ([ArvoKirk90](photosite_core::references#arvokirk90)).
///
/// Volumes that surfaces bound absorb by Beer and Lambert's law along every segment within them. A volume within another
/// replaces it, and what is left on the way out is taken to be air.
#[derive(Clone, Copy)]
pub(super) struct Path {
    /// W·m⁻²·sr⁻¹·nm⁻¹ at each wavelength.
    pub(super) light: SampledSpectrum,
    /// A refraction that disperses leaves only the hero.
    pub(super) wavelengths: Wavelengths,
    /// Where its numbers go on.
    place: SamplePlace,
    /// Number of the path that it has come from as a branch.
    pub(super) origin: Option<u32>,
    /// Segments so far.
    depth: u32,
    throughput: SampledSpectrum,
    /// Density with which the last vertex scattered here; `None` where no light sample could have come here instead.
    scattered: Option<(Pdf<SolidAngle>, Receiver)>,
    /// Product of squared relative indices, which roulette must not take for a loss.
    eta_scale: f32,
    /// What the path is inside of, where that absorbs.
    medium: Option<SpectrumId>,
    /// How likely paths from lamps are to find the same.
    odds: Odds,
    pub(super) sharing: Sharing,
}

/// What a path shares with others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sharing {
    /// Nothing.
    Nothing,
    /// Its second surface, if that is matt; the path is of a group of this number, and has come from a first surface if it has
    /// branched off.
    Group(u32),
    /// What it gathers: it has come to a second surface, and its light is what that sends back.
    Light,
}

/// What paths put off until all have come to their next surface.
#[derive(Default)]
pub(super) struct Postponed {
    /// Rays from surfaces to lights.
    pub(super) shadow_rays: Vec<Ray>,
    /// What arrives from there unless something is in the way: at the path of which number, and how much.
    pub(super) lights: Vec<(u32, SampledSpectrum)>,
    /// Paths that have come from others, which have split, and along which ray each goes on.
    pub(super) branches: Vec<(Path, Ray)>,
    /// Surfaces to be shared.
    pub(super) firsts: Vec<FirstSurface>,
    pub(super) seconds: Vec<SecondSurface>,
    /// What paths have brought until they came to their second surfaces: number of the path that was started, and light.
    pub(super) before: Vec<(u32, SampledSpectrum)>,
}

/// A surface that a path has met.
struct Vertex<'a> {
    /// From the vertex before, m.
    distance: f32,
    point: &'a SurfacePoint,
    shading: &'a Shading,
    /// Back along the path, unit vector in world space.
    wo: Vec3,
    /// The same in the shading frame.
    wo_local: Vec3,
    receiver: Receiver,
}

/// Who looks for light at a surface.
#[inline]
pub(super) fn receiver(point: &SurfacePoint, shading: &Shading) -> Receiver {
    // What only reflects has its shading normal on the side that it is seen from.
    let normal = shading.frame.z;
    let facing = if shading.bsdf.transmits() { Facing::Both(normal) } else { Facing::Front(normal) };
    Receiver { point: point.position, facing }
}

impl<'a> Vertex<'a> {
    #[inline]
    fn new(distance: f32, point: &'a SurfacePoint, shading: &'a Shading, wo: Vec3) -> Self {
        let receiver = receiver(point, shading);
        Self { distance, point, shading, wo, wo_local: shading.frame.to_local(wo), receiver }
    }

    /// What becomes of the odds at this vertex, in the direction `wi`, which was scattered to with a density.
    #[inline]
    fn crossing(&self, wi: Vec3, wi_local: Vec3, pdf_to_lamp: f32) -> Crossing {
        let normal = self.point.geometric_normal;
        Crossing {
            cos_to_camera: self.wo.dot(normal).abs(),
            cos_to_lamp: wi.dot(normal).abs(),
            pdf_to_camera: self.shading.bsdf.reverse_pdf(self.wo_local, wi_local).0,
            pdf_to_lamp,
        }
    }
}

impl Path {
    /// From the camera, with the numbers from a place on, beside paths from lamps of such odds.
    #[inline]
    pub(super) fn new(wavelengths: Wavelengths, place: SamplePlace, odds: Odds, sharing: Sharing) -> Self {
        Self {
            light: SampledSpectrum::ZERO,
            wavelengths,
            place,
            origin: None,
            depth: 0,
            throughput: SampledSpectrum::ONE,
            scattered: None,
            eta_scale: 1.0,
            medium: None,
            odds,
            sharing,
        }
    }

    /// Whether it does nothing at matt surfaces but look at a light and scatter.
    #[inline]
    fn is_plain(&self, limits: &PathLimits) -> bool {
        let goes_alone = !matches!(self.sharing, Sharing::Group(_)) && !self.odds.are_shared();
        let splits = limits.splitting > 1 && self.origin.is_none();
        goes_alone && !splits && self.medium.is_none() && self.depth + 1 < limits.max_depth
    }

    /// Gathers light where a ray has led, and returns the one along which the path with this number goes on. It has none when it
    /// ends, and when it has split.
    #[inline]
    pub(super) fn advance(
        &mut self,
        number: u32,
        (ray, hit): (&Ray, Option<Hit>),
        scene: &Scene,
        limits: &PathLimits,
        sampler: &mut Sampler,
        postponed: &mut Postponed,
    ) -> Option<Ray> {
        self.depth += 1;
        let Some(hit) = hit else {
            match (self.sharing, self.origin) {
                (Sharing::Group(group), Some(origin)) => {
                    self.light = scene.environment_radiance(ray.direction, &self.wavelengths);
                    self.share_light(origin, group, number, Place::Sky(ray.direction), postponed);
                }
                _ => self.escape(scene, ray.direction),
            }
            return None;
        };
        let point = scene.point(&hit, ray.time);
        let wo = -ray.direction;
        // A volume seen from behind has been crossed, whether or not its front was met before.
        self.medium = scene.absorption_behind(&point, wo).or(self.medium);
        if let Some(medium) = self.medium {
            self.throughput *= scene.transmittance(medium, hit.t, &self.wavelengths);
        }
        let emitted = scene.emitted(&point, wo, &self.wavelengths);
        if !emitted.is_black() {
            self.light +=
                self.throughput * emitted * emission_weight(scene, &point, &hit, wo, self.scattered, &self.odds);
        }
        if self.depth == limits.max_depth {
            return None;
        }

        let shading = scene.shading(&point, wo, &self.wavelengths);
        if shading.bsdf.needs_single_wavelength() {
            terminate_secondary(&mut self.wavelengths, &mut self.throughput);
        }
        let vertex = Vertex::new(hit.t, &point, &shading, wo);
        if let Sharing::Group(group) = self.sharing {
            self.share(number, group, &vertex, postponed);
        }
        sampler.resume(self.place);
        if !shading.bsdf.is_delta() {
            if let Some((ray, light)) = self.direct_light(scene, &vertex, sampler) {
                postponed.shadow_rays.push(ray);
                postponed.lights.push((number, self.throughput * light));
            }
            let branches = limits.splitting > 1 || matches!(self.sharing, Sharing::Group(_));
            if branches && self.origin.is_none() {
                self.split(number, scene, &vertex, limits, sampler, postponed);
                return None;
            }
        }
        self.scatter(scene, &vertex, limits, sampler)
    }

    /// Shares the first surface, and the second one.
    // Out of the way of renders in which pixels share nothing.
    #[inline(never)]
    fn share(&mut self, number: u32, group: u32, vertex: &Vertex<'_>, postponed: &mut Postponed) {
        self.sharing = Sharing::Nothing;
        let Bsdf::Diffuse(Diffuse { reflectance }) = vertex.shading.bsdf else { return };
        let Some(side) = Side::new(vertex.point, vertex.shading.frame.z, vertex.wo) else { return };
        if self.medium.is_some() {
            return;
        }
        match (self.depth, self.origin) {
            (1, None) => {
                let throughput = self.throughput * reflectance;
                if throughput.is_black() {
                    return;
                }
                self.sharing = Sharing::Group(group);
                postponed.firsts.push(FirstSurface { path: number, group, side, point: *vertex.point, throughput });
            }
            (2, Some(origin)) => {
                postponed.before.push((origin, self.light));
                self.light = SampledSpectrum::ZERO;
                self.throughput = SampledSpectrum::ONE;
                self.share_light(origin, group, number, Place::Matt(side), postponed);
            }
            _ => {}
        }
    }

    /// Shares what this branch gathers from a place on.
    fn share_light(&mut self, origin: u32, group: u32, branch: u32, place: Place, postponed: &mut Postponed) {
        self.sharing = Sharing::Light;
        postponed.seconds.push(SecondSurface { origin, group, branch, place });
    }

    /// What a branch has gathered, at the wavelengths of the path that it has come from.
    #[inline]
    pub(super) fn arrived_at(&self, origin: &Self) -> SampledSpectrum {
        self.light * self.wavelengths.densities_over(&origin.wavelengths)
    }

    /// Gathers the light of the environment.
    #[inline]
    fn escape(&mut self, scene: &Scene, direction: Vec3) {
        let emitted = scene.environment_radiance(direction, &self.wavelengths);
        if !emitted.is_black() {
            let weight = self.scattered.map_or(1.0, |(pdf, receiver)| {
                pdf.power_heuristic(scene.lights().environment_pdf(&receiver, direction))
            });
            self.light += self.throughput * emitted * weight;
        }
    }

    /// Sends several paths on from a surface, of which some may end there.
    // Out of the way of renders that do not split.
    #[inline(never)]
    fn split(
        &self,
        number: u32,
        scene: &Scene,
        vertex: &Vertex<'_>,
        limits: &PathLimits,
        sampler: &mut Sampler,
        postponed: &mut Postponed,
    ) {
        let place = sampler.place();
        for branch in 0..limits.splitting {
            let own = place.branch(branch, limits.splitting);
            sampler.resume(own);
            let mut path = Self { origin: Some(number), light: SampledSpectrum::ZERO, place: own, ..*self };
            if let Some(ray) = path.scatter(scene, vertex, limits, sampler) {
                postponed.branches.push((path, ray));
            }
        }
    }

    /// The ray along which the path goes on from a surface; `None` where it ends there.
    #[inline]
    fn scatter(
        &mut self,
        scene: &Scene,
        vertex: &Vertex<'_>,
        limits: &PathLimits,
        sampler: &mut Sampler,
    ) -> Option<Ray> {
        let Vertex { point, shading, wo, wo_local, receiver, .. } = vertex;
        let u_lobe = if shading.bsdf.has_lobes() {
            sampler.next_1d()
        } else {
            sampler.skip();
            0.0
        };
        let u = sampler.next_2d();
        let sample = shading.bsdf.sample(*wo_local, u_lobe, u)?;
        let wi = shading.frame.to_world(sample.wi);
        if leaks(point, shading, *wo, wi, sample.is_transmission) {
            return None;
        }
        self.throughput *= sample.throughput();
        if self.throughput.is_black() {
            return None;
        }
        if sample.terminates_secondary {
            terminate_secondary(&mut self.wavelengths, &mut self.throughput);
        }
        if self.odds.are_shared() {
            self.odds = self.odds_after(vertex, wi, &sample);
        }
        self.eta_scale *= sample.eta * sample.eta;
        self.scattered = (!sample.is_delta).then_some((sample.pdf, *receiver));
        if sample.is_transmission {
            self.medium = scene.medium_across(point, wi, self.medium);
        }
        self.survives(limits, sampler).then(|| leave(point, wi))
    }

    /// Whether roulette lets the path go on, with the numbers from where the sampler is.
    #[inline]
    fn survives(&mut self, limits: &PathLimits, sampler: &mut Sampler) -> bool {
        // What is shared has come from its first surface with the density of scattering alone.
        if self.depth >= limits.roulette_depth && !matches!(self.sharing, Sharing::Group(_)) {
            let survival = self.throughput.max() * self.eta_scale;
            if survival < 1.0 {
                if sampler.next_1d() >= survival {
                    return false;
                }
                self.throughput *= 1.0 / survival;
            }
        }
        sampler.leave(&mut self.place);
        true
    }

    /// The odds beyond a surface that has scattered the path.
    // Out of the way of renders without paths from lamps.
    #[inline(never)]
    fn odds_after(&self, vertex: &Vertex<'_>, wi: Vec3, sample: &BsdfSample) -> Odds {
        let is_first = self.depth == 1;
        let crossing = || vertex.crossing(wi, sample.wi, sample.pdf.0);
        // The shading normal is another for light that comes from there.
        if vertex.shading.bsdf.is_edge_on(vertex.wo_local) {
            return Odds::NONE;
        }
        match (sample.is_delta, is_first) {
            (true, true) => Odds::NONE,
            (true, false) => self.odds.after_delta(sample.eta),
            (false, true) => self.odds.after_first(&crossing(), vertex.distance),
            (false, false) => self.odds.after(&crossing(), vertex.shading.bsdf.casts_caustics()),
        }
    }

    /// Light that a surface receives straight from a light and scatters back along the path, unless something is in the way of
    /// the ray.
    #[inline]
    fn direct_light(
        &self,
        scene: &Scene,
        vertex: &Vertex<'_>,
        sampler: &mut Sampler,
    ) -> Option<(Ray, SampledSpectrum)> {
        let Vertex { point, receiver, .. } = vertex;
        let wavelengths = &self.wavelengths;
        let light = scene.sample_light(receiver, point.time, sampler.next_2d(), wavelengths)?;
        self.light_from(scene, vertex, &light)
    }

    /// The same from a light that is looked at.
    #[inline]
    fn light_from(&self, scene: &Scene, vertex: &Vertex<'_>, light: &LightSample) -> Option<(Ray, SampledSpectrum)> {
        let Vertex { point, shading, wo, wo_local, .. } = vertex;
        let wavelengths = &self.wavelengths;
        let wi_local = shading.frame.to_local(light.wi);
        let is_transmission = wi_local.z * wo_local.z < 0.0;
        if light.pdf.0 <= 0.0 || leaks(point, shading, *wo, light.wi, is_transmission) {
            return None;
        }
        let scattering = shading.bsdf.eval(*wo_local, wi_local);
        let cos = wi_local.z.abs();
        let mut contribution = light.radiance * scattering.f * (cos / light.pdf.0);
        let medium = if is_transmission { scene.medium_across(point, light.wi, self.medium) } else { self.medium };
        // Light from outside would have to come through the boundary, where shadow rays end.
        if let (Some(medium), Some((position, _))) = (medium, light.position) {
            contribution *= scene.transmittance(medium, point.position.distance(position), wavelengths);
        }
        if contribution.is_black() {
            return None;
        }
        let mut weight = if light.is_delta { 1.0 } else { light.pdf.power_heuristic(scattering.pdf) };
        let is_shared = self.odds.are_shared() && self.depth > 1 && !light.is_delta;
        if is_shared && shading.bsdf.casts_caustics() && !shading.bsdf.is_edge_on(*wo_local) {
            let crossing = vertex.crossing(light.wi, wi_local, scattering.pdf.0);
            let density = scene.emission_density(light.light, point.time);
            weight *= self.odds.weight_of_looked_at(&crossing, density, light.pdf.0);
        }
        Some((shadow_ray(point, light.wi, light.position), contribution * weight))
    }
}

/// Weight of emission that a scattered ray found.
#[inline]
fn emission_weight(
    scene: &Scene,
    point: &SurfacePoint,
    hit: &Hit,
    wo: Vec3,
    scattered: Option<(Pdf<SolidAngle>, Receiver)>,
    odds: &Odds,
) -> f32 {
    let Some(light) = scene.light_of(point) else { return 1.0 };
    let emission_density = || scene.emission_density(light, point.time);
    match scattered {
        Some((pdf, receiver)) => {
            let cos = wo.dot(point.geometric_normal);
            let lights = scene.lights();
            let looked_at = lights.triangle_pdf(light, &receiver, scene.geometry(), point.time, hit.t, cos);
            pdf.power_heuristic(looked_at) * odds.weight_of_found(emission_density, looked_at.0 / pdf.0)
        }
        None => odds.weight_of_found(emission_density, 0.0),
    }
}

/// Whether light on its way wi → wo would leak through an opaque surface whose shading normal disagrees with it
/// ([Veach97](photosite_core::references#veach97) §5.3). It is dropped. Light that a dielectric reflects or refracts to the wrong
/// side of the surface is not: there it is as much at home, and would be missing.
#[inline]
pub(super) fn leaks(point: &SurfacePoint, shading: &Shading, wo: Vec3, wi: Vec3, is_transmission: bool) -> bool {
    let crosses = wo.dot(point.geometric_normal) * wi.dot(point.geometric_normal) < 0.0;
    crosses != is_transmission && !shading.bsdf.transmits()
}

#[inline]
pub(super) fn terminate_secondary(wavelengths: &mut Wavelengths, throughput: &mut SampledSpectrum) {
    wavelengths.terminate_secondary();
    *throughput = SampledSpectrum::from([throughput[0], 0.0, 0.0, 0.0]);
}

/// The ray that leaves a surface point in the unit direction `wi`.
#[inline]
pub(super) fn leave(point: &SurfacePoint, wi: Vec3) -> Ray {
    Ray::new(offset_origin(point.position, point.error, point.geometric_normal, wi), wi).at_time(point.time)
}

/// The ray from a surface point to a light: up to just before its surface, or without end.
#[inline]
pub(super) fn shadow_ray(point: &SurfacePoint, wi: Vec3, light: Option<(Vec3, Vec3)>) -> Ray {
    let mut ray = leave(point, wi);
    if let Some((position, normal)) = light {
        let target = if normal == Vec3::ZERO {
            position
        } else {
            towards_light(position.into(), normal.into(), wi.into()).into()
        };
        ray.direction = target - ray.origin;
        ray.t_max = 1.0;
    }
    ray
}

/// Where a ray in the unit direction `wi` to a point of a light with this unit normal ends: just before it.
#[inline(always)]
fn towards_light<R: Real>(position: Vector<R>, normal: Vector<R>, wi: Vector<R>) -> Vector<R> {
    // A few roundings lie between the light's corners and its sampled point.
    offset(position, position.abs() * position.x.broadcast(gamma(8)), normal, -wi)
}
