//! Rays that light paths start with, from points on area lights.

use glam::Vec3;

use super::lights::{Light, Lights};
use super::triangle_light::TriangleLight;
use crate::geometry::Geometry;
use photosite_core::math::{Frame, warp};
use photosite_core::spectrum::SampledSpectrum;

/// A ray of light that sets out from a surface.
#[derive(Clone, Copy, Debug)]
pub struct LightRay {
    /// Handle of its light.
    pub light: u32,
    /// Where it starts.
    pub position: Vec3,
    /// Of the surface, unit vector.
    pub normal: Vec3,
    /// Where it goes, unit vector.
    pub direction: Vec3,
    /// W·m⁻²·sr⁻¹·nm⁻¹.
    pub radiance: SampledSpectrum,
    /// Density of its start and direction, over the cosine to the normal, m⁻²·sr⁻¹.
    pub density: f32,
}

/// Density of starts and directions over the cosine, where lights are chosen with that probability: evenly over the
/// triangle, and by Lambert's law.
#[inline]
fn density(probability: f32, double_area: f32, two_sided: bool) -> f32 {
    let sides = if two_sided { 2.0 } else { 1.0 };
    probability * 2.0 * std::f32::consts::FRAC_1_PI / (double_area * sides)
}

impl Lights {
    /// Whether light sets out from any surface.
    pub fn has_emitters(&self) -> bool {
        !self.emitters.is_empty()
    }

    /// Light that sets out from a surface at a time, by five numbers in [0, 1): for the light, the point and the
    /// direction. `emitted_at(light, barycentric)` is the radiance of a point of a triangle. `None` where there is no
    /// light, or none of that triangle.
    pub fn sample_le(
        &self,
        geometry: &Geometry,
        emitted_at: impl FnOnce(&TriangleLight, [f32; 2]) -> SampledSpectrum,
        time: f32,
        (u_light, u_point, u_direction): (f32, [f32; 2], [f32; 2]),
    ) -> Option<LightRay> {
        let (light, probability, rest) = self.emitters.sample(u_light)?;
        let Light::Triangle(emitter) = &self.lights[light as usize] else { return None };
        let triangle = self.triangle(light, emitter, geometry, time)?;
        let barycentric = warp::uniform_triangle(u_point);
        let two_sided = emitter.emission.two_sided;
        let (position, normal) = (triangle.point(barycentric).into(), triangle.normal());
        let side = if two_sided && rest >= 0.5 { -normal } else { normal };
        let direction = Frame::from_normal(side).to_world(warp::cosine_hemisphere(u_direction).into());
        let radiance = emitted_at(emitter, barycentric);
        let density = density(probability, triangle.double_area, two_sided);
        (!radiance.is_black()).then_some(LightRay { light, position, normal, direction, radiance, density })
    }

    /// [`LightRay::density`] of [`Self::sample_le`] on a light at a time; 0 for lights that are no surfaces.
    #[inline]
    pub fn emission_density(&self, light: u32, geometry: &Geometry, time: f32) -> f32 {
        let Light::Triangle(emitter) = &self.lights[light as usize] else { return 0.0 };
        let Some(triangle) = self.triangle(light, emitter, geometry, time) else { return 0.0 };
        density(self.emitters.probability(light), triangle.double_area, emitter.emission.two_sided)
    }
}
