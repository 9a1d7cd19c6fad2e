//! Size and SHA-256 of a file, by which damage shows that a file's name does not.

use std::collections::BTreeMap;
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use photosite_core::input;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use photosite_core::{Error, Invalid, Result};

/// Bytes read at a time.
const BUFFER_BYTES: usize = 1 << 16;

/// Size and SHA-256 of a file.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
pub struct FileSum {
    /// Size, bytes.
    pub bytes: u64,
    /// SHA-256 (FIPS 180-4), 64 hexadecimal digits.
    pub sha256: String,
}

impl FileSum {
    /// Checksum and size of the file at `path`, which is read once.
    pub fn of(path: &Path) -> io::Result<Self> {
        let mut file = input::open(path)?;
        let (mut sum, mut bytes) = (Sha256::new(), 0);
        let mut buffer = vec![0; BUFFER_BYTES];
        loop {
            match file.read(&mut buffer) {
                Ok(0) => return Ok(Self { bytes, sha256: hex(&sum.finalize()) }),
                Ok(count) => {
                    sum.update(&buffer[..count]);
                    bytes += count as u64;
                }
                Err(reason) if reason.kind() == ErrorKind::Interrupted => {}
                Err(reason) => return Err(reason),
            }
        }
    }
}

/// Checksums of files that results are made of. Each file is read once and must not change from then on, since later
/// results are recorded as made of it, too.
#[derive(Debug, Default)]
pub struct KnownSums(Mutex<BTreeMap<PathBuf, (FileSum, Option<SystemTime>)>>);

impl KnownSums {
    /// Whether the checksum of a file was asked for before.
    pub fn has(&self, path: &Path) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).contains_key(path)
    }

    /// Checksum and size of a file.
    ///
    /// # Errors
    ///
    /// One that cannot be read, and one that has changed since it was read first.
    pub fn of(&self, path: &Path) -> Result<FileSum> {
        // One that was there before may come back.
        let is_known = self.has(path);
        let unreadable = |reason| {
            let error = Error::io(path, "read", reason);
            if is_known { error.since_begun() } else { error }
        };
        let metadata = input::metadata(path).map_err(unreadable)?;
        let modified = metadata.modified().ok();
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((sum, then)) = known.get(path)
            && (sum.bytes, *then) == (metadata.len(), modified)
        {
            return Ok(sum.clone());
        }
        let sum = FileSum::of(path).map_err(unreadable)?;
        match known.insert(path.to_owned(), (sum.clone(), modified)) {
            Some((earlier, _)) if earlier != sum => {
                let invalid = Invalid::new("", "has changed while images were made of it");
                Err(invalid.help("restore it as it was, or start again in another folder").in_file(path))
            }
            Some(_) | None => Ok(sum),
        }
    }
}

/// Bytes as text of two hexadecimal digits each.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_that_of_the_standard() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").expect("written");
        // FIPS 180-4's example of one block
        let sha256 = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad".to_owned();
        assert_eq!(FileSum::of(&path).expect("read"), FileSum { bytes: 3, sha256 });
    }
}
