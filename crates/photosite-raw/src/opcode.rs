//! Opcodes of DNG files that change pixel values ([Dng16](photosite_core::references#dng16), chapter 7).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::warp::offset;
use super::{AreaSpec, GainMap, PixelArea};

/// Largest value of stored pixels, on which opcodes' tables and deltas are scaled.
const LARGEST: f32 = 65_535.0;

/// A change of pixel values that a file asks for. Those of OpcodeList1 apply to stored values of the whole image, those
/// of OpcodeList2 to linear values of the active area with black at 0 and white at 1, those of OpcodeList3 to the
/// demosaicked image.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Opcode {
    /// Gain 1 + k₀r² + k₁r⁴ + k₂r⁶ + k₃r⁸ + k₄r¹⁰ with the distance r from the centre, 1 at the farthest corner. The
    /// centre is 0, 0 at the top-left pixel and 1, 1 at the opposite one.
    FixVignetteRadial {
        /// k₀ … k₄.
        k: [f64; 5],
        /// The centre.
        centre: [f64; 2],
    },
    /// Defective pixels: those of this stored value.
    FixBadPixelsConstant(u32),
    /// Defective pixels, one by one and in rectangles.
    FixBadPixelsList(Vec<PixelArea>),
    /// Table of 16-bit values, the last of which stands for all beyond.
    MapTable(AreaSpec, Vec<u16>),
    /// Polynomial with these coefficients, that of the constant first.
    MapPolynomial(AreaSpec, Vec<f64>),
    /// Gains on a grid.
    GainMap(GainMap),
    /// A value for each row or column.
    PerLine(AreaSpec, PerLine, Vec<f32>),
}

/// Operation that changes pixel values row by row or column by column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PerLine {
    /// Sum with the row's value, in steps of 16 bits.
    DeltaPerRow,
    /// Sum with the column's value, in steps of 16 bits.
    DeltaPerColumn,
    /// Product with the row's value.
    ScalePerRow,
    /// Product with the column's value.
    ScalePerColumn,
}

impl PerLine {
    /// Rows, or columns, of an area.
    pub fn lines(self, area: &AreaSpec) -> usize {
        match self {
            Self::DeltaPerRow | Self::ScalePerRow => area.area.height.div_ceil(area.pitch[1].max(1)),
            Self::DeltaPerColumn | Self::ScalePerColumn => area.area.width.div_ceil(area.pitch[0].max(1)),
        }
    }
}

/// Layout of the pixel values that opcodes change.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Values of each pixel, one beside the other.
    pub samples: usize,
    /// Index of the plane that the first value of each pixel belongs to.
    pub plane: usize,
    /// Width of a pixel over its height.
    pub aspect: f64,
    /// Whether values are stored ones of up to 16 bits, not linear ones with white at 1.
    pub is_stored: bool,
}

impl Frame {
    /// Place of the centre of a column (axis 0) or a row (axis 1), from 0 at the first edge to 1 at the opposite one.
    #[inline]
    pub fn place(&self, axis: usize, index: usize) -> f64 {
        (index as f64 + 0.5) / self.size[axis] as f64
    }
}

impl Opcode {
    /// Whether the opcode corrects the lens's falloff.
    pub fn is_of_falloff(&self) -> bool {
        matches!(self, Self::FixVignetteRadial { .. } | Self::GainMap(_))
    }

    /// Area of values that the opcode changes; `None` for all.
    fn area(&self) -> Option<&AreaSpec> {
        match self {
            Self::MapTable(area, _) | Self::MapPolynomial(area, _) | Self::PerLine(area, ..) => Some(area),
            Self::GainMap(map) => map.reach().map(|reach| &reach.pixels),
            Self::FixVignetteRadial { .. } | Self::FixBadPixelsConstant(_) | Self::FixBadPixelsList(_) => None,
        }
    }

    /// Changes the values of an image, row by row. Those of defective pixels need their neighbours and stay.
    pub fn apply(&self, values: &mut [f32], frame: &Frame) {
        if matches!(self, Self::FixBadPixelsConstant(_) | Self::FixBadPixelsList(_)) {
            return;
        }
        let area = self.area();
        let rows = values.par_chunks_mut((frame.size[0] * frame.samples).max(1)).enumerate();
        rows.filter(|(y, _)| area.is_none_or(|area| area.has_row(*y))).for_each(|(y, row)| {
            for (i, value) in row.iter_mut().enumerate() {
                let (x, plane) = (i / frame.samples, frame.plane + i % frame.samples);
                if area.is_none_or(|area| area.has_number(x, plane)) {
                    *value = self.changed(*value, [x, y], plane, frame);
                }
            }
        });
    }

    /// The value that takes the place of one of a plane at a pixel.
    fn changed(&self, value: f32, [x, y]: [usize; 2], plane: usize, frame: &Frame) -> f32 {
        let white = if frame.is_stored { LARGEST } else { 1.0 };
        // Noise below black and what is above white keep their distance from the curve's ends.
        let by_curve = |curve: &dyn Fn(f32) -> f32| {
            let inside = value.clamp(0.0, white);
            curve(inside) + (value - inside)
        };
        match self {
            Self::FixVignetteRadial { k, centre } => {
                let [dx, dy] = offset(*centre, [x as f64, y as f64], frame.size, frame.aspect);
                let r2 = dx * dx + dy * dy;
                value * (1.0 + r2 * k.iter().rev().fold(0.0, |sum, k| sum * r2 + k)) as f32
            }
            Self::MapTable(_, table) => by_curve(&|value| {
                let at = (value * (LARGEST / white) + 0.5) as usize;
                f32::from(table.get(at).or(table.last()).copied().unwrap_or(0)) * (white / LARGEST)
            }),
            Self::MapPolynomial(_, coefficients) => {
                let polynomial = |x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
                by_curve(&|value| (polynomial(value.into()) as f32).clamp(0.0, white))
            }
            Self::GainMap(map) => value * map.at_plane(frame.place(0, x), frame.place(1, y), plane),
            Self::PerLine(area, what, lines) => {
                let line = match what {
                    PerLine::DeltaPerRow | PerLine::ScalePerRow => (y - area.area.y) / area.pitch[1],
                    PerLine::DeltaPerColumn | PerLine::ScalePerColumn => (x - area.area.x) / area.pitch[0],
                };
                match (what, lines.get(line)) {
                    (PerLine::DeltaPerRow | PerLine::DeltaPerColumn, Some(delta)) => value + delta * (white / LARGEST),
                    (PerLine::ScalePerRow | PerLine::ScalePerColumn, Some(scale)) => value * scale,
                    (_, None) => value,
                }
            }
            Self::FixBadPixelsConstant(_) | Self::FixBadPixelsList(_) => value,
        }
    }
}
