//! Locks that keep two processes from doing the same work.
//!
//! A lock is a file that its holder has locked. The kernel releases it when the holder dies, however that happens, so
//! that the protected work is never lost to a dead process. The holder removes the file with the lock.
//!
//! Not every network file system supports locks. There each process gets a lock that proves nothing
//! ([`Lock::is_proven`]), and correctness must not depend on it: names are unique to each process, and renames replace
//! nothing.

use photosite_core::{Help, Remedy};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use photosite_core::cleanup::Cleanup;
use photosite_core::output::{create_folders, folder_of};
use photosite_core::{Error, Invalid, Result};

/// Name of a folder's lock, a file in it.
const IN_FOLDER: &str = ".photosite.lock";

/// Lock that this process holds until it drops it.
#[derive(Debug)]
pub struct Lock {
    // Removed first, and unlocked then: what is locked must be what has the name.
    _cleanup: Cleanup,
    file: File,
    is_proven: bool,
}

impl Lock {
    /// Takes the lock of this file; `None` where another process holds it.
    pub fn try_take(path: &Path) -> Result<Option<Self>> {
        Self::take(path, File::try_lock).map_err(|reason| Error::io(path, "lock", reason))
    }

    /// Takes the lock of an existing folder, and waits while another process holds it.
    pub fn wait_for_folder(folder: &Path) -> Result<Self> {
        let path = folder.join(IN_FOLDER);
        let wait = |file: &File| file.lock().map_err(TryLockError::Error);
        loop {
            if let Some(lock) = Self::take(&path, wait).map_err(|reason| Error::io(&path, "lock", reason))? {
                return Ok(lock);
            }
        }
    }

    /// Takes the lock of a folder, which is created where missing. A folder that another process fills is refused.
    pub fn of_folder(folder: &Path) -> Result<Self> {
        let path = folder.join(IN_FOLDER);
        loop {
            create_folders(folder).map_err(|reason| Error::io(folder, "create the folder", reason))?;
            match Self::take(&path, File::try_lock) {
                Ok(Some(lock)) => return Ok(lock),
                Ok(None) => return Err(busy(folder, "folder")),
                // Whoever had made the folder has given it up and taken it away.
                Err(reason) if reason.kind() == ErrorKind::NotFound && !folder.is_dir() => {}
                Err(reason) => return Err(Error::io(&path, "lock", reason)),
            }
        }
    }

    /// Takes the lock of a file or folder that is being made, beside it. A path that another process is making is
    /// refused.
    pub fn beside(path: &Path) -> Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let lock = folder_of(path)?.join(format!(".{name}.lock"));
        Self::try_take(&lock)?.ok_or_else(|| busy(path, "name"))
    }

    fn take(path: &Path, lock: impl Fn(&File) -> Result<(), TryLockError>) -> io::Result<Option<Self>> {
        loop {
            // Network file systems lock only what may be written.
            let file = File::options().read(true).write(true).create(true).truncate(false).open(path)?;
            let is_proven = match lock(&file) {
                Ok(()) => true,
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(reason)) if reason.kind() == ErrorKind::Interrupted => continue,
                Err(TryLockError::Error(_)) => false,
            };
            // Its last holder may have removed it between the two.
            if !is_proven || has_name(&file, path) {
                let path = path.to_owned();
                let cleanup = Cleanup::new(move || remove(&path));
                return Ok(Some(Self { _cleanup: cleanup, file, is_proven }));
            }
        }
    }

    /// Whether no other process can hold the lock; false where the file system does not support locks.
    pub fn is_proven(&self) -> bool {
        self.is_proven
    }

    /// Locked file, in which the holder may state itself. A copy of it that stays open keeps the lock.
    pub fn file(&self) -> &File {
        &self.file
    }
}

/// Whether a process holds the lock of a file that was opened for this; `None` where the file system does not tell. The
/// check holds the lock for a moment, in which a process that wants it takes it for another's.
pub fn is_held(file: &File) -> Option<bool> {
    // Shared, for which network file systems ask no more than that the file may be read.
    match file.try_lock_shared() {
        Ok(()) => file.unlock().ok().map(|()| false),
        Err(TryLockError::WouldBlock) => Some(true),
        Err(TryLockError::Error(_)) => None,
    }
}

fn remove(path: &PathBuf) {
    let _ = fs::remove_file(path);
}

/// Whether an open file is the one of that name.
#[cfg(unix)]
fn has_name(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let same = |open: fs::Metadata, named: fs::Metadata| (open.dev(), open.ino()) == (named.dev(), named.ino());
    file.metadata().ok().zip(fs::metadata(path).ok()).is_some_and(|(open, named)| same(open, named))
}

#[cfg(not(unix))]
fn has_name(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Error of a path that another process holds, marked as temporary.
fn busy(path: &Path, what: &str) -> Error {
    let help = Help::any(["wait until that one has ended".into(), Remedy::Elsewhere(format!("another {what}"))]);
    Invalid::new("", "another process is writing here").help(help).in_file(path).temporary()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_held_once_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lock");
        let lock = Lock::try_take(&path).expect("a lock").expect("free");
        assert!(lock.is_proven() && Lock::try_take(&path).expect("no failure").is_none());
        let looked_at = File::open(&path).expect("a file");
        assert_eq!(is_held(&looked_at), Some(true));
        drop(lock);
        assert_eq!(is_held(&looked_at), Some(false));
        assert!(!path.exists());
        let again = Lock::try_take(&path).expect("a lock");
        assert!(again.is_some());
    }

    /// Case: the holder has removed the file while another process had it open, whose lock would exclude nobody.
    #[test]
    fn a_lock_on_a_file_that_lost_its_name_is_none() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lock");
        let calls = std::cell::Cell::new(0);
        let lock = Lock::take(&path, |file| {
            calls.set(calls.get() + 1);
            if calls.get() == 1 {
                fs::remove_file(&path).expect("removed");
            }
            file.try_lock()
        });
        assert!(lock.expect("a lock").is_some() && calls.get() == 2);
    }

    #[test]
    fn a_file_system_without_locks_gives_ones_that_prove_nothing() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("lock");
        let unknown = |_: &File| Err(TryLockError::Error(ErrorKind::Unsupported.into()));
        let [one, two] = [(); 2].map(|()| Lock::take(&path, unknown).expect("no failure").expect("one for each"));
        assert!(!one.is_proven() && !two.is_proven());
    }

    #[test]
    fn threads_that_race_for_a_lock_hold_it_one_by_one() {
        use std::sync::atomic::{AtomicU32, Ordering};
        let folder = tempfile::tempdir().expect("a folder");
        let holders = AtomicU32::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        let lock = Lock::wait_for_folder(folder.path()).expect("a lock");
                        assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0, "two hold it");
                        holders.fetch_sub(1, Ordering::SeqCst);
                        drop(lock);
                    }
                });
            }
        });
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 0);
    }
}
