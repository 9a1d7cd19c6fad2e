//! `photosite info`: the contents of a scene, capture, sensor, raw or image file.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use clap::Args;
use photosite_core::{input, suggest};
use serde_json::{Map, Value, json};

use super::json_text::listing;
use super::print::{print_json, println_text, rounded};
use super::scene_args::SceneArgs;
use photosite_capture::report::LensReport;
use photosite_capture::{Capture, ExposureTime, Extent, read_sensor_file, subject};
use photosite_core::image::{NotFinite, Planes};
use photosite_core::units::Decibels;
use photosite_core::{Error, Invalid, Result, Sandbox};
use photosite_files::exr::{Attribute, read_exr_file};
use photosite_files::formats::{EXR, Format, Holds, lists::endings};
use photosite_files::image_file::{ImageFile, read_image_file};
use photosite_files::raw_file::read_raw;
use photosite_pipeline::standalone_camera;
use photosite_raw::{GainMap, Pixels, RawImage, RawMetadata};
use photosite_sensor::{self as sensors, Binning, ReadOutNoise, SensorModel, presets};
use photosite_transport::optics::{Camera, Focus, LensDescription, LensKind};
use photosite_transport::scene::description::{
    EnvironmentDescription, InstanceDescription, MaterialDescription, SceneDescription,
};

const EXAMPLES: &str = "\
Examples:
  photosite info model.glb
  photosite info sony-imx249-color";

/// Show what a scene, capture, sensor, raw or image file holds.
///
/// The size of a scene is shown, with a warning where its unit is probably not the metre: where it is longer than
/// 20 m although nothing states the unit of its OBJ, PLY or STL files (meters_per_unit), or longer than 100 m in
/// glTF.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct InfoArgs {
    #[arg(help = format!(
        "A .toml, capture.json, .gltf, .glb, .obj, .ply, .stl, {} file, or the name of a sensor preset",
        endings(Format::reads_images)
    ))]
    file: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    scene: SceneArgs,
}

pub(super) fn run(args: &InfoArgs, sandbox: &Sandbox) -> Result<()> {
    let mut facts = facts(&args.file, sandbox, &args.scene.after(&[], &args.file))?;
    if args.json {
        return print_json(&facts);
    }
    if let Some(Value::Array(objects)) = facts.get_mut("objects") {
        shorten(objects);
    }
    println_text(&listing(&facts))
}

/// Shortens a long list of objects to its first ones, for people.
fn shorten(objects: &mut Vec<Value>) {
    const MOST: usize = 40;
    if objects.len() > MOST {
        let left_out = objects.len() - MOST;
        objects.truncate(MOST);
        objects.push(json!({ "name": format!("and {left_out} more, which --json lists") }));
    }
}

/// Facts about a file, by the kind that its extension says.
fn facts(path: &Path, sandbox: &Sandbox, overrides: &[String]) -> Result<Map<String, Value>> {
    if let Some(format) = Format::of(path).filter(|format| format.reads_images()) {
        return of_image(path, format);
    }
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "" if path.to_str().is_some_and(|name| presets::names().any(|preset| preset == name)) && !path.exists() => {
            Ok(presets::model(&path.to_string_lossy()).as_ref().map(of_sensor).unwrap_or_default())
        }
        "toml" => match read_sensor_file(path, sandbox)? {
            Some(sensor) => Ok(of_sensor(&sensor)),
            None => of_capture(&Capture::load_within(sandbox, path, overrides)?),
        },
        "gltf" | "glb" | "obj" | "ply" | "stl" | "json" => of_capture(&Capture::load_within(sandbox, path, overrides)?),
        _ if path.is_dir() => {
            let invalid = Invalid::new("", "is a folder");
            Err(invalid.help("give a file in it, for example its capture.json").in_file(path))
        }
        ending => {
            // A name without an ending may be that of a sensor.
            if !ending.is_empty() {
                input::metadata(path).map_err(|source| Error::io(path, "read", source))?;
            }
            let help = format!(
                "give a .toml, .json (a capture.json), .gltf, .glb, .obj, .ply, .stl, {} file, or a name that `photosite \
                 sensors` lists",
                endings(Format::reads_images)
            );
            let near = suggest::did_you_mean(&path.to_string_lossy(), presets::names());
            let message = format!("is not a kind of file that photosite knows{near}");
            Err(Invalid::new("", message).help(help).in_file(path))
        }
    }
}

/// Facts about an image or raw file.
fn of_image(path: &Path, format: &Format) -> Result<Map<String, Value>> {
    match format.holds {
        Holds::Light if *format == EXR => {
            let image = read_exr_file(path)?;
            let mut facts = of_planes(&image.planes, image.warnings);
            for (name, value) in &image.attributes {
                let value = match value {
                    Attribute::Text(text) => json!(text),
                    Attribute::Number(number) | Attribute::PixelAspect(number) => json!(number),
                    Attribute::Chromaticities(points) => json!(points),
                    Attribute::Other(_) => value.number().map_or_else(|| json!(value.to_string()), |n| json!(n)),
                };
                facts.insert(name.clone(), value);
            }
            Ok(facts)
        }
        Holds::Light => {
            let image = read_image_file(path, Pixels::All)?;
            Ok(of_planes(&image.mean, image.warnings))
        }
        Holds::Raw | Holds::Arrays => {
            let raw = read_raw(path)?;
            let mut facts = if format.holds == Holds::Raw { of_raw(&raw.linear()) } else { of_numbers(&raw) };
            facts.extend(of_metadata(&raw.metadata));
            Ok(facts)
        }
        Holds::Codes => {
            let ImageFile { image, notes } = ImageFile::read(path, Pixels::All)?;
            let mut facts = of_planes(&image.mean, notes.left_out);
            if !notes.orientation.is_upright() {
                facts.insert("orientation".to_owned(), json!(notes.orientation.number()));
            }
            facts.extend(map(json!({ "full_scale": image.full_scale, "pixel_aspect": notes.pixel_aspect })));
            Ok(facts)
        }
    }
}

fn map(facts: Value) -> Map<String, Value> {
    match facts {
        Value::Object(map) => map,
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => Map::new(),
    }
}

/// Position of the camera halfway through its first image, as in `capture.json`.
fn position_halfway(capture: &Capture) -> [f64; 3] {
    let start = capture.camera_to_world();
    let moved = capture.recording().and_then(|recording| {
        let motion = recording.motion.as_ref()?;
        Some(motion.pose(&start, recording.middle_s()))
    });
    moved.unwrap_or(start).translation.to_array()
}

fn of_capture(capture: &Capture) -> Result<Map<String, Value>> {
    let (scene, lens, sensor, exposure, render) =
        (capture.scene(), capture.lens(), capture.sensor(), capture.exposure(), capture.render());
    let units = capture.units()?;
    let units = units.iter().map(|u| json!({"file": u.file, "unit_m": u.unit_m, "unit_from": u.source.name()}));
    let mut facts = map(json!({ "geometry": units.collect::<Vec<_>>() }));
    facts.extend(of_scene(scene));
    let mut warnings = capture.warnings();
    warnings.extend(capture.unit_warning().filter(|warning| !warnings.contains(warning)));
    match standalone_camera(capture) {
        Err(error) => warnings.push(error.to_string()),
        Ok(camera) => {
            let field = camera.field_of_view();
            let degrees = |angle: f64| round(angle.to_degrees());
            if camera.makes_image() {
                facts.extend(map(json!({
                    "projection": lens.projection_name(),
                    "distortion_coefficients": lens.projection.coefficients(),
                    "field_of_view_deg": field.across_rad.map(|angle| angle.map(degrees)),
                    "lens_reach_deg": degrees(field.reach_rad),
                    "lens_reach_px": field.radius_px.map(round),
                    "covers_sensor": field.blind_px.is_none(),
                })));
            }
            let report = LensReport::new(lens, &camera, sensor.pixel_pitch_m, &[]);
            facts.insert("lens".to_owned(), json!(lens_in_words(lens)));
            facts.insert("focus".to_owned(), json!(focus_in_words(lens, &camera)));
            let mut figures = report.figures.map(|figures| json!(figures)).unwrap_or_default();
            round_all(&mut figures);
            if let Some(far) = figures.pointer_mut("/depth_of_field_m/1").filter(|far| far.is_null()) {
                *far = json!("infinity");
            }
            facts.extend(map(figures));
        }
    }
    let exposure_value = match exposure.time {
        ExposureTime::Fixed(time) if lens.kind != LensKind::Bare => Some((lens.f_number.powi(2) / time.0).log2()),
        ExposureTime::Fixed(_) | ExposureTime::Auto(_) => None,
    };
    facts.extend(map(json!({
        "camera_position_m": position_halfway(capture),
        "sensor": sensor.name,
        "resolution_px": sensor.resolution,
        "pixel_pitch_um": sensor.pixel_pitch_m.map(|m| round(m * 1e6)),
        "exposure_time_s": match exposure.time {
            ExposureTime::Fixed(time) => json!(time.0),
            ExposureTime::Auto(_) => json!("automatic"),
        },
        "exposure_value": exposure_value.map(round),
        "gain_db": exposure.gain.0,
        "digital_gain_db": exposure.digital_gain.0,
        "frames": exposure.frames,
        "samples_per_pixel": render.samples_per_pixel,
        "warnings": warnings,
    })));
    Ok(facts)
}

fn lens_in_words(lens: &LensDescription) -> String {
    let [f_mm, n] = [lens.focal_length_m * 1e3, lens.f_number].map(round);
    match lens.kind {
        LensKind::Thin => format!("{f_mm} mm f/{n}"),
        LensKind::Prescription => {
            let name = lens.prescription.as_ref().map_or("", |prescription| &prescription.name);
            format!("{name}, {f_mm} mm f/{n}")
        }
        LensKind::Pinhole => format!("pinhole, {f_mm} mm f/{n}"),
        LensKind::Hole => format!("hole of {} mm at {f_mm} mm", round(f_mm / n)),
        LensKind::Bare => "none".to_owned(),
    }
}

fn focus_in_words(lens: &LensDescription, camera: &Camera) -> String {
    let u = camera.focus_distance_m();
    let place = match u {
        _ if u < 0.0 => {
            format!("nowhere: the sensor stands {} mm behind the lens", round(camera.image_distance_m() * 1e3))
        }
        _ if u.is_infinite() => "infinity".to_owned(),
        _ => format!("{} m", round(u)),
    };
    match (lens.kind, lens.focus) {
        (LensKind::Pinhole, _) => "none, as everything is sharp".to_owned(),
        (LensKind::Hole | LensKind::Bare, _) => "none".to_owned(),
        (LensKind::Thin | LensKind::Prescription, Focus::Autofocus { pixel: [x, y], .. }) => {
            format!("{place}, on what pixel {x}, {y} sees")
        }
        (LensKind::Thin | LensKind::Prescription, Focus::Distance(_) | Focus::Infinity | Focus::ImageDistance(_)) => {
            place
        }
    }
}

/// Rounds every number in a value, as [`round`] does.
fn round_all(value: &mut Value) {
    match value {
        Value::Number(number) => {
            if let Some(x) = number.as_f64() {
                *value = json!(round(x));
            }
        }
        Value::Array(items) => items.iter_mut().for_each(round_all),
        Value::Object(map) => map.values_mut().for_each(round_all),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

fn of_scene(scene: &SceneDescription) -> Map<String, Value> {
    let triangles = |mesh: usize| scene.meshes[mesh].triangles.len();
    let named = |name: &str| if name.is_empty() { "unnamed".to_owned() } else { name.to_owned() };
    let emits = |m: &&MaterialDescription| m.emission.is_some();
    let object = |instance: &InstanceDescription| {
        let mut facts = map(json!({ "name": named(&instance.name) }));
        facts.extend(map(of_extent(&Extent::of_instance(scene, instance)?)));
        Some(Value::Object(facts))
    };
    let environment = scene.environment.as_ref().map(|environment| match environment {
        EnvironmentDescription::Constant { luminance_nit: Some(nit), .. } => {
            format!("the same light everywhere, {} lux on a plane", round(PI * nit))
        }
        EnvironmentDescription::Constant { luminance_nit: None, .. } => "the same light everywhere".to_owned(),
        EnvironmentDescription::Sky(_) => "the sky by day".to_owned(),
        EnvironmentDescription::Image { image, .. } => {
            format!("the image {}, {} × {} pixels", image.name, image.width, image.height)
        }
    });
    map(json!({
        "meshes": scene.meshes.len(),
        "triangles": (0..scene.meshes.len()).map(triangles).sum::<usize>(),
        "instances": scene.instances.len(),
        "triangles_of_instances": scene.instances.iter().flat_map(|i| i.meshes.clone()).map(triangles).sum::<usize>(),
        "bounding_box": Extent::of_scene(scene).as_ref().map(of_extent),
        "objects": subject(scene).filter_map(object).collect::<Vec<_>>(),
        "textures": scene.images.len(),
        "materials": scene.materials.iter().map(|m| named(&m.name)).collect::<Vec<_>>(),
        "emitting_materials": scene.materials.iter().filter(emits).map(|m| named(&m.name)).collect::<Vec<_>>(),
        "lights": scene.lights.iter().map(|l| json!({"name": named(&l.name), "type": l.kind.name()})).collect::<Vec<_>>(),
        "environment": environment,
        "cameras": scene.cameras.iter().map(|c| named(&c.name)).collect::<Vec<_>>(),
    }))
}

fn of_extent(extent: &Extent) -> Value {
    let [min, max, size] = [extent.low, extent.high, extent.size()].map(|v| v.to_array());
    json!({ "min_m": min, "max_m": max, "size_m": size })
}

fn of_sensor(sensor: &SensorModel) -> Map<String, Value> {
    let mut facts = of_plain_sensor(sensor);
    facts.extend(map(json!(sensor.uncommon_facts())).into_iter().filter(|(_, fact)| !fact.is_null()));
    facts
}

/// Noise of the read-out and black level at a step of gain.
fn step_of_gain(sensor: &SensorModel, (gain, noise): &(Decibels, ReadOutNoise)) -> Value {
    json!({
        "gain_db": gain.0,
        "read_noise_e": noise.read.0,
        "row_noise_e": noise.row.0,
        "column_noise_e": noise.column.0,
        "dsnu_e": round(noise.dsnu.total()),
        "black_level_dn": sensor.converter.black_level_dn(*gain),
    })
}

fn of_plain_sensor(sensor: &SensorModel) -> Map<String, Value> {
    // Of a sensor whose noise changes with gain, that at 0 dB, and all steps beside it.
    let read_out = sensor.noise.read_out.at(Decibels(0.0));
    let steps: Vec<_> = sensor.noise.read_out.steps().iter().map(|step| step_of_gain(sensor, step)).collect();
    let peaks: Vec<_> = sensor.efficiencies().iter().map(|qe| round(qe.max().into())).collect();
    let mut facts = map(json!({
        "name": sensor.name,
        "kind": sensor.architecture.name(),
        "description": sensor.description,
        "source": sensor.source,
        "resolution_px": sensor.resolution,
        "pixel_pitch_um": sensor.pixel_pitch_m.map(|m| round(m * 1e6)),
        "size_mm": sensor.size_m().map(|m| round(m * 1e3)),
        "format": sensors::Format::nearest(sensor.size_m()).map(|format| format.names[0]),
        "cfa": sensor.cfa.to_string(),
        "channels": sensor.cfa.channels(),
        "peak_quantum_efficiency": peaks,
        "full_well_e": sensor.full_well.0,
        "read_noise_e": read_out.read.0,
        "dark_current_e_per_s": sensor.noise.dark_current_e_per_s,
        "prnu_percent": round(sensor.noise.prnu.total() * 100.0),
        "dsnu_e": round(read_out.dsnu.total()),
        "base_iso": sensor.base_iso(Binning::NONE).map(f64::round),
        "gain_db_range": sensor.converter.gain_range.map(|gain| gain.0),
        "bits": sensor.converter.bits,
        "output_bits": sensor.output_bits(),
        "conversion_gain_dn_per_e": sensor.converter.conversion_gain_dn_per_e,
        "black_level_dn": sensor.converter.black_level_dn(Decibels(0.0)),
    }));
    if !steps.is_empty() {
        facts.insert("gain_steps".to_owned(), steps.into());
    }
    facts
}

/// Orientation of an image that is not upright, and statements of its file that are left out.
fn of_metadata(metadata: &RawMetadata) -> Map<String, Value> {
    let mut facts = Map::new();
    if !metadata.orientation.is_upright() {
        facts.insert("orientation".to_owned(), json!(metadata.orientation.number()));
    }
    if !metadata.left_out.is_empty() {
        facts.insert("warnings".to_owned(), json!(metadata.left_out));
    }
    facts
}

/// Facts about TIFF, PBM, PGM, PPM and NPY files.
fn of_numbers(raw: &RawImage) -> Map<String, Value> {
    let sum: f64 = raw.data.iter().map(|&dn| f64::from(dn)).sum();
    map(json!({
        "resolution_px": [raw.width, raw.height],
        "minimum_dn": raw.data.iter().min(),
        "mean_dn": sum / raw.data.len().max(1) as f64,
        "maximum_dn": raw.data.iter().max(),
    }))
}

fn of_raw(raw: &RawImage) -> Map<String, Value> {
    // Masked pixels say nothing of the image.
    let active = raw.cropped();
    let mut facts = of_numbers(&active);
    facts.extend(map(json!({
        "resolution_px": [raw.width, raw.height],
        "active_area_px": raw.active_area.map(|area| [area.x, area.y, area.width, area.height]),
        "saturated_pixels": active.saturated(),
        "cfa": raw.cfa.to_string(),
        "bits": raw.bits,
        "black_level_dn": raw.black_level_dn.mean(),
        "white_level_dn": raw.white_level_dn,
        "channel_whites_dn": raw.channel_whites_dn,
        "camera_model": raw.metadata.camera_model,
        "camera_serial": raw.metadata.camera_serial,
        "pixel_pitch_um": raw.metadata.pixel_pitch_m.map(|pitch| pitch.map(|m| round(m * 1e6))),
        "exposure_time_s": raw.metadata.exposure_time_s,
        "falloff_correction": falloff_in_words(&raw.metadata),
        "default_crop_px": raw.metadata.default_crop.map(|area| [area.x, area.y, area.width, area.height]),
        "distortion_correction": raw.metadata.distortion.is_some(),
        "iso": raw.metadata.iso,
        "f_number": raw.metadata.f_number,
        "focal_length_mm": raw.metadata.focal_length_m.map(|m| round(m * 1e3)),
        "as_shot_neutral": raw.metadata.as_shot_neutral,
    })));
    facts
}

fn falloff_in_words(metadata: &RawMetadata) -> Option<String> {
    let maps: Vec<&GainMap> = metadata.gain_maps().collect();
    let first = maps.first()?;
    let largest = maps.iter().flat_map(|map| map.gains()).copied().fold(0.0, f32::max);
    let points = format!("{} × {} points", first.columns(), first.rows());
    let of = if maps.len() == 1 { points } else { format!("{} maps, the first of {points}", maps.len()) };
    Some(format!("gains up to {}, {of}", round(largest.into())))
}

/// Figures of the finite values of planes, and the warnings of their file.
fn of_planes(planes: &Planes, mut warnings: Vec<String>) -> Map<String, Value> {
    let channel = |c: &photosite_core::image::Channel| {
        let finite = || c.data.iter().copied().filter(|value| value.is_finite());
        let count = finite().count();
        let sum: f64 = finite().map(f64::from).sum();
        let (low, high) = finite().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let mean = sum / count as f64;
        json!({"name": c.name, "minimum": low, "mean": mean, "maximum": high, "not_finite": c.data.len() - count})
    };
    warnings.extend(NotFinite::of(planes).map(|found| found.to_string()));
    let mut facts = map(json!({
        "resolution_px": [planes.width(), planes.height()],
        "channels": planes.channels().iter().map(channel).collect::<Vec<_>>(),
    }));
    if !warnings.is_empty() {
        facts.insert("warnings".to_owned(), json!(warnings));
    }
    facts
}

/// Number with six significant digits, since unit conversions mean no more.
fn round(x: f64) -> f64 {
    rounded(x, 6)
}
