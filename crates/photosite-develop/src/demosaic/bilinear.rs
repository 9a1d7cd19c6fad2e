//! Linear interpolation between the nearest pixels of a channel, for any filter array.
//!
//! The value is a mean weighted by a tent, (r + 1 − |Δx|)·(r + 1 − |Δy|) within the smallest radius r at which every
//! pixel has a neighbour of every channel (normalised convolution,
//! [Knutsson93](photosite_core::references#knutsson93)). For Bayer mosaics r = 1, and that is bilinear interpolation.
//! At the edges the mean is over what lies in the image.

use photosite_core::rows::for_each_row;

use super::channels::{planes, together};
use crate::neighbours::{Step, radius_for_all, steps};
use photosite_core::image::Planes;
use photosite_raw::Cfa;

/// Planes of all channels; measured values stay.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let radius = radius_for_all(cfa);
    let mut channels = planes(width, height, cfa);
    for (c, channel) in channels.iter_mut().enumerate() {
        Tent::new(cfa, c, radius).fill(&mut channel.data, [width, height], true, |i| mosaic[i]);
    }
    together(width, height, channels)
}

/// Neighbours of one channel with their weights, for each place of the tile.
pub(crate) struct Tent {
    columns: usize,
    rows: usize,
    radius: usize,
    taps: Vec<Vec<(Step, f32)>>,
}

impl Tent {
    pub(crate) fn new(cfa: &Cfa, channel: usize, radius: usize) -> Self {
        let (columns, rows) = cfa.tile_size();
        let weight = |step: Step| {
            let along = |d: isize| radius as f32 + 1.0 - d.unsigned_abs() as f32;
            (step, along(step.dx) * along(step.dy))
        };
        let taps = |i: usize| steps(cfa, [i % columns, i / columns], channel, radius).into_iter().map(weight).collect();
        Self { columns, rows, radius, taps: (0..columns * rows).map(taps).collect() }
    }

    /// Neighbours with their weights at each place of the tile, row by row.
    pub(crate) fn taps(&self) -> &[Vec<(Step, f32)>] {
        &self.taps
    }

    /// Fills a plane with weighted means of `value`, which is asked at pixels that see the channel. Those pixels
    /// themselves keep their value if `keep` says so.
    pub(super) fn fill(
        &self,
        plane: &mut [f32],
        [width, height]: [usize; 2],
        keep: bool,
        value: impl Fn(usize) -> f32 + Sync,
    ) {
        let r = self.radius;
        for_each_row(plane, width, |y, row| {
            let inner_row = y >= r && y + r < height;
            for column in 0..self.columns.min(width) {
                let taps = &self.taps[y % self.rows * self.columns + column];
                let measured = keep && taps.first().is_some_and(|(step, _)| (step.dx, step.dy) == (0, 0));
                if measured {
                    for x in (column..width).step_by(self.columns) {
                        row[x] = value(y * width + x);
                    }
                    continue;
                }
                let sum: f32 = taps.iter().map(|(_, weight)| weight).sum();
                let offsets: Vec<(isize, f32)> =
                    taps.iter().map(|(s, weight)| (s.dy * width as isize + s.dx, weight / sum)).collect();
                for x in (column..width).step_by(self.columns) {
                    let here = y * width + x;
                    row[x] = if inner_row && x >= r && x + r < width {
                        offsets.iter().map(|&(offset, weight)| weight * value(here.wrapping_add_signed(offset))).sum()
                    } else {
                        self.at_edge(taps, [x, y], [width, height], &value)
                    };
                }
            }
        });
    }

    fn at_edge(
        &self,
        taps: &[(Step, f32)],
        [x, y]: [usize; 2],
        size: [usize; 2],
        value: &impl Fn(usize) -> f32,
    ) -> f32 {
        let inside = taps.iter().filter_map(|(step, weight)| Some((step.from(x, y, size)?, weight)));
        let (sum, weights) = inside
            .map(|((x, y), weight)| (weight * value(y * size[0] + x), weight))
            .fold((0.0, 0.0), |(sum, weights), (value, weight)| (sum + value, weights + weight));
        if weights > 0.0 {
            return sum / weights;
        }
        // All lie outside: at the same place of a neighbouring tile some lie inside.
        let shifts = |tile: usize| [0, tile as isize, -(tile as isize)];
        let (columns, rows) = (shifts(self.columns), shifts(self.rows));
        let places = rows.into_iter().flat_map(|dy| columns.map(|dx| Step { dx, dy }));
        let mut places = places.filter_map(|shift| shift.from(x, y, size));
        let inside = places.find_map(|(x, y)| taps.iter().find_map(|(step, _)| step.from(x, y, size)));
        // An image smaller than a tile may lack a channel altogether.
        inside.map_or(0.0, |(x, y)| value(y * size[0] + x))
    }
}
