//! The keys of the random numbers of each request.

use photosite_core::math::hash::{hash64_halves, second_half};

/// A key of its own for each request, the same for all samples of the sequence.
#[inline]
pub(super) fn request_key(sequence_key: u64, dimension: u32) -> u64 {
    let half = DIMENSIONS.get(dimension as usize).copied();
    hash64_halves(sequence_key, half.unwrap_or_else(|| second_half(u64::from(dimension))))
}

/// Halves [`second_half`] of the dimensions that most paths come by.
static DIMENSIONS: [u64; 64] = {
    let mut halves = [0; 64];
    let mut dimension = 0;
    while dimension < 64 {
        halves[dimension] = second_half(dimension as u64);
        dimension += 1;
    }
    halves
};
