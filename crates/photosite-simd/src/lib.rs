//! Arithmetic on eight or sixteen `f32` at a time, on the registers that the processor turns out to have.
//!
//! A formula is written once, over a [`Real`]: one number, or several in lanes. An operation on many numbers is written
//! over a [`Simd`], the evidence that the processor has certain instructions, and is handed to [`dispatch`], which
//! looks for the widest instructions and runs the operation with them:
//!
//! ```
//! use photosite_simd::{Lanes, Real, Simd, WithSimd, dispatch};
//!
//! /// 1/√x of eight numbers.
//! struct InverseRoots<'a>(&'a [f32; 8]);
//!
//! impl WithSimd for InverseRoots<'_> {
//!     type Output = [f32; 8];
//!
//!     #[inline(always)]
//!     fn with_simd<S: Simd>(self, simd: S) -> [f32; 8] {
//!         (simd.broadcast(1.0) / simd.load(self.0).sqrt()).store()
//!     }
//! }
//!
//! assert_eq!(dispatch(InverseRoots(&[4.0; 8])), [0.5; 8]);
//! ```
//!
//! # Why this is sound
//!
//! A token of wide instructions, `Avx2` or `Avx512`, is made by its `detect` alone, which asks the processor. Lanes are
//! made from a token or from other lanes. So no such instruction runs on a processor without it, whatever safe code
//! does. Every processor of AArch64 has NEON: anyone may make the token `Neon`, as [`Portable`]. All `unsafe` code of
//! photosite is in this crate.
//!
//! # Why results do not depend on the machine
//!
//! All kinds of lanes do the same IEEE operations in the same order as a single number would, and none is contracted
//! into a fused one.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod dispatch;
mod heap;
mod lanes;
mod memory;
#[cfg(target_arch = "aarch64")]
mod neon;
mod operation;
mod portable;
mod real;

#[cfg(target_arch = "x86_64")]
pub use avx2::{Avx2, Avx2Lanes, Avx2Mask};
#[cfg(target_arch = "x86_64")]
pub use avx512::{Avx512, Avx512Lanes, Avx512Mask};
pub use dispatch::{dispatch, dispatch_wide};
pub use heap::Heap;
pub use lanes::{IdLanes, LANES, LaneMask, Lanes, MAX_LANES, Simd, Vectors, WideLanes};
pub use memory::{compact, prefer_huge_pages, prefetch};
#[cfg(target_arch = "aarch64")]
pub use neon::{Neon, NeonLanes, NeonMask};
pub use operation::WithSimd;
pub use portable::{Portable, PortableLanes, PortableMask};
pub use real::{Real, Vector};
