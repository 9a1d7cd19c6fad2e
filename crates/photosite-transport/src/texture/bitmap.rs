//! Decoded images: the storage of texels and the values that they stand for.

use std::sync::OnceLock;

use glam::Vec4;

use super::sampler::Taps;
use photosite_core::Invalid;
use photosite_core::spectrum::rgb;

/// A decoded image of up to four channels.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// Origin of the image, for messages.
    pub name: String,
    /// Number of columns.
    pub width: usize,
    /// Number of rows; the first is the top.
    pub height: usize,
    /// Texels, row by row.
    pub texels: Texels,
}

/// Texel storage, RGBA or RGB interleaved.
#[derive(Clone, Debug)]
pub enum Texels {
    /// 8-bit RGBA.
    Rgba8(Vec<[u8; 4]>),
    /// 16-bit RGBA.
    Rgba16(Vec<[u16; 4]>),
    /// Linear float RGB, of HDR images.
    Rgb32F(Vec<[f32; 3]>),
}

impl Texels {
    /// Number of texels.
    pub fn len(&self) -> usize {
        match self {
            Self::Rgba8(texels) => texels.len(),
            Self::Rgba16(texels) => texels.len(),
            Self::Rgb32F(texels) => texels.len(),
        }
    }

    /// Whether there are no texels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Longest side of an image: positions of texels are exact in f32 up to here.
const MAX_SIDE: usize = 1 << 20;

impl Bitmap {
    /// Checks that there is a texel for every place, and at least one.
    pub fn check(&self) -> Result<(), Invalid> {
        let Self { name, width, height, texels } = self;
        if !(1..=MAX_SIDE).contains(width) || !(1..=MAX_SIDE).contains(height) {
            let message = format!("image \"{name}\" is {width} × {height} pixels");
            return Err(Invalid::new("", message).help(format!("images have 1 to {MAX_SIDE} pixels per side")));
        }
        if texels.len() != width * height {
            let message = format!("image \"{name}\" holds {} pixels for {width} × {height}", texels.len());
            return Err(Invalid::new("", message).help("the file may be cut short; write it again"));
        }
        Ok(())
    }

    /// A texel as stored, 0–1 for integers: RGBA, row by row.
    pub fn linear_texel(&self, index: usize) -> [f32; 4] {
        self.mix_linear(&Taps::single(index)).to_array()
    }

    /// A texel with R, G, B decoded from sRGB, unless it is of floats.
    pub fn srgb_texel(&self, index: usize) -> [f32; 4] {
        self.mix_srgb(&Taps::single(index)).to_array()
    }

    /// Weighted sum of texels as stored.
    #[inline]
    pub(super) fn mix_linear(&self, taps: &Taps) -> Vec4 {
        match &self.texels {
            Texels::Rgba8(texels) => taps.mix(|i| Vec4::from_array(texels[i].map(f32::from))) * (1.0 / 255.0),
            Texels::Rgba16(texels) => taps.mix(|i| Vec4::from_array(texels[i].map(f32::from))) * (1.0 / 65535.0),
            Texels::Rgb32F(texels) => taps.mix(|i| opaque(texels[i])),
        }
    }

    /// Weighted sum of texels whose colours are decoded from sRGB first. Floats are linear already.
    #[inline]
    pub(super) fn mix_srgb(&self, taps: &Taps) -> Vec4 {
        match &self.texels {
            Texels::Rgba8(texels) => {
                let decode = decoded_8_bit();
                taps.mix(|i| {
                    let [r, g, b, a] = texels[i];
                    let [r, g, b] = [r, g, b].map(|v| decode[usize::from(v)]);
                    Vec4::new(r, g, b, f32::from(a) * (1.0 / 255.0))
                })
            }
            Texels::Rgba16(texels) => {
                let decode = decoded_16_bit();
                taps.mix(|i| {
                    let [r, g, b, a] = texels[i];
                    let [r, g, b] = [r, g, b].map(|v| decode[usize::from(v)]);
                    Vec4::new(r, g, b, f32::from(a) * (1.0 / 65535.0))
                })
            }
            Texels::Rgb32F(texels) => taps.mix(|i| opaque(texels[i])),
        }
    }
}

#[inline]
fn opaque([r, g, b]: [f32; 3]) -> Vec4 {
    Vec4::new(r, g, b, 1.0)
}

/// Linear value of every 8-bit sRGB code.
fn decoded_8_bit() -> &'static [f32; 256] {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|code| rgb::decode(code as f32 / 255.0)))
}

/// Linear value of every 16-bit sRGB code.
fn decoded_16_bit() -> &'static [f32; 65536] {
    static TABLE: OnceLock<Box<[f32; 65536]>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut table = Box::new([0.0; 65536]);
        for (code, value) in table.iter_mut().enumerate() {
            *value = rgb::decode(code as f32 / 65535.0);
        }
        table
    })
}
