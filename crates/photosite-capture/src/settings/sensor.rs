//! Sensor of a capture, `[sensor]`: a preset or sensor file, with the keys of the table laid over it.
//!
//! A preset is taken as a whole, without some of its keys (`without`), or not at all (`preset = "none"`). The sensor
//! that a report holds is whole; changes are laid over it as over a preset.

use std::marker::PhantomData;
use std::path::Path;

use serde_json::json;

use super::super::tables::MergedSensor;
use super::super::tables::file_kind::FileKind;
use super::super::tables::spectra::Finder;
use super::super::tree::nodes::{Node, Table, Value, join, parse};
use super::super::tree::overrides;
use super::super::tree::source::CaptureSource;
use super::super::tree::text_file::read_text;
use super::converter_bits::follow_bits;
use super::sensor_size::scale_to;
use photosite_core::Sandbox;
use photosite_core::input;
use photosite_core::spectrum::{Outside, Spectrum};
use photosite_core::suggest::{did_you_mean, list};
use photosite_core::{Error, Invalid, Result};
use photosite_files::map_file::{MapFile, read_map};
use photosite_sensor::{DefectFile, MeasuredPattern, PatternFile, SensorFiles, SensorModel, SpectrumSource, presets};

/// Finder of the files that a sensor names.
struct OfSensor<'f, 'a>(&'f Finder<'a>);

impl SensorFiles for OfSensor<'_, '_> {
    fn spectrum(&mut self, source: &SpectrumSource) -> Result<Spectrum, Invalid> {
        self.0.spectrum(source, Outside::Zero)
    }

    fn pattern(&mut self, pattern: &PatternFile) -> Result<MeasuredPattern, Invalid> {
        const FORMS: &str = "write an EXR, TIFF or NPY image of floats, one for each pixel, row by row";
        let path = self.0.path(&pattern.file).map_err(|invalid| invalid.within("file"))?;
        let refused = |message: String| {
            let is_there = !pattern.file.is_empty() && path.is_file();
            let help = if is_there { FORMS } else { "write the path relative to the file that names it" };
            Invalid::new("file", message).help(help)
        };
        let of_file = |what: &str| refused(format!("{}: {what}", path.display()));
        let MapFile { size, values, is_codes, warnings } =
            read_map(&path, None).map_err(|error| refused(error.to_string()))?;
        if is_codes {
            return Err(of_file("holds whole numbers"));
        }
        if let Some(warning) = warnings.first() {
            return Err(of_file(warning));
        }
        MeasuredPattern::new(size, values).map_err(|invalid| of_file(&invalid.message))
    }

    fn defects(&mut self, file: &DefectFile) -> Result<String, Invalid> {
        let path = self.0.path(&file.file).map_err(|invalid| invalid.within("file"))?;
        input::read_text(&path, input::TABLE_BYTES).map_err(|reason| {
            let message = format!("cannot read {}: {reason}", path.display());
            Invalid::new("file", message).help("write the path relative to the file that names it")
        })
    }
}

/// Makes the model of a sensor.
pub(crate) fn sensor_model(sensor: &MergedSensor, sandbox: &Sandbox) -> Result<SensorModel, Invalid> {
    // Its paths start at no folder any more.
    let finder = Finder::new(Path::new(""), sandbox, Vec::new());
    SensorModel::new(&sensor.name, &sensor.description, OfSensor(&finder))
}

/// The preset of sensors that begin from nothing.
const NOTHING: &str = "none";

/// Name of a sensor that begins from nothing and has no name.
pub(crate) const UNNAMED: &str = "sensor";

/// Keys of `[sensor]` that say which sensor it is, and are not of the sensor itself.
const OF_CAPTURES: [&str; 3] = ["preset", "without", "scaled_to_px"];

/// Reads the sensor and puts the merged table in the place of `[sensor]`, so that errors of its keys find their line.
/// Paths of curves are relative to `folder` no more, but can be used as they are.
pub(crate) fn read_sensor(source: &mut CaptureSource, folder: &Path) -> Result<MergedSensor> {
    let table = match source.get("sensor") {
        Some(node) if node.as_table().is_some() => node.clone(),
        Some(_) => {
            let help = format!("write [sensor] with preset = {:?}", presets::DEFAULT);
            return Err(source.error(Invalid::new("sensor", "expected a table").help(help)));
        }
        None => empty_table(),
    };
    let mut changes = table.clone();
    let [preset, without, scaled_to] = OF_CAPTURES.map(|key| changes.remove(key));
    let (mut merged, name) = base(source, folder, preset.as_ref(), &changes)?;
    by_itself(source, &merged, "sensor.")?;
    if let Some(without) = without {
        take_away(source, &mut merged, &name, &without)?;
    }
    anchor_files(&mut changes, folder);
    let of_file = preset.as_ref().and_then(|preset| keys_over_preset(source, preset, &merged, &table));
    let mut warnings: Vec<_> = of_file.into_iter().chain(follow_bits(&mut merged, &changes)).collect();
    let changed = |key| changes.as_table().is_some_and(|table| table.contains_key(key));
    for [key, other] in ALTERNATIVES.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]) {
        if changed(key) && !changed(other) {
            merged.remove(other);
        }
    }
    for (key, tables) in KINDS {
        let stated = |sensor: &Node| sensor.at(key).and_then(Node::as_str).map(str::to_owned);
        if stated(&changes).is_some_and(|new| stated(&merged) != Some(new)) {
            tables.iter().for_each(|table| drop(merged.remove(table)));
        }
    }
    merged.lay_over(changes).map_err(|error| source.no_element("sensor", error))?;
    if let Some(size) = scaled_to {
        warnings.extend(scale_to(source, &mut merged, &size)?);
    }
    // The place of the table as a whole is where the capture file speaks of it.
    if let Some(node) = source.get("sensor") {
        merged.span = node.span.clone();
    }
    source.replace("sensor", merged);

    let table = source.get("sensor").ok_or_else(|| source.error(Invalid::new("sensor", "is missing")))?;
    let description = source.read_beside("sensor", table, PhantomData, &OF_CAPTURES)?;
    Ok(MergedSensor { name, description, warnings })
}

/// Refuses a sensor file that names another sensor. `prefix` begins its keys in messages.
fn by_itself(source: &CaptureSource, file: &Node, prefix: &str) -> Result<()> {
    let Some((key, node)) = OF_CAPTURES.into_iter().find_map(|key| Some((key, file.at(&[key])?))) else {
        return Ok(());
    };
    let message = format!("`{key}` stands in [sensor] of a capture; a sensor file states its sensor by itself");
    let help =
        "write all keys of the sensor, or name the preset where a sensor is asked for, and change its keys by --set";
    Err(source.error_at_node(node, Invalid::new(format!("{prefix}{key}"), message).help(help)))
}

/// Warning where an override names the preset and the file's own keys of `[sensor]`, meant for another, stay over it.
fn keys_over_preset(source: &CaptureSource, preset: &Node, base: &Node, table: &Node) -> Option<String> {
    if !source.is_of_argument(preset) {
        return None;
    }
    let mut keys = Vec::new();
    differing_keys(source, "", Some(base), table, &mut keys);
    let (name, keys) = (preset.as_str().unwrap_or_default(), keys.join(", "));
    (!keys.is_empty()).then(|| {
        format!(
            "sensor.preset is {name:?} now, and these keys of [sensor] in the file stay over it, where it has others: \
             {keys}; remove them from the file, or set them, too, for the sensor of that name"
        )
    })
}

/// Paths of the keys of the file, not of overrides, that a preset has otherwise or not at all.
fn differing_keys(source: &CaptureSource, path: &str, base: Option<&Node>, over: &Node, keys: &mut Vec<String>) {
    match over.as_table() {
        Some(table) => {
            for (key, entry) in table {
                let below = base.and_then(|base| base.at(&[key]));
                differing_keys(source, &join(path, key), below, &entry.node, keys);
            }
        }
        // What no text states, such as the size of an image that is exposed, has no place in one.
        None if over.span.is_empty() => {}
        None => {
            if !source.is_of_argument(over) && !base.is_some_and(|base| base.means(over)) {
                keys.push(path.to_owned());
            }
        }
    }
}

/// Names [`NOTHING`] as the preset of a sensor that has all of its keys, so that nothing else comes in when it is read
/// again.
pub(crate) fn close_sensor(sensor: &mut serde_json::Value, name: &str) {
    let head = json!({ "preset": NOTHING, "name": name });
    if let (serde_json::Value::Object(keys), serde_json::Value::Object(mut closed)) = (sensor, head) {
        let keys_but_the_head = std::mem::take(keys).into_iter().filter(|(key, _)| !closed.contains_key(key));
        let rest: Vec<_> = keys_but_the_head.collect();
        closed.extend(rest);
        *keys = closed;
    }
}

/// Keys of a sensor that say the same thing in two ways: one of them in a capture file takes the place of the other.
const ALTERNATIVES: [[&str; 2]; 1] = [["pixel_pitch_um", "format"]];

/// Keys that say what whole tables mean: where a capture file changes one, the preset's own tables do not stay.
const KINDS: [(&[&str], &[&str]); 3] =
    [(&["kind"], &["ccd", "spad"]), (&["shutter", "kind"], &["shutter"]), (&["spad", "counting"], &["spad"])];

/// Takes the keys of a list away from a preset.
fn take_away(source: &CaptureSource, base: &mut Node, name: &str, without: &Node) -> Result<()> {
    let keys: Vec<String> = source.read_node("sensor.without", without)?;
    for (i, key) in keys.iter().enumerate() {
        let path: Vec<&str> = key.split('.').map(str::trim).collect();
        let taken = path.split_last().and_then(|(last, tables)| base.at_mut(tables)?.remove(last));
        if taken.is_none() {
            let there = base.paths();
            let there = || there.iter().map(String::as_str);
            let message = format!("sensor {name} has no {key:?} to remove{}", did_you_mean(key, there()));
            let help = match list(key, there()) {
                keys if keys.is_empty() => "there is nothing in it; remove the key".to_owned(),
                keys => format!("it has {keys}"),
            };
            return Err(source.error(Invalid::new(format!("sensor.without[{i}]"), message).help(help)));
        }
    }
    Ok(())
}

fn empty_table() -> Node {
    Node { span: 0..0, value: Value::Table(Table::new()) }
}

/// Reads a sensor file by itself; `None` where the file is no sensor file, as it has no `[adc]`.
pub fn read_sensor_file(path: &Path, sandbox: &Sandbox) -> Result<Option<SensorModel>> {
    let source = CaptureSource::parse(path, read_text(path)?)?;
    if !source.sections().any(|(key, _)| key == "adc") {
        return Ok(None);
    }
    if let Some(root) = source.get("") {
        by_itself(&source, root, "")?;
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let finder = Finder::new(folder, sandbox, Vec::new());
    let model = SensorModel::new(&stem, &source.read_whole()?, OfSensor(&finder));
    model.map(Some).map_err(|invalid| source.error(invalid))
}

/// A sensor that was read by its name.
#[derive(Clone, Debug)]
pub struct NamedSensor {
    /// The sensor.
    pub model: SensorModel,
    /// Values of all its keys.
    pub values: serde_json::Value,
    /// Warnings about its keys.
    pub warnings: Vec<String>,
}

/// A sensor by the name of a preset or the path of a sensor file, with overrides, `key=value`, laid over its keys.
pub fn read_named_sensor(sandbox: &Sandbox, name: &str, overrides: &[String]) -> Result<NamedSensor> {
    if is_path(name) {
        input::metadata(Path::new(name)).map_err(|reason| Error::io(Path::new(name), "read", reason))?;
    } else if presets::table(name).is_none() {
        let Invalid { message, help, .. } = unknown_preset(name);
        return Err(Error::Usage { message, help });
    }
    let mut source = CaptureSource::empty(Path::new(name)).within(sandbox);
    source.set("", format!("sensor.preset = {}", toml::Value::from(name)))?;
    for argument in overrides {
        overrides::set_below(&mut source, "sensor", argument)?;
    }
    let merged = read_sensor(&mut source, Path::new(""))?;
    let model = sensor_model(&merged, source.sandbox()).map_err(|invalid| source.error(invalid.within("sensor")))?;
    let warnings = merged.warnings.into_iter().chain(model.warnings()).collect();
    Ok(NamedSensor { model, values: source.read("sensor")?.unwrap_or_default(), warnings })
}

/// Base of the changes, and its name: the sensor that a report holds, else the default, unless a preset is named.
fn base(source: &mut CaptureSource, folder: &Path, preset: Option<&Node>, changes: &Node) -> Result<(Node, String)> {
    let name = match preset.map(|node| node.as_str().ok_or(node)) {
        None => None,
        Some(Ok(name)) => Some(name.to_owned()),
        Some(Err(_)) => {
            let help = format!("for example preset = {:?}", presets::DEFAULT);
            return Err(source.error(Invalid::new("sensor.preset", "expected the name of a sensor").help(help)));
        }
    };
    let stored = source.stored_sensor().cloned();
    match (name, stored) {
        (None, None) => named(source, folder, presets::DEFAULT, preset.unwrap_or(changes)),
        (None, Some(mut stored)) => {
            anchor_files(&mut stored, source.path().parent().unwrap_or(Path::new("")));
            let name = stored.at(&["name"]).and_then(Node::as_str).unwrap_or(UNNAMED).to_owned();
            Ok((stored, name))
        }
        (Some(name), None) => named(source, folder, &name, preset.unwrap_or(changes)),
        (Some(name), Some(mut stored)) => {
            let (mut other, name) = named(source, folder, &name, preset.unwrap_or(changes))?;
            // Stored light has its number of pixels, and so has every position in the image; cameras of a
            // rig keep different serial numbers.
            for key in ["resolution_px", "serial"] {
                if let Some(value) = stored.remove(key) {
                    other.remove(key);
                    other.insert_new(key, value);
                }
            }
            Ok((other, name))
        }
    }
}

/// The table of a preset or of a sensor file, and its name. Values of a preset are placed where it is named.
fn named(source: &mut CaptureSource, folder: &Path, name: &str, place: &Node) -> Result<(Node, String)> {
    if name == NOTHING {
        return Ok((empty_table(), UNNAMED.to_owned()));
    }
    if is_path(name) {
        let path = folder.join(name);
        // What the user has given himself in the place of a capture may lie anywhere.
        let is_allowed = if path == source.path() { Ok(()) } else { source.sandbox().check(&path) };
        is_allowed.map_err(|invalid| source.error(invalid.within("sensor.preset")))?;
        let text = input::read_text(&path, input::TREE_BYTES).map_err(|reason| {
            let message = format!("cannot read {}: {reason}", path.display());
            let help = "paths are relative to the file that contains them";
            source.error(Invalid::new("sensor.preset", message).help(help))
        })?;
        let mut node = source.add_file(&path, text)?;
        let kind = FileKind::of_keys(node.as_table().into_iter().flatten().map(|(key, _)| key.as_str()));
        if let Some(kind @ (FileKind::Capture | FileKind::DataSet | FileKind::Lens)) = kind {
            if path == source.path() {
                return Err(kind.instead_of("a sensor file", &path));
            }
            let Invalid { message, help, .. } = kind.refusal("a sensor file", &path);
            let message = format!("{name} {message}");
            return Err(source.error(Invalid { key: "sensor.preset".to_owned(), message, help }));
        }
        anchor_files(&mut node, path.parent().unwrap_or(Path::new("")));
        return Ok((node, path.file_stem().unwrap_or_default().to_string_lossy().into_owned()));
    }
    let Some(table) = presets::table(name) else {
        let file = FileKind::check_named(&folder.join(name), &[FileKind::Sensor], "a sensor file");
        return Err(
            source.error(file.err().map_or_else(|| unknown_preset(name), |other| other.within("sensor.preset")))
        );
    };
    // A preset is known to be good; what can be wrong is what a capture file makes of it.
    let mut node =
        parse(&table.to_string(), 0).map_err(|(_, message)| source.error(Invalid::new("sensor.preset", message)))?;
    node.place_at(&place.span);
    Ok((node, name.to_owned()))
}

/// Whether a sensor is named by a file, not as a preset.
fn is_path(name: &str) -> bool {
    name.contains(['/', '\\']) || name.to_ascii_lowercase().ends_with(".toml")
}

fn unknown_preset(name: &str) -> Invalid {
    let message = format!("photosite has no sensor {name:?}{}", did_you_mean(name, presets::names()));
    let help =
        format!("known names are {}; write a file with its extension, \"{name}.toml\"", list(name, presets::names()));
    Invalid::new("sensor.preset", message).help(help)
}

/// Makes the paths of `{ file = "…" }` relative to `folder` rather than to the file that they stand in.
pub(crate) fn anchor_files(node: &mut Node, folder: &Path) {
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
