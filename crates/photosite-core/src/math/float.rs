//! Bounds on floating-point rounding error, after [pbrt4](crate::references#pbrt4) §6.8.1, and rounding for display.

/// γₙ = n·ε/(1 − n·ε): the relative error of n chained f32 operations is at most γₙ, with ε = 2⁻²⁴ (eq. 6.20).
pub const fn gamma(n: u32) -> f32 {
    let half_ulp = f32::EPSILON * 0.5;
    (n as f32 * half_ulp) / (1.0 - n as f32 * half_ulp)
}

/// Rounds to a number of significant digits, for display.
pub fn rounded(x: f64, digits: i32) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let scale = 10f64.powf(f64::from(digits - 1) - x.abs().log10().floor());
    if scale.is_finite() && scale > 0.0 { (x * scale).round() / scale } else { x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_bounds_a_chain_of_sums() {
        let (n, x) = (64, 0.1f32);
        let sum = (1..n).fold(x, |sum, _| sum + x);
        let exact = f64::from(x) * f64::from(n);
        assert!((f64::from(sum) - exact).abs() <= exact * f64::from(gamma(n as u32)));
    }
}
