//! `photosite info`: what a scene, capture, sensor, raw or EXR file holds.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use clap::Args;
use photosite::image::Planes;
use photosite::io::capture::{Capture, read_sensor_file};
use photosite::io::exr::{Attribute, read_exr};
use photosite::raw::{RawImage, read_dng, read_tiff};
use photosite::scene::description::SceneDescription;
use photosite::sensor::SensorModel;
use photosite::{Error, Result};
use serde_json::{Map, Value, json};

use super::{print_json, println_out};

/// Say what a scene, capture, sensor, raw or EXR file holds.
#[derive(Args)]
pub(super) struct InfoArgs {
    /// A .toml, .gltf, .glb, .obj, .dng, .tiff or .exr file.
    file: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &InfoArgs) -> Result<()> {
    let facts = facts(&args.file)?;
    if args.json {
        return print_json(&facts);
    }
    let width = facts.keys().map(|key| key.chars().count()).max().unwrap_or(0);
    for (key, value) in &facts {
        let is_listed = |item: &Value| item.is_string() || item.is_object();
        let listed = value.as_array().filter(|items| items.iter().any(is_listed));
        println_out(&match listed {
            Some(items) => items.iter().fold(format!("{key}:"), |text, item| text + "\n  " + &plain(item)),
            None => format!("{key:width$}  {}", plain(value)),
        })?;
    }
    Ok(())
}

/// A value without the quotes of JSON.
fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(plain).collect::<Vec<_>>().join(" "),
        Value::Object(map) => {
            map.iter().map(|(key, value)| format!("{key} {}", plain(value))).collect::<Vec<_>>().join(", ")
        }
        Value::Null | Value::Bool(_) | Value::Number(_) => value.to_string(),
    }
}

/// What the file holds, by the kind that its name says.
fn facts(path: &Path) -> Result<Map<String, Value>> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "toml" => match read_sensor_file(path)? {
            Some(sensor) => Ok(of_sensor(&sensor)),
            None => Ok(of_capture(&Capture::read(path, &[])?)),
        },
        "gltf" | "glb" | "obj" => Ok(of_capture(&Capture::read(path, &[])?)),
        "exr" => {
            let picture = read_exr(open(path)?).map_err(|invalid| invalid.in_file(path))?;
            let mut facts = of_planes(&picture.planes);
            for (name, value) in &picture.attributes {
                let value = match value {
                    Attribute::Text(text) => json!(text),
                    Attribute::Number(number) => json!(number),
                };
                facts.insert(name.clone(), value);
            }
            Ok(facts)
        }
        "dng" => Ok(of_raw(&read_dng(open(path)?).map_err(|invalid| invalid.in_file(path))?)),
        "tif" | "tiff" => Ok(of_raw(&read_tiff(open(path)?).map_err(|invalid| invalid.in_file(path))?)),
        _ => Err(Error::Usage {
            message: format!("{} is of no kind that photosite knows", path.display()),
            help: Some("give a .toml, .gltf, .glb, .obj, .dng, .tiff or .exr file".to_owned()),
        }),
    }
}

fn open(path: &Path) -> Result<BufReader<File>> {
    File::open(path).map(BufReader::new).map_err(|source| Error::io(path, "read", source))
}

fn map(facts: Value) -> Map<String, Value> {
    match facts {
        Value::Object(map) => map,
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => Map::new(),
    }
}

fn of_capture(capture: &Capture) -> Map<String, Value> {
    let mut facts = of_scene(&capture.scene);
    let lens = &capture.lens;
    facts.extend(map(json!({
        "lens": format!("{} mm f/{}", round(lens.focal_length_m * 1e3), round(lens.f_number)),
        "sensor": capture.sensor.name,
        "resolution_px": capture.sensor.resolution,
        "samples_per_pixel": capture.render.samples_per_pixel,
    })));
    facts
}

fn of_scene(scene: &SceneDescription) -> Map<String, Value> {
    let placed = |f: &dyn Fn(usize) -> usize| scene.instances.iter().map(|i| f(i.mesh)).sum::<usize>();
    let names = |names: Vec<&String>| names.into_iter().filter(|name| !name.is_empty()).cloned().collect::<Vec<_>>();
    map(json!({
        "meshes": scene.meshes.len(),
        "instances": scene.instances.len(),
        "triangles": scene.meshes.iter().map(|m| m.triangles.len()).sum::<usize>(),
        "triangles_placed": placed(&|mesh| scene.meshes[mesh].triangles.len()),
        "pictures": scene.images.len(),
        "lights": scene.lights.len(),
        "environment": scene.environment.is_some(),
        "cameras": names(scene.cameras.iter().map(|c| &c.name).collect()),
        "materials": names(scene.materials.iter().map(|m| &m.name).collect()),
        "warnings": scene.warnings,
    }))
}

fn of_sensor(sensor: &SensorModel) -> Map<String, Value> {
    let peaks: Vec<_> = sensor.quantum_efficiency.iter().map(|qe| round(f64::from(qe.max()))).collect();
    map(json!({
        "name": sensor.name,
        "description": sensor.description,
        "source": sensor.source,
        "resolution_px": sensor.resolution,
        "pixel_pitch_um": sensor.pixel_pitch_m.map(|m| round(m * 1e6)),
        "channels": sensor.cfa.channels().join(" "),
        "peak_quantum_efficiency": peaks,
        "full_well_e": sensor.full_well.0,
        "read_noise_e": sensor.noise.read.0,
        "dark_current_e_per_s": sensor.noise.dark_current_e_per_s,
        "prnu_percent": round(sensor.noise.prnu * 100.0),
        "dsnu_e": sensor.noise.dsnu.0,
        "bits": sensor.converter.bits,
        "conversion_gain_dn_per_e": sensor.converter.conversion_gain_dn_per_e,
        "black_level_dn": sensor.converter.black_level_dn,
    }))
}

fn of_raw(raw: &RawImage) -> Map<String, Value> {
    let sum: f64 = raw.data.iter().map(|&dn| f64::from(dn)).sum();
    let (width, height) = raw.cfa.tile_size();
    let letters = |i: usize| raw.cfa.channels()[raw.cfa.channel_at(i % width, i / width)].as_str();
    map(json!({
        "camera_model": raw.metadata.camera_model,
        "resolution_px": [raw.width, raw.height],
        "cfa": (0..width * height).map(letters).collect::<String>(),
        "bits": raw.bits,
        "black_level_dn": raw.black_level_dn,
        "white_level_dn": raw.white_level_dn,
        "minimum_dn": raw.data.iter().min(),
        "mean_dn": round(sum / raw.data.len().max(1) as f64),
        "maximum_dn": raw.data.iter().max(),
        "saturated_pixels": raw.data.iter().filter(|&&dn| dn >= raw.white_level_dn).count(),
        "exposure_time_s": raw.metadata.exposure_time_s,
        "f_number": raw.metadata.f_number,
        "focal_length_mm": raw.metadata.focal_length_m.map(|m| round(m * 1e3)),
        "as_shot_neutral": raw.metadata.as_shot_neutral,
    }))
}

fn of_planes(planes: &Planes) -> Map<String, Value> {
    let channel = |c: &photosite::image::Channel| {
        let sum: f64 = c.data.iter().map(|&v| f64::from(v)).sum();
        let (low, high) = c.data.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        json!({"channel": c.name, "minimum": low, "mean": (sum / c.data.len().max(1) as f64) as f32, "maximum": high})
    };
    map(json!({
        "resolution_px": [planes.width(), planes.height()],
        "channels": planes.channels().iter().map(channel).collect::<Vec<_>>(),
    }))
}

/// Six significant digits: what is said is for people.
fn round(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let scale = 10f64.powf(5.0 - x.abs().log10().floor());
    (x * scale).round() / scale
}
