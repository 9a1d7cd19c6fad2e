//! Demosaicking in four directions, for X-Trans and other arrays of red, green and blue in which green is densest.
//!
//! Along each of four directions, row, column and both diagonals, a whole image is made: green by linear
//! interpolation along the direction, red and blue by their differences to it. Where an image bends least along its
//! own direction, that direction is an edge's; the directions in which most of the surroundings are even so are
//! averaged. The idea of counting even neighbours is Hirakawa's and Parks's
//! ([Hirakawa05](photosite_core::references#hirakawa05)); that of four directions on X-Trans arrays is Frank
//! Markesteijn's.
//!
//! Beyond the edges the mosaic goes on with what lies a tile further inwards, which has the same channel.

use rayon::prelude::*;

use super::channels::{planes, together};
use crate::neighbours::{densest, radius_for_all, steps};
use photosite_core::image::Planes;
use photosite_raw::Cfa;

/// Rows of a band without its margin.
const BAND: usize = 48;
/// Pixels around a pixel that its result depends on, at most.
const MARGIN: usize = 12;
/// The directions as steps (Δx, Δy).
const DIRECTIONS: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [1, -1]];
/// Farthest green pixel along a direction.
const REACH: isize = 3;
const GREEN: usize = 1;

/// Whether the method works: R, G and B with green densest and near along all directions.
pub(super) fn fits(cfa: &Cfa) -> bool {
    let (columns, rows) = cfa.tile_size();
    let is_rgb =
        cfa.channels() == ["R", "G", "B"] && !cfa.is_full() && densest(cfa) == GREEN && radius_for_all(cfa) <= 2;
    is_rgb
        && (0..columns * rows).all(|i| {
            let has_green = |direction: usize| Line::new(cfa, [i % columns, i / columns], direction).is_some();
            cfa.channel_at(i % columns, i / columns) == GREEN || (0..4).all(has_green)
        })
}

/// The nearest green pixels on both sides along a direction: steps and weights.
#[derive(Clone, Copy)]
struct Line {
    before: isize,
    after: isize,
}

impl Line {
    fn new(cfa: &Cfa, [x, y]: [usize; 2], direction: usize) -> Option<Self> {
        let (columns, rows) = cfa.tile_size();
        let [dx, dy] = DIRECTIONS[direction];
        let is_green = |k: &isize| {
            let column = (x as isize + k * dx).rem_euclid(columns as isize) as usize;
            let row = (y as isize + k * dy).rem_euclid(rows as isize) as usize;
            cfa.channel_at(column, row) == GREEN
        };
        Some(Self { before: (1..=REACH).find(|k| is_green(&-k))?, after: (1..=REACH).find(is_green)? })
    }
}

/// Planes R, G and B.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let mut channels = planes(width, height, cfa);
    let [red, green, blue] = &mut channels[..] else { return together(width, height, channels) };
    let tables = Tables::new(cfa, width + 2 * MARGIN);
    let chunk = (width * BAND).max(1);
    let bands =
        red.data.par_chunks_mut(chunk).zip(green.data.par_chunks_mut(chunk)).zip(blue.data.par_chunks_mut(chunk));
    bands.enumerate().for_each(|(i, ((red, green), blue))| {
        let rows = red.len() / width;
        let mut band = Band::load(mosaic, [width, height], i * BAND, rows, cfa, &tables);
        band.solve();
        for y in 0..rows {
            for x in 0..width {
                let [r, g, b] = band.colour((y + MARGIN) * band.width + x + MARGIN);
                (red[y * width + x], green[y * width + x], blue[y * width + x]) = (r, g, b);
            }
        }
    });
    together(width, height, channels)
}

/// Tables for every place of the tile.
struct Tables {
    columns: usize,
    rows: usize,
    channel: Vec<usize>,
    /// Green pixels along each direction; meaningless at green pixels.
    lines: Vec<[Option<Line>; 4]>,
    /// Offsets and weights of red and of blue pixels nearby.
    near: Vec<[Vec<(isize, f32)>; 2]>,
}

impl Tables {
    fn new(cfa: &Cfa, stride: usize) -> Self {
        let (columns, rows) = cfa.tile_size();
        let places = || (0..columns * rows).map(|i| [i % columns, i / columns]);
        let radius = radius_for_all(cfa);
        let near = |place: [usize; 2], channel: usize| {
            let weight = |d: isize| radius as f32 + 1.0 - d.unsigned_abs() as f32;
            let taps = steps(cfa, place, channel, radius).into_iter();
            let taps: Vec<(isize, f32)> =
                taps.map(|s| (s.dy * stride as isize + s.dx, weight(s.dx) * weight(s.dy))).collect();
            let sum: f32 = taps.iter().map(|(_, w)| w).sum();
            taps.into_iter().map(|(offset, w)| (offset, w / sum)).collect()
        };
        Self {
            columns,
            rows,
            channel: places().map(|[x, y]| cfa.channel_at(x, y)).collect(),
            lines: places().map(|place| [0, 1, 2, 3].map(|d| Line::new(cfa, place, d))).collect(),
            near: places().map(|place| [near(place, 0), near(place, 2)]).collect(),
        }
    }
}

/// A band of rows with its margin.
struct Band<'a> {
    tables: &'a Tables,
    width: usize,
    height: usize,
    /// Row and column of the tile at the band's first pixel.
    phase: [usize; 2],
    mosaic: Vec<f32>,
    /// Red, green and blue for each direction.
    images: [[Vec<f32>; 3]; 4],
    /// Curvature of the image of each direction.
    bends: [Vec<f32>; 4],
    /// Number of neighbours that are even along each direction.
    even: [Vec<u8>; 4],
}

impl<'a> Band<'a> {
    fn load(
        mosaic: &[f32],
        [width, height]: [usize; 2],
        top: usize,
        rows: usize,
        cfa: &Cfa,
        tables: &'a Tables,
    ) -> Self {
        let (padded_width, padded_height) = (width + 2 * MARGIN, rows + 2 * MARGIN);
        let (columns, tile_rows) = cfa.tile_size();
        let mut padded = Vec::with_capacity(padded_width * padded_height);
        for y in 0..padded_height {
            let from = &mosaic[inwards(top + y, MARGIN, height, tile_rows) * width..][..width];
            padded.extend((0..padded_width).map(|x| from[inwards(x, MARGIN, width, columns)]));
        }
        let plane = || vec![0.0; padded.len()];
        Self {
            tables,
            width: padded_width,
            height: padded_height,
            // The first pixel lies a margin before the image's.
            phase: [(top + MARGIN * (tile_rows - 1)) % tile_rows, MARGIN * (columns - 1) % columns],
            images: [(); 4].map(|()| [(); 3].map(|()| plane())),
            bends: [(); 4].map(|()| plane()),
            even: [(); 4].map(|()| vec![0; padded.len()]),
            mosaic: padded,
        }
    }

    fn solve(&mut self) {
        for direction in 0..4 {
            self.interpolate(direction);
            self.measure_bends(direction);
        }
        self.count_even();
    }

    /// Place in the tile of a pixel.
    #[inline]
    fn place(&self, x: usize, y: usize) -> usize {
        let Tables { columns, rows, .. } = self.tables;
        (y + self.phase[0]) % rows * columns + (x + self.phase[1]) % columns
    }

    /// Offset of a step along a direction.
    fn step(&self, direction: usize) -> isize {
        let [dx, dy] = DIRECTIONS[direction];
        dy * self.width as isize + dx
    }

    fn interpolate(&mut self, direction: usize) {
        let step = self.step(direction);
        let [mut red, mut green, mut blue] = std::mem::take(&mut self.images[direction]);
        let reach = REACH as usize;
        for y in reach..self.height - reach {
            for x in reach..self.width - reach {
                let (i, place) = (y * self.width + x, self.place(x, y));
                let at = |offset: isize| self.mosaic[i.wrapping_add_signed(offset)];
                green[i] = match self.tables.lines[place][direction] {
                    Some(Line { before, after }) if self.tables.channel[place] != GREEN => {
                        let (b, a) = (before as f32, after as f32);
                        (a * at(-before * step) + b * at(after * step)) / (a + b)
                    }
                    Some(_) | None => self.mosaic[i],
                };
            }
        }
        let inset = reach + 2;
        for y in inset..self.height - inset {
            for x in inset..self.width - inset {
                let i = y * self.width + x;
                let near = &self.tables.near[self.place(x, y)];
                for (colour, taps) in [(&mut red, &near[0]), (&mut blue, &near[1])] {
                    let difference = |&(offset, weight): &(isize, f32)| {
                        let j = i.wrapping_add_signed(offset);
                        weight * (self.mosaic[j] - green[j])
                    };
                    colour[i] = green[i] + taps.iter().map(difference).sum::<f32>();
                }
                match self.tables.channel[self.place(x, y)] {
                    0 => red[i] = self.mosaic[i],
                    2 => blue[i] = self.mosaic[i],
                    _ => {}
                }
            }
        }
        self.images[direction] = [red, green, blue];
    }

    /// Squared second differences of brightness and colour along the direction.
    fn measure_bends(&mut self, direction: usize) {
        let step = self.step(direction);
        let [red, green, blue] = &self.images[direction];
        let bends = &mut self.bends[direction];
        let inset = REACH as usize + 3;
        for y in inset..self.height - inset {
            for x in inset..self.width - inset {
                let i = y * self.width + x;
                let (before, after) = (i.wrapping_add_signed(-step), i.wrapping_add_signed(step));
                let bend = |plane: &[f32]| 2.0 * plane[i] - plane[before] - plane[after];
                let [r, g, b] = [bend(red), bend(green), bend(blue)];
                // Luma and colour differences of BT.2020.
                let luma = 0.2627 * r + 0.6780 * g + 0.0593 * b;
                let (cb, cr) = ((b - luma) * 0.56433, (r - luma) * 0.67815);
                bends[i] = luma * luma + cb * cb + cr * cr;
            }
        }
    }

    /// Counts, in windows of 3 × 3, where each direction bends no more than 8 times what the best does.
    fn count_even(&mut self) {
        let inset = REACH as usize + 4;
        let [a, b, c, d] = &self.bends;
        let limit: Vec<f32> = (0..a.len()).map(|i| 8.0 * a[i].min(b[i]).min(c[i]).min(d[i]) + 1e-12).collect();
        for (bends, even) in self.bends.iter().zip(&mut self.even) {
            for y in inset..self.height - inset {
                for x in inset..self.width - inset {
                    let rows = (y - 1..=y + 1).map(|y| y * self.width + x);
                    let count = rows.flat_map(|i| i - 1..=i + 1).filter(|&i| bends[i] <= limit[i]).count();
                    even[y * self.width + x] = count as u8;
                }
            }
        }
    }

    /// The mean of the directions that are even in nearly as much of the surroundings, 5 × 5, as the best.
    fn colour(&self, i: usize) -> [f32; 3] {
        let count = |even: &Vec<u8>| -> u32 {
            let rows = (0..5).map(|k| i + k * self.width - 2 * self.width);
            rows.flat_map(|i| &even[i - 2..=i + 2]).map(|&n| u32::from(n)).sum()
        };
        let counts = self.even.each_ref().map(count);
        let best = counts.into_iter().max().unwrap_or(0);
        let mut sum = [0.0; 3];
        let mut directions = 0.0;
        for (count, image) in counts.into_iter().zip(&self.images) {
            if 8 * count >= 7 * best {
                sum.iter_mut().zip(image).for_each(|(sum, plane)| *sum += plane[i]);
                directions += 1.0;
            }
        }
        sum.map(|sum| sum / directions)
    }
}

/// The pixel of a line of `n` that lies `margin` before `i`, or, where there is none, one of the same channel inwards.
pub(super) fn inwards(i: usize, margin: usize, n: usize, tile: usize) -> usize {
    let mut i = i as isize - margin as isize;
    let (n, tile) = (n as isize, tile as isize);
    if n < tile {
        // Less than a tile has no such pixel for every channel.
        return i.rem_euclid(n.max(1)) as usize;
    }
    if i < 0 {
        i = i.rem_euclid(tile);
    }
    if i >= n {
        i -= (i - n + tile) / tile * tile;
    }
    i as usize
}
