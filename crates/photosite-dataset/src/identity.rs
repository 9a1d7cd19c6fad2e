//! Identity of a data set folder: `dataset.json`, written once and compared from then on.

use std::ops::Range;
use std::path::Path;

use photosite_core::input;
use serde_json::{Map, Value, json};

use photosite_calibration::dataset::{Found, Plan, SamplingDescription};
use photosite_calibration::truth::{Needs, TruthLayer};
use photosite_capture::{Capture, DatasetFile, real_path};
use photosite_core::{Error, Invalid, Result};
use photosite_pipeline::{DEVICE, add_file_of, difference, fingerprinted, keys_and_files};

/// Name of the file that identifies a data set.
pub const IDENTITY: &str = "dataset.json";
/// Key of the part in the identities of part folders.
pub(super) const OF_PART: &str = "part";
/// Keys of the number of frames and of the cameras; absent in folders of earlier versions.
pub(super) const FRAMES: &str = "frames";
pub(super) const CAMERAS: &str = "cameras";

/// Identity: everything that decides the content of the images, which is version, description, captures and the files
/// that these name. The number of frames decides nothing, unless a key goes from one value to another over all of them
/// or flow refers to the next one.
pub(super) fn identity<'a>(
    file: &DatasetFile,
    mut captures: impl Iterator<Item = &'a Capture> + Clone,
    overrides: &[String],
    (plan, found): (&Plan, &[Found]),
) -> Result<Value> {
    let mut description = file.values.clone();
    let sweeps = file.description.vary.iter().any(|variation| variation.sweep.is_some())
        || file.description.sampling == SamplingDescription::LatinHypercube;
    // Flow of the last frame leads nowhere.
    let flows = captures.clone().any(|capture| TruthLayer::any_needs(&capture.output().truth.layers, Needs::NextImage));
    if let (false, Value::Object(keys)) = (sweeps || flows, &mut description) {
        keys.remove("frames");
    }
    let mut named = Map::new();
    let mut keys = Vec::new();
    for capture in captures.clone() {
        keys.push(keys_and_files(capture, &mut named)?);
    }
    if let Some(first) = captures.next() {
        for name in found.iter().flat_map(|found| &found.files) {
            add_file_of(first, name, &mut named)?;
        }
    }
    let mut identity = fingerprinted(json!({
        "photosite_version": env!("CARGO_PKG_VERSION"),
        "dataset": description,
        "overrides": overrides,
        "captures": keys,
        "files_sha256": named,
    }));
    // How much there is to be, which decides nothing of any image.
    identity.insert(FRAMES.to_owned(), plan.frames().into());
    let cameras = plan.cameras().iter().map(|camera| &*camera.place.name).collect();
    identity.insert(CAMERAS.to_owned(), cameras);
    Ok(Value::Object(identity))
}

/// Identity of the same images with light that a device has traced.
pub(super) fn on_device(identity: &Value, device: &str) -> Value {
    let (extent, deciding): (Map<String, Value>, Map<String, Value>) = identity
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(key, _)| *key != "fingerprint")
        .map(|(key, value)| (key.clone(), value.clone()))
        .chain([(DEVICE.to_owned(), device.into())])
        .partition(|(key, _)| [FRAMES, CAMERAS].contains(&&**key));
    Value::Object(fingerprinted(Value::Object(deciding)).into_iter().chain(extent).collect())
}

/// An earlier identity of the same images with the current number of frames; `None` where both have the same.
pub(super) fn with_extent_of(earlier: &Value, now: &Value) -> Option<Value> {
    let extent = [FRAMES, CAMERAS];
    if extent.iter().all(|key| earlier.get(key) == now.get(key)) {
        return None;
    }
    let mut identity = earlier.as_object()?.clone();
    identity.extend(extent.iter().filter_map(|key| Some(((*key).to_owned(), now.get(key)?.clone()))));
    Some(Value::Object(identity))
}

/// Identity of a folder that holds a part of every image, made from the data set file `input`.
pub(super) fn part_identity(identity: &Value, samples: &Range<u32>, input: &Path) -> Value {
    let part = json!({ "samples": [samples.start, samples.end], "path": real_path(input) });
    let keys = identity.as_object().into_iter().flatten().map(|(key, value)| (key.clone(), value.clone()));
    Value::Object(keys.chain([(OF_PART.to_owned(), part)]).collect())
}

/// Value of a key in the identity of a part.
pub(super) fn of_part<'a>(identity: &'a Value, key: &str) -> Option<&'a Value> {
    identity.get(OF_PART)?.get(key)
}

/// Reads the identity of a folder.
pub(super) fn read_identity(path: &Path) -> Result<Value> {
    let text = input::read_text(path, input::TREE_BYTES).map_err(|reason| Error::io(path, "read", reason))?;
    serde_json::from_str(&text).map_err(|e| Invalid::new("", format!("is damaged: {e}")).in_file(path))
}

/// Reason why two identities are not of one data set, or not of the same part of it.
pub(super) fn refusal(earlier: &Value, now: &Value) -> Option<String> {
    if earlier.get("fingerprint") != now.get("fingerprint") {
        return Some(format!("contains another data set: {}", difference(earlier, now)));
    }
    let samples = |identity: &Value| of_part(identity, "samples").cloned().unwrap_or_default();
    let range = samples(earlier);
    if range == samples(now) {
        return None;
    }
    Some(if range.is_null() {
        "contains the whole of this data set".to_owned()
    } else {
        let [from, to] = [0, 1].map(|end| range.get(end).cloned().unwrap_or_default());
        format!("holds the samples {from}..{to} of each pixel")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Images of a card are another data set than those of the processor, or of another card; how much there is to be
    /// stays as it was.
    #[test]
    fn data_sets_are_of_one_device() {
        let mut identity = fingerprinted(json!({ "dataset": {}, "overrides": [], "captures": [] }));
        identity.insert(FRAMES.to_owned(), 3.into());
        identity.insert(CAMERAS.to_owned(), json!(["left"]));
        let processor = Value::Object(identity);
        let [one, other] = ["a card", "another"].map(|name| on_device(&processor, name));
        assert_eq!(refusal(&one, &on_device(&processor, "a card")), None);
        for (earlier, now) in [(&processor, &one), (&one, &processor), (&one, &other)] {
            let words = refusal(earlier, now).expect("another data set");
            assert!(words.contains("another device"), "{words}");
        }
        assert_eq!(one[FRAMES], processor[FRAMES]);
        assert_eq!(one[CAMERAS], processor[CAMERAS]);
        assert_eq!(one[DEVICE], "a card");
    }
}
