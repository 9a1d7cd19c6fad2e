//! The folder of a data set: which pictures are there, and what they are pictures of.
//!
//! DIR/CAMERA/NUMBER holds the files of one picture. It is made beside as `.NUMBER.XXXXXX.partial` and renamed when it
//! is complete, so that whatever stands under its number is whole. `dataset.json` says what the folder is for,
//! `manifest.jsonl` what is in it, a line a picture.
//!
//! Several processes may fill it. Each picture has a lock, `.NUMBER.lock`, so that they make different ones, and know
//! what a dead one has left; what concerns the whole has the lock of the folder. The lock of a picture says who makes it,
//! `.NUMBER.failed` why it could not be made. Nothing is lost where the file system
//! knows no locks: each process makes a picture under a name of its own, the first to finish gives it its number, and
//! the other drops its own.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use photosite_core::{Remedy, fail_point, input};
use serde_json::Value;

use super::failure::{Failure, forget};
use super::frames::Frames;
use super::heartbeat::{Beating, Heartbeat};
use super::identity::{IDENTITY, read_identity, refusal, with_extent_of};
use super::presence::{damage, failure, lock, picture};
use crate::calibration::dataset::Plan;
use crate::io::lock::Lock;
use crate::io::output::{create_folder, remove_leftovers, write_new, write_whole};
use crate::io::pretty_json::pretty_json;
use crate::io::unfinished::{UnfinishedFolder, unfinished_folders};
use crate::pipeline::are_checkpoints_in;
use crate::report::{Listing, Look, REPORT};
use crate::{Error, Invalid, Result};

/// A folder that is known to be that of this data set.
pub struct DatasetFolder {
    path: PathBuf,
    knows_locks: bool,
    /// Whether the pictures' other files are somewhere else.
    has_reports_only: bool,
    heartbeat: Heartbeat,
}

impl DatasetFolder {
    /// Takes a new or empty folder, or one of the same data set; no other.
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
        Ok(Self {
            path: path.to_owned(),
            knows_locks: lock.is_proven(),
            has_reports_only: false,
            heartbeat: Heartbeat::default(),
        })
    }

    /// The same folder, of which a picture's report alone says that it is there: its files are in a store elsewhere.
    pub fn of_reports(self) -> Self {
        Self { has_reports_only: true, ..self }
    }

    /// Whether processes that fill the folder together know of each other.
    pub(super) fn knows_locks(&self) -> bool {
        self.knows_locks
    }

    /// Writes `dataset.json` again where somebody took it away: without it nothing opens the folder.
    pub(super) fn restore(&self, identity: &Value) -> Result<()> {
        if self.path.join(IDENTITY).exists() { Ok(()) } else { write_identity(&self.path, identity) }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a picture is there, with all of its files.
    pub(super) fn is_done(&self, camera: &str, number: u32) -> bool {
        let picture = self.picture(camera, number);
        if self.has_reports_only {
            return Listing::read(&picture.join(REPORT)).is_ok();
        }
        damage(&picture, Look::Sizes).is_none()
    }

    /// Begins a picture, or finds out who has it. One that has lost a file since it was made is made again.
    pub(super) fn begin(&self, camera: &str, number: u32) -> Result<Turn> {
        let path = self.picture(camera, number);
        if self.is_done(camera, number) {
            return Ok(Turn::Done);
        }
        let Some(lock) = Lock::try_take(&self.lock(camera, number))? else { return Ok(Turn::Theirs) };
        // Another process may have finished it before it let go of the lock.
        if self.is_done(camera, number) {
            return Ok(Turn::Done);
        }
        let lost = damage(&path, Look::Sizes).filter(|_| path.exists());
        if let Some(what) = &lost {
            remove_picture(&path, what, &lock)?;
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
        Ok(Turn::Ours(NewPicture { folder, failure, lost, _beating: self.heartbeat.of(&lock), _lock: lock }))
    }

    /// Takes away a picture that is damaged, unless another process makes it anew, or has done so.
    pub(super) fn remove(&self, camera: &str, number: u32, damage: impl Fn(&Path) -> Option<String>) -> Result<()> {
        let Some(lock) = Lock::try_take(&self.lock(camera, number))? else { return Ok(()) };
        let path = self.picture(camera, number);
        damage(&path).map_or(Ok(()), |what| remove_picture(&path, &what, &lock))
    }

    /// Where a picture is.
    pub(super) fn picture(&self, camera: &str, number: u32) -> PathBuf {
        picture(&self.path, camera, number)
    }

    fn lock(&self, camera: &str, number: u32) -> PathBuf {
        lock(&self.path, camera, number)
    }

    /// Keeps why a picture could not be made, until it is made. One that was asked to stop has not failed.
    pub(super) fn record_failure(&self, camera: &str, number: u32, error: &Error) {
        if !matches!(error, Error::Cancelled { .. }) {
            Failure::of(error).write(&failure(&self.path, camera, number));
        }
    }

    /// Keeps why frames cannot be had, of all their pictures.
    pub(super) fn record_failures<'a>(&self, frames: &Frames, cameras: impl Iterator<Item = &'a str> + Clone) {
        for (number, why) in &frames.reasons {
            cameras.clone().for_each(|camera| why.write(&failure(&self.path, camera, *number)));
        }
    }

    /// Removes what dead processes have left beside pictures that are done.
    pub(super) fn sweep(&self, plan: &Plan) -> Result<()> {
        for camera in plan.cameras().iter().map(|camera| &*camera.place.name) {
            let folder = self.path.join(camera);
            let entries = input::entries(&folder).map_err(|reason| Error::io(&folder, "read", reason))?;
            let number = |name: &str| name.strip_prefix('.')?.split('.').next()?.parse().ok();
            let numbers = entries.flatten().filter_map(|entry| number(&entry.file_name().to_string_lossy()));
            for number in numbers.collect::<BTreeSet<u32>>() {
                // The lock leaves with its file.
                let lock = Lock::try_take(&self.lock(camera, number))?;
                let path = self.picture(camera, number);
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

/// Refuses a folder that holds something else than a data set. Whoever begins at the same time may have begun to fill it.
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

/// The error of a place that is not for this data set.
fn not_of_set(message: String) -> Error {
    let help = Remedy::Elsewhere("another folder, as pictures of two data sets must not be mixed".to_owned());
    Error::Usage { message, help: Some(help.into()) }
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
    /// Where an earlier try has left why it failed.
    failure: PathBuf,
    /// What was wrong with an earlier one that it replaces.
    lost: Option<String>,
    _beating: Beating,
    _lock: Lock,
}

impl NewPicture {
    /// What was wrong with an earlier one, if there was one.
    pub(super) fn lost(&self) -> Option<&str> {
        self.lost.as_deref()
    }

    /// The folder for its files.
    pub(super) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Gives the complete picture its number: whether this process was the one to do so.
    pub(super) fn finish(self) -> Result<bool> {
        check_complete(self.folder.path())?;
        fail_point::reach("picture-complete");
        let is_ours = self.folder.finish()?;
        forget(&self.failure);
        Ok(is_ours)
    }
}

/// Removes a picture of which something is damaged. It loses its number first, so that none is ever seen that lacks
/// more and more.
///
/// Without a lock another process may be about to put a whole one in its place, which must not be lost.
fn remove_picture(path: &Path, what: &str, lock: &Lock) -> Result<()> {
    if !lock.is_proven() {
        let message = format!("is damaged: {what}; and its file system does not support locks");
        let help = "remove the folder while no process fills the data set, and run the command again";
        return Err(Invalid::new("", message).help(help).in_file(path));
    }
    // Under a name of its own it is one that is given up.
    UnfinishedFolder::beside(path, |_| false)?.take_over(path);
    Ok(())
}

/// Refuses a picture that lacks a file which its report names.
fn check_complete(folder: &Path) -> Result<()> {
    let Some(what) = damage(folder, Look::Sizes) else { return Ok(()) };
    let invalid = Invalid::new("", format!("was written, and then {what}"));
    Err(invalid.help("run the command again, which makes the picture again").in_file(folder).temporary())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, DatasetFolder) {
        let root = tempfile::tempdir().expect("a folder");
        fs::create_dir(root.path().join("left")).expect("made");
        let folder = DatasetFolder {
            path: root.path().to_owned(),
            knows_locks: true,
            has_reports_only: false,
            heartbeat: Heartbeat::default(),
        };
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
    fn a_picture_that_lost_a_file_is_made_again() {
        let (root, folder) = folder();
        for lost in ["raw.dng", REPORT] {
            let picture = ours(&folder);
            fill(picture.path());
            assert!(picture.finish().expect("finished") && folder.is_done("left", 7));
            fs::remove_file(folder.picture("left", 7).join(lost)).expect("removed");
            assert!(!folder.is_done("left", 7), "{lost}");
        }
        drop(ours(&folder));
        assert_eq!(names(&root), [""; 0], "nothing of the damaged one is left");
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
