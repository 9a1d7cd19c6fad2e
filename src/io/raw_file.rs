//! Any raw file, those that [`raw`] reads and writes and EXR files.

use std::io::{BufReader, Read, Seek};
use std::path::Path;

use super::output::write_whole;
use super::raw_exr::{read_raw_exr, write_raw_exr};
use crate::raw::{self, RawImage};
use crate::{Error, Invalid, Result};
use photosite_core::input;

/// What EXR files begin with.
const EXR: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Reads a DNG, TIFF, PBM, PGM, PPM, NPY or EXR file of digital numbers, recognised by what it begins with.
pub fn read_raw(path: &Path) -> Result<RawImage> {
    let unreadable = |reason| Error::io(path, "read", reason);
    let mut file = BufReader::new(input::open(path).map_err(unreadable)?);
    let mut magic = Vec::new();
    file.by_ref().take(EXR.len() as u64).read_to_end(&mut magic).map_err(unreadable)?;
    if magic != EXR {
        return raw::read(path);
    }
    file.rewind().map_err(unreadable)?;
    read_raw_exr(file).map_err(|invalid| invalid.in_file(path))
}

/// Writes a raw image in the format that the extension asks for: .exr, or one of [`RawImage::save`]. The file appears
/// whole or not at all; an older one is replaced.
pub fn save_raw(raw: &RawImage, path: &Path) -> Result<()> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr")) {
        return write_whole(path, |to| write_raw_exr(raw, to));
    }
    raw.save(path)
}

/// Refuses a raw file whose rows are staggered, as those of hexagonal cells are, for what counts in columns.
pub fn refuse_staggered_rows(path: &Path) -> Result<()> {
    let is_dng = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("dng"));
    if !(is_dng && raw::read(path)?.metadata.is_staggered) {
        return Ok(());
    }
    let invalid = Invalid::new("", "has the staggered rows of hexagonal cells, and an edge is followed in columns");
    Err(invalid.help("measure image.png, or what photosite develop makes of it").in_file(path))
}
