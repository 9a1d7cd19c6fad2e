//! Paths in the values of a capture, made to lead to the same files from another folder.

use std::path::{Component, Path, PathBuf, absolute};

use photosite_core::key_path::{split_change, toml_value};
use serde_json::{Value, json};

use super::super::settings::sensor::close_sensor;
use super::super::tree::source::CaptureSource;
use photosite_core::Result;

/// Keys whose text is the path of a file.
const PATHS: [&str; 4] = ["file", "image", "texture", "calibration"];
/// Keys whose text is the path of a file, or the name of something that ships.
const PATHS_OR_NAMES: [&str; 2] = ["prescription", "preset"];

/// Rewrites every path in `value` that is relative to the folder `from` so that it is relative to `to`. Where that is no
/// folder, or there is no way from one to the other, as between drives, it becomes absolute.
pub(crate) fn relocate(value: &mut Value, from: &Path, to: Option<&Path>) {
    rewrite(value, &|path| relocated(path, from, to));
}

/// A change `key=value` that was typed on a command line: paths that lead to files from the current folder are rewritten
/// so that they lead there from `folder`, that of the capture, from which all others count.
pub fn typed_change(change: &str, folder: &Path) -> String {
    let parsed = split_change(change).and_then(|(key, value)| {
        let value = toml_value(value).unwrap_or_else(|| value.into());
        let last = key.rsplit('.').next().unwrap_or_default();
        Some((key, last, serde_json::to_value(value).ok()?))
    });
    let Some((key, last, value)) = parsed else { return change.to_owned() };
    let before = json!({ last: value });
    let mut after = before.clone();
    rewrite(&mut after, &|path| {
        if Path::new(path).is_file() { relative_path(Path::new(path), folder) } else { path.to_owned() }
    });
    if after == before {
        return change.to_owned();
    }
    toml::Value::try_from(&after[last]).map_or_else(|_| change.to_owned(), |value| format!("{key}={value}"))
}

/// Rewrites every path in a value.
fn rewrite(value: &mut Value, rewritten: &dyn Fn(&str) -> String) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                match value {
                    Value::String(path) if PATHS.contains(&key.as_str()) => *path = rewritten(path),
                    // What ships goes by its name.
                    Value::String(path) if PATHS_OR_NAMES.contains(&key.as_str()) && path.contains('.') => {
                        *path = rewritten(path);
                    }
                    Value::Array(items) if key == "geometry" => {
                        for item in items {
                            if let Value::String(path) = item {
                                *path = rewritten(path);
                            }
                        }
                    }
                    Value::Object(_) | Value::Array(_) => rewrite(value, rewritten),
                    Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| rewrite(item, rewritten)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

fn relocated(path: &str, from: &Path, to: Option<&Path>) -> String {
    let Some(file) = whole(&from.join(path)) else { return path.to_owned() };
    let relative = match to.map(whole) {
        Some(Some(to)) => pathdiff::diff_paths(&file, to),
        // The working folder, from which paths are read as they stand.
        Some(None) => return path.to_owned(),
        None => None,
    };
    relative.unwrap_or(file).to_string_lossy().into_owned()
}

/// A path as it reads from a folder, which must exist, however it was typed: the way from the one real folder to the
/// other. Where there is none, as between drives, the path from the root.
pub fn relative_path(path: &Path, folder: &Path) -> String {
    let path = real_path(path);
    let relative = folder.canonicalize().ok().and_then(|folder| pathdiff::diff_paths(&path, folder));
    relative.unwrap_or(path).to_string_lossy().into_owned()
}

/// The path from the root without links to folders. The file itself may be one: what it names is sought beside the
/// link.
pub fn real_path(path: &Path) -> PathBuf {
    let absolute = absolute(path).unwrap_or_else(|_| path.to_owned());
    match (absolute.parent().map(Path::canonicalize), absolute.file_name()) {
        (Some(Ok(folder)), Some(name)) => folder.join(name),
        _ => absolute,
    }
}

/// The path from the root, without links and steps back where it exists, and without steps back where it does not.
/// `None` where there is no current folder.
fn whole(path: &Path) -> Option<PathBuf> {
    if let Ok(path) = path.canonicalize() {
        return Some(path);
    }
    let mut whole = PathBuf::new();
    for part in absolute(path).ok()?.components() {
        if part == Component::ParentDir {
            whole.pop();
        } else {
            whole.push(part);
        }
    }
    Some(whole)
}

/// All keys of a capture, with paths relative to the folder `to`, or absolute ones.
pub(crate) fn keys_of(source: &CaptureSource, sensor: &str, to: Option<&Path>) -> Result<serde_json::Value> {
    let mut keys: serde_json::Value = source.read_whole()?;
    if let Some(table) = keys.get_mut("sensor") {
        close_sensor(table, sensor);
    }
    for (section, value) in keys.as_object_mut().into_iter().flatten() {
        // Curves of the sensor, which may come from a file of its own, are relative to the current folder already.
        let from = if section == "sensor" { None } else { source.path().parent() };
        relocate(value, from.unwrap_or(Path::new("")), to);
    }
    Ok(keys)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn paths_lead_to_the_same_files() {
        let mut value = json!({
            "scene": { "geometry": ["room.obj", "/data/vase.obj"], "environment": { "image": "skies/noon.hdr" } },
            "materials": { "file": { "type": "diffuse", "reflectance": { "file": "../red.csv" } } },
            "lights": [{ "spectrum": { "file": "lamp.csv" } }],
            "sensor": { "preset": "file" },
            "lens": { "prescription": "../50mm.zmx", "calibration": "camchain.yaml" },
            "other": { "prescription": "double-gauss" },
        });
        let mut absolute = value.clone();
        relocate(&mut absolute, Path::new("/scenes/room"), None);
        assert_eq!(absolute["scene"]["geometry"][0], "/scenes/room/room.obj");
        assert_eq!(absolute["materials"]["file"]["reflectance"]["file"], "/scenes/red.csv");
        let mut as_it_stands = value.clone();
        relocate(&mut as_it_stands, Path::new(""), Some(Path::new("")));
        assert_eq!(as_it_stands, value);
        relocate(&mut value, Path::new("scenes/room"), Some(Path::new("out/first")));
        assert_eq!(value["scene"]["geometry"][0], "../../scenes/room/room.obj");
        assert!(value["scene"]["geometry"][1].as_str().expect("a path").ends_with("../data/vase.obj"));
        assert_eq!(value["scene"]["environment"]["image"], "../../scenes/room/skies/noon.hdr");
        assert_eq!(value["materials"]["file"]["reflectance"]["file"], "../../scenes/red.csv");
        assert_eq!(value["lights"][0]["spectrum"]["file"], "../../scenes/room/lamp.csv");
        assert_eq!(value["sensor"]["preset"], "file");
        assert_eq!(value["lens"]["prescription"], "../../scenes/50mm.zmx");
        assert_eq!(value["lens"]["calibration"], "../../scenes/room/camchain.yaml");
        assert_eq!(value["other"]["prescription"], "double-gauss");
    }
}
