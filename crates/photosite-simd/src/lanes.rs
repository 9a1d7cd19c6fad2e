//! Eight numbers at a time: the operations that rays and matt surfaces need, on AVX registers where the machine has them
//! and on plain arrays elsewhere. Loops over arrays that the compiler turns into such operations by itself are compiled for
//! these registers too.
//!
//! Of AVX-512 there are sixteen lanes, for what takes as many as there are ([`ManyLanes`]); on eight lanes its registers and
//! masks made renders up to 6 % slower (AMD EPYC, one thread).
//!
//! All kinds do the same IEEE operations in the same order and contract nothing into fused ones, so that a picture does
//! not depend on the machine. This is the only file with `unsafe` code: the AVX intrinsics must not run on a processor
//! without AVX2, and the compiler cannot know where the program will run. Advice to the memory, by an
//! instruction and by a call of the system, is here too.

#![allow(unsafe_code, reason = "intrinsics behind a run-time check; see the module documentation")]

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::Vec3;

use crate::{Real, Vector};

/// Eight f32 lanes. Implementations are values of a register or an array.
pub trait Lanes: Real<Mask: LaneMask> {
    /// Numbers of lanes.
    type Indices: Copy;

    fn load(values: &[f32; 8]) -> Self;
    /// Numbers below 8.
    fn indices(values: &[u8; 8]) -> Self::Indices;
    /// Lane i is the one of self that the i-th number names.
    fn permute(self, indices: Self::Indices) -> Self;
    fn store(self) -> [f32; 8];
}

/// Lanes in the most that a register holds, if not more than [`MOST_LANES`].
pub trait ManyLanes: Real<Mask: LaneMask> {
    /// Eight on the same machine.
    type Eight: Lanes;
    /// How many.
    const COUNT: usize;

    /// The first [`COUNT`](Self::COUNT) numbers.
    fn load_many(values: &[f32; MOST_LANES]) -> Self;
    /// The lanes, and then zeros.
    fn store_many(self) -> [f32; MOST_LANES];
}

/// Lanes of the widest registers.
pub const MOST_LANES: usize = 16;

impl<L: Lanes> ManyLanes for L {
    type Eight = L;
    const COUNT: usize = 8;

    #[inline(always)]
    fn load_many(values: &[f32; MOST_LANES]) -> Self {
        let ([first, _], []) = values.as_chunks::<8>() else { unreachable!("two times eight") };
        Self::load(first)
    }
    #[inline(always)]
    fn store_many(self) -> [f32; MOST_LANES] {
        let mut values = [0.0; MOST_LANES];
        values[..8].copy_from_slice(&self.store());
        values
    }
}

/// What comparisons of lanes find.
pub trait LaneMask {
    /// Bit i is set where lane i is.
    fn bits(self) -> u32;
}

/// Lanes in an array, on any machine.
#[derive(Clone, Copy)]
pub struct Portable([f32; 8]);

/// Which lanes of an array are set.
#[derive(Clone, Copy)]
pub struct PortableMask([bool; 8]);

impl Portable {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f32, f32) -> bool) -> PortableMask {
        PortableMask(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl LaneMask for PortableMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..8).fold(0, |mask, i| mask | u32::from(self.0[i]) << i)
    }
}

impl BitAnd for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] & other.0[i]))
    }
}

impl BitOr for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}

impl Not for PortableMask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(|is_set| !is_set))
    }
}

impl Add for Portable {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Portable {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Portable {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Portable {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

impl Neg for Portable {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Real for Portable {
    type Mask = PortableMask;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; 8])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.zip(sign, f32::copysign)
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.zip(other, Real::least)
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.zip(other, Real::most)
    }
    #[inline(always)]
    fn is_below(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn is_at_most(self, other: Self) -> PortableMask {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn select(mask: PortableMask, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| if mask.0[i] { yes.0[i] } else { no.0[i] }))
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
    fn store(self) -> [f32; 8] {
        self.0
    }
}

#[cfg(target_arch = "x86_64")]
pub use avx::{Avx, Avx512};

#[cfg(target_arch = "x86_64")]
mod avx {
    use std::arch::x86_64::*;
    use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

    use super::{LaneMask, Lanes, MOST_LANES, ManyLanes};
    use crate::Real;

    /// Lanes in an AVX register. Only code that is inlined below a function with the `avx2` target feature, itself
    /// called after `is_x86_feature_detected!` said yes, may make one.
    #[derive(Clone, Copy)]
    pub struct Avx(__m256);

    /// Lanes of which all bits are set or none.
    #[derive(Clone, Copy)]
    pub struct AvxMask(__m256);

    /// Sixteen lanes in an AVX-512 register, likewise below a function with the `avx512f` target feature.
    #[derive(Clone, Copy)]
    pub struct Avx512(__m512);

    /// A bit for each lane.
    #[derive(Clone, Copy)]
    pub struct Avx512Mask(__mmask16);

    // SAFETY, for every block below: a value of these types exists only where its instructions do (see the types), and the loads
    // and stores are of references to as many floats or bytes, which the unaligned instructions accept at any address.

    /// Operators of two operands, an intrinsic each.
    macro_rules! operators {
        ($($kind:ident: $($trait:ident $method:ident = $intrinsic:ident),+;)+) => { $($(
            impl $trait for $kind {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: the instruction is there.
                    Self(unsafe { $intrinsic(self.0, other.0) })
                }
            }
        )+)+ };
    }

    operators! {
        Avx: Add add = _mm256_add_ps, Sub sub = _mm256_sub_ps, Mul mul = _mm256_mul_ps, Div div = _mm256_div_ps;
        AvxMask: BitAnd bitand = _mm256_and_ps, BitOr bitor = _mm256_or_ps;
        Avx512: Add add = _mm512_add_ps, Sub sub = _mm512_sub_ps, Mul mul = _mm512_mul_ps, Div div = _mm512_div_ps;
        Avx512Mask: BitAnd bitand = _kand_mask16, BitOr bitor = _kor_mask16;
    }

    impl LaneMask for AvxMask {
        #[inline(always)]
        fn bits(self) -> u32 {
            // SAFETY: AVX2 is there.
            unsafe { _mm256_movemask_ps(self.0) as u32 }
        }
    }

    impl LaneMask for Avx512Mask {
        #[inline(always)]
        fn bits(self) -> u32 {
            u32::from(self.0)
        }
    }

    impl Not for AvxMask {
        type Output = Self;
        #[inline(always)]
        fn not(self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1))) })
        }
    }

    impl Not for Avx512Mask {
        type Output = Self;
        #[inline(always)]
        fn not(self) -> Self {
            Self(!self.0)
        }
    }

    impl Neg for Avx {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
        }
    }

    impl Neg for Avx512 {
        type Output = Self;
        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: AVX-512 is there.
            let flipped =
                unsafe { _mm512_xor_si512(_mm512_castps_si512(self.0), _mm512_castps_si512(Self::splat(-0.0).0)) };
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_castsi512_ps(flipped) })
        }
    }

    impl Real for Avx {
        type Mask = AvxMask;

        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_set1_ps(value) })
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_sqrt_ps(self.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
        }
        #[inline(always)]
        fn copysign(self, sign: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_or_ps(self.abs().0, _mm256_and_ps(_mm256_set1_ps(-0.0), sign.0)) })
        }
        #[inline(always)]
        fn least(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn most(self, other: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn is_below(self, other: Self) -> AvxMask {
            // SAFETY: AVX2 is there.
            AvxMask(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn is_at_most(self, other: Self) -> AvxMask {
            // SAFETY: AVX2 is there.
            AvxMask(unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn select(mask: AvxMask, yes: Self, no: Self) -> Self {
            // SAFETY: AVX2 is there.
            Self(unsafe { _mm256_blendv_ps(no.0, yes.0, mask.0) })
        }
    }

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
        fn store(self) -> [f32; 8] {
            let mut values = [0.0; 8];
            // SAFETY: writes the eight floats of the array.
            unsafe { _mm256_storeu_ps(values.as_mut_ptr(), self.0) };
            values
        }
    }

    impl Real for Avx512 {
        type Mask = Avx512Mask;

        #[inline(always)]
        fn splat(value: f32) -> Self {
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_set1_ps(value) })
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_sqrt_ps(self.0) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_abs_ps(self.0) })
        }
        #[inline(always)]
        fn copysign(self, sign: Self) -> Self {
            /// Bits of the second operand where the first has ones, and of the third elsewhere.
            const CHOOSE: i32 = 0xca;
            // SAFETY: AVX-512 is there.
            Self(unsafe {
                let [mask, sign, own] = [Self::splat(-0.0), sign, self].map(|lanes| _mm512_castps_si512(lanes.0));
                _mm512_castsi512_ps(_mm512_ternarylogic_epi32::<CHOOSE>(mask, sign, own))
            })
        }
        #[inline(always)]
        fn least(self, other: Self) -> Self {
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_min_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn most(self, other: Self) -> Self {
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_max_ps(self.0, other.0) })
        }
        #[inline(always)]
        fn is_below(self, other: Self) -> Avx512Mask {
            // SAFETY: AVX-512 is there.
            Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn is_at_most(self, other: Self) -> Avx512Mask {
            // SAFETY: AVX-512 is there.
            Avx512Mask(unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) })
        }
        #[inline(always)]
        fn select(mask: Avx512Mask, yes: Self, no: Self) -> Self {
            // SAFETY: AVX-512 is there.
            Self(unsafe { _mm512_mask_blend_ps(mask.0, no.0, yes.0) })
        }
    }

    impl ManyLanes for Avx512 {
        type Eight = Avx;
        const COUNT: usize = 16;

        #[inline(always)]
        fn load_many(values: &[f32; MOST_LANES]) -> Self {
            // SAFETY: reads the sixteen floats behind the reference.
            Self(unsafe { _mm512_loadu_ps(values.as_ptr()) })
        }
        #[inline(always)]
        fn store_many(self) -> [f32; MOST_LANES] {
            let mut values = [0.0; MOST_LANES];
            // SAFETY: writes the sixteen floats of the array.
            unsafe { _mm512_storeu_ps(values.as_mut_ptr(), self.0) };
            values
        }
    }
}

/// Eight vectors in memory, component by component.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vectors([[f32; 8]; 3]);

impl Vectors {
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        [self.0[0][lane], self.0[1][lane], self.0[2][lane]] = v.to_array();
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.0[0][lane], self.0[1][lane], self.0[2][lane])
    }

    #[inline(always)]
    pub fn load<L: Lanes>(&self) -> Vector<L> {
        Vector::new(L::load(&self.0[0]), L::load(&self.0[1]), L::load(&self.0[2]))
    }

    #[inline(always)]
    pub fn store<L: Lanes>(v: Vector<L>) -> Self {
        Self([v.x.store(), v.y.store(), v.z.store()])
    }
}

/// Asks the memory for what will be needed.
#[inline(always)]
pub fn prefetch<T>(value: &T) {
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
pub fn prefer_huge_pages<T>(values: &Vec<T>) {
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
pub fn compact<T: Copy>(values: &[T]) -> Vec<T> {
    let mut all = Vec::with_capacity(values.len());
    prefer_huge_pages(&all);
    all.extend_from_slice(values);
    all
}

/// Defines a function that runs its generic body with the widest lanes this machine has. The body must be
/// `#[inline(always)]`, so that it is compiled once more under the `avx2` target feature.
#[macro_export]
macro_rules! with_widest_lanes {
    (
        fn $name:ident $(<$generic:ident: $bound:path>)?
        ($($argument:ident: $type:ty),* $(,)?) -> $output:ty = $body:ident
    ) => {
        $crate::on_widest_registers! {
            fn $name $(<$generic: $bound>)? ($($argument: $type),*) -> $output {
                wide: $body::<$crate::Avx, $($generic)?>($($argument),*),
                portable: $body::<$crate::Portable, $($generic)?>($($argument),*),
            }
        }
    };
}

/// The same with as many lanes as the widest registers of this machine have.
#[macro_export]
macro_rules! with_most_lanes {
    (
        fn $name:ident <$generic:ident: $bound:path> ($($argument:ident: $type:ty),* $(,)?) -> $output:ty = $body:ident
    ) => {
        #[inline]
        fn $name<$generic: $bound>($($argument: $type),*) -> $output {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx512f")]
                fn sixteen<$generic: $bound>($($argument: $type),*) -> $output {
                    $body::<$crate::Avx512, $generic>($($argument),*)
                }
                if std::arch::is_x86_feature_detected!("avx512f") {
                    #[allow(unsafe_code, reason = "the one call that the check above makes sound")]
                    // SAFETY: the processor has AVX-512, as was just asked.
                    return unsafe { sixteen($($argument),*) };
                }
            }
            $crate::with_widest_lanes! {
                fn eight<$generic: $bound>($($argument: $type),*) -> $output = $body
            }
            eight($($argument),*)
        }
    };
}

/// The same for a body whose loops the compiler turns into operations on lanes by itself.
#[macro_export]
macro_rules! with_widest_registers {
    (fn $name:ident ($($argument:ident: $type:ty),* $(,)?) -> $output:ty = $body:ident) => {
        $crate::on_widest_registers! {
            fn $name($($argument: $type),*) -> $output {
                wide: $body($($argument),*),
                portable: $body($($argument),*),
            }
        }
    };
}

/// Defines a function that runs the first of two expressions where the machine has AVX2, compiled for it, and the second
/// elsewhere.
#[macro_export]
macro_rules! on_widest_registers {
    (
        fn $name:ident $(<$generic:ident: $bound:path>)?
        ($($argument:ident: $type:ty),* $(,)?) -> $output:ty {
            wide: $wide:expr,
            portable: $portable:expr $(,)?
        }
    ) => {
        #[inline]
        fn $name $(<$generic: $bound>)? ($($argument: $type),*) -> $output {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide $(<$generic: $bound>)? ($($argument: $type),*) -> $output {
                    $wide
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    #[allow(unsafe_code, reason = "the one call that the check above makes sound")]
                    // SAFETY: the processor has AVX2, as was just asked.
                    return unsafe { wide$(::<$generic>)?($($argument),*) };
                }
            }
            $portable
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation on the given lanes, as bits.
    #[inline(always)]
    fn every_operation<L: Lanes>(a: &[f32; 8], b: &[f32; 8]) -> Vec<u32> {
        let (x, y) = (L::load(a), L::load(b));
        let turned = x.permute(L::indices(&[7, 0, 0, 3, 2, 6, 5, 1]));
        let both = x.is_below(y) & !y.is_at_most(L::splat(3.0));
        let results = [
            [x + y, x - y, x * y, x / y, x.least(y), x.most(y)],
            [L::splat(a[0]), turned, -x, x.abs(), x.sqrt(), x.copysign(y)],
            [L::select(both, x, y); 6],
        ];
        // The sign of a NaN is nobody's promise.
        let canonical = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
        let mut bits: Vec<u32> = results.as_flattened().iter().flat_map(|r| r.store().map(canonical)).collect();
        bits.extend([x.is_at_most(y).bits(), x.is_below(y).bits(), both.bits()]);
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

    /// Every operation on as many lanes as there are, for sixteen pairs, as bits.
    #[inline(always)]
    fn every_operation_on<L: ManyLanes, P: Pairs>(pairs: &P) -> Vec<[u32; 2]> {
        let all = pairs.get();
        let mut bits = Vec::new();
        for pairs in all.chunks(L::COUNT) {
            let (mut a, mut b) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
            for (lane, &[x, y]) in pairs.iter().enumerate() {
                (a[lane], b[lane]) = (x, y);
            }
            let (x, y) = (L::load_many(&a), L::load_many(&b));
            let both = x.is_below(y) & !y.is_at_most(L::splat(3.0)) | y.is_below(x);
            let results = [x + y, x - y, x * y, x / y, x.least(y), x.most(y), -x, x.abs(), x.sqrt(), x.copysign(y)];
            let chosen = L::select(both, x, y).store_many();
            let results = results.map(L::store_many);
            for lane in 0..pairs.len() {
                let canonical = |x: f32| if x.is_nan() { u32::MAX } else { x.to_bits() };
                bits.extend(results.map(|lanes| [lane as u32, canonical(lanes[lane])]));
                bits.push([both.bits() >> lane & 1, canonical(chosen[lane])]);
            }
        }
        bits.into_iter().map(|[a, b]| [a % 8, b]).collect()
    }

    /// Where numbers come from.
    trait Pairs {
        fn get(&self) -> Vec<[f32; 2]>;
    }

    struct Strange;

    impl Pairs for Strange {
        fn get(&self) -> Vec<[f32; 2]> {
            let numbers = [1.0, -2.5, 0.0, -0.0, f32::INFINITY, 1e-40, 3.0, f32::NAN];
            numbers.iter().flat_map(|&a| numbers.map(|b| [a, b])).collect()
        }
    }

    with_most_lanes! {
        fn most<P: Pairs>(pairs: &P) -> Vec<[u32; 2]> = every_operation_on
    }

    #[test]
    fn many_lanes_agree_with_eight_bit_by_bit() {
        assert_eq!(most(&Strange), every_operation_on::<Portable, _>(&Strange));
    }

    #[test]
    fn a_nan_yields_to_the_second_operand() {
        let nan = Portable::splat(f32::NAN);
        assert_eq!(nan.least(Portable::splat(2.0)).store(), [2.0; 8]);
        assert_eq!(nan.most(Portable::splat(2.0)).store(), [2.0; 8]);
        assert_eq!(nan.is_at_most(nan).bits(), 0);
    }
}
