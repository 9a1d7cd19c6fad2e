//! Calibration targets as files: for the printer (SVG, PDF), for other programs (OBJ with MTL, JSON of the points), and
//! as a capture file that photographs them (TOML).

use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use photosite_calibration::targets::{Target, TargetDescription, print};
use photosite_core::output::write_whole;
use photosite_core::{Error, Result};
use photosite_sensor::presets;

/// File format of a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Svg,
    Pdf,
    Obj,
    Json,
    Toml,
}

/// Formats by extension.
const FORMATS: [(&str, Format); 5] =
    [("svg", Format::Svg), ("pdf", Format::Pdf), ("obj", Format::Obj), ("json", Format::Json), ("toml", Format::Toml)];

/// Files that [`write_target`] would write for a path; an error where its extension is unknown.
pub fn target_files(path: &Path) -> Result<Vec<PathBuf>> {
    Ok(match format(path)? {
        // What the other file refers to comes first.
        Format::Obj => vec![path.with_extension("mtl"), path.to_owned()],
        Format::Svg | Format::Pdf | Format::Json | Format::Toml => vec![path.to_owned()],
    })
}

/// Writes a target in the format of the extension.
pub fn write_target(path: &Path, description: &TargetDescription, target: &Target) -> Result<()> {
    let name = description.kind().name();
    let text = |path: &Path, text: String| write_whole(path, |to| to.write_all(text.as_bytes()));
    match format(path)? {
        Format::Svg => text(path, print::svg(target, name)),
        Format::Pdf => {
            let bytes = print::pdf(target, name).map_err(|invalid| invalid.in_file(path))?;
            write_whole(path, |to| to.write_all(&bytes))
        }
        Format::Json => text(path, format!("{:#}\n", json!(TargetFacts::new(description, target)))),
        Format::Toml => text(path, capture(description, target)),
        Format::Obj => {
            let library = path.with_extension("mtl");
            text(&library, mtl(target, name))?;
            let library = library.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            text(path, obj(target, name, &library))
        }
    }
}

fn format(path: &Path) -> Result<Format> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    let format = FORMATS.iter().find(|(known, _)| extension.as_deref() == Some(*known));
    format.map(|(_, format)| *format).ok_or_else(|| Error::Usage {
        message: format!("{} does not tell which format to write the target in", path.display()),
        help: Some("end the name in .svg or .pdf (to print), .toml (a capture), .obj or .json (its points)".into()),
    })
}

/// Facts about a target in its own frame (x right, y down, z into the sheet).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct TargetFacts {
    /// Keys of the target.
    pub target: TargetDescription,
    /// Top-left and bottom-right corner of the sheet, mm.
    pub sheet_mm: [[f64; 2]; 2],
    /// Points of the target, in OpenCV's order.
    pub points: Vec<PointFacts>,
    /// Markers of the target.
    pub markers: Vec<MarkerFacts>,
}

/// A point of a target.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct PointFacts {
    /// Name of the point.
    pub name: String,
    /// Position on the sheet, mm.
    pub xy_mm: [f64; 2],
}

/// A marker of a target.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
pub struct MarkerFacts {
    /// Dictionary that the marker's pattern is from.
    pub dictionary: String,
    /// Number of the marker in its dictionary.
    pub id: u32,
    /// Corners of the marker on the sheet, in OpenCV's order, mm.
    pub corners_xy_mm: [[f64; 2]; 4],
}

impl TargetFacts {
    /// Facts about the target of that description.
    pub fn new(description: &TargetDescription, target: &Target) -> Self {
        let millimetres = |p: DVec2| p.to_array().map(|x| (x * 1e9).round() / 1e6 + 0.0);
        let points = target.points.iter();
        let points = points.map(|point| PointFacts { name: point.name.clone(), xy_mm: millimetres(point.position_m) });
        let markers = target.markers.iter().map(|marker| MarkerFacts {
            dictionary: marker.dictionary.to_string(),
            id: marker.id,
            corners_xy_mm: marker.corners_m.map(millimetres),
        });
        Self {
            target: description.clone(),
            sheet_mm: target.sheet.map(millimetres),
            points: points.collect(),
            markers: markers.collect(),
        }
    }
}

/// MTL file: linear sRGB for programs that know no spectra.
fn mtl(target: &Target, name: &str) -> String {
    let mut text = "# Lambertian inks, linear sRGB under D65\n".to_owned();
    for ink in &target.inks {
        let [r, g, b] = ink.linear_srgb();
        let _ = writeln!(text, "newmtl {name}-{}\nKd {r:.5} {g:.5} {b:.5}", ink.name);
    }
    text
}

/// OBJ file: metres, y up; the front looks along +z.
fn obj(target: &Target, name: &str, library: &str) -> String {
    let mut text = format!("# {name}: metres, the front looks along +z\nmtllib {library}\no {name}\n");
    let mut first = 1;
    for (material, mesh) in target.meshes(name) {
        for position in &mesh.positions {
            let _ = writeln!(text, "v {} {} 0", position.x, 0.0 - position.y);
        }
        for uv in &mesh.uvs[0] {
            // OBJ's v points up.
            let _ = writeln!(text, "vt {} {}", uv.x, 1.0 - uv.y);
        }
        let _ = writeln!(text, "usemtl {}", material.name);
        for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)) {
            let _ = writeln!(text, "f {a}/{a} {b}/{b} {c}/{c}");
        }
        first += mesh.positions.len() as u32;
    }
    text
}

/// Focal length of the lens that a capture of a target gets, mm.
const FOCAL_LENGTH_MM: f64 = 16.0;
/// Part of the image that the sheet fills along the tighter side.
const FILLED: f64 = 0.9;

/// Capture file with the target, evenly lit, square in the image.
fn capture(description: &TargetDescription, target: &Target) -> String {
    let sensor = presets::model(presets::DEFAULT).expect("the default preset is part of the program");
    let size = target.size_m();
    let side = |i: usize| sensor.resolution[i] as f64 * sensor.pixel_pitch_m[i] * FILLED;
    // A lens focused at u shows what is there at the scale f/(u − f).
    let distance = FOCAL_LENGTH_MM / 1e3 * (1.0 + (size.x / side(0)).max(size.y / side(1)));
    let distance = (distance * 1e3).ceil() / 1e3;
    // Every key and its value: a description is a table of plain values.
    let keys = toml::to_string(description).expect("a table of plain values");
    format!(
        "# A {name} of {:.1} by {:.1} mm, evenly lit. photosite target {name} -o FILE.pdf prints it.\n\n\
         [scene]\nenvironment = {{ illuminant = \"D65\", illuminance_lux = 1000 }}\n\n\
         [[targets]]\n{keys}\
         position_m = [0.0, 0.0, 0.0]   # of the middle of the sheet\n\
         look_at_m = [0.0, 0.0, 1.0]    # what its front faces\n\n\
         [camera]\nposition_m = [0.0, 0.0, {distance}]\nlook_at_m = [0.0, 0.0, 0.0]\n\n\
         [lens]\nfocal_length_mm = {FOCAL_LENGTH_MM:?}\nf_number = 8.0\nfocus_distance_m = {distance}\n\n\
         [sensor]\npreset = {:?}\n\n\
         [exposure]\nauto = true\n\n\
         # Light goes from the surroundings to the sheet and to the camera: nothing lies between.\n\
         [render]\nsamples_per_pixel = 64\nmax_depth = 2\n",
        size.x * 1e3,
        size.y * 1e3,
        presets::DEFAULT,
        name = description.kind().name(),
    )
}
