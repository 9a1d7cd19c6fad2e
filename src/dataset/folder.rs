//! The folder of a data set: which pictures are there, and what they are pictures of.
//!
//! DIR/CAMERA/NUMBER holds the files of one picture. It is made beside as `.NUMBER.XXXXXX.partial` and renamed when it
//! is complete, so that whatever stands under its number is whole. `dataset.json` says what the folder is for,
//! `manifest.jsonl` what is in it, a line a picture.
//!
//! Several processes may fill it. Each picture has a lock, `.NUMBER.lock`, so that they make different ones, and know
//! what a dead one has left; what concerns the whole has the lock of the folder. Nothing is lost where the file system
//! knows no locks: each process makes a picture under a name of its own, the first to finish gives it its number, and
//! the other drops its own.

use photosite_core::Remedy;
use std::collections::BTreeSet;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::calibration::camera_files::{CalibratedCamera, StereoPair, kalibr, opencv, opencv_pair, ros, ros_pair};
use crate::calibration::dataset::{CALIBRATION_FOLDER, Plan};
use crate::calibration::truth::TruthLayer;
use crate::capture::{Capture, DatasetFile, real_path};
use crate::io::lock::Lock;
use crate::io::output::{create_folder, remove_leftovers, write_new, write_whole};
use crate::io::unfinished::{UnfinishedFolder, unfinished_folders};
use crate::{Error, Invalid, Result};
use photosite_core::fail_point;
use serde_json::{Map, Value, json};

use super::finished::{MANIFEST, read_present};
use crate::io::pretty_json::pretty_json;
use crate::pipeline::{PART, are_checkpoints_in, difference, fingerprinted, keys_and_files};
use crate::report::{REPORT, Report, listed_files};
use photosite_core::input;

/// The file that identifies the data set.
const IDENTITY: &str = "dataset.json";
/// Its key in folders of parts.
const OF_PART: &str = "part";
/// The folder's contents for people.
const CARD: &str = "README.md";

/// Everything that decides what the pictures are: version, description, captures, and the files that these name. How
/// many frames there are decides nothing of any of them, unless a key goes from one value to another over all, or flow
/// tells of the next one.
pub(super) fn identity(file: &DatasetFile, captures: &[Capture], overrides: &[String]) -> Result<Value> {
    let mut description = file.values.clone();
    let sweeps = file.description.vary.iter().any(|variation| variation.sweep.is_some());
    // Flow of the last frame leads nowhere.
    let flows = captures.iter().any(|capture| capture.output.truth.layers.contains(&TruthLayer::Flow));
    if let (false, Value::Object(keys)) = (sweeps || flows, &mut description) {
        keys.remove("frames");
    }
    let mut named = Map::new();
    let mut keys = Vec::new();
    for capture in captures {
        keys.push(keys_and_files(capture, &mut named)?);
    }
    Ok(Value::Object(fingerprinted(json!({
        "photosite_version": env!("CARGO_PKG_VERSION"),
        "dataset": description,
        "overrides": overrides,
        "captures": keys,
        "files_sha256": named,
    }))))
}

/// The identity of a folder that holds a part of every picture, made from the data set file `input`.
pub(super) fn part_identity(identity: &Value, samples: &Range<u32>, input: &Path) -> Value {
    let mut identity = identity.clone();
    identity[OF_PART] = json!({ "samples": [samples.start, samples.end], "path": real_path(input) });
    identity
}

/// A folder of parts of pictures.
pub struct PartFolder {
    path: PathBuf,
    identity: Value,
}

impl PartFolder {
    /// Whether a folder is that of a data set.
    pub fn is_one(path: &Path) -> bool {
        path.join(IDENTITY).exists()
    }

    /// Reads what a folder is a part of.
    pub fn read(path: &Path) -> Result<Self> {
        let refuse = |message: &str| {
            let help = "give folders that hold a part of a data set";
            Err(Invalid::new("", message).help(help).in_file(path))
        };
        if !Self::is_one(path) {
            return refuse("holds no part of a data set");
        }
        let identity = read_identity(&path.join(IDENTITY))?;
        if identity[OF_PART].is_null() {
            return refuse("holds a whole data set and no part of one");
        }
        Ok(Self { path: path.to_owned(), identity })
    }

    /// Where the data set file was.
    pub fn input(&self) -> PathBuf {
        PathBuf::from(self.identity[OF_PART]["path"].as_str().unwrap_or_default())
    }

    /// The overrides that it was made with.
    pub fn arguments(&self) -> Vec<String> {
        let arguments = self.identity["overrides"].as_array().into_iter().flatten();
        arguments.filter_map(Value::as_str).map(str::to_owned).collect()
    }

    /// Refuses parts of another data set.
    pub fn check(&self, whole: &Value) -> Result<()> {
        if self.identity["fingerprint"] == whole["fingerprint"] {
            return Ok(());
        }
        let difference = difference(&self.identity, whole);
        let message = format!("{} is a part of another data set: {difference}", self.path.display());
        Err(Error::Usage { message, help: Some("give parts of one data set, and its file as it was".into()) })
    }

    /// The part of a picture, if it is there.
    pub fn picture(&self, camera: &str, number: u32) -> Option<PathBuf> {
        Some(picture(&self.path, camera, number)).filter(|path| path.exists())
    }
}

fn read_identity(path: &Path) -> Result<Value> {
    let text = input::read_at_most(path, input::TREE_BYTES).map_err(|reason| Error::io(path, "read", reason))?;
    serde_json::from_slice(&text).map_err(|e| Invalid::new("", format!("is damaged: {e}")).in_file(path))
}

/// DIR/CAMERA/NUMBER.
fn picture(folder: &Path, camera: &str, number: u32) -> PathBuf {
    folder.join(camera).join(format!("{number:06}"))
}

/// A folder that is known to be that of this data set.
pub struct DatasetFolder {
    path: PathBuf,
}

impl DatasetFolder {
    /// Takes a new or empty folder, or one of the same data set; no other.
    pub fn claim(path: &Path, identity: &Value, plan: &Plan) -> Result<Self> {
        let refuse = |message: String| {
            let help = Remedy::Elsewhere("another folder, as pictures of two data sets must not be mixed".to_owned());
            Err(Error::Usage { message, help: Some(help.into()) })
        };
        if path.is_file() {
            return refuse(format!("{} is a file, where a folder is needed", path.display()));
        }
        create_folder(path)?;
        let marker = path.join(IDENTITY);
        // Whoever begins at the same time takes part.
        let lock = Lock::wait_for_folder(path)?;
        if lock.is_proven() {
            remove_leftovers(path);
        }
        if !marker.exists() {
            let entries = fs::read_dir(path).map_err(|reason| Error::io(path, "read", reason))?;
            let mut names = entries.flatten().map(|entry| entry.file_name());
            if names.any(|name| !name.to_string_lossy().starts_with(".photosite")) && !marker.exists() {
                return refuse(format!("{} is not empty, and holds no data set", path.display()));
            }
            write_new(&marker, |to| writeln!(to, "{}", pretty_json(identity)))?;
        }
        let earlier = read_identity(&marker)?;
        if earlier["fingerprint"] != identity["fingerprint"] {
            let difference = difference(&earlier, identity);
            return refuse(format!("{} holds another data set: {difference}", path.display()));
        }
        let samples = |identity: &Value| identity[OF_PART]["samples"].clone();
        if samples(&earlier) != samples(identity) {
            let range = samples(&earlier);
            let held = if range.is_null() {
                "the whole of this data set".to_owned()
            } else {
                format!("the samples {}..{} of each pixel", range[0], range[1])
            };
            return refuse(format!("{} holds {held}", path.display()));
        }
        for camera in plan.cameras() {
            create_folder(&path.join(&camera.place.name))?;
        }
        Ok(Self { path: path.to_owned() })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a picture is there.
    pub(super) fn is_done(&self, camera: &str, number: u32) -> bool {
        self.picture(camera, number).exists()
    }

    /// Begins a picture, or finds out who has it.
    pub(super) fn begin(&self, camera: &str, number: u32) -> Result<Turn> {
        let path = self.picture(camera, number);
        if path.exists() {
            return Ok(Turn::Done);
        }
        let Some(lock) = Lock::try_take(&self.lock(camera, number))? else { return Ok(Turn::Theirs) };
        // Another process may have finished it before it let go of the lock.
        if path.exists() {
            return Ok(Turn::Done);
        }
        // Before there is one of this process.
        let left = if lock.is_proven() { unfinished_folders(&path) } else { Vec::new() };
        let folder = UnfinishedFolder::beside(&path, are_checkpoints_in)?;
        for older in left {
            if !are_checkpoints_in(folder.path()) && are_checkpoints_in(&older) && folder.take_over(&older) {
                remove_leftovers(folder.path());
            } else {
                // Nothing depends on it.
                let _ = fs::remove_dir_all(&older);
            }
        }
        fail_point::reach("picture-begun");
        Ok(Turn::Ours(NewPicture { folder, _lock: lock }))
    }

    /// Writes the manifest and the card of what is there, and returns how many pictures that are, and which files of
    /// the cameras are left out, with the reasons. Of processes that end at the same time the last to write knows of
    /// the pictures of all.
    pub(super) fn write_index(
        &self,
        file: &DatasetFile,
        identity: &Value,
        plan: &Plan,
    ) -> Result<(usize, Vec<String>)> {
        let _lock = Lock::wait_for_folder(&self.path)?;
        self.sweep(plan)?;
        let mut lines = Vec::new();
        for number in 0..plan.frames() {
            for camera in plan.cameras().iter().filter(|camera| self.is_done(&camera.place.name, number)) {
                lines.push(self.line(&camera.place.name, number, plan)?.to_string());
            }
        }
        write_whole(&self.path.join(MANIFEST), |to| lines.iter().try_for_each(|line| writeln!(to, "{line}")))?;
        let left_out = if lines.is_empty() { Vec::new() } else { self.write_calibration()? };
        let card = card(file, identity, plan, lines.len(), &left_out);
        write_whole(&self.path.join(CARD), |to| to.write_all(card.as_bytes()))?;
        Ok((lines.len(), left_out))
    }

    /// Writes what calibrations of the cameras shall find, as far as the formats have words for their lenses, and
    /// returns why what is not there is not. Of lenses that differ from frame to frame only the pictures' own reports
    /// can tell.
    fn write_calibration(&self) -> Result<Vec<String>> {
        let set = read_present(&self.path)?;
        let folder = self.path.join(CALIBRATION_FOLDER);
        // What was true of fewer frames is not left behind.
        for name in calibration_names(&set.cameras) {
            let path = folder.join(name);
            if path.exists() {
                fs::remove_file(&path).map_err(|reason| Error::io(&path, "remove the earlier file", reason))?;
            }
        }
        let rig = match set.rig() {
            Ok(rig) => rig,
            Err(invalid) => return Ok(vec![format!("all of its files: {}", invalid.message)]),
        };
        let mut left_out = Vec::new();
        for (name, text) in calibration_files(&rig) {
            let path = folder.join(&name);
            match text {
                Ok(text) => {
                    create_folder(path.parent().unwrap_or(&self.path))?;
                    write_whole(&path, |to| to.write_all(text.as_bytes()))?;
                }
                Err(invalid) => left_out.push(format!("`{name}`: {}", invalid.message)),
            }
        }
        Ok(left_out)
    }

    /// What the manifest says of a picture.
    fn line(&self, camera: &str, number: u32, plan: &Plan) -> Result<Value> {
        let Report { files, seed, overrides, traced, exposure, .. } =
            Report::read(&self.picture(camera, number).join(REPORT))?;
        let pose = traced.camera.as_ref();
        Ok(json!({
            "frame": number,
            "frames": plan.frames(),
            "camera": camera,
            "time_s": plan.time_s(number),
            "folder": format!("{camera}/{number:06}"),
            "files": files,
            "seed": seed,
            "overrides": overrides,
            "pose": {
                "rotation": pose.map(|camera| camera.rotation),
                "translation_m": pose.map(|camera| camera.translation_m),
            },
            "camera_matrix": pose.map(|camera| camera.camera_matrix),
            "exposure": exposure,
        }))
    }

    fn picture(&self, camera: &str, number: u32) -> PathBuf {
        picture(&self.path, camera, number)
    }

    fn lock(&self, camera: &str, number: u32) -> PathBuf {
        self.path.join(camera).join(format!(".{number:06}.lock"))
    }

    /// Removes what dead processes have left beside pictures that are done.
    fn sweep(&self, plan: &Plan) -> Result<()> {
        for camera in plan.cameras().iter().map(|camera| &*camera.place.name) {
            let folder = self.path.join(camera);
            let entries = fs::read_dir(&folder).map_err(|reason| Error::io(&folder, "read", reason))?;
            let number = |name: &str| name.strip_prefix('.')?.split('.').next()?.parse().ok();
            let numbers = entries.flatten().filter_map(|entry| number(&entry.file_name().to_string_lossy()));
            for number in numbers.collect::<BTreeSet<u32>>() {
                // The lock leaves with its file.
                let lock = Lock::try_take(&self.lock(camera, number))?;
                let path = self.picture(camera, number);
                if lock.is_some_and(|lock| lock.is_proven() && path.exists()) {
                    // Nothing depends on it.
                    unfinished_folders(&path).iter().for_each(|folder| drop(fs::remove_dir_all(folder)));
                }
            }
        }
        Ok(())
    }
}

/// Whose a picture is to make.
pub(super) enum Turn {
    /// The picture is there.
    Done,
    /// Another process is at it.
    Theirs,
    /// Nobody else makes it.
    Ours(NewPicture),
}

/// A picture that is being made. One that is given up goes, unless there is a checkpoint to go on from.
pub(super) struct NewPicture {
    // Put away before the lock is let go of.
    folder: UnfinishedFolder,
    _lock: Lock,
}

impl NewPicture {
    /// The folder for its files.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Gives the complete picture its number: whether this process was the one to do so.
    pub(super) fn finish(self) -> Result<bool> {
        check_complete(self.folder.path())?;
        fail_point::reach("picture-complete");
        self.folder.finish()
    }
}

/// Refuses a picture that lacks a file which its report names.
fn check_complete(folder: &Path) -> Result<()> {
    let is_gone = |path: &Path| {
        let invalid = Invalid::new("", "was written, and is gone");
        invalid.help("give the command again, which makes the picture anew").in_file(path).temporary()
    };
    let report = [REPORT, PART].map(|name| folder.join(name)).into_iter().find(|path| path.exists());
    let Some(report) = report else { return Err(is_gone(&folder.join(REPORT))) };
    let names = listed_files(&report).map_err(Error::since_begun)?;
    match names.iter().find(|name| !folder.join(name).exists()) {
        Some(name) => Err(is_gone(&folder.join(name))),
        None => Ok(()),
    }
}

/// The files of a rig by their names. OpenCV's and ROS's pairs are those of the first camera with each other one; ROS
/// files of rigs of more than two cameras lie in a folder for each pair, in which the first camera is turned for that
/// one.
fn calibration_files(rig: &[CalibratedCamera]) -> Vec<(String, Result<String, Invalid>)> {
    let mut files = vec![("camchain.yaml".to_owned(), kalibr(rig))];
    files.extend(beside_the_first(rig).map(|camera| (format!("opencv/{}.yaml", camera.name), opencv(&camera))));
    let Some((first, others)) = rig.split_first() else { return files };
    if others.is_empty() {
        files.push((format!("ros/{}.yaml", first.name), ros(first)));
    }
    for other in others {
        let pair_name = format!("{}-{}", first.name, other.name);
        let folder = if others.len() > 1 { format!("ros/{pair_name}") } else { "ros".to_owned() };
        let pair = StereoPair::new(first, other);
        let pair = pair.as_ref().map_err(Invalid::clone);
        files.push((format!("opencv/stereo/{pair_name}.yaml"), pair.clone().and_then(opencv_pair)));
        let names = [first, other].map(|camera| format!("{folder}/{}.yaml", camera.name));
        match pair.and_then(ros_pair) {
            Ok(texts) => files.extend(names.into_iter().zip(texts.map(Ok))),
            Err(invalid) => files.extend(names.map(|name| (name, Err(invalid.clone())))),
        }
    }
    files
}

/// The names of all files that [`calibration_files`] may give for cameras of these names.
fn calibration_names(cameras: &[String]) -> Vec<String> {
    let mut names = vec!["camchain.yaml".to_owned()];
    let Some(first) = cameras.first() else { return names };
    for camera in cameras {
        names.extend(["opencv", "ros"].map(|folder| format!("{folder}/{camera}.yaml")));
        names.push(format!("opencv/stereo/{first}-{camera}.yaml"));
        names.extend([first, camera].map(|of_pair| format!("ros/{first}-{camera}/{of_pair}.yaml")));
    }
    names
}

/// The cameras in a world whose axes are OpenCV's of the first: its own pose is the identity.
fn beside_the_first(rig: &[CalibratedCamera]) -> impl Iterator<Item = CalibratedCamera> {
    let to_first = rig.first().map(CalibratedCamera::from_world).unwrap_or_default();
    rig.iter().map(move |camera| CalibratedCamera { to_world: to_first * camera.to_world, ..camera.clone() })
}

/// What a reader who finds the folder has to know.
fn card(file: &DatasetFile, identity: &Value, plan: &Plan, present: usize, left_out: &[String]) -> String {
    let cameras: Vec<String> = plan
        .cameras()
        .iter()
        .map(|c| {
            let [width, height] = c.camera.resolution();
            format!("- `{}`: {width} × {height} pixels", c.place.name)
        })
        .collect();
    let varied: Vec<String> = file.description.vary.iter().map(|v| format!("- `{}`", v.key)).collect();
    let left_out: String = left_out.iter().map(|why| format!("  - not there, {why}\n")).collect();
    let varied = if varied.is_empty() { "Nothing but poses and noise.".to_owned() } else { varied.join("\n") };
    format!(
        "# Synthetic pictures\n\n\
         Made by photosite {version} from `{capture}`; everything in them is computed, nothing was photographed.\n\n\
         {frames} frames by {count} cameras; {present} of {all} pictures are here.\n\n\
         ## Cameras\n\n{cameras}\n\n\
         ## What differs from frame to frame\n\n{varied}\n\n\
         ## Files\n\n\
         - `CAMERA/NUMBER/`: one picture. `raw.*` are digital numbers of the sensor, `image.png` is developed from them, \
         `electrons.exr` holds the mean photo-electrons without noise, `truth.*` what is really there at each pixel, \
         `capture.json` everything that is needed to use and to repeat the picture.\n\
         - `manifest.jsonl`: a line for each picture: pose (world → camera, OpenCV's axes: x right, y down, z forward), \
         camera matrix (integer coordinates at pixel centres), exposure, changes to the capture.\n\
         - `calibration/`: the cameras for OpenCV, ROS and Kalibr, as far as these know such lenses. The first camera is the \
         reference: poses of `opencv/CAMERA.yaml` lead from it; `opencv/stereo/FIRST-CAMERA.yaml` holds a pair (R, T, R1, R2, P1, P2, Q) and \
         `ros/` the same with Tx = -fx·b in P, for the raw picture and for `image.png` where that keeps its distortion.\n{left_out}\
         - `dataset.json`: what the data set was made from, with hashes of the files.\n\n\
         `photosite layout` arranges all this as COLMAP, EuRoC, Kalibr, BOP or COCO have it.\n\n\
         Lengths are metres, the world is that of glTF (y up). Fingerprint: `{fingerprint}`.\n",
        version = env!("CARGO_PKG_VERSION"),
        capture = file.description.capture,
        frames = plan.frames(),
        count = plan.cameras().len(),
        all = plan.frames() as usize * plan.cameras().len(),
        cameras = cameras.join("\n"),
        fingerprint = identity["fingerprint"].as_str().unwrap_or_default(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, DatasetFolder) {
        let root = tempfile::tempdir().expect("a folder");
        fs::create_dir(root.path().join("left")).expect("made");
        let folder = DatasetFolder { path: root.path().to_owned() };
        (root, folder)
    }

    fn fill(picture: &Path) {
        fs::write(picture.join("raw.dng"), "raw").expect("written");
        fs::write(picture.join(REPORT), r#"{"files": ["raw.dng"]}"#).expect("written");
    }

    fn ours(folder: &DatasetFolder) -> NewPicture {
        match folder.begin("left", 7).expect("no failure") {
            Turn::Ours(picture) => picture,
            Turn::Done | Turn::Theirs => panic!("nobody else is there"),
        }
    }

    fn names(root: &tempfile::TempDir) -> Vec<String> {
        let entries = fs::read_dir(root.path().join("left")).expect("a folder");
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_picture_that_somebody_makes_is_left_to_them() {
        let (root, folder) = folder();
        let picture = ours(&folder);
        assert!(matches!(folder.begin("left", 7).expect("no failure"), Turn::Theirs));
        assert!(matches!(folder.begin("left", 8).expect("no failure"), Turn::Ours(_)));
        fill(picture.path());
        assert!(picture.finish().expect("finished"));
        assert!(matches!(folder.begin("left", 7).expect("no failure"), Turn::Done));
        assert_eq!(names(&root), ["000007"]);
    }

    /// As on a file system without locks, where nothing tells two processes of each other: the lock is taken away.
    #[test]
    fn without_locks_one_of_two_makes_the_picture_and_no_file_is_lost() {
        let (root, folder) = folder();
        let first = ours(&folder);
        fs::write(first.path().join("electrons.exr"), "electrons").expect("written");
        fs::rename(folder.lock("left", 7), root.path().join("lock")).expect("taken away");
        let unproven = UnfinishedFolder::beside(&folder.picture("left", 7), are_checkpoints_in).expect("begun");
        fill(unproven.path());
        fill(first.path());
        assert_eq!(fs::read_dir(first.path()).expect("a folder").count(), 3);
        assert!(first.finish().expect("finished"));
        assert!(!unproven.finish().expect("dropped"));
        assert_eq!(fs::read_dir(folder.picture("left", 7)).expect("a folder").count(), 3);
        assert_eq!(names(&root), ["000007"]);
    }

    #[test]
    fn a_picture_that_lost_a_file_does_not_get_its_number() {
        let (root, folder) = folder();
        for lost in ["raw.dng", REPORT] {
            let picture = ours(&folder);
            fill(picture.path());
            fs::remove_file(picture.path().join(lost)).expect("removed");
            let error = picture.finish().expect_err("incomplete");
            assert!(error.is_temporary() && error.to_string().contains(lost), "{error}");
        }
        assert_eq!(names(&root), [""; 0]);
    }

    /// Of dead processes, and of versions that had one name for all.
    #[test]
    fn what_a_dead_process_has_left_is_gone_on_from_or_removed() {
        let (root, folder) = folder();
        for (name, file) in [(".000007.partial", "raw.dng"), (".000007.a1b2c3.partial", "checkpoint.film")] {
            let left = root.path().join("left").join(name);
            fs::create_dir(&left).expect("made");
            for file in [file, ".photosite-a1b2c3.partial"] {
                fs::write(left.join(file), "left").expect("written");
            }
        }
        let picture = ours(&folder);
        assert_eq!(fs::read(picture.path().join("checkpoint.film")).expect("taken over"), b"left");
        assert_eq!(fs::read_dir(picture.path()).expect("a folder").count(), 1, "and nothing else of it");
        assert_eq!(unfinished_folders(&folder.picture("left", 7)), [picture.path()]);
        let kept = picture.path().to_owned();
        drop(picture);
        assert!(kept.exists(), "there is a checkpoint to go on from");
    }
}
