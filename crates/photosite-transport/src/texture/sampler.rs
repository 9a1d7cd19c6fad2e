//! Texels that count at a point, with their weights: wrap modes and filters, as OpenGL and glTF define them.

use glam::{Vec2, Vec4};
use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings by which texels are found and interpolated.
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

/// Wrap mode: the continuation of the image beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Wrap {
    /// Image repeated.
    Repeat,
    /// Image mirrored, then repeated.
    #[serde(rename = "mirror")]
    MirroredRepeat,
    /// Border of the image.
    #[serde(rename = "clamp")]
    ClampToEdge,
}

/// Filter: the interpolation between texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
#[serde(rename_all = "kebab-case")]
pub enum Filter {
    /// Bilinear interpolation.
    Linear,
    /// The nearest texel.
    Nearest,
}

/// The four texels around a point, rows first, and where between them the point lies. A single texel is four times the
/// same.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taps {
    indices: [usize; 4],
    /// 0–1, from left to right and from top to bottom.
    within: Vec2,
}

impl Taps {
    /// Taps of one texel alone.
    pub(super) fn single(index: usize) -> Self {
        Self { indices: [index; 4], within: Vec2::ZERO }
    }

    /// Bilinear mean of `texel(index)`.
    #[inline]
    pub(super) fn mix(&self, texel: impl Fn(usize) -> Vec4) -> Vec4 {
        let [top_left, top_right, bottom_left, bottom_right] = self.indices;
        if top_left == bottom_right {
            return texel(top_left);
        }
        // In this form, unlike glam's `lerp`, the mean of equal texels is that texel to the last bit.
        let mean = |a: Vec4, b: Vec4, t: f32| a + (b - a) * t;
        let top = mean(texel(top_left), texel(top_right), self.within.x);
        let bottom = mean(texel(bottom_left), texel(bottom_right), self.within.x);
        mean(top, bottom, self.within.y)
    }
}

impl SamplerSettings {
    /// The texels at `uv` of an image of at least 1 × 1.
    #[inline]
    pub(super) fn taps(&self, uv: Vec2, width: usize, height: usize) -> Taps {
        let axis = |wrap: Wrap, u: f32, size: usize| match self.filter {
            Filter::Nearest => {
                let x = wrap.position(u, size).floor();
                let i = wrap.index(x as isize, size);
                (i, i, 0.0)
            }
            Filter::Linear => {
                // Texel i has its centre at i + ½.
                let x = wrap.position(u, size) - 0.5;
                let i = x.floor();
                (wrap.index(i as isize, size), wrap.index(i as isize + 1, size), x - i)
            }
        };
        let (left, right, x) = axis(self.wrap[0], uv.x, width);
        let (top, bottom, y) = axis(self.wrap[1], uv.y, height);
        let [top, bottom] = [top * width, bottom * width];
        Taps { indices: [top + left, top + right, bottom + left, bottom + right], within: Vec2::new(x, y) }
    }
}

impl Wrap {
    /// A coordinate in periods → one in texels, brought into the first period: 0 to `size`, or twice that where every
    /// second period is mirrored. Rounding may reach the upper end itself.
    #[inline]
    fn position(self, u: f32, size: usize) -> f32 {
        // What is no number has to be somewhere; infinities end up here as well, for inf − inf is NaN.
        let number = |u: f32| if u.is_nan() { 0.0 } else { u };
        match self {
            Self::Repeat => number(u - u.floor()) * size as f32,
            Self::MirroredRepeat => number(u - 2.0 * (0.5 * u).floor()) * size as f32,
            Self::ClampToEdge => number(u).clamp(0.0, 1.0) * size as f32,
        }
    }

    /// Index of a texel for a neighbour of the first period: −1 to `size`, or to twice `size` where mirrored.
    #[inline]
    fn index(self, i: isize, size: usize) -> usize {
        let n = size as isize;
        let wrapped = match self {
            Self::Repeat => {
                if i < 0 {
                    i + n
                } else if i >= n {
                    i - n
                } else {
                    i
                }
            }
            Self::MirroredRepeat => {
                // … 1 0 | 0 1 … n−1 | n−1 … 1 0 | 0 …
                let i = if i < 0 { -1 - i } else { i };
                if i < n { i } else { (2 * n - 1 - i).max(0) }
            }
            Self::ClampToEdge => i.clamp(0, n - 1),
        };
        wrapped as usize
    }
}
