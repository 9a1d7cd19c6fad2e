//! Numbers as fractions of 32-bit integers, which TIFF and EXIF want.

use tiff::encoder::{Rational, SRational};

/// The closest fraction whose parts fit `limit`, by continued fractions. `value` is finite, not negative; above `limit`
/// it becomes the limit.
fn fraction(value: f64, limit: u32) -> (u32, u32) {
    if value >= f64::from(limit) {
        return (limit, 1);
    }
    // Convergents h/k of the continued fraction a₀ + 1/(a₁ + 1/(a₂ + …)): hᵢ = aᵢ·hᵢ₋₁ + hᵢ₋₂, kᵢ likewise.
    let (mut h, mut h_before) = (1u64, 0u64);
    let (mut k, mut k_before) = (0u64, 1u64);
    let mut rest = value;
    loop {
        let whole = rest.floor();
        let next = |last: u64, before: u64| (whole as u64).checked_mul(last).and_then(|p| p.checked_add(before));
        let (Some(next_h), Some(next_k)) = (next(h, h_before), next(k, k_before)) else { break };
        if next_h > u64::from(limit) || next_k > u64::from(limit) {
            break;
        }
        (h, h_before, k, k_before) = (next_h, h, next_k, k);
        let error = (h as f64 / k as f64 - value).abs();
        // Twelve digits are more than any of these numbers is known to, and keep 0.01 at 1/100.
        if rest == whole || error <= 1e-12 * value {
            break;
        }
        rest = 1.0 / (rest - whole);
    }
    // At least the first convergent, ⌊value⌋/1, fits; both parts are below the limit.
    (h as u32, k as u32)
}

/// A number of 0 and more as a TIFF RATIONAL.
pub(super) fn rational(value: f64) -> Rational {
    let (n, d) = fraction(sane(value), u32::MAX);
    Rational { n, d }
}

/// A number as a TIFF SRATIONAL.
pub(super) fn srational(value: f64) -> SRational {
    let (n, d) = fraction(sane(value), i32::MAX as u32);
    let sign = if value < 0.0 { -1 } else { 1 };
    SRational { n: sign * n as i32, d: d as i32 }
}

/// The magnitude, and 0 for what no number is.
fn sane(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.abs() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_fractions_stay_short() {
        for (value, n, d) in [(0.01, 1, 100), (2.8, 14, 5), (1.0, 1, 1), (0.0, 0, 1), (1.0 / 3.0, 1, 3), (30.0, 30, 1)]
        {
            let r = rational(value);
            assert_eq!((r.n, r.d), (n, d), "{value}");
        }
        let r = srational(-0.25);
        assert_eq!((r.n, r.d), (-1, 4));
    }

    #[test]
    fn any_number_comes_out_close() {
        for exponent in -8..9 {
            for mantissa in [1.0, std::f64::consts::PI, 9.999_999_9] {
                let value = mantissa * 10f64.powi(exponent);
                let r = rational(value);
                let back = f64::from(r.n) / f64::from(r.d);
                // Half the spacing of fractions n/d with one part at its limit of 2³²: 2⁻³³ relative where the value is
                // above 2⁻³², and as much absolutely below.
                let spacing = 2f64.powi(-32);
                assert!((back - value).abs() <= value * spacing + spacing * spacing.max(value), "{value} {back}");
            }
        }
    }

    #[test]
    fn what_does_not_fit_is_clamped() {
        assert_eq!(rational(1e300).n, u32::MAX);
        assert_eq!(rational(f64::INFINITY).n, u32::MAX);
        assert_eq!(rational(f64::NAN).n, 0);
        assert_eq!(srational(-1e300).n, -i32::MAX);
    }
}
