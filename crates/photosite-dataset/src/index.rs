//! Index of a data set folder: `manifest.jsonl`, `calibration/` and `README.md`.

use std::collections::BTreeMap;
use std::path::Path;

use photosite_core::key_path::{split_change, toml_value};
use photosite_core::{counted, input};
use serde_json::{Value, json};

use super::calibration::write_calibration;
use super::folder::DatasetFolder;
use super::frames::Frames;
use super::image_folder::name;
use super::noise::SetNoise;
use super::read_dataset::{Line, MANIFEST, read_present};
use super::selection::FrameList;
use super::warnings_by_kind::WarningsByKind;
use photosite_calibration::dataset::Plan;
use photosite_capture::DatasetFile;
use photosite_capture::report::{REPORT, Report};
use photosite_core::output::write_whole;
use photosite_core::{Error, Invalid, Result};
use photosite_files::file_sum::FileSum;
use photosite_files::lock::Lock;

/// Name of the card, which describes the folder to people.
const CARD: &str = "README.md";

/// Index of a data set folder.
pub struct Index {
    /// Number of images that are there.
    pub present: usize,
    /// Numbers of the frames that lack an image, in order.
    pub missing: Vec<u32>,
    /// Files of the cameras that are left out, with the reasons.
    pub left_out: Vec<String>,
    /// Monte Carlo noise of the images.
    pub noise: SetNoise,
    /// Warnings of the images' reports, each kind once.
    pub warnings: Vec<String>,
}

impl Index {
    /// Refuses a folder that lacks images of these frames, or has `damaged` ones among them.
    pub fn check(&self, frames: &Frames, damaged: usize, folder: &DatasetFolder) -> Result<()> {
        const DAMAGED: [&str; 2] = ["damaged image", "damaged images"];
        let missing: Vec<u32> = frames.numbers().filter(|number| self.missing.binary_search(number).is_ok()).collect();
        let message = match (missing.len(), damaged) {
            (0, 0) => return Ok(()),
            (0, _) => format!("has {}", counted(damaged, DAMAGED)),
            (_, 0) => format!("lacks images of the frames {}", FrameList::of(&missing)),
            (..) => {
                let list = FrameList::of(&missing);
                format!("lacks images of the frames {list}, and has {}", counted(damaged, DAMAGED))
            }
        };
        let help = "give the same command without --index-only, which makes them";
        Err(Invalid::new("", message).help(help).in_file(folder.path()))
    }
}

/// Writes manifest, calibration files and card of the images that are there. Of processes that end at the same time,
/// the last to write knows of the images of all. `focuses`: whether autofocus focuses the cameras in every frame.
pub(super) fn write_index(
    folder: &DatasetFolder,
    file: &DatasetFile,
    identity: &Value,
    (plan, focuses): (&Plan, bool),
) -> Result<Index> {
    let _lock = Lock::wait_for_folder(folder.path())?;
    folder.restore(identity)?;
    folder.sweep(plan)?;
    let path = folder.path().join(MANIFEST);
    let earlier = report_sums(&path);
    let (mut lines, mut missing) = (Vec::new(), Vec::new());
    let (mut renders, mut said) = (Vec::new(), WarningsByKind::default());
    for number in 0..plan.frames() {
        for camera in plan.cameras().iter().map(|camera| &*camera.place.name) {
            if folder.is_done(camera, number) {
                let path = folder.image(camera, number).join(REPORT);
                let report = Report::read(&path).map_err(Error::since_begun)?;
                said.frame(number);
                report.warnings.iter().for_each(|words| said.warning(camera, number, words));
                renders.push((name(camera, number), report.traced.render.clone()));
                lines.push(line(&path, report, (camera, number), plan, &earlier)?.to_string());
            } else if missing.last() != Some(&number) {
                missing.push(number);
            }
        }
    }
    write_whole(&path, |to| lines.iter().try_for_each(|line| writeln!(to, "{line}")))?;
    let present = lines.len();
    let left_out = if present == 0 {
        Vec::new()
    } else {
        write_calibration(&read_present(folder.path()).map_err(Error::since_begun)?, focuses)?
    };
    let noise = SetNoise::of(renders.iter().map(|(image, render)| (image.clone(), render.as_ref())));
    let index = Index { present, missing, left_out, noise, warnings: said.in_words() };
    let card = card(file, identity, plan, &index);
    write_whole(&folder.path().join(CARD), |to| to.write_all(card.as_bytes()))?;
    Ok(index)
}

/// Checksums of the images' reports in a manifest, by the images' folders; unreadable lines are skipped. Nothing else
/// vouches for a report.
pub(super) fn report_sums(manifest: &Path) -> BTreeMap<String, FileSum> {
    let text = input::read_text(manifest, input::TABLE_BYTES).unwrap_or_default();
    let lines = text.lines().filter_map(|line| serde_json::from_str::<Line>(line).ok());
    lines.filter_map(|mut line| Some((line.folder, line.sums.remove(REPORT)?))).collect()
}

/// Line of the manifest for an image.
fn line(
    path: &Path,
    report: Report,
    (camera, number): (&str, u32),
    plan: &Plan,
    earlier: &BTreeMap<String, FileSum>,
) -> Result<Value> {
    let Report { files, mut sums, seed, overrides, traced, exposure, .. } = report;
    let name = name(camera, number);
    // An image has the same bytes whenever it is made: another sum than before is that of a damaged report.
    let report = earlier.get(&name).cloned().map_or_else(|| FileSum::of(path), Ok);
    sums.insert(REPORT.to_owned(), report.map_err(|reason| Error::io(path, "read", reason))?);
    let pose = traced.camera.as_ref();
    Ok(json!({
        "frame": number,
        "frames": plan.frames(),
        "camera": camera,
        "time_s": plan.time_s(number),
        "folder": name,
        "files": files,
        "sums": sums,
        "seed": seed,
        "overrides": overrides,
        "varied": varied(plan, &overrides),
        "pose": {
            "rotation": pose.map(|camera| camera.rotation),
            "translation_m": pose.map(|camera| camera.translation_m),
        },
        "camera_matrix": pose.map(|camera| camera.camera_matrix),
        "exposure": exposure,
        "noise_ratio": traced.render.as_ref().and_then(|render| render.noise_ratio),
    }))
}

/// Values of the varied keys in an image, taken from its changes to the capture.
fn varied(plan: &Plan, overrides: &[String]) -> Value {
    let value = |key: &str| {
        let of_key =
            |change: &String| split_change(change).filter(|(other, _)| *other == key).map(|(_, v)| v.to_owned());
        let text = overrides.iter().rev().find_map(of_key)?;
        let value = toml_value(&text).and_then(|value| serde_json::to_value(value).ok());
        Some((key.to_owned(), value.unwrap_or(Value::from(text))))
    };
    plan.varied_keys().into_iter().filter_map(value).collect()
}

/// Card (`README.md`) for a reader who finds the folder.
fn card(file: &DatasetFile, identity: &Value, plan: &Plan, index: &Index) -> String {
    let Index { present, left_out, noise, warnings, .. } = index;
    let cameras: Vec<String> = plan
        .cameras()
        .iter()
        .map(|c| {
            let [width, height] = c.camera.resolution();
            format!("- `{}`: {width} × {height} pixels", c.place.name)
        })
        .collect();
    let keys = file.description.vary.iter().flat_map(|variation| variation.keys());
    let varied: Vec<String> = keys.map(|key| format!("- `{key}`")).collect();
    let left_out: String = left_out.iter().map(|why| format!("  - not there, {why}\n")).collect();
    let noise = noise.in_words().map(|words| format!("## Noise\n\n{words}.\n\n"));
    let warnings: String = warnings.iter().map(|words| format!("- {words}\n")).collect();
    let warnings = (!warnings.is_empty()).then(|| format!("## Warnings\n\n{warnings}\n"));
    let told: String = noise.into_iter().chain(warnings).collect();
    let varied = if varied.is_empty() { "Nothing but poses and noise.".to_owned() } else { varied.join("\n") };
    format!(
        "# Synthetic images\n\n\
         Made by photosite {version} from `{capture}`; everything in them is computed, nothing was photographed.\n\n\
         {frames} frames by {count} cameras; {present} of {all} images are here.\n\n\
         ## Cameras\n\n{cameras}\n\n\
         ## What differs from frame to frame\n\n{varied}\n\n{told}\
         ## Files\n\n\
         - `CAMERA/NUMBER/`: one image. `raw.*` are digital numbers of the sensor, `image.png` is developed from them, \
         `electrons.exr` holds the mean photo-electrons without noise, `truth.*` what is really there at each pixel, \
         `capture.json` everything that is needed to use and to repeat the image.\n\
         - `manifest.jsonl`: a line for each image: pose (world → camera, OpenCV's axes: x right, y down, z forward), \
         camera matrix (integer coordinates at pixel centres), exposure, Monte Carlo noise beside the sensor's \
         (`noise_ratio`), changes to the capture and among them what was drawn (`varied`), sizes and SHA-256 of the files. `photosite render` makes the image alone, from its \
         `capture.json` or from the capture with each of the changes after `--set`.\n\
         - `calibration/`: the cameras for OpenCV, ROS and Kalibr, as far as these know such lenses. The first camera is the \
         reference: poses of `opencv/CAMERA.yaml` lead from it; `opencv/stereo/FIRST-CAMERA.yaml` holds a pair (R, T, E, F, \
         R1, R2, P1, P2, Q, the epipoles e1 and e2, and H1 and H2, the homographies of rectification) and `ros/` \
         the same with Tx = -fx·b in P, for the raw image and for `image.png` where that keeps its distortion.\n{left_out}\
         - `dataset.json`: what the data set was made from, with hashes of the files.\n\n\
         `photosite layout` arranges all this as COLMAP, EuRoC, Kalibr, BOP, COCO or Nerfstudio have it, or packs it for \
         WebDataset, Hugging Face datasets (Parquet) or ROS 2 (MCAP).\n\n\
         Lengths are metres, the world is that of glTF (y up). Fingerprint: `{fingerprint}`.\n",
        version = env!("CARGO_PKG_VERSION"),
        capture = file.description.capture,
        frames = plan.frames(),
        count = plan.cameras().len(),
        all = plan.frames() as usize * plan.cameras().len(),
        cameras = cameras.join("\n"),
        fingerprint = identity.get("fingerprint").and_then(Value::as_str).unwrap_or_default(),
    )
}
