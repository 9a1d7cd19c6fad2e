//! Defective pixels: hot, dead and stuck ones take the median of their neighbours.

use rayon::prelude::*;

use super::choices::Defects;
use super::neighbours::{Step, steps};
use photosite_raw::Cfa;

/// Neighbours of the same channel that a pixel is compared with.
const NEIGHBOURS: usize = 8;
/// Least distance of a defective pixel from the range of its neighbours, as a part of full scale.
const FLOOR: f32 = 0.02;

/// Replaces pixels of a mosaic that lie further outside the range of their 8 nearest neighbours of the same channel
/// than that range is wide, and at least 2 % of full scale. An edge or a line of light has neighbours like itself; a
/// star of a single pixel has none, which is why nothing is replaced unasked.
pub(super) fn correct(mosaic: &mut Vec<f32>, size: [usize; 2], cfa: &Cfa, defects: Defects) {
    match defects {
        Defects::None => return,
        Defects::Median => {}
    }
    *mosaic = with_neighbours(mosaic, size, cfa, |i, values| {
        let value = mosaic[i];
        let (Some(&low), Some(&high)) = (values.first(), values.last()) else { return value };
        let margin = (high - low).max(FLOOR);
        let is_defect = value < low - margin || value > high + margin;
        if is_defect { median(values) } else { value }
    });
}

/// Replaces pixels of a mosaic that are known to be defective by the median of those of the 8 nearest neighbours of the
/// same channel that are not; where all are, they stay.
pub(super) fn replace(mosaic: &mut Vec<f32>, size: [usize; 2], cfa: &Cfa, is_bad: &[bool]) {
    // Neighbours that are not numbers do not count.
    let known: Vec<f32> = mosaic.iter().zip(is_bad).map(|(value, bad)| if *bad { f32::NAN } else { *value }).collect();
    *mosaic =
        with_neighbours(
            &known,
            size,
            cfa,
            |i, values| {
                if is_bad[i] && !values.is_empty() { median(values) } else { mosaic[i] }
            },
        );
}

fn median(sorted: &[f32]) -> f32 {
    0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2])
}

/// A value for each number of a mosaic, from its index and the sorted values of its nearest neighbours.
fn with_neighbours(
    before: &[f32],
    [width, height]: [usize; 2],
    cfa: &Cfa,
    value: impl Fn(usize, &[f32]) -> f32 + Sync,
) -> Vec<f32> {
    let samples = cfa.samples_per_pixel();
    let (columns, rows) = cfa.tile_size();
    let radius = 2 * columns.max(rows);
    // Of a full layout every pixel has the channel.
    let near = |i: usize| -> Vec<Step> {
        let (place, whole) = ([i % columns, i / columns], Cfa::mono());
        let (cfa, place, channel) =
            if cfa.is_full() { (&whole, [0, 0], 0) } else { (cfa, place, cfa.channel_at(place[0], place[1])) };
        let others = steps(cfa, place, channel, radius).into_iter().filter(|s| (s.dx, s.dy) != (0, 0));
        others.take(NEIGHBOURS).collect()
    };
    let near: Vec<Vec<Step>> = (0..columns * rows).map(near).collect();
    let (near, value) = (&near, &value);
    let corrected = (0..height).into_par_iter().flat_map_iter(|y| {
        (0..width * samples).map(move |i| {
            let (x, sample) = (i / samples, i % samples);
            let at = |x: usize, y: usize| before[(y * width + x) * samples + sample];
            let mut values = [0.0; NEIGHBOURS];
            let mut count = 0;
            for (nx, ny) in near[y % rows * columns + i % columns].iter().filter_map(|s| s.from(x, y, [width, height]))
            {
                values[count] = at(nx, ny);
                count += usize::from(!values[count].is_nan());
            }
            let values = &mut values[..count];
            values.sort_unstable_by(f32::total_cmp);
            value(y * width * samples + i, values)
        })
    });
    corrected.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_pixels_are_mended_and_edges_and_lines_stay() {
        for text in ["RGGB", "x-trans", "mono", "full:RGB"] {
            let cfa = Cfa::parse(text).expect("known");
            let samples = cfa.samples_per_pixel();
            let (width, height) = (48, 20);
            // An edge at column 36 and a bright column 4, with differing channels.
            let scene = |x: usize, _: usize| if x >= 36 || x == 4 { 0.8 } else { 0.1 };
            let clean: Vec<f32> =
                (0..width * samples * height).map(|i| scene(i / samples % width, i / samples / width)).collect();
            let mut mosaic = clean.clone();
            let hot = [7 * width + 20, 15 * width + 43].map(|i| i * samples);
            mosaic[hot[0]] = 1.0;
            mosaic[hot[1]] = 0.0;
            correct(&mut mosaic, [width, height], &cfa, Defects::Median);
            let lines = |i: usize| i / samples % width < 7;
            for (i, (found, clean)) in mosaic.iter().zip(&clean).enumerate() {
                // A line of one pixel is half gone in a mosaic; only Bayer's every other row keeps all of it.
                assert!(found == clean || (lines(i) && text == "x-trans"), "{text}: {i} {found} {clean}");
            }
        }
    }
}
