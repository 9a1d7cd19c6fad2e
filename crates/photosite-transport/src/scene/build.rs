//! From a description to the tables of a [`Scene`].

use std::ops::Range;
use std::sync::Arc;

use glam::{DAffine3, Vec3};

use super::description::{
    AlphaMode, Colour, Described, EmissionDescription, EnvironmentDescription, InstanceDescription, LayeredDescription,
    LightDescription, MaterialDescription, MeshDescription, PictureLevel, Roughness, SceneDescription,
    ShapeDescription, TextureDescription, TexturedColour, TexturedFactor,
};
use super::{
    Alpha, AnisotropySource, CoatSource, ColourSource, FactorSource, FilmSource, InstanceTable, LayeredMaterial,
    Material, NormalMap, Scene, Tabled,
};
use crate::bsdf::{Ggx, Map, MapAll, Mix, Model, RelativeIndex};
use crate::geometry::{
    Accel, Deformation, Geometry, Instance, InstanceTransform, MeshRange, Motion, PlacedQuadric, Primitive,
    PrimitiveRange, Transform, Triangle,
};
use crate::light::{
    DeltaLight, Environment, EnvironmentPicture, Light, LightPose, Lights, Sky, SurfaceEmission, Tint, TriangleLight,
};
use crate::texture::{Bitmap, Texture};
use photosite_core::spectrum::dispersion::lines;
use photosite_core::spectrum::upsampling::{reflectance_spectrum, rgb_illuminant};
use photosite_core::spectrum::{Dispersion, Spectrum, SpectrumId, SpectrumTable, cie, illuminant};

/// Builds a scene. `importance` says how much each wavelength matters to the sensor (any unit, not negative): lights are
/// chosen by their power weighed with it. Coordinates must lie within 10¹⁸ m of the origin, as those that
/// `photosite::Capture::load` returns do.
pub fn build(description: SceneDescription, importance: &Spectrum) -> Scene {
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

    let (geometry, accel, instance_table, emitters) =
        lay_out(meshes, &instances, |material| emissions[material].is_some());
    let (low, high) = accel.bounds();
    // The size weighs light from afar against that of lights in the scene. Without geometry there is none, and any
    // will do.
    let radius = if accel.instances().is_empty() { 1.0 } else { f64::from((high - low).length()) * 0.5 };

    let mut all =
        LightList { lights: Vec::new(), motions: Vec::new(), powers: Vec::new(), spectrum: Spectrum::constant(0.0) };
    for range in emitters {
        let material = geometry.meshes[geometry.triangles[range.start as usize].mesh as usize].material;
        if let Some(emission) = &emissions[material as usize] {
            for triangle in range {
                let power = builder.triangle_power(&geometry, triangle, emission);
                let light = Light::Triangle(TriangleLight { triangle, emission: emission.surface });
                all.add(light, None, power, &emission.spectrum, importance);
            }
        }
    }
    for light in &lights {
        builder.light(light, radius, &mut all);
    }
    let environment = environment.map(|e| builder.environment(&e, radius, &mut all));
    let LightList { lights, motions, powers, spectrum } = all;
    let lights = Lights::new(lights, motions, &powers, disk_m2(radius), &geometry, environment);
    let has_media = table.iter().any(|m| m.absorption.is_some());
    let diffuse =
        |mesh: &MeshRange| table[mesh.material as usize].only_reflectance().filter(|_| !has_media && mesh.is_plain());
    Scene {
        diffuse: geometry.meshes.iter().map(diffuse).collect(),
        geometry,
        accel,
        instances: instance_table,
        has_alpha: table.iter().any(|m| !matches!(m.alpha, Alpha::Opaque)),
        has_media,
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
    /// `factor` times the integral of `spectrum` is the light's power, W.
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

    /// Factor of the emission's spectrum that gives the triangle's power: π·area·(mean tint), twice for two sides.
    fn triangle_power(&self, geometry: &Geometry, triangle: u32, emission: &Emission) -> f64 {
        let [a, b, c] = geometry.corners(triangle);
        let area = 0.5 * f64::from((b - a).cross(c - a).length());
        let brightness = match emission.surface.tint {
            Tint::None => 1.0,
            Tint::Textured { texture, .. } => {
                // Sixteen points spread over the triangle; a triangle that shines between them only is still found by
                // scattered rays.
                let texture = &self.textures[texture as usize];
                let points = (0..16).map(|i| {
                    let u = [(i % 4) as f32 * 0.25 + 0.125, (i / 4) as f32 * 0.25 + 0.125];
                    let barycentric = photosite_core::math::warp::uniform_triangle(u);
                    let [r, g, b, _] = texture.sample_rgba_srgb(geometry.uv(
                        Primitive::Triangle(triangle),
                        barycentric,
                        texture.uv_set as usize,
                    ));
                    f64::from(emission.surface.tinted([r, g, b]).iter().sum::<f32>()) / 3.0
                });
                points.sum::<f64>() / 16.0
            }
        };
        let sides = if emission.surface.two_sided { 2.0 } else { 1.0 };
        std::f64::consts::PI * area * brightness * sides
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
            EnvironmentDescription::Picture { image, level, rotation_deg } => {
                let (sphere, _) = EnvironmentPicture::luminous_integrals(image);
                let spectrum = emission_spectrum(&Colour::Rgb([1.0; 3]), Some(nit_per_unit(image, *level)));
                let radiance = self.spectra.add(&spectrum);
                let picture = EnvironmentPicture::new(Arc::clone(image), radiance, *rotation_deg);
                (Environment::Picture(picture), spectrum, sphere)
            }
            EnvironmentDescription::Sky(conditions) => {
                // Its spectrum is that of the light from all directions together.
                let (sky, spectrum) = Sky::new(conditions, &mut self.spectra);
                (Environment::Sky(Box::new(sky)), spectrum, 1.0)
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
        RelativeIndex { eta: self.spectra.add(&index.to_spectrum()), dispersive: !index.is_constant() }
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

/// Area of the disk through which a scene of that radius is lit from afar.
fn disk_m2(radius: f64) -> f64 {
    std::f64::consts::PI * radius * radius
}

/// Luminance of a white texel of value 1 of an environment picture, nit.
pub fn nit_per_unit(image: &Arc<Bitmap>, level: PictureLevel) -> f64 {
    match level {
        PictureLevel::NitPerUnit(nit) => nit,
        PictureLevel::HorizontalLux(lux) => {
            let (_, horizontal) = EnvironmentPicture::luminous_integrals(image);
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

/// A transform and those that follow, if any differs from it.
fn moves_from(first: &DAffine3, later: &[DAffine3]) -> Option<Vec<DAffine3>> {
    let moves = later.iter().any(|pose| pose != first);
    moves.then(|| [first].into_iter().chain(later).copied().collect())
}

/// Lays meshes out: those placed once, and all emitters, in world space in one hierarchy; the others in hierarchies of their
/// own with an instance for each. What deforms, emitters that move included, has the world space of all times.
/// Returns the triangle ranges of emitters too.
fn lay_out(
    meshes: Vec<MeshDescription>,
    instances: &[InstanceDescription],
    emits: impl Fn(usize) -> bool,
) -> (Geometry, Accel, InstanceTable, Vec<Range<u32>>) {
    let mut uses = vec![0usize; meshes.len()];
    for instance in instances {
        uses[instance.mesh] += 1;
    }
    let layout = |instance: &InstanceDescription| {
        let mesh = &meshes[instance.mesh];
        let moves = moves_from(&instance.to_world, &instance.later).is_some();
        if !mesh.later_shapes.is_empty() || moves && emits(mesh.material) {
            Layout::Deforming
        } else if !moves && (uses[instance.mesh] == 1 || emits(mesh.material)) {
            Layout::World
        } else {
            Layout::Instanced
        }
    };
    let laid_out = |wanted| instances.iter().enumerate().filter(move |(_, instance)| layout(instance) == wanted);
    let mut geometry = Geometry::default();
    let surfaces = vec![[u32::MAX; 2]; instances.len()];
    let mut table = InstanceTable { surfaces, ..InstanceTable::default() };
    let (mut ranges, mut placed) = (Vec::new(), Vec::new());
    let (mut emitters, mut light_count) = (Vec::new(), 0);
    let mut add = |geometry: &mut Geometry, table: &mut InstanceTable, index: usize| {
        let instance = &instances[index];
        table.of_mesh.push(index as u32);
        let mesh = &meshes[instance.mesh];
        let emitting = emits(mesh.material);
        let range = append(geometry, mesh, &instance.to_world, emitting.then_some(light_count));
        if emitting && !range.is_empty() {
            light_count += range.len() as u32;
            emitters.push(range.clone());
        }
        range
    };
    for (index, _) in laid_out(Layout::World) {
        add(&mut geometry, &mut table, index);
        // All of these have the first instance.
        table.surfaces[index] = [geometry.meshes.len() as u32 - 1, 0];
    }
    let in_world =
        PrimitiveRange { triangles: 0..geometry.triangles.len() as u32, quadrics: 0..geometry.quadrics.len() as u32 };
    if in_world != PrimitiveRange::default() {
        ranges.push(in_world);
        placed.push(Instance { blas: 0, transform: InstanceTransform::World });
        table.of_instance.push(None);
    }
    for (index, instance) in laid_out(Layout::Deforming) {
        let range = add(&mut geometry, &mut table, index);
        deform(&mut geometry, &meshes[instance.mesh], instance);
        table.surfaces[index] = [geometry.meshes.len() as u32 - 1, placed.len() as u32];
        placed.push(Instance { blas: ranges.len() as u32, transform: InstanceTransform::World });
        table.of_instance.push(None);
        ranges.push(range.into());
    }
    for (index, mesh) in meshes.iter().enumerate().filter(|&(index, _)| uses[index] > 0) {
        let mut blas = None;
        for (number, i) in laid_out(Layout::Instanced).filter(|(_, i)| i.mesh == index) {
            let blas = *blas.get_or_insert_with(|| {
                ranges.push(append(&mut geometry, mesh, &DAffine3::IDENTITY, None).into());
                (ranges.len() - 1) as u32
            });
            let transform = match moves_from(&i.to_world, &i.later) {
                Some(poses) => InstanceTransform::Moving(Box::new(Motion::new(&poses))),
                None => InstanceTransform::Still(Transform::new(&i.to_world)),
            };
            // No other is added to the geometry until all instances of this mesh are placed.
            table.surfaces[number] = [geometry.meshes.len() as u32 - 1, placed.len() as u32];
            placed.push(Instance { blas, transform });
            table.of_instance.push(Some(number as u32));
        }
    }
    drop(meshes);
    let accel = Accel::build(&geometry, &ranges, placed);
    (geometry, accel, table, emitters)
}

/// Where the triangles of an instance go.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Layout {
    /// Into the world, with others.
    World,
    /// Into the world in several shapes.
    Deforming,
    /// Into their own space, as an instance.
    Instanced,
}

/// Gives the mesh that was added last the shapes that it goes through in the world.
fn deform(geometry: &mut Geometry, mesh: &MeshDescription, instance: &InstanceDescription) {
    let first = ShapeDescription { positions: mesh.positions.clone(), normals: mesh.normals.clone() };
    let shapes: Vec<&ShapeDescription> = [&first].into_iter().chain(&mesh.later_shapes).collect();
    let poses: Vec<&DAffine3> = [&instance.to_world].into_iter().chain(&instance.later).collect();
    let corner_count = mesh.positions.len() as u32;
    let mut deformation = Deformation {
        first_corner: geometry.positions.len() as u32 - corner_count,
        corner_count,
        positions: Vec::new(),
        normals: Vec::new(),
    };
    // One of both may stand still.
    for i in 0..shapes.len().max(poses.len()) {
        let (shape, pose) = (shapes[i.min(shapes.len() - 1)], poses[i.min(poses.len() - 1)]);
        let normal_matrix = pose.matrix3.inverse().transpose();
        deformation.positions.extend(shape.positions.iter().map(|p| pose.transform_point3(p.as_dvec3()).as_vec3()));
        let normal = |n: &Vec3| (normal_matrix * n.as_dvec3()).normalize_or_zero().as_vec3();
        deformation.normals.extend(shape.normals.iter().map(normal));
    }
    let handle = geometry.deformations.len() as u32;
    geometry.deformations.push(deformation);
    if let Some(range) = geometry.meshes.last_mut() {
        range.deformation = Some(handle);
    }
}

/// Adds a mesh, transformed, and returns its triangles.
fn append(
    geometry: &mut Geometry,
    mesh: &MeshDescription,
    to_world: &DAffine3,
    first_light: Option<u32>,
) -> Range<u32> {
    let identity = *to_world == DAffine3::IDENTITY;
    let point = |p: &Vec3| if identity { *p } else { to_world.transform_point3(p.as_dvec3()).as_vec3() };
    let normal_matrix = to_world.matrix3.inverse().transpose();
    let normal = |n: &Vec3| if identity { *n } else { (normal_matrix * n.as_dvec3()).normalize_or_zero().as_vec3() };
    let base = geometry.positions.len() as u32;
    let first_triangle = geometry.triangles.len() as u32;
    let from = |present: bool, at: usize| present.then_some(base.wrapping_sub(at as u32));
    let range = MeshRange {
        material: mesh.material as u32,
        first_primitive: first_triangle + geometry.quadrics.len() as u32,
        first_triangle,
        triangle_count: mesh.triangles.len() as u32,
        first_light,
        normals_from: from(!mesh.normals.is_empty(), geometry.normals.len()),
        tangents_from: from(!mesh.tangents.is_empty(), geometry.tangents.len()),
        uvs_from: [0, 1].map(|set| from(mesh.uvs.len() > set, geometry.uvs[set].len())),
        colours_from: from(!mesh.colours.is_empty(), geometry.colours.len()),
        deformation: None,
        quadric: None,
    };
    let mesh_handle = geometry.meshes.len() as u32;
    if let Some(kind) = mesh.quadric {
        geometry.meshes.push(MeshRange { quadric: Some(geometry.quadrics.len() as u32), ..range });
        geometry.quadrics.push(PlacedQuadric::new(kind, to_world, mesh_handle));
        return first_triangle..first_triangle;
    }
    geometry.positions.extend(mesh.positions.iter().map(point));
    geometry.normals.extend(mesh.normals.iter().map(normal));
    let mirrored = to_world.matrix3.determinant() < 0.0;
    let handedness = if mirrored { -1.0 } else { 1.0 };
    geometry.tangents.extend(mesh.tangents.iter().map(|t| {
        let along = to_world.transform_vector3(t.truncate().as_dvec3()).normalize_or_zero().as_vec3();
        along.extend(t.w * handedness)
    }));
    for (all, own) in geometry.uvs.iter_mut().zip(&mesh.uvs) {
        all.extend_from_slice(own);
    }
    geometry.colours.extend_from_slice(&mesh.colours);
    geometry.triangles.extend(mesh.triangles.iter().map(|&[a, b, c]| {
        // A mirroring transform turns corners clockwise; the front stays the front.
        let corners = if mirrored { [a, c, b] } else { [a, b, c] };
        Triangle { corners: corners.map(|corner| base + corner), mesh: mesh_handle }
    }));
    geometry.meshes.push(range);
    first_triangle..geometry.triangles.len() as u32
}
