//! What a data set holds of a picture, read into memory.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use photosite_core::input;
use serde_json::{Map, Value, json};

use crate::calibration::camera_files::CalibratedCamera;
use crate::calibration::dataset::DatasetDescription;
use crate::calibration::layouts::Shot;
use crate::dataset::finished::{Line, refuse_resampled, shot};
use crate::dataset::layout_folder::{PICTURE, TRUTH, check_size, read_truth};
use crate::dataset::presence::name;
use crate::image::Planes;
use crate::io::plain_png::picture_size;
use crate::io::raw_file::read_raw;
use crate::io::truth::by_layer;
use crate::raw::{PixelArea, RawImage};
use crate::report::{REPORT, Report};
use crate::{Error, Invalid, Result};

/// Raw files that a picture may have, those that say most first.
const RAW_FILES: [&str; 5] = ["raw.dng", "raw.exr", "raw.npy", "raw.tiff", "raw.pgm"];

/// What is known of a data set before its pictures are there.
pub(super) struct SetFacts {
    /// Names, in the order of the rig.
    pub(super) cameras: Vec<String>,
    frames: u32,
    frame_rate_hz: Option<f64>,
}

impl SetFacts {
    /// Those that `dataset.json` states.
    pub(super) fn of_identity(identity: &Value, frames: u32, path: &Path) -> Result<Self> {
        let description: DatasetDescription =
            serde_json::from_value(identity.get("dataset").cloned().unwrap_or_default())
                .map_err(|e| Invalid::new("dataset", format!("is damaged: {e}")).in_file(path))?;
        let mut cameras: Vec<String> = description.cameras.into_iter().map(|camera| camera.name).collect();
        if cameras.is_empty() {
            cameras.push("camera".to_owned());
        }
        let trajectory = description.poses.and_then(|poses| poses.trajectory);
        Ok(Self { cameras, frames, frame_rate_hz: trajectory.map(|way| way.frame_rate_hz) })
    }
}

/// The pictures of a data set.
pub(super) struct Samples {
    dataset: PathBuf,
    facts: SetFacts,
}

/// A picture.
pub(super) struct Sample {
    /// What is known of it.
    pub(super) shot: Shot,
    /// From the start of the first frame; none without a trajectory.
    pub(super) time_s: Option<f64>,
    /// Of the sensor's noise.
    pub(super) seed: u64,
    /// The text of `capture.json`.
    pub(super) report: Vec<u8>,
    /// `image.png`.
    pub(super) image: Option<Vec<u8>>,
    /// The pixels that see light.
    pub(super) raw: Option<RawImage>,
    /// Ground truth by the names of its layers.
    pub(super) truth: BTreeMap<String, Planes>,
}

impl Samples {
    pub(super) fn new(dataset: &Path, facts: SetFacts) -> Self {
        Self { dataset: dataset.to_owned(), facts }
    }

    pub(super) fn dataset(&self) -> &Path {
        &self.dataset
    }

    pub(super) fn facts(&self) -> &SetFacts {
        &self.facts
    }

    /// The pictures of frames, by their frames, within a frame by their cameras.
    pub(super) fn of_frames(&self, frames: Range<u32>) -> impl Iterator<Item = Result<Sample>> {
        let of_frame = move |frame| (0..self.facts.cameras.len()).map(move |camera| self.read(frame, camera));
        frames.flat_map(of_frame)
    }

    fn read(&self, frame: u32, camera: usize) -> Result<Sample> {
        let time_s = self.facts.frame_rate_hz.map(|rate| f64::from(frame) / rate);
        let line = Line {
            frame,
            frames: self.facts.frames,
            camera: self.facts.cameras[camera].clone(),
            time_s,
            folder: name(&self.facts.cameras[camera], frame),
            sums: BTreeMap::new(),
        };
        let folder = self.dataset.join(&line.folder);
        let path = folder.join(REPORT);
        let text = input::read_text(&path, input::TABLE_BYTES).map_err(|reason| Error::io(&path, "read", reason))?;
        let report = Report::of_json(&path, text.as_bytes())?;
        let (seed, files) = (report.seed, report.files.clone());
        let shot = shot(&path, report, line, camera)?;
        let has = |name: &&str| files.iter().any(|file| file == name);
        let image = Some(PICTURE).filter(has).map(|name| folder.join(name));
        if let Some(path) = &image {
            refuse_resampled(&self.dataset, &shot)?;
            check_size(picture_size(path)?, &shot, path)?;
        }
        let image =
            image.map(|path| input::read(&path).map_err(|reason| Error::io(&path, "read", reason))).transpose()?;
        let raw = RAW_FILES.iter().copied().find(has).map(|name| folder.join(name));
        let raw = raw.map(|path| {
            let raw = seen(read_raw(&path)?);
            let side = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
            check_size([side(raw.width), side(raw.height)], &shot, &path)?;
            Ok(raw)
        });
        let raw = raw.transpose()?;
        let truth = match Some(TRUTH).filter(has) {
            Some(name) => by_layer(read_truth(&folder.join(name))?),
            None if files.iter().any(|file| file.starts_with("truth")) => {
                let help = "make the data set with output.truth_formats = [\"exr\"]";
                return Err(Invalid::new("", "has ground truth, but no truth.exr").help(help).in_file(&folder));
            }
            None => BTreeMap::new(),
        };
        if image.is_none() && raw.is_none() {
            let help = "make the data set with output.image = true or output.raw = [\"dng\"]";
            return Err(Invalid::new("", "has neither image.png nor a raw file").help(help).in_file(&folder));
        }
        Ok(Sample { shot, time_s, seed, report: text.into_bytes(), image, raw, truth })
    }
}

impl Sample {
    /// What the sample's files are called.
    pub(super) fn key(&self) -> String {
        format!("{}-{:06}", self.shot.calibrated.name, self.shot.frame)
    }

    /// Which camera it is, when, where, and what its numbers mean. In OpenCV's conventions, as the report.
    pub(super) fn facts(&self) -> Value {
        let Shot { frame, stamp_ns, calibrated, .. } = &self.shot;
        let CalibratedCamera { name, projection, resolution, .. } = calibrated;
        let (rotation, translation) = self.pose();
        let mut facts = Map::new();
        let mut put = |key: &str, value: Value| drop(facts.insert(key.to_owned(), value));
        put("camera", json!(name));
        put("frame", json!(frame));
        put("time_s", json!(self.time_s));
        put("stamp_ns", json!(stamp_ns));
        put("seed", json!(self.seed));
        put("resolution_px", json!(resolution));
        put("camera_matrix", json!(calibrated.matrix().as_chunks::<3>().0));
        put("projection", json!(projection.name()));
        put("distortion", json!(projection.coefficients()));
        put("xi", json!(projection.xi()));
        put("rotation", json!(rotation.as_chunks::<3>().0));
        put("translation_m", json!(translation));
        if let Some(raw) = &self.raw {
            let raw = json!({
                "colour_filter_array": raw.cfa.to_string(),
                "bits": raw.bits,
                "white_level_dn": raw.white_level_dn,
                "linearisation_dn": raw.linearisation,
            });
            put("raw", raw);
        }
        Value::Object(facts)
    }

    /// World → camera with OpenCV's axes: the rotation row by row, and the translation.
    pub(super) fn pose(&self) -> ([f64; 9], [f64; 3]) {
        let from_world = self.shot.calibrated.from_world();
        // Adding zero makes zeros of negative ones.
        let rotation = from_world.matrix3.transpose().to_cols_array().map(|x| x + 0.0);
        (rotation, from_world.translation.to_array().map(|x| x + 0.0))
    }
}

/// The part of a raw image that sees light, which has the pixels of the camera.
fn seen(raw: RawImage) -> RawImage {
    let PixelArea { x, y, width, height } = raw.active();
    if [width, height] == [raw.width, raw.height] {
        return raw;
    }
    let (samples, row) = (raw.cfa.samples_per_pixel(), raw.row_length());
    let rows = (y..y + height).flat_map(|line| &raw.data[line * row + x * samples..][..width * samples]);
    let cfa = raw.active_cfa();
    RawImage { width, height, data: rows.copied().collect(), cfa, active_area: None, ..raw }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raw::Cfa;

    #[test]
    fn masked_pixels_are_left_out_and_filters_keep_their_places() {
        let cfa = Cfa::parse("RGGB").expect("a filter");
        let bare = RawImage::bare(4, 3, (0..12).collect(), cfa, 11);
        let raw = RawImage { active_area: Some(PixelArea { x: 1, y: 1, width: 3, height: 2 }), ..bare };
        let seen = seen(raw);
        assert_eq!((seen.width, seen.height, seen.data), (3, 2, vec![5, 6, 7, 9, 10, 11]));
        assert_eq!(seen.cfa.to_string(), "BGGR");
    }
}
