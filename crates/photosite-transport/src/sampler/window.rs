//! Sobol points of eight samples at a time.
//!
//! Samples follow each other, and so do their numbers: those of eight samples of one dimension cost little more than
//! those of one, eight lanes at a time.

use super::request_key::request_key;
use super::sobol;
use photosite_core::math::hash::unit_f32;
use photosite_simd::{Simd, WithSimd, dispatch};

/// Samples that are computed together.
const WIDTH: usize = 8;

/// Dimensions that are kept, more than a path asks for between two rays.
const KEPT: usize = 8;

/// The numbers of [`WIDTH`] samples of a sequence, as far as they have been asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct Window {
    sequence_key: u64,
    /// Index of the first sample; a multiple of [`WIDTH`].
    first_index: u32,
    /// The dimension that each slot holds of one number, and of two; none has number 0.
    first_of: [u32; KEPT],
    pair_of: [u32; KEPT],
    numbers: [Numbers; KEPT],
}

/// Random numbers of two dimensions of each sample.
type Numbers = [[f32; WIDTH]; 2];

impl Window {
    /// Moves to where sample `index` of the sequence is.
    #[inline]
    pub(super) fn show(&mut self, sequence_key: u64, index: u32) {
        let first_index = index - index % WIDTH as u32;
        if (self.sequence_key, self.first_index) != (sequence_key, first_index) {
            (self.sequence_key, self.first_index) = (sequence_key, first_index);
            (self.first_of, self.pair_of) = ([0; KEPT], [0; KEPT]);
        }
    }

    /// The first number of a sample that is shown, in the order of a request.
    #[inline]
    pub(super) fn first(&mut self, index: u32, dimension: u32) -> f32 {
        let slot = dimension as usize % KEPT;
        if self.first_of[slot] != dimension {
            self.fill_firsts(dimension);
        }
        self.numbers[slot][0][index as usize % WIDTH]
    }

    /// Both random numbers of a sample.
    #[inline]
    pub(super) fn both(&mut self, index: u32, dimension: u32) -> [f32; 2] {
        let slot = dimension as usize % KEPT;
        if self.pair_of[slot] != dimension {
            self.fill_pairs(dimension);
        }
        let [firsts, seconds] = &self.numbers[slot];
        let lane = index as usize % WIDTH;
        [firsts[lane], seconds[lane]]
    }

    // Out of the way of those that look numbers up.
    #[inline(never)]
    fn fill_firsts(&mut self, dimension: u32) {
        let slot = dimension as usize % KEPT;
        self.numbers[slot][0] =
            dispatch(Firsts { first_index: self.first_index, key: request_key(self.sequence_key, dimension) });
        (self.first_of[slot], self.pair_of[slot]) = (dimension, 0);
    }

    #[inline(never)]
    fn fill_pairs(&mut self, dimension: u32) {
        let slot = dimension as usize % KEPT;
        self.numbers[slot] =
            dispatch(Pairs { first_index: self.first_index, key: request_key(self.sequence_key, dimension) });
        (self.first_of[slot], self.pair_of[slot]) = (dimension, dimension);
    }
}

/// The first of each pair of numbers of [`WIDTH`] samples.
struct Firsts {
    first_index: u32,
    key: u64,
}

impl WithSimd for Firsts {
    type Output = [f32; WIDTH];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [f32; WIDTH] {
        firsts_inline(self.first_index, self.key)
    }
}

/// The pairs of numbers of [`WIDTH`] samples.
struct Pairs {
    first_index: u32,
    key: u64,
}

impl WithSimd for Pairs {
    type Output = Numbers;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Numbers {
        pairs_inline(self.first_index, self.key)
    }
}

// Loops rather than closures, which would not be inlined into a function for wide registers.
#[inline(always)]
fn firsts_inline(first_index: u32, key: u64) -> [f32; WIDTH] {
    let mut numbers = [0.0; WIDTH];
    for (lane, number) in numbers.iter_mut().enumerate() {
        *number = unit_f32(sobol::first(shuffled(first_index, lane, key), key));
    }
    numbers
}

#[inline(always)]
fn pairs_inline(first_index: u32, key: u64) -> Numbers {
    let [mut firsts, mut seconds] = [[0.0; WIDTH]; 2];
    for (lane, (first, second)) in firsts.iter_mut().zip(&mut seconds).enumerate() {
        let shuffled = shuffled(first_index, lane, key);
        *first = unit_f32(sobol::first(shuffled, key));
        *second = unit_f32(sobol::second(shuffled, key));
    }
    [firsts, seconds]
}

#[inline(always)]
fn shuffled(first_index: u32, lane: usize, key: u64) -> u32 {
    sobol::shuffled(first_index | lane as u32, key)
}
