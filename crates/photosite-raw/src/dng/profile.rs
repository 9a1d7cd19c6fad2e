//! Camera profiles (DCP files): colour tags of a DNG file by themselves, in a TIFF file of another magic number (DNG 1.6
//! specification, chapter 6).

use std::io::{Read, Seek};

use super::colour;
use crate::openable::{ReadSeek, open};
use crate::tags::{Tags, unreadable};
use crate::{ColourCalibration, RawMetadata};
use photosite_core::Invalid;

/// Reads the colour calibrations of a camera profile, or of a DNG file.
///
/// # Errors
///
/// A file of another kind, or one without a colour matrix.
pub fn read_profile<R: Read + Seek>(mut from: R) -> Result<Vec<ColourCalibration>, Invalid> {
    read(&mut from)
}

fn read(from: &mut dyn ReadSeek) -> Result<Vec<ColourCalibration>, Invalid> {
    let (decoder, pointer) = open(from).map_err(unreadable)?;
    let mut file = Tags { decoder };
    let main = file.decoder.read_directory(pointer).map_err(unreadable)?;
    let mut metadata = RawMetadata::default();
    colour::read(&mut file, &main, &mut metadata)?;
    if metadata.calibrations.is_empty() {
        return Err(Invalid::new("ColorMatrix1", "is missing").help("give a camera profile (.dcp) or a DNG file"));
    }
    Ok(metadata.calibrations)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::{LightSource, RawImage, write_dng};

    #[test]
    fn a_profile_has_the_matrices_of_a_file() {
        let calibration = |light, first| ColourCalibration {
            light,
            colour_matrix: vec![[first, -0.25, 0.125], [-0.5, 1.5, 0.0], [0.0, 0.25, 0.5]],
            forward_matrix: None,
        };
        let calibrations = vec![calibration(LightSource::D65, 0.75), calibration(LightSource::A, 1.0)];
        let metadata = RawMetadata { calibrations: calibrations.clone(), ..RawMetadata::default() };
        let cfa = crate::Cfa::parse("RGGB").expect("a layout");
        let raw = RawImage { metadata, ..RawImage::bare(2, 2, vec![1, 2, 3, 4], cfa, 255) };
        let mut file = Cursor::new(Vec::new());
        write_dng(&raw, &mut file).expect("written");
        assert_eq!(read_profile(&mut file).expect("a DNG file"), calibrations);
        // Another magic number makes a profile of it.
        let mut bytes = file.into_inner();
        let magic = if bytes.starts_with(b"II") { *b"RC" } else { *b"CR" };
        bytes[2..4].copy_from_slice(&magic);
        assert_eq!(read_profile(Cursor::new(&bytes)).expect("a profile"), calibrations);
        assert!(read_profile(Cursor::new(&bytes[..20])).is_err());
        // The order of bytes of another machine.
        let mut big = b"MMCR\0\0\0\x08\0\x01".to_vec();
        // ColorMatrix1: nine signed rationals at 26, and no further directory.
        big.extend([0xc6, 0x21, 0, 10, 0, 0, 0, 9, 0, 0, 0, 26, 0, 0, 0, 0]);
        (1..10_i32).for_each(|i| big.extend([i.to_be_bytes(), 2_i32.to_be_bytes()].concat()));
        let found = read_profile(Cursor::new(big)).expect("a profile");
        assert_eq!(found[0].colour_matrix, [[0.5, 1.0, 1.5], [2.0, 2.5, 3.0], [3.5, 4.0, 4.5]]);
        let bare = RawImage::bare(1, 1, vec![1], crate::Cfa::mono(), 255);
        let mut file = Cursor::new(Vec::new());
        write_dng(&bare, &mut file).expect("written");
        assert_eq!(read_profile(&mut file).expect_err("no colours").key, "ColorMatrix1");
    }
}
