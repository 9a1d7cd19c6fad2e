//! Textures made from the images of MTL materials.
//!
//! Images of colours are kept as they are, sRGB-encoded. In images of one number the channel that counts is copied to
//! all channels, since textures of opacity use alpha. Exponents become roughness, heights become normals.

use std::collections::hash_map::{Entry, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::files::file_beside;
use super::map::{Map, MapChannel, Range};
use super::mtl::{MtlMaterial, roughness_of_exponent};
use crate::bitmap_file::read_bitmap;
use crate::stand_in::{Holds, stand_in, stands_in};
use photosite_core::spectrum::rgb;
use photosite_core::warnings::Warnings;
use photosite_core::{Remedy, Result, Sandbox};
use photosite_transport::scene::description::TextureDescription;
use photosite_transport::texture::{Bitmap, Texels, Wrap};

/// Textures of a material, whose images are already among the scene's. Those of one number have it in every channel.
#[derive(Debug, Default)]
pub(super) struct MaterialTextures {
    pub(super) diffuse: Option<TextureDescription>,
    pub(super) specular: Option<TextureDescription>,
    pub(super) emission: Option<TextureDescription>,
    pub(super) opacity: Option<TextureDescription>,
    /// Texture of `map_Pr`, a factor of the roughness.
    pub(super) roughness: Option<TextureDescription>,
    /// Texture of roughness derived from `map_Ns`.
    pub(super) roughness_of_exponent: Option<TextureDescription>,
    pub(super) metallic: Option<TextureDescription>,
    /// Texture of sheen, sRGB-encoded.
    pub(super) sheen: Option<TextureDescription>,
    pub(super) coat: Option<TextureDescription>,
    pub(super) coat_roughness: Option<TextureDescription>,
    /// A tangent-space normal map, and the factor of its x and y.
    pub(super) normal: Option<(TextureDescription, f32)>,
}

/// Exponent of white in a map of exponents without `Ns`: the largest that the format defines
/// ([Mtl95](photosite_core::references#mtl95)).
const LARGEST_EXPONENT: f32 = 1000.0;

/// Cache of images.
#[derive(Default)]
pub(super) struct ImageCache {
    pub(super) images: Vec<Arc<Bitmap>>,
    /// Sandbox that images must lie in.
    sandbox: Sandbox,
    /// Whether a missing or broken image gets a stand-in with a warning.
    is_lenient: bool,
    pub(super) warnings: Warnings,
    /// Prepared images by path and preparation.
    pub(super) slots: HashMap<(PathBuf, String), Prepared>,
}

#[derive(Clone, Copy)]
pub(super) struct Prepared {
    image: usize,
    /// Whether the image is a normal map though heights were asked for.
    has_normals: bool,
}

/// Preparation of an image for its use in a texture.
#[derive(Clone, Copy, Debug)]
enum Preparation {
    /// Colour image.
    Colours(Range),
    /// One number in every channel.
    Number(Option<MapChannel>, Range),
    /// Single number, encoded as colours are, in every channel.
    EncodedNumber(Option<MapChannel>, Range),
    /// Opacity in every channel: alpha where the image makes use of it and the map names no channel.
    Opacity(Option<MapChannel>, Range),
    /// Roughness for a factor of this exponent.
    Roughness(Option<MapChannel>, Range, f32),
    /// Normals from heights in texels, times this factor; a normal map stays as it is.
    Normals(Option<MapChannel>, Range, f32, [Wrap; 2]),
    /// Unchanged image.
    Kept,
}

impl ImageCache {
    /// Empty cache of images in a sandbox.
    pub(super) fn within(sandbox: &Sandbox, is_lenient: bool) -> Self {
        Self { sandbox: sandbox.clone(), is_lenient, ..Self::default() }
    }

    pub(super) fn of_material(&mut self, mtl: &MtlMaterial, library: &Path) -> Result<MaterialTextures> {
        let mut texture = |map: &Option<Map>, preparation: fn(&Map) -> Preparation| match map {
            Some(map) => self.texture(map, library, preparation(map)).map(|(texture, _)| Some(texture)),
            None => Ok(None),
        };
        let colours = |map: &Map| Preparation::Colours(map.range);
        let number = |map: &Map| Preparation::Number(map.channel, map.range);
        let mut textures = MaterialTextures {
            diffuse: texture(&mtl.diffuse_map, colours)?,
            specular: texture(&mtl.specular_map, colours)?,
            emission: texture(&mtl.emission_map, colours)?,
            opacity: texture(&mtl.opacity_map, |map| Preparation::Opacity(map.channel, map.range))?,
            roughness: texture(&mtl.roughness_map, number)?,
            metallic: texture(&mtl.metallic_map, number)?,
            sheen: texture(&mtl.sheen_map, |map| Preparation::EncodedNumber(map.channel, map.range))?,
            coat: texture(&mtl.coat_map, number)?,
            coat_roughness: texture(&mtl.coat_roughness_map, number)?,
            normal: None,
            roughness_of_exponent: None,
        };
        if let Some(map) = &mtl.shininess_map {
            let preparation = Preparation::Roughness(map.channel, map.range, mtl.shininess.unwrap_or(LARGEST_EXPONENT));
            textures.roughness_of_exponent = Some(self.texture(map, library, preparation)?.0);
        }
        if let Some(map) = &mtl.normal_map {
            textures.normal = Some((self.texture(map, library, Preparation::Kept)?.0, map.bumps));
        } else if let Some(map) = &mtl.bump_map {
            let preparation = Preparation::Normals(map.channel, map.range, map.bumps, map.sampler.wrap);
            let (texture, has_normals) = self.texture(map, library, preparation)?;
            textures.normal = Some((texture, if has_normals { map.bumps } else { 1.0 }));
        }
        Ok(textures)
    }

    /// Texture of a map, and whether an image of heights was a normal map.
    fn texture(&mut self, map: &Map, library: &Path, preparation: Preparation) -> Result<(TextureDescription, bool)> {
        let path = file_beside(library.parent().unwrap_or(Path::new("")), &map.file);
        let prepared = match self.slots.entry((path, format!("{preparation:?}"))) {
            Entry::Occupied(entry) => *entry.get(),
            Entry::Vacant(entry) => {
                let path = &entry.key().0;
                self.sandbox.check(path).map_err(|e| e.within(&map.key).at_line(library, map.line))?;
                let image = match read_bitmap(path).map_err(|e| e.within(&map.key)) {
                    Ok(image) => image,
                    Err(invalid) if self.is_lenient => {
                        let holds = preparation.holds();
                        self.warnings.once(stands_in(&invalid.to_string(), holds));
                        stand_in(holds, path.display().to_string())
                    }
                    Err(invalid) => return Err(invalid.or(Remedy::Lenient).at_line(library, map.line)),
                };
                let (image, has_normals) = preparation.apply(image);
                self.images.push(Arc::new(image));
                *entry.insert(Prepared { image: self.images.len() - 1, has_normals })
            }
        };
        let texture =
            TextureDescription { image: prepared.image, uv_set: 0, sampler: map.sampler, transform: map.transform };
        Ok((texture, prepared.has_normals))
    }
}

impl Preparation {
    /// Content of the image before its preparation.
    fn holds(self) -> Holds {
        match self {
            Self::Colours(_) => Holds::Colours,
            Self::Number(..) | Self::EncodedNumber(..) | Self::Opacity(..) | Self::Roughness(..) => Holds::Factors,
            Self::Normals(..) | Self::Kept => Holds::Normals,
        }
    }

    /// Prepared image, and whether it is a normal map though heights were asked for.
    fn apply(self, image: Bitmap) -> (Bitmap, bool) {
        let made = match self {
            Self::Kept | Self::Colours(Range::WHOLE) => image,
            Self::Colours(range) => each_texel(&image, |i| {
                let [r, g, b, a] = image.srgb_texel(i);
                let [r, g, b] = [r, g, b].map(|c| rgb::encode(range.apply(c)));
                [r, g, b, a]
            }),
            Self::Number(channel, range) => numbers(&image, channel, range, |v| v),
            Self::EncodedNumber(channel, range) => numbers(&image, channel, range, rgb::encode),
            Self::Opacity(channel, range) => {
                let by_alpha = (0..image.texels.len()).any(|i| image.linear_texel(i)[3] < 1.0);
                let channel = channel.or(by_alpha.then_some(MapChannel::Matte));
                numbers(&image, channel, range, |v| v)
            }
            Self::Roughness(channel, range, exponent) => {
                numbers(&image, channel, range, |v| roughness_of_exponent(exponent * v))
            }
            Self::Normals(..) if has_normals(&image) => return (image, true),
            Self::Normals(channel, range, strength, wrap) => {
                normals(&numbers(&image, channel, range, |v| v), strength, wrap)
            }
        };
        (made, false)
    }
}

/// Image of 16 bits with a function of each texel, 0–1.
fn each_texel(image: &Bitmap, texel: impl Fn(usize) -> [f32; 4]) -> Bitmap {
    let code = |value: f32| (value.clamp(0.0, 1.0) * f32::from(u16::MAX)).round() as u16;
    let texels = Texels::Rgba16((0..image.texels.len()).map(|i| texel(i).map(code)).collect());
    Bitmap { name: image.name.clone(), width: image.width, height: image.height, texels }
}

/// Image with a function of the channel that counts in every channel.
fn numbers(image: &Bitmap, channel: Option<MapChannel>, range: Range, f: impl Fn(f32) -> f32) -> Bitmap {
    each_texel(image, |i| {
        let [r, g, b, a] = image.linear_texel(i);
        let number = match channel {
            Some(MapChannel::R) => r,
            Some(MapChannel::G) => g,
            Some(MapChannel::B) => b,
            Some(MapChannel::Matte) => a,
            // Of grey, to the last bit, itself.
            None | Some(MapChannel::Luminance) if r == g && g == b => r,
            None | Some(MapChannel::Luminance) => rgb::luminance([r, g, b].map(f64::from)) as f32,
        };
        [f(range.apply(number)); 4]
    })
}

/// Whether an image is mostly blue, as normal maps are, which programs write as `map_Bump` too.
fn has_normals(image: &Bitmap) -> bool {
    /// Least excess of blue: normals of less than 60° from the surface's have a blue of more than ¾, red and green of
    /// about ½.
    const BLUER_BY: f64 = 0.15;
    let mut sum = [0.0; 3];
    for i in 0..image.texels.len() {
        let texel = image.linear_texel(i);
        sum.iter_mut().zip(texel).for_each(|(sum, c)| *sum += f64::from(c));
    }
    let [r, g, b] = sum.map(|sum| sum / image.texels.len() as f64);
    b - r > BLUER_BY && b - g > BLUER_BY
}

/// Normal map of heights, which are `strength` texels for white: (−∂h/∂x, −∂h/∂y, 1) by differences over two texels, y
/// upwards as in glTF.
fn normals(heights: &Bitmap, strength: f32, wrap: [Wrap; 2]) -> Bitmap {
    let (width, height) = (heights.width, heights.height);
    let step = |at: usize, by: isize, size: usize, wrap: Wrap| {
        let (at, size) = (at as isize + by, size as isize);
        match wrap {
            Wrap::Repeat => at.rem_euclid(size) as usize,
            // One texel beyond the border, the mirrored image has that of the border.
            Wrap::MirroredRepeat | Wrap::ClampToEdge => at.clamp(0, size - 1) as usize,
        }
    };
    each_texel(heights, |i| {
        let (x, y) = (i % width, i / width);
        let at = |x: usize, y: usize| heights.linear_texel(y * width + x)[0];
        let right = at(step(x, 1, width, wrap[0]), y) - at(step(x, -1, width, wrap[0]), y);
        let up = at(x, step(y, -1, height, wrap[1])) - at(x, step(y, 1, height, wrap[1]));
        let normal = glam::Vec3::new(-0.5 * strength * right, -0.5 * strength * up, 1.0).normalize();
        let [x, y, z] = (normal * 0.5 + 0.5).to_array();
        [x, y, z, 1.0]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, texels: &[[u8; 4]]) -> Bitmap {
        let texels = Texels::Rgba8(texels.to_vec());
        Bitmap { name: "test".into(), width, height: texels.len() / width, texels }
    }

    fn made(preparation: Preparation, width: usize, texels: &[[u8; 4]]) -> Bitmap {
        preparation.apply(image(width, texels)).0
    }

    /// Texels are rounded to 16 bits: right to half of that.
    const ROUNDED: f32 = 0.5001 / 65535.0;

    #[test]
    fn one_number_is_the_channel_that_is_asked_for_in_its_range() {
        let texel = [51, 102, 204, 153];
        let luminance = 0.2 * 0.2126 + 0.4 * 0.7152 + 0.8 * 0.0722;
        for (channel, expected) in [
            (Some(MapChannel::R), 0.2),
            (Some(MapChannel::G), 0.4),
            (Some(MapChannel::B), 0.8),
            (Some(MapChannel::Matte), 0.6),
            (None, luminance),
        ] {
            let range = Range { base: 0.1, gain: 0.5 };
            let number = made(Preparation::Number(channel, range), 1, &[texel]).linear_texel(0);
            // The weights of luminance are quoted to four decimals.
            for c in number {
                assert!((c - (0.1 + 0.5 * expected)).abs() < ROUNDED + 5e-5, "{channel:?}: {c}");
            }
        }
        let encoded = made(Preparation::EncodedNumber(None, Range::WHOLE), 1, &[[51, 51, 51, 255]]);
        assert!((encoded.srgb_texel(0)[0] - 0.2).abs() < 2.0 * ROUNDED);
    }

    #[test]
    fn colours_keep_their_bytes_unless_their_range_changes() {
        let texel = [51, 102, 204, 153];
        let kept = made(Preparation::Colours(Range::WHOLE), 1, &[texel]);
        assert!(matches!(&kept.texels, Texels::Rgba8(t) if t[..] == [texel]));
        let halved = made(Preparation::Colours(Range { base: 0.0, gain: 0.5 }), 1, &[texel]);
        for (a, b) in halved.srgb_texel(0).into_iter().zip(kept.srgb_texel(0)).take(3) {
            assert!((a - 0.5 * b).abs() < 3.0 * ROUNDED, "linear values are halved");
        }
    }

    #[test]
    fn opacity_is_alpha_where_there_is_any() {
        let opacity = |texels: &[[u8; 4]]| made(Preparation::Opacity(None, Range::WHOLE), 1, texels).linear_texel(0);
        assert!((opacity(&[[255, 255, 255, 51]])[3] - 0.2).abs() < ROUNDED);
        assert!((opacity(&[[51, 51, 51, 255]])[3] - 0.2).abs() < ROUNDED);
    }

    #[test]
    fn exponents_become_roughness() {
        // 0.2 of 160 is 32, of which α = √(2/34) and the roughness √α.
        let made = made(Preparation::Roughness(None, Range::WHOLE, 160.0), 1, &[[51, 51, 51, 255]]);
        assert!((made.linear_texel(0)[0] - (2.0f32 / 34.0).powf(0.25)).abs() < ROUNDED);
    }

    #[test]
    fn normals_stand_across_slopes() {
        // A ramp that rises by 51/255 a texel to the right and falls by twice that downwards, clamped at its ends.
        let heights: Vec<[u8; 4]> = (0..9u8)
            .map(|i| (i % 3, i / 3))
            .map(|(x, y)| [102 + 51 * x - 51 * y; 3])
            .map(|[r, g, b]| [r, g, b, 255])
            .collect();
        let ramp = |strength| {
            let preparation = Preparation::Normals(None, Range::WHOLE, strength, [Wrap::ClampToEdge; 2]);
            let [x, y, z, _] = made(preparation, 3, &heights).linear_texel(4).map(|c| 2.0 * c - 1.0);
            glam::Vec3::new(x, y, z)
        };
        // h = 0.2·x − 0.2·row, and up is against the rows.
        assert!((ramp(1.0) - glam::Vec3::new(-0.2, -0.2, 1.0).normalize()).length() < 4.0 * ROUNDED);
        assert!((ramp(3.0) - glam::Vec3::new(-0.6, -0.6, 1.0).normalize()).length() < 4.0 * ROUNDED);
        // Around the border the first column follows the last.
        let preparation = Preparation::Normals(None, Range::WHOLE, 1.0, [Wrap::Repeat; 2]);
        let [x, ..] = made(preparation, 3, &heights).linear_texel(3).map(|c| 2.0 * c - 1.0);
        assert!(((0.1f32).atan() - x.atan()).abs() < 0.01, "{x}");
    }

    #[test]
    fn images_of_normals_stay() {
        let flat = [128, 128, 255, 255];
        let (kept, has_normals) =
            Preparation::Normals(None, Range::WHOLE, 0.5, [Wrap::Repeat; 2]).apply(image(2, &[flat, flat]));
        assert!(has_normals && matches!(&kept.texels, Texels::Rgba8(t) if t[0] == flat));
    }
}
