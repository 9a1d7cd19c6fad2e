//! Mean and temporal variance of two images of the same light.

use photosite_core::Invalid;

/// Statistics of two images taken of the same light ([Emva1288](photosite_core::references#emva1288), section on mean
/// and variance of gray value), in DN:
///
/// - μ_y = (μ\[0\] + μ\[1\])/2, the mean of both images
/// - σ_y² = Σ(y\[0\] − y\[1\])²/(2·N) − (μ\[0\] − μ\[1\])²/2 over the N pixels: fixed patterns and what is common to
///   all pixels of an image cancel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PairStatistics {
    /// μ_y, DN.
    pub mean: f64,
    /// σ_y², DN².
    pub variance: f64,
}

impl PairStatistics {
    /// Statistics of two images of the same size, which must have pixels.
    pub fn new(first: &[u16], second: &[u16]) -> Result<Self, Invalid> {
        if first.is_empty() || first.len() != second.len() {
            let message = format!("images of {} and of {} pixels do not form a pair", first.len(), second.len());
            return Err(Invalid::new("", message));
        }
        // Sums of integers are exact: squares of 32 bits for up to 2³² pixels.
        let (mut sums, mut squares) = ([0u64; 2], 0u64);
        for (&a, &b) in first.iter().zip(second) {
            sums[0] += u64::from(a);
            sums[1] += u64::from(b);
            squares += u64::from(a.abs_diff(b)).pow(2);
        }
        let pixels = first.len() as f64;
        let means = sums.map(|sum| sum as f64 / pixels);
        Ok(Self {
            mean: 0.5 * (means[0] + means[1]),
            variance: squares as f64 / (2.0 * pixels) - 0.5 * (means[0] - means[1]).powi(2),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_patterns_and_common_steps_cancel() {
        // Differences −1, 1, 1, −1 on top of any pattern: Σd²/(2·4) = 0.5.
        let pair = PairStatistics::new(&[10, 201, 33, 64], &[11, 200, 32, 65]).expect("a pair");
        assert_eq!(pair, PairStatistics { mean: 77.0, variance: 0.5 });
        // The second image is brighter by 3 as a whole.
        let shifted = PairStatistics::new(&[10, 201, 33, 64], &[14, 203, 35, 68]).expect("a pair");
        assert_eq!(shifted, PairStatistics { mean: 78.5, variance: 0.5 });
        assert!(PairStatistics::new(&[1, 2], &[1]).is_err() && PairStatistics::new(&[], &[]).is_err());
    }
}
