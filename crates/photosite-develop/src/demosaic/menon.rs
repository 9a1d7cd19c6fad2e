//! Demosaicking along edges, for Bayer mosaics.
//!
//! Green is interpolated along rows and along columns; where colour differences change less along one of the two, that
//! direction is an edge's, and its result is taken. Red and blue follow as differences to green along the chosen
//! directions, and a refinement smooths those differences once more
//! ([Menon07](photosite_core::references#menon07), "DDFAPD"). Linear gradients come out exactly.
//!
//! In: the mosaic of a Bayer filter in any of its four phases, white-balanced, since the method takes colour
//! differences for smooth. Out: planes R, G, B in the same unit. At the edges the mosaic is mirrored.

use rayon::prelude::*;

use crate::window::mirror;
use photosite_core::image::{Channel, Planes};
use photosite_raw::Cfa;

/// Pixels around a tile that its result depends on; even, so that a tile has the mosaic's phase.
pub(crate) const MARGIN: usize = 10;
/// Rows and columns of a tile without its margin; even, too.
const TILE_ROWS: usize = 128;
const TILE_COLUMNS: usize = 256;

/// Planes R, G and B of a Bayer mosaic.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let mut planes = ["R", "G", "B"].map(|name| Channel { name: name.to_owned(), data: vec![0.0; width * height] });
    let [red, green, blue] = &mut planes;
    let band = (width * TILE_ROWS).max(1);
    let bands = red.data.par_chunks_mut(band).zip(green.data.par_chunks_mut(band)).zip(blue.data.par_chunks_mut(band));
    bands.enumerate().for_each(|(i, ((red, green), blue))| {
        let mut tile = Tile::new(cfa);
        let top = i * TILE_ROWS;
        for left in (0..width).step_by(TILE_COLUMNS) {
            tile.load(mosaic, [width, height], [left, top]);
            tile.solve();
            let columns = TILE_COLUMNS.min(width - left);
            for y in 0..red.len() / width {
                let from = (y + MARGIN) * Tile::WIDTH + MARGIN;
                let to = y * width + left;
                red[to..to + columns].copy_from_slice(&tile.chroma[Tile::RED][from..from + columns]);
                green[to..to + columns].copy_from_slice(&tile.green[from..from + columns]);
                blue[to..to + columns].copy_from_slice(&tile.chroma[Tile::BLUE][from..from + columns]);
            }
        }
    });
    Planes::new(width, height, planes.into()).expect("planes were made for this size")
}

/// Parity of the rows that hold red pixels of a Bayer filter, and of the columns.
pub(crate) fn red_place(cfa: &Cfa) -> [usize; 2] {
    (0..4).map(|i| [i / 2, i % 2]).find(|&[y, x]| cfa.channel_at(x, y) == 0).unwrap_or([0, 0])
}

/// A piece of the mosaic and what becomes of it, small enough for the cache.
///
/// In a row of red pixels ("own" colour red) every other pixel is red; the green ones between have red beside and blue
/// above them. In a row of blue pixels it is the other way round. So each step is written once, for the row's own and
/// other colour.
struct Tile {
    /// Parity of the rows that hold red pixels, and of the columns.
    red: [usize; 2],
    mosaic: Vec<f32>,
    green: Vec<f32>,
    /// Red and blue.
    chroma: [Vec<f32>; 2],
    /// Own colour minus green where green was interpolated along rows, and along columns; 0 at green pixels.
    difference: [Vec<f32>; 2],
    /// Whether to interpolate along the row, for pixels that are not green.
    along_row: Vec<bool>,
}

impl Tile {
    const WIDTH: usize = TILE_COLUMNS + 2 * MARGIN;
    const HEIGHT: usize = TILE_ROWS + 2 * MARGIN;
    const RED: usize = 0;
    const BLUE: usize = 1;

    fn new(cfa: &Cfa) -> Self {
        let plane = || vec![0.0; Self::WIDTH * Self::HEIGHT];
        Self {
            red: red_place(cfa),
            mosaic: plane(),
            green: plane(),
            chroma: [plane(), plane()],
            difference: [plane(), plane()],
            along_row: vec![false; Self::WIDTH * Self::HEIGHT],
        }
    }

    /// Copies the piece at column `left`, row `top`, with its margin.
    fn load(&mut self, mosaic: &[f32], [width, height]: [usize; 2], [left, top]: [usize; 2]) {
        for (y, row) in self.mosaic.chunks_exact_mut(Self::WIDTH).enumerate() {
            let from = &mosaic[mirror(top + y, MARGIN, height) * width..][..width];
            for (x, value) in row.iter_mut().enumerate() {
                *value = from[mirror(left + x, MARGIN, width)];
            }
        }
    }

    fn solve(&mut self) {
        self.interpolate_green_both_ways();
        self.choose_directions();
        self.fill_green();
        // Each step needs the one before it one pixel further out.
        self.chroma_at_green(5);
        self.other_colour(6, mean_of_two);
        // The refinement: the same once more, with what is now known in between.
        self.green_again(7);
        self.chroma_at_green(8);
        self.other_colour(9, mean_of_three);
    }

    /// Index of the colour, besides green, that the row's pixels see.
    fn own_colour(&self, y: usize) -> usize {
        if y % 2 == self.red[0] { Self::RED } else { Self::BLUE }
    }

    /// Indices of the row's pixels that are not green, `inset` pixels from the tile's edge.
    fn coloured(&self, y: usize, inset: usize) -> impl Iterator<Item = usize> + use<> {
        let parity = if y % 2 == self.red[0] { self.red[1] } else { 1 - self.red[1] };
        pixels(y, inset, parity)
    }

    /// Indices of the row's green pixels.
    fn green_pixels(&self, y: usize, inset: usize) -> impl Iterator<Item = usize> + use<> {
        let parity = if y % 2 == self.red[0] { 1 - self.red[1] } else { self.red[1] };
        pixels(y, inset, parity)
    }

    /// Green at coloured pixels: the mean of its neighbours, corrected by the second difference of the pixel's colour.
    fn interpolate_green_both_ways(&mut self) {
        for y in 2..Self::HEIGHT - 2 {
            for i in self.coloured(y, 2) {
                let m = &self.mosaic;
                for (difference, step) in self.difference.iter_mut().zip([1, Self::WIDTH]) {
                    let curvature = 2.0 * m[i] - m[i - 2 * step] - m[i + 2 * step];
                    let green = 0.5 * (m[i - step] + m[i + step]) + 0.25 * curvature;
                    difference[i] = m[i] - green;
                }
            }
        }
    }

    /// Sums of the changes of colour difference near a pixel, along the row and along the column; the smaller wins.
    fn choose_directions(&mut self) {
        let change = |direction: usize, step: usize, i: usize| {
            (self.difference[direction][i] - self.difference[direction][i + 2 * step]).abs()
        };
        // Weights 3 for the pixel's own line, 1 for the lines beside it, which hold changes at two places where they
        // have its colour and at one where they have the other.
        let roughness = |direction: usize, i: usize| {
            let (step, across) = if direction == 0 { (1, Self::WIDTH) } else { (Self::WIDTH, 1) };
            let own_line = |i: usize| change(direction, step, i - 2 * step) + change(direction, step, i);
            let neighbour_line = |i: usize| change(direction, step, i - step);
            3.0 * own_line(i)
                + own_line(i - 2 * across)
                + own_line(i + 2 * across)
                + neighbour_line(i - across)
                + neighbour_line(i + across)
        };
        for y in 4..Self::HEIGHT - 4 {
            for i in self.coloured(y, 4) {
                self.along_row[i] = roughness(0, i) <= roughness(1, i);
            }
        }
    }

    /// Green everywhere, and each coloured pixel's own colour.
    fn fill_green(&mut self) {
        self.green.copy_from_slice(&self.mosaic);
        for y in 4..Self::HEIGHT - 4 {
            let own = self.own_colour(y);
            for i in self.coloured(y, 4) {
                let difference = self.difference[usize::from(!self.along_row[i])][i];
                self.green[i] = self.mosaic[i] - difference;
                self.chroma[own][i] = self.mosaic[i];
            }
        }
    }

    /// Red and blue at green pixels: green plus the mean difference to green of the two neighbours of that colour.
    fn chroma_at_green(&mut self, inset: usize) {
        let green = &self.green;
        for y in inset..Self::HEIGHT - inset {
            let own = self.own_colour(y);
            let pixels = self.green_pixels(y, inset);
            let [first, second] = &mut self.chroma;
            let (own, other) = if own == Self::RED { (first, second) } else { (second, first) };
            for i in pixels {
                for (colour, step) in [(&mut *own, 1), (&mut *other, Self::WIDTH)] {
                    let difference = |i: usize| colour[i] - green[i];
                    colour[i] = green[i] + 0.5 * (difference(i - step) + difference(i + step));
                }
            }
        }
    }

    /// Blue at red pixels and red at blue ones: the pixel's own colour plus the mean difference to it along the chosen
    /// direction.
    fn other_colour(&mut self, inset: usize, mean: impl Fn(f32, f32, f32) -> f32) {
        for y in inset..Self::HEIGHT - inset {
            let own = self.own_colour(y);
            let pixels = self.coloured(y, inset);
            let [first, second] = &mut self.chroma;
            let (own, other) = if own == Self::RED { (first, second) } else { (second, first) };
            for i in pixels {
                let step = if self.along_row[i] { 1 } else { Self::WIDTH };
                let difference = |i: usize| other[i] - own[i];
                other[i] = own[i] + mean(difference(i - step), difference(i), difference(i + step));
            }
        }
    }

    /// Green at coloured pixels, from differences that are now known at every pixel.
    fn green_again(&mut self, inset: usize) {
        for y in inset..Self::HEIGHT - inset {
            let own = &self.chroma[self.own_colour(y)];
            for i in self.coloured(y, inset) {
                let step = if self.along_row[i] { 1 } else { Self::WIDTH };
                let difference = |i: usize| own[i] - self.green[i];
                self.green[i] = own[i] - mean_of_three(difference(i - step), difference(i), difference(i + step));
            }
        }
    }
}

fn mean_of_two(before: f32, _: f32, after: f32) -> f32 {
    0.5 * (before + after)
}

fn mean_of_three(before: f32, here: f32, after: f32) -> f32 {
    (before + here + after) / 3.0
}

/// Indices of every other pixel of a row of a tile.
fn pixels(y: usize, inset: usize, parity: usize) -> impl Iterator<Item = usize> {
    let first = inset + (inset + parity) % 2;
    (first..Tile::WIDTH - inset).step_by(2).map(move |x| y * Tile::WIDTH + x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PHASES: [&str; 4] = ["RGGB", "BGGR", "GRBG", "GBRG"];

    /// Mosaic that a sensor with this filter array sees of an image given as functions of (x, y).
    fn mosaic(cfa: &Cfa, width: usize, height: usize, colour: impl Fn(usize, f64, f64) -> f64) -> Vec<f32> {
        let pixel = |i: usize| {
            let (x, y) = (i % width, i / width);
            colour(cfa.channel_at(x, y), x as f64, y as f64) as f32
        };
        (0..width * height).map(pixel).collect()
    }

    #[test]
    fn linear_gradients_are_exact_in_all_phases_and_across_tiles() {
        let (width, height) = (TILE_COLUMNS + 37, TILE_ROWS + 21);
        let ramp = |channel: usize, x: f64, y: f64| {
            let [a, b, c] = [[0.2, 1e-3, -2e-4], [0.3, -4e-4, 1e-3], [0.1, 5e-4, 7e-4]][channel];
            a + b * x + c * y
        };
        for phase in PHASES {
            let cfa = Cfa::parse(phase).expect("a Bayer phase");
            let planes = demosaic(&mosaic(&cfa, width, height, ramp), width, height, &cfa);
            for (c, channel) in planes.channels().iter().enumerate() {
                for y in MARGIN..height - MARGIN {
                    for x in MARGIN..width - MARGIN {
                        let expected = ramp(c, x as f64, y as f64);
                        let found = f64::from(channel.data[y * width + x]);
                        // Some twenty f32 operations on values below 1, each within 2⁻²⁴.
                        assert!((found - expected).abs() < 2e-6, "{phase} {} at {x}, {y}: {found}", channel.name);
                    }
                }
            }
        }
    }

    #[test]
    fn measured_values_stay_as_they_are() {
        let (width, height) = (40, 30);
        for phase in PHASES {
            let cfa = Cfa::parse(phase).expect("a Bayer phase");
            let noise = mosaic(&cfa, width, height, |c, x, y| (12.9898 * x + 78.233 * y + c as f64).sin());
            let planes = demosaic(&noise, width, height, &cfa);
            for (i, measured) in noise.iter().enumerate() {
                let channel = cfa.channel_at(i % width, i / width);
                // Green is refined at coloured pixels only.
                assert_eq!(planes.channels()[channel].data[i], *measured, "{phase}, pixel {i}");
            }
        }
    }

    #[test]
    fn a_zone_plate_comes_out_better_than_by_bilinear_interpolation() {
        let n = 256;
        // Grey cos(k·r²): the frequency grows to 0.35 cycles a pixel at the sides.
        let plate = |_: usize, x: f64, y: f64| {
            let (x, y) = (x - n as f64 / 2.0, y - n as f64 / 2.0);
            0.5 + 0.4 * (std::f64::consts::PI * 0.35 / (n as f64 / 2.0) * (x * x + y * y)).cos()
        };
        for phase in PHASES {
            let cfa = Cfa::parse(phase).expect("a Bayer phase");
            let mosaic = mosaic(&cfa, n, n, plate);
            let psnr = |planes: &dyn Fn(usize, usize) -> f32| {
                let inside = MARGIN..n - MARGIN;
                let mut squares = 0.0;
                for y in inside.clone() {
                    for x in inside.clone() {
                        for c in 0..3 {
                            let error = f64::from(planes(c, y * n + x)) - plate(c, x as f64, y as f64);
                            squares += error * error;
                        }
                    }
                }
                -10.0 * (squares / (3 * inside.len() * inside.len()) as f64).log10()
            };
            let planes = demosaic(&mosaic, n, n, &cfa);
            let ours = psnr(&|c, i| planes.channels()[c].data[i]);
            let bilinear = psnr(&|c, i| bilinear(&mosaic, n, &cfa, c, i));
            println!("{phase}: {ours:.2} dB, bilinear {bilinear:.2} dB");
            assert!(ours > bilinear + 8.0, "{phase}: {ours:.2} dB, bilinear {bilinear:.2} dB");
        }
    }

    /// The mean of the neighbours (3 × 3) that see the channel, weighted by 4, 2, 1.
    fn bilinear(mosaic: &[f32], n: usize, cfa: &Cfa, channel: usize, i: usize) -> f32 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dy, dx) in (0..9).map(|k| (k / 3, k % 3)) {
            let (x, y) = (i % n + dx - 1, i / n + dy - 1);
            if cfa.channel_at(x, y) == channel {
                let weight = if dx == 1 { 2.0 } else { 1.0 } * if dy == 1 { 2.0 } else { 1.0 };
                sum += weight * mosaic[y * n + x];
                weights += weight;
            }
        }
        if cfa.channel_at(i % n, i / n) == channel { mosaic[i] } else { sum / weights }
    }

    #[test]
    fn images_of_any_size_are_filled() {
        for phase in PHASES {
            let cfa = Cfa::parse(phase).expect("a Bayer phase");
            for (width, height) in [(2, 2), (3, 2), (2, 5), (7, 7), (TILE_COLUMNS + 1, 3), (3, TILE_ROWS + 1)] {
                let planes = demosaic(&vec![0.25; width * height], width, height, &cfa);
                for channel in planes.channels() {
                    assert!(channel.data.iter().all(|v| (v - 0.25).abs() < 1e-6), "{phase} {width} × {height}");
                }
            }
            for (width, height) in [(0, 0), (0, 3), (3, 0), (1, 1), (1, 9), (9, 1)] {
                let planes = demosaic(&vec![0.25; width * height], width, height, &cfa);
                assert!(planes.channels().iter().all(|c| c.data.len() == width * height));
            }
        }
    }
}
