//! `capture.json`: as a report, as a capture that is read again, and as the cameras and targets of a data set.

use photosite::Capture;
use photosite::dataset::read_present;
use photosite::report::Report;
use crate::{folder, written};

const MANIFEST: &[u8] = br#"{"frame": 0, "frames": 1, "camera": "left", "time_s": 0.5, "folder": "left/000000"}"#;

pub(crate) fn target(data: &[u8]) {
    let path = written("left/000000/capture.json", data);
    if Report::of_json(&path, data).is_ok() {
        written("manifest.jsonl", MANIFEST);
        let _ = read_present(folder());
        let _ = Capture::load(&path);
    }
}
