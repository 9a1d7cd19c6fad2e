//! Writing of files that appear whole or not at all, and survive a power cut.
//!
//! A file is written under a name that no other process has, synced, and renamed; then its folder is synced. While it
//! is written it is locked, so that the next process that writes to its folder recognises and removes files of dead
//! processes.

use std::collections::BTreeSet;
use std::fs::{self, File, Metadata};
use std::io::{self, BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::cleanup::Cleanup;
use crate::fail_point;
use crate::sandbox;
use crate::{Error, Invalid, Result};

/// Prefix of the names of files that are being written.
const PREFIX: &str = ".photosite-";
/// Suffix of the names of files and folders that are being written.
pub const PARTIAL: &str = ".partial";

/// A file being written, as encoders see it.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Writes `path` through a temporary file beside it, renamed into place once `write` has succeeded. On failure nothing
/// is left behind and an older file of that name stays as it was.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<()> {
    write_beside(path, write)?.put_in_place(path)
}

/// Writes a file beside its place and syncs it, under a temporary name.
pub fn write_beside(path: &Path, write: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<FileBeside> {
    Ok(FileBeside(Temporary::write(path, write)?.synced(path)?))
}

/// A complete, synced file under a temporary name, which is removed unless it is put in place.
pub struct FileBeside(Temporary);

impl FileBeside {
    /// Renames the file to its final name, replacing an older file of that name.
    pub fn put_in_place(self, path: &Path) -> Result<()> {
        self.0.persist(path)?;
        sync_folder(folder_of(path)?)
    }
}

/// Writes a file as [`write_whole`] does, unless a file of that name exists by then; that one stays as it was. Returns
/// whether the file was written.
pub fn write_new(path: &Path, write: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<bool> {
    let is_new = Temporary::write(path, write)?.synced(path)?.persist_new(path)?;
    sync_folder(folder_of(path)?)?;
    Ok(is_new)
}

/// Writes a whole file that need not survive a power cut: a preview of work under way, or one of a folder that is
/// synced when it is finished (`UnfinishedFolder` of the files of data sets).
pub fn write_unsynced(path: &Path, write: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<()> {
    Temporary::write(path, write)?.persist(path).map(|_| ())
}

/// Writes a file as [`write_whole`] does, or as [`write_unsynced`], and returns the stamp that tells it from a file
/// that another process puts in its place.
pub fn write_stamped(
    path: &Path,
    is_synced: bool,
    write: impl FnOnce(&mut dyn Sink) -> io::Result<()>,
) -> Result<Stamp> {
    let file = Temporary::write(path, write)?;
    if !is_synced {
        return file.persist(path);
    }
    let stamp = file.synced(path)?.persist(path)?;
    sync_folder(folder_of(path)?)?;
    Ok(stamp)
}

/// Size and inode, which tell a file from others that had its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamp {
    bytes: u64,
    inode: u64,
}

impl Stamp {
    fn of(file: &Metadata) -> Self {
        #[cfg(unix)]
        let inode = std::os::unix::fs::MetadataExt::ino(file);
        #[cfg(not(unix))]
        let inode = 0;
        Self { bytes: file.len(), inode }
    }

    /// Whether the file of that name is still the stamped one.
    pub fn is_of(self, path: &Path) -> bool {
        fs::metadata(path).is_ok_and(|file| Self::of(&file) == self)
    }
}

/// A file under a temporary name.
struct Temporary {
    file: NamedTempFile,
    cleanup: Cleanup,
}

impl Temporary {
    fn write(path: &Path, write: impl FnOnce(&mut dyn Sink) -> io::Result<()>) -> Result<Self> {
        let failed = |reason| Error::io(path, "write", reason);
        // Its reasons do not name the temporary file, which nobody knows.
        let open = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
        let folder = folder_of(path)?;
        sandbox::written(folder).map_err(failed)?;
        sweep_once(folder);
        let begin = || -> io::Result<NamedTempFile> {
            loop {
                let file = tempfile::Builder::new().prefix(PREFIX).suffix(PARTIAL).make_in(folder, open)?;
                // Tells that somebody lives who writes it. A file system without locks gives none, and nobody sweeps.
                let _ = file.as_file().lock();
                // Somebody who sweeps may have come between the two.
                if file.path().exists() {
                    return Ok(file);
                }
            }
        };
        let mut file = begin().map_err(failed)?;
        let temporary = file.path().to_owned();
        let cleanup = Cleanup::new(move || {
            let _ = fs::remove_file(&temporary);
        });
        let mut buffered = BufWriter::new(Remembering::new(file.as_file_mut()));
        let written = write(&mut buffered).and_then(|()| buffered.flush());
        let (remembering, _) = buffered.into_parts();
        // What the file said comes before what an encoder has made of it.
        if let Err(reason) = written {
            return Err(failed(remembering.failure.unwrap_or(reason)));
        }
        #[cfg(unix)]
        {
            // Temporary files are private; an image is not.
            use std::os::unix::fs::PermissionsExt;
            file.as_file().set_permissions(fs::Permissions::from_mode(0o644)).map_err(failed)?;
        }
        fail_point::reach("file-written");
        Ok(Self { file, cleanup })
    }

    fn synced(self, path: &Path) -> Result<Self> {
        self.file.as_file().sync_all().map_err(|reason| Error::io(path, "write", reason))?;
        Ok(self)
    }

    fn persist(self, path: &Path) -> Result<Stamp> {
        let failed = |reason| Error::io(path, "write", reason);
        let stamp = Stamp::of(&self.file.as_file().metadata().map_err(failed)?);
        self.file.persist(path).map_err(|e| failed(e.error))?;
        self.cleanup.disarm();
        fail_point::reach("file-named");
        Ok(stamp)
    }

    fn persist_new(self, path: &Path) -> Result<bool> {
        match self.file.persist_noclobber(path) {
            Ok(_) => {
                self.cleanup.disarm();
                Ok(true)
            }
            Err(e) if e.error.kind() == ErrorKind::AlreadyExists => Ok(false),
            Err(e) => Err(Error::io(path, "write", e.error)),
        }
    }
}

/// A writer that remembers its first error, which encoders wrap beyond recognition.
pub struct Remembering<W> {
    inner: W,
    failure: Option<io::Error>,
}

impl<W> Remembering<W> {
    /// Wrapper of a writer without errors so far.
    pub fn new(inner: W) -> Self {
        Self { inner, failure: None }
    }

    /// First error of the writer.
    pub fn into_failure(self) -> Option<io::Error> {
        self.failure
    }

    fn remember<T>(&mut self, outcome: io::Result<T>) -> io::Result<T> {
        if let Err(reason) = &outcome
            && reason.kind() != ErrorKind::Interrupted
            && self.failure.is_none()
        {
            self.failure = Some(same(reason));
        }
        outcome
    }
}

impl<W: Write> Write for Remembering<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes);
        self.remember(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.inner.flush();
        self.remember(flushed)
    }
}

impl<W: Seek> Seek for Remembering<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let place = self.inner.seek(to);
        self.remember(place)
    }
}

/// Copy of an error, which is not `Clone`.
fn same(reason: &io::Error) -> io::Error {
    reason.raw_os_error().map_or_else(|| reason.kind().into(), io::Error::from_raw_os_error)
}

/// The folder that a file is written to.
pub fn folder_of(path: &Path) -> Result<&Path> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let help = "create it first, or choose another name";
        return Err(Invalid::new("", "does not exist, or is not a folder").help(help).in_file(folder));
    }
    Ok(folder)
}

/// Creates a folder and its parents.
pub fn create_folder(path: &Path) -> Result<()> {
    let created: Vec<&Path> = path.ancestors().take_while(|part| !part.exists()).collect();
    create_folders(path).map_err(|reason| Error::io(path, "create the folder", reason))?;
    created.into_iter().try_for_each(|folder| folder_of(folder).and_then(sync_folder))
}

/// Creates a folder and its parents, not synced, where no link leads out of the sandbox.
///
/// # Errors
///
/// A link that leads out, or the system's error.
pub fn create_folders(path: &Path) -> io::Result<()> {
    sandbox::written(path)?;
    fs::create_dir_all(path)
}

/// Makes sure that names in a folder are what they are after a power cut, too.
pub fn sync_folder(path: &Path) -> Result<()> {
    // Elsewhere folders cannot be opened.
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(path).and_then(|folder| folder.sync_all()) {
        Err(reason) if !is_no_need(reason.kind()) => Err(Error::io(path, "write to the folder", reason)),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// Whether an error only means that a file system does not sync folders, or that the folder must not be read.
fn is_no_need(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::InvalidInput | ErrorKind::Unsupported | ErrorKind::PermissionDenied)
}

/// Removes files that a process was writing to a folder when it died. No living process may be writing to it.
pub fn remove_leftovers(folder: &Path) {
    let names = fs::read_dir(folder).into_iter().flatten().flatten();
    let leftovers = names.filter(|entry| is_temporary(&entry.file_name().to_string_lossy()));
    // Nothing depends on it.
    leftovers.for_each(|entry| drop(fs::remove_file(entry.path())));
}

/// Removes files that dead processes were writing to a folder, once for each folder that this process writes to. Files
/// of living processes are locked and stay.
fn sweep_once(folder: &Path) {
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let Ok(whole) = folder.canonicalize() else { return };
    if SWEPT.lock().unwrap_or_else(PoisonError::into_inner).insert(whole) {
        sweep(folder);
    }
}

fn sweep(folder: &Path) {
    let names = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in names.filter(|entry| is_temporary(&entry.file_name().to_string_lossy())) {
        // Network file systems lock only what may be written.
        let Ok(file) = File::options().write(true).open(entry.path()) else { continue };
        if file.try_lock().is_ok() {
            // Nothing depends on it.
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_temporary(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(PARTIAL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("picture.dng");
        write_whole(&path, |sink| sink.write_all(b"first")).expect("written");
        let failure = write_whole(&path, |sink| {
            sink.write_all(b"sec")?;
            Err(std::io::Error::other("disk full"))
        });
        assert!(failure.is_err());
        assert_eq!(fs::read(&path).expect("still there"), b"first");
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
    }

    #[test]
    fn files_of_the_dead_are_swept_and_those_of_the_living_stay() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let count = || fs::read_dir(folder.path()).expect("readable").count();
        let dead = folder.path().join(".photosite-a1b2c3.partial");
        let others = [".photosite.lock", ".photosite-a1b2c3", "photosite-a.partial"].map(|n| folder.path().join(n));
        others.iter().chain([&dead]).for_each(|path| fs::write(path, "half").expect("written"));
        let living = write_beside(&folder.path().join("a.dng"), |sink| sink.write_all(b"whole")).expect("written");
        assert!(!dead.exists() && count() == others.len() + 1);
        sweep(folder.path());
        assert_eq!(count(), others.len() + 1, "what is being written stays");
        living.put_in_place(&folder.path().join("a.dng")).expect("named");
        sweep(folder.path());
        assert!(count() == others.len() + 1 && folder.path().join("a.dng").exists());
    }

    #[test]
    fn a_new_file_replaces_none() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("dataset.json");
        let write = |text: &'static [u8]| write_new(&path, |sink| sink.write_all(text));
        assert!(write(b"first").expect("written") && !write(b"second").expect("refused"));
        assert_eq!(fs::read(&path).expect("still there"), b"first");
        assert_eq!(fs::read_dir(folder.path()).expect("readable").count(), 1);
    }

    #[test]
    fn a_file_that_another_process_replaced_is_known() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let path = folder.path().join("raw.dng");
        let stamp = write_stamped(&path, true, |sink| sink.write_all(b"ours!!")).expect("written");
        assert!(stamp.is_of(&path));
        write_whole(&path, |sink| sink.write_all(b"theirs")).expect("written");
        assert!(!stamp.is_of(&path));
        fs::remove_file(&path).expect("removed");
        assert!(!stamp.is_of(&path));
    }

    #[test]
    fn what_a_killed_process_was_writing_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().expect("temporary folder");
        let names = [".photosite-x1y2z3.partial", ".000001.x1y2z3.partial", "raw.dng", ".photosite.lock"];
        names.iter().for_each(|name| fs::write(folder.path().join(name), name).expect("written"));
        remove_leftovers(folder.path());
        assert_eq!(names.map(|name| folder.path().join(name).exists()), [false, true, true, true]);
    }
}
