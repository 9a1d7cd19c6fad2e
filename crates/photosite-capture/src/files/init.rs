//! The capture file that a scene file stands for: what `photosite render model.glb` makes of it, written out key by
//! key.
//!
//! Every number is that which the render of the scene file finds, in the digits that make it again, so that both give
//! the same images. What is found anew each time, such as the exposure, is named by what finds it.

use std::fmt::Write;
use std::path::Path;

use serde_json::Value;

use super::super::Capture;
use super::super::camera::framing::{Framing, bounding_sphere};
use super::super::camera::lens::{DEFAULT_F_NUMBER, DEFAULT_FOCAL_LENGTH_M};
use super::super::camera::pose::lens_size;
use super::super::scene::environment::EVEN;
use super::super::scene::floor_surface::Subject;
use super::super::settings::exposure::LONGEST_AUTO_S;
use super::super::tables::geometry_kind::GeometryKind;
use super::super::tables::{LensTable, UpAxis};
use super::input::is_scene_file;
use super::relocate::relative_path;
use photosite_core::Sandbox;
use photosite_core::math::float::rounded;
use photosite_core::{Invalid, Result};
use photosite_sensor::presets;
use photosite_transport::integrator::RenderSettings;

/// A capture file that is made of a scene file.
#[derive(Clone, Debug)]
pub struct InitialCapture {
    /// Text of the file.
    pub text: String,
    /// Warnings about assumptions and about the scene.
    pub warnings: Vec<String>,
}

/// The capture file of a scene file, to be kept in `folder`, which exists.
///
/// # Errors
///
/// A file that is no scene, or that cannot be rendered.
pub fn initial_capture(sandbox: &Sandbox, path: &Path, folder: &Path) -> Result<InitialCapture> {
    if !is_scene_file(path) {
        let invalid = Invalid::new("", "is not a scene file");
        return Err(invalid
            .help("give a scene (.gltf, .glb, .obj, .ply, .stl); a capture file needs no other")
            .in_file(path));
    }
    let capture = Capture::load_within(sandbox, path, &[])?;
    let mut warnings = capture.warnings();
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut text = format!(
        "# {name}, as `photosite render` shows it without a capture file: the same images, byte for byte.\n\
         # Whatever is left out takes its default; `photosite schema` lists all keys.\n"
    );
    let mut section = |lines: String| text += &lines;
    section(scene(&capture, &relative_path(path, folder), &mut warnings)?);
    section(camera(&capture)?);
    section(lens(&capture));
    section(sensor(&capture));
    section(exposure(&capture)?);
    section(render(&capture.render));
    section(OUTPUT.to_owned());
    Ok(InitialCapture { text, warnings })
}

/// Lines of a table: keys with their values, and comments.
struct Table(String);

impl Table {
    fn new(name: &str) -> Self {
        Self(format!("\n[{name}]\n"))
    }

    /// Begins another table below this one.
    fn table(&mut self, name: &str) {
        self.0 += &Self::new(name).0;
    }

    fn key(&mut self, key: &str, value: impl std::fmt::Display, comment: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{:<44}  # {comment}", format!("{key} = {value}"));
    }

    /// Adds a key, commented out, that would change what is there.
    fn other(&mut self, key: &str, value: impl std::fmt::Display, comment: &str) {
        let _ = writeln!(self.0, "{:<44}  # {comment}", format!("# {key} = {value}"));
    }
}

fn scene(capture: &Capture, geometry: &str, warnings: &mut Vec<String>) -> Result<String> {
    let mut table = Table::new("scene");
    let subject = Subject::of(&capture.scene);
    table.key(
        "geometry",
        toml::Value::from(vec![geometry]),
        "glTF, GLB, OBJ, PLY and STL files, relative to this file",
    );
    // glTF is in metres.
    let kind = GeometryKind::of(Path::new(geometry));
    if kind.is_none_or(GeometryKind::is_in_metres) {
        table.other("variant", "\"name\"", "a material variant of the file (`photosite info` lists them)");
    } else if let Some((low, high)) = capture.scene.subject_bounds() {
        let [x, y, z] = (high - low).to_array().map(|length| rounded(length, 3));
        let size = format!("{x} × {y} × {z} m");
        table.key("meters_per_unit", "1.0", &format!("0.001 for millimetres; with 1, all is {size} large"));
        warnings.push(format!(
            "{geometry} does not say in which unit it is: metres are assumed, so everything is {size} in size; write \
             meters_per_unit = 0.001 if it is in millimetres"
        ));
    }
    if let Some(kind) = kind.filter(|kind| !kind.is_in_metres()) {
        let (up, other) = if kind.up() == UpAxis::Z { ("z", "y") } else { ("y", "z") };
        table.key("up", format!("{up:?}"), &format!("the axis of the file that points up; or {other:?}"));
    }
    let sky: Option<Value> = capture.source.read("scene.environment.sky")?;
    let Some(sky) = sky else {
        let comment = "besides the lights of the file: D65 of 500 lux from all sides; or a sky, or an image";
        table.other("environment", format!("{EVEN:?}"), comment);
        table.other("ground", "{ reflectance = 0.3 }", "a level plane below all, out to the horizon");
        return Ok(table.0);
    };
    table.other("environment", format!("{EVEN:?}"), "in place of the sky: D65 of 500 lux from all sides");
    table.other("environment", "{ image = \"sky.hdr\", illuminance_lux = 10000 }", "or an image of the surroundings");
    table.other("backdrop", "{ reflectance = 0.5 }", "a studio's, in place of the ground");
    table.table("scene.environment.sky");
    for (key, comment) in [
        ("sun_elevation_deg", "how high the sun stands"),
        ("sun_azimuth_deg", "from north (-Z) over east (+X): 50° to the left of the camera"),
        ("turbidity", "haze, from 1 to 10: a clear day"),
        ("ground_albedo", "of the ground that the sky sees: that below"),
    ] {
        table.key(key, float(&sky[key]), comment);
    }
    table.table("scene.ground");
    let reflectance: Value = capture.source.read("scene.ground.reflectance")?.unwrap_or_default();
    table.key("height_m", format!("{:?}", subject.floor_m()), "just below the lowest point");
    table.key("reflectance", float(&reflectance), "a neutral grey; or material = \"name\"");
    Ok(table.0)
}

fn camera(capture: &Capture) -> Result<String> {
    let mut table = Table::new("camera");
    if let Some(camera) = capture.scene.cameras.first() {
        table.key("gltf_camera", toml::Value::from(&*camera.name), "the first of the file, with its field of view");
        table.other("position_m", "[0.0, 1.0, 3.0]", "in its place: where the lens is …");
        table.other("look_at_m", "[0.0, 0.0, 0.0]", "… and a point on its axis");
        return Ok(table.0);
    }
    let Some(sphere) = bounding_sphere(&capture.scene) else { return Ok(table.0) };
    let size = lens_size(&LensTable::default(), &capture.sensor, None, None)
        .map_err(|invalid| capture.source.error(invalid))?;
    let Framing { position, look_at } = Framing::of(&sphere, &capture.sensor, size);
    table.key(
        "position_m",
        format!("{:?}", position.to_array()),
        "where the lens is: all of the scene is in the image",
    );
    table.key("look_at_m", format!("{:?}", look_at.to_array()), "a point on its axis: the middle of the scene");
    Ok(table.0)
}

fn lens(capture: &Capture) -> String {
    let mut table = Table::new("lens");
    let millimetres = DEFAULT_FOCAL_LENGTH_M * 1e3;
    if capture.scene.cameras.is_empty() {
        table.key("focal_length_mm", format!("{millimetres:?}"), "or horizontal_fov_deg, the angle over the width");
    } else {
        table.other("horizontal_fov_deg", "40.0", "the angle over the width, in place of that of the file's camera");
    }
    table.key("f_number", format!("{DEFAULT_F_NUMBER:?}"), "smaller is brighter, with less depth of field");
    table.key("focus_distance_m", "\"scene\"", "the middle of the scene; or a distance, or autofocus_px = \"centre\"");
    table.0
}

fn sensor(capture: &Capture) -> String {
    let mut table = Table::new("sensor");
    table.key("preset", format!("{:?}", presets::DEFAULT), "`photosite sensors` lists others");
    let [width, height] = capture.sensor.resolution;
    table.other("scaled_to_px", format!("[{}, {}]", width / 2, height / 2), "the same view at another size");
    table.0
}

fn exposure(capture: &Capture) -> Result<String> {
    let mut table = Table::new("exposure");
    table.key("auto", "true", "the time is found from the light");
    let mean: Option<f64> = capture.source.read("exposure.auto_mean")?;
    match mean {
        Some(mean) => table.key("auto_mean", format!("{mean:?}"), "the mean of the image, as a part of saturation"),
        None => table.other("auto_mean", "0.2", "in place of keeping bright parts below saturation: the image's mean"),
    }
    table.key("max_time_s", format!("{LONGEST_AUTO_S:?}"), "the longest time; beyond it the gain rises instead");
    table.other("compensation_ev", "1.0", "twice as bright as that");
    table.other("time_s", "0.01", "in place of all of this: a time of your own");
    Ok(table.0)
}

fn render(settings: &RenderSettings) -> String {
    let mut table = Table::new("render");
    table.key("samples_per_pixel", settings.samples_per_pixel, "four times as many halve the noise of rendering");
    table.key("max_depth", settings.max_depth, "segments of a light path, at most");
    table.key("seed", settings.seed, "of rendering and of the sensor's noise");
    table.other("noise_target", "0.2", "stop where the noise of rendering is a fifth of the sensor's");
    table.0
}

/// Table `[output]`, the same in all files.
const OUTPUT: &str = r#"
[output]
raw = ["dng"]                                 # also tiff, pgm, npy, exr
image = true                                  # the developed image, image.png
electrons = true                              # what the sensor counts on average, electrons.exr
# truth = ["depth", "normal", "instance"]     # what is really there at each pixel
"#;

/// Number in TOML with a decimal point, even if it is an integer.
fn float(value: &Value) -> String {
    value.as_f64().map_or_else(|| value.to_string(), |number| format!("{number:?}"))
}
