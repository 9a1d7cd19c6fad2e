//! TIFF files of digital numbers.

use std::io::Cursor;

use photosite::raw::read_tiff;

pub(crate) fn target(data: &[u8]) {
    if let Ok(raw) = read_tiff(Cursor::new(data)) {
        raw.validate().expect("whole");
    }
}
