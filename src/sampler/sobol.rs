//! Owen-scrambled Sobol points in one and two dimensions.
//!
//! Each request of a path takes the first one or two Sobol dimensions, in an order of samples shuffled by its own key
//! and scrambled by its own keys ("padding", B. Burley, "Practical Hash-based Owen Scrambling", JCGT 2020): every
//! request is stratified in itself, and requests are independent of each other. All 2³² sample indices are distinct.

/// The second Sobol dimension (its direction numbers are the rows of Pascal's triangle mod 2), bit-reversed as scrambling
/// needs it, for each byte of the bit-reversed index.
static REVERSED_SECOND_DIMENSION: [[u32; 256]; 4] = second_dimension_tables();

const fn second_dimension_tables() -> [[u32; 256]; 4] {
    let mut tables = [[0; 256]; 4];
    // Direction number of index bit j: v₀ = 2³¹, vⱼ = vⱼ₋₁ ⊕ vⱼ₋₁/2; reversed, v₀ = 1, vⱼ = vⱼ₋₁ ⊕ 2·vⱼ₋₁.
    let mut direction: u32 = 1;
    let mut bit = 32;
    while bit > 0 {
        bit -= 1;
        let (byte, within) = (bit / 8, 1 << (bit % 8));
        let mut value = 0;
        while value < 256 {
            if value & within != 0 {
                tables[byte][value] ^= direction;
            }
            value += 1;
        }
        direction ^= direction << 1;
    }
    tables
}

/// A permutation in which each bit of the result depends on that bit and the lower ones only, hence an Owen scramble
/// of bit-reversed numbers (S. Laine, T. Karras 2011; constants by N. Vegdahl, "Building a Better LK Hash", 2021).
#[inline]
fn permute(mut x: u32, key: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The scrambled first dimension of the sample whose index has these bits in reverse, 32 bits.
#[inline]
pub(super) fn scrambled_1d(reversed_index: u32, key: u64) -> u32 {
    // The first Sobol dimension is the bit-reversed index. Scrambling alone would leave its first bit a function of the index's
    // last, and two requests dependent: one half of one would always meet the same half of the other.
    let [shuffle, scramble] = keys(key);
    permute(permute(reversed_index, shuffle).reverse_bits(), scramble).reverse_bits()
}

/// The scrambled first two dimensions of the sample whose index has these bits in reverse, 32 bits each.
#[inline]
pub(super) fn scrambled_2d(reversed_index: u32, key: u64) -> [u32; 2] {
    let [shuffle, scramble] = keys(key);
    let reversed = permute(reversed_index, shuffle);
    let bytes = reversed.to_le_bytes();
    let second = (0..4).fold(0, |x, i| x ^ REVERSED_SECOND_DIMENSION[i][usize::from(bytes[i])]);
    let first = permute(reversed.reverse_bits(), scramble);
    let second = permute(second, scramble.rotate_left(16) ^ 0x9e37_79b9);
    // Both turned round at once.
    let both = (u64::from(second) | u64::from(first) << 32).reverse_bits();
    [both as u32, (both >> 32) as u32]
}

#[inline]
fn keys(key: u64) -> [u32; 2] {
    [key as u32, (key >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_of_two_of_samples_is_a_net() {
        // (0, m, 2)-net: each elementary interval of area 2⁻ᵐ holds exactly one of the first 2ᵐ points.
        for m in [4u32, 7, 10] {
            for split in 0..=m {
                let mut cells = vec![0; 1 << m];
                for index in 0..1 << m {
                    let [x, y] = scrambled_2d(u32::reverse_bits(index), 0x1234_5678_9abc_def0);
                    let column = u64::from(x) >> (32 - split);
                    let row = u64::from(y) >> (32 - (m - split));
                    cells[(row << split | column) as usize] += 1;
                }
                assert!(cells.iter().all(|&count| count == 1), "2^{m} samples, {split} bits of x");
            }
        }
    }

    #[test]
    fn one_dimension_is_stratified_and_keys_differ() {
        let mut strata = [0; 64];
        for index in 0..64 {
            strata[(scrambled_1d(u32::reverse_bits(index), 99) >> 26) as usize] += 1;
        }
        assert_eq!(strata, [1; 64]);
        assert_ne!(scrambled_1d(3, 1), scrambled_1d(3, 2));
    }

    #[test]
    fn samples_beyond_sixteen_bits_are_new() {
        let sample = |index: u32| scrambled_2d(index.reverse_bits(), 7);
        assert_ne!(sample(5), sample(5 + (1 << 16)));
    }
}
