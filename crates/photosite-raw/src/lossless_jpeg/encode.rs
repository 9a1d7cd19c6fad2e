//! Writing lossless JPEG.

use super::huffman::{CATEGORIES, Table};
use super::{DHT, EOI, SOF3, SOI, SOS};

/// Bits of the numbers.
const PRECISION: u8 = 16;

/// Encodes rows of `row_length` numbers, those of `components` (1–4) beside each other. Both sides are at most 65 535,
/// and rows are whole.
pub(crate) fn encode(numbers: &[u16], row_length: usize, components: usize) -> Vec<u8> {
    let mut occurrences = [0; CATEGORIES];
    for_each_difference(numbers, row_length, components, |difference| occurrences[category(difference) as usize] += 1);
    let table = Table::for_counts(&occurrences);

    let side = |n: usize| (n as u16).to_be_bytes();
    let [rows, columns] = [side(numbers.len() / row_length), side(row_length / components)];
    let count = components as u8;
    let mut to = vec![0xff, SOI];
    segment(&mut to, SOF3, |to| {
        to.push(PRECISION);
        to.extend([rows, columns].concat());
        to.push(count);
        (0..count).for_each(|component| to.extend([component, 0x11, 0]));
    });
    segment(&mut to, DHT, |to| {
        to.push(0);
        to.extend(table.counts);
        to.extend(&table.symbols);
    });
    segment(&mut to, SOS, |to| {
        to.push(count);
        (0..count).for_each(|component| to.extend([component, 0]));
        // The predictor on the left; no end of a spectral selection; no point transform.
        to.extend([1, 0, 0]);
    });
    let codes = table.codes();
    let mut bits = Bits { to, waiting: 0, count: 0 };
    for_each_difference(numbers, row_length, components, |difference| {
        let category = category(difference);
        let (code, length) = codes[category as usize];
        bits.push(code.into(), length);
        // A difference of 2¹⁵ is stated by its category alone.
        if category < 16 {
            let value = i32::from(difference) - i32::from(difference < 0);
            bits.push(value as u32 & ((1 << category) - 1), category);
        }
    });
    let mut to = bits.finish();
    to.extend([0xff, EOI]);
    to
}

/// A marker with its parameters.
fn segment(to: &mut Vec<u8>, marker: u8, fill: impl FnOnce(&mut Vec<u8>)) {
    let mut parameters = Vec::new();
    fill(&mut parameters);
    to.extend([0xff, marker]);
    to.extend((parameters.len() as u16 + 2).to_be_bytes());
    to.extend(parameters);
}

/// Differences to the number on the left of the same component; in the first column to the one above; at the very first
/// to half the range. All modulo 2¹⁶.
fn for_each_difference(numbers: &[u16], row_length: usize, components: usize, mut each: impl FnMut(i16)) {
    for (y, row) in numbers.chunks_exact(row_length).enumerate() {
        for (x, &number) in row.iter().enumerate() {
            let predicted = if x >= components {
                row[x - components]
            } else if y > 0 {
                numbers[(y - 1) * row_length + x]
            } else {
                1 << (PRECISION - 1)
            };
            each(number.wrapping_sub(predicted) as i16);
        }
    }
}

/// Bits of a difference: 0 for 0, 16 for −2¹⁵.
#[inline]
fn category(difference: i16) -> u32 {
    u16::BITS - difference.unsigned_abs().leading_zeros()
}

/// Bits, the most significant first; a byte of ones is followed by one of zeros, which tells it from a marker.
struct Bits {
    to: Vec<u8>,
    waiting: u64,
    count: u32,
}

impl Bits {
    #[inline]
    fn push(&mut self, bits: u32, count: u32) {
        self.waiting = self.waiting << count | u64::from(bits);
        self.count += count;
        while self.count >= 8 {
            self.count -= 8;
            let byte = (self.waiting >> self.count) as u8;
            self.to.push(byte);
            if byte == 0xff {
                self.to.push(0);
            }
        }
    }

    /// Fills the last byte with ones.
    fn finish(mut self) -> Vec<u8> {
        let free = (8 - self.count % 8) % 8;
        self.push((1 << free) - 1, free);
        self.to
    }
}
