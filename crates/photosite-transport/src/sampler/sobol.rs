//! Owen-scrambled Sobol points in one and two dimensions.
//!
//! Each request of a path takes the first one or two Sobol dimensions, in an order of samples shuffled by its own key
//! and scrambled by its own keys ("padding", B. Burley, "Practical Hash-based Owen Scrambling", JCGT 2020): every
//! request is stratified in itself, and requests are independent of each other. All 2³² sample indices are distinct.

/// A permutation in which each bit of the result depends on that bit and the lower ones only, hence an Owen scramble
/// of bit-reversed numbers (S. Laine, T. Karras 2011; constants by N. Vegdahl, "Building a Better LK Hash", 2021).
#[inline(always)]
fn permute(mut x: u32, key: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol dimension of an index, its bits in reverse as scrambling needs them. Its direction numbers are the
/// rows of Pascal's triangle mod 2, and reversed the powers of 1 + x: with the bits of the index for coefficients of a
/// polynomial p(x) mod 2, this is p(1 + x), where (1 + x)^h = 1 + x^h for the powers of two that halve it.
#[inline(always)]
fn reversed_second_dimension(mut index: u32) -> u32 {
    index ^= index >> 16;
    index ^= (index >> 8) & 0x00ff_00ff;
    index ^= (index >> 4) & 0x0f0f_0f0f;
    index ^= (index >> 2) & 0x3333_3333;
    index ^ (index >> 1) & 0x5555_5555
}

/// Index of a sample, shuffled by the key of a request: its place in the order of this request. Scrambling alone would
/// leave the first bit of the first dimension, which is the reversed index, a function of the index's last, and two
/// requests dependent: one half of one would always meet the same half of the other.
#[inline(always)]
pub(super) fn shuffled(index: u32, key: u64) -> u32 {
    permute(index.reverse_bits(), key as u32).reverse_bits()
}

/// The scrambled first dimension of a [`shuffled`] sample, 32 bits.
#[inline(always)]
pub(super) fn first(shuffled: u32, key: u64) -> u32 {
    permute(shuffled, (key >> 32) as u32).reverse_bits()
}

/// The scrambled second dimension of a [`shuffled`] sample, 32 bits.
#[inline(always)]
pub(super) fn second(shuffled: u32, key: u64) -> u32 {
    permute(reversed_second_dimension(shuffled), ((key >> 32) as u32).rotate_left(16) ^ 0x9e37_79b9).reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scrambled_2d(index: u32, key: u64) -> [u32; 2] {
        let shuffled = shuffled(index, key);
        [first(shuffled, key), second(shuffled, key)]
    }

    #[test]
    fn every_power_of_two_of_samples_is_a_net() {
        // (0, m, 2)-net: each elementary interval of area 2⁻ᵐ holds exactly one of the first 2ᵐ points.
        for m in [4u32, 7, 10] {
            for split in 0..=m {
                let mut cells = vec![0; 1 << m];
                for index in 0..1 << m {
                    let [x, y] = scrambled_2d(index, 0x1234_5678_9abc_def0);
                    let column = u64::from(x) >> (32 - split);
                    let row = u64::from(y) >> (32 - (m - split));
                    cells[(row << split | column) as usize] += 1;
                }
                assert!(cells.iter().all(|&count| count == 1), "2^{m} samples, {split} bits of x");
            }
        }
    }

    #[test]
    fn the_second_dimension_has_the_rows_of_pascals_triangle_for_direction_numbers() {
        // Row j has the parities of the binomial coefficients, each the sum of two of the row before.
        let mut row: u32 = 1;
        for bit in 0..32 {
            assert_eq!(reversed_second_dimension(1 << bit), row, "bit {bit}");
            row ^= row << 1;
        }
        let (a, b) = (0x1234_5678, 0x9abc_def0);
        assert_eq!(reversed_second_dimension(a ^ b), reversed_second_dimension(a) ^ reversed_second_dimension(b));
    }

    #[test]
    fn keys_differ() {
        assert_ne!(scrambled_2d(3, 1), scrambled_2d(3, 2));
    }

    #[test]
    fn samples_beyond_sixteen_bits_are_new() {
        assert_ne!(scrambled_2d(5, 7), scrambled_2d(5 + (1 << 16), 7));
    }
}
