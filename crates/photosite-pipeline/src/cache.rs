//! Cache of the programs on disk: images of points through lenses from prescriptions, which take long to work out.
//!
//! Each node of them is a file of its own in a folder that is called by what its images follow from. It is written
//! whole or not at all, and one that is broken is worked out anew.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::SystemTime;
use std::{env, fs};

use sha2::{Digest, Sha256};

use photosite_transport::optics::{Shelf, keep_point_spreads};

/// Environment variable that names the folder, or is `off`.
const VARIABLE: &str = "PHOTOSITE_CACHE";
/// Most bytes on disk, beyond which the folders that are not in use for longest are removed.
const MOST_BYTES: u64 = 4 << 30;
/// Bytes of the checksum at the end of a file.
const SUM: usize = 8;

/// Keeps images of points through lenses from prescriptions on disk from now on: in the folder that `PHOTOSITE_CACHE`
/// names, nowhere where that is `off`, or else in the user's folder of caches. Programs call it as they start; a
/// library does not.
pub fn keep_on_disk() {
    if let Some(folder) = folder(|name| env::var_os(name)) {
        let lenses = folder.join("point-spreads");
        let shelf = move |key: &str| FolderShelf::new(&lenses, key).map(|shelf| Arc::new(shelf) as Arc<dyn Shelf>);
        keep_point_spreads(Box::new(shelf));
    }
}

/// The folder by what the environment says.
fn folder(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(own) = variable(VARIABLE).filter(|own| !own.is_empty()) {
        return (own != "off").then(|| own.into());
    }
    // Relative paths are to be left alone, says the XDG Base Directory Specification.
    let path = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let caches = if cfg!(windows) {
        path("LOCALAPPDATA")
    } else if cfg!(target_os = "macos") {
        path("HOME").map(|home| home.join("Library/Caches"))
    } else {
        path("XDG_CACHE_HOME").or_else(|| path("HOME").map(|home| home.join(".cache")))
    };
    caches.map(|caches| caches.join("photosite"))
}

/// A folder with a file for each node.
#[derive(Debug)]
struct FolderShelf {
    folder: PathBuf,
}

impl FolderShelf {
    /// The folder of a key among others; `None` where it cannot be made.
    fn new(among: &Path, key: &str) -> Option<Self> {
        let name: String = Sha256::digest(key.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
        let folder = among.join(name);
        fs::create_dir_all(&folder).ok()?;
        trim(among, &folder);
        Some(Self { folder })
    }

    fn path(&self, number: usize) -> PathBuf {
        self.folder.join(format!("{number:05}"))
    }
}

impl Shelf for FolderShelf {
    fn take(&self, number: usize) -> Option<Vec<u8>> {
        let mut bytes = fs::read(self.path(number)).ok()?;
        let (kept, sum) = bytes.split_last_chunk::<SUM>()?;
        if checksum(kept) != u64::from_le_bytes(*sum) {
            return None;
        }
        bytes.truncate(bytes.len() - SUM);
        Some(bytes)
    }

    fn keep(&self, number: usize, bytes: &[u8]) {
        static WRITTEN: AtomicU64 = AtomicU64::new(0);
        let ours = format!(".{}-{}", std::process::id(), WRITTEN.fetch_add(1, Ordering::Relaxed));
        let unfinished = self.folder.join(ours);
        let whole = [bytes, &checksum(bytes).to_le_bytes()].concat();
        let is_kept = fs::write(&unfinished, whole).is_ok() && fs::rename(&unfinished, self.path(number)).is_ok();
        if !is_kept {
            // Nothing is lost but time.
            let _ = fs::remove_file(&unfinished);
        }
    }
}

/// Checksum: the hash of Fowler, Noll and Vo over words of eight bytes, and the length.
fn checksum(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<8>();
    let last = rest.iter().fold(bytes.len() as u64, |sum, byte| (sum << 8) | u64::from(*byte));
    let words = words.iter().map(|word| u64::from_le_bytes(*word));
    words
        .chain([last])
        .fold(0xcbf2_9ce4_8422_2325, |sum, word| (sum ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(29))
}

/// Removes folders, the oldest first, until what is left is not too large; one that is in use stays.
fn trim(among: &Path, in_use: &Path) {
    let Ok(folders) = fs::read_dir(among) else { return };
    let size_and_time = |folder: &Path| {
        let files = fs::read_dir(folder).into_iter().flatten().flatten().filter_map(|file| file.metadata().ok());
        files.fold((0, SystemTime::UNIX_EPOCH), |(size, time), file| {
            (size + file.len(), time.max(file.modified().unwrap_or(time)))
        })
    };
    let mut all: Vec<(SystemTime, u64, PathBuf)> = folders
        .flatten()
        .map(|folder| folder.path())
        // Of ours alone, by their names.
        .filter(|folder| folder.file_name().is_some_and(|name| name.len() == 2 * size_of::<[u8; 32]>()))
        .map(|folder| (size_and_time(&folder), folder))
        .map(|((size, time), folder)| (time, size, folder))
        .collect();
    all.sort();
    let mut size: u64 = all.iter().map(|(_, size, _)| size).sum();
    for (_, of_folder, folder) in all.iter().filter(|(_, _, folder)| folder != in_use) {
        if size <= MOST_BYTES {
            return;
        }
        if fs::remove_dir_all(folder).is_ok() {
            size -= of_folder;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(variables: &[(&str, &str)]) -> Option<PathBuf> {
        folder(|name| variables.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into()))
    }

    #[test]
    fn a_folder_of_ones_own_goes_before_that_of_the_platform() {
        assert_eq!(found(&[(VARIABLE, "elsewhere"), ("HOME", "/home/me")]), Some("elsewhere".into()));
        assert_eq!(found(&[(VARIABLE, "off"), ("HOME", "/home/me"), ("LOCALAPPDATA", "C:\\me")]), None);
        assert_eq!(found(&[]), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn on_linux_it_is_that_of_the_desktop() {
        assert_eq!(found(&[("HOME", "/home/me")]), Some("/home/me/.cache/photosite".into()));
        assert_eq!(found(&[(VARIABLE, ""), ("HOME", "/home/me")]), Some("/home/me/.cache/photosite".into()));
        assert_eq!(found(&[("XDG_CACHE_HOME", "/c"), ("HOME", "/home/me")]), Some("/c/photosite".into()));
        assert_eq!(found(&[("XDG_CACHE_HOME", "c"), ("HOME", "/home/me")]), Some("/home/me/.cache/photosite".into()));
    }

    #[test]
    fn what_is_kept_comes_back_and_what_is_broken_does_not() {
        let among = tempfile::tempdir().expect("a folder");
        let shelf = FolderShelf::new(among.path(), "a lens").expect("a folder");
        let bytes: Vec<u8> = (0..1003).map(|i| (i * 7 % 251) as u8).collect();
        assert_eq!(shelf.take(3), None);
        shelf.keep(3, &bytes);
        shelf.keep(4, &[]);
        let again = FolderShelf::new(among.path(), "a lens").expect("a folder");
        assert_eq!((again.take(3), again.take(4)), (Some(bytes.clone()), Some(Vec::new())));
        assert_eq!(FolderShelf::new(among.path(), "another lens").expect("a folder").take(3), None);
        let whole = fs::read(shelf.path(3)).expect("a file");
        for (i, length) in [(0, 1011), (500, 1011), (1002, 1011), (1010, 1011), (0, 1010), (0, 5), (0, 0)] {
            let mut broken = whole.clone();
            broken[i] ^= u8::from(length == whole.len());
            broken.truncate(length);
            fs::write(shelf.path(3), broken).expect("writes");
            assert_eq!(shelf.take(3), None, "byte {i} of {length}");
        }
    }
}
