//! All lights of a scene: their tables, and directions to them with their densities.

use glam::Vec3;

use super::bounds::LightBounds;
use super::choice::Choice;
use super::delta_light::DeltaLight;
use super::emissive_triangle::EmissiveTriangle;
use super::emitters::Emitters;
use super::environment::Environment;
use super::light_sample_context::LightSampleContext;
use super::sample::{LiContext, LiSample, LightSample};
use super::selection::Selection;
use super::triangle_light::TriangleLight;
use crate::geometry::{Facet, Geometry, Motion, Transform};
use photosite_core::math::{Area, Pdf, SolidAngle};
use photosite_core::spectrum::SampledSpectrum;

/// One light.
#[derive(Clone, Debug)]
pub enum Light {
    /// A light without a surface.
    Delta(Box<DeltaLight>),
    /// A triangle that emits.
    Triangle(TriangleLight),
    /// The environment, of which there is at most one.
    Environment,
}

impl Light {
    /// Whether it is infinitely far.
    fn is_distant(&self) -> bool {
        match self {
            Self::Delta(light) => light.extent().is_none(),
            Self::Triangle(_) => false,
            Self::Environment => true,
        }
    }

    /// Its bounds, where it is somewhere and has any power.
    pub(super) fn bounds(&self, motion: Option<&Motion>, power: f64, geometry: &Geometry) -> Option<LightBounds> {
        if power.is_nan() || power <= 0.0 {
            return None;
        }
        match self {
            Self::Delta(light) => LightBounds::of_delta_light(light, motion, power),
            Self::Triangle(light) => Some(LightBounds::of_triangle(light, power, geometry)),
            Self::Environment => None,
        }
    }
}

/// Lights with the tables to choose among them.
#[derive(Clone, Debug)]
pub struct Lights {
    pub(super) lights: Vec<Light>,
    /// Triangles of the lights that keep their shape.
    static_triangles: Vec<Option<EmissiveTriangle>>,
    /// Motions of the lights that move, in order of their handles. Such lights are described in their own space.
    motions: Vec<(u32, Motion)>,
    environment: Option<Environment>,
    /// Index of the environment among the lights infinitely far.
    environment_index: Option<u32>,
    selection: Selection,
    pub(super) emitters: Emitters,
}

impl Lights {
    /// `powers[i]` is the power of `lights[i]` as the sensor sees it, in relative units, for lights infinitely far that
    /// through a disk of `disk_m2`; `motions[i]` is its way through the world, rigid, where it has a space of its own.
    /// An [`Environment`] comes with one [`Light::Environment`].
    pub fn new(
        lights: Vec<Light>,
        motions: Vec<Option<Motion>>,
        powers: &[f64],
        disk_m2: f64,
        geometry: &Geometry,
        environment: Option<Environment>,
    ) -> Self {
        let bounds: Vec<_> = (lights.iter().zip(&motions).zip(powers))
            .map(|((light, motion), power)| light.bounds(motion.as_ref(), *power, geometry))
            .collect();
        // BSDF sampling finds the rest of the environment.
        let sampled_part = |light: &Light| match (light, &environment) {
            (Light::Environment, Some(environment)) => environment.excess(),
            _ => 1.0,
        };
        let distant: Vec<(u32, f64)> = ((0..).zip(lights.iter().zip(powers)))
            .filter(|(_, (light, _))| light.is_distant())
            .map(|(i, (light, power))| (i, power / disk_m2 * sampled_part(light)))
            .filter(|(_, irradiance)| *irradiance > 0.0)
            .collect();
        let emitted: Vec<f64> = (lights.iter().zip(powers))
            .map(|(light, &power)| if matches!(light, Light::Triangle(_)) { power } else { 0.0 })
            .collect();
        let is_environment = |(light, _): &(u32, f64)| matches!(lights[*light as usize], Light::Environment);
        Self {
            environment_index: distant.iter().position(is_environment).map(|i| i as u32),
            selection: Selection::new(&bounds, &distant),
            emitters: Emitters::new(&emitted),
            motions: (0..).zip(motions).filter_map(|(light, motion)| Some((light, motion?))).collect(),
            static_triangles: lights.iter().map(|light| static_triangle(light, geometry)).collect(),
            lights,
            environment,
        }
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether all is dark.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// The environment.
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_ref()
    }

    /// Chooses a light for a context. `None` where the lights of the branch of the tree that it descended to cannot
    /// reach the point. The remainder of the random number is in [0, 1) again, so that lights and the points on each
    /// are stratified together.
    #[inline]
    pub(crate) fn choose(&self, ctx: &LightSampleContext, u_light: f32) -> Option<Choice> {
        self.selection.sample(ctx, u_light)
    }

    /// Samples a direction to the light that was chosen. `li.point` is in the world, and `emitted_at(light,
    /// barycentric)` is the radiance of a point of a triangle. `None` where the light cannot reach the point.
    #[inline]
    pub(crate) fn sample_chosen(
        &self,
        choice: &Choice,
        v: f32,
        li: &LiContext<'_>,
        emitted_at: impl FnOnce(&TriangleLight, [f32; 2]) -> SampledSpectrum,
    ) -> Option<LightSample> {
        let &Choice { light, probability, rest } = choice;
        let u = [rest, v];

        // Sample in the light's own space, if it moves
        let transform = self.transform_at(light, li.time);
        let point = transform.map_or(li.point, |transform| transform.to_object.transform_point3(li.point));
        let li = &LiContext { point, ..*li };
        let LiSample { radiance, wi, position, pdf, is_delta } = match &self.lights[light as usize] {
            Light::Delta(light) => light.sample_li(u, li),
            Light::Triangle(emitter) => {
                let triangle = self.triangle(light, emitter, li.geometry, li.time)?;
                emitter.sample_li(&triangle, u, li, emitted_at)
            }
            Light::Environment => self.environment.as_ref()?.sample_li(u, li),
        }?;

        // Transform the sample into the world, and account for the choice of the light
        let sample = LightSample { light, radiance, wi, position, pdf: pdf.times(probability), is_delta };
        let Some(Transform { to_world, .. }) = transform else { return Some(sample) };
        let in_world = |(position, normal)| (to_world.transform_point3(position), to_world.transform_vector3(normal));
        Some(LightSample {
            wi: to_world.transform_vector3(sample.wi).normalize(),
            position: sample.position.map(in_world),
            ..sample
        })
    }

    /// The triangle of a light, [`Facet::NO_TRIANGLE`] where it is none.
    #[inline]
    pub(crate) fn triangle_of(&self, light: u32) -> u32 {
        match &self.lights[light as usize] {
            Light::Triangle(emitter) => emitter.triangle,
            Light::Delta(_) | Light::Environment => Facet::NO_TRIANGLE,
        }
    }

    /// A light that is a triangle at rest.
    #[inline]
    pub(crate) fn static_triangle_light(&self, light: u32) -> Option<(&TriangleLight, &EmissiveTriangle)> {
        let Light::Triangle(emitter) = &self.lights[light as usize] else { return None };
        let triangle = self.static_triangles[light as usize].as_ref()?;
        self.motions.is_empty().then_some((emitter, triangle))
    }

    /// The triangle of a light at a time, in its own space; `None` where it has no area.
    #[inline]
    pub(super) fn triangle(
        &self,
        light: u32,
        emitter: &TriangleLight,
        geometry: &Geometry,
        time: f32,
    ) -> Option<EmissiveTriangle> {
        let still = &self.static_triangles[light as usize];
        still.or_else(|| EmissiveTriangle::new(geometry.corners_at(emitter.triangle, time)))
    }

    /// Transform of a light's own space at a time, if it moves.
    #[inline]
    fn transform_at(&self, light: u32, time: f32) -> Option<Transform> {
        let found = self.motions.binary_search_by_key(&light, |(light, _)| *light).ok()?;
        Some(self.motions[found].1.at(time))
    }

    /// Density with which [`Scene::sample_light`](crate::scene::Scene::sample_light) samples the point of a triangle
    /// light that a ray of unit direction met at `distance` and at that time; `cos` is the cosine at the light, of
    /// either sign.
    #[inline]
    pub fn triangle_pdf(
        &self,
        light: u32,
        ctx: &LightSampleContext,
        geometry: &Geometry,
        time: f32,
        distance: f32,
        cos: f32,
    ) -> Pdf<SolidAngle> {
        match &self.lights[light as usize] {
            Light::Triangle(emitter) => match self.triangle(light, emitter, geometry, time) {
                Some(triangle) => Pdf::<Area>::new(2.0 / triangle.double_area)
                    .to_solid_angle(distance * distance, cos.abs())
                    .times(self.selection.probability(ctx, light)),
                None => Pdf::new(0.0),
            },
            Light::Delta(_) | Light::Environment => Pdf::new(0.0),
        }
    }

    /// Density with which [`Scene::sample_light`](crate::scene::Scene::sample_light) samples the environment in the
    /// unit direction `towards`.
    #[inline]
    pub fn environment_pdf(&self, ctx: &LightSampleContext, towards: Vec3) -> Pdf<SolidAngle> {
        match (&self.environment, self.environment_index) {
            (Some(environment), Some(number)) => {
                environment.pdf(towards).times(self.selection.probability_of_distant(ctx, number))
            }
            (None, _) | (Some(_), None) => Pdf::new(0.0),
        }
    }
}

/// The triangle of a light whose mesh keeps its shape.
fn static_triangle(light: &Light, geometry: &Geometry) -> Option<EmissiveTriangle> {
    let &Light::Triangle(TriangleLight { triangle, .. }) = light else { return None };
    let mut shapes = geometry.shapes(triangle);
    shapes.next().filter(|_| shapes.next().is_none()).and_then(EmissiveTriangle::new)
}
