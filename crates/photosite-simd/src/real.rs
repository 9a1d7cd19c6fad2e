//! Formulas that are the same for one number and for several at a time: numbers, comparisons, and vectors of three.
//!
//! A function over a [`Real`] does the same IEEE operations in the same order for an `f32` and in each lane of a
//! register, so that both give the same bits. Where a formula has two branches, lanes compute both and
//! [`select`](Real::select).

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use glam::Vec3;

/// A number, or one in each lane of a register.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The result of a comparison, in each lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;

    /// Constant `value` in as many lanes as `self` has; existing lanes are the evidence that the processor supports
    /// them.
    #[must_use]
    fn broadcast(self, value: f32) -> Self;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Magnitude.
    #[must_use]
    fn abs(self) -> Self;
    /// The magnitude with the sign of another number.
    #[must_use]
    fn copysign(self, sign: Self) -> Self;
    /// Minimum of two numbers; `other` where either is NaN.
    #[must_use]
    fn min(self, other: Self) -> Self;
    /// Maximum of two numbers; `other` where either is NaN.
    #[must_use]
    fn max(self, other: Self) -> Self;
    /// Comparison `self` < `other`; false where either is NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// Comparison `self` ≤ `other`; false where either is NaN.
    fn le(self, other: Self) -> Self::Mask;
    /// Selection of `yes` where the mask is set, and of `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

impl Real for f32 {
    type Mask = bool;

    #[inline(always)]
    fn broadcast(self, value: f32) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

/// A vector of three numbers, or of three in each lane. Its operations are those of [`Vec3`], in the same order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

impl<R: Real> Vector<R> {
    /// Vector of three components.
    #[inline(always)]
    pub fn new(x: R, y: R, z: R) -> Self {
        Self { x, y, z }
    }

    /// Constant vector `v` in as many lanes as `self` has.
    #[inline(always)]
    #[must_use]
    pub fn broadcast(self, v: Vec3) -> Self {
        Self::new(self.x.broadcast(v.x), self.x.broadcast(v.y), self.x.broadcast(v.z))
    }

    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// Vector product.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self::new(
            self.y * other.z - other.y * self.z,
            self.z * other.x - other.z * self.x,
            self.x * other.y - other.x * self.y,
        )
    }

    /// Magnitudes of the components.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// Vector of the same direction with length 1, or `other` where the length is 0 or infinite.
    #[inline(always)]
    #[must_use]
    pub fn normalize_or(self, other: Self) -> Self {
        let squared = self.dot(self);
        let inverse = squared.broadcast(1.0) / squared.sqrt();
        let has_length = squared.broadcast(0.0).lt(inverse) & inverse.lt(squared.broadcast(f32::INFINITY));
        Self::select(has_length, self * inverse, other)
    }

    /// Vector with each component divided by a number.
    #[inline(always)]
    #[must_use]
    pub fn over(self, divisor: R) -> Self {
        Self::new(self.x / divisor, self.y / divisor, self.z / divisor)
    }

    /// Selection of `yes` where the mask is set, and of `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self::new(R::select(mask, yes.x, no.x), R::select(mask, yes.y, no.y), R::select(mask, yes.z, no.z))
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: R) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

impl<R: Real> Neg for Vector<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl From<Vec3> for Vector<f32> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl From<Vector<f32>> for Vec3 {
    #[inline(always)]
    fn from(v: Vector<f32>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_are_those_of_glam_bit_by_bit() {
        let (a, b) = (Vec3::new(0.1, -2.7, 3.3), Vec3::new(-5.7, 0.9, 1.0 / 3.0));
        let (v, w) = (Vector::from(a), Vector::from(b));
        assert_eq!(v.dot(w).to_bits(), a.dot(b).to_bits());
        assert_eq!(Vec3::from(v.cross(w)), a.cross(b));
        assert_eq!(Vec3::from(v + w), a + b);
        assert_eq!(Vec3::from(v - w), a - b);
        assert_eq!(Vec3::from(v * 0.7), a * 0.7);
        assert_eq!(Vec3::from(v.over(0.7)), a / 0.7);
        assert_eq!(Vec3::from(-v.abs()), -a.abs());
        assert_eq!(Vec3::from(v.normalize_or(w)), a.normalize_or(b));
        for short in [Vec3::ZERO, Vec3::splat(1e-30), Vec3::splat(f32::NAN)] {
            assert_eq!(Vec3::from(Vector::from(short).normalize_or(w)), short.normalize_or(b), "{short}");
        }
    }
}
