//! What the files say, before anything is prepared for rendering: meshes, instances, materials, textures, lights and
//! cameras in SI units and world axes (metres, right-handed, +Y up).
//!
//! The readers in `photosite-scene-io` fill these structures; [`scene::build`](crate::scene) turns them into tables.
//! Indices refer to the `Vec`s of the same [`SceneDescription`] and are checked by the readers.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};

pub use crate::bsdf::models::*;
use crate::bsdf::{Form, Ggx, Map, MapAll};
pub use crate::bsdf::{Mix, Model};
use crate::geometry::{Motion, QuadricKind};
pub use crate::light::LightKind;
use crate::light::SkyConditions;
use crate::texture::{Bitmap, SamplerSettings, UvTransform};
use photosite_core::Invalid;
use photosite_core::math::hash::hash64;
use photosite_core::spectrum::{Dispersion, Spectrum};

/// A whole scene as read from files.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// Pictures that textures refer to.
    pub images: Vec<Arc<Bitmap>>,
    /// Materials that meshes refer to.
    pub materials: Vec<MaterialDescription>,
    /// Triangle meshes, each with one material.
    pub meshes: Vec<MeshDescription>,
    /// Placements of meshes.
    pub instances: Vec<InstanceDescription>,
    /// Lights without a surface.
    pub lights: Vec<LightDescription>,
    /// What surrounds the scene, if anything shines from there.
    pub environment: Option<EnvironmentDescription>,
    /// Cameras of the files, in order.
    pub cameras: Vec<CameraDescription>,
    /// Things worth telling the user that are no errors, each once.
    pub warnings: Vec<String>,
}

impl SceneDescription {
    /// What tells surfaces apart, hashed: names, instances of meshes and their triangles, whatever their place and
    /// shape. Scenes that have it in common show the same surfaces, which may have moved.
    pub fn surfaces(&self) -> u64 {
        let text =
            |hash: u64, text: &str| text.bytes().fold(hash64(hash, text.len() as u64), |h, b| hash64(h, b.into()));
        let corners =
            |hash: u64, [a, b, c]: &[u32; 3]| hash64(hash, u64::from(*a) << 42 ^ u64::from(*b) << 21 ^ u64::from(*c));
        let of_meshes = self.meshes.iter().fold(self.meshes.len() as u64, |hash, mesh| {
            let kind = match mesh.quadric {
                None => 0,
                Some(QuadricKind::Sphere) => 1,
                Some(QuadricKind::Disk) => 2,
                Some(QuadricKind::Cylinder) => 3,
            };
            let named = hash64(text(hash, &mesh.name), kind);
            mesh.triangles.iter().fold(hash64(named, mesh.triangles.len() as u64), corners)
        });
        self.instances.iter().fold(of_meshes, |hash, instance| hash64(text(hash, &instance.name), instance.mesh as u64))
    }
}

/// An indexed triangle mesh in its own space.
#[derive(Clone, Debug, Default)]
pub struct MeshDescription {
    /// Name in the file, for messages.
    pub name: String,
    /// Index of the material.
    pub material: usize,
    /// Corners, metres. Finite.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position, or empty: then the mesh is flat-shaded by its geometric normals.
    pub normals: Vec<Vec3>,
    /// Tangents with handedness in w (glTF), one per position, or empty.
    pub tangents: Vec<Vec4>,
    /// UV sets, each with one entry per position; at most two.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear RGBA, 0–1, that multiplies the base colour, one per position, or empty.
    pub colours: Vec<Vec4>,
    /// Corner indices, counter-clockwise seen from the front. In range, no triangle of zero area.
    pub triangles: Vec<[u32; 3]>,
    /// The shapes that follow in the time of the picture, at evenly spaced times, where the mesh deforms.
    pub later_shapes: Vec<ShapeDescription>,
    /// The unit shape that it is in place of triangles; see [`of_quadric`](Self::of_quadric).
    pub quadric: Option<QuadricKind>,
}

impl MeshDescription {
    /// A quadric of unit size, for one instance that moves, turns and scales it. `positions` are corners of a box around it.
    pub fn of_quadric(kind: QuadricKind, name: String, material: usize) -> Self {
        Self { name, material, positions: kind.corners(), quadric: Some(kind), ..Self::default() }
    }
}

/// Where the corners of a mesh have gone.
#[derive(Clone, Debug, Default)]
pub struct ShapeDescription {
    /// Corners, metres. Finite, as many as in the first shape.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one per position, or empty if the first shape has none.
    pub normals: Vec<Vec3>,
}

/// One placement of a mesh.
#[derive(Clone, Debug)]
pub struct InstanceDescription {
    /// Name of the node, for messages.
    pub name: String,
    /// Index of the mesh.
    pub mesh: usize,
    /// Mesh space → world. Finite and invertible.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
}

impl InstanceDescription {
    /// Mesh space → world when this part of the picture's time, 0 to 1, has gone by.
    pub fn at(&self, time: f32) -> DAffine3 {
        if self.later.iter().all(|pose| *pose == self.to_world) {
            return self.to_world;
        }
        let poses: Vec<DAffine3> = [&self.to_world].into_iter().chain(&self.later).copied().collect();
        Motion::new(&poses).to_world(time)
    }
}

/// A colour or spectrum that scales a texture or stands alone.
#[derive(Clone, Debug)]
pub enum Colour {
    /// Linear sRGB; upsampled to a spectrum by [`photosite_core::spectrum::upsampling`].
    Rgb([f32; 3]),
    /// A measured or computed spectrum.
    Spectrum(Spectrum),
}

/// Use of an image by a material.
#[derive(Clone, Debug)]
pub struct TextureDescription {
    /// Index of the image.
    pub image: usize,
    /// Which UV set.
    pub uv_set: usize,
    /// Filter and wrap modes.
    pub sampler: SamplerSettings,
    /// Transform of the UVs.
    pub transform: UvTransform,
}

/// How a surface scatters light.
#[derive(Clone, Debug)]
pub struct MaterialDescription {
    /// The name that capture files override it by.
    pub name: String,
    /// Scattering model.
    pub model: MaterialModel,
    /// Tangent-space normal map and the scale of its x and y.
    pub normal_map: Option<(TextureDescription, f32)>,
    /// Emission, if any.
    pub emission: Option<EmissionDescription>,
    /// What of the surface is there at all.
    pub alpha: AlphaMode,
    /// Alpha of the material as a whole, 0–1, times the alpha channel of the base-colour texture.
    pub alpha_factor: f32,
    /// Texture whose alpha channel counts.
    pub alpha_texture: Option<TextureDescription>,
    /// Whether the back scatters like the front. A single-sided opaque material is black and lightless from behind.
    pub double_sided: bool,
}

impl MaterialDescription {
    /// A material of that name and model that covers the whole surface, without bumps or light of its own.
    pub fn new(name: impl Into<String>, model: MaterialModel) -> Self {
        Self {
            name: name.into(),
            model,
            normal_map: None,
            emission: None,
            alpha: AlphaMode::Opaque,
            alpha_factor: 1.0,
            alpha_texture: None,
            double_sided: false,
        }
    }

    /// All textures that the material uses.
    pub fn textures(&self) -> Vec<TextureDescription> {
        let mut all = Textures::default();
        self.model.visit(&mut all);
        let normal = self.normal_map.as_ref().map(|(texture, _)| texture);
        let emission = self.emission.as_ref().and_then(|emission| emission.texture.as_ref());
        all.0.extend([normal, emission, self.alpha_texture.as_ref()].into_iter().flatten().cloned());
        all.0
    }

    /// Changes all textures that the material uses.
    pub fn change_textures(&mut self, change: &mut dyn FnMut(&mut TextureDescription)) {
        self.model = self.model.map(&mut ChangedTextures(change));
        let normal = self.normal_map.as_mut().map(|(texture, _)| texture);
        let emission = self.emission.as_mut().and_then(|emission| emission.texture.as_mut());
        [normal, emission, self.alpha_texture.as_mut()].into_iter().flatten().for_each(change);
    }
}

/// A scattering model as files describe it.
pub type MaterialModel = Model<Described>;

/// Parameters as files state them.
#[derive(Clone, Copy, Debug)]
pub struct Described;

impl Form for Described {
    type Colour = TexturedColour;
    type Spectrum = Spectrum;
    type Index = Dispersion;
    type Distribution = Roughness;
    type Layered = Box<LayeredDescription>;
    type Mix = Box<Mix<Described>>;
}

/// Roughness of GGX microfacets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Roughness {
    /// Perceptual roughness 0–1; α = value² (glTF's convention). Smooth where it is 0.
    pub value: f32,
    /// −1–1: α along the tangent grows, across it shrinks. 0 is isotropic.
    pub anisotropy: f32,
}

impl Roughness {
    /// A polished surface.
    pub const SMOOTH: Self = Self::isotropic(0.0);

    /// The same roughness in all directions.
    pub const fn isotropic(value: f32) -> Self {
        Self { value, anisotropy: 0.0 }
    }

    /// The microfacets.
    pub fn distribution(self) -> Ggx {
        Ggx::from_roughness(self.value, self.anisotropy)
    }
}

/// What is done with each parameter of a model and of the models that it is made of. The default is nothing.
pub trait Visit {
    /// A reflectance.
    fn colour(&mut self, _colour: &TexturedColour) {}
    /// A spectrum.
    fn spectrum(&mut self, _spectrum: &Spectrum) {}
    /// A roughness.
    fn roughness(&mut self, _roughness: &Roughness) {}
    /// glTF's material.
    fn layered(&mut self, _layers: &LayeredDescription) {}
}

impl MaterialModel {
    /// Shows a visitor all parameters.
    pub fn visit(&self, visitor: &mut impl Visit) {
        self.map(&mut Visited(visitor));
    }
}

/// The form in which nothing is left of a model but its name.
#[derive(Clone, Copy, Debug)]
struct Nothing;

impl Form for Nothing {
    type Colour = ();
    type Spectrum = ();
    type Index = ();
    type Distribution = ();
    type Layered = ();
    type Mix = ();
}

/// A visitor as a map.
struct Visited<'a, V>(&'a mut V);

impl<V: Visit> Map<Described, Nothing> for Visited<'_, V> {
    fn colour(&mut self, colour: &TexturedColour) {
        self.0.colour(colour);
    }

    fn spectrum(&mut self, spectrum: &Spectrum) {
        self.0.spectrum(spectrum);
    }

    // No visitor asks for it so far.
    fn index(&mut self, _index: &Dispersion) {}

    fn distribution(&mut self, roughness: &Roughness) {
        self.0.roughness(roughness);
    }
}

impl<V: Visit> MapAll<Described, Nothing> for Visited<'_, V> {
    fn layered(&mut self, layers: &Box<LayeredDescription>) {
        self.0.layered(layers);
    }

    fn mix(&mut self, mix: &Box<Mix<Described>>) {
        mix.models.iter().for_each(|model| model.visit(self.0));
    }
}

/// The textures of a model.
#[derive(Default)]
struct Textures(Vec<TextureDescription>);

impl Visit for Textures {
    fn colour(&mut self, colour: &TexturedColour) {
        self.0.extend(colour.texture.clone());
    }

    fn layered(&mut self, layers: &LayeredDescription) {
        self.0.extend(layers.textures().into_iter().flatten().cloned());
    }
}

/// Leaves a model as it is but for its textures.
struct ChangedTextures<'a>(&'a mut dyn FnMut(&mut TextureDescription));

impl Map<Described, Described> for ChangedTextures<'_> {
    fn colour(&mut self, colour: &TexturedColour) -> TexturedColour {
        let mut colour = colour.clone();
        colour.texture.iter_mut().for_each(&mut *self.0);
        colour
    }

    fn spectrum(&mut self, spectrum: &Spectrum) -> Spectrum {
        spectrum.clone()
    }

    fn index(&mut self, index: &Dispersion) -> Dispersion {
        index.clone()
    }

    fn distribution(&mut self, roughness: &Roughness) -> Roughness {
        *roughness
    }
}

impl MapAll<Described, Described> for ChangedTextures<'_> {
    fn layered(&mut self, layers: &Box<LayeredDescription>) -> Box<LayeredDescription> {
        let mut layers = layers.clone();
        layers.textures_mut().into_iter().flatten().for_each(&mut *self.0);
        layers
    }

    fn mix(&mut self, mix: &Box<Mix<Described>>) -> Box<Mix<Described>> {
        Box::new(Mix { models: mix.models.each_ref().map(|model| model.map(self)), weight: mix.weight })
    }
}

/// A colour, times an sRGB-encoded texture.
#[derive(Clone, Debug)]
pub struct TexturedColour {
    /// 0–1.
    pub colour: Colour,
    /// RGB counts.
    pub texture: Option<TextureDescription>,
}

impl TexturedColour {
    /// Without a texture.
    pub fn plain(colour: Colour) -> Self {
        Self { colour, texture: None }
    }

    /// White.
    pub fn white() -> Self {
        Self::plain(Colour::Rgb([1.0; 3]))
    }
}

/// A number, times a channel of a linear texture.
#[derive(Clone, Debug, Default)]
pub struct TexturedFactor {
    /// The number.
    pub value: f32,
    /// The texture, and which channel of it counts.
    pub texture: Option<(TextureDescription, Channel)>,
}

impl TexturedFactor {
    /// Without a texture.
    pub fn plain(value: f32) -> Self {
        Self { value, texture: None }
    }
}

/// A channel of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "named by what they are")]
pub enum Channel {
    R,
    G,
    B,
    A,
}

/// glTF 2.0's material with its `KHR_materials_*` extensions, from the base up. The default is what the specification
/// says of a material that says nothing, but for `metallic`, which is 0 here.
#[derive(Clone, Debug)]
pub struct LayeredDescription {
    /// Reflectance of the coloured base, F₀ of the metal, tint of transmission.
    pub base_colour: TexturedColour,
    /// Metalness 0–1.
    pub metallic: TexturedFactor,
    /// Perceptual roughness 0–1; α = roughness².
    pub roughness: TexturedFactor,
    /// Refractive index (`ior`, `dispersion`).
    pub index: Dispersion,
    /// Reflectance at normal incidence before the specular colour; left out, that of the index. glTF's index 0 means 1.
    pub normal_reflectance: Option<f32>,
    /// Weight of the facets' reflection where there is no metal (`specular`).
    pub specular: TexturedFactor,
    /// Factor of their reflectance at normal incidence; may exceed 1.
    pub specular_colour: TexturedColour,
    /// How much of what gets in goes on (`transmission`).
    pub transmission: TexturedFactor,
    /// The medium of the closed volume that the surface bounds (`volume`): absorption, m⁻¹. None: a thin sheet.
    pub absorption_per_m: Option<Spectrum>,
    /// How much of the rest comes out behind, and with which colour (`diffuse_transmission`).
    pub diffuse_transmission: Option<(TexturedFactor, TexturedColour)>,
    /// Grooves (`anisotropy`).
    pub anisotropy: Option<AnisotropyDescription>,
    /// A thin film (`iridescence`).
    pub film: Option<FilmDescription>,
    /// Colour and roughness of fibres (`sheen`).
    pub sheen: Option<(TexturedColour, TexturedFactor)>,
    /// Varnish (`clearcoat`).
    pub coat: Option<CoatDescription>,
}

impl Default for LayeredDescription {
    fn default() -> Self {
        Self {
            base_colour: TexturedColour::white(),
            metallic: TexturedFactor::plain(0.0),
            roughness: TexturedFactor::plain(1.0),
            index: Dispersion::constant(1.5),
            normal_reflectance: None,
            specular: TexturedFactor::plain(1.0),
            specular_colour: TexturedColour::white(),
            transmission: TexturedFactor::plain(0.0),
            absorption_per_m: None,
            diffuse_transmission: None,
            anisotropy: None,
            film: None,
            sheen: None,
            coat: None,
        }
    }
}

/// Grooves: α along them is mix(roughness², 1, strength²), across them roughness² (`anisotropy`).
#[derive(Clone, Debug)]
pub struct AnisotropyDescription {
    /// 0–1.
    pub strength: f32,
    /// Of the rougher direction from the tangent towards the bitangent, rad.
    pub rotation_rad: f32,
    /// Linear texture: R, G the direction, B times the strength.
    pub texture: Option<TextureDescription>,
}

/// A thin film (`iridescence`).
#[derive(Clone, Debug)]
pub struct FilmDescription {
    /// 0–1.
    pub weight: TexturedFactor,
    /// Refractive index, at least 1.
    pub index: f32,
    /// Thickness where the texture is 0 and where it is 1 or there is none, nm.
    pub thickness_nm: [f32; 2],
    /// Its green says where between them.
    pub thickness_texture: Option<TextureDescription>,
}

/// Varnish of index 1.5 (`clearcoat`).
#[derive(Clone, Debug)]
pub struct CoatDescription {
    /// 0–1.
    pub weight: TexturedFactor,
    /// Perceptual roughness 0–1.
    pub roughness: TexturedFactor,
    /// Its own bumps, and the factor of their x and y; without any it is smooth, whatever the base has.
    pub normal_map: Option<(TextureDescription, f32)>,
}

/// All textures of the layers, by shared or by mutable reference.
macro_rules! layered_textures {
    ($name:ident, $textured:ident, $pair:ident $(, $mutable:tt)?) => {
        fn $name(& $($mutable)? self) -> Vec<Option<& $($mutable)? TextureDescription>> {
            let Self {
                base_colour, metallic, roughness, index: _, normal_reflectance: _, specular, specular_colour,
                transmission, absorption_per_m: _, diffuse_transmission, anisotropy, film, sheen, coat,
            } = self;
            let mut all = vec![base_colour.texture.$textured(), specular_colour.texture.$textured()];
            all.extend([metallic, roughness, specular, transmission].map($pair));
            if let Some((factor, colour)) = diffuse_transmission {
                all.extend([$pair(factor), colour.texture.$textured()]);
            }
            if let Some(anisotropy) = anisotropy {
                all.push(anisotropy.texture.$textured());
            }
            if let Some(FilmDescription { weight, thickness_texture, .. }) = film {
                all.extend([$pair(weight), thickness_texture.$textured()]);
            }
            if let Some((colour, roughness)) = sheen {
                all.extend([colour.texture.$textured(), $pair(roughness)]);
            }
            if let Some(CoatDescription { weight, roughness, normal_map }) = coat {
                all.extend([$pair(weight), $pair(roughness), normal_map.$textured().map(|(texture, _)| texture)]);
            }
            all
        }
    };
}

impl LayeredDescription {
    layered_textures!(textures, as_ref, texture_of);
    layered_textures!(textures_mut, as_mut, texture_of_mut, mut);
}

fn texture_of(factor: &TexturedFactor) -> Option<&TextureDescription> {
    factor.texture.as_ref().map(|(texture, _)| texture)
}

fn texture_of_mut(factor: &mut TexturedFactor) -> Option<&mut TextureDescription> {
    factor.texture.as_mut().map(|(texture, _)| texture)
}

/// Light that a surface or lamp gives.
#[derive(Clone, Debug)]
pub struct EmissionDescription {
    /// Colour (times D65 for RGB) or spectral shape.
    pub colour: Colour,
    /// Photometric level: luminance in nit for surfaces, luminous intensity in candela for point and spot lights,
    /// illuminance in lux for directional ones. An RGB colour is scaled so that white (1, 1, 1) has this level, a
    /// spectrum so that it has this level itself. `None`: the spectrum is absolute (W·m⁻²·sr⁻¹·nm⁻¹, W·sr⁻¹·nm⁻¹,
    /// W·m⁻²·nm⁻¹).
    pub level: Option<f64>,
    /// sRGB-encoded texture on surfaces.
    pub texture: Option<TextureDescription>,
}

/// glTF alpha modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// There where alpha ≥ cutoff.
    Mask {
        /// The threshold.
        cutoff: f32,
    },
    /// There with probability alpha.
    Blend,
}

/// A light without a surface. It shines along −Z of its node (glTF).
#[derive(Clone, Debug)]
pub struct LightDescription {
    /// Name, for messages.
    pub name: String,
    /// Node → world; only rotation and translation matter.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
    /// Shape and unit of the level.
    pub kind: LightKind,
    /// Its light. The texture is ignored.
    pub emission: EmissionDescription,
}

/// Light from infinitely far in all directions.
#[derive(Clone, Debug)]
pub enum EnvironmentDescription {
    /// The same radiance everywhere.
    Constant {
        /// Spectral shape or colour.
        colour: Colour,
        /// Luminance in nit (illuminance on a plane is π times that); `None` where the spectrum is absolute.
        luminance_nit: Option<f64>,
    },
    /// An equirectangular picture of linear sRGB; its top row is +Y, its centre looks along −Z before rotation.
    Picture {
        /// Linear, 3 or 4 channels.
        image: Arc<Bitmap>,
        /// What a pixel value of 1 means.
        level: PictureLevel,
        /// Rotation about +Y, counter-clockwise seen from above, degrees.
        rotation_deg: f64,
    },
    /// The sky by day.
    Sky(SkyConditions),
}

/// How the pixel values of an environment picture become luminances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureLevel {
    /// Luminance in nit of a white pixel of value 1.
    NitPerUnit(f64),
    /// The picture is scaled so that it gives this illuminance (lux) on a horizontal plane facing up.
    HorizontalLux(f64),
}

/// A camera of a scene file. The lens and sensor may override its field of view.
#[derive(Clone, Debug)]
pub struct CameraDescription {
    /// Name that `gltf_camera` refers to.
    pub name: String,
    /// Camera → world; looks along −Z, +Y up.
    pub to_world: DAffine3,
    /// The same at the evenly spaced times that follow in the time of the picture, where it moves.
    pub later: Vec<DAffine3>,
    /// Full vertical field of view, rad.
    pub vertical_fov_rad: f64,
}

/// Where a camera stands and looks, as rotation and translation.
pub fn look_at(position: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    let z = (position - target).try_normalize()?;
    let x = up.cross(z).try_normalize()?;
    Some(DAffine3::from_cols(x, z.cross(x), z, position))
}

/// The same with what a user wrote. Keys of errors are `position_m`, `look_at_m` and `up`.
pub fn looking(position: [f64; 3], target: [f64; 3], up: Option<[f64; 3]>) -> Result<DAffine3, Invalid> {
    let position = vector("position_m", position)?;
    let target = vector("look_at_m", target)?;
    let up = vector("up", up.unwrap_or([0.0, 1.0, 0.0]))?;
    if position == target {
        let message = "is where the camera stands, so it looks nowhere";
        return Err(Invalid::new("look_at_m", message).help("write a point in front of the camera"));
    }
    look_at(position, target, up).ok_or_else(|| {
        let message = format!("the camera looks along {up}, so that cannot be up in the picture");
        Invalid::new("up", message).help("write a direction across the view, for example up = [0, 0, -1]")
    })
}

/// Three finite coordinates.
pub fn vector(key: &str, v: [f64; 3]) -> Result<DVec3, Invalid> {
    let vector = DVec3::from_array(v);
    if vector.is_finite() { Ok(vector) } else { Err(Invalid::new(key, format!("must be finite, got {v:?}"))) }
}
