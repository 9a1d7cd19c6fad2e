//! The bilateral filter ([Tomasi98](photosite_core::references#tomasi98)): a mean weighted by nearness, and by likeness
//! within noise.
//!
//! w = exp(−|Δ|²/(2σ_s²)) · exp(−d²/(2σ_r²)), with d² the mean over the channels of the squared difference in standard
//! deviations of noise, σ_s a third of the radius plus ½, and σ_r = 3·strength: the difference of two pixels of one
//! value has a standard deviation of √2.

use rayon::prelude::*;

pub(super) fn filter(planes: &[Vec<f32>], [width, height]: [usize; 2], radius: usize, strength: f32) -> Vec<Vec<f32>> {
    let sigma = radius as f32 / 3.0 + 0.5;
    let range = -0.5 / (3.0 * strength).powi(2) / planes.len() as f32;
    let r = radius as isize;
    let near = |dx: isize, dy: isize| (-0.5 * (dx * dx + dy * dy) as f32 / (sigma * sigma)).exp();
    let window: Vec<(isize, isize, f32)> =
        (-r..=r).flat_map(|dy| (-r..=r).map(move |dx| (dx, dy, near(dx, dy)))).collect();
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
            for &(dx, dy, near) in &window {
                let (Some(x), Some(y)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else { continue };
                if x >= width || y >= height {
                    continue;
                }
                let j = y * width + x;
                let square: f32 = planes.iter().map(|plane| (plane[j] - plane[i]).powi(2)).sum();
                let weight = near * (square * range).exp();
                weights += weight;
                sums.iter_mut().zip(planes).for_each(|(sum, plane)| *sum += weight * plane[j]);
            }
            to.iter_mut().zip(&sums).for_each(|(row, sum)| row[x] = sum / weights);
        }
    });
    result
}
