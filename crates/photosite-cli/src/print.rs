//! Output of commands on standard output, and files that are written for a command alone.

use std::path::Path;

use photosite_core::shorten::shorten_lines;

use photosite_core::Error;
pub(super) use photosite_core::math::float::rounded;
use photosite_core::output::{Sink, write_new, write_whole};
use photosite_files::pretty_json::pretty_json;

/// Refuses to overwrite a file without `force`.
pub(super) fn refuse_existing(path: &Path, force: bool) -> photosite_core::Result<()> {
    if force || !path.exists() { Ok(()) } else { Err(exists_already(path)) }
}

pub(super) fn exists_already(path: &Path) -> Error {
    let message = format!("{} already exists", path.display());
    Error::Usage { message, help: Some("add --force to overwrite it, or choose another name".into()) }
}

/// Writes a file whole. A file that another process has put there in the meantime is not overwritten without `force`,
/// either.
pub(super) fn write_result(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>,
) -> photosite_core::Result<()> {
    if force {
        write_whole(path, write)
    } else if write_new(path, write)? {
        Ok(())
    } else {
        Err(exists_already(path))
    }
}

/// Prints an object as JSON on standard output.
pub(super) fn print_json(value: &impl serde::Serialize) -> photosite_core::Result<()> {
    println_out(&pretty_json(value))
}

/// Prints a line on standard output. A reader that has gone away, as `head` does, is no error.
pub(super) fn println_out(text: &str) -> photosite_core::Result<()> {
    print_out(format!("{text}\n").as_bytes())
}

/// Prints text for people; words from files are shortened as in messages.
pub(super) fn println_text(text: &str) -> photosite_core::Result<()> {
    println_out(&shorten_lines(text))
}

/// Prints bytes on standard output. A reader that has gone away is no error.
pub(super) fn print_out(bytes: &[u8]) -> photosite_core::Result<()> {
    use std::io::{ErrorKind, Write};
    match std::io::stdout().lock().write_all(bytes) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io("standard output".as_ref(), "write", error))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
