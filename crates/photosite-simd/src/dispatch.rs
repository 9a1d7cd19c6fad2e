//! The choice of instructions at run time.

#[cfg(target_arch = "aarch64")]
use crate::Neon as Baseline;
#[cfg(not(target_arch = "aarch64"))]
use crate::Portable as Baseline;
use crate::WithSimd;

/// Runs an operation on eight lanes with the best instructions that this processor has for eight lanes.
#[inline]
pub fn dispatch<O: WithSimd>(operation: O) -> O::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx2) = crate::Avx2::detect() {
        return avx2.run(operation);
    }
    // Instructions that every processor of the architecture has
    operation.with_simd(Baseline)
}

/// Runs an operation on [wide lanes](crate::Simd::Wide) with the widest instructions that this processor has.
#[inline]
pub fn dispatch_wide<O: WithSimd>(operation: O) -> O::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(avx512) = crate::Avx512::detect() {
        return avx512.run(operation);
    }
    dispatch(operation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{IdLanes, LaneMask, Lanes, MAX_LANES, Portable, Real, Simd, WideLanes};

    /// Results of every operation on the given lanes, as bits.
    struct EveryOperation<'a>(&'a [f32; 8], &'a [f32; 8]);

    impl WithSimd for EveryOperation<'_> {
        type Output = Vec<u32>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Vec<u32> {
            let Self(a, b) = self;
            let (x, y) = (simd.load(a), simd.load(b));
            let reordered = x.permute(simd.indices(&[7, 0, 0, 3, 2, 6, 5, 1]));
            let both = x.lt(y) & !y.le(simd.broadcast(3.0));
            let either = both | y.lt(x);
            let results = [
                [x + y, x - y, x * y, x / y, x.min(y), x.max(y)],
                [simd.broadcast(a[0]), reordered, -x, x.abs(), x.sqrt(), x.copysign(y)],
                [Real::select(both, x, y), Real::select(either, x, y), x.broadcast(b[1]), x, y, -y],
                // What rounds once if the compiler makes one instruction of two
                [x * y + x, x * y - x, x - x * y, -(x * y) - y, x * x + y * y, (x - y) * (x + y)],
            ];
            // The sign of a NaN is nobody's promise.
            let canonical = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
            let mut bits: Vec<u32> = results.as_flattened().iter().flat_map(|r| r.store().map(canonical)).collect();
            bits.extend([7, 8, 9].map(|id| simd.find(&[7, 0, 8, u32::MAX, 8, 7, 6, 8], id)));
            bits.extend([x.le(y).bits(), x.lt(y).bits(), both.bits(), either.bits()]);
            bits
        }
    }

    #[test]
    fn all_kinds_of_lanes_agree_bit_by_bit() {
        let strange = [1.0, -2.5, 0.0, -0.0, f32::INFINITY, 1e-40, f32::MAX, f32::NAN];
        for shift in 0..8 {
            let mut other = strange;
            other.rotate_left(shift);
            let pair = || EveryOperation(&strange, &other);
            assert_eq!(dispatch(pair()), pair().with_simd(Portable), "{other:?}");
        }
    }

    /// Numbers that look random: half of them have any bits, the others lie between 1 and 2, so that sums and products
    /// of them are rounded.
    fn numbers<const N: usize>(series: u32) -> [f32; N] {
        std::array::from_fn(|i| {
            let mixed = (series * N as u32 + i as u32).wrapping_mul(0x9e37_79b9);
            let mixed = (mixed ^ mixed >> 16).wrapping_mul(0x85eb_ca6b);
            let bits = mixed ^ mixed >> 13;
            f32::from_bits(if series.is_multiple_of(2) { bits } else { bits >> 9 | 1.0_f32.to_bits() })
        })
    }

    #[test]
    fn results_are_those_of_every_other_machine() {
        let mut sum = 0_u64;
        for series in 0..2000 {
            let (a, b) = (numbers(series), numbers(series + 2000));
            let results = dispatch(EveryOperation(&a, &b));
            assert_eq!(results, EveryOperation(&a, &b).with_simd(Portable), "{a:?}, {b:?}");
            sum = results.into_iter().fold(sum, |sum, bits| (sum ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3));
        }
        // As found with AVX2
        assert_eq!(sum, 6_212_606_975_434_945_944);
    }

    /// Results of every operation on wide lanes, for 64 pairs of numbers, as bits.
    struct EveryWideOperation<'a>(&'a [[f32; 2]; 64]);

    impl WithSimd for EveryWideOperation<'_> {
        type Output = Vec<u32>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Vec<u32> {
            let mut bits = Vec::new();
            for pairs in self.0.chunks(S::Wide::COUNT) {
                let (mut a, mut b) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
                for (lane, &[x, y]) in pairs.iter().enumerate() {
                    (a[lane], b[lane]) = (x, y);
                }
                let (x, y) = (simd.load_wide(&a), simd.load_wide(&b));
                let both = x.lt(y) & !y.le(simd.broadcast_wide(3.0)) | y.lt(x);
                let chosen = Real::select(both, x, y);
                let results = [
                    [x + y, x - y, x * y, x / y, x.min(y), x.max(y), -x],
                    [x.abs(), x.sqrt(), x.copysign(y), chosen, x * y + x, x * y - x, x - x * y],
                ];
                let results = results.map(|row| row.map(WideLanes::store_wide));
                let ids = IdLanes::select(both, simd.broadcast_id(7), simd.broadcast_id(u32::MAX)).store_wide();
                for lane in 0..pairs.len() {
                    let canonical = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
                    bits.extend(results.as_flattened().iter().map(|lanes| canonical(lanes[lane])));
                    bits.extend([both.bits() >> lane & 1, ids[lane]]);
                }
            }
            bits
        }
    }

    #[test]
    fn wide_lanes_agree_with_eight_bit_by_bit() {
        let strange = [1.0, -2.5, 0.0, -0.0, f32::INFINITY, 1e-40, 3.0, f32::NAN];
        let strange = std::array::from_fn(|i| [strange[i / 8], strange[i % 8]]);
        let random = |series| std::array::from_fn(|i| [numbers::<64>(series)[i], numbers::<64>(series + 2)[i]]);
        for pairs in [strange, random(0), random(1)] {
            let portable = EveryWideOperation(&pairs).with_simd(Portable);
            assert_eq!(dispatch_wide(EveryWideOperation(&pairs)), portable);
            assert_eq!(dispatch(EveryWideOperation(&pairs)), portable);
        }
    }

    #[test]
    fn a_nan_yields_to_the_second_operand() {
        let (nan, two) = (Portable.broadcast(f32::NAN), Portable.broadcast(2.0));
        assert_eq!(nan.min(two).store(), [2.0; 8]);
        assert_eq!(nan.max(two).store(), [2.0; 8]);
        assert_eq!(nan.le(nan).bits(), 0);
    }
}
