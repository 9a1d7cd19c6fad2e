//! What commands print on standard output, and files that are written for a command alone.

use std::path::Path;

use photosite_core::shorten::shorten_lines;

use crate::Error;
use crate::io::output::{Sink, write_new, write_whole};
use crate::io::pretty_json::pretty_json;
pub(super) use crate::math::float::rounded;

/// Refuses to overwrite a file unasked.
pub(super) fn refuse_existing(path: &Path, force: bool) -> crate::Result<()> {
    if force || !path.exists() { Ok(()) } else { Err(exists_already(path)) }
}

pub(super) fn exists_already(path: &Path) -> Error {
    let message = format!("{} already exists", path.display());
    Error::Usage { message, help: Some("add --force to overwrite it, or choose another name".into()) }
}

/// Writes a file whole. One that another process has put there in the meantime is not overwritten unasked, either.
pub(super) fn write_result(
    path: &Path,
    force: bool,
    write: impl FnOnce(&mut dyn Sink) -> std::io::Result<()>,
) -> crate::Result<()> {
    if force {
        write_whole(path, write)
    } else if write_new(path, write)? {
        Ok(())
    } else {
        Err(exists_already(path))
    }
}

/// Prints an object as JSON on standard output.
pub(super) fn print_json(value: &impl serde::Serialize) -> crate::Result<()> {
    println_out(&pretty_json(value))
}

/// Prints a line on standard output. A reader that has seen enough and went away, as `head` does, is no error.
pub(super) fn println_out(text: &str) -> crate::Result<()> {
    print_out(format!("{text}\n").as_bytes())
}

/// Prints a text for people, in which words that files hold are cut as in messages.
pub(super) fn println_text(text: &str) -> crate::Result<()> {
    println_out(&shorten_lines(text))
}

/// Prints bytes on standard output, likewise.
pub(super) fn print_out(bytes: &[u8]) -> crate::Result<()> {
    use std::io::{ErrorKind, Write};
    match std::io::stdout().lock().write_all(bytes) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io("standard output".as_ref(), "write", error))
        }
        Ok(()) | Err(_) => Ok(()),
    }
}
