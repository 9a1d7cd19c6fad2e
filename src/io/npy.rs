//! Planes as NumPy arrays.

use std::io::{self, Write};

use npyz::{AutoSerialize, WriterBuilder};

/// Writes planes of so many columns and rows as an array of shape (rows, columns), or (rows, columns, planes) where
/// there are several, each value as what `number` makes of it.
pub fn write_planes<V: Copy, T: AutoSerialize, W: Write>(
    [width, height]: [usize; 2],
    planes: &[&[V]],
    number: impl Fn(V) -> T,
    to: W,
) -> io::Result<()> {
    let shape = [height, width, planes.len()].map(|n| n as u64);
    let shape = if planes.len() == 1 { &shape[..2] } else { &shape[..] };
    let mut array = npyz::WriteOptions::new().default_dtype().shape(shape).writer(to).begin_nd()?;
    array.extend((0..width * height).flat_map(|i| planes.iter().map(move |plane| plane[i])).map(number))?;
    array.finish()
}
