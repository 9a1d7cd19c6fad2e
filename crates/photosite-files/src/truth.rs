//! Files of ground truth: all layers in one OpenEXR file, or each as a NumPy array or a 16-bit PNG file.
//!
//! | layer | EXR, 32-bit floats | NPY | PNG, 16 bits |
//! |---|---|---|---|
//! | depth, distance | m, ∞ for nothing | `float32` | in a unit of choice, 0 for nothing |
//! | position, uv, object-position | NaN for nothing | `float32` | – |
//! | normal, shading-normal | −1 … 1, zeros for nothing | `float32` | (n + 1)/2 · 65535, zeros for nothing |
//! | nocs | 0 … 1, zeros for nothing | `float32` | 65535 for 1, zeros for nothing |
//! | albedo | linear sRGB | `float32` | 65535 for white, linear, kept within |
//! | instance, material | 0 for nothing | `uint32` | 0 for nothing |
//! | flow | x, y, visible | `float32` | 64·x + 2¹⁵, 64·y + 2¹⁵, visible (KITTI's); zeros beyond ±512 px |
//! | disparity | x, y, visible | `float32` | 256·x where it is visible, at least 1; 0 elsewhere (KITTI's) |

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use photosite_core::keys::Keys;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use photosite_calibration::truth::{PngRule, TruthLayer, Values};
use photosite_core::Invalid;
use photosite_core::image::{Channel, Planes};

use super::exr::{self, Attribute, write_exr_of};
use super::formats::{FileImage, Samples, png};
use super::npy::write_planes;

/// The largest number of 16 bits.
const LARGEST: f64 = u16::MAX as f64;

/// Format of files of ground truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema, Keys)]
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
        if (self, layer.png()) != (Self::Png, PngRule::None) {
            return Ok(());
        }
        let message = format!("16-bit PNG files have no room for {}", layer.name());
        Err(Invalid::new("truth_formats", message).help("write \"exr\" or \"npy\", or leave that layer out"))
    }
}

/// Planes of each layer, in the order of its channels; planes of other names by themselves.
pub fn by_layer(planes: Planes) -> BTreeMap<String, Planes> {
    let [width, height] = [planes.width(), planes.height()];
    let layer_of = |name: &str| TruthLayer::ALL.into_iter().find(|layer| layer.channels().contains(&name));
    let place = |name: &str| layer_of(name)?.channels().iter().position(|known| *known == name);
    let mut layers: BTreeMap<String, Vec<Channel>> = BTreeMap::new();
    for channel in planes.into_channels() {
        let name = layer_of(&channel.name).map_or_else(|| channel.name.clone(), |layer| layer.name().to_owned());
        layers.entry(name).or_default().push(channel);
    }
    let together = |(name, mut channels): (String, Vec<Channel>)| {
        channels.sort_by_key(|channel| place(&channel.name));
        (name, Planes::new(width, height, channels).expect("planes of one image"))
    };
    layers.into_iter().map(together).collect()
}

/// Whether all depths and distances fit into 16 bits of `depth_unit_m`, and all disparities into those of KITTI's,
/// which are along x alone.
pub fn fits_png(truth: &Planes, depth_unit_m: f64) -> Result<(), Invalid> {
    for layer in kept_as(PngRule::Length) {
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
    // Half a step more, as numbers are rounded; rows that lie less than half a pixel apart are the same.
    let held = -0.5 / DISPARITY_STEPS..=(LARGEST + 0.5) / DISPARITY_STEPS;
    let is_held = |[x, y]: &[f64; 2]| held.contains(x) && y.abs() <= x.abs().max(0.5);
    let wrong = visible(truth, PngRule::Disparity).find(|way| !is_held(way));
    if let Some([x, y]) = wrong {
        let most = LARGEST / DISPARITY_STEPS;
        let message = format!(
            "a disparity of {x:.1}, {y:.1} px cannot be stored in PNG files, which hold those along x from 0 to {most:.1} px"
        );
        let help = "write \"exr\" or \"npy\", or put the cameras side by side, looking the same way";
        return Err(Invalid::new("truth_formats", message).help(help));
    }
    Ok(())
}

/// Steps of a PNG file's disparity in a pixel, and of its flow.
const DISPARITY_STEPS: f64 = 256.0;
const FLOW_STEPS: f64 = 64.0;

/// The layers that PNG files keep by a rule.
fn kept_as(rule: PngRule) -> impl Iterator<Item = TruthLayer> {
    TruthLayer::ALL.into_iter().filter(move |layer| layer.png() == rule)
}

/// Components x and y of the ways to another image that are visible there, px, of the layers of a rule.
fn visible(truth: &Planes, rule: PngRule) -> impl Iterator<Item = [f64; 2]> {
    let of_layer = |layer: TruthLayer| {
        let planes: Vec<&[f32]> = layer.channels().iter().filter_map(|name| truth.plane(name)).collect();
        let count = planes.first().map_or(0, |plane| plane.len());
        (0..count).map(move |i| [0, 1, 2].map(|c| f64::from(planes[c][i])))
    };
    kept_as(rule).flat_map(of_layer).filter(|[.., visible]| *visible > 0.0).map(|[x, y, _]| [x, y])
}

/// Warnings about displacements that PNG files hold in part, or not at all.
pub fn lost_in_png(truth: &Planes) -> Vec<String> {
    let mut lost = Vec::new();
    let aside = visible(truth, PngRule::Disparity).map(|[_, y]| y.abs()).fold(0.0, f64::max);
    if aside > 0.5 {
        lost.push(format!(
            "PNG files hold disparity along x alone, and here it reaches {aside:.1} px along y: \"exr\" and \"npy\" hold both"
        ));
    }
    let beyond = visible(truth, PngRule::Flow).filter(|&[x, y]| flow_code(x).and(flow_code(y)).is_none()).count();
    if beyond > 0 {
        lost.push(format!(
            "flow beyond ±512 px is marked as invalid in PNG files, here in {beyond} pixels: \"exr\" and \"npy\" hold it"
        ));
    }
    lost
}

/// The number that stands for flow along an axis, if there is one.
fn flow_code(px: f64) -> Option<u16> {
    let code = (px * FLOW_STEPS).round() + 32768.0;
    (1.0..=LARGEST).contains(&code).then_some(code as u16)
}

/// Writes all layers as one OpenEXR file.
pub fn write_truth_exr<W: Write + Seek>(truth: &Planes, to: W) -> io::Result<()> {
    let mut of_units: Vec<(&str, Vec<&str>)> = Vec::new();
    for layer in TruthLayer::ALL.into_iter().filter(|layer| !layer.unit().is_empty()) {
        match of_units.iter_mut().find(|(unit, _)| *unit == layer.unit()) {
            Some((_, names)) => names.push(layer.name()),
            None => of_units.push((layer.unit(), vec![layer.name()])),
        }
    }
    let mut unit: String = of_units.iter().map(|(unit, names)| format!("{}: {unit}; ", names.join(", "))).collect();
    unit += "position, normals: world axes, x right, y up; object-position, nocs: axes of the object";
    write_exr_of(exr::Values::Smooth, truth, &[("unit", Attribute::Text(unit))], to)
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
    match layer.values() {
        Values::Index => write_planes(size, &planes, |id| id as u32, to),
        Values::Real => write_planes(size, &planes, |value| value, to),
    }
}

/// Writes a layer as a PNG file of one or three 16-bit numbers a pixel; depths and distances are in units of
/// `depth_unit_m`.
pub fn write_truth_png<W: Write>(truth: &Planes, layer: TruthLayer, depth_unit_m: f64, to: W) -> io::Result<()> {
    let planes = planes_of(truth, layer)?;
    let count = if layer.png() == PngRule::Disparity { 1 } else { planes.len() };
    let mut values = Vec::with_capacity(count * truth.width() * truth.height());
    for i in 0..truth.width() * truth.height() {
        let of_pixel = [0, 1, 2].map(|c| f64::from(planes.get(c).map_or(0.0, |plane| plane[i])));
        values.extend(&codes(layer, of_pixel, depth_unit_m)?[..count]);
    }
    png::write(&FileImage::plain([truth.width(), truth.height()], count, Samples::U16(values.into())), to)
}

/// Codes of a pixel's values, 16 bits each.
fn codes(layer: TruthLayer, values: [f64; 3], depth_unit_m: f64) -> io::Result<[u16; 3]> {
    // Casting rounds off and keeps within the range of the type.
    let code = |value: f64| value.round() as u16;
    match layer.png() {
        PngRule::Length if values[0].is_infinite() => Ok([0; 3]),
        PngRule::Length => {
            let units = values[0] / depth_unit_m;
            if units > LARGEST {
                return Err(io::Error::other(format!("{} m do not fit into 16 bits", values[0])));
            }
            // 0 is for nothing.
            Ok([code(units).max(1), 0, 0])
        }
        PngRule::Index if values[0] > LARGEST => {
            let name = layer.name();
            Err(io::Error::other(format!("{} {name}s are more than 16 bits tell apart: write \"exr\"", values[0])))
        }
        PngRule::Index => Ok([code(values[0]), 0, 0]),
        PngRule::Direction if values == [0.0; 3] => Ok([0; 3]),
        PngRule::Direction => Ok(values.map(|n| code((n + 1.0) / 2.0 * LARGEST))),
        PngRule::Part => Ok(values.map(|part| code(part * LARGEST))),
        PngRule::Flow => Ok(match (flow_code(values[0]), flow_code(values[1])) {
            (Some(x), Some(y)) => [x, y, code(values[2])],
            (None, _) | (_, None) => [0; 3],
        }),
        PngRule::Disparity if values[2] > 0.0 => Ok([code(values[0] * DISPARITY_STEPS).max(1), 0, 0]),
        PngRule::Disparity => Ok([0; 3]),
        PngRule::None => Err(io::Error::other("PNG files have no room for it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;

    #[test]
    fn layers_have_their_channels_in_order() {
        // As a file has them, sorted by name.
        let mut planes = Planes::zeros(1, 1, ["depth", "flow.X", "flow.Y", "flow.visible", "other.X", "uv.U", "uv.V"]);
        planes.channels_mut().iter_mut().enumerate().for_each(|(i, channel)| channel.data[0] = i as f32);
        let layers = by_layer(planes);
        let names = |planes: &Planes| planes.channels().iter().map(|c| (c.name.clone(), c.data[0])).collect::<Vec<_>>();
        let named = |names: &[(&str, f32)]| names.iter().map(|&(name, x)| (name.to_owned(), x)).collect::<Vec<_>>();
        assert_eq!(layers.keys().collect::<Vec<_>>(), ["depth", "flow", "other.X", "uv"]);
        assert_eq!(names(&layers["flow"]), named(&[("flow.X", 1.0), ("flow.Y", 2.0), ("flow.visible", 3.0)]));
        assert_eq!(names(&layers["uv"]), named(&[("uv.U", 5.0), ("uv.V", 6.0)]));
    }

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

    fn disparities(values: &[[f32; 3]]) -> Planes {
        let plane = |c: usize| Channel {
            name: TruthLayer::Disparity.channels()[c].to_owned(),
            data: values.iter().map(|value| value[c]).collect(),
        };
        Planes::new(values.len(), 1, [0, 1, 2].map(plane).to_vec()).expect("planes")
    }

    #[test]
    fn disparities_are_those_of_kitti_or_refused() {
        // The development kit: d = I/256, 0 where there is none.
        let code = |x, visible| codes(TruthLayer::Disparity, [x, 0.0, visible], 1e-3).map(|[code, ..]| code).ok();
        assert_eq!(code(12.5, 1.0), Some(3200));
        assert_eq!(code(12.5, 0.0), Some(0));
        assert_eq!(code(1e-4, 1.0), Some(1), "far away, but there");
        let fits = |values: &[[f32; 3]]| fits_png(&disparities(values), 1e-3);
        assert!(fits(&[[0.0, 0.0, 1.0], [255.9, 0.4, 1.0], [-9.0, 0.0, 0.0], [300.0, 300.0, 0.0]]).is_ok());
        for wrong in [[-0.1, 0.0, 1.0], [256.1, 0.0, 1.0], [0.0, 3.0, 1.0], [2.0, -3.0, 1.0]] {
            assert_eq!(fits(&[wrong]).expect_err("refused").key, "truth_formats", "{wrong:?}");
        }
        assert!(lost_in_png(&disparities(&[[9.0, 0.4, 1.0], [9.0, 2.0, 0.0]])).is_empty());
        let lost = lost_in_png(&disparities(&[[9.0, 0.4, 1.0], [9.0, -2.25, 1.0]]));
        assert!(lost.len() == 1 && lost[0].contains("2.2 px along y"), "{lost:?}");
    }
}
