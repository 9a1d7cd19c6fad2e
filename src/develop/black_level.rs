//! Black level: digital numbers become a signal of 0 for no light and 1 for saturation.

use rayon::prelude::*;

use crate::raw::RawImage;

/// x = (DN − black)/(white − black) for every pixel. Noise below black stays negative.
pub(super) fn subtract(raw: &RawImage) -> Vec<f32> {
    let black = f32::from(raw.black_level_dn);
    let range = (f32::from(raw.white_level_dn) - black).max(1.0);
    raw.data.par_iter().map(|&dn| (f32::from(dn) - black) / range).collect()
}
