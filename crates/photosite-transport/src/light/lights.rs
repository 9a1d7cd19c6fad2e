//! All lights of a scene: their tables, and directions to them with their densities.

use std::sync::Arc;

use glam::{Quat, Vec3};

use super::bounds::LightBounds;
use super::emitters::Emitters;
use super::facet::Facet;
use super::selection::{Choice, Selection};
use super::{Environment, Profile, Projector, Receiver, SurfaceEmission};
use crate::geometry::{Geometry, Motion, Transform};
use photosite_core::math::{Area, Pdf, SolidAngle, warp};
use photosite_core::spectrum::{SampledSpectrum, SpectrumId, SpectrumTable, Wavelengths};

/// One light.
#[derive(Clone, Copy, Debug)]
pub enum Light {
    /// The same intensity in all directions.
    Point {
        /// Metres.
        position: Vec3,
        /// W·sr⁻¹·nm⁻¹.
        intensity: SpectrumId,
    },
    /// Intensity within a cone, with the falloff of KHR_lights_punctual.
    Spot {
        /// Metres.
        position: Vec3,
        /// Unit vector along the middle of the cone.
        axis: Vec3,
        /// Cosine of the half-angle of full intensity.
        cos_inner: f32,
        /// Cosine of the half-angle beyond which there is none.
        cos_outer: f32,
        /// W·sr⁻¹·nm⁻¹ on the axis.
        intensity: SpectrumId,
    },
    /// Parallel light.
    Directional {
        /// Unit vector to where it comes from.
        towards: Vec3,
        /// On a plane across the direction, W·m⁻²·nm⁻¹.
        irradiance: SpectrumId,
    },
    /// Intensity by a measured profile.
    Profile {
        /// Metres.
        position: Vec3,
        /// World → lamp, which shines along −z.
        to_lamp: Quat,
        /// Handle in [`Lamps::profiles`].
        profile: u32,
        /// W·sr⁻¹·nm⁻¹ for each candela of the profile.
        per_candela: SpectrumId,
    },
    /// A slide thrown through a lens.
    Projector {
        /// Metres.
        position: Vec3,
        /// World → projector, which shines along −z.
        to_lamp: Quat,
        /// Handle in [`Lamps::projectors`].
        projector: u32,
        /// Spectral flux of a white slide, W·nm⁻¹.
        flux: SpectrumId,
    },
    /// A triangle that emits.
    Triangle(TriangleLight),
    /// The environment, of which there is at most one.
    Environment,
}

/// What lamps are that do not shine by a formula.
#[derive(Clone, Debug, Default)]
pub struct Lamps {
    /// Of [`Light::Profile`].
    pub profiles: Vec<Arc<Profile>>,
    /// Of [`Light::Projector`].
    pub projectors: Vec<Projector>,
}

/// A triangle that emits.
#[derive(Clone, Copy, Debug)]
pub struct TriangleLight {
    /// Handle of the triangle.
    pub triangle: u32,
    /// Its emission.
    pub emission: SurfaceEmission,
}

/// A direction in which a point looks for light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Handle of the light.
    pub light: u32,
    /// Radiance from there, or for lights without extent, irradiance across the direction (pdf 1).
    pub radiance: SampledSpectrum,
    /// Unit vector to the light.
    pub wi: Vec3,
    /// Where on the light, with its normal; `None` where it is infinitely far.
    pub position: Option<(Vec3, Vec3)>,
    /// Density of the choice, that of the light included.
    pub pdf: Pdf<SolidAngle>,
    /// Whether no BSDF sample could have found it.
    pub is_delta: bool,
}

/// Lights with the tables to choose among them.
#[derive(Clone, Debug)]
pub struct Lights {
    pub(super) lights: Vec<Light>,
    /// The triangles of those that stay as they are.
    facets: Vec<Option<Facet>>,
    /// The ways of the lights that move, in order of their handles. They are described in their own space.
    motions: Vec<(u32, Motion)>,
    lamps: Lamps,
    environment: Option<Environment>,
    /// Number of the environment among the lights infinitely far.
    environment_number: Option<u32>,
    selection: Selection,
    pub(super) emitters: Emitters,
}

impl Lights {
    /// `powers[i]` is the power of `lights[i]` as the sensor sees it, in relative units, for lights infinitely far that
    /// through a disk of `disk_m2`; `motions[i]` is its way through the world, rigid, where it has a space of its own. An
    /// [`Environment`] comes with one [`Light::Environment`].
    pub fn new(
        lights: Vec<Light>,
        motions: Vec<Option<Motion>>,
        powers: &[f64],
        disk_m2: f64,
        geometry: &Geometry,
        lamps: Lamps,
        environment: Option<Environment>,
    ) -> Self {
        let bounds: Vec<_> = (lights.iter().zip(&motions).zip(powers))
            .map(|((light, motion), power)| LightBounds::of(light, motion.as_ref(), *power, geometry, &lamps))
            .collect();
        let is_distant = |light: &Light| matches!(light, Light::Directional { .. } | Light::Environment);
        // Scattered rays find the rest of the environment.
        let part_looked_at = |light: &Light| match (light, &environment) {
            (Light::Environment, Some(environment)) => environment.excess(),
            _ => 1.0,
        };
        let distant: Vec<(u32, f64)> = ((0..).zip(lights.iter().zip(powers)))
            .filter(|(_, (light, _))| is_distant(light))
            .map(|(i, (light, power))| (i, power / disk_m2 * part_looked_at(light)))
            .filter(|(_, irradiance)| *irradiance > 0.0)
            .collect();
        let is_environment = |(light, _): &(u32, f64)| matches!(lights[*light as usize], Light::Environment);
        Self {
            environment_number: distant.iter().position(is_environment).map(|i| i as u32),
            selection: Selection::new(&bounds, &distant),
            emitters: Emitters::new(&lights, powers),
            motions: (0..).zip(motions).filter_map(|(light, motion)| Some((light, motion?))).collect(),
            facets: lights.iter().map(|light| still_facet(light, geometry)).collect(),
            lights,
            lamps,
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

    /// The light at which a receiver looks. `None` where the lights that it came to cannot reach it. What the choice leaves of the
    /// number is one in [0, 1) again, so that lights are chosen, and the points on each spread, as evenly as pairs of numbers
    /// are.
    #[inline]
    pub(crate) fn choose(&self, receiver: &Receiver, u_light: f32) -> Option<Choice> {
        self.selection.sample(receiver, u_light)
    }

    /// A direction from a receiver towards the light that was chosen, at a time from 0 to 1. `emitted_at(light, barycentric)` is
    /// the radiance of a point of a triangle. `None` where the light cannot reach the receiver.
    #[inline]
    #[allow(clippy::too_many_arguments, reason = "tables, receiver and random numbers, each once")]
    pub(crate) fn sample_chosen(
        &self,
        &Choice { light: index, probability, rest }: &Choice,
        spectra: &SpectrumTable,
        geometry: &Geometry,
        emitted_at: impl FnOnce(&TriangleLight, [f32; 2]) -> SampledSpectrum,
        receiver: &Receiver,
        time: f32,
        v: f32,
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        let u = [rest, v];
        let place = self.place_of(index, time);
        let local = place.map_or(receiver.point, |place| place.to_group.transform_point3(receiver.point));
        let light = &self.lights[index as usize];
        let choice = (index, light, probability);
        let sample = self.sample_one(choice, spectra, geometry, emitted_at, local, time, u, wavelengths)?;
        let Some(Transform { to_world, .. }) = place else { return Some(sample) };
        let in_world = |(position, normal)| (to_world.transform_point3(position), to_world.transform_vector3(normal));
        Some(LightSample {
            wi: to_world.transform_vector3(sample.wi).normalize(),
            position: sample.position.map(in_world),
            ..sample
        })
    }

    /// A light that is a triangle, and stays as and where it is.
    #[inline]
    pub(crate) fn still_triangle(&self, light: u32) -> Option<(&TriangleLight, &Facet)> {
        let Light::Triangle(emitter) = &self.lights[light as usize] else { return None };
        let facet = self.facets[light as usize].as_ref()?;
        self.motions.is_empty().then_some((emitter, facet))
    }

    /// The triangle of a light at a time, in its own space; `None` where it has no area.
    #[inline]
    pub(super) fn facet(&self, light: u32, emitter: &TriangleLight, geometry: &Geometry, time: f32) -> Option<Facet> {
        let still = &self.facets[light as usize];
        still.or_else(|| Facet::new(geometry.corners_at(emitter.triangle, time)))
    }

    /// Where a light's own space is at a time, if it moves.
    #[inline]
    fn place_of(&self, light: u32, time: f32) -> Option<Transform> {
        let found = self.motions.binary_search_by_key(&light, |(light, _)| *light).ok()?;
        Some(self.motions[found].1.at(time))
    }

    /// The same for a light that was chosen with that probability, in its own space.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "tables, point and random numbers, each once")]
    fn sample_one(
        &self,
        (index, light, probability): (u32, &Light, f32),
        spectra: &SpectrumTable,
        geometry: &Geometry,
        emitted_at: impl FnOnce(&TriangleLight, [f32; 2]) -> SampledSpectrum,
        point: Vec3,
        time: f32,
        u: [f32; 2],
        wavelengths: &Wavelengths,
    ) -> Option<LightSample> {
        let from_point = |position: Vec3, intensity: SampledSpectrum| {
            let to_light = position - point;
            let distance_squared = to_light.length_squared();
            (distance_squared > 0.0).then(|| LightSample {
                light: index,
                radiance: intensity / distance_squared,
                wi: to_light / distance_squared.sqrt(),
                position: Some((position, Vec3::ZERO)),
                pdf: Pdf::new(probability),
                is_delta: true,
            })
        };
        match light {
            Light::Point { position, intensity } => from_point(*position, spectra.sample(*intensity, wavelengths)),
            Light::Spot { position, axis, cos_inner, cos_outer, intensity } => {
                let cos = (point - *position).normalize_or_zero().dot(*axis);
                let falloff = spot_falloff(cos, *cos_inner, *cos_outer);
                if falloff == 0.0 {
                    return None;
                }
                from_point(*position, spectra.sample(*intensity, wavelengths) * falloff)
            }
            Light::Profile { position, to_lamp, profile, per_candela } => {
                let direction = *to_lamp * (point - *position).normalize_or_zero();
                let candela = self.lamps.profiles[*profile as usize].intensity(direction);
                if candela == 0.0 {
                    return None;
                }
                from_point(*position, spectra.sample(*per_candela, wavelengths) * candela)
            }
            Light::Projector { position, to_lamp, projector, flux } => {
                let projector = &self.lamps.projectors[*projector as usize];
                let opening = projector.opening(u);
                let from = *position + to_lamp.inverse() * opening;
                let direction = *to_lamp * (point - from).normalize_or_zero();
                let intensity = projector.intensity(opening, direction, wavelengths);
                if intensity.is_black() {
                    return None;
                }
                from_point(from, spectra.sample(*flux, wavelengths) * intensity)
            }
            Light::Directional { towards, irradiance } => Some(LightSample {
                light: index,
                radiance: spectra.sample(*irradiance, wavelengths),
                wi: *towards,
                position: None,
                pdf: Pdf::new(probability),
                is_delta: true,
            }),
            Light::Triangle(light) => {
                let facet = self.facet(index, light, geometry, time)?;
                let barycentric = warp::uniform_triangle(u);
                let sight = facet.sight(barycentric, point.into());
                if !(sight.cos > 0.0 || light.emission.two_sided && sight.cos < 0.0) {
                    return None;
                }
                Some(LightSample {
                    light: index,
                    radiance: emitted_at(light, barycentric),
                    wi: sight.wi.into(),
                    position: Some((sight.position.into(), facet.normal())),
                    pdf: Pdf::new(sight.density).times(probability),
                    is_delta: false,
                })
            }
            Light::Environment => {
                let environment = self.environment.as_ref()?;
                let (wi, pdf) = environment.sample(u)?;
                Some(LightSample {
                    light: index,
                    radiance: environment.radiance(spectra, wi, wavelengths),
                    wi,
                    position: None,
                    pdf: pdf.times(probability),
                    is_delta: false,
                })
            }
        }
    }

    /// Density with which [`Scene::sample_light`](crate::scene::Scene::sample_light) finds, for a receiver, the point of a triangle
    /// light that a ray of unit direction met at `distance` and at that time, `cos` being the cosine at the light, of either
    /// sign.
    #[inline]
    pub fn triangle_pdf(
        &self,
        light: u32,
        receiver: &Receiver,
        geometry: &Geometry,
        time: f32,
        distance: f32,
        cos: f32,
    ) -> Pdf<SolidAngle> {
        match &self.lights[light as usize] {
            Light::Triangle(emitter) => match self.facet(light, emitter, geometry, time) {
                Some(facet) => Pdf::<Area>::new(2.0 / facet.double_area)
                    .to_solid_angle(distance * distance, cos.abs())
                    .times(self.selection.probability(receiver, light)),
                None => Pdf::new(0.0),
            },
            Light::Point { .. }
            | Light::Spot { .. }
            | Light::Profile { .. }
            | Light::Projector { .. }
            | Light::Directional { .. }
            | Light::Environment => Pdf::new(0.0),
        }
    }

    /// Density with which [`Scene::sample_light`](crate::scene::Scene::sample_light) looks, for a receiver, at the environment in
    /// the unit direction `towards`.
    #[inline]
    pub fn environment_pdf(&self, receiver: &Receiver, towards: Vec3) -> Pdf<SolidAngle> {
        match (&self.environment, self.environment_number) {
            (Some(environment), Some(number)) => {
                environment.pdf(towards).times(self.selection.probability_of_distant(receiver, number))
            }
            (None, _) | (Some(_), None) => Pdf::new(0.0),
        }
    }
}

/// The triangle of a light whose mesh keeps its shape.
fn still_facet(light: &Light, geometry: &Geometry) -> Option<Facet> {
    let Light::Triangle(TriangleLight { triangle, .. }) = *light else { return None };
    let mut shapes = geometry.shapes(triangle);
    shapes.next().filter(|_| shapes.next().is_none()).and_then(Facet::new)
}

/// KHR_lights_punctual's angular attenuation: the square of the clamped ramp between the cosines of both half-angles.
#[inline]
fn spot_falloff(cos: f32, cos_inner: f32, cos_outer: f32) -> f32 {
    let ramp = ((cos - cos_outer) / (cos_inner - cos_outer).max(1e-4)).clamp(0.0, 1.0);
    ramp * ramp
}
