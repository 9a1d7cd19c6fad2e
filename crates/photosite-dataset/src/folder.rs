//! Folder of a data set: which images are there, and how several processes fill it.
//!
//! DIR/CAMERA/NUMBER holds the files of one image. The folder is made as `.NUMBER.XXXXXX.partial` beside it and renamed
//! when it is complete, so that a folder with a number is always whole. `dataset.json` identifies the data set, and
//! `manifest.jsonl` lists its images, one per line.
//!
//! Several processes may fill the folder. Each image has a lock, `.NUMBER.lock`, so that they make different images and
//! recognise what dead processes have left; operations on the whole take the lock of the folder. The lock of an image
//! names its maker, and `.NUMBER.failed` says why it could not be made. Where the file system supports no locks, no
//! image is lost: each process makes an image under a name of its own, the first to finish gives it its number, and the
//! others remove theirs.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use photosite_core::{Remedy, fail_point, input};
use serde_json::Value;

use super::failure::{Failure, forget};
use super::frames::Frames;
use super::heartbeat::{Beating, Heartbeat};
use super::identity::{IDENTITY, read_identity, refusal, with_extent_of};
use super::image_folder::{damage, failure, image, lock};
use photosite_calibration::dataset::Plan;
use photosite_capture::report::CheckDepth;
use photosite_core::output::{create_folder, remove_leftovers, write_new, write_whole};
use photosite_core::{Error, Invalid, Result};
use photosite_files::lock::Lock;
use photosite_files::pretty_json::pretty_json;
use photosite_files::unfinished::{UnfinishedFolder, unfinished_folders};
use photosite_pipeline::are_checkpoints_in;

/// Folder that is known to be that of this data set.
pub struct DatasetFolder {
    path: PathBuf,
    knows_locks: bool,
    heartbeat: Heartbeat,
}

impl DatasetFolder {
    /// Claims a new or empty folder, or one of the same data set; no other.
    pub fn claim(path: &Path, identity: &Value, plan: &Plan) -> Result<Self> {
        check_is_folder(path)?;
        create_folder(path)?;
        let marker = path.join(IDENTITY);
        // Whoever begins at the same time takes part.
        let lock = Lock::wait_for_folder(path)?;
        if lock.is_proven() {
            remove_leftovers(path);
        }
        if !marker.exists() {
            refuse_filled(path)?;
            write_identity(path, identity)?;
        }
        let earlier = read_identity(&marker)?;
        if let Some(difference) = refusal(&earlier, identity) {
            return Err(not_of_set(format!("{} {difference}", path.display())));
        }
        if let Some(now) = with_extent_of(&earlier, identity) {
            write_whole(&marker, |to| writeln!(to, "{}", pretty_json(&now)))?;
        }
        for camera in plan.cameras() {
            create_folder(&path.join(&camera.place.name))?;
        }
        Ok(Self { path: path.to_owned(), knows_locks: lock.is_proven(), heartbeat: Heartbeat::default() })
    }

    /// Whether processes that fill the folder together know of each other.
    pub(super) fn knows_locks(&self) -> bool {
        self.knows_locks
    }

    /// Writes `dataset.json` again where somebody removed it: without it nothing opens the folder.
    pub(super) fn restore(&self, identity: &Value) -> Result<()> {
        if self.path.join(IDENTITY).exists() { Ok(()) } else { write_identity(&self.path, identity) }
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether an image is there, with all of its files.
    pub(super) fn is_done(&self, camera: &str, number: u32) -> bool {
        damage(&self.image(camera, number), CheckDepth::Sizes).is_none()
    }

    /// Begins an image, or finds out who makes it. An image that has lost a file since it was made is made again.
    pub(super) fn begin(&self, camera: &str, number: u32) -> Result<Turn> {
        let path = self.image(camera, number);
        if self.is_done(camera, number) {
            return Ok(Turn::Done);
        }
        let Some(lock) = Lock::try_take(&self.lock(camera, number))? else { return Ok(Turn::Theirs) };
        // Another process may have finished it before it let go of the lock.
        if self.is_done(camera, number) {
            return Ok(Turn::Done);
        }
        let lost = damage(&path, CheckDepth::Sizes).filter(|_| path.exists());
        if let Some(what) = &lost {
            remove_image(&path, what, &lock)?;
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
        let failure = failure(&self.path, camera, number);
        Ok(Turn::Ours(NewImage { folder, failure, lost, _beating: self.heartbeat.of(&lock), _lock: lock }))
    }

    /// Removes a damaged image, unless another process is making it anew or has done so.
    pub(super) fn remove(&self, camera: &str, number: u32, damage: impl Fn(&Path) -> Option<String>) -> Result<()> {
        let Some(lock) = Lock::try_take(&self.lock(camera, number))? else { return Ok(()) };
        let path = self.image(camera, number);
        damage(&path).map_or(Ok(()), |what| remove_image(&path, &what, &lock))
    }

    /// Folder of an image.
    pub(super) fn image(&self, camera: &str, number: u32) -> PathBuf {
        image(&self.path, camera, number)
    }

    fn lock(&self, camera: &str, number: u32) -> PathBuf {
        lock(&self.path, camera, number)
    }

    /// Records why an image could not be made, until it is made. A cancelled image has not failed.
    pub(super) fn record_failure(&self, camera: &str, number: u32, error: &Error) {
        if !matches!(error, Error::Cancelled { .. }) {
            Failure::of(error).write(&failure(&self.path, camera, number));
        }
    }

    /// Records for all images of the refused frames why these cannot be planned.
    pub(super) fn record_failures<'a>(&self, frames: &Frames, cameras: impl Iterator<Item = &'a str> + Clone) {
        for (number, why) in &frames.reasons {
            cameras.clone().for_each(|camera| why.write(&failure(&self.path, camera, *number)));
        }
    }

    /// Removes what dead processes have left beside finished images.
    pub(super) fn sweep(&self, plan: &Plan) -> Result<()> {
        for camera in plan.cameras().iter().map(|camera| &*camera.place.name) {
            let folder = self.path.join(camera);
            let entries = input::entries(&folder).map_err(|reason| Error::io(&folder, "read", reason))?;
            let number = |name: &str| name.strip_prefix('.')?.split('.').next()?.parse().ok();
            let numbers = entries.flatten().filter_map(|entry| number(&entry.file_name().to_string_lossy()));
            for number in numbers.collect::<BTreeSet<u32>>() {
                // The lock leaves with its file.
                let lock = Lock::try_take(&self.lock(camera, number))?;
                let path = self.image(camera, number);
                if path.exists() {
                    forget(&failure(&self.path, camera, number));
                }
                if lock.is_some_and(|lock| lock.is_proven() && path.exists()) {
                    // Nothing depends on it.
                    unfinished_folders(&path).iter().for_each(|folder| drop(fs::remove_dir_all(folder)));
                }
            }
        }
        Ok(())
    }
}

/// Refuses what [`DatasetFolder::claim`] would refuse, and changes nothing.
pub(super) fn check_folder(path: &Path, identity: &Value) -> Result<()> {
    check_is_folder(path)?;
    let marker = path.join(IDENTITY);
    if !marker.exists() {
        return if path.exists() { refuse_filled(path) } else { Ok(()) };
    }
    match refusal(&read_identity(&marker)?, identity) {
        Some(difference) => Err(not_of_set(format!("{} {difference}", path.display()))),
        None => Ok(()),
    }
}

/// Refuses a folder that holds something other than a data set. Another process may have begun to fill it at the same
/// time.
fn refuse_filled(path: &Path) -> Result<()> {
    let entries = input::entries(path).map_err(|reason| Error::io(path, "read", reason))?;
    let mut names = entries.flatten().map(|entry| entry.file_name());
    if names.any(|name| !name.to_string_lossy().starts_with(".photosite")) && !path.join(IDENTITY).exists() {
        return Err(not_of_set(format!("{} is not empty and does not contain a data set", path.display())));
    }
    Ok(())
}

fn write_identity(folder: &Path, identity: &Value) -> Result<()> {
    write_new(&folder.join(IDENTITY), |to| writeln!(to, "{}", pretty_json(identity))).map(|_| ())
}

fn check_is_folder(path: &Path) -> Result<()> {
    if path.is_file() {
        return Err(not_of_set(format!("{} is a file, but a folder is needed", path.display())));
    }
    Ok(())
}

/// Error of a folder that is not for this data set.
fn not_of_set(message: String) -> Error {
    let help = Remedy::Elsewhere("another folder, as images of two data sets must not be mixed".to_owned());
    Error::Usage { message, help: Some(help.into()) }
}

/// Answer to a process that wants to make an image.
pub(super) enum Turn {
    /// The image is there.
    Done,
    /// Another process makes the image.
    Theirs,
    /// No other process makes the image.
    Ours(NewImage),
}

/// Image that is being made. Its folder is removed when it is given up, unless there is a checkpoint to go on from.
pub(super) struct NewImage {
    // Put away before the lock is let go of.
    folder: UnfinishedFolder,
    /// Path of the failure that an earlier attempt has left.
    failure: PathBuf,
    /// Damage of an earlier image that this one replaces.
    lost: Option<String>,
    _beating: Beating,
    _lock: Lock,
}

impl NewImage {
    /// Damage of the earlier image, if there was one.
    pub(super) fn lost(&self) -> Option<&str> {
        self.lost.as_deref()
    }

    /// Folder for the image's files.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Gives the complete image its number; returns whether this process was the one to do so.
    pub(super) fn finish(self) -> Result<bool> {
        check_complete(self.folder.path())?;
        fail_point::reach("picture-complete");
        let is_ours = self.folder.finish()?;
        forget(&self.failure);
        Ok(is_ours)
    }
}

/// Removes a damaged image. Its number is taken away first, so that no process ever sees an image that loses file after
/// file.
///
/// Without a lock another process may be about to put a whole one in its place, which must not be lost.
fn remove_image(path: &Path, what: &str, lock: &Lock) -> Result<()> {
    if !lock.is_proven() {
        let message = format!("is damaged: {what}; and its file system does not support locks");
        let help = "remove the folder while no process fills the data set, and run the command again";
        return Err(Invalid::new("", message).help(help).in_file(path));
    }
    // Under a name of its own it is one that is given up.
    UnfinishedFolder::beside(path, |_| false)?.take_over(path);
    Ok(())
}

/// Refuses an image that lacks a file which its report names.
fn check_complete(folder: &Path) -> Result<()> {
    let Some(what) = damage(folder, CheckDepth::Sizes) else { return Ok(()) };
    let invalid = Invalid::new("", format!("was written, and then {what}"));
    Err(invalid.help("run the command again, which makes the image again").in_file(folder).temporary())
}

#[cfg(test)]
mod tests {
    use photosite_capture::report::REPORT;

    use super::*;

    fn folder() -> (tempfile::TempDir, DatasetFolder) {
        let root = tempfile::tempdir().expect("a folder");
        fs::create_dir(root.path().join("left")).expect("made");
        let folder = DatasetFolder { path: root.path().to_owned(), knows_locks: true, heartbeat: Heartbeat::default() };
        (root, folder)
    }

    fn fill(image: &Path) {
        fs::write(image.join("raw.dng"), "raw").expect("written");
        fs::write(image.join(REPORT), r#"{"files": ["raw.dng"]}"#).expect("written");
    }

    fn ours(folder: &DatasetFolder) -> NewImage {
        match folder.begin("left", 7).expect("no failure") {
            Turn::Ours(image) => image,
            Turn::Done | Turn::Theirs => panic!("nobody else is there"),
        }
    }

    fn names(root: &tempfile::TempDir) -> Vec<String> {
        let entries = fs::read_dir(root.path().join("left")).expect("a folder");
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn an_image_that_somebody_makes_is_left_to_them() {
        let (root, folder) = folder();
        let image = ours(&folder);
        assert!(matches!(folder.begin("left", 7).expect("no failure"), Turn::Theirs));
        assert!(matches!(folder.begin("left", 8).expect("no failure"), Turn::Ours(_)));
        fill(image.path());
        assert!(image.finish().expect("finished"));
        assert!(matches!(folder.begin("left", 7).expect("no failure"), Turn::Done));
        assert_eq!(names(&root), ["000007"]);
    }

    /// Case: two processes that do not see each other's lock, as on a file system without locks: the lock is taken
    /// away.
    #[test]
    fn without_locks_one_of_two_makes_the_image_and_no_file_is_lost() {
        let (root, folder) = folder();
        let first = ours(&folder);
        fs::write(first.path().join("electrons.exr"), "electrons").expect("written");
        fs::rename(folder.lock("left", 7), root.path().join("lock")).expect("taken away");
        let unproven = UnfinishedFolder::beside(&folder.image("left", 7), are_checkpoints_in).expect("begun");
        fill(unproven.path());
        fill(first.path());
        assert_eq!(fs::read_dir(first.path()).expect("a folder").count(), 3);
        assert!(first.finish().expect("finished"));
        assert!(!unproven.finish().expect("dropped"));
        assert_eq!(fs::read_dir(folder.image("left", 7)).expect("a folder").count(), 3);
        assert_eq!(names(&root), ["000007"]);
    }

    #[test]
    fn an_image_that_lost_a_file_is_made_again() {
        let (root, folder) = folder();
        for lost in ["raw.dng", REPORT] {
            let image = ours(&folder);
            fill(image.path());
            assert!(image.finish().expect("finished") && folder.is_done("left", 7));
            fs::remove_file(folder.image("left", 7).join(lost)).expect("removed");
            assert!(!folder.is_done("left", 7), "{lost}");
        }
        drop(ours(&folder));
        assert_eq!(names(&root), [""; 0], "nothing of the damaged one is left");
    }

    #[test]
    fn an_image_that_lost_a_file_does_not_get_its_number() {
        let (root, folder) = folder();
        for lost in ["raw.dng", REPORT] {
            let image = ours(&folder);
            fill(image.path());
            fs::remove_file(image.path().join(lost)).expect("removed");
            let error = image.finish().expect_err("incomplete");
            assert!(error.is_temporary() && error.to_string().contains(lost), "{error}");
        }
        assert_eq!(names(&root), [""; 0]);
    }

    /// Case: leftovers of dead processes, and of versions that had one name for all.
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
        let image = ours(&folder);
        assert_eq!(fs::read(image.path().join("checkpoint.film")).expect("taken over"), b"left");
        assert_eq!(fs::read_dir(image.path()).expect("a folder").count(), 1, "and nothing else of it");
        assert_eq!(unfinished_folders(&folder.image("left", 7)), [image.path()]);
        let kept = image.path().to_owned();
        drop(image);
        assert!(kept.exists(), "there is a checkpoint to go on from");
    }
}
