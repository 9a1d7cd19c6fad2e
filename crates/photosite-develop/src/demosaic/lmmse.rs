//! Linear minimum mean square error estimates along rows and along columns, for any filter array of small tiles.
//!
//! If an image is thought of as one of many whose values v of channels a and b, at pixels that lie d apart, have the
//! covariance
//!
//! C(d, a, b) = exp(−√((dx/l_x)² + (dy/l_y)²)) · (1 if a = b, else ρ),
//!
//! the best linear estimate of a channel is a weighted sum of the numbers around a pixel, whatever channels they are
//! of. The weights follow from C at each place of the tile, with those of the channel adding up to 1 and those of each
//! other to 0, so that even surfaces come out exactly. It is made twice: for structure along rows, l_x ≫ l_y, and along
//! columns. Where colour differences change less along one of the two, that is an edge's direction, and counts for
//! more.
//!
//! That is the idea of Zhang and Wu for Bayer mosaics ([Zhang05](photosite_core::references#zhang05)), with the weights
//! for any mosaic after Chaix de Lavarène, Alleysson and Hérault ([Chaix07](photosite_core::references#chaix07)), who
//! take them from example images. Correlation and lengths are chosen on test charts.
//!
//! In: the mosaic, white-balanced, since channels are taken for alike. Out: planes of all channels in the same unit;
//! measured values stay. Beyond the edges the mosaic goes on as in [`markesteijn`](super::markesteijn).

use rayon::prelude::*;

use super::channels::{planes, together};
use super::markesteijn::inwards;
use crate::neighbours::{densest, radius_for_all};
use photosite_core::image::Planes;
use photosite_core::math::linear::solve;
use photosite_raw::Cfa;

/// Pixels around a pixel, on each side, that its value depends on.
const REACH: usize = 4;
/// Lengths over which an image changes, along its structure and across, pixels.
const LENGTHS: [f64; 2] = [16.0, 3.0];
/// ρ, the correlation of two channels.
const CORRELATION: f64 = 0.9;
/// Variance of noise over that of the image: keeps the equations well-conditioned.
const NOISE: f64 = 1e-4;
/// Pixels on each side whose colour differences tell the direction.
const WINDOW: usize = 3;
/// Rows of a band without its margin.
const BAND: usize = 48;
/// Pixels around a band that its result depends on.
const MARGIN: usize = REACH + WINDOW + 1;
/// Most places of a tile, each of which has weights of its own.
const MOST_PLACES: usize = 64;

/// Whether the method works: the window shows every channel, and the tile is small.
pub(super) fn fits(cfa: &Cfa) -> bool {
    let (columns, rows) = cfa.tile_size();
    cfa.is_mosaic() && columns * rows <= MOST_PLACES && radius_for_all(cfa) <= REACH
}

/// Planes of all channels.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let mut channels = planes(width, height, cfa);
    if width * height == 0 {
        return together(width, height, channels);
    }
    let weights = [0, 1].map(|direction| Weights::new(cfa, direction));
    let mut bands: Vec<Vec<&mut [f32]>> = Vec::new();
    for channel in &mut channels {
        for (i, rows) in channel.data.chunks_mut(width * BAND).enumerate() {
            if bands.len() == i {
                bands.push(Vec::new());
            }
            bands[i].push(rows);
        }
    }
    bands.par_iter_mut().enumerate().for_each(|(i, to)| {
        let band = Band::load(mosaic, [width, height], i * BAND, to[0].len() / width, cfa);
        band.solve(&weights, cfa, width, to);
    });
    drop(bands);
    together(width, height, channels)
}

/// The weights of one direction.
struct Weights {
    /// Weights of the window, row by row, for each place of the tile and each channel.
    taps: Vec<Vec<Vec<f32>>>,
}

impl Weights {
    /// Structure along rows for direction 0, along columns for 1.
    fn new(cfa: &Cfa, direction: usize) -> Self {
        let (columns, rows) = cfa.tile_size();
        Self { taps: (0..columns * rows).map(|i| Self::of_place(cfa, [i % columns, i / columns], direction)).collect() }
    }

    fn of_place(cfa: &Cfa, [x, y]: [usize; 2], direction: usize) -> Vec<Vec<f32>> {
        let (columns, rows) = cfa.tile_size();
        let channels = cfa.channels().len();
        let (side, reach) = (2 * REACH + 1, REACH as isize);
        let step = |i: usize| [(i % side) as isize - reach, (i / side) as isize - reach];
        let channel = |i: usize| {
            let [dx, dy] = step(i);
            let column = (x as isize + dx).rem_euclid(columns as isize) as usize;
            cfa.channel_at(column, (y as isize + dy).rem_euclid(rows as isize) as usize)
        };
        let covariance = |[dx, dy]: [isize; 2], a: usize, b: usize| {
            let [along, across] = if direction == 0 { [dx, dy] } else { [dy, dx] };
            let distance = (along as f64 / LENGTHS[0]).hypot(across as f64 / LENGTHS[1]);
            (-distance).exp() * if a == b { 1.0 } else { CORRELATION }
        };
        // (C + noise) w + K μ = c, Kᵀ w = e, with K telling which number is of which channel.
        let n = side * side;
        let mut matrix = vec![vec![0.0; n + channels]; n + channels];
        for i in 0..n {
            let [xi, yi] = step(i);
            for (j, entry) in matrix[i].iter_mut().enumerate().take(n) {
                let [xj, yj] = step(j);
                *entry = covariance([xi - xj, yi - yj], channel(i), channel(j));
            }
            matrix[i][i] += NOISE;
            matrix[i][n + channel(i)] = 1.0;
            matrix[n + channel(i)][i] = 1.0;
        }
        let of_channel = |wanted: usize| {
            let known = (0..n).map(|i| covariance(step(i), channel(i), wanted));
            let sums = (0..channels).map(|c| if c == wanted { 1.0 } else { 0.0 });
            let weights = solve(matrix.clone(), known.chain(sums).collect()).unwrap_or_else(|| vec![0.0; n]);
            weights.into_iter().take(n).map(|weight| weight as f32).collect()
        };
        (0..channels).map(of_channel).collect()
    }
}

/// A band of rows with its margin. The values of a row lie in as many pieces as the tile has columns, so that those of
/// one place of the tile are neighbours.
struct Band {
    tile: [usize; 2],
    /// Values in a piece.
    length: usize,
    height: usize,
    /// Column and row of the tile at the band's first pixel.
    phase: [usize; 2],
    pieces: Vec<f32>,
}

impl Band {
    fn load(mosaic: &[f32], [width, height]: [usize; 2], top: usize, rows: usize, cfa: &Cfa) -> Self {
        let (columns, tile_rows) = cfa.tile_size();
        let length = (width + 2 * MARGIN).div_ceil(columns);
        let padded_height = rows + 2 * MARGIN;
        let mut pieces = vec![0.0; length * columns * padded_height];
        for (y, row) in pieces.chunks_exact_mut(length * columns).enumerate() {
            let from = &mosaic[inwards(top + y, MARGIN, height, tile_rows) * width..][..width];
            for x in 0..length * columns {
                row[x % columns * length + x / columns] = from[inwards(x, MARGIN, width, columns)];
            }
        }
        // The first pixel lies a margin before the image's.
        let phase = [MARGIN * (columns - 1) % columns, (top + MARGIN * (tile_rows - 1)) % tile_rows];
        Self { tile: [columns, tile_rows], length, height: padded_height, phase, pieces }
    }

    /// Place in the tile of the pixels of a piece.
    fn place(&self, piece: usize, y: usize) -> [usize; 2] {
        [(piece + self.phase[0]) % self.tile[0], (y + self.phase[1]) % self.tile[1]]
    }

    fn piece(&self, piece: usize, y: usize) -> &[f32] {
        &self.pieces[(y * self.tile[0] + piece) * self.length..][..self.length]
    }

    /// Writes the rows without the margin.
    fn solve(&self, weights: &[Weights; 2], cfa: &Cfa, width: usize, to: &mut [&mut [f32]]) {
        let channels = cfa.channels().len();
        let padded = self.tile[0] * self.length;
        let estimates = [0, 1].map(|direction| self.estimate(&weights[direction], cfa, channels));
        let guide = densest(cfa);
        let [by_row, by_column] = [(0, 1), (1, padded)].map(|(direction, step)| {
            let mut change = vec![0.0; padded * self.height];
            for c in (0..channels).filter(|&c| c != guide) {
                let (plane, guide) = (&estimates[direction][c], &estimates[direction][guide]);
                for i in 0..change.len() - step {
                    change[i] += ((plane[i + step] - guide[i + step]) - (plane[i] - guide[i])).abs();
                }
            }
            window_sums(&change, padded)
        });
        for y in 0..self.height - 2 * MARGIN {
            for x in 0..width {
                let i = (y + MARGIN) * padded + x + MARGIN;
                // Far apart, one of the two is taken alone.
                let [row, column] =
                    [by_row[i], by_column[i]].map(|change| (change * change).powi(2) + f32::MIN_POSITIVE);
                let part = column / (row + column);
                for (c, plane) in to.iter_mut().enumerate() {
                    let [along_row, along_column] = [&estimates[0][c], &estimates[1][c]].map(|plane| plane[i]);
                    plane[y * width + x] = part * along_row + (1.0 - part) * along_column;
                }
            }
        }
    }

    /// Estimates all channels by the weights of a direction; nothing within [`REACH`] of the band's edge.
    fn estimate(&self, weights: &Weights, cfa: &Cfa, channels: usize) -> Vec<Vec<f32>> {
        let columns = self.tile[0];
        let (side, padded) = (2 * REACH + 1, columns * self.length);
        let mut planes = vec![vec![0.0; padded * self.height]; channels];
        let mut sums = vec![0.0; self.length];
        for y in REACH..self.height - REACH {
            for piece in 0..columns {
                let [place_x, place_y] = self.place(piece, y);
                let taps = &weights.taps[place_y * columns + place_x];
                for (c, plane) in planes.iter_mut().enumerate() {
                    if c == cfa.channel_at(place_x, place_y) {
                        sums.copy_from_slice(self.piece(piece, y));
                    } else {
                        sums.fill(0.0);
                        for (i, &weight) in taps[c].iter().enumerate() {
                            let column = piece as isize + (i % side) as isize - REACH as isize;
                            let from = self.piece(column.rem_euclid(columns as isize) as usize, y + i / side - REACH);
                            add_shifted(&mut sums, from, column.div_euclid(columns as isize), weight);
                        }
                    }
                    let row = plane[y * padded..][..padded].iter_mut().skip(piece).step_by(columns);
                    row.zip(&sums).for_each(|(to, sum)| *to = *sum);
                }
            }
        }
        planes
    }
}

/// Adds weight · from[k + shift] to each sum k.
#[inline]
fn add_shifted(sums: &mut [f32], from: &[f32], shift: isize, weight: f32) {
    let by = shift.unsigned_abs().min(sums.len());
    let (sums, from) = if shift < 0 { (&mut sums[by..], from) } else { (sums, &from[by..]) };
    sums.iter_mut().zip(from).for_each(|(sum, value)| *sum += weight * value);
}

/// Sums over squares of [`WINDOW`] pixels on each side; where such a square leaves the image, of what is there.
fn window_sums(values: &[f32], width: usize) -> Vec<f32> {
    let mut across = vec![0.0f32; values.len()];
    for (from, to) in values.chunks_exact(width).zip(across.chunks_exact_mut(width)) {
        for (x, to) in to.iter_mut().enumerate() {
            *to = from[x.saturating_sub(WINDOW)..(x + WINDOW + 1).min(width)].iter().sum();
        }
    }
    let mut sums = vec![0.0f32; values.len()];
    let height = values.len() / width;
    for (y, to) in sums.chunks_exact_mut(width).enumerate() {
        for row in y.saturating_sub(WINDOW)..(y + WINDOW + 1).min(height) {
            to.iter_mut().zip(&across[row * width..]).for_each(|(sum, value)| *sum += value);
        }
    }
    sums
}
