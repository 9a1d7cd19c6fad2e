//! Distortion: moves every pixel to where a lens without distortion would show it.

use rayon::prelude::*;

use crate::image::{Channel, Planes};
use crate::raw::Warp;

/// Resamples every plane by Catmull–Rom splines ([Catmull74](crate::references#catmull74)) at the places that the warp
/// names; what lies beyond the edge of the distorted picture takes its nearest pixel.
pub(super) fn correct(picture: Planes, warp: Option<&Warp>) -> Planes {
    let Some(warp) = warp else { return picture };
    let size = [picture.width(), picture.height()];
    let [width, height] = size;
    let corrected = |channel: &Channel| {
        let mut data = vec![0.0; width * height];
        data.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                *value = sample(&channel.data, size, warp.source_px([x as f64, y as f64], size));
            }
        });
        Channel { name: channel.name.clone(), data }
    };
    let channels = picture.channels().iter().map(corrected).collect();
    Planes::new(width, height, channels).expect("planes keep their size")
}

/// The value at a place between pixels, whose centres have integer coordinates.
fn sample(plane: &[f32], [width, height]: [usize; 2], [x, y]: [f64; 2]) -> f32 {
    let (left, weights_x) = taps(x);
    let (top, weights_y) = taps(y);
    let clamped = |i: i64, n: usize| i.clamp(0, n as i64 - 1) as usize;
    let mut sum = 0.0;
    for (k, weight_y) in (0..).zip(weights_y) {
        let row = &plane[clamped(top + k, height) * width..][..width];
        let along: f32 = (0..).zip(weights_x).map(|(k, weight)| weight * row[clamped(left + k, width)]).sum();
        sum += weight_y * along;
    }
    sum
}

/// The first of four pixels around a place, and their weights.
fn taps(place: f64) -> (i64, [f32; 4]) {
    // A warp that a damaged file gives may lead anywhere; a cast keeps it within the integers.
    let first = place.floor().clamp(-1e9, 1e9);
    let t = (place - first).clamp(0.0, 1.0) as f32;
    let weights = [
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    ];
    (first as i64 - 1, weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(value: impl Fn(f64, f64) -> f64) -> Planes {
        let data = (0..60 * 40).map(|i| value((i % 60) as f64, (i / 60) as f64) as f32).collect();
        Planes::new(60, 40, vec![Channel { name: "Y".to_owned(), data }]).expect("right size")
    }

    #[test]
    fn pixels_come_from_where_the_warp_says() {
        let warp = Warp { radial: [1.0, -0.08, 0.02, 0.0], tangential: [0.002, -0.001], centre: [0.48, 0.53] };
        // Catmull–Rom splines reproduce parabolas exactly.
        let value = |x: f64, y: f64| 0.2 + 0.01 * x - 0.005 * y + 1e-4 * x * x - 5e-5 * x * y;
        let found = correct(plane(value), Some(&warp));
        for y in 6..34 {
            for x in 6..54 {
                let [sx, sy] = warp.source_px([x as f64, y as f64], [60, 40]);
                let error = f64::from(found.channels()[0].data[y * 60 + x]) - value(sx, sy);
                // Sixteen products in f32 of values below 1.
                assert!(error.abs() < 2e-6, "{x}, {y}: {error}");
            }
        }
        let same = plane(value);
        let none = Warp { radial: [1.0, 0.0, 0.0, 0.0], tangential: [0.0; 2], centre: [0.5; 2] };
        let straight = correct(same.clone(), Some(&none));
        let pairs = straight.channels()[0].data.iter().zip(&same.channels()[0].data);
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-6));
        assert_eq!(correct(same.clone(), None), same);
    }
}
