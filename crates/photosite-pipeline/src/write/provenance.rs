//! Provenance of a result: the keys of its capture and the files that these name, which decide its bytes.

use std::path::Path;

use photosite_capture::{Capture, CaptureSource, relative_path};
use photosite_core::Result;
use photosite_files::file_sum::hex;
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

/// The key of the hash of all the others.
pub(crate) const FINGERPRINT: &str = "fingerprint";

/// The key of the device that traced the light, where that was not the processor.
pub const DEVICE: &str = "device";

/// Provenance: everything that decides what a render gives.
pub(crate) fn provenance(capture: &Capture) -> Result<Map<String, Value>> {
    let mut hashes = Map::new();
    let keys = keys_and_files(capture, &mut hashes)?;
    let mut whole = json!({
        "photosite_version": env!("CARGO_PKG_VERSION"),
        "capture": keys,
        "files_sha256": hashes,
    });
    // The processor goes without saying.
    if let (Some(device), Some(whole)) = (capture.device(), whole.as_object_mut()) {
        whole.insert(DEVICE.to_owned(), device.name().into());
    }
    Ok(fingerprinted(whole))
}

/// The keys of a capture, with paths relative to its own folder. The hashes of all files that they name are added to
/// `hashes`.
pub fn keys_and_files(capture: &Capture, hashes: &mut Map<String, Value>) -> Result<Value> {
    let folder = capture.source().path().parent().unwrap_or(Path::new(""));
    // Names do not depend on where the command was given: an absolute path becomes relative, too, from the current folder.
    let named_from = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let values = capture.to_json(named_from)?;
    add_files(&values, (folder, capture.source()), hashes)?;
    // What scenes and calibrations name in turn
    let mut in_turn = capture.scene().files.iter().chain(capture.calibration_files());
    in_turn.try_for_each(|path| add_file(&relative_path(path, named_from), path, capture.source(), hashes))?;
    Ok(values)
}

/// Adds the hash of a file by its name, which is relative to the folder of a capture.
pub fn add_file_of(capture: &Capture, name: &str, hashes: &mut Map<String, Value>) -> Result<()> {
    let folder = capture.source().path().parent().unwrap_or(Path::new(""));
    add_file(name, &folder.join(name), capture.source(), hashes)
}

fn add_files(
    values: &Value,
    place @ (folder, source): (&Path, &CaptureSource),
    hashes: &mut Map<String, Value>,
) -> Result<()> {
    match values {
        Value::String(name) => {
            let path = folder.join(name);
            // A text may happen to be the name of a file.
            if !name.is_empty() && source.sandbox().check(&path).is_ok() && (path.is_file() || source.sums().has(&path))
            {
                add_file(name, &path, source, hashes)
            } else {
                Ok(())
            }
        }
        Value::Array(values) => values.iter().try_for_each(|value| add_files(value, place, hashes)),
        Value::Object(table) => table.values().try_for_each(|value| add_files(value, place, hashes)),
        Value::Null | Value::Bool(_) | Value::Number(_) => Ok(()),
    }
}

fn add_file(name: &str, path: &Path, source: &CaptureSource, hashes: &mut Map<String, Value>) -> Result<()> {
    hashes.insert(name.to_owned(), source.sums().of(path)?.sha256.into());
    Ok(())
}

/// An object with the hash of all that it says at its head.
pub fn fingerprinted(whole: Value) -> Map<String, Value> {
    let fingerprint = hex(&Sha256::digest(whole.to_string()));
    let keys = if let Value::Object(keys) = whole { keys } else { Map::new() };
    std::iter::once((FINGERPRINT.to_owned(), Value::from(fingerprint))).chain(keys).collect()
}

/// The first thing in which the provenance of two results differs, of the later one.
pub fn difference(earlier: &Value, now: &Value) -> &'static str {
    let parts = [
        ("photosite_version", "it was made by another version of photosite"),
        ("dataset", "the data set file says something else"),
        ("overrides", "its overrides say something else"),
        ("captures", "the capture says something else"),
        ("capture", "the capture says something else"),
        ("files_sha256", "a file that the capture names has changed"),
        (DEVICE, "its light was traced on another device"),
    ];
    parts.into_iter().find(|(key, _)| earlier[key] != now[key]).map_or("it is not the same", |(_, what)| what)
}
