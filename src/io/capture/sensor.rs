//! `[sensor]`: a preset or sensor file, with the keys of the table laid over it.

use std::path::Path;

use super::colour::Finder;
use super::overrides;
use super::read_text;
use super::source::CaptureSource;
use super::tables::MergedSensor;
use super::tree::{Node, Value, parse};
use crate::io::suggest::{did_you_mean, list};
use crate::sensor::{SensorModel, presets};
use crate::spectrum::Outside;
use crate::{Error, Invalid, Result};

/// Makes the model of a sensor.
pub(super) fn sensor_model(sensor: &MergedSensor) -> Result<SensorModel, Invalid> {
    // Its paths start at no folder any more.
    let finder = Finder::new(Path::new(""), Vec::new());
    SensorModel::new(&sensor.name, &sensor.description, |spectrum| finder.spectrum(spectrum, Outside::Zero))
}

/// Reads the sensor and puts the merged table in the place of `[sensor]`, so that errors of its keys find their line.
/// Paths of curves are relative to `folder` no more, but can be used as they are.
pub(super) fn read_sensor(source: &mut CaptureSource, folder: &Path) -> Result<MergedSensor> {
    let mut changes = match source.get("sensor") {
        Some(node) if node.as_table().is_some() => node.clone(),
        Some(_) => {
            let help = format!("write [sensor] with preset = {:?}", presets::DEFAULT);
            return Err(source.error(Invalid::new("sensor", "expected a table").help(help)));
        }
        None => Node { span: 0..0, value: Value::Table(Default::default()) },
    };
    let preset = changes.remove("preset");
    let name = match preset.as_ref().map(|node| node.as_str().ok_or(node)) {
        None => presets::DEFAULT.to_owned(),
        Some(Ok(name)) => name.to_owned(),
        Some(Err(_)) => {
            let help = format!("for example preset = {:?}", presets::DEFAULT);
            return Err(source.error(Invalid::new("sensor.preset", "expected the name of a sensor").help(help)));
        }
    };
    let mut merged = base(source, folder, &name, preset.as_ref().unwrap_or(&changes))?;
    anchor_files(&mut changes, folder);
    let changed = |key| changes.as_table().is_some_and(|table| table.contains_key(key));
    for [key, other] in ALTERNATIVES.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]) {
        if changed(key) && !changed(other) {
            merged.remove(other);
        }
    }
    for [table, kind] in KINDS {
        if said(&changes, table, kind).is_some_and(|new| said(&merged, table, kind) != Some(new)) {
            merged.remove(table);
        }
    }
    merged.lay_over(changes);
    // The place of the table as a whole is where the capture file speaks of it.
    if let Some(node) = source.get("sensor") {
        merged.span = node.span.clone();
    }
    source.replace("sensor", merged);

    let description = source.read("sensor")?.ok_or_else(|| source.error(Invalid::new("sensor", "is missing")))?;
    let name = Path::new(&name).file_stem().map_or_else(|| name.clone(), |stem| stem.to_string_lossy().into_owned());
    Ok(MergedSensor { name, description })
}

/// Keys of a sensor that say the same thing in two ways: one of them in a capture file takes the place of the other.
const ALTERNATIVES: [[&str; 2]; 1] = [["pixel_pitch_um", "format"]];

/// Tables with the key that says what the others mean: where a capture file changes that, none of the preset's stay.
const KINDS: [[&str; 2]; 2] = [["shutter", "kind"], ["spad", "counting"]];

/// The text at a key of a table of the sensor.
fn said<'a>(sensor: &'a Node, table: &str, key: &str) -> Option<&'a str> {
    sensor.as_table()?.get(table)?.node.as_table()?.get(key)?.node.as_str()
}

/// Reads a sensor of which all keys are there, whatever preset they come from.
pub(super) fn read_whole_sensor(source: &mut CaptureSource, name: &str) -> Result<MergedSensor> {
    let mut table =
        source.get("sensor").cloned().unwrap_or(Node { span: 0..0, value: Value::Table(Default::default()) });
    table.remove("preset");
    source.replace("sensor", table);
    let description = source.read("sensor")?.ok_or_else(|| source.error(Invalid::new("sensor", "is missing")))?;
    Ok(MergedSensor { name: name.to_owned(), description })
}

/// Reads a sensor file by itself; `None` where the file is no sensor file, as it has no `[adc]`.
pub fn read_sensor_file(path: &Path) -> Result<Option<SensorModel>> {
    let source = CaptureSource::parse(path, read_text(path)?)?;
    if !source.sections().any(|(key, _)| key == "adc") {
        return Ok(None);
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let finder = Finder::new(folder, Vec::new());
    let model = SensorModel::new(&stem, &source.read_whole()?, |spectrum| finder.spectrum(spectrum, Outside::Zero));
    model.map(Some).map_err(|invalid| source.error(invalid))
}

/// A sensor by the name of a preset or the path of a sensor file, with the `key=value` of every `--set` laid over its
/// keys.
pub fn read_named_sensor(name: &str, overrides: &[String]) -> Result<SensorModel> {
    if is_path(name) {
        std::fs::metadata(name).map_err(|reason| Error::io(Path::new(name), "read", reason))?;
    } else if presets::table(name).is_none() {
        let Invalid { message, help, .. } = unknown_preset(name);
        return Err(Error::Usage { message, help });
    }
    let mut source = CaptureSource::of_scene_file(Path::new(name));
    source.set("", format!("sensor.preset = {}", toml::Value::from(name)))?;
    for argument in overrides {
        overrides::set_below(&mut source, "sensor", argument)?;
    }
    let merged = read_sensor(&mut source, Path::new(""))?;
    sensor_model(&merged).map_err(|invalid| source.error(invalid.within("sensor")))
}

/// The table of a preset or of a sensor file. Values of a preset are placed where it is named.
fn base(source: &mut CaptureSource, folder: &Path, name: &str, place: &Node) -> Result<Node> {
    if is_path(name) {
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).map_err(|reason| {
            let message = format!("cannot read {}: {reason}", path.display());
            let help = "paths are relative to the file that they are written in";
            source.error(Invalid::new("sensor.preset", message).help(help))
        })?;
        let mut node = source.add_file(&path, text)?;
        anchor_files(&mut node, path.parent().unwrap_or(Path::new("")));
        return Ok(node);
    }
    let table = presets::table(name).ok_or_else(|| source.error(unknown_preset(name)))?;
    // A preset is known to be good; what can be wrong is what a capture file makes of it.
    let mut node =
        parse(&table.to_string(), 0).map_err(|(_, message)| source.error(Invalid::new("sensor.preset", message)))?;
    node.place_at(&place.span);
    Ok(node)
}

/// Whether a sensor is named by a file, not as a preset.
fn is_path(name: &str) -> bool {
    name.contains(['/', '\\']) || name.to_ascii_lowercase().ends_with(".toml")
}

fn unknown_preset(name: &str) -> Invalid {
    let message = format!("photosite has no sensor {name:?}{}", did_you_mean(name, presets::names()));
    let help =
        format!("known are {}; a file is written with its ending, \"{name}.toml\"", list(name, presets::names()));
    Invalid::new("sensor.preset", message).help(help)
}

/// Makes the paths of `{ file = "…" }` relative to `folder` rather than to the file that they stand in.
pub(super) fn anchor_files(node: &mut Node, folder: &Path) {
    let Value::Table(table) = &mut node.value else { return };
    for (key, entry) in table {
        match &mut entry.node.value {
            Value::String(file) if key == "file" => *file = folder.join(&*file).to_string_lossy().into_owned(),
            Value::Table(_) => anchor_files(&mut entry.node, folder),
            Value::String(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Boolean(_)
            | Value::Datetime(_)
            | Value::Array(_) => {}
        }
    }
}
