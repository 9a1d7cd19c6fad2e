//! Contact sheet of a data set: which images are there, and in which values they differ, by the manifest alone.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::image_folder::{image, name};
use super::layout_folder::IMAGE;
use super::read_dataset::MANIFEST;
use photosite_core::input;
use photosite_core::{Error, Invalid, Result};

/// Images of a data set that are there.
#[derive(Clone, Debug)]
pub struct Sheet {
    folder: PathBuf,
    /// Names of the cameras, in the order of the data set.
    pub cameras: Vec<String>,
    /// Number of frames of the whole data set.
    pub frames: u32,
    /// Images, frame by frame.
    pub images: Vec<SheetImage>,
}

/// Image with the values by which it is told from others.
#[derive(Clone, Debug, Serialize)]
pub struct SheetImage {
    /// Number of the frame.
    pub frame: u32,
    /// Name of the camera.
    pub camera: String,
    /// Time of the frame, s; `None` where frames have no times.
    pub time_s: Option<f64>,
    /// Varied keys of the capture, and exposure values that are numbers.
    pub facts: Map<String, Value>,
}

/// Values of a manifest line that are shown.
#[derive(Deserialize)]
struct Line {
    frame: u32,
    frames: u32,
    camera: String,
    time_s: Option<f64>,
    #[serde(default)]
    varied: Map<String, Value>,
    #[serde(default)]
    exposure: Map<String, Value>,
}

/// Exposure values by which images are told apart.
const OF_EXPOSURE: [&str; 3] = ["time_s", "gain_db", "exposure_value"];

impl Sheet {
    /// Whether a folder is that of a data set whose first image is there.
    pub fn is_in(folder: &Path) -> bool {
        folder.join(MANIFEST).is_file()
    }

    /// Reads the manifest.
    ///
    /// # Errors
    ///
    /// A manifest that is not there or damaged, or that names a camera which is no folder of the data set.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(MANIFEST);
        let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
        let mut sheet = Self { folder: folder.to_owned(), cameras: Vec::new(), frames: 0, images: Vec::new() };
        for (number, line) in (1..).zip(text.lines()) {
            let damaged = |why: String| {
                let help = "run the command that makes the data set again, which writes it again";
                Invalid::new("", format!("is damaged: {why}")).help(help).at_line(&path, number)
            };
            let line: Line = serde_json::from_str(line).map_err(|error| damaged(error.to_string()))?;
            // The manifest may be a stranger's, and its images lie in its folder.
            if !is_name(&line.camera) {
                return Err(damaged(format!("{:?} is not the name of a camera", line.camera)));
            }
            sheet.frames = line.frames;
            if !sheet.cameras.contains(&line.camera) {
                sheet.cameras.push(line.camera.clone());
            }
            let exposure = line.exposure.into_iter().filter(|(key, _)| OF_EXPOSURE.contains(&key.as_str()));
            let exposure = exposure.map(|(key, value)| (format!("exposure.{key}"), value));
            let mut facts: Map<String, Value> = exposure.collect();
            facts.extend(line.varied);
            let Line { frame, camera, time_s, .. } = line;
            sheet.images.push(SheetImage { frame, camera, time_s, facts });
        }
        Ok(sheet)
    }

    /// Folder of image `number` of the list.
    pub fn folder_of(&self, number: usize) -> Option<PathBuf> {
        let SheetImage { camera, frame, .. } = self.images.get(number)?;
        Some(image(&self.folder, camera, *frame))
    }

    /// Name of image `number` of the list.
    pub fn name_of(&self, number: usize) -> Option<String> {
        self.images.get(number).map(|SheetImage { camera, frame, .. }| name(camera, *frame))
    }

    /// Developed image, where there is one.
    pub fn image_of(&self, number: usize) -> Option<PathBuf> {
        self.folder_of(number).map(|folder| folder.join(IMAGE)).filter(|path| path.is_file())
    }

    /// Partner of an image, taken by another camera of the rig at the same time: the second camera's for the first
    /// camera, the first camera's for all others.
    pub fn partner_of(&self, number: usize) -> Option<usize> {
        let SheetImage { camera, frame, .. } = self.images.get(number)?;
        let [first, second, ..] = &self.cameras[..] else { return None };
        let partner = if camera == first { second } else { first };
        self.images.iter().position(|other| other.frame == *frame && other.camera == *partner)
    }
}

/// Whether a text is the name of a folder directly within another.
fn is_name(text: &str) -> bool {
    let mut parts = Path::new(text).components();
    matches!((parts.next(), parts.next()), (Some(Component::Normal(part)), None) if part == text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sheet(text: &str) -> Result<Sheet> {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join(MANIFEST), text).expect("written");
        Sheet::read(folder.path())
    }

    #[test]
    fn images_have_what_varies_and_how_they_are_exposed() {
        let line = |frame: u32, camera: &str| {
            format!(
                r#"{{"frame": {frame}, "frames": 3, "camera": "{camera}", "time_s": null, "folder": "/etc", "varied": {{"lens.f_number": 4, "on": true}}, "exposure": {{"time_s": 0.01, "auto": false, "frames": 1}}}}"#
            )
        };
        let lines = [line(0, "left"), line(0, "right"), line(2, "left"), line(2, "right")];
        let sheet = sheet(&lines.join("\n")).expect("a manifest");
        assert_eq!((sheet.frames, &sheet.cameras[..]), (3, &["left".to_owned(), "right".to_owned()][..]));
        let facts = serde_json::json!({ "exposure.time_s": 0.01, "lens.f_number": 4, "on": true });
        assert!(sheet.images.iter().all(|image| Value::from(image.facts.clone()) == facts));
        assert_eq!([0, 1, 2, 3].map(|number| sheet.partner_of(number)), [Some(1), Some(0), Some(3), Some(2)]);
        assert_eq!(sheet.name_of(3).as_deref(), Some("right/000002"));
        assert!(sheet.folder_of(3).is_some_and(|path| path.ends_with("right/000002")));
        assert_eq!(sheet.folder_of(4), None);
    }

    #[test]
    fn no_manifest_leads_out_of_its_folder() {
        for camera in ["..", "/etc", "a/b", "../x", "", ".", "a/"] {
            let line = format!(r#"{{"frame": 0, "frames": 1, "camera": "{camera}", "time_s": null}}"#);
            let error = sheet(&line).expect_err(camera).to_string();
            assert!(error.contains("is not the name of a camera"), "{error}");
        }
        assert!(sheet("{").is_err());
    }
}
