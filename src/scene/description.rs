//! What the files say, before anything is prepared for rendering: meshes, instances, materials, textures, lights and
//! cameras in SI units and world axes (metres, right-handed, +Y up).
//!
//! The readers in [`io`](crate::io) fill these structures; [`scene::build`](crate::scene) turns them into tables.
//! Indices refer to the `Vec`s of the same [`SceneDescription`] and are checked by the readers.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};

use crate::spectrum::{Dispersion, Spectrum};
use crate::texture::{Bitmap, SamplerSettings, UvTransform};

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
    /// Corner indices, counter-clockwise seen from the front. In range, no triangle of zero area.
    pub triangles: Vec<[u32; 3]>,
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
}

/// A colour or spectrum that scales a texture or stands alone.
#[derive(Clone, Debug)]
pub enum Colour {
    /// Linear sRGB; upsampled to a spectrum by [`crate::spectrum::upsampling`].
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
    /// All textures that the material uses.
    pub fn textures(&self) -> impl Iterator<Item = &TextureDescription> {
        let of_model = match &self.model {
            MaterialModel::Diffuse { texture, .. } => [texture.as_ref(), None],
            MaterialModel::Conductor { .. } | MaterialModel::Dielectric { .. } => [None, None],
            MaterialModel::MetallicRoughness { base_colour_texture, metallic_roughness_texture, .. } => {
                [base_colour_texture.as_ref(), metallic_roughness_texture.as_ref()]
            }
        };
        let normal = self.normal_map.as_ref().map(|(texture, _)| texture);
        let emission = self.emission.as_ref().and_then(|emission| emission.texture.as_ref());
        of_model.into_iter().chain([normal, emission, self.alpha_texture.as_ref()]).flatten()
    }

    /// All textures that the material uses, to be changed.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut TextureDescription> {
        let of_model = match &mut self.model {
            MaterialModel::Diffuse { texture, .. } => [texture.as_mut(), None],
            MaterialModel::Conductor { .. } | MaterialModel::Dielectric { .. } => [None, None],
            MaterialModel::MetallicRoughness { base_colour_texture, metallic_roughness_texture, .. } => {
                [base_colour_texture.as_mut(), metallic_roughness_texture.as_mut()]
            }
        };
        let normal = self.normal_map.as_mut().map(|(texture, _)| texture);
        let emission = self.emission.as_mut().and_then(|emission| emission.texture.as_mut());
        of_model.into_iter().chain([normal, emission, self.alpha_texture.as_mut()]).flatten()
    }
}

/// Scattering models; one arm each in [`crate::bsdf`].
#[derive(Clone, Debug)]
pub enum MaterialModel {
    /// Lambert's law.
    Diffuse {
        /// Reflectance, 0–1, times the texture.
        reflectance: Colour,
        /// sRGB-encoded colour texture.
        texture: Option<TextureDescription>,
    },
    /// A metal, GGX microfacets; smooth where the roughness is 0.
    Conductor {
        /// Real part of the refractive index.
        eta: Spectrum,
        /// Imaginary part (extinction coefficient).
        k: Spectrum,
        /// Perceptual roughness 0–1; α = roughness² (glTF convention).
        roughness: f32,
        /// Anisotropy −1–1: α along the tangent grows, across shrinks. 0 is isotropic.
        anisotropy: f32,
    },
    /// Clear glass or liquid, GGX microfacets; smooth where the roughness is 0.
    Dielectric {
        /// Index of the side that the normal points away from, relative to the other.
        index: Dispersion,
        /// Perceptual roughness 0–1; α = roughness².
        roughness: f32,
    },
    /// glTF 2.0 metallic-roughness (glTF specification, appendix B).
    MetallicRoughness {
        /// Base colour, times the texture.
        base_colour: Colour,
        /// sRGB-encoded base colour.
        base_colour_texture: Option<TextureDescription>,
        /// Metalness 0–1, times blue of the texture.
        metallic: f32,
        /// Perceptual roughness 0–1, times green of the texture.
        roughness: f32,
        /// Linear texture: G roughness, B metalness.
        metallic_roughness_texture: Option<TextureDescription>,
    },
}

/// Light that a surface or lamp gives.
#[derive(Clone, Debug)]
pub struct EmissionDescription {
    /// Colour (times D65 for RGB) or spectral shape.
    pub colour: Colour,
    /// Photometric level: luminance in nit for surfaces, luminous intensity in candela for point and spot lights,
    /// illuminance in lux for directional ones. An RGB colour is scaled so that white (1, 1, 1) has this level, a spectrum
    /// so that it has this level itself. `None`: the spectrum is absolute (W·m⁻²·sr⁻¹·nm⁻¹, W·sr⁻¹·nm⁻¹, W·m⁻²·nm⁻¹).
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
    /// Shape and unit of the level.
    pub kind: LightKind,
    /// Its light. The texture is ignored.
    pub emission: EmissionDescription,
}

/// Shapes of lights without a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Intensity (cd) equal in all directions.
    Point,
    /// Intensity (cd) within a cone, falling off smoothly between the angles (KHR_lights_punctual).
    Spot {
        /// Half-angle of full intensity, rad.
        inner_rad: f32,
        /// Half-angle beyond which there is none, rad, at most π/2.
        outer_rad: f32,
    },
    /// Illuminance (lux) on a plane across the direction, from infinitely far.
    Directional,
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
    /// Full vertical field of view, rad.
    pub vertical_fov_rad: f64,
}

/// Where a camera stands and looks, as rotation and translation.
pub fn look_at(position: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    let z = (position - target).try_normalize()?;
    let x = up.cross(z).try_normalize()?;
    Some(DAffine3::from_cols(x, z.cross(x), z, position))
}
