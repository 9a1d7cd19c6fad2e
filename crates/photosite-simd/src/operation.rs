//! Operations on numbers in lanes.

use crate::Simd;

/// An operation that runs with whatever instructions the processor has.
///
/// An operation is implemented by a struct of its arguments rather than a closure, since no closure is generic over
/// the kind of lanes.
pub trait WithSimd {
    /// Result of the operation.
    type Output;

    /// Runs the operation.
    ///
    /// Write `#[inline(always)]` on this and on all that it calls in hot loops: only what is inlined into
    /// [`dispatch`](crate::dispatch())'s own function is compiled for the instructions of `simd`. That holds too for
    /// loops over arrays, which the compiler turns into wide instructions by itself and which need `simd` for nothing
    /// else. Code that is not inlined is correct but slow. Closures cannot be marked so; use functions or loops
    /// instead.
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output;
}
