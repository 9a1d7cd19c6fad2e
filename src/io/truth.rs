//! Ground truth as files: all layers in one OpenEXR file, or each as a NumPy array or a 16-bit PNG file.
//!
//! | layer | EXR, 32-bit floats | NPY | PNG, 16 bits |
//! |---|---|---|---|
//! | depth, distance | m, ∞ for nothing | `float32` | in a unit of choice, 0 for nothing |
//! | position, uv | NaN for nothing | `float32` | – |
//! | normal, shading-normal | −1 … 1, zeros for nothing | `float32` | (n + 1)/2 · 65535, zeros for nothing |
//! | albedo | linear sRGB | `float32` | 65535 for white, linear, kept within |
//! | instance, material | 0 for nothing | `uint32` | 0 for nothing |
//! | flow | x, y, visible | `float32` | 64·x + 2¹⁵, 64·y + 2¹⁵, visible (KITTI's) |
//! | disparity | x, y, visible | `float32` | 256·x where it is visible, 0 elsewhere (KITTI's) |

use std::io::{self, Seek, Write};

use png::{BitDepth, ColorType};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::Invalid;
use crate::calibration::truth::TruthLayer;
use crate::image::Planes;

use super::exr::{Attribute, write_exr};
use super::npy::write_planes;
use super::plain_png::write_png_of_numbers;

/// The largest number of 16 bits.
const LARGEST: f64 = u16::MAX as f64;

/// How ground truth is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TruthFormat {
    /// One OpenEXR file of all layers.
    Exr,
    /// A NumPy array for each layer.
    Npy,
    /// A 16-bit PNG file for each layer.
    Png,
}

impl TruthFormat {
    /// Whether the format can hold a layer.
    pub fn check(self, layer: TruthLayer) -> Result<(), Invalid> {
        match (self, layer) {
            (Self::Png, TruthLayer::Position | TruthLayer::Uv) => {
                let message = format!("16-bit PNG files have no room for {}", layer.name());
                Err(Invalid::new("truth_formats", message).help("write \"exr\" or \"npy\", or leave that layer out"))
            }
            (Self::Exr | Self::Npy | Self::Png, _) => Ok(()),
        }
    }
}

/// Whether all depths and distances fit into 16 bits of `depth_unit_m`.
pub fn fits_png(truth: &Planes, depth_unit_m: f64) -> Result<(), Invalid> {
    for layer in [TruthLayer::Depth, TruthLayer::Distance] {
        let finite = truth.plane(layer.name()).into_iter().flatten().filter(|m| m.is_finite());
        let largest = f64::from(finite.copied().fold(0.0, f32::max));
        if largest / depth_unit_m > LARGEST {
            let (name, unit_mm) = (layer.name(), depth_unit_m * 1e3);
            let message = format!("a {name} of {largest} m does not fit into 16 bits of {unit_mm} mm");
            let least = largest / LARGEST * 1e3;
            let help = format!("write at least {least:.3}, or truth_formats = [\"exr\"] or [\"npy\"]");
            return Err(Invalid::new("truth_depth_unit_mm", message).help(help));
        }
    }
    Ok(())
}

/// Writes all layers as one OpenEXR file.
pub fn write_truth_exr<W: Write + Seek>(truth: &Planes, to: W) -> io::Result<()> {
    let unit = "depth, distance, position: m; flow, disparity: px; position, normals: world axes, x right, y up";
    write_exr(truth, &[("unit", Attribute::Text(unit.to_owned()))], to)
}

/// The planes of a layer.
fn planes_of(truth: &Planes, layer: TruthLayer) -> io::Result<Vec<&[f32]>> {
    let plane = |name: &&str| truth.plane(name).ok_or_else(|| io::Error::other(format!("there is no plane {name}")));
    layer.channels().iter().map(plane).collect()
}

/// Writes a layer as an array of shape (rows, columns), or (rows, columns, values) where a pixel has several.
pub fn write_truth_npy<W: Write>(truth: &Planes, layer: TruthLayer, to: W) -> io::Result<()> {
    let planes = planes_of(truth, layer)?;
    let size = [truth.width(), truth.height()];
    match layer {
        TruthLayer::Instance | TruthLayer::Material => write_planes(size, &planes, |id| id as u32, to),
        TruthLayer::Depth
        | TruthLayer::Distance
        | TruthLayer::Position
        | TruthLayer::Normal
        | TruthLayer::ShadingNormal
        | TruthLayer::Uv
        | TruthLayer::Albedo
        | TruthLayer::Flow
        | TruthLayer::Disparity => write_planes(size, &planes, |value| value, to),
    }
}

/// Writes a layer as a PNG file of one or three 16-bit numbers a pixel; depths and distances are in units of
/// `depth_unit_m`.
pub fn write_truth_png<W: Write>(truth: &Planes, layer: TruthLayer, depth_unit_m: f64, to: W) -> io::Result<()> {
    let planes = planes_of(truth, layer)?;
    let side = |n: usize| u32::try_from(n).map_err(io::Error::other);
    let size = [side(truth.width())?, side(truth.height())?];
    let count = if layer == TruthLayer::Disparity { 1 } else { planes.len() };
    let kind = if count == 1 { ColorType::Grayscale } else { ColorType::Rgb };
    let mut bytes = Vec::with_capacity(2 * count * truth.width() * truth.height());
    for i in 0..truth.width() * truth.height() {
        let values = [0, 1, 2].map(|c| f64::from(planes.get(c).map_or(0.0, |plane| plane[i])));
        let codes = codes(layer, values, depth_unit_m)?;
        codes[..count].iter().for_each(|code| bytes.extend(code.to_be_bytes()));
    }
    write_png_of_numbers(size, kind, BitDepth::Sixteen, &bytes, to)
}

/// The numbers that stand for a pixel's values.
fn codes(layer: TruthLayer, values: [f64; 3], depth_unit_m: f64) -> io::Result<[u16; 3]> {
    // Casting rounds off and keeps within the range of the type.
    let code = |value: f64| value.round() as u16;
    match layer {
        TruthLayer::Depth | TruthLayer::Distance if values[0].is_infinite() => Ok([0; 3]),
        TruthLayer::Depth | TruthLayer::Distance => {
            let units = values[0] / depth_unit_m;
            if units > LARGEST {
                return Err(io::Error::other(format!("{} m do not fit into 16 bits", values[0])));
            }
            // 0 is for nothing.
            Ok([code(units).max(1), 0, 0])
        }
        TruthLayer::Instance | TruthLayer::Material if values[0] > LARGEST => {
            let name = layer.name();
            Err(io::Error::other(format!("{} {name}s are more than 16 bits tell apart: write \"exr\"", values[0])))
        }
        TruthLayer::Instance | TruthLayer::Material => Ok([code(values[0]), 0, 0]),
        TruthLayer::Normal | TruthLayer::ShadingNormal if values == [0.0; 3] => Ok([0; 3]),
        TruthLayer::Normal | TruthLayer::ShadingNormal => Ok(values.map(|n| code((n + 1.0) / 2.0 * LARGEST))),
        TruthLayer::Albedo => Ok(values.map(|part| code(part * LARGEST))),
        TruthLayer::Flow => {
            let [x, y] = [0, 1].map(|axis| (values[axis] * 64.0).round() + 32768.0);
            let fits = [x, y].iter().all(|code| (1.0..=LARGEST).contains(code));
            Ok(if fits { [x as u16, y as u16, code(values[2])] } else { [0; 3] })
        }
        TruthLayer::Disparity => {
            let units = (values[0] * 256.0).round();
            let fits = values[2] > 0.0 && (1.0..=LARGEST).contains(&units);
            Ok([if fits { units as u16 } else { 0 }, 0, 0])
        }
        TruthLayer::Position | TruthLayer::Uv => Err(io::Error::other("PNG files have no room for it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_are_whole_units_and_nothing_is_zero() {
        let depth = |m: f64, unit: f64| codes(TruthLayer::Depth, [m, 0.0, 0.0], unit).map(|[code, ..]| code).ok();
        assert_eq!(depth(1.2344, 1e-3), Some(1234));
        assert_eq!(depth(1.2344, 1e-4), Some(12344));
        assert_eq!(depth(f64::INFINITY, 1e-3), Some(0));
        assert_eq!(depth(1e-5, 1e-3), Some(1));
        assert_eq!(depth(65.6, 1e-3), None);
    }

    #[test]
    fn flow_is_that_of_kitti() {
        // The development kit of the benchmark: u = (I − 2¹⁵)/64, and the third number says whether there is any.
        let flow = |x, y, visible| codes(TruthLayer::Flow, [x, y, visible], 1e-3).ok();
        assert_eq!(flow(0.0, -1.0, 1.0), Some([32768, 32704, 1]));
        assert_eq!(flow(511.0, 2.0, 0.0), Some([65472, 32896, 0]));
        assert_eq!(flow(600.0, 2.0, 1.0), Some([0; 3]));
    }
}
