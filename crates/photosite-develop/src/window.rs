//! Windows around pixels: separable weighted means, and rows with what is beside them. At the edges the image is
//! mirrored.

use rayon::prelude::*;

use photosite_core::rows::for_each_row;

/// Weights of a Gaussian at whole pixels from −radius to radius, with a sum of 1.
pub(super) fn gaussian_weights(sigma: f64, radius: usize) -> Vec<f32> {
    let r = radius as i32;
    let weights: Vec<f64> = (-r..=r).map(|i| (-0.5 * (f64::from(i) / sigma).powi(2)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| (w / sum) as f32).collect()
}

/// Sums of a plane, weighted by `across` along rows and then by `down` along columns, both of odd lengths.
pub(super) fn separable(plane: &[f32], [width, height]: [usize; 2], [across, down]: [&[f32]; 2]) -> Vec<f32> {
    let radius = across.len() / 2;
    let mut along_rows = vec![0.0; plane.len()];
    let rows = along_rows.par_chunks_mut(width.max(1)).zip(plane.par_chunks(width.max(1)));
    // A row between its mirrored ends, so that the loop over its pixels is a plain one.
    rows.for_each_init(Vec::new, |wide, (to, from)| {
        wide.clear();
        wide.extend((0..width + 2 * radius).map(|x| from[mirror(x, radius, width)]));
        for (k, w) in across.iter().enumerate() {
            to.iter_mut().zip(&wide[k..]).for_each(|(to, from)| *to += w * from);
        }
    });
    let radius = down.len() / 2;
    let mut result = vec![0.0; plane.len()];
    for_each_row(&mut result, width, |y, to| {
        for (k, w) in down.iter().enumerate() {
            let row = &along_rows[mirror(y + k, radius, height) * width..][..width];
            to.iter_mut().zip(row).for_each(|(to, from)| *to += w * from);
        }
    });
    result
}

/// The pixel of a line of `n` that lies `margin` before `i`, after reflection at the first and last pixel, which keeps
/// even and odd apart.
#[inline]
pub(super) fn mirror(i: usize, margin: usize, n: usize) -> usize {
    if i >= margin && i - margin < n {
        return i - margin;
    }
    if n == 1 {
        return 0;
    }
    let period = 2 * (n - 1);
    // `margin` is less than `margin` periods.
    let i = (i + margin * period - margin) % period;
    i.min(period - i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirroring_keeps_even_and_odd_apart() {
        let line: Vec<usize> = (6..18).map(|i| mirror(i, 10, 4)).collect();
        assert_eq!(line, [2, 3, 2, 1, 0, 1, 2, 3, 2, 1, 0, 1]);
        assert!((0..100).all(|i| mirror(i, 10, 2) == i % 2));
    }

    #[test]
    fn smoothing_keeps_what_is_even_and_spreads_a_point() {
        let (size, sigma) = ([41, 37], 2.0);
        let weights = gaussian_weights(sigma, 6);
        let even = separable(&vec![0.3; 41 * 37], size, [&weights; 2]);
        assert!(even.iter().all(|v| (v - 0.3).abs() < 1e-6));
        let mut point = vec![0.0; 41 * 37];
        point[18 * 41 + 20] = 1.0;
        let spread = separable(&point, size, [&weights; 2]);
        let variance: f64 =
            spread.iter().enumerate().map(|(i, v)| ((i % 41) as f64 - 20.0).powi(2) * f64::from(*v)).sum();
        // Cut at three standard deviations, the variance loses 3 %.
        assert!((variance / sigma.powi(2) - 1.0).abs() < 0.04, "{variance}");
    }
}
