//! Construction of the tables of a [`Scene`] from a description.

use std::sync::{Arc, OnceLock};

use glam::DAffine3;

use super::description::{
    AlphaMode, Colour, Described, EmissionDescription, EnvironmentDescription, ImageLevel, LayeredDescription,
    LightDescription, MaterialDescription, Roughness, SceneDescription, TextureDescription, TexturedColour,
    TexturedFactor,
};
use super::layout::{Earlier, LaidOut, lay_out, moves_from};
use super::{
    Alpha, AnisotropySource, CoatSource, ColourSource, FactorSource, FilmSource, LayeredMaterial, Material, NormalMap,
    Scene, Tabled,
};
use crate::bsdf::{Ggx, Map, MapAll, Mix, Model, RelativeIndex, SceneTraits};
use crate::geometry::{Geometry, MeshRange, Motion, Primitive, PrimitiveRange};
use crate::light::{
    AreaLight, DeltaLight, Emitter, EmitterShape, Environment, EnvironmentImage, Light, LightPose, Lights, Sky,
    SkyLight, SurfaceEmission, Tint,
};
use crate::texture::{Bitmap, Texture};
use photosite_core::spectrum::dispersion::lines;
use photosite_core::spectrum::upsampling::{reflectance_spectrum, rgb_illuminant};
use photosite_core::spectrum::{Dispersion, Spectrum, SpectrumId, SpectrumTable, cie, illuminant};

/// Builds a scene. `importance` says how much each wavelength matters to the sensor (any unit, not negative): lights
/// are chosen by their power weighed with it. Coordinates must lie within 10¹⁸ m of the origin, as those that
/// `photosite::Capture::load` returns do.
pub fn build(description: SceneDescription, importance: &Spectrum) -> Scene {
    build_after(description, importance, None)
}

/// Builds a scene as [`build`] does. Where an earlier scene had the same meshes, and those that stand in the world stand
/// there still, both share geometry and hierarchies: only [movable](super::description::InstanceDescription::is_movable)
/// instances are somewhere else, materials and lights are others.
pub fn build_after(description: SceneDescription, importance: &Spectrum, earlier: Option<&Scene>) -> Scene {
    let objects = objects_of_instances(&description);
    // Those of a scene without surroundings are known of its hierarchy.
    let subject = (!description.surroundings.is_empty()).then(|| description.subject_bounds());
    let SceneDescription { images, materials, meshes, instances, lights, environment, .. } = description;
    let mut builder = Builder {
        images,
        textures: Vec::new(),
        layered: Vec::new(),
        mixes: Vec::new(),
        spectra: SpectrumTable::default(),
        importance,
    };
    let emission = |m: &MaterialDescription| m.emission.as_ref().map(|e| builder.surface_emission(e, m.double_sided));
    let emissions: Vec<Option<Emission>> = materials.iter().map(emission).collect();
    let material =
        |(m, e): (&MaterialDescription, &Option<Emission>)| builder.material(m, e.as_ref().map(|e| e.surface));
    let table: Vec<Material> = materials.iter().zip(&emissions).map(material).collect();

    let earlier = earlier.map(|Scene { geometry, accel, kept, .. }| Earlier { geometry, accel, kept });
    let LaidOut { geometry, accel, instances: instance_table, kept } =
        lay_out(meshes, &instances, |material| emissions[material].is_some(), earlier);
    let bounds = match subject {
        Some(bounds) => bounds,
        None if accel.instances().is_empty() => None,
        None => Some(accel.bounds()).map(|(low, high)| (low.as_dvec3(), high.as_dvec3())),
    };
    // The size weighs light from afar against that of lights in the scene. Without geometry there is none, and any
    // will do.
    let radius = bounds.map_or(1.0, |(low, high)| f64::from((high - low).as_vec3().length()) * 0.5);

    let mut all =
        LightList { lights: Vec::new(), motions: Vec::new(), powers: Vec::new(), spectrum: Spectrum::constant(0.0) };
    for primitive in kept.emitters.iter().flat_map(PrimitiveRange::primitives) {
        let material = geometry.meshes[geometry.mesh_of(primitive) as usize].material;
        if let Some(emission) = &emissions[material as usize] {
            let power = builder.emitted_power(&geometry, primitive, emission);
            let light = Light::Area(AreaLight { primitive, emission: emission.surface });
            all.add(light, None, power, &emission.spectrum, importance);
        }
    }
    for light in &lights {
        builder.light(light, radius, &mut all);
    }
    let environment = environment.map(|e| builder.environment(&e, radius, &mut all));
    let LightList { lights, motions, powers, spectrum } = all;
    let lights = Lights::new(lights, motions, &powers, disk_m2(radius), &geometry, environment);
    let has_panes = {
        let models = table.iter().map(|m| &m.model).chain(builder.mixes.iter().flat_map(|mix| &mix.models));
        let layered = builder.layered.iter().map(|layers| layers as &dyn SceneTraits);
        models.filter_map(Model::scene_traits).chain(layered).any(SceneTraits::may_pass_straight)
    };
    let has_media = table.iter().any(|m| m.absorption.is_some());
    let diffuse =
        |mesh: &MeshRange| table[mesh.material as usize].only_reflectance().filter(|_| !has_media && mesh.is_plain());
    Scene {
        diffuse: geometry.meshes.iter().map(diffuse).collect(),
        geometry,
        accel,
        instances: instance_table,
        objects,
        kept,
        places: OnceLock::new(),
        has_alpha: table.iter().any(|m| !matches!(m.alpha, Alpha::Opaque)),
        has_media,
        has_panes,
        materials: table,
        layered: builder.layered,
        mixes: builder.mixes,
        textures: builder.textures,
        spectra: builder.spectra,
        lights,
        light_spectrum: spectrum,
    }
}

/// Lights as they are gathered, with the weights to choose them by and the sum of their spectra.
struct LightList {
    lights: Vec<Light>,
    motions: Vec<Option<Motion>>,
    powers: Vec<f64>,
    spectrum: Spectrum,
}

impl LightList {
    /// Adds a light. `factor` times the integral of `spectrum` is the light's power, W.
    fn add(&mut self, light: Light, motion: Option<Motion>, factor: f64, spectrum: &Spectrum, importance: &Spectrum) {
        self.lights.push(light);
        self.motions.push(motion);
        self.powers.push(factor * spectrum.product(importance).integral());
        let mut sum = self.spectrum.values().iter();
        self.spectrum = spectrum.map(|_, v| v * factor + f64::from(*sum.next().unwrap_or(&0.0)));
    }
}

/// A surface's emission with the radiance of its white.
struct Emission {
    surface: SurfaceEmission,
    spectrum: Spectrum,
}

struct Builder<'a> {
    images: Vec<Arc<Bitmap>>,
    textures: Vec<Texture>,
    layered: Vec<LayeredMaterial>,
    mixes: Vec<Mix<Tabled>>,
    spectra: SpectrumTable,
    importance: &'a Spectrum,
}

impl Builder<'_> {
    fn texture(&mut self, t: &TextureDescription) -> u32 {
        let image = Arc::clone(&self.images[t.image]);
        self.textures.push(Texture::new(image, t.sampler, t.transform, t.uv_set as u32));
        (self.textures.len() - 1) as u32
    }

    fn optional_texture(&mut self, t: &Option<TextureDescription>) -> Option<u32> {
        t.as_ref().map(|t| self.texture(t))
    }

    fn factor(&mut self, TexturedFactor { value, texture }: &TexturedFactor) -> FactorSource {
        let texture = texture.as_ref().map(|(texture, channel)| (self.texture(texture), *channel as usize));
        FactorSource { value: *value, texture }
    }

    fn normal_map(&mut self, map: &Option<(TextureDescription, f32)>) -> Option<NormalMap> {
        map.as_ref().map(|(t, scale)| NormalMap { texture: self.texture(t), scale: *scale })
    }

    fn layers(&mut self, d: &LayeredDescription) -> LayeredMaterial {
        let n = d.index.index(lines::D);
        // Colours above 1 are taken apart: what is upsampled stays below.
        let (specular_scale, specular_colour) = match &d.specular_colour.colour {
            Colour::Rgb(rgb) => {
                let largest = rgb.iter().copied().fold(1.0, f32::max);
                (largest, Colour::Rgb(rgb.map(|c| c / largest)))
            }
            Colour::Spectrum(spectrum) => (1.0, Colour::Spectrum(spectrum.clone())),
        };
        let is_white = matches!(specular_colour, Colour::Rgb([1.0, 1.0, 1.0])) && d.specular_colour.texture.is_none();
        let specular_colour = TexturedColour { colour: specular_colour, texture: d.specular_colour.texture.clone() };
        LayeredMaterial {
            base_colour: self.colour(&d.base_colour),
            metallic: self.factor(&d.metallic),
            roughness: self.factor(&d.roughness),
            eta: self.spectra.add(&d.index.to_spectrum()),
            dispersive: !d.index.is_constant(),
            f0: d.normal_reflectance.unwrap_or(((n - 1.0) / (n + 1.0)).powi(2) as f32),
            specular: self.factor(&d.specular),
            specular_colour: (!is_white).then(|| self.colour(&specular_colour)),
            specular_scale,
            transmission: self.factor(&d.transmission),
            has_volume: d.absorption_per_m.is_some(),
            diffuse_transmission: d.diffuse_transmission.as_ref().map(|(f, c)| (self.factor(f), self.colour(c))),
            anisotropy: d.anisotropy.as_ref().map(|a| AnisotropySource {
                strength: a.strength,
                rotation: [a.rotation_rad.cos(), a.rotation_rad.sin()],
                texture: self.optional_texture(&a.texture),
            }),
            film: d.film.as_ref().map(|f| FilmSource {
                weight: self.factor(&f.weight),
                index: f.index,
                thickness_nm: f.thickness_nm,
                texture: self.optional_texture(&f.thickness_texture),
            }),
            sheen: d.sheen.as_ref().map(|(c, r)| (self.colour(c), self.factor(r))),
            coat: d.coat.as_ref().map(|c| CoatSource {
                weight: self.factor(&c.weight),
                roughness: self.factor(&c.roughness),
                normal_map: self.normal_map(&c.normal_map),
            }),
        }
    }

    fn material(&mut self, m: &MaterialDescription, emission: Option<SurfaceEmission>) -> Material {
        let model = m.model.map(self);
        // Only glTF's material bounds volumes.
        let layers = if let Model::Layered(layers) = &m.model { Some(layers) } else { None };
        let absorption = layers.and_then(|l| l.absorption_per_m.as_ref()).map(|a| self.spectra.add(a));
        let factor = m.alpha_factor;
        let alpha = match m.alpha {
            AlphaMode::Opaque => Alpha::Opaque,
            AlphaMode::Mask { cutoff } => {
                Alpha::Mask { factor, texture: self.optional_texture(&m.alpha_texture), cutoff }
            }
            AlphaMode::Blend => Alpha::Blend { factor, texture: self.optional_texture(&m.alpha_texture) },
        };
        Material { model, normal_map: self.normal_map(&m.normal_map), emission, alpha, absorption }
    }

    fn surface_emission(&mut self, e: &EmissionDescription, two_sided: bool) -> Emission {
        let (spectrum, tint) = match (&e.texture, &e.colour) {
            (None, _) => (emission_spectrum(&e.colour, e.level), Tint::None),
            (Some(texture), Colour::Rgb(factor)) => {
                let white = emission_spectrum(&Colour::Rgb([1.0; 3]), e.level);
                (white, Tint::Textured { factor: *factor, texture: self.texture(texture) })
            }
            (Some(texture), Colour::Spectrum(_)) => {
                let tint = Tint::Textured { factor: [1.0; 3], texture: self.texture(texture) };
                (emission_spectrum(&e.colour, e.level), tint)
            }
        };
        let surface = SurfaceEmission { radiance: self.spectra.add(&spectrum), tint, two_sided };
        Emission { surface, spectrum }
    }

    /// Factor of the emission's spectrum that gives the power of a primitive: π·area·(mean tint), twice for two sides.
    fn emitted_power(&self, geometry: &Geometry, primitive: Primitive, emission: &Emission) -> f64 {
        let Some(shape) = Emitter::at(geometry, primitive, 0.0) else { return 0.0 };
        let brightness = match emission.surface.tint {
            Tint::None => 1.0,
            Tint::Textured { texture, .. } => {
                // Sixteen points spread over the shape; one that shines between them only is still found by scattered
                // rays.
                let texture = &self.textures[texture as usize];
                let points = (0..16).map(|i| {
                    let u = [(i % 4) as f32 * 0.25 + 0.125, (i / 4) as f32 * 0.25 + 0.125];
                    let at = shape.sample_area(u).parameters;
                    let [r, g, b, _] = texture.sample_rgba_srgb(geometry.uv(primitive, at, texture.uv_set as usize));
                    f64::from(emission.surface.tinted([r, g, b]).iter().sum::<f32>()) / 3.0
                });
                points.sum::<f64>() / 16.0
            }
        };
        let sides = if emission.surface.two_sided { 2.0 } else { 1.0 };
        std::f64::consts::PI * f64::from(shape.area()) * brightness * sides
    }

    fn light(&mut self, light: &LightDescription, scene_radius: f64, list: &mut LightList) {
        let spectrum = emission_spectrum(&light.emission.colour, light.emission.level);
        let id = self.spectra.add(&spectrum);
        let motion = moves_from(&light.to_world, &light.later).map(|poses| Motion::new(&poses));
        // A light that moves is given in its own space.
        let to_world = if motion.is_some() { DAffine3::IDENTITY } else { light.to_world };
        let factor = light.kind.power_factor(disk_m2(scene_radius));
        let light = DeltaLight::new(light.kind.clone(), LightPose::new(&to_world), id);
        list.add(Light::Delta(Box::new(light)), motion, factor, &spectrum, self.importance);
    }

    fn environment(&mut self, e: &EnvironmentDescription, scene_radius: f64, list: &mut LightList) -> Environment {
        let (environment, spectrum, solid_angle) = match e {
            EnvironmentDescription::Constant { colour, luminance_nit } => {
                let spectrum = emission_spectrum(colour, *luminance_nit);
                let environment = Environment::Constant { radiance: self.spectra.add(&spectrum) };
                (environment, spectrum, 4.0 * std::f64::consts::PI)
            }
            EnvironmentDescription::Image { image, level, rotation_deg } => {
                let (sphere, _) = EnvironmentImage::luminous_integrals(image);
                let spectrum = emission_spectrum(&Colour::Rgb([1.0; 3]), Some(nit_per_unit(image, *level)));
                let radiance = self.spectra.add(&spectrum);
                let image = EnvironmentImage::new(Arc::clone(image), radiance, *rotation_deg);
                (Environment::Image(image), spectrum, sphere)
            }
            EnvironmentDescription::Sky(conditions) => {
                // Its spectrum is that of the light from all directions together.
                let (sky, SkyLight { all, .. }) = Sky::new(conditions, &mut self.spectra);
                (Environment::Sky(Box::new(sky)), all, 1.0)
            }
        };
        list.add(Light::Environment, None, disk_m2(scene_radius) * solid_angle, &spectrum, self.importance);
        environment
    }
}

impl Map<Described, Tabled> for Builder<'_> {
    fn colour(&mut self, TexturedColour { colour, texture }: &TexturedColour) -> ColourSource {
        match (colour, self.optional_texture(texture)) {
            (Colour::Rgb(rgb), None) => ColourSource::Spectrum(self.spectra.add(&reflectance_spectrum(*rgb))),
            (Colour::Rgb(factor), Some(texture)) => ColourSource::Texture { factor: *factor, texture },
            (Colour::Spectrum(spectrum), None) => ColourSource::Spectrum(self.spectra.add(spectrum)),
            (Colour::Spectrum(spectrum), Some(texture)) => {
                ColourSource::SpectrumTexture { spectrum: self.spectra.add(spectrum), texture }
            }
        }
    }

    fn spectrum(&mut self, spectrum: &Spectrum) -> SpectrumId {
        self.spectra.add(spectrum)
    }

    fn index(&mut self, index: &Dispersion) -> RelativeIndex<SpectrumId> {
        let (dispersive, is_one) = (!index.is_constant(), index.is_one());
        RelativeIndex { eta: self.spectra.add(&index.to_spectrum()), dispersive, is_one }
    }

    fn distribution(&mut self, roughness: &Roughness) -> Ggx {
        roughness.distribution()
    }
}

impl MapAll<Described, Tabled> for Builder<'_> {
    fn layered(&mut self, layers: &Box<LayeredDescription>) -> u32 {
        let layers = self.layers(layers);
        self.layered.push(layers);
        (self.layered.len() - 1) as u32
    }

    fn mix(&mut self, mix: &Box<Mix<Described>>) -> u32 {
        let mix = Mix { models: mix.models.each_ref().map(|model| model.map(self)), weight: mix.weight };
        self.mixes.push(mix);
        (self.mixes.len() - 1) as u32
    }
}

/// Index of the object of each instance.
fn objects_of_instances(description: &SceneDescription) -> Vec<u32> {
    let objects = description.all_objects();
    let mut of_instances = Vec::with_capacity(description.instances.len());
    for (index, object) in (0..).zip(&objects) {
        of_instances.extend(object.instances.clone().map(|_| index));
    }
    of_instances
}

/// Area of the disk through which a scene of that radius is lit from afar.
fn disk_m2(radius: f64) -> f64 {
    std::f64::consts::PI * radius * radius
}

/// Luminance of a white texel of value 1 of an environment image, nit.
pub fn nit_per_unit(image: &Arc<Bitmap>, level: ImageLevel) -> f64 {
    match level {
        ImageLevel::NitPerUnit(nit) => nit,
        ImageLevel::HorizontalLux(lux) => {
            let (_, horizontal) = EnvironmentImage::luminous_integrals(image);
            if horizontal > 0.0 { lux / horizontal } else { 0.0 }
        }
    }
}

/// The absolute spectrum of an emission: D65 times the colour, or the given shape, scaled to the photometric level.
pub fn emission_spectrum(colour: &Colour, level: Option<f64>) -> Spectrum {
    match colour {
        Colour::Rgb(rgb) => {
            let white = cie::luminous(illuminant::d65());
            rgb_illuminant(*rgb).scale(level.unwrap_or(1.0) / white)
        }
        Colour::Spectrum(spectrum) => match level {
            None => spectrum.clone(),
            Some(level) => {
                let luminous = cie::luminous(spectrum);
                // Light that the eye does not see cannot be scaled to a luminance.
                spectrum.scale(if luminous > 0.0 { level / luminous } else { 0.0 })
            }
        },
    }
}
