//! Lights of a scene: their tables, and directions to them with their densities.

use glam::Vec3;

use super::area_light::AreaLight;
use super::bounds::LightBounds;
use super::choice::Choice;
use super::delta_light::DeltaLight;
use super::emissive_triangle::EmissiveTriangle;
use super::emitter::{Emitter, EmitterShape};
use super::emitters::Emitters;
use super::environment::Environment;
use super::light_sample_context::LightSampleContext;
use super::sample::{LiContext, LiSample, LightSample};
use super::selection::Selection;
use crate::geometry::{Facet, Geometry, Motion, Transform};
use photosite_core::math::{Pdf, SolidAngle};
use photosite_core::spectrum::SampledSpectrum;

/// Light of a scene.
#[derive(Clone, Debug)]
pub enum Light {
    /// A light without a surface.
    Delta(Box<DeltaLight>),
    /// A primitive that emits.
    Area(AreaLight),
    /// The environment, of which there is at most one.
    Environment,
}

impl Light {
    /// Whether the light is infinitely far.
    fn is_distant(&self) -> bool {
        match self {
            Self::Delta(light) => light.extent().is_none(),
            Self::Area(_) => false,
            Self::Environment => true,
        }
    }

    /// Bounds of the light, unless it is infinitely far or without power.
    pub(super) fn bounds(&self, motion: Option<&Motion>, power: f64, geometry: &Geometry) -> Option<LightBounds> {
        if power.is_nan() || power <= 0.0 {
            return None;
        }
        match self {
            Self::Delta(light) => LightBounds::of_delta_light(light, motion, power),
            Self::Area(light) => Some(LightBounds::of_area_light(light, power, geometry)),
            Self::Environment => None,
        }
    }
}

/// Lights with the tables to choose among them.
#[derive(Clone, Debug)]
pub struct Lights {
    pub(super) lights: Vec<Light>,
    /// Shapes of the lights that keep theirs.
    pub(super) static_shapes: Vec<Option<Emitter>>,
    /// Motions of the lights that move, in order of their handles. Such lights are described in their own space.
    pub(super) motions: Vec<(u32, Motion)>,
    pub(super) environment: Option<Environment>,
    /// Index of the environment among the lights infinitely far.
    pub(super) environment_index: Option<u32>,
    pub(super) selection: Selection,
    pub(super) emitters: Emitters,
}

impl Lights {
    /// Builds the tables of the lights. `powers[i]` is the power of `lights[i]` as the sensor sees it, in relative
    /// units, for lights infinitely far the power through a disk of `disk_m2`; `motions[i]` is its way through the
    /// world, rigid, where it has a space of its own. An [`Environment`] comes with one [`Light::Environment`].
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
            .map(|(light, &power)| if matches!(light, Light::Area(_)) { power } else { 0.0 })
            .collect();
        let is_environment = |(light, _): &(u32, f64)| matches!(lights[*light as usize], Light::Environment);
        Self {
            environment_index: distant.iter().position(is_environment).map(|i| i as u32),
            selection: Selection::new(&bounds, &distant),
            emitters: Emitters::new(&emitted),
            motions: (0..).zip(motions).filter_map(|(light, motion)| Some((light, motion?))).collect(),
            static_shapes: lights.iter().map(|light| static_shape(light, geometry)).collect(),
            lights,
            environment,
        }
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is no light.
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
    /// parameters)` is the radiance of a point of an area light. `None` where the light cannot reach the point.
    #[inline]
    pub(crate) fn sample_chosen(
        &self,
        choice: &Choice,
        v: f32,
        li: &LiContext<'_>,
        emitted_at: impl FnOnce(&AreaLight, [f32; 2]) -> SampledSpectrum,
    ) -> Option<LightSample> {
        let &Choice { light, probability, rest } = choice;
        let u = [rest, v];

        // Sample in the light's own space, if it moves
        let transform = self.transform_at(light, li.time);
        let point = transform.map_or(li.point, |transform| transform.to_object.transform_point3(li.point));
        let li = &LiContext { point, ..*li };
        let LiSample { radiance, wi, position, pdf, is_delta } = match &self.lights[light as usize] {
            Light::Delta(light) => light.sample_li(u, li),
            Light::Area(area_light) => {
                let shape = self.shape(light, area_light, li.geometry, li.time)?;
                area_light.sample_li(&shape, u, li, emitted_at)
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

    /// Primitive at which shadow rays to a light end ([`Ray::to`](crate::geometry::Ray::to)).
    #[inline]
    pub(crate) fn target_of(&self, light: u32) -> u32 {
        match &self.lights[light as usize] {
            Light::Area(area_light) => area_light.primitive.target(),
            Light::Delta(_) | Light::Environment => Facet::NO_TRIANGLE,
        }
    }

    /// A light that is a triangle at rest.
    #[inline]
    pub(crate) fn static_triangle_light(&self, light: u32) -> Option<(&AreaLight, &EmissiveTriangle)> {
        let Light::Area(area_light) = &self.lights[light as usize] else { return None };
        let Some(Emitter::Triangle(triangle)) = &self.static_shapes[light as usize] else { return None };
        self.motions.is_empty().then_some((area_light, triangle))
    }

    /// The shape of a light at a time; `None` where it has no area.
    #[inline]
    pub(super) fn shape(&self, light: u32, area_light: &AreaLight, geometry: &Geometry, time: f32) -> Option<Emitter> {
        let still = &self.static_shapes[light as usize];
        still.or_else(|| Emitter::at(geometry, area_light.primitive, time))
    }

    /// Way of a light's own space through the world, if it moves.
    #[inline]
    pub(super) fn motion_of(&self, light: u32) -> Option<&Motion> {
        let found = self.motions.binary_search_by_key(&light, |(light, _)| *light).ok()?;
        Some(&self.motions[found].1)
    }

    /// Transform of a light's own space at a time, if it moves.
    #[inline]
    fn transform_at(&self, light: u32, time: f32) -> Option<Transform> {
        Some(self.motion_of(light)?.at(time))
    }

    /// Density with which [`Scene::sample_light`](crate::scene::Scene::sample_light) samples the point of an area
    /// light that a ray of unit direction met at `distance` and at that time; `cos` is the cosine at the light, of
    /// either sign.
    #[inline]
    pub fn area_light_pdf(
        &self,
        light: u32,
        ctx: &LightSampleContext,
        geometry: &Geometry,
        time: f32,
        distance: f32,
        cos: f32,
    ) -> Pdf<SolidAngle> {
        match &self.lights[light as usize] {
            Light::Area(area_light) => match self.shape(light, area_light, geometry, time) {
                Some(shape) => shape.pdf(ctx.point, distance, cos).times(self.selection.probability(ctx, light)),
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

/// The shape of a light that keeps it.
fn static_shape(light: &Light, geometry: &Geometry) -> Option<Emitter> {
    let Light::Area(area_light) = light else { return None };
    Emitter::at_rest(geometry, area_light.primitive)
}
