//! Overrides, `key=value`: values of the caller in place of those of the file.

use photosite_core::Remedy;
use photosite_core::key_path::{has_outside_quotes, split_change, toml_value};

use super::source::{CaptureSource, shown};
use photosite_core::{Error, Result};

/// Lays `key=value` over the values of a capture file. The key is a path of keys, where elements of arrays go by name
/// or are numbered from 0 (`lights.key.intensity_cd`, `lights.0.intensity_cd`); the value is TOML, or a bare word that
/// stands for itself.
pub(crate) fn set(source: &mut CaptureSource, argument: &str) -> Result<()> {
    let (key, value) = split_change(argument).unwrap_or((argument, ""));
    if let Some((table, key)) = key.trim().split_once('.') {
        let mut lost = Vec::new();
        for other in alternatives(table, key, value) {
            if (table, key) == ("lens", "prescription") && goes_with_prescription(source, other) {
                continue;
            }
            let Some(node) = source.remove(table, other) else { continue };
            // Poses and focus of a file give way to those of data sets and sweeps all the time, and a time that is
            // given means that none is found.
            let is_told = match table {
                "exposure" => *other != "auto" || source.is_of_argument(&node),
                "lens" => {
                    let whole_lens = ["prescription", "calibration"];
                    whole_lens.contains(&key) || whole_lens.contains(other)
                }
                _ => false,
            };
            if is_told {
                lost.push(format!("{table}.{other}"));
            }
        }
        source.note_displaced(argument, &lost);
    }
    set_in(source, "", "lens.f_number=4", argument)
}

/// Keys of the same table that say in another way what this one says. In a file the two cannot stand together; on the
/// command line, where nothing can be taken away, the one takes the place of the other.
fn alternatives(table: &str, key: &str, value: &str) -> &'static [&'static str] {
    match table {
        "exposure" => alternatives_in_exposure(key, value),
        "scene" => match key {
            // A light as a whole takes the place of another as a whole.
            "environment" => &["environment"],
            _ => &[],
        },
        "camera" => match key {
            "position_m" | "look_at_m" | "up" => &["gltf_camera", "calibration_pose"],
            "gltf_camera" => &["position_m", "look_at_m", "up", "calibration_pose"],
            "calibration_pose" => &["position_m", "look_at_m", "up", "gltf_camera"],
            // A motion as a whole takes the place of another as a whole.
            "motion" => &["motion", "position_m", "look_at_m", "up", "gltf_camera", "calibration_pose"],
            _ => &[],
        },
        "lens" => match key.split('.').next().unwrap_or_default() {
            "focus_distance_m" => &["autofocus_px"],
            "autofocus_px" => &["focus_distance_m"],
            "horizontal_fov_deg" => {
                &["focal_length_mm", "lensmaker", "intrinsics", "image_distance_mm", "prescription", "calibration"]
            }
            "focal_length_mm" | "image_distance_mm" => &["horizontal_fov_deg"],
            "lensmaker" | "intrinsics" => &["horizontal_fov_deg", "prescription", "calibration"],
            "projection" | "xi" | "distortion" => &["calibration"],
            "calibration" => &OF_CALIBRATION,
            "type" => &["prescription"],
            "prescription" => &OTHER_THAN_GLASS,
            _ => &[],
        },
        _ => &[],
    }
}

/// Keys of `[lens]` that describe a lens without its glass. A zoom's focal length and the sensor's distance are those
/// of the lens before, too.
const OTHER_THAN_GLASS: [&str; 19] = [
    "calibration",
    "calibration_camera",
    "calibration_area_px",
    "type",
    "focal_length_mm",
    "horizontal_fov_deg",
    "image_distance_mm",
    "lensmaker",
    "intrinsics",
    "distortion",
    "projection",
    "xi",
    "max_angle_deg",
    "min_focus_distance_m",
    "falloff",
    "stops",
    "lateral_colour",
    "supplementary",
    "psf",
];

/// Keys of `[lens]` that say in another way what a calibration does.
const OF_CALIBRATION: [&str; 7] =
    ["horizontal_fov_deg", "lensmaker", "intrinsics", "projection", "xi", "distortion", "prescription"];

/// Whether the value at a key that a prescription takes the place of is meant for it: diffraction of its own wave
/// fronts, and what arguments say of a lens of any kind.
fn goes_with_prescription(source: &CaptureSource, key: &str) -> bool {
    match key {
        "psf" => source.read::<String>("lens.psf.kind").is_ok_and(|kind| kind.as_deref() == Some("wave")),
        "focal_length_mm" | "image_distance_mm" => {
            source.get(&format!("lens.{key}")).is_some_and(|node| source.is_of_argument(node))
        }
        _ => false,
    }
}

fn alternatives_in_exposure(key: &str, value: &str) -> &'static [&'static str] {
    match (key, value) {
        ("iso", _) => &["gain_db", "digital_gain_db"],
        ("gain_db" | "digital_gain_db", _) => &["iso"],
        ("auto", "true") | ("max_time_s" | "max_gain_db", _) => &["time_s", "bracket_times_s"],
        ("auto_mean", _) => &["time_s", "bracket_times_s", "auto_target", "auto_brighter_part"],
        ("auto_target" | "auto_brighter_part", _) => &["time_s", "bracket_times_s", "auto_mean"],
        ("bracket_ev", _) => &["bracket_times_s"],
        ("time_s", _) => &[
            "auto",
            "auto_target",
            "auto_brighter_part",
            "auto_mean",
            "compensation_ev",
            "max_time_s",
            "max_gain_db",
            "bracket_times_s",
        ],
        ("bracket_times_s", _) => &[
            "auto",
            "auto_target",
            "auto_brighter_part",
            "auto_mean",
            "compensation_ev",
            "max_time_s",
            "max_gain_db",
            "time_s",
            "bracket_ev",
        ],
        _ => &[],
    }
}

/// Applies an override to a key below `table`.
pub(crate) fn set_below(source: &mut CaptureSource, table: &str, argument: &str) -> Result<()> {
    // With the name of the table, as a capture file has it, it is the same key.
    let prefix =
        if argument.trim_start().starts_with(&format!("{table}.")) { String::new() } else { format!("{table}.") };
    set_in(source, &prefix, "noise.read_noise_e=2", argument)
}

/// Applies an override to a key of a calibration target.
pub(crate) fn set_target(source: &mut CaptureSource, argument: &str) -> Result<()> {
    set_in(source, "target.", "square_mm=20", argument)
}

/// Applies an override to a key of synthetic noise.
pub(crate) fn set_noise(source: &mut CaptureSource, argument: &str) -> Result<()> {
    set_in(source, "noise.", "gaussian.sigma=4", argument)
}

fn set_in(source: &mut CaptureSource, prefix: &str, example: &str, argument: &str) -> Result<()> {
    let wrong = |what: String| {
        let help = Some(Remedy::Example(example.to_owned()).into());
        Error::Override { argument: shown(argument), message: what, help }
    };
    let Some((key, value)) = split_change(argument) else {
        return Err(wrong("there is no value".to_owned()));
    };
    // A key may not smuggle in a document of its own.
    if key.is_empty() || key.contains(['\n', '\r']) || has_outside_quotes(key, &['=', '#', '[', ']']) {
        return Err(wrong(format!("{key:?} is not a key")));
    }
    // A number beyond all others is refused as such, by its key.
    let is_endless = value.contains(|c: char| c.is_ascii_digit()) && value.parse().is_ok_and(f64::is_infinite);
    let toml = if is_endless || toml_value(value).is_some() {
        format!("{prefix}{key} = {value}")
    } else if is_bare_word(value) {
        format!("{prefix}{key} = {value:?}")
    } else {
        return Err(wrong(format!("{value:?} is neither a TOML value nor a word")));
    };
    source.set(argument, toml)
}

/// Whether a word, name or path, needs no quotes to be told from TOML.
fn is_bare_word(value: &str) -> bool {
    !value.is_empty() && value.chars().all(|c| c.is_alphanumeric() || "_-./:+ ".contains(c))
}
