//! Film's soft shoulder.

/// x(2.51x + 0.03)/(x(2.43x + 0.59) + 0.14) for x ≥ 0: a fit to the Academy's reference rendering, with a soft toe and
/// a shoulder that reaches 1 near x = 7 and stays below 1.033 ([Narkowicz16](photosite_core::references#narkowicz16)).
pub(super) fn curve(x: f32) -> f32 {
    let x = x.max(0.0);
    // Beyond here squares would overflow; the curve is at its end.
    let x = x.min(1e6);
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filmic_curve_rises_from_black_to_white() {
        let values: Vec<f32> = (0..1000).map(|i| curve(i as f32 * 0.02)).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        assert_eq!([curve(0.0), curve(-1.0)], [0.0, 0.0]);
        // By a calculator: 1·2.54/(3.02 + 0.14).
        assert!((curve(1.0) - 0.803_797_5).abs() < 1e-6);
        assert!((curve(f32::INFINITY) - 2.51 / 2.43).abs() < 1e-3);
    }
}
