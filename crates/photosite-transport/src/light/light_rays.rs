//! Rays that light paths start with, from points on area lights.

use glam::Vec3;

use super::area_light::AreaLight;
use super::emitter::{EmitterPoint, EmitterShape};
use super::lights::{Light, Lights};
use crate::geometry::Geometry;
use photosite_core::math::{Frame, warp};
use photosite_core::spectrum::SampledSpectrum;

/// A ray of light that sets out from a surface.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// Handle of the light that the ray leaves.
    pub light: u32,
    /// Start of the ray, m.
    pub position: Vec3,
    /// Bound on the rounding error of the position, per axis, m.
    pub error: Vec3,
    /// Unit normal of the surface that the ray leaves.
    pub normal: Vec3,
    /// Unit direction of the ray.
    pub direction: Vec3,
    /// Radiance, W·m⁻²·sr⁻¹·nm⁻¹.
    pub radiance: SampledSpectrum,
    /// Density of the ray's start and direction, over the cosine to the normal, m⁻²·sr⁻¹.
    pub density: f32,
}

/// Density of starts and directions over the cosine, where lights are chosen with that probability: evenly over the
/// shape, and by Lambert's law.
#[inline]
fn density(probability: f32, area: f32, two_sided: bool) -> f32 {
    let sides = if two_sided { 2.0 } else { 1.0 };
    probability * std::f32::consts::FRAC_1_PI / (area * sides)
}

impl Lights {
    /// Whether any surface emits light.
    pub fn has_emitters(&self) -> bool {
        !self.emitters.is_empty()
    }

    /// Samples a ray that leaves an area light at a time, by five random numbers in [0, 1): for the light, the point
    /// and the direction. `emitted_at(light, parameters)` is the radiance of a point of an area light. `None` where
    /// there is no light, or none from that point.
    pub fn sample_le(
        &self,
        geometry: &Geometry,
        emitted_at: impl FnOnce(&AreaLight, [f32; 2]) -> SampledSpectrum,
        time: f32,
        (u_light, u_point, u_direction): (f32, [f32; 2], [f32; 2]),
    ) -> Option<LightRay> {
        let (light, probability, rest) = self.emitters.sample(u_light)?;
        let Light::Area(area_light) = &self.lights[light as usize] else { return None };
        let shape = self.shape(light, area_light, geometry, time)?;
        let two_sided = area_light.emission.two_sided;
        let EmitterPoint { position, error, normal, parameters } = shape.sample_area(u_point);
        let side = if two_sided && rest >= 0.5 { -normal } else { normal };
        let direction = Frame::from_normal(side).to_world(warp::cosine_hemisphere(u_direction).into());
        let radiance = emitted_at(area_light, parameters);
        let density = density(probability, shape.area(), two_sided);
        (!radiance.is_black()).then_some(LightRay { light, position, error, normal, direction, radiance, density })
    }

    /// Density [`LightRay::density`] of [`Self::sample_le`] on a light at a time; 0 for lights that are no surfaces.
    #[inline]
    pub fn emission_density(&self, light: u32, geometry: &Geometry, time: f32) -> f32 {
        let Light::Area(area_light) = &self.lights[light as usize] else { return 0.0 };
        let Some(shape) = self.shape(light, area_light, geometry, time) else { return 0.0 };
        density(self.emitters.probability(light), shape.area(), area_light.emission.two_sided)
    }
}
