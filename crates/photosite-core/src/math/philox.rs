//! Philox4x32-10, a counter-based random generator: the stream for a key and a counter is a pure function of both, so
//! noise can be asked for in any order, on any number of threads (Salmon et al., "Parallel Random Numbers: As Easy
//! as 1, 2, 3", SC 2011).

use std::convert::Infallible;

use photosite_simd::{Simd, WithSimd, dispatch_wide};
use rand::TryRng;

/// A stream of random numbers for one key and one 64-bit stream number (a pixel, a row …).
///
/// It implements [`rand::Rng`], so the distributions of `rand_distr` draw from it. A stream holds 2⁶⁶ numbers.
#[derive(Clone, Debug)]
pub struct Philox {
    key: [u32; 2],
    counter: [u32; 4],
    block: [u32; 4],
    used: usize,
}

impl Philox {
    /// The stream `stream` of `key`.
    pub fn new(key: u64, stream: u64) -> Self {
        let [low, high] = halves(stream);
        Self { key: halves(key), counter: [0, 0, low, high], block: [0; 4], used: 4 }
    }

    /// The two streams number 2·`pair` and 2·`pair` + 1 of another kind: they share their first block, so that
    /// neighbours that need no more than 64 bits each cost one block together. Do not mix these streams with
    /// [`Self::new`] for the same key.
    #[inline]
    pub fn pair(key: u64, pair: u64) -> [Self; 2] {
        let block = philox4x32_10([0, 0, pair as u32, (pair >> 32) as u32], halves(key));
        Self::of_block(key, pair, block)
    }

    /// The streams of the pairs `first`, `first + 1` … of [`Self::pair`], for which [`PairBlocks::new`] has computed the
    /// first blocks.
    #[inline]
    pub fn pairs(blocks: &PairBlocks) -> impl Iterator<Item = [Self; 2]> {
        let PairBlocks { key, first, numbers: [a, b, c, d] } = blocks;
        (0..PAIRS).map(move |i| Self::of_block(*key, first + i as u64, [a, b, c, d].map(|of| of[i] as u32)))
    }

    #[inline]
    fn of_block(key: u64, pair: u64, [a, b, c, d]: [u32; 4]) -> [Self; 2] {
        let key = halves(key);
        let [low, high] = halves(pair);
        // The third and fourth number of a block are those that are left; what follows is each stream's own.
        let stream = |own: u32, first: [u32; 2]| Self {
            key,
            counter: [0, own, low, high],
            block: [0, 0, first[0], first[1]],
            used: 2,
        };
        [stream(1, [a, b]), stream(2, [c, d])]
    }
}

/// The low and the high half of a number.
#[inline]
fn halves(number: u64) -> [u32; 2] {
    [number as u32, (number >> 32) as u32]
}

const ROUNDS: usize = 10;
const MULTIPLIERS: [u64; 2] = [0xd251_1f53, 0xcd9e_8d57];
/// Increment of the key from round to round.
const WEYL: [u32; 2] = [0x9e37_79b9, 0xbb67_ae85];

/// One block of four numbers: ten rounds of Philox4x32.
#[inline]
pub fn philox4x32_10(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for round in 0..ROUNDS {
        if round > 0 {
            key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
        }
        let p0 = MULTIPLIERS[0] * u64::from(counter[0]);
        let p1 = MULTIPLIERS[1] * u64::from(counter[2]);
        counter =
            [(p1 >> 32) as u32 ^ counter[1] ^ key[0], p1 as u32, (p0 >> 32) as u32 ^ counter[3] ^ key[1], p0 as u32];
    }
    counter
}

/// Number of pairs of streams that are begun together: several of the widest registers full.
pub const PAIRS: usize = 32;

/// The first blocks of [`PAIRS`] pairs of streams, which share what a block costs: the rounds run on all of them at once.
pub struct PairBlocks {
    key: u64,
    first: u64,
    /// Four numbers of each block, each in 64 bits.
    numbers: [[u64; PAIRS]; 4],
}

impl PairBlocks {
    /// First blocks of the pairs from number `first` on.
    #[inline]
    pub fn new(key: u64, first: u64) -> Self {
        Self { key, first, numbers: dispatch_wide(Rounds { key, first }) }
    }
}

/// Key and counters of many blocks through the rounds.
struct Rounds {
    key: u64,
    first: u64,
}

impl WithSimd for Rounds {
    type Output = [[u64; PAIRS]; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [[u64; PAIRS]; 4] {
        // A product of two halves is one instruction for numbers of 64 bits whose upper half is known to be 0.
        const LOW: u64 = u32::MAX as u64;
        let [mut a, mut b, mut c, mut d] = [[0; PAIRS]; 4];
        for i in 0..PAIRS {
            let pair = self.first + i as u64;
            (c[i], d[i]) = (pair & LOW, pair >> 32);
        }
        let mut key = halves(self.key);
        for round in 0..ROUNDS {
            if round > 0 {
                key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
            }
            let [k0, k1] = key.map(u64::from);
            for i in 0..PAIRS {
                let p0 = MULTIPLIERS[0] * (a[i] & LOW);
                let p1 = MULTIPLIERS[1] * (c[i] & LOW);
                (a[i], b[i], c[i], d[i]) = ((p1 >> 32) ^ b[i] ^ k0, p1 & LOW, (p0 >> 32) ^ d[i] ^ k1, p0 & LOW);
            }
        }
        [a, b, c, d]
    }
}

impl TryRng for Philox {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        if self.used == 4 {
            self.block = philox4x32_10(self.counter, self.key);
            let (low, carry) = self.counter[0].overflowing_add(1);
            self.counter[0] = low;
            self.counter[1] = self.counter[1].wrapping_add(u32::from(carry));
            self.used = 0;
        }
        self.used += 1;
        Ok(self.block[self.used - 1])
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let low = u64::from(self.try_next_u32()?);
        Ok(low | u64::from(self.try_next_u32()?) << 32)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(4) {
            let word = self.try_next_u32()?.to_le_bytes();
            chunk.copy_from_slice(&word[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use rand::Rng;

    use super::*;

    /// Known answers of the Random123 distribution (`kat_vectors`, philox4x32 10).
    #[test]
    fn known_answers() {
        assert_eq!(philox4x32_10([0; 4], [0; 2]), [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]);
        assert_eq!(
            philox4x32_10([0xffff_ffff; 4], [0xffff_ffff; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            philox4x32_10([0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344], [0xa409_3822, 0x299f_31d0]),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn streams_do_not_overlap() {
        let [a, b] = Philox::pair(1, 0);
        let [c, d] = Philox::pair(1, 1);
        for streams in [vec![Philox::new(1, 0), Philox::new(1, 1)], vec![a, b, c, d]] {
            let numbers: Vec<Vec<u32>> =
                streams.into_iter().map(|mut stream| (0..64).map(|_| stream.next_u32()).collect()).collect();
            for (i, a) in numbers.iter().enumerate() {
                // Two of 64 numbers of 32 bits are equal with a probability of 5e-7.
                assert!(numbers[i + 1..].iter().all(|b| a.iter().all(|x| !b.contains(x))));
            }
        }
    }

    #[test]
    fn many_pairs_are_those_that_are_begun_one_by_one() {
        let key = 0x0123_4567_89ab_cdef;
        // The low half of the numbers overflows, too.
        for first in [0, 7 << 32 | 1000, (9 << 32) - 5] {
            let blocks = PairBlocks::new(key, first);
            for (i, together) in Philox::pairs(&blocks).enumerate() {
                for (mut together, mut alone) in together.into_iter().zip(Philox::pair(key, first + i as u64)) {
                    let numbers = |stream: &mut Philox| [(); 6].map(|()| stream.next_u32());
                    assert_eq!(numbers(&mut together), numbers(&mut alone), "{first} + {i}");
                }
            }
        }
    }

    #[test]
    fn a_pair_shares_a_block_and_goes_its_own_ways() {
        let [mut even, mut odd] = Philox::pair(0x0123_4567_89ab_cdef, 7 << 32 | 9);
        let block = |second| philox4x32_10([0, second, 9, 7], [0x89ab_cdef, 0x0123_4567]);
        let numbers = |stream: &mut Philox| [(); 6].map(|()| stream.next_u32());
        let ([a, b, c, d], [e, f, g, h], [i, j, k, l]) = (block(0), block(1), block(2));
        assert_eq!(numbers(&mut even), [a, b, e, f, g, h]);
        assert_eq!(numbers(&mut odd), [c, d, i, j, k, l]);
    }
}
