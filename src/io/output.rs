//! Writing files so that each appears whole or not at all.

use std::fs;
use std::io::{BufWriter, Seek, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use crate::{Error, Invalid, Result};

/// A file being written, as encoders see it.
pub trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Writes `path` through a temporary file beside it, renamed into place once `write` has succeeded. On failure nothing
/// is left behind and an older file of that name stays as it was.
pub fn write_whole(path: &Path, write: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>) -> Result<()> {
    let failed = |reason| Error::io(path, "write", reason);
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        let help = "make it first, or choose another name";
        return Err(Invalid::new("", "is no folder to write to").help(help).in_file(folder));
    }
    // The reason names the temporary file, which nobody knows.
    let temporary = NamedTempFile::new_in(folder).map_err(|reason| failed(reason.kind().into()))?;
    let mut buffered = BufWriter::new(temporary);
    write(&mut buffered).map_err(failed)?;
    let temporary = buffered.into_inner().map_err(|e| failed(e.into_error()))?;
    #[cfg(unix)]
    {
        // Temporary files are private; a picture is not.
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(temporary.path(), fs::Permissions::from_mode(0o644)).map_err(failed)?;
    }
    temporary.persist(path).map_err(|e| failed(e.error))?;
    Ok(())
}

/// Creates a folder and its parents.
pub fn create_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|reason| Error::io(path, "create the folder", reason))
}

/// Removes what an earlier attempt left of a folder, if it left any.
pub fn remove_unfinished(path: &Path) -> Result<()> {
    if path.exists() {
        fs::remove_dir_all(path).map_err(|reason| Error::io(path, "remove the unfinished folder", reason))?;
    }
    Ok(())
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
}
