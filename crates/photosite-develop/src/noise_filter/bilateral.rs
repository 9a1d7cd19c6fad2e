//! The bilateral filter ([Tomasi98](photosite_core::references#tomasi98)): a mean weighted by nearness and by likeness,
//!
//! w = exp(−|Δ|²/(2σ_s²)) · exp(−d²/(2σ_r²)),
//!
//! with the distance |Δ| of two pixels and their difference d.
//!
//! | | [`by_noise`] | [`by_difference`] |
//! |---|---|---|
//! | d | root of the mean squared difference of the channels, in standard deviations of noise | sum of the channels' absolute differences |
//! | σ_r | 3·strength: the difference of two pixels of one value has a standard deviation of √2 | as given |
//! | window | a square, cut off at the edges of the image | a disk, the image mirrored at its edges |
//!
//! The second is what OpenCV's `bilateralFilter` computes.

use rayon::prelude::*;

use crate::window::mirror;

/// Tells differences from noise: those of `planes` are in its standard deviations.
pub(super) fn by_noise(
    planes: &[Vec<f32>],
    size: [usize; 2],
    radius: usize,
    sigma_px: f32,
    strength: f32,
) -> Vec<Vec<f32>> {
    let range = -0.5 / (3.0 * strength).powi(2) / planes.len() as f32;
    let inside = |i: usize, step: isize, n: usize| i.checked_add_signed(step).filter(|&i| i < n);
    let likeness = |i: usize, j: usize| {
        let square: f32 = planes.iter().map(|plane| (plane[j] - plane[i]).powi(2)).sum();
        (square * range).exp()
    };
    weighted_means(planes, size, &window(radius, sigma_px, |_, _| true), inside, likeness)
}

/// Tells differences by a standard deviation σ_r in the unit of `planes`.
pub(super) fn by_difference(
    planes: &[Vec<f32>],
    size: [usize; 2],
    radius: usize,
    sigma_px: f32,
    sigma_range: f32,
) -> Vec<Vec<f32>> {
    let range = -0.5 / sigma_range.powi(2);
    let mirrored = |i: usize, step: isize, n: usize| Some(mirror(i + radius.wrapping_add_signed(step), radius, n));
    let likeness = |i: usize, j: usize| {
        let difference: f32 = planes.iter().map(|plane| (plane[j] - plane[i]).abs()).sum();
        (difference * difference * range).exp()
    };
    let r = radius as isize;
    let disk = window(radius, sigma_px, |dx, dy| dx * dx + dy * dy <= r * r);
    weighted_means(planes, size, &disk, mirrored, likeness)
}

/// Steps to the pixels of a window with their weights by distance.
fn window(radius: usize, sigma: f32, holds: impl Fn(isize, isize) -> bool) -> Vec<(isize, isize, f32)> {
    let r = radius as isize;
    let near = |dx: isize, dy: isize| (-0.5 * (dx * dx + dy * dy) as f32 / (sigma * sigma)).exp();
    let steps = (-r..=r).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy)));
    steps.filter(|&(dx, dy)| holds(dx, dy)).map(|(dx, dy)| (dx, dy, near(dx, dy))).collect()
}

/// Means of the pixels that `neighbour` finds a step beside each, weighted by the window and by likeness.
fn weighted_means(
    planes: &[Vec<f32>],
    [width, height]: [usize; 2],
    window: &[(isize, isize, f32)],
    neighbour: impl Fn(usize, isize, usize) -> Option<usize> + Sync,
    likeness: impl Fn(usize, usize) -> f32 + Sync,
) -> Vec<Vec<f32>> {
    let mut result = vec![vec![0.0; width * height]; planes.len()];
    let mut rows: Vec<Vec<&mut [f32]>> = (0..height).map(|_| Vec::with_capacity(planes.len())).collect();
    for plane in &mut result {
        rows.iter_mut().zip(plane.chunks_mut(width.max(1))).for_each(|(rows, row)| rows.push(row));
    }
    rows.into_par_iter().enumerate().for_each(|(y, mut to)| {
        let mut sums = vec![0.0; planes.len()];
        for x in 0..width {
            let i = y * width + x;
            sums.fill(0.0);
            let mut weights = 0.0;
            for &(dx, dy, near) in window {
                let (Some(x), Some(y)) = (neighbour(x, dx, width), neighbour(y, dy, height)) else { continue };
                let j = y * width + x;
                let weight = near * likeness(i, j);
                weights += weight;
                sums.iter_mut().zip(planes).for_each(|(sum, plane)| *sum += weight * plane[j]);
            }
            to.iter_mut().zip(&sums).for_each(|(row, sum)| row[x] = sum / weights);
        }
    });
    result
}
