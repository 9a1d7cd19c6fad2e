//! The nearest pixel of each channel, for any filter array.

use photosite_core::rows::for_each_row;

use super::channels::{planes, together};
use crate::neighbours::{Step, radius_for_all, steps};
use photosite_core::image::Planes;
use photosite_raw::Cfa;

/// Takes every channel from its nearest pixel that lies in the image; of equally near ones the upper, then the left.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let (columns, rows) = cfa.tile_size();
    // Twice the radius: at an edge the nearest may lie inwards.
    let radius = 2 * radius_for_all(cfa);
    let mut channels = planes(width, height, cfa);
    for (c, channel) in channels.iter_mut().enumerate() {
        let near: Vec<Vec<Step>> =
            (0..columns * rows).map(|i| steps(cfa, [i % columns, i / columns], c, radius)).collect();
        for_each_row(&mut channel.data, width, |y, row| {
            for (x, value) in row.iter_mut().enumerate() {
                let place = y % rows * columns + x % columns;
                let from = near[place].iter().find_map(|step| step.from(x, y, [width, height]));
                // An image smaller than a tile may lack a channel altogether.
                let (x, y) = from.unwrap_or((x, y));
                *value = mosaic[y * width + x];
            }
        });
    }
    together(width, height, channels)
}
