//! Highlights: what becomes of pixels that are full in one channel and not in another.
//!
//! After white balance channels are full at different levels: the most sensitive at 1, the others above. A full pixel
//! only tells that its channel was at least so bright, so that white walls would turn into the colour of the balance.

use rayon::prelude::*;

use photosite_core::rows::for_each_value;

use super::choices::Highlights;
use photosite_core::image::Planes;

/// The level that no channel may pass before demosaicking.
pub(super) fn ceiling(highlights: Highlights) -> f32 {
    match highlights {
        // Clipped to what the most sensitive channel can tell, blown highlights are white. Before demosaicking, so that
        // their edges are, too.
        Highlights::Clip => 1.0,
        Highlights::Blend | Highlights::Reconstruct | Highlights::None => f32::INFINITY,
    }
}

/// A part of its level from which on a channel counts as full, since noise takes some full pixels below.
const FULL: f32 = 0.98;

/// Mends pixels of a demosaicked, white-balanced image whose channels are full at 1 over the response to white.
pub(super) fn recover(image: &mut Planes, neutral: &[f64], highlights: Highlights) {
    let levels: Vec<f32> = neutral.iter().map(|n| (1.0 / n) as f32).collect();
    match highlights {
        Highlights::Clip => clip(image),
        Highlights::None => {}
        Highlights::Blend => blend(image),
        Highlights::Reconstruct => reconstruct(image, &levels),
    }
}

/// Demosaicking may have overshot white, which is 1 in all channels; it would become a colour.
fn clip(image: &mut Planes) {
    for channel in image.channels_mut() {
        for_each_value(&mut channel.data, |value| *value = value.min(1.0));
    }
}

/// Brightness of the unclipped colour, with the distance from grey that the clipped one has: v = m + (u − m)·|c − m_c|
/// /
/// |u − m|, of which u is the pixel, c the same clipped at 1, m and m_c their means over the channels.
fn blend(image: &mut Planes) {
    for_pixels(image, |_, pixel| {
        if pixel.iter().all(|v| *v <= 1.0) {
            return;
        }
        let n = pixel.len() as f32;
        let mean = pixel.iter().sum::<f32>() / n;
        let clipped_mean = pixel.iter().map(|v| v.min(1.0)).sum::<f32>() / n;
        let spread = pixel.iter().map(|v| (v - mean).powi(2)).sum::<f32>();
        let clipped_spread = pixel.iter().map(|v| (v.min(1.0) - clipped_mean).powi(2)).sum::<f32>();
        let part = if spread > 0.0 { (clipped_spread / spread).sqrt().min(1.0) } else { 0.0 };
        pixel.iter_mut().for_each(|v| *v = mean + (*v - mean) * part);
    });
}

/// Pixels along a cell of the map of colours.
const CELL: usize = 16;

/// Full channels take the value that the others predict by the ratio of channels nearby, at least their level. Where
/// all are full, white of the highest level is all that can be said.
fn reconstruct(image: &mut Planes, levels: &[f32]) {
    let (width, channels) = (image.width(), image.channels().len());
    let colours = surrounding_colours(image, levels);
    let cells = width.div_ceil(CELL);
    let brightest = levels.iter().copied().fold(1.0, f32::max);
    for_pixels(image, |i, pixel| {
        let mut is_full = [false; 16];
        let count = (0..channels).filter(|&c| {
            is_full[c] = pixel[c] >= FULL * levels[c];
            is_full[c]
        });
        let count = count.count();
        if count == channels {
            pixel.fill(brightest);
        } else if count > 0 {
            let cell = (i / width / CELL) * cells + i % width / CELL;
            let colour = &colours[cell * channels..(cell + 1) * channels];
            let seen = |c: &usize| !is_full[*c] && colour[*c] > 0.0;
            let scale = (0..channels).filter(seen).map(|c| pixel[c] / colour[c]).sum::<f32>()
                / (0..channels).filter(seen).count().max(1) as f32;
            for c in (0..channels).filter(|&c| is_full[c]) {
                pixel[c] = pixel[c].max(scale * colour[c]);
            }
        }
    });
}

/// Mean colour of the bright pixels of each cell that are full in no channel, or of the nearest cells that have such;
/// grey where there are none at all.
fn surrounding_colours(image: &Planes, levels: &[f32]) -> Vec<f32> {
    let (width, height, channels) = (image.width(), image.height(), image.channels().len());
    let (columns, rows) = (width.div_ceil(CELL), height.div_ceil(CELL));
    let of_cell = |cell: usize| {
        let mut sum = vec![0.0; channels + 1];
        for y in (cell / columns * CELL..height).take(CELL) {
            for x in (cell % columns * CELL..width).take(CELL) {
                let value = |c: usize| image.channels()[c].data[y * width + x];
                let bright = (0..channels).any(|c| value(c) > 0.3);
                if bright && (0..channels).all(|c| value(c) < FULL * levels[c]) {
                    (0..channels).for_each(|c| sum[c] += value(c));
                    sum[channels] += 1.0;
                }
            }
        }
        sum
    };
    let mut cells: Vec<Vec<f32>> = (0..columns * rows).into_par_iter().map(of_cell).collect();
    // Cells without such pixels take the sum of their neighbours, until every cell has some.
    while cells.iter().any(|cell| cell[channels] == 0.0) && cells.iter().any(|cell| cell[channels] > 0.0) {
        let before = cells.clone();
        for (i, cell) in cells.iter_mut().enumerate().filter(|(_, cell)| cell[channels] == 0.0) {
            for y in (i / columns).saturating_sub(1)..(i / columns + 2).min(rows) {
                for x in (i % columns).saturating_sub(1)..(i % columns + 2).min(columns) {
                    cell.iter_mut().zip(&before[y * columns + x]).for_each(|(sum, more)| *sum += more);
                }
            }
        }
    }
    cells
        .iter()
        .flat_map(|cell| {
            let count = cell[channels];
            (0..channels).map(move |c| if count > 0.0 { cell[c] / count } else { 1.0 })
        })
        .collect()
}

/// Changes every pixel, given its number and its values.
fn for_pixels(image: &mut Planes, change: impl Fn(usize, &mut [f32]) + Sync) {
    let (width, channels) = (image.width().max(1), image.channels().len());
    let mut rows: Vec<Vec<&mut [f32]>> = Vec::new();
    for channel in image.channels_mut() {
        for (y, row) in channel.data.chunks_mut(width).enumerate() {
            if rows.len() == y {
                rows.push(Vec::with_capacity(channels));
            }
            rows[y].push(row);
        }
    }
    rows.par_iter_mut().enumerate().for_each(|(y, planes)| {
        let mut pixel = vec![0.0; channels];
        for x in 0..width {
            pixel.iter_mut().zip(planes.iter()).for_each(|(value, plane)| *value = plane[x]);
            change(y * width + x, &mut pixel);
            planes.iter_mut().zip(&pixel).for_each(|(plane, value)| plane[x] = *value);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::image::Channel;

    fn image(pixels: &[[f32; 3]]) -> Planes {
        let plane = |c: usize| Channel { name: "RGB"[c..=c].to_owned(), data: pixels.iter().map(|p| p[c]).collect() };
        Planes::new(pixels.len(), 1, (0..3).map(plane).collect()).expect("right sizes")
    }

    fn recovered(pixels: &[[f32; 3]], highlights: Highlights) -> Vec<[f32; 3]> {
        let mut image = image(pixels);
        // Full at 2, 1 and 1.6.
        recover(&mut image, &[0.5, 1.0, 0.625], highlights);
        (0..pixels.len()).map(|i| [0, 1, 2].map(|c| image.channels()[c].data[i])).collect()
    }

    #[test]
    fn what_is_not_full_stays() {
        let pixels = [[0.2, 0.5, 0.7], [0.9, 0.1, 0.3]];
        for highlights in [Highlights::Clip, Highlights::Blend, Highlights::Reconstruct, Highlights::None] {
            assert_eq!(recovered(&pixels, highlights), pixels);
        }
    }

    #[test]
    fn full_white_stays_without_colour() {
        let full = [[2.0, 1.0, 1.6]];
        assert_eq!(recovered(&full, Highlights::Clip), [[1.0; 3]]);
        assert_eq!(recovered(&full, Highlights::Reconstruct), [[2.0; 3]]);
        let [blended] = recovered(&full, Highlights::Blend)[..] else { panic!("one pixel") };
        assert!(blended.iter().all(|v| (v - 4.6 / 3.0).abs() < 1e-6), "grey of their mean: {blended:?}");
    }

    #[test]
    fn a_full_channel_follows_its_neighbours_colour() {
        // Neighbours in proportions 2 : 3 : 1; red and blue tell that green, full at 1, was 1.5.
        let found = recovered(&[[0.4, 0.6, 0.2], [1.0, 1.0, 0.5]], Highlights::Reconstruct);
        assert!((found[1][1] - 1.5).abs() < 1e-6 && found[1][0] == 1.0, "{found:?}");
    }
}
