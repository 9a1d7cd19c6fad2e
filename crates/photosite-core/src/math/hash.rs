//! Integer hashing for keys of random sequences: not cryptographic, but every input bit moves every output bit.

/// Mixes 64 bits (the finaliser of SplitMix64, Steele et al. 2014).
#[inline]
pub const fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// Hashes a pair; chain it to hash more: `hash64(hash64(a, b), c)`.
#[inline]
pub const fn hash64(a: u64, b: u64) -> u64 {
    hash64_halves(first_half(a), second_half(b))
}

/// `hash64(a, b)` from what [`first_half`] makes of a and [`second_half`] of b, where one of them is hashed with many
/// others.
#[inline]
pub const fn hash64_halves(a: u64, b: u64) -> u64 {
    mix64(a ^ b)
}

/// Half of [`hash64_halves`] that depends on a.
#[inline]
pub const fn first_half(a: u64) -> u64 {
    a.wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xd6e8_feb8_6659_fd93)
}

/// Half of [`hash64_halves`] that depends on b.
#[inline]
pub const fn second_half(b: u64) -> u64 {
    mix64(b.wrapping_add(0x9e37_79b9_7f4a_7c15))
}

/// The top 24 bits of `x` as a number in [0, 1).
#[inline]
pub fn unit_f32(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flipping_one_bit_flips_half_of_the_others() {
        // 64 output bits, 64 × 256 trials: the mean of a fair coin over 2^20 flips has σ = 0.0005.
        let mut flipped = 0u32;
        for trial in 0..256u64 {
            for bit in 0..64 {
                flipped += (hash64(trial, 7) ^ hash64(trial ^ (1 << bit), 7)).count_ones();
            }
        }
        let mean = f64::from(flipped) / (256.0 * 64.0 * 64.0);
        assert!((mean - 0.5).abs() < 0.0025, "{mean}");
    }

    #[test]
    fn unit_numbers_stay_below_one() {
        assert!(unit_f32(u32::MAX) < 1.0);
    }
}
