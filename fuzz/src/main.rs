//! Fuzz targets in one program; `FUZZ_TARGET` chooses one of them. They share files that inputs may name, a folder to write
//! to, and captures made of bytes.
#![no_main]

mod captures;
mod targets;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

pub(crate) use captures::{Captures, render};
use libfuzzer_sys::fuzz_target;
use targets::{TARGETS, Target};

fuzz_target!(|data: &[u8]| chosen()(data));

/// Target that `FUZZ_TARGET` names.
fn chosen() -> Target {
    static CHOSEN: OnceLock<Target> = OnceLock::new();
    *CHOSEN.get_or_init(|| {
        let asked = std::env::var("FUZZ_TARGET").unwrap_or_default();
        let found = TARGETS.iter().find(|(name, _)| *name == asked);
        let names: Vec<_> = TARGETS.iter().map(|(name, _)| *name).collect();
        found.unwrap_or_else(|| panic!("FUZZ_TARGET is {asked:?}; there are {}", names.join(", "))).1
    })
}

/// Small files that inputs may name: geometry, spectra, images.
pub(crate) fn files() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/files"))
}

/// A copy of [`files`] that a target may write to. `fuzz/run` puts it into memory, and removes it.
pub(crate) fn folder() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("photosite-fuzz-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a writable temporary folder");
        for entry in fs::read_dir(files()).expect("the folder of files") {
            let path = entry.expect("an entry").path();
            fs::copy(&path, folder.join(path.file_name().expect("a name"))).expect("copied");
        }
        folder
    })
}

/// Writes a file into [`folder`], for readers that want its path.
pub(crate) fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    fs::create_dir_all(path.parent().unwrap_or(folder())).expect("a folder");
    fs::write(&path, bytes).expect("written");
    path
}
