//! Folders that appear whole or not at all.
//!
//! A folder is made beside its place under a name that no other process has, `.NAME.XXXXXX.partial`, synced, and
//! renamed when it is complete. Of several processes that make the same folder, one gives it the name, and the others
//! drop theirs.

use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use photosite_core::cleanup::Cleanup;
use photosite_core::output::{PARTIAL, create_folder, folder_of, sync_folder};
use photosite_core::{Error, Result};

/// Folder that is being filled. It is removed when it is given up.
#[derive(Debug)]
pub struct UnfinishedFolder {
    /// Final path of the folder.
    target: PathBuf,
    /// Path of the folder while it is unfinished.
    partial: PathBuf,
    cleanup: Cleanup,
}

impl UnfinishedFolder {
    /// Begins an empty folder for `path`, whose parent is created where missing. A folder that is given up stays if
    /// `is_kept` returns true for it.
    pub fn beside(path: &Path, is_kept: impl Fn(&Path) -> bool + Send + 'static) -> Result<Self> {
        create_folder(path.parent().unwrap_or(Path::new("")))?;
        let parent = folder_of(path)?;
        let prefix = format!(".{}.", path.file_name().unwrap_or_default().to_string_lossy());
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(PARTIAL);
        #[cfg(unix)]
        {
            // Temporary folders are private; what becomes of this is not.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(fs::Permissions::from_mode(0o777));
        }
        let made = builder.tempdir_in(parent).map_err(|reason| Error::io(parent, "write into", reason))?;
        let partial = made.keep();
        let unfinished = partial.clone();
        let cleanup = Cleanup::new(move || {
            if !is_kept(&unfinished) {
                let _ = fs::remove_dir_all(&unfinished);
            }
        });
        Ok(Self { target: path.to_owned(), partial, cleanup })
    }

    /// Folder to write to.
    pub fn path(&self) -> &Path {
        &self.partial
    }

    /// Takes over an older unfinished folder with its contents in place of this one; returns false if another process
    /// has taken it.
    pub fn take_over(&self, older: &Path) -> bool {
        // An empty folder gives way, though not everywhere.
        let _ = fs::remove_dir(&self.partial);
        fs::rename(older, &self.partial).is_ok() || {
            // As it was.
            let _ = fs::create_dir(&self.partial);
            false
        }
    }

    /// Gives the complete folder its name. Where another process has filled a folder of that name, this one is removed,
    /// and false is returned.
    pub fn finish(self) -> Result<bool> {
        sync_all(&self.partial)?;
        match fs::rename(&self.partial, &self.target) {
            Ok(()) => {
                self.cleanup.disarm();
                sync_folder(folder_of(&self.target)?)?;
                Ok(true)
            }
            Err(_) if is_filled(&self.target) => {
                self.cleanup.disarm();
                let removed = fs::remove_dir_all(&self.partial);
                removed.map_err(|reason| Error::io(&self.partial, "remove the folder", reason))?;
                Ok(false)
            }
            Err(reason) => Err(Error::io(&self.target, "rename the finished folder to", reason)),
        }
    }
}

/// Whether a folder is not empty.
pub fn is_filled(path: &Path) -> bool {
    fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some())
}

/// Unfinished folders for `path`, of living processes and of dead ones.
pub fn unfinished_folders(path: &Path) -> Vec<PathBuf> {
    let prefix = format!(".{}.", path.file_name().unwrap_or_default().to_string_lossy());
    let is_one = |name: &str| name.starts_with(&prefix) && name.ends_with(PARTIAL);
    let entries = folder_of(path).ok().and_then(|folder| fs::read_dir(folder).ok()).into_iter().flatten().flatten();
    entries.filter(|entry| is_one(&entry.file_name().to_string_lossy())).map(|entry| entry.path()).collect()
}

/// Syncs a folder with all that is below it.
fn sync_all(folder: &Path) -> Result<()> {
    let failed = |path: &Path, reason: std::io::Error| {
        let is_gone = reason.kind() == ErrorKind::NotFound;
        let error = Error::io(path, "write", reason);
        // It was there.
        if is_gone { error.temporary() } else { error }
    };
    for entry in fs::read_dir(folder).map_err(|reason| failed(folder, reason))? {
        let path = entry.map_err(|reason| failed(folder, reason))?.path();
        if path.is_dir() {
            sync_all(&path)?;
        } else {
            let file = File::options().write(true).open(&path);
            file.and_then(|file| file.sync_all()).map_err(|reason| failed(&path, reason))?;
        }
    }
    sync_folder(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(path: &Path, text: &str) -> UnfinishedFolder {
        let folder = UnfinishedFolder::beside(path, |_| false).expect("begun");
        fs::write(folder.path().join("text"), text).expect("written");
        folder
    }

    #[test]
    fn of_two_that_make_the_same_one_is_kept_and_the_other_leaves_nothing() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path().join("000007");
        let [one, two] = ["one", "two"].map(|text| filled(&path, text));
        assert_ne!(one.path(), two.path());
        assert_eq!(unfinished_folders(&path).len(), 2);
        assert!(two.finish().expect("renamed") && !one.finish().expect("dropped"));
        assert_eq!(fs::read_to_string(path.join("text")).expect("there"), "two");
        assert_eq!(fs::read_dir(root.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn what_is_given_up_is_removed_unless_it_is_kept() {
        let root = tempfile::tempdir().expect("a folder");
        let path = root.path().join("layout");
        drop(filled(&path, "given up"));
        assert_eq!(fs::read_dir(root.path()).expect("a folder").count(), 0);
        let kept = UnfinishedFolder::beside(&path, |folder| folder.join("text").exists()).expect("begun");
        fs::write(kept.path().join("text"), "kept").expect("written");
        drop(kept);
        let left = unfinished_folders(&path);
        let next = UnfinishedFolder::beside(&path, |_| false).expect("begun");
        assert!(next.take_over(&left[0]) && !next.take_over(&left[0]));
    }
}
