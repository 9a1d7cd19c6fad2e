//! The median of a square window, cut off at the edges of the image.

use rayon::prelude::*;

pub(super) fn filter(plane: &[f32], [width, height]: [usize; 2], radius: usize) -> Vec<f32> {
    let mut result = vec![0.0; plane.len()];
    let side = 2 * radius + 1;
    let rows = result.par_chunks_mut(width.max(1)).enumerate();
    rows.for_each_init(
        || Vec::with_capacity(side * side),
        |window, (y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                window.clear();
                for y in y.saturating_sub(radius)..(y + radius + 1).min(height) {
                    let (first, last) = (x.saturating_sub(radius), (x + radius + 1).min(width));
                    window.extend_from_slice(&plane[y * width + first..y * width + last]);
                }
                let middle = window.len() / 2;
                *value = *window.select_nth_unstable_by(middle, f32::total_cmp).1;
            }
        },
    );
    result
}
