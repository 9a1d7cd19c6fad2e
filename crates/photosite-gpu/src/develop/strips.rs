//! Strips of rows that an image is developed in, one after the other, so that planes of any image have room on a card
//! and no kernel runs long.

use std::ops::Range;

use photosite_core::Invalid;
use photosite_develop::packed::PackedDevelopment;
use photosite_raw::{Orientation, PixelArea};

/// Bytes of a pixel in the largest buffer of a strip: three planes.
const BYTES_PER_PIXEL: u64 = 12;

/// Rows of an image that are developed together.
#[derive(Clone, Debug)]
pub(crate) struct Strip {
    /// First row in the active area.
    pub(crate) top: usize,
    /// Rows without the margin.
    pub(crate) rows: usize,
    /// Columns and rows with the margin.
    pub(crate) padded: [usize; 2],
    /// Raw numbers that the strip depends on, from an even one on.
    pub(crate) numbers: Range<usize>,
    /// Index of the first number of the active area among those that are on the card, modulo 2³².
    pub(crate) first_number: u32,
    /// Columns and rows of the strip in the image.
    pub(crate) turned: [usize; 2],
    /// Column and row of the image that the strip begins at.
    pub(crate) corner: [usize; 2],
    /// Pixels of the strip that stand at those of the image.
    pub(crate) turn: Turn,
}

/// Map from pixels of an image that stands upright to those of a stored one: first + x·right + y·down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn {
    pub(crate) first: [i32; 2],
    pub(crate) right: [i32; 2],
    pub(crate) down: [i32; 2],
}

impl Turn {
    /// Turn of a part of an image that begins at a column.
    fn new(orientation: Orientation, size: [usize; 2], column: usize) -> Self {
        let at = |place: [usize; 2], size: [usize; 2]| orientation.source(place, size).map(|i| i as i32);
        // Steps are those of the smallest image that has all of them
        let corner = at([0, 0], [2, 2]);
        let step = |to: [i32; 2]| [to[0] - corner[0], to[1] - corner[1]];
        let [x, y] = at([0, 0], size);
        Self { first: [x + column as i32, y], right: step(at([1, 0], [2, 2])), down: step(at([0, 1], [2, 2])) }
    }
}

/// Strips of an image, of so many pixels with their margin at most.
///
/// # Errors
///
/// Rows that are too long for a strip.
pub(crate) fn strips(of: &PackedDevelopment, most_bytes: u64, most_pixels: usize) -> Result<Vec<Strip>, Invalid> {
    let margin = of.demosaicking.margin();
    let columns = of.active.width + 2 * margin;
    let most_pixels = most_pixels.min((most_bytes / BYTES_PER_PIXEL) as usize);
    // Cards start no more workgroups along an axis, and each has a row at least.
    let most_rows = (most_pixels / columns.max(1)).saturating_sub(2 * margin).min(65_535 - 2 * margin);
    if most_rows == 0 {
        let message =
            format!("rows of {columns} pixels are too long for a table of {most_bytes} bytes, the largest there");
        return Err(Invalid::new("develop", message).help("develop with --device cpu"));
    }
    let PixelArea { x: column, y, width, height } = of.shown;
    let tops = (y..y + height).step_by(most_rows);
    Ok(tops
        .map(|top| {
            let rows = most_rows.min(y + height - top);
            let numbers = numbers(of, top.saturating_sub(margin)..(top + rows + margin).min(of.active.height));
            let active = of.samples * (of.active.y * of.stored_px[0] + of.active.x);
            let turn = Turn::new(of.orientation, [width, rows], column);
            Strip {
                top,
                rows,
                padded: [columns, rows + 2 * margin],
                first_number: (active as u32).wrapping_sub(numbers.start as u32),
                numbers,
                turned: of.orientation.turned([width, rows]),
                corner: corner(&turn, top - y, height - rows - (top - y)),
                turn,
            }
        })
        .collect())
}

/// Raw numbers of some rows of the active area, from an even one on.
fn numbers(of: &PackedDevelopment, rows: Range<usize>) -> Range<usize> {
    let row_length = of.samples * of.stored_px[0];
    let at = |row: usize, x: usize| (of.active.y + row) * row_length + of.samples * x;
    let start = at(rows.start, of.active.x);
    start / 2 * 2..at(rows.end - 1, of.active.x + of.active.width)
}

/// Column and row of the image that a strip begins at, with so many rows of the stored image before it and behind it.
fn corner(turn: &Turn, before: usize, behind: usize) -> [usize; 2] {
    // Along the side of the image that the stored rows lie along
    let from = |step: i32| match step {
        0 => 0,
        1 => before,
        _ => behind,
    };
    [from(turn.right[1]), from(turn.down[1])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_lead_to_the_pixels_that_orientations_name() {
        for number in 1..=8u8 {
            let orientation = Orientation::of_number(number.into()).expect("one of eight");
            for size in [[1, 1], [1, 4], [5, 1], [5, 4]] {
                let [columns, rows] = orientation.turned(size);
                let turn = Turn::new(orientation, size, 7);
                for (x, y) in (0..columns).flat_map(|x| (0..rows).map(move |y| (x, y))) {
                    let found =
                        [0, 1].map(|axis| turn.first[axis] + x as i32 * turn.right[axis] + y as i32 * turn.down[axis]);
                    let [column, row] = orientation.source([x, y], size);
                    assert_eq!(found, [column as i32 + 7, row as i32], "{number}: {x}, {y} of {size:?}");
                }
            }
        }
    }
}
