//! Textures: images, samplers and UV transforms. An image is decoded once, and only if a material uses it.

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec2;
use gltf::json::Root;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::texture::{MagFilter, MinFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use rayon::prelude::*;

use super::buffers::{Buffers, FileLocation, check_uri, out_of_range, read_uri};
use super::ktx2;
use super::mesh::UV_SETS;
use crate::bitmap_file::decode_bitmap;
use crate::stand_in::{Holds, stand_in, stands_in};
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Remedy};
use photosite_transport::scene::description::TextureDescription;
use photosite_transport::texture::{Bitmap, Filter, SamplerSettings, Texels, UvTransform, Wrap};

/// A reference to a texture, which materials write in several forms.
pub(super) struct TextureUse<'a> {
    pub(super) texture: usize,
    pub(super) uv_set: u32,
    pub(super) transform: Option<&'a TextureTransform>,
}

/// Collector of the textures that materials use.
pub(super) struct Textures<'a> {
    root: &'a Root,
    /// Index of each image among those of the scene description.
    slots: HashMap<TextureImage, usize>,
    /// Images in the order of their slots.
    used: Vec<Used>,
}

/// A used image, with the first reference to it.
struct Used {
    content: TextureImage,
    holds: Holds,
    key: String,
}

/// Image derived from a glTF image.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum TextureImage {
    /// Unchanged image.
    Image(usize),
    /// Roughness 1 − factor·alpha, in the green channel, of an image whose alpha is glossiness. The factor is kept by
    /// its bits.
    Roughness(usize, u32),
    /// Stand-in for the image that a glTF texture lacks.
    Missing(usize),
}

impl<'a> Textures<'a> {
    pub(super) fn new(root: &'a Root) -> Self {
        Self { root, slots: HashMap::new(), used: Vec::new() }
    }

    /// Describes the use of a texture that holds `holds`, and notes that its image is needed. `key` names what refers
    /// to it.
    pub(super) fn describe(
        &mut self,
        used: TextureUse<'_>,
        holds: Holds,
        key: &str,
    ) -> Result<TextureDescription, Invalid> {
        self.describe_image(used, holds, key, TextureImage::Image)
    }

    /// Describes the use of a texture whose alpha is glossiness, as a texture whose green channel is the roughness 1 −
    /// `glossiness`·alpha.
    pub(super) fn describe_roughness(
        &mut self,
        used: TextureUse<'_>,
        glossiness: f32,
        key: &str,
    ) -> Result<TextureDescription, Invalid> {
        self.describe_image(used, Holds::Colours, key, |image| TextureImage::Roughness(image, glossiness.to_bits()))
    }

    fn describe_image(
        &mut self,
        used: TextureUse<'_>,
        holds: Holds,
        key: &str,
        content: impl FnOnce(usize) -> TextureImage,
    ) -> Result<TextureDescription, Invalid> {
        let index = used.texture;
        let textures = &self.root.textures;
        let texture = textures
            .get(index)
            .ok_or_else(|| out_of_range(&format!("{key}.index"), "textures", index, textures.len()))?;
        let named = |name: &str| texture.extensions.as_ref().and_then(|e| e.others.get(name)?.get("source")?.as_u64());
        // A file may offer a PNG or JPEG beside them, for readers that know neither.
        let extension = ["EXT_texture_webp", "KHR_texture_basisu"].into_iter().find_map(named);
        let image = extension.map_or(texture.source.value(), |image| image as usize);
        let content = if image == u32::MAX as usize {
            TextureImage::Missing(index)
        } else if image < self.root.images.len() {
            content(image)
        } else {
            return Err(out_of_range(&format!("textures[{index}].source"), "images", image, self.root.images.len()));
        };
        let sampler = match texture.sampler {
            Some(sampler) => {
                let samplers = &self.root.samplers;
                let found = samplers.get(sampler.value());
                let found = found.ok_or_else(|| {
                    out_of_range(&format!("textures[{index}].sampler"), "samplers", sampler.value(), samplers.len())
                })?;
                sampler_settings(found, &format!("samplers[{}]", sampler.value()))?
            }
            None => SamplerSettings::default(),
        };
        let uv_set = used.transform.and_then(|t| t.tex_coord).unwrap_or(used.uv_set) as usize;
        if uv_set >= UV_SETS {
            let message = format!("uses TEXCOORD_{uv_set}, but only {UV_SETS} UV sets are supported");
            return Err(Invalid::new(format!("{key}.texCoord"), message).help("write 0 or 1"));
        }
        let transform = used.transform.map(|t| uv_transform(t, key)).transpose()?.unwrap_or_default();
        let slot = *self.slots.entry(content).or_insert_with(|| {
            self.used.push(Used { content, holds, key: key.to_owned() });
            self.used.len() - 1
        });
        Ok(TextureDescription { image: slot, uv_set, sampler, transform })
    }

    /// Decodes the used images, in parallel. A missing or broken one is an error, or gets a stand-in.
    pub(super) fn decode(
        self,
        buffers: &Buffers,
        place: FileLocation<'_>,
        is_lenient: bool,
        warnings: &mut Warnings,
    ) -> Result<Vec<Arc<Bitmap>>, Invalid> {
        let decode = |used: &Used| match used.content {
            TextureImage::Image(image) | TextureImage::Roughness(image, _) => {
                read_image(self.root, image, buffers, place)
            }
            TextureImage::Missing(texture) => {
                Err(Invalid::new(format!("textures[{texture}]"), "has no image that can be read")
                    .help("export the textures as PNG, JPEG, WebP or KTX2"))
            }
        };
        // Collected before the first error is looked for, so that always the same error is reported.
        let decoded: Vec<Result<ktx2::Decoded, Invalid>> = self.used.par_iter().map(decode).collect();
        let mut bitmaps = Vec::with_capacity(decoded.len());
        for (decoded, used) in decoded.into_iter().zip(&self.used) {
            let Used { content, holds, key } = used;
            let bitmap = match decoded {
                Ok(ktx2::Decoded { bitmap, is_srgb }) => {
                    if let Some(says) = is_srgb.filter(|&is_srgb| is_srgb != (*holds == Holds::Colours)) {
                        let (says, is) = if says { ("sRGB-encoded", "linear") } else { ("linear", "sRGB-encoded") };
                        let name = &bitmap.name;
                        warnings.once(format!("{key}: the KTX2 image {name} says that it is {says}, but is taken as {is}, which its use demands"));
                    }
                    bitmap
                }
                Err(invalid) if is_lenient => {
                    if let TextureImage::Image(image) | TextureImage::Roughness(image, _) = content {
                        check_uri(self.root.images[*image].uri.as_deref(), place)?;
                    }
                    warnings.once(stands_in(&invalid.to_string(), *holds));
                    stand_in(*holds, invalid.key)
                }
                Err(invalid) => return Err(invalid.or(Remedy::Lenient)),
            };
            bitmaps.push(Arc::new(match content {
                TextureImage::Image(_) | TextureImage::Missing(_) => bitmap,
                TextureImage::Roughness(_, glossiness) => roughness(&bitmap, f32::from_bits(*glossiness)),
            }));
        }
        Ok(bitmaps)
    }
}

fn read_image(root: &Root, index: usize, buffers: &Buffers, place: FileLocation<'_>) -> Result<ktx2::Decoded, Invalid> {
    let image = &root.images[index];
    let key = format!("images[{index}]");
    let (bytes, name) = match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let key = format!("{key}.uri");
            let name = if uri.starts_with("data:") { key.clone() } else { uri.clone() };
            (read_uri(uri, place).map_err(|e| e.within(&key))?.into(), image.name.clone().unwrap_or(name))
        }
        (None, Some(view)) => {
            let (bytes, _) = buffers.view(root, view.value(), &format!("{key}.bufferView"))?;
            (std::borrow::Cow::from(bytes), image.name.clone().unwrap_or_else(|| key.clone()))
        }
        (None, None) => return Err(Invalid::new(key, "has neither a uri nor a bufferView, so no image")),
    };
    let decoded = if ktx2::is_ktx2(&bytes) {
        ktx2::decode(&bytes, name)
    } else {
        decode_bitmap(&bytes, name).map(|bitmap| ktx2::Decoded { bitmap, is_srgb: None })
    };
    decoded.map_err(|e| e.within(&key))
}

/// Roughness 1 − factor·alpha in the green channel.
fn roughness(glossy: &Bitmap, factor: f32) -> Bitmap {
    let texel = |i: usize| {
        let roughness = ((1.0 - factor * glossy.linear_texel(i)[3]) * f32::from(u16::MAX)).round() as u16;
        [u16::MAX, roughness, 0, u16::MAX]
    };
    let texels = Texels::Rgba16((0..glossy.texels.len()).map(texel).collect());
    Bitmap { name: glossy.name.clone(), width: glossy.width, height: glossy.height, texels }
}

fn sampler_settings(sampler: &Sampler, key: &str) -> Result<SamplerSettings, Invalid> {
    let wrap = |mode: &Checked<WrappingMode>, name: &str| match mode {
        Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::MirroredRepeat),
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::ClampToEdge),
        Checked::Invalid => {
            Err(Invalid::new(format!("{key}.{name}"), "is unknown").help("write 10497, 33648 or 33071"))
        }
    };
    // A render magnifies wherever it resolves texels, so the magnification filter decides; the other one only where a
    // file gives no more than that.
    let nearest = match (&sampler.mag_filter, &sampler.min_filter) {
        (Some(Checked::Valid(filter)), _) => *filter == MagFilter::Nearest,
        (None, Some(Checked::Valid(filter))) => matches!(filter, MinFilter::Nearest | MinFilter::NearestMipmapNearest),
        (None, None) => false,
        (Some(Checked::Invalid), _) | (None, Some(Checked::Invalid)) => {
            return Err(Invalid::new(key, "has an unknown filter").help("write 9728 or 9729 as magFilter"));
        }
    };
    Ok(SamplerSettings {
        wrap: [wrap(&sampler.wrap_s, "wrapS")?, wrap(&sampler.wrap_t, "wrapT")?],
        filter: if nearest { Filter::Nearest } else { Filter::Linear },
    })
}

fn uv_transform(transform: &TextureTransform, key: &str) -> Result<UvTransform, Invalid> {
    let offset = Vec2::from_array(transform.offset.0);
    let scale = Vec2::from_array(transform.scale.0);
    let rotation_rad = transform.rotation.0;
    if !(offset.is_finite() && scale.is_finite() && rotation_rad.is_finite()) {
        return Err(Invalid::new(format!("{key}.extensions.KHR_texture_transform"), "is not finite"));
    }
    Ok(UvTransform { offset, rotation_rad, scale })
}
