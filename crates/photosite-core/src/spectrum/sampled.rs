//! The values of a spectral quantity at the four wavelengths of a path.

use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Sub};

use glam::Vec4;

use super::LANES;

/// Values at the path's [`Wavelengths`](super::Wavelengths), lane by lane; the first lane is the hero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SampledSpectrum(pub Vec4);

impl SampledSpectrum {
    /// Zero at every wavelength.
    pub const ZERO: Self = Self(Vec4::ZERO);
    /// One at every wavelength.
    pub const ONE: Self = Self(Vec4::ONE);

    /// A constant spectrum.
    #[inline]
    pub const fn splat(value: f32) -> Self {
        Self(Vec4::splat(value))
    }

    /// A spectrum from one value per lane.
    #[inline]
    pub fn from_lanes(lane: impl FnMut(usize) -> f32) -> Self {
        Self(Vec4::from_array(std::array::from_fn(lane)))
    }

    /// The function `f` of the value in every lane.
    #[inline]
    #[must_use]
    pub fn map(self, mut f: impl FnMut(f32) -> f32) -> Self {
        Self::from_lanes(|i| f(self.0[i]))
    }

    /// Values lane by lane.
    #[inline]
    pub fn to_array(self) -> [f32; LANES] {
        self.0.to_array()
    }

    /// Largest value.
    #[inline]
    pub fn max(self) -> f32 {
        self.0.max_element()
    }

    /// Mean over the lanes.
    #[inline]
    pub fn mean(self) -> f32 {
        self.0.element_sum() * (1.0 / LANES as f32)
    }

    /// Whether every value is zero.
    #[inline]
    pub fn is_black(self) -> bool {
        self.0 == Vec4::ZERO
    }

    /// Whether every value is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.is_finite()
    }
}

impl From<[f32; LANES]> for SampledSpectrum {
    #[inline]
    fn from(lanes: [f32; LANES]) -> Self {
        Self(Vec4::from_array(lanes))
    }
}

impl Index<usize> for SampledSpectrum {
    type Output = f32;
    #[inline]
    fn index(&self, lane: usize) -> &f32 {
        &self.0.as_ref()[lane]
    }
}

impl Add for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl AddAssign for SampledSpectrum {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.0 += other.0;
    }
}

impl Sub for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl Mul for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl MulAssign for SampledSpectrum {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        self.0 *= other.0;
    }
}

impl Mul<f32> for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f32) -> Self {
        Self(self.0 * factor)
    }
}

impl MulAssign<f32> for SampledSpectrum {
    #[inline]
    fn mul_assign(&mut self, factor: f32) {
        self.0 *= factor;
    }
}

impl Div for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl Div<f32> for SampledSpectrum {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f32) -> Self {
        Self(self.0 / divisor)
    }
}
