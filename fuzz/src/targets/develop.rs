//! DNG files that can be read are developed.

use std::io::Cursor;

use photosite::DevelopedImage;
use photosite::develop::DevelopSettings;
use photosite::raw::read_dng;

pub(crate) fn target(data: &[u8]) {
    // Large images take their time.
    if let Ok(raw) = read_dng(Cursor::new(data))
        && raw.data.len() <= 4096
    {
        let _ = DevelopedImage::develop(&raw, &DevelopSettings::default());
    }
}
