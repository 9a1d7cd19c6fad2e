//! Reading of regular files and of folders, in the [`sandbox`] if there is one, and of texts of a bounded size. All of
//! photosite opens files for reading here.
//!
//! Devices, pipes and sockets may have no end, or keep a reader waiting for ever.

use std::fs::{self, File, FileType, Metadata, ReadDir};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use crate::{memory, sandbox, text};

/// Largest size, in bytes, of a description that is parsed into a tree, such as a capture or a sensor: the tree of a
/// TOML file takes some seventy times as much memory.
pub const TREE_BYTES: u64 = 16 << 20;

/// Largest size, in bytes, of a table of numbers, or of a report, which has a line for each point of a target.
pub const TABLE_BYTES: u64 = 256 << 20;

/// Opens a regular file.
///
/// # Errors
///
/// A file that cannot be opened, is outside of the sandbox, or is a folder, a device, a pipe or a socket.
pub fn open(path: &Path) -> io::Result<File> {
    let path = sandbox::opened(path)?;
    // Before it is opened: that of a pipe waits for somebody who writes.
    let found = fs::metadata(&path)?;
    if let Some(kind) = other_kind(found.file_type()) {
        return Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {kind}, but a file is needed")));
    }
    File::open(path)
}

/// Opens a file for reading and changing; where it is to be new, it is created or emptied.
///
/// # Errors
///
/// A file that cannot be opened, or is outside of the sandbox.
pub fn open_to_change(path: &Path, is_new: bool) -> io::Result<File> {
    let path = sandbox::opened(path)?;
    File::options().read(true).write(true).create(is_new).truncate(is_new).open(path)
}

/// Metadata of a file or folder: its size, kind and times.
///
/// # Errors
///
/// A path that is not there, or outside of the sandbox.
pub fn metadata(path: &Path) -> io::Result<Metadata> {
    fs::metadata(sandbox::opened(path)?)
}

/// Entries of a folder.
///
/// # Errors
///
/// A folder that cannot be read, or is outside of the sandbox.
pub fn entries(folder: &Path) -> io::Result<ReadDir> {
    fs::read_dir(sandbox::opened(folder)?)
}

/// Reads a regular file as a whole.
///
/// # Errors
///
/// Errors of [`open`], and a file that cannot be read.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open(path)?;
    let mut bytes = Vec::new();
    // Memory that there is not is an error of this file alone.
    let length = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    memory::check(length as u64, "reading it", "")
        .map_err(|invalid| io::Error::new(ErrorKind::OutOfMemory, invalid))?;
    bytes
        .try_reserve_exact(length)
        .map_err(|_| io::Error::new(ErrorKind::OutOfMemory, format!("its {length} bytes do not fit into memory")))?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a regular file as a whole if it has at most `most` bytes.
///
/// # Errors
///
/// Errors of [`read`], and a file that is longer.
pub fn read_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let mut bytes = Vec::new();
    // It may grow while it is read.
    file.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it is larger than {} MiB, the limit for such files", most >> 20);
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// Reads a text file of at most `most` bytes, decoded by [`text::decode`].
///
/// # Errors
///
/// Errors of [`read_at_most`] and [`text::decode`].
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    text::decode(read_at_most(path, most)?)
}

/// Name of a kind of file that is not regular.
fn other_kind(kind: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_block_device() || kind.is_char_device() {
            return Some("a device");
        }
        if kind.is_fifo() {
            return Some("a pipe");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
    }
    kind.is_dir().then_some("a folder")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regular_files_are_read_up_to_their_limit() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("text");
        fs::write(&path, "one\ntwo").expect("written");
        assert_eq!(read(&path).expect("read"), b"one\ntwo");
        assert_eq!(read_text(&path, 7).expect("read"), "one\ntwo");
        assert_eq!(read_at_most(&path, 6).expect_err("too long").kind(), ErrorKind::FileTooLarge);
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_named_and_not_waited_for() {
        let folder = tempfile::tempdir().expect("a folder");
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).expect("a socket");
        for (path, kind) in [(Path::new("/dev/zero"), "a device"), (folder.path(), "a folder"), (&*socket, "a socket")]
        {
            for error in [read(path).expect_err(kind), read_text(path, 10).expect_err(kind)] {
                assert!(error.to_string().contains(kind), "{error}");
            }
        }
    }
}
