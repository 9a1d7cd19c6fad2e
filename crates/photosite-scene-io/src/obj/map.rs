//! Options of the maps of an MTL file: `map_Kd -s 2 2 -mm 0 0.5 wood.png`.

use glam::Vec2;

use super::lines::{Statement, number};
use photosite_core::warnings::Warnings;
use photosite_core::{Invalid, Result};
use photosite_transport::texture::{SamplerSettings, UvTransform, Wrap};

/// A reference to an image.
#[derive(Clone, Debug)]
pub(super) struct Map {
    pub(super) file: String,
    pub(super) sampler: SamplerSettings,
    pub(super) transform: UvTransform,
    /// Channel (`-imfchan`) that counts where one number is wanted; by default the luminance.
    pub(super) channel: Option<MapChannel>,
    /// Range (`-mm`): the image's values v stand for base + gain·v.
    pub(super) range: Range,
    /// Factor of bumps (`-bm`).
    pub(super) bumps: f32,
    /// Line and keyword, for messages.
    pub(super) line: usize,
    pub(super) key: String,
}

/// Channel of a texel, where one number is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MapChannel {
    R,
    G,
    B,
    /// Matte channel: alpha.
    Matte,
    Luminance,
}

/// Mapping of an image's values v to base + gain·v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) base: f32,
    pub(super) gain: f32,
}

impl Range {
    /// Identity mapping.
    pub(super) const WHOLE: Self = Self { base: 0.0, gain: 1.0 };

    /// Mapped value, clamped to 0–1.
    pub(super) fn apply(self, value: f32) -> f32 {
        (self.base + self.gain * value).clamp(0.0, 1.0)
    }
}

/// Parses a file name behind its options.
pub(super) fn map(statement: &Statement<'_>, warnings: &mut Warnings) -> Result<Map, Invalid> {
    let mut left_out = |option: &str| {
        let (line, key) = (statement.line, statement.keyword());
        warnings.once(format!("line {line}: {key}: the option -{option} is not supported and is left out"));
    };
    let mut rest = statement.rest();
    let mut sampler = SamplerSettings::default();
    let (mut scale, mut offset) = (Vec2::ONE, Vec2::ZERO);
    let (mut channel, mut range, mut bumps) = (None, Range::WHOLE, 1.0);
    while let Some(option) = rest.strip_prefix('-') {
        let (option, mut after) = split_word(option);
        match option {
            "s" => (scale, after) = vector(after, 1.0),
            "o" => (offset, after) = vector(after, 0.0),
            "t" => {
                let turbulence;
                (turbulence, after) = vector(after, 0.0);
                if turbulence != Vec2::ZERO {
                    left_out(option);
                }
            }
            "mm" => {
                let (base, next) = split_word(after);
                let (gain, next) = split_word(next);
                range = Range { base: number(base)?, gain: number(gain)? };
                after = next;
            }
            "bm" => {
                let (word, next) = split_word(after);
                (bumps, after) = (number(word)?, next);
            }
            "imfchan" => {
                let (word, next) = split_word(after);
                match word {
                    "r" => channel = Some(MapChannel::R),
                    "g" => channel = Some(MapChannel::G),
                    "b" => channel = Some(MapChannel::B),
                    "m" => channel = Some(MapChannel::Matte),
                    "l" => channel = Some(MapChannel::Luminance),
                    // Depth, which images no longer have.
                    _ => left_out(option),
                }
                after = next;
            }
            "clamp" => {
                let (word, next) = split_word(after);
                if word == "on" {
                    sampler.wrap = [Wrap::ClampToEdge; 2];
                }
                after = next;
            }
            // Of rasterisers, which need to be told how to filter.
            "blendu" | "blendv" | "boost" | "texres" => after = split_word(after).1,
            "cc" | "type" | "colorspace" => {
                let (word, next) = split_word(after);
                if !matches!(word, "off" | "sRGB" | "srgb") {
                    left_out(option);
                }
                after = next;
            }
            // A file may be called anything, even this.
            _ => break,
        }
        rest = after;
    }
    if rest.is_empty() {
        return Err(Invalid::new("", "names no file"));
    }
    // OBJ scales and moves from the bottom of the image, glTF (v' = 1 − v) from its top:
    // 1 − (s·(1 − v') + o) = s·v' + (1 − s − o).
    let transform = UvTransform { offset: Vec2::new(offset.x, 1.0 - scale.y - offset.y), rotation_rad: 0.0, scale };
    let (line, key) = (statement.line, statement.keyword().to_owned());
    Ok(Map { file: rest.to_owned(), sampler, transform, channel, range, bumps, line, key })
}

/// Splits off the first word of a text.
fn split_word(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    (word, rest.trim_start())
}

/// One to three numbers and the text behind them; the third number, for solid textures, is ignored.
fn vector(text: &str, default: f32) -> (Vec2, &str) {
    let mut values = [default; 3];
    let mut rest = text;
    for value in &mut values {
        let (word, after) = split_word(rest);
        let Ok(parsed) = number(word) else { break };
        (*value, rest) = (parsed, after);
    }
    (Vec2::new(values[0], values[1]), rest)
}
