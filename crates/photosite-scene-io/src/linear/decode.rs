//! Decoding of linear light from files, recognised by their first bytes.

use std::io::Cursor;

use super::LinearImage;
use super::openexr::of_exr;
use super::radiance::{decode_radiance, is_radiance};
use crate::exr::read_exr;
use photosite_core::Invalid;

/// First bytes of an OpenEXR file.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// Linear light of an OpenEXR or Radiance HDR file; `None` of others.
pub(crate) fn decode_linear(bytes: &[u8]) -> Option<Result<LinearImage, Invalid>> {
    if bytes.starts_with(&EXR_MAGIC) {
        return Some(read_exr(Cursor::new(bytes)).and_then(of_exr));
    }
    is_radiance(bytes).then(|| decode_radiance(bytes))
}
