//! The mean of a square window.

use crate::window::separable;

pub(super) fn filter(plane: &[f32], size: [usize; 2], radius: usize) -> Vec<f32> {
    let n = 2 * radius + 1;
    separable(plane, size, [&vec![1.0 / n as f32; n]; 2])
}
