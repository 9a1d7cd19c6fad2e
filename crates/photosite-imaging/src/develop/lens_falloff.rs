//! Lens falloff: brightens each pixel by what the lens darkens it.

use rayon::prelude::*;

use crate::raw::{GainMap, RawImage};

/// Multiplies the signal by the gains of the raw file's maps. A saturated pixel stays at the edge of saturation times
/// its gain, above 1, so that highlights are clipped alike over the picture.
pub(super) fn correct(signal: &mut [f32], raw: &RawImage) {
    for map in &raw.metadata.gain_maps {
        apply(signal, map, raw);
    }
}

fn apply(signal: &mut [f32], map: &GainMap, raw: &RawImage) {
    let samples = raw.cfa.samples_per_pixel();
    let rows = signal.par_chunks_mut(raw.row_length().max(1)).enumerate().filter(|(y, _)| map.has_row(*y));
    rows.for_each(|(y, row)| {
        for (i, value) in row.iter_mut().enumerate() {
            let (x, plane) = (i / samples, i % samples);
            if map.has_number(x, plane) {
                *value *= gain(map, [x, y], plane, raw);
            }
        }
    });
}

fn gain(map: &GainMap, [x, y]: [usize; 2], plane: usize, raw: &RawImage) -> f32 {
    map.at_plane((x as f64 + 0.5) / raw.width as f64, (y as f64 + 0.5) / raw.height as f64, plane)
}
