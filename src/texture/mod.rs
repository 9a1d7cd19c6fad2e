//! Pictures on surfaces: bitmaps, wrap modes, filters, UV transforms.

use glam::Vec2;

/// A decoded picture of up to four channels.
#[derive(Clone, Debug)]
pub struct Bitmap {
    /// Where it came from, for messages.
    pub name: String,
    /// Columns.
    pub width: usize,
    /// Rows; the first is the top.
    pub height: usize,
    /// Texels.
    pub texels: Texels,
}

/// Texel storage, RGBA or RGB interleaved.
#[derive(Clone, Debug)]
pub enum Texels {
    /// 8-bit RGBA.
    Rgba8(Vec<[u8; 4]>),
    /// 16-bit RGBA.
    Rgba16(Vec<[u16; 4]>),
    /// Linear float RGB, of HDR pictures.
    Rgb32F(Vec<[f32; 3]>),
}

/// How texels are found and mixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerSettings {
    /// Wrap along u and v.
    pub wrap: [Wrap; 2],
    /// Interpolation between texels.
    pub filter: Filter,
}

impl Default for SamplerSettings {
    fn default() -> Self {
        Self { wrap: [Wrap::Repeat; 2], filter: Filter::Linear }
    }
}

/// What lies outside the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// The picture mirrored, then again.
    MirroredRepeat,
    /// The texels of the border.
    ClampToEdge,
}

/// Interpolation between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The texel that contains the point.
    Nearest,
    /// Bilinear between texel centres.
    Linear,
}

/// KHR_texture_transform: uv' = T·R·S·uv.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Offset after rotation and scaling.
    pub offset: Vec2,
    /// Rotation, rad, counter-clockwise as the extension defines it.
    pub rotation_rad: f32,
    /// Scale.
    pub scale: Vec2,
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_rad: 0.0, scale: Vec2::ONE }
    }
}
