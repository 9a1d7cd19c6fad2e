//! Bilinear interpolation corrected by the curvature of the pixel's own channel, for Bayer mosaics
//! ([Malvar04](photosite_core::references#malvar04)): what the mean of the neighbours lacks of a bend, the pixel's own
//! channel, which bends alike, tells. At the edges the mosaic is mirrored.

use rayon::prelude::*;

use super::channels::{planes, together};
use crate::window::mirror;
use photosite_core::image::Planes;
use photosite_raw::Cfa;

/// Pixels around a pixel that its result depends on.
const MARGIN: usize = 2;

/// Planes R, G and B; measured values stay.
pub(super) fn demosaic(mosaic: &[f32], width: usize, height: usize, cfa: &Cfa) -> Planes {
    let padded_width = width + 2 * MARGIN;
    // Five rows at a time, with their margins.
    let mut channels = planes(width, height, cfa);
    let [red, green, blue] = &mut channels[..] else { return together(width, height, channels) };
    let chunk = width.max(1);
    let rows =
        red.data.par_chunks_mut(chunk).zip(green.data.par_chunks_mut(chunk)).zip(blue.data.par_chunks_mut(chunk));
    rows.enumerate().for_each_init(
        || vec![0.0; 5 * padded_width],
        |lines, (y, ((red, green), blue))| {
            for (k, line) in lines.chunks_exact_mut(padded_width).enumerate() {
                let from = &mosaic[mirror(y + k, MARGIN, height) * width..][..width];
                line[MARGIN..MARGIN + width].copy_from_slice(from);
                for i in [0, 1, width + MARGIN, width + MARGIN + 1] {
                    line[i] = from[mirror(i, MARGIN, width)];
                }
            }
            let line = |k: usize| &lines[k * padded_width..][..padded_width];
            let lines = [line(0), line(1), line(2), line(3), line(4)];
            for x in 0..width {
                let own = cfa.channel_at(x, y);
                let here = lines[2][x + 2];
                if own == 1 {
                    let beside = cfa.channel_at(x + 1, y);
                    let along_row = at_green(&lines, x, false);
                    let along_column = at_green(&lines, x, true);
                    green[x] = here;
                    (red[x], blue[x]) = if beside == 0 { (along_row, along_column) } else { (along_column, along_row) };
                } else {
                    green[x] = green_at_coloured(&lines, x);
                    let other = other_at_coloured(&lines, x);
                    (red[x], blue[x]) = if own == 0 { (here, other) } else { (other, here) };
                }
            }
        },
    );
    together(width, height, channels)
}

/// Fig. 2 of the paper, first column: green at red and blue.
#[inline]
fn green_at_coloured(m: &[&[f32]; 5], x: usize) -> f32 {
    let crossed = m[1][x + 2] + m[3][x + 2] + m[2][x + 1] + m[2][x + 3];
    let far = m[0][x + 2] + m[4][x + 2] + m[2][x] + m[2][x + 4];
    (4.0 * m[2][x + 2] + 2.0 * crossed - far) * 0.125
}

/// Red or blue at green, with pixels of that colour beside it in its row, or in its column.
#[inline]
fn at_green(m: &[&[f32]; 5], x: usize, in_column: bool) -> f32 {
    let row = [m[2][x], m[2][x + 1], m[2][x + 3], m[2][x + 4]];
    let column = [m[0][x + 2], m[1][x + 2], m[3][x + 2], m[4][x + 2]];
    let (along, across) = if in_column { (column, row) } else { (row, column) };
    let diagonal = m[1][x + 1] + m[1][x + 3] + m[3][x + 1] + m[3][x + 3];
    (5.0 * m[2][x + 2] + 4.0 * (along[1] + along[2]) - diagonal - along[0] - along[3] + 0.5 * (across[0] + across[3]))
        * 0.125
}

/// Blue at red and red at blue.
#[inline]
fn other_at_coloured(m: &[&[f32]; 5], x: usize) -> f32 {
    let diagonal = m[1][x + 1] + m[1][x + 3] + m[3][x + 1] + m[3][x + 3];
    let far = m[0][x + 2] + m[4][x + 2] + m[2][x] + m[2][x + 4];
    (6.0 * m[2][x + 2] + 2.0 * diagonal - 1.5 * far) * 0.125
}
