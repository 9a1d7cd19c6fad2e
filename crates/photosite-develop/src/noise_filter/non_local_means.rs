//! Non-local means ([Buades05](photosite_core::references#buades05)): a mean of the pixels of a window, weighted by how
//! alike their surroundings of 3 × 3 pixels look.
//!
//! w = exp(−max(d² − 2, 0)/h²) with d² the mean over surroundings and channels of the squared difference in standard
//! deviations of noise, which is 2 between surroundings that differ by noise alone, and h² = strength².
//! Differences are computed offset by offset, so that each is taken once and not once a patch.

use rayon::prelude::*;

/// Pixels around a pixel that count as its surroundings.
const PATCH: usize = 1;
/// Rows that a thread works on at a time.
const BAND: usize = 32;

pub(super) fn filter(planes: &[Vec<f32>], [width, height]: [usize; 2], radius: usize, strength: f32) -> Vec<Vec<f32>> {
    let r = radius as isize;
    let offsets: Vec<(isize, isize)> = (-r..=r).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy))).collect();
    let starts: Vec<usize> = (0..height).step_by(BAND).collect();
    let band = |&top: &usize| {
        let rows = BAND.min(height - top);
        let mut sums = vec![vec![0.0f32; width * rows]; planes.len()];
        let mut weights = vec![0.0f32; width * rows];
        // Squared differences of the band's rows and of those that patches reach beyond it.
        let first = top.saturating_sub(PATCH);
        let last = (top + rows + PATCH).min(height);
        let mut squares = vec![0.0f32; width * (last - first)];
        let mut across = vec![0.0f32; width * (last - first)];
        for &(dx, dy) in &offsets {
            let at = |x: usize, y: usize| {
                let x = x.saturating_add_signed(dx).min(width - 1);
                let y = y.saturating_add_signed(dy).min(height - 1);
                y * width + x
            };
            for y in first..last {
                for x in 0..width {
                    let (i, j) = (y * width + x, at(x, y));
                    let square: f32 = planes.iter().map(|plane| (plane[i] - plane[j]).powi(2)).sum();
                    squares[(y - first) * width + x] = square / planes.len() as f32;
                }
            }
            for (to, from) in across.chunks_exact_mut(width).zip(squares.chunks_exact(width)) {
                for (x, to) in to.iter_mut().enumerate() {
                    let (a, b) = (x.saturating_sub(PATCH), (x + PATCH + 1).min(width));
                    *to = from[a..b].iter().sum::<f32>() / (b - a) as f32;
                }
            }
            for y in top..top + rows {
                let (a, b) = (y.saturating_sub(PATCH).max(first), (y + PATCH + 1).min(last));
                for x in 0..width {
                    // A pixel beyond the edge is none.
                    let inside = x.checked_add_signed(dx).is_some_and(|x| x < width)
                        && y.checked_add_signed(dy).is_some_and(|y| y < height);
                    if !inside {
                        continue;
                    }
                    let distance = (a..b).map(|y| across[(y - first) * width + x]).sum::<f32>() / (b - a) as f32;
                    let weight =
                        if (dx, dy) == (0, 0) { 1.0 } else { (-(distance - 2.0).max(0.0) / strength.powi(2)).exp() };
                    let (i, j) = ((y - top) * width + x, at(x, y));
                    weights[i] += weight;
                    sums.iter_mut().zip(planes).for_each(|(sum, plane)| sum[i] += weight * plane[j]);
                }
            }
        }
        for sum in &mut sums {
            sum.iter_mut().zip(&weights).for_each(|(sum, weight)| *sum /= weight);
        }
        sums
    };
    let bands: Vec<Vec<Vec<f32>>> = starts.par_iter().map(band).collect();
    (0..planes.len()).map(|c| bands.iter().flat_map(|band| band[c].iter().copied()).collect()).collect()
}
