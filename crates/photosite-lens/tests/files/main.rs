//! Readers of lens files: files that programs wrote against the figures that these programs give, the reference lenses
//! written in each format, the traps of each, and bad files.

mod bad;
mod deeplens;
mod formats;
mod real;
mod rims;
mod traps;

use std::path::Path;

use photosite_lens::files::{Reading, read};

/// Reads a text as a file of this name.
fn reading(name: &str, text: &str) -> Reading {
    read(text.as_bytes(), Path::new(name)).unwrap_or_else(|error| panic!("{name}: {error}\n{text}"))
}

/// The error of a text, with its help behind it.
fn error(name: &str, text: &str) -> String {
    let error = match read(text.as_bytes(), Path::new(name)) {
        Ok(reading) => panic!("{name} was read: {:?}\n{text}", reading.prescription),
        Err(error) => error,
    };
    let help = miette::Diagnostic::help(&error).map(|help| help.to_string()).unwrap_or_default();
    format!("{error} | {help}")
}

/// A lens of `tests/reference`.
fn reference(name: &str) -> Reading {
    let path = format!("{}/tests/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let bytes = std::fs::read(&path).expect("committed");
    read(&bytes, Path::new(&path)).unwrap_or_else(|error| panic!("{error}"))
}
