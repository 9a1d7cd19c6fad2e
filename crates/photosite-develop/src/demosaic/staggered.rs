//! Mosaics of hexagonal cells: each channel is a mean over its cells about a place, weighted by a cone of their distance
//! d,
//!
//! w = 1 − d/R
//!
//! with R one pitch more than the farthest that a cell of the mosaic has to the nearest of any channel (normalised
//! convolution, [Knutsson93](photosite_core::references#knutsson93)). At the edges the mean is over what lies in the
//! image.

use photosite_core::rows::for_each_row;

use super::channels::{planes, together};
use crate::neighbours::{Step, radius_for_all};
use photosite_core::cells::shift;
use photosite_core::image::Planes;
use photosite_raw::Cfa;

/// Planes of all channels; measured values stay. Rows are `row_distance` pitches apart.
pub(super) fn demosaic(mosaic: &[f32], size: [usize; 2], cfa: &Cfa, row_distance: f64) -> Planes {
    let [width, height] = size;
    let (columns, tile_rows) = cfa.tile_size();
    // Both the tile and the stagger come again.
    let rows = if tile_rows.is_multiple_of(2) { tile_rows } else { 2 * tile_rows };
    let mut channels = planes(width, height, cfa);
    for (c, channel) in channels.iter_mut().enumerate() {
        let near = |i: usize| neighbours(cfa, [i % columns, i / columns], c, row_distance);
        let near: Vec<Vec<(Step, f64)>> = (0..columns * rows).map(near).collect();
        let nearest = near.iter().filter_map(|steps| steps.first());
        let radius = 1.0 + nearest.map(|(_, distance)| *distance).fold(0.0, f64::max);
        for_each_row(&mut channel.data, width, |y, row| {
            for (x, value) in row.iter_mut().enumerate() {
                if cfa.channel_at(x, y) == c {
                    *value = mosaic[y * width + x];
                    continue;
                }
                let steps = near[y % rows * columns + x % columns].iter().take_while(|(_, d)| *d < radius);
                let inside = steps.filter_map(|&(step, d)| Some((step.from(x, y, size)?, 1.0 - d / radius)));
                let (sum, weights) = inside.fold((0.0, 0.0), |(sum, weights), ((x, y), weight)| {
                    (sum + weight * f64::from(mosaic[y * width + x]), weights + weight)
                });
                // An image smaller than a tile may lack a channel altogether.
                *value = if weights > 0.0 { (sum / weights) as f32 } else { mosaic[y * width + x] };
            }
        });
    }
    together(width, height, channels)
}

/// Steps from a place of the tile to cells of a channel and their distances in pitches, the nearest first.
fn neighbours(cfa: &Cfa, [x, y]: [usize; 2], channel: usize, row_distance: f64) -> Vec<(Step, f64)> {
    let (columns, rows) = cfa.tile_size();
    let reach = radius_for_all(cfa) as isize + 2;
    let at = |from: usize, step: isize, size: usize| (from as isize + step).rem_euclid(size as isize) as usize;
    let sees = |step: &Step| cfa.channel_at(at(x, step.dx, columns), at(y, step.dy, rows)) == channel;
    let all = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| Step { dx, dy }));
    let distance = |step: Step| {
        let across = step.dx as f64 + shift((y as isize + step.dy) as f64) - shift(y as f64);
        (step, across.hypot(step.dy as f64 * row_distance))
    };
    let mut steps: Vec<(Step, f64)> = all.filter(sees).map(distance).collect();
    steps.sort_by(|a, b| a.1.total_cmp(&b.1));
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::cells::REGULAR_ROWS;

    /// Cells of "RGB/BRG" have three neighbours of each other colour at a distance of a pitch, about the middle.
    #[test]
    fn slopes_come_out_of_hexagons_of_three_colours() {
        let (cfa, size) = (Cfa::parse("RGB/BRG").expect("a tile"), [30, 20]);
        let slope = |channel: usize, x: usize, y: usize| {
            0.2 * channel as f64 + 0.01 * (x as f64 + shift(y as f64)) + 0.02 * y as f64 * REGULAR_ROWS
        };
        let seen = |i: usize| slope(cfa.channel_at(i % 30, i / 30), i % 30, i / 30) as f32;
        let mosaic: Vec<f32> = (0..600).map(seen).collect();
        let planes = demosaic(&mosaic, size, &cfa, REGULAR_ROWS);
        for (channel, plane) in planes.channels().iter().enumerate() {
            for (i, value) in plane.data.iter().enumerate() {
                let (x, y) = (i % 30, i / 30);
                if (3..27).contains(&x) && (3..17).contains(&y) {
                    assert!((f64::from(*value) - slope(channel, x, y)).abs() < 1e-6, "{channel} {x} {y}: {value}");
                }
            }
        }
    }

    #[test]
    fn even_colours_stay_even_up_to_the_edges_of_any_size() {
        for text in ["RGB/BRG", "RGGB", "RGB/GBR/BRG", "R"] {
            let cfa = Cfa::parse(text).expect("a tile");
            for size in [[1, 1], [2, 9], [13, 7]] {
                let seen = |i: usize| 0.2 + 0.2 * cfa.channel_at(i % size[0], i / size[0]) as f32;
                let mosaic: Vec<f32> = (0..size[0] * size[1]).map(seen).collect();
                let planes = demosaic(&mosaic, size, &cfa, 1.0);
                if size[0] * size[1] > 50 {
                    for (channel, plane) in planes.channels().iter().enumerate() {
                        assert!(plane.data.iter().all(|v| (v - 0.2 - 0.2 * channel as f32).abs() < 1e-6), "{text}");
                    }
                }
            }
        }
    }
}
