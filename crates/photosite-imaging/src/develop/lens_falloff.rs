//! Lens falloff: brightens each pixel by what the lens darkens it.

use rayon::prelude::*;

use crate::raw::{GainMap, RawImage};

/// Multiplies the signal by the gains of the raw file's map. A saturated pixel stays at the edge of saturation times
/// its gain, above 1, so that highlights are clipped alike over the picture.
pub(super) fn correct(signal: &mut [f32], raw: &RawImage) {
    let Some(map) = &raw.metadata.gain_map else { return };
    let samples = raw.cfa.samples_per_pixel();
    signal.par_chunks_mut(raw.row_length().max(1)).enumerate().for_each(|(y, row)| {
        for (i, value) in row.iter_mut().enumerate() {
            *value *= gain(map, i / samples, y, raw);
        }
    });
}

fn gain(map: &GainMap, x: usize, y: usize, raw: &RawImage) -> f32 {
    map.at((x as f64 + 0.5) / raw.width as f64, (y as f64 + 0.5) / raw.height as f64)
}
