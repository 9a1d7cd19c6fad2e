//! Any raw file: read as what it begins with, written as its name ends.

use std::io::{BufReader, Read, Seek};
use std::path::Path;

use super::dng::is_dng;
use super::{RawImage, read_dng, read_npy, read_pnm, read_tiff, write_dng, write_npy, write_pgm, write_tiff};
use photosite_core::input;
use photosite_core::output::write_whole;
use photosite_core::{Error, Invalid, Result};

/// Reads a DNG, TIFF, PBM, PGM, PPM or NPY file. Only DNG says more than the numbers: of the others, grey ones are
/// taken for those of a monochrome sensor.
pub fn read(path: &Path) -> Result<RawImage> {
    let file = input::open(path).map_err(|source| Error::io(path, "read", source))?;
    let mut raw = read_any(BufReader::new(file)).map_err(|invalid| invalid.in_file(path))?;
    for what in &mut raw.metadata.left_out {
        *what = format!("{}: {what}", path.display());
    }
    Ok(raw)
}

impl RawImage {
    /// Writes it in the format that the extension asks for: .dng, which holds all that is known of it, or .tiff, .pgm
    /// or .npy, which hold its numbers. The file appears whole or not at all; an older one is replaced.
    ///
    /// # Errors
    ///
    /// Another extension, an image that the format cannot hold, a folder that is not there.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let extension = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        match extension.as_str() {
            "dng" => write_whole(path, |to| write_dng(self, to)),
            "tif" | "tiff" => write_whole(path, |to| write_tiff(self, to)),
            "pgm" => write_whole(path, |to| write_pgm(self, to)),
            "npy" => write_whole(path, |to| write_npy(self, to)),
            _ => {
                let message = format!("{extension:?} is not a kind of raw file that can be written");
                Err(Invalid::new("", message).help("end the name in .dng, .tiff, .pgm or .npy").in_file(path))
            }
        }
    }
}

fn read_any<R: Read + Seek>(mut from: BufReader<R>) -> std::result::Result<RawImage, Invalid> {
    let io = |error: std::io::Error| Invalid::new("", format!("cannot read it: {error}"));
    let mut magic = Vec::new();
    from.by_ref().take(4).read_to_end(&mut magic).map_err(io)?;
    from.rewind().map_err(io)?;
    match &magic[..] {
        b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+" => {
            let is_dng = is_dng(&mut from);
            from.rewind().map_err(io)?;
            if is_dng { read_dng(from) } else { read_tiff(from) }
        }
        [b'P', b'1'..=b'6', ..] => read_pnm(from),
        b"\x93NUM" => read_npy(from),
        _ => Err(Invalid::new("", "is not a raw file of a kind that photosite knows")
            .help("give a DNG, TIFF, PBM, PGM, PPM or NPY file, or a raw.exr that photosite wrote")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use rand::RngExt;

    use super::*;
    use crate::raw::{Cfa, write_dng, write_npy, write_pgm, write_tiff};
    use photosite_core::math::philox::Philox;

    #[test]
    fn mutated_files_are_errors_or_pictures_no_larger_than_their_bytes_can_hold() {
        let mut random = Philox::new(7, 0);
        for cfa in ["mono", "full:RGB", "RGGB"] {
            let cfa = Cfa::parse(cfa).expect("known");
            let data = (0..12 * cfa.samples_per_pixel() as u16).map(|i| i.wrapping_mul(3_000)).collect();
            let raw = RawImage { width: 4, height: 3, data, cfa, ..RawImage::default() };
            let [mut dng, mut tiff, mut pgm, mut npy] = [const { Vec::new() }; 4];
            write_dng(&raw, Cursor::new(&mut dng)).expect("written");
            write_tiff(&raw, Cursor::new(&mut tiff)).expect("written");
            write_pgm(&raw, &mut pgm).expect("written");
            write_npy(&raw, &mut npy).expect("written");
            let text = [&b"P2\n4 3 60000\n"[..], &b"3000 7 ".repeat(6)].concat();
            let bits = b"P1\n4 3\n010011000111".to_vec();
            let kinds = [("DNG", dng), ("TIFF", tiff), ("PGM", pgm), ("NPY", npy), ("text", text), ("bits", bits)];
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
                    if let Ok(read) = read_any(BufReader::new(Cursor::new(&file))) {
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
            let [mut dng, mut tiff, mut pgm, mut npy] = [const { Vec::new() }; 4];
            write_dng(&raw, Cursor::new(&mut dng)).expect("written");
            write_tiff(&raw, Cursor::new(&mut tiff)).expect("written");
            write_pgm(&raw, &mut pgm).expect("written");
            write_npy(&raw, &mut npy).expect("written");
            for file in [dng, tiff, pgm, npy] {
                assert_eq!(read_any(BufReader::new(Cursor::new(&file))), Ok(raw.clone()));
                for length in 0..file.len() {
                    // Behind what TIFF files need, there may be a directory's end that nobody reads.
                    let _ = read_any(BufReader::new(Cursor::new(&file[..length])));
                }
            }
        }
        for other in [&b""[..], b"P", b"II", b"\x89PNG"] {
            assert!(read_any(BufReader::new(Cursor::new(other))).expect_err("not a raw file").help.is_some());
        }
    }
}
