//! Sampling of offsets from point spread functions.
//!
//! The samples of a point spread function lie too far apart to serve as uniform squares of light: a square of the side
//! s multiplies the modulation by sinc(ν·s), 0.97 at half the limit of diffraction where four samples are as wide as
//! λ·N. The samples are therefore sharpened by −∇²/24 first, which undoes that to below 0.3 %; what falls below zero
//! then, near dark rings, is left out. Farther out squares are larger: of twice the side beyond 64 of them from the
//! middle, of four times beyond 128 and so on.

use std::borrow::Cow;

use glam::DVec2;

use crate::point_spread::PointSpread;

/// Number of cells along a side of each level.
const SIDE: usize = 128;
/// Largest number of levels: those of the largest point spread function, and some more.
const MOST_LEVELS: usize = 8;
/// Cells of a level that a finer one covers.
const INNER: std::ops::Range<usize> = SIDE / 4..SIDE - SIDE / 4;

/// Cumulative light of a whole row.
const WHOLE: u16 = u16::MAX;

/// A point spread function as cells of uniform light, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct SpreadTable {
    /// Cumulative light of the cells in each row, up to [`WHOLE`], of levels from the finest on.
    cells: Vec<u16>,
    /// Cumulative light of the rows, up to 1.
    rows: Vec<f64>,
    /// Side of the finest cells, mm.
    cell_mm: f64,
    /// Middle of the levels, mm from the chief ray's landing point.
    middle_mm: DVec2,
    /// Largest distance of landing rays from the middle, and half-width of the point spread function, mm: light that
    /// lands farther away is folded back.
    pub(crate) farthest_and_reach_mm: [f64; 2],
}

impl SpreadTable {
    /// Table of a point spread function whose size is 128 times a power of two.
    pub fn new(spread: &PointSpread) -> Self {
        let (mut energy, mut size) = (Cow::Borrowed(&spread.energy), spread.size);
        assert!(size.is_multiple_of(SIDE) && (size / SIDE).is_power_of_two(), "an image of {size} samples");
        let (mut cells, mut rows) = (Vec::new(), Vec::new());
        let mut sum = 0.0;
        loop {
            let is_finest = rows.is_empty();
            let part = sharpening(rows.len() / SIDE);
            let first = (size - SIDE) / 2;
            for row in 0..SIDE {
                let mut of_row = 0.0;
                let up_to: [f64; SIDE] = std::array::from_fn(|column| {
                    let is_covered = !is_finest && INNER.contains(&row) && INNER.contains(&column);
                    of_row +=
                        if is_covered { 0.0 } else { sharpened(&energy, size, part, [first + row, first + column]) };
                    of_row
                });
                let part = if of_row > 0.0 { f64::from(WHOLE) / of_row } else { 0.0 };
                cells.extend(up_to.map(|up_to| (part * up_to).round() as u16));
                sum += of_row;
                rows.push(sum);
            }
            if size == SIDE {
                break;
            }
            energy = Cow::Owned(halved(&energy, size));
            size /= 2;
        }
        rows.iter_mut().for_each(|up_to| *up_to /= sum);
        // The middle of sample size/2 is half a cell beyond the corner of the levels' middle.
        let cell_mm = spread.spacing_mm;
        Self {
            cells,
            rows,
            cell_mm,
            middle_mm: spread.middle_mm - 0.5 * cell_mm,
            farthest_and_reach_mm: [spread.farthest_mm, spread.reach_mm()],
        }
    }

    /// Bytes of the table.
    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        let Self { cells, rows, cell_mm, middle_mm, farthest_and_reach_mm: [farthest, reach] } = self;
        let head = [rows.len() as f64, *cell_mm, middle_mm.x, middle_mm.y, *farthest, *reach];
        let doubles = head.iter().chain(rows).flat_map(|number| number.to_le_bytes());
        doubles.chain(cells.iter().flat_map(|number| number.to_le_bytes())).collect()
    }

    /// Table at the start of some bytes, which are consumed; `None` where there is none.
    pub(crate) fn from_bytes(bytes: &mut &[u8]) -> Option<Self> {
        let mut double = || {
            let (number, rest) = bytes.split_first_chunk()?;
            *bytes = rest;
            Some(f64::from_le_bytes(*number))
        };
        let mut head = [0.0; 6];
        for number in &mut head {
            *number = double()?;
        }
        let [count, cell_mm, x, y, farthest, reach] = head;
        let count = count as usize;
        if count == 0 || !count.is_multiple_of(SIDE) || count > MOST_LEVELS * SIDE {
            return None;
        }
        let rows = (0..count).map(|_| double()).collect::<Option<Vec<_>>>()?;
        let (of_cells, rest) = bytes.split_at_checked(count * SIDE * size_of::<u16>())?;
        *bytes = rest;
        let (cells, _) = of_cells.as_chunks();
        let cells = cells.iter().map(|number| u16::from_le_bytes(*number)).collect();
        let (middle_mm, farthest_and_reach_mm) = (DVec2::new(x, y), [farthest, reach]);
        Some(Self { cells, rows, cell_mm, middle_mm, farthest_and_reach_mm })
    }

    /// Samples an offset of light from the chief ray's landing point, mm, by numbers in [0, 1).
    pub fn sample(&self, [u, v]: [f64; 2]) -> DVec2 {
        let row = self.rows.partition_point(|up_to| *up_to <= v).min(self.rows.len() - 1);
        let before = if row == 0 { 0.0 } else { self.rows[row - 1] };
        let across = rest(v, before, self.rows[row]);
        let of_row = &self.cells[row * SIDE..][..SIDE];
        let target = u * f64::from(of_row[SIDE - 1]);
        let column = of_row.partition_point(|up_to| f64::from(*up_to) <= target).min(SIDE - 1);
        let before = if column == 0 { 0.0 } else { of_row[column - 1].into() };
        let along = rest(target, before, of_row[column].into());
        let level = row / SIDE;
        let place = DVec2::new(column as f64 + along, (row % SIDE) as f64 + across) - 0.5 * SIDE as f64;
        self.middle_mm + place * (self.cell_mm * f64::from(1_u32 << level))
    }
}

/// Fraction of an interval below a number in it.
fn rest(u: f64, from: f64, to: f64) -> f64 {
    if to > from { ((u - from) / (to - from)).clamp(0.0, 1.0) } else { 0.5 }
}

/// Factor of −∇² that sharpens the cells of a level: 1/24 for its squares, and the loss by halving the levels before.
fn sharpening(level: usize) -> f64 {
    (2.0 - 0.25_f64.powi(level as i32)) / 24.0
}

/// Cell value for which a square of uniform light has the modulation of the point spread function.
fn sharpened(energy: &[f32], size: usize, part: f64, [row, column]: [usize; 2]) -> f64 {
    let at = |row: usize, column: usize| f64::from(energy[row % size * size + column % size]);
    let (below, left) = (row + size - 1, column + size - 1);
    let around = at(below, column) + at(row + 1, column) + at(row, left) + at(row, column + 1);
    (at(row, column) - part * (around - 4.0 * at(row, column))).max(0.0)
}

/// Sums of two by two cells.
fn halved(energy: &[f32], size: usize) -> Vec<f32> {
    let half = size / 2;
    let sum = |i: usize| {
        let first = i / half * 2 * size + i % half * 2;
        energy[first] + energy[first + 1] + energy[first + size] + energy[first + size + 1]
    };
    (0..half * half).map(sum).collect()
}
