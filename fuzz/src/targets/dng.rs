//! DNG files of digital numbers.

use std::io::Cursor;

use photosite::raw::read_dng;

pub(crate) fn target(data: &[u8]) {
    if let Ok(raw) = read_dng(Cursor::new(data)) {
        raw.validate().expect("whole");
    }
}
