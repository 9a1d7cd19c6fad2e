//! Raw files of any format: read as what they begin with, written as their names end.

use std::io::{BufReader, Read};
use std::path::Path;

use super::formats::{
    EXR, Format, Holds, MAGIC, Source,
    lists::{endings, names},
};
use photosite_core::input;
use photosite_core::output::write_whole;
use photosite_core::{Error, Invalid, Result};
use photosite_raw::{DngCompression, RawImage};

/// Reads a file of digital numbers, recognised by what it begins with. Only DNG and EXR files say more than the pixel
/// values: of the others, grey ones are taken for those of a monochrome sensor.
pub fn read_raw(path: &Path) -> Result<RawImage> {
    let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
    let mut raw = read_any(&mut BufReader::new(file)).map_err(|invalid| invalid.in_file(path))?;
    for what in &mut raw.metadata.left_out {
        *what = format!("{}: {what}", path.display());
    }
    Ok(raw)
}

/// Reads digital numbers of any format.
pub(super) fn read_any(from: &mut dyn Source) -> Result<RawImage, Invalid> {
    let io = |error: std::io::Error| Invalid::new("", format!("cannot read it: {error}"));
    let mut magic = Vec::new();
    from.take(MAGIC).read_to_end(&mut magic).map_err(io)?;
    from.rewind().map_err(io)?;
    let Some(read) = Format::of_magic(&magic).and_then(|format| format.raw_reader) else {
        let help = format!("give a {} file, or a raw.exr that photosite wrote", silent_formats());
        return Err(Invalid::new("", "is not a raw file of a kind that photosite knows").help(help));
    };
    read(from)
}

/// Names of the formats of raw files that any program may have written.
pub(super) fn silent_formats() -> String {
    names(|format| format.raw_reader.is_some() && *format != EXR)
}

/// Writes a raw image in the format of the extension: .dng, which holds all that is known of it, or another that holds
/// its pixel values. The file appears whole or not at all; an older one is replaced.
///
/// # Errors
///
/// Another extension, an image that the format cannot hold, a folder that is not there.
pub fn save_raw(raw: &RawImage, path: impl AsRef<Path>) -> Result<()> {
    let path = path.as_ref();
    let Some(format) = Format::of(path).filter(|format| format.writes_raw()) else {
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let message = format!("{extension:?} is not a kind of raw file that can be written");
        let help = format!("end the name in {}", endings(Format::writes_raw));
        return Err(Invalid::new("", message).help(help).in_file(path));
    };
    write_whole(path, |to| format.write_raw(raw, DngCompression::None, to))
}

/// Whether the name of a file says that it states the mosaic of a sensor, as DNG files do.
pub fn is_mosaic(path: &Path) -> bool {
    Format::of(path).is_some_and(|format| format.holds == Holds::Raw)
}

/// Refuses a raw file whose rows are staggered, as those of hexagonal cells are, for commands that count in columns.
pub fn refuse_staggered_rows(path: &Path) -> Result<()> {
    if !(is_mosaic(path) && read_raw(path)?.metadata.is_staggered) {
        return Ok(());
    }
    let invalid = Invalid::new("", "has the staggered rows of hexagonal cells, and an edge is followed in columns");
    Err(invalid.help("measure image.png, or what photosite develop makes of it").in_file(path))
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use rand::RngExt;

    use super::*;
    use crate::formats::FORMATS;
    use photosite_core::math::philox::Philox;
    use photosite_raw::Cfa;

    /// The image in every format but EXR, whose mutations take their time.
    fn written(raw: &RawImage) -> Vec<(&'static str, Vec<u8>)> {
        let formats = FORMATS.into_iter().filter(|format| format.writes_raw() && *format != &EXR);
        let file = |format: &'static Format| {
            let mut file = Cursor::new(Vec::new());
            format.write_raw(raw, DngCompression::None, &mut file).expect("written");
            (format.name, file.into_inner())
        };
        formats.map(file).collect()
    }

    #[test]
    fn mutated_files_are_errors_or_images_no_larger_than_their_bytes_can_hold() {
        let mut random = Philox::new(7, 0);
        for cfa in ["mono", "full:RGB", "RGGB"] {
            let cfa = Cfa::parse(cfa).expect("known");
            let data = (0..12 * cfa.samples_per_pixel() as u16).map(|i| i.wrapping_mul(3_000)).collect();
            let raw = RawImage { width: 4, height: 3, data, cfa, ..RawImage::default() };
            let mut kinds = written(&raw);
            let text = [&b"P2\n4 3 60000\n"[..], &b"3000 7 ".repeat(6)].concat();
            let bits = b"P1\n4 3\n010011000111".to_vec();
            kinds.extend([("text", text), ("bits", bits)]);
            for (kind, file) in kinds {
                for _ in 0..3000 {
                    let mut file = file.clone();
                    for _ in 0..random.random_range(1..6) {
                        let at = random.random_range(0..file.len());
                        match random.random_range(0..5) {
                            0 => file[at] = random.random(),
                            1 => file[at] ^= 1 << random.random_range(0..8),
                            2 => file[at] = [0, 0xff, 0x7f, b'9'][random.random_range(0..4)],
                            3 => drop(file.remove(at)),
                            _ => file.insert(at, random.random()),
                        }
                    }
                    if let Ok(read) = read_any(&mut Cursor::new(&file)) {
                        read.validate().expect("whole");
                        assert!(read.data.len() <= 1032 * file.len(), "{kind}: {} numbers", read.data.len());
                    }
                }
            }
        }
    }

    #[test]
    fn files_are_known_by_what_they_begin_with() {
        for cfa in ["mono", "full:RGB"] {
            let cfa = Cfa::parse(cfa).expect("known");
            let data = (0..6 * cfa.samples_per_pixel() as u16).map(|i| i * 3_000).collect();
            let raw = RawImage { width: 3, height: 2, data, cfa, ..RawImage::default() };
            for (_, file) in written(&raw) {
                assert_eq!(read_any(&mut Cursor::new(&file)), Ok(raw.clone()));
                for length in 0..file.len() {
                    // Behind what TIFF files need, there may be a directory's end that nobody reads.
                    let _ = read_any(&mut Cursor::new(&file[..length]));
                }
            }
        }
        for other in [&b""[..], b"P", b"II", b"\x89PNG"] {
            assert!(read_any(&mut Cursor::new(other)).expect_err("not a raw file").help.is_some());
        }
    }
}
