//! Rows and values of planes, changed side by side: what shares them among threads is compiled once for each kind of
//! number, as what changes a row is called through a pointer. (Each loop of its own compiles 4000 lines of LLVM's code.)

use rayon::prelude::*;

/// Changes all rows, in any order. `change` gets the number of a row from the top, too.
pub fn for_each_row<T: Send>(values: &mut [T], width: usize, change: impl Fn(usize, &mut [T]) + Sync) {
    each_row(values, width.max(1), &change);
}

fn each_row<T: Send>(values: &mut [T], width: usize, change: &(dyn Fn(usize, &mut [T]) + Sync)) {
    values.par_chunks_mut(width).enumerate().for_each(|(y, row)| change(y, row));
}

/// Values that one thread changes one after the other.
const BLOCK: usize = 4096;

/// Changes all values, in any order.
pub fn for_each_value(values: &mut [f32], change: impl Fn(&mut f32) + Sync) {
    for_each_row(values, BLOCK, |_, block| block.iter_mut().for_each(&change));
}

/// A number of values, by their places.
pub fn values(count: usize, value: impl Fn(usize) -> f32 + Sync) -> Vec<f32> {
    let mut values = vec![0.0; count];
    for_each_row(&mut values, BLOCK, |block, to| {
        to.iter_mut().enumerate().for_each(|(i, to)| *to = value(block * BLOCK + i));
    });
    values
}
