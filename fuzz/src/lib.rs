//! What the fuzz targets share: files that inputs may name, a folder to write to, and captures made of bytes.

mod captures;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

pub use captures::{Captures, render};

/// Small files that inputs may name: geometry, spectra, images.
pub fn files() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/files"))
}

/// A copy of [`files`] that a target may write to. `fuzz/run` puts it into memory, and removes it.
pub fn folder() -> &'static Path {
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
pub fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    fs::create_dir_all(path.parent().unwrap_or(folder())).expect("a folder");
    fs::write(&path, bytes).expect("written");
    path
}
