//! File of calibrations: its format, its cameras and their poses.

use std::path::{Path, PathBuf};

use photosite_core::{Error, Result};

use super::calibration::Calibration;
use super::tree::{Fault, Table};
use super::{colmap, euroc, kalibr, opencv, ros, xml, yaml};

/// File of poses beside COLMAP's `cameras.txt`.
const IMAGES: &str = "images.txt";

/// Formats of calibration files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Kalibr,
    OpenCv,
    Ros,
    Colmap,
    Euroc,
}

/// Endings of calibration files.
pub const ENDINGS: [&str; 5] = ["yaml", "yml", "xml", "json", "txt"];

/// Cameras of a calibration file.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFile {
    /// Cameras in the order of the file.
    pub cameras: Vec<Calibration>,
    format: Format,
}

impl CalibrationFile {
    /// Reads the text of a calibration file; `path` tells its format, and is named in errors.
    ///
    /// # Errors
    ///
    /// A file that is none of the formats; a key that is missing or has no such value, with its line; a model that
    /// photosite does not render.
    pub fn parse(text: &str, path: &Path) -> Result<Self> {
        parse(text, path).map(|(format, cameras)| Self { cameras, format }).map_err(|fault| placed(fault, path))
    }

    /// File that holds the poses of the cameras, where it is another one: COLMAP's `images.txt`.
    pub fn file_of_poses(&self, path: &Path) -> Option<PathBuf> {
        (self.format == Format::Colmap).then(|| path.with_file_name(IMAGES))
    }

    /// Adds poses from the text of [`file_of_poses`](Self::file_of_poses).
    ///
    /// # Errors
    ///
    /// A line that is no image, or one of a camera that there is not.
    pub fn add_poses(&mut self, text: &str, path: &Path) -> Result<()> {
        colmap::add_poses(&mut self.cameras, text).map_err(|fault| placed(fault, path))
    }
}

fn placed(fault: Fault, path: &Path) -> Error {
    match fault.line {
        Some(line) => fault.invalid.at_line(path, line),
        None => fault.invalid.in_file(path),
    }
}

fn is_colmap(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("txt"))
}

fn parse(text: &str, path: &Path) -> Result<(Format, Vec<Calibration>), Fault> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if ending == "bin" {
        let help = "write it as text: colmap model_converter --output_type TXT";
        return Err(Fault::of_file("COLMAP's binary models are not read").help(help));
    }
    if !ENDINGS.contains(&ending.as_str()) {
        return Err(Fault::of_file(format!("is no calibration that photosite reads: it ends in {ending:?}")).help(
            "give camchain.yaml of Kalibr, a .yaml, .yml, .xml or .json of OpenCV, camera_info of ROS, or cameras.txt of COLMAP",
        ));
    }
    if is_colmap(path) {
        return Ok((Format::Colmap, colmap::cameras(text)?));
    }
    let is_xml = text.trim_start().starts_with('<');
    let root = if is_xml { xml::parse(text)? } else { yaml::parse(text)? };
    let file = Table::of_file(&root)?;
    let format = format_of(&file)?;
    let cameras = match format {
        Format::Kalibr => kalibr::cameras(&file)?,
        Format::OpenCv => opencv::cameras(&file)?,
        Format::Ros => vec![ros::camera(&file)?],
        Format::Euroc => vec![euroc::camera(&file)?],
        Format::Colmap => Vec::new(),
    };
    Ok((format, cameras))
}

/// Format by the keys of a file.
fn format_of(file: &Table<'_>) -> Result<Format, Fault> {
    if file.items().any(|(name, item)| kalibr::is_camera(name, &item)) {
        return Ok(Format::Kalibr);
    }
    if file.has_any(&["T_BS"]) || (file.has_any(&["camera_model"]) && file.has_any(&["intrinsics"])) {
        return Ok(Format::Euroc);
    }
    if file.has_any(&ros::OWN_KEYS) || ros::has_model(file) {
        return Ok(Format::Ros);
    }
    if file.has_any(&opencv::MATRICES) || file.has_any(&["M1"]) {
        return Ok(Format::OpenCv);
    }
    Err(Fault::of_file("holds no camera that photosite knows").help(
        "Kalibr's files have cam0 with camera_model, OpenCV's and ROS' camera_matrix, and EuRoC's T_BS at the top",
    ))
}
