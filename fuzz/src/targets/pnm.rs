//! PNM files of digital numbers.

use photosite::raw::read_pnm;

pub(crate) fn target(data: &[u8]) {
    if let Ok(raw) = read_pnm(data) {
        raw.validate().expect("whole");
    }
}
