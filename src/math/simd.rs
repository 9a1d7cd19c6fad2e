//! Eight numbers at a time: the few operations that ray traversal needs, on AVX registers where the machine has them
//! and on plain arrays elsewhere. Loops over arrays that the compiler turns into such operations by itself are compiled for
//! these registers too.
//!
//! Of AVX-512 nothing is used: on eight lanes its registers and masks made renders up to 6 % slower (AMD EPYC, one thread).
//!
//! Both kinds do the same IEEE operations in the same order and contract nothing into fused ones, so that a picture does
//! not depend on the machine. This is the only file with `unsafe` code: the AVX intrinsics must not run on a processor
//! without AVX2, and the compiler cannot know where the program will run. Advice to the memory, by an
//! instruction and by a call of the system, is here too.

#![allow(unsafe_code, reason = "intrinsics behind a run-time check; see the module documentation")]

/// Eight f32 lanes. Implementations are values of a register or an array.
pub(crate) trait Lanes: Copy {
    /// Numbers of lanes.
    type Indices: Copy;

    fn load(values: &[f32; 8]) -> Self;
    /// Numbers below 8.
    fn indices(values: &[u8; 8]) -> Self::Indices;
    /// Lane i is the one of self that the i-th number names.
    fn permute(self, indices: Self::Indices) -> Self;
    fn splat(value: f32) -> Self;
    fn store(self) -> [f32; 8];
    fn add(self, other: Self) -> Self;
    fn sub(self, other: Self) -> Self;
    fn mul(self, other: Self) -> Self;
    fn div(self, other: Self) -> Self;
    /// The smaller of the two; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of the two; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// Bit i is set where lane i of self ≤ that of other; NaN compares false.
    fn le(self, other: Self) -> u32;
    /// Bit i is set where lane i of self < that of other; NaN compares false.
    fn lt(self, other: Self) -> u32;
}

/// Lanes in an array, on any machine.
#[derive(Clone, Copy)]
pub(crate) struct Portable([f32; 8]);

impl Portable {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn mask(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        (0..8).fold(0, |mask, i| mask | u32::from(f(self.0[i], other.0[i])) << i)
    }
}

impl Lanes for Portable {
    type Indices = [u8; 8];

    #[inline(always)]
    fn load(values: &[f32; 8]) -> Self {
        Self(*values)
    }
    #[inline(always)]
    fn indices(values: &[u8; 8]) -> [u8; 8] {
        *values
    }
    #[inline(always)]
    fn permute(self, indices: [u8; 8]) -> Self {
        Self(indices.map(|i| self.0[usize::from(i % 8)]))
    }
    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; 8])
    }
    #[inline(always)]
    fn store(self) -> [f32; 8] {
        self.0
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.mask(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        self.mask(other, |a, b| a < b)
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use avx::Avx;

#[cfg(target_arch = "x86_64")]
mod avx {
    use std::arch::x86_64::{
        __m256, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _mm_loadl_epi64, _mm256_add_ps, _mm256_cmp_ps, _mm256_cvtepu8_epi32,
        _mm256_div_ps, _mm256_loadu_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
        _mm256_permutevar8x32_ps, _mm256_set1_ps, _mm256_storeu_ps, _mm256_sub_ps,
    };

    use super::Lanes;

    /// Lanes in an AVX register. Only code that is inlined below a function with the `avx2` target feature, itself
    /// called after `is_x86_feature_detected!` said yes, may make one.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx(__m256);

    // SAFETY, for every block below: an `Avx` exists only where AVX2 does (see the type), and the loads and stores are of
    // references to eight floats or bytes, which the unaligned instructions accept at any address.
    impl Lanes for Avx {
        type Indices = __m256i;

        #[inline(always)]
        fn load(values: &[f32; 8]) -> Self {
            // SAFETY: reads the eight floats behind the reference.
            Self(unsafe { _mm256_loadu_ps(values.as_ptr()) })
        }
        #[inline(always)]
        fn indices(values: &[u8; 8]) -> __m256i {
            // SAFETY: reads the eight bytes behind the reference.
            unsafe { _mm256_cvtepu8_epi32(_mm_loadl_epi64(values.as_ptr().cast())) }
        }
        #[inline(always)]
        fn permute(self, indices: __m256i) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_permutevar8x32_ps(self.0, indices) })
        }
        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_set1_ps(value) })
        }
        #[inline(always)]
        fn store(self) -> [f32; 8] {
            let mut values = [0.0; 8];
            // SAFETY: writes the eight floats of the array.
            unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) };
            values
        }
        #[inline(always)]
        fn add(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_add_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn sub(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_sub_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn mul(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_mul_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn div(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_div_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn le(self, other: Self) -> u32 {
            // SAFETY: AVX2 is there.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) as u32 }
        }
        #[inline(always)]
        fn lt(self, other: Self) -> u32 {
            // SAFETY: AVX2 is there.
            unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) as u32 }
        }
    }
}

/// Asks the memory for what will be needed.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

        let start = std::ptr::from_ref(value).cast::<i8>();
        for offset in (0..size_of::<T>()).step_by(64) {
            // SAFETY: reads nothing that the program could tell.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(offset)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// Asks the system for pages of 2 MB where it gives 4 kB otherwise, for what a vector has room for: rays in large scenes spend
/// much of their time looking up where pages are.
pub(crate) fn prefer_huge_pages<T>(values: &Vec<T>) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 4096;
        let start = values.as_ptr().cast::<u8>();
        let skipped = start.align_offset(PAGE);
        let len = (values.capacity() * size_of::<T>()).saturating_sub(skipped) / PAGE * PAGE;
        if len > 0 {
            // SAFETY: whole pages of the vector's memory; the advice changes how they are kept, not what they hold. Where the
            // system does not follow it, nothing happens.
            unsafe { libc::madvise(start.wrapping_add(skipped).cast_mut().cast(), len, libc::MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = values;
}

/// A vector with room for nothing more, in such pages.
pub(crate) fn compact<T: Copy>(values: &[T]) -> Vec<T> {
    let mut all = Vec::with_capacity(values.len());
    prefer_huge_pages(&all);
    all.extend_from_slice(values);
    all
}

/// Defines a function that runs its generic body with the widest lanes this machine has. The body must be
/// `#[inline(always)]`, so that it is compiled once more under the `avx2` target feature.
macro_rules! with_widest_lanes {
    (
        fn $name:ident $(<$generic:ident: $bound:path $(, const $count:ident: usize)?>)?
        ($($argument:ident: $type:ty),* $(,)?) -> $output:ty = $body:ident
    ) => {
        $crate::math::simd::on_widest_registers! {
            fn $name $(<$generic: $bound $(, const $count: usize)?>)? ($($argument: $type),*) -> $output {
                wide: $body::<$crate::math::simd::Avx, $($generic, $($count)?)?>($($argument),*),
                portable: $body::<$crate::math::simd::Portable, $($generic, $($count)?)?>($($argument),*),
            }
        }
    };
}

/// The same for a body whose loops the compiler turns into operations on lanes by itself.
macro_rules! with_widest_registers {
    (fn $name:ident ($($argument:ident: $type:ty),* $(,)?) -> $output:ty = $body:ident) => {
        $crate::math::simd::on_widest_registers! {
            fn $name($($argument: $type),*) -> $output {
                wide: $body($($argument),*),
                portable: $body($($argument),*),
            }
        }
    };
}

/// Defines a function that runs the first of two expressions where the machine has AVX2, compiled for it, and the second
/// elsewhere.
macro_rules! on_widest_registers {
    (
        fn $name:ident $(<$generic:ident: $bound:path $(, const $count:ident: usize)?>)?
        ($($argument:ident: $type:ty),* $(,)?) -> $output:ty {
            wide: $wide:expr,
            portable: $portable:expr $(,)?
        }
    ) => {
        #[inline]
        fn $name $(<$generic: $bound $(, const $count: usize)?>)? ($($argument: $type),*) -> $output {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide $(<$generic: $bound $(, const $count: usize)?>)? ($($argument: $type),*) -> $output {
                    $wide
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    #[allow(unsafe_code, reason = "the one call that the check above makes sound")]
                    // SAFETY: the processor has AVX2, as was just asked.
                    return unsafe { wide$(::<$generic, $($count)?>)?($($argument),*) };
                }
            }
            $portable
        }
    };
}
pub(crate) use {on_widest_registers, with_widest_lanes, with_widest_registers};

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on the given lanes, as bits.
    #[inline(always)]
    fn every_operation<L: Lanes>(a: &[f32; 8], b: &[f32; 8]) -> Vec<u32> {
        let (x, y) = (L::load(a), L::load(b));
        let turned = x.permute(L::indices(&[7, 0, 0, 3, 2, 6, 5, 1]));
        let results = [x.add(y), x.sub(y), x.mul(y), x.div(y), x.min(y), x.max(y), L::splat(a[0]), turned];
        // The sign of a NaN is nobody's promise.
        let canonical = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
        let mut bits: Vec<u32> = results.into_iter().flat_map(|r| r.store().map(canonical)).collect();
        bits.extend([x.le(y), x.lt(y)]);
        bits
    }

    with_widest_lanes! {
        fn widest(a: &[f32; 8], b: &[f32; 8]) -> Vec<u32> = every_operation
    }

    #[test]
    fn both_kinds_of_lanes_agree_bit_by_bit() {
        let a = [1.0, -2.5, 0.0, -0.0, f32::INFINITY, 1e-40, 3.0, f32::MAX];
        let b = [1.0, 3.5, -0.0, 7.0, 2.0, 1e20, 0.1, f32::INFINITY];
        assert_eq!(widest(&a, &b), every_operation::<Portable>(&a, &b));
    }

    #[test]
    fn a_nan_yields_to_the_second_operand() {
        let nan = Portable::splat(f32::NAN);
        assert_eq!(nan.min(Portable::splat(2.0)).store(), [2.0; 8]);
        assert_eq!(nan.max(Portable::splat(2.0)).store(), [2.0; 8]);
        assert_eq!(nan.le(nan), 0);
    }
}
