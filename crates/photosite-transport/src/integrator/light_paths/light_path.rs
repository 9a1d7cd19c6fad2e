//! A path from a light: what it carries, how it goes on, and what it sends to the lens.

use glam::Vec3;

use crate::geometry::{Ray, SurfacePoint};
use crate::integrator::interaction::{leaks, light_sample_context, shadow_ray, terminate_secondary};
use crate::integrator::job::RenderJob;
use crate::integrator::mis_ratio::{PathVertex, delta_term, light_weight};
use crate::integrator::path::PathLimits;
use crate::light::LightRay;
use crate::sampler::{SamplePosition, Sampler};
use crate::scene::{Scene, Shading};
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, SpectrumTable, Wavelengths};

/// Data that light paths need to go on.
pub(super) struct LightTracing<'a> {
    pub(super) job: &'a RenderJob<'a>,
    pub(super) limits: PathLimits,
    pub(super) spectra: SpectrumTable,
    /// Transmittance of the lens.
    pub(super) transmittance: SpectrumId,
    /// Paths for each sample of all pixels.
    pub(super) paths: u32,
}

/// A path that is about to go on along a ray.
#[derive(Clone, Copy)]
pub(super) struct LightPath {
    /// Number of the sample that it belongs to.
    pub(super) sample: u32,
    /// Position in its random numbers.
    pub(super) position: SamplePosition,
    pub(super) wavelengths: Wavelengths,
    pub(super) emission: LightRay,
    /// Power β, W·nm⁻¹ at each wavelength.
    pub(super) power: SampledSpectrum,
    /// MIS ratio q of [`super::mis_ratio`] so far, without the factor of the surface that the camera sees.
    pub(super) mis_ratio: f32,
    /// Segments so far.
    pub(super) depth: u32,
    /// Whether the first surface casts caustics, as it may until the path has come to it.
    pub(super) is_caustic: bool,
    /// The absorbing medium that the path is in.
    pub(super) medium: Option<SpectrumId>,
    /// Length of the path since its light, m, until a surface tells which medium that is in.
    pub(super) unresolved_distance_m: Option<f32>,
}

/// A point of the lens, and what light that comes there counts.
pub(super) struct LensPoint {
    pub(super) origin: Vec3,
    /// Weight of the camera's ray that leaves the point, sr.
    pub(super) weight: f32,
    /// Area of the image over that of what it shows on a plane across the ray.
    pub(super) px2_per_m2: f32,
    /// Weights of the wavelengths besides.
    pub(super) weights: SampledSpectrum,
}

/// The cosines of a direction to the geometric and, with its sign, to the shading normal.
#[inline]
fn cosines(point: &SurfacePoint, shading: &Shading, w: Vec3) -> (f32, f32) {
    (w.dot(point.geometric_normal).abs(), w.dot(shading.frame.z))
}

impl LightPath {
    /// Absorbs along the segment to a point. A volume that is seen from within for the first time has been all around
    /// since the light, as it is for paths from the camera, which come into it before they come to the light.
    pub(super) fn absorb(&mut self, scene: &Scene, point: &SurfacePoint, wi: Vec3, distance: f32) {
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

    /// The shadow ray from a vertex to the lens, the irradiance that comes there if nothing occludes it, and its MIS
    /// ratio q.
    pub(super) fn sent(
        &self,
        tracing: &LightTracing<'_>,
        (point, wi): (&SurfacePoint, Vec3),
        lens: &LensPoint,
        wavelengths: &Wavelengths,
    ) -> Option<(Ray, SampledSpectrum, f32)> {
        let scene = tracing.job.scene;
        let to_lens = lens.origin - point.position;
        let distance = to_lens.length();
        let wo = to_lens / distance;
        let shading = scene.shading(point, wo, wavelengths);
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
        let ratio = self.mis_ratio * path_vertex.first_term(distance);
        let weight = light_weight(ratio);
        let of_lens = lens.weight * (lens.px2_per_m2 * cos_to_camera) / tracing.paths as f32;
        let mut irradiance = self.power * scattering.f * (cos_shading.abs() / cos_to_light * of_lens * weight);
        if let Some(medium) = scene.absorption_behind(point, wo) {
            irradiance *= scene.transmittance(medium, distance, wavelengths);
        }
        irradiance *= tracing.spectra.sample(tracing.transmittance, wavelengths) * lens.weights;
        let is_light = irradiance.is_finite() && !irradiance.is_black();
        is_light.then(|| (shadow_ray(point, wo, Some((lens.origin, Vec3::ZERO))), irradiance, ratio))
    }

    /// The ray along which the path goes on from a surface that it has come to from `distance`; `None` where it ends
    /// there.
    pub(super) fn scatter(
        &mut self,
        tracing: &LightTracing<'_>,
        (point, shading, wi): (&SurfacePoint, &Shading, Vec3),
        distance: f32,
        sampler: &mut Sampler,
    ) -> Option<Ray> {
        let scene = tracing.job.scene;
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
        if self.depth >= tracing.limits.roulette_depth {
            let survival = factor.max();
            if survival < 1.0 {
                if sampler.next_1d() >= survival {
                    return None;
                }
                self.power *= 1.0 / survival;
            }
        }
        sampler.save(&mut self.position);
        Some(point.spawn_ray(wo))
    }

    /// Density with which the first surface, at that distance, samples the point that the path starts from.
    fn light_pdf(&self, scene: &Scene, point: &SurfacePoint, shading: &Shading, distance: f32) -> f32 {
        let LightRay { light, normal, direction, .. } = self.emission;
        let ctx = light_sample_context(point, shading);
        let cos = direction.dot(normal);
        scene.lights().area_light_pdf(light, &ctx, scene.geometry(), point.time, distance, cos).0
    }
}
