//! The function space: a quadratic polynomial of wavelength, squeezed into 0–1.

use glam::{DVec4, Vec4};

use crate::spectrum::{SampledSpectrum, Spectrum, Wavelengths};

/// Range of the fit, nm; beyond it the value at the nearer end holds. A colour implies nothing about the reflectance
/// there.
pub const RANGE_NM: [f32; 2] = [360.0, 830.0];

const CENTRE_NM: f32 = 0.5 * (RANGE_NM[0] + RANGE_NM[1]);
const HALF_WIDTH_NM: f32 = 0.5 * (RANGE_NM[1] - RANGE_NM[0]);

/// A smooth spectrum with values in [0, 1] ([JakobHanika19](crate::references#jakobhanika19) eqs. 4–5):
///
/// S(λ) = ½ + p/(2√(1 + p²)), p = c₀t² + c₁t + c₂, t = (λ − 595 nm)/235 nm.
///
/// The coefficients are kept as homogeneous coordinates (b, w) with c = b/w, of any length: S = ½ + P/(2√(w² + P²))
/// with P = b₀t² + b₁t + b₂. Black and white, whose c is infinite, are then ordinary points with w = 0, and
/// interpolating between polynomials is harmless. w is never negative; w and b are not all zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SigmoidPolynomial(Vec4);

impl SigmoidPolynomial {
    /// Polynomial of homogeneous coordinates (b₀, b₁, b₂, w).
    pub(super) fn from_homogeneous(coordinates: Vec4) -> Self {
        Self(coordinates)
    }

    /// Constant spectrum of a value in [0, 1], exact at every wavelength.
    #[inline]
    pub fn constant(value: f32) -> Self {
        // With P = v − ½ and w² = v(1 − v) the root is ½.
        Self(Vec4::new(0.0, 0.0, value - 0.5, (value * (1.0 - value)).max(0.0).sqrt()))
    }

    /// Homogeneous coordinates (b₀, b₁, b₂, w).
    pub(super) fn homogeneous(self) -> Vec4 {
        self.0
    }

    /// Value at a wavelength in nm.
    #[inline]
    pub fn eval(self, lambda_nm: f32) -> f32 {
        let [b0, b1, b2, w] = self.0.to_array();
        let t = (lambda_nm.clamp(RANGE_NM[0], RANGE_NM[1]) - CENTRE_NM) * (1.0 / HALF_WIDTH_NM);
        let p = (b0 * t + b1) * t + b2;
        0.5 + 0.5 * p / (w * w + p * p).sqrt().max(f32::MIN_POSITIVE)
    }

    /// Values at the wavelengths of a path.
    #[inline]
    pub fn sample(self, wavelengths: &Wavelengths) -> SampledSpectrum {
        let [low, high] = RANGE_NM.map(Vec4::splat);
        let lambda = Vec4::from_array(wavelengths.lambdas_nm()).clamp(low, high);
        let t = (lambda - CENTRE_NM) * (1.0 / HALF_WIDTH_NM);
        let p = (self.0.x * t + self.0.y) * t + self.0.z;
        let length = (p * p + self.0.w * self.0.w).sqrt().max(Vec4::splat(f32::MIN_POSITIVE));
        SampledSpectrum(0.5 + 0.5 * p / length)
    }

    /// The value at every nanometre from 300 to 1100 nm.
    pub fn to_spectrum(self) -> Spectrum {
        Spectrum::from_fn(|lambda| f64::from(self.eval(lambda as f32))).known_within(RANGE_NM)
    }
}

/// S and its derivatives by b₀, b₁, b₂, w at `lambda_nm`, in f64 for fitting.
pub(super) fn value_and_gradient(v: DVec4, lambda_nm: f64) -> (f64, DVec4) {
    let t = (lambda_nm - f64::from(CENTRE_NM)) / f64::from(HALF_WIDTH_NM);
    let p = (v.x * t + v.y) * t + v.z;
    let length = (p * p + v.w * v.w).sqrt().max(f64::MIN_POSITIVE);
    // d(P/√(w² + P²)) = (w²·dP − w·P·dw)/(w² + P²)^{3/2}
    let (p, w) = (p / length, v.w / length);
    let by_p = 0.5 * w * w / length;
    (0.5 + 0.5 * p, DVec4::new(by_p * t * t, by_p * t, by_p, -0.5 * w * p / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_are_constant_to_the_last_bit_or_two() {
        for i in 0..=255 {
            let value = i as f32 / 255.0;
            for lambda in [300.0, 360.0, 555.5, 1100.0] {
                // A handful of roundings of numbers around ½.
                assert!((SigmoidPolynomial::constant(value).eval(lambda) - value).abs() <= 2.0 * f32::EPSILON);
            }
        }
        assert_eq!(SigmoidPolynomial::constant(0.0).eval(500.0), 0.0);
        assert_eq!(SigmoidPolynomial::constant(1.0).eval(500.0), 1.0);
    }

    #[test]
    fn lanes_agree_with_single_values_and_ends_hold() {
        let s = SigmoidPolynomial(Vec4::new(1.5, -0.7, -0.2, 0.4));
        let lambda = [300.0, 420.0, 640.0, 1100.0];
        let lanes = s.sample(&Wavelengths::new(lambda, [1.0; 4])).to_array();
        for (lane, lambda) in lanes.into_iter().zip(lambda) {
            assert!((lane - s.eval(lambda)).abs() < 1e-6);
        }
        assert_eq!(s.eval(300.0), s.eval(360.0));
        assert_eq!(s.eval(1100.0), s.eval(830.0));
    }

    #[test]
    fn gradient_is_that_of_finite_differences() {
        let v = DVec4::new(0.8, -0.5, 0.1, 0.3);
        let (_, gradient) = value_and_gradient(v, 512.0);
        for axis in 0..4 {
            let h = 1e-5;
            let mut ends = [v, v];
            ends[0][axis] -= h;
            ends[1][axis] += h;
            let [low, high] = ends.map(|v| value_and_gradient(v, 512.0).0);
            // Central differences: error of h² = 1e-10 times third derivatives of order 10².
            assert!((gradient[axis] - (high - low) / (2.0 * h)).abs() < 1e-7);
        }
    }
}
