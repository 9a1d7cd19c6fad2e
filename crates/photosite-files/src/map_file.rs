//! Maps of depth or disparity, of this and other programs, in the format of the file name's extension.
//!
//! | file | holds | nothing is |
//! |---|---|---|
//! | EXR, one plane or a named one | 32-bit floats | ∞ as a depth, 0 as a disparity |
//! | NPY of floats, of shape (rows, columns); TIFF of 32-bit floats | the same | the same |
//! | NPY, TIFF and PNG of whole numbers of 8 or 16 bits, grey | codes, each a step more | 0 |
//!
//! OpenCV's matchers count disparities in 1/16 px, KITTI in 1/256 px.

use std::borrow::Cow;
use std::io;
use std::path::Path;

use super::exr::Attribute;
use super::formats::{FileImage, Format, PNG, Samples, lists::written};
use super::image_file::read_image_file;
use super::stated_colours::StatedColours;
use photosite_core::image::{Channel, Planes};
use photosite_core::output::Sink;
use photosite_core::{Invalid, Result};
use photosite_raw::Pixels;

/// Map of depth or disparity.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFile {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Values, row by row.
    pub values: Vec<f32>,
    /// Whether the values are codes, of which 0 means no value.
    pub is_codes: bool,
    /// Warnings about the file.
    pub warnings: Vec<String>,
}

impl MapFile {
    /// The map with each value replaced by `convert` of it (codes are multiplied by `step` first), and by `nothing`
    /// where that has none or a code is 0; also the number of the latter.
    pub fn converted(&self, step: f64, nothing: f32, convert: impl Fn(f64) -> Option<f64>) -> (Self, usize) {
        let scale = if self.is_codes { step } else { 1.0 };
        let of_value = |&value: &f32| {
            let is_something = !(self.is_codes && value == 0.0);
            is_something.then(|| convert(f64::from(value) * scale)).flatten()
        };
        let found: Vec<Option<f64>> = self.values.iter().map(of_value).collect();
        let without = found.iter().filter(|value| value.is_none()).count();
        let values = found.into_iter().map(|value| value.map_or(nothing, |value| value as f32)).collect();
        (Self { size: self.size, values, is_codes: false, warnings: Vec::new() }, without)
    }
}

/// Reads a map; `channel` chooses among several planes of an EXR file.
pub fn read_map(path: &Path, channel: Option<&str>) -> Result<MapFile> {
    let image = read_image_file(path, Pixels::Active)?.whole().map_err(|invalid| invalid.in_file(path))?;
    let (size, is_codes) = ([image.mean.width(), image.mean.height()], image.full_scale.is_some());
    let warnings = image.said().collect();
    let mut planes = image.mean.into_channels();
    let names = planes.iter().map(|plane| &plane.name[..]).collect::<Vec<_>>().join(", ");
    let refused = |message: String, help: &str| Invalid::new("", message).help(help).in_file(path);
    let found = match channel {
        Some(name) => planes.iter().position(|plane| plane.name == name),
        None => (planes.len() == 1).then_some(0),
    };
    let Some(index) = found else {
        return Err(match channel {
            Some(name) => refused(format!("has no plane {name}, but {names}"), "name one of them with --channel"),
            None => {
                refused(format!("has the planes {names}"), "choose one with --channel, or give a file of one plane")
            }
        });
    };
    Ok(MapFile { size, values: planes.swap_remove(index).data, is_codes, warnings })
}

/// Checks that maps can be written under that name.
pub fn check_map_name(path: &Path) -> Result<&'static Format> {
    written(path, |format| format.floats || *format == PNG, "a map that photosite can write")
}

/// Refuses a map whose values exceed the range of a PNG file of steps of that size.
pub fn check_map(format: &Format, values: &[f32], step: f64) -> Result<(), Invalid> {
    let most = f64::from(u16::MAX);
    let finite = || values.iter().map(|&value| f64::from(value)).filter(|value| value.is_finite());
    if format.floats || finite().all(|value| (-0.5..=most + 0.5).contains(&(value / step))) {
        return Ok(());
    }
    let (least, largest) = finite().fold((0.0, 0.0), |(low, high): (f64, f64), x| (low.min(x), high.max(x)));
    let message = format!("values from {least} to {largest} do not fit into 16 bits of steps of {step}");
    Err(Invalid::new("", message).help("make the steps larger, or write a .exr, .npy or .tiff file"))
}

/// Writes a map with its name and unit. PNG files hold whole steps of that size, at least 1 where there is a value.
pub fn write_map(
    format: &Format,
    map: &MapFile,
    name: &str,
    unit: &str,
    step: f64,
    to: &mut dyn Sink,
) -> io::Result<()> {
    let [width, height] = map.size;
    if format.floats {
        let channel = Channel { name: name.to_owned(), data: map.values.clone() };
        let planes = Planes::new(width, height, vec![channel]).map_err(io::Error::other)?;
        let description = format!("{name} in {unit}");
        let unit = StatedColours::of_exr([("unit", Attribute::Text(unit.to_owned()))]);
        let image = FileImage::of_planes(&planes);
        let image = FileImage { description: Some(description), colours: Cow::Owned(unit), ..image };
        return format.write(&image, to);
    }
    let code = |&value: &f32| match f64::from(value) {
        value if value.is_finite() && value != 0.0 => (value / step).round().max(1.0) as u16,
        _ => 0,
    };
    let codes = map.values.iter().map(code).collect();
    format.write(&FileImage::plain(map.size, 1, Samples::U16(codes)), to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::EXR;
    use photosite_core::output::write_whole;

    #[test]
    fn maps_come_back_from_every_kind_of_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let map = MapFile {
            size: [3, 2],
            values: vec![0.0, 0.25, 1.5, 3.0, 0.75, 12.25],
            is_codes: false,
            warnings: Vec::new(),
        };
        for (kind, step) in [("exr", 1.0), ("npy", 1.0), ("tiff", 1.0), ("png", 0.25)] {
            let path = folder.path().join(format!("map.{kind}"));
            let format = check_map_name(&path).expect("a map");
            check_map(format, &map.values, step).expect("room");
            write_whole(&path, |to| write_map(format, &map, "disparity", "px", step, to)).expect("written");
            let read = read_map(&path, None).expect("a map");
            assert_eq!((read.size, read.is_codes), (map.size, kind == "png"));
            let back: Vec<f32> = read.values.iter().map(|value| value * step as f32).collect();
            assert_eq!(back, map.values, "{kind}");
        }
        assert!(check_map(&PNG, &[17_000.0], 0.25).is_err());
        assert!(check_map(&PNG, &[-1.0], 0.25).is_err());
        assert!(check_map(&EXR, &[-1.0, 1e9], 0.25).is_ok());
        assert!(check_map_name("a.jpg".as_ref()).is_err());
    }
}
