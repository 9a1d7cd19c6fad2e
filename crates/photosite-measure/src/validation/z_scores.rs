//! Per-pixel z-scores and how they are distributed.
//!
//! Two estimates a and b of the same quantity, with the variances of their means, give z = (a − b)/√(var a + var b).
//! Where both estimate the same quantity and are normally distributed, z follows N(0, 1): mean 0, spread 1,
//! 4.55 % beyond 2, 0.27 % beyond 3, 63 in a million beyond 4.
//!
//! **From few samples they do not.** A variance is estimated from the same n samples as its mean, so that z of normal
//! samples follows Student's t with 2·(n − 1) degrees of freedom: among 480 000 numbers, with the bound of
//! [`Verdict`](super::Verdict) at |z| = 5.6, one expects 30 beyond it from 8 samples a pixel on either side, 0.06 from
//! 64, and 0.01 from very many. Samples of light transport are skew besides: rare bright paths that have not come yet
//! are missing from the mean and from the variance alike, which makes tails longer. A stratified sampler's variance is
//! too large, since it is computed as if samples were independent, and the spread falls below 1
//! ([Jung20](photosite_core::references#jung20) discuss all three).

use serde::Serialize;

use photosite_core::math::normal;
use photosite_core::math::statistics::{Moments, kolmogorov_smirnov, kolmogorov_smirnov_p_value};

/// (a − b)/√(var a + var b): infinite where numbers without variance differ, `None` where they are equal.
pub(super) fn z_score(difference: f64, variance: f64) -> Option<f64> {
    let z = difference / variance.sqrt();
    (!z.is_nan()).then_some(z)
}

/// Distribution of the z-scores of a channel. Mean, spread, tails and distance are those of the finite ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZScores {
    /// z-scores, infinite ones included.
    pub tests: usize,
    /// Pixels left out: equal, without any variance.
    pub equal_without_variance: usize,
    /// Pixels with infinite z: different, without any variance.
    pub different_without_variance: usize,
    /// Mean, 0 if images agree.
    pub mean: f64,
    /// z-score of the channel as a whole, Σ(a − b)/√Σ(var a + var b): a faint difference of all pixels, lost in the
    /// noise of each, shows here. Infinite (`null` in JSON) where there is no variance at all; 0 for equal images.
    pub of_mean: f64,
    /// Standard deviation, 1 if images agree and their variances are right.
    pub spread: f64,
    /// Tails: the parts of the z-scores that lie far out.
    pub tails: [Tail; 3],
    /// Largest |z| of all; infinite (`null` in JSON) where pixels without variance differ.
    pub largest: f64,
    /// Kolmogorov–Smirnov distance from N(0, 1): the largest difference of the cumulated distributions, 0–1.
    pub ks_distance: f64,
    /// Probability of at least this distance if pixels are independent and follow N(0, 1). Many pixels make it tiny for
    /// distances that are of no account; it has no part in the verdict.
    pub ks_p_value: f64,
}

/// The part of z-scores on both sides beyond a number of standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tail {
    /// Standard deviations.
    pub sigma: f64,
    /// The part of the z-scores with |z| > sigma.
    pub fraction: f64,
    /// The part of N(0, 1).
    pub expected: f64,
}

impl ZScores {
    /// Distribution for the differences a − b of pixels and their variances.
    pub(super) fn new(differences: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let mut equal_without_variance = 0;
        let z_scores = differences.clone().map(|(difference, variance)| z_score(difference, variance));
        let defined = z_scores.inspect(|z| equal_without_variance += usize::from(z.is_none())).flatten();
        let (mut finite, infinite): (Vec<f64>, Vec<f64>) = defined.partition(|z| z.is_finite());
        finite.sort_by(f64::total_cmp);
        let moments: Moments = finite.iter().copied().collect();
        let ks_distance = kolmogorov_smirnov(&finite, normal::cdf);
        let n = finite.len().max(1) as f64;
        let tail = |sigma: f64| {
            let inside = finite.partition_point(|&z| z <= sigma) - finite.partition_point(|&z| z < -sigma);
            let fraction = (finite.len() - inside) as f64 / n;
            Tail { sigma, fraction, expected: normal::two_sided_p_value(sigma) }
        };
        let (sum, variance) = differences.fold((0.0, 0.0), |(d, v), pixel| (d + pixel.0, v + pixel.1));
        Self {
            tests: finite.len() + infinite.len(),
            equal_without_variance,
            different_without_variance: infinite.len(),
            mean: moments.mean(),
            of_mean: z_score(sum, variance).unwrap_or(0.0),
            spread: moments.variance().sqrt(),
            tails: [2.0, 3.0, 4.0].map(tail),
            largest: finite.iter().chain(&infinite).fold(0.0, |largest, z| z.abs().max(largest)),
            ks_distance,
            ks_p_value: kolmogorov_smirnov_p_value(ks_distance, finite.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;
    use rand_distr::StandardNormal;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    use super::*;
    use photosite_core::math::philox::Philox;
    use photosite_core::math::statistics::sidak_p_value;

    const N: usize = 100_000;

    /// Differences with normal noise of variance 4, whose variance is said to be `variance`.
    fn noise(variance: f64) -> ZScores {
        let mut random = Philox::new(7, 0);
        let noise: Vec<(f64, f64)> =
            (0..N).map(|_| (2.0 * random.sample::<f64, _>(StandardNormal), variance)).collect();
        ZScores::new(noise.into_iter())
    }

    #[test]
    fn normal_noise_gives_the_normal_distribution() {
        let z = noise(4.0);
        let n = N as f64;
        // Standard errors: of a mean 1/√n, of a spread 1/√(2n), of a fraction √(p(1 − p)/n). 4 of each.
        assert!(z.mean.abs() < 4.0 / n.sqrt(), "{z:?}");
        assert!((z.of_mean - z.mean * n.sqrt()).abs() < 1e-9, "{z:?}");
        assert!((z.spread - 1.0).abs() < 4.0 / (2.0 * n).sqrt(), "{z:?}");
        for (tail, expected) in z.tails.iter().zip([0.045_500_26, 0.002_699_80, 0.000_063_34]) {
            assert!((tail.expected - expected).abs() < 1e-8);
            assert!((tail.fraction - expected).abs() < 4.0 * (expected * (1.0 - expected) / n).sqrt(), "{z:?}");
        }
        assert!(z.ks_p_value > 1e-3 && z.tests == N, "{z:?}");
    }

    #[test]
    fn a_wrong_variance_shows_in_the_spread_and_the_distance() {
        let z = noise(4.0 / 1.05f64.powi(2));
        assert!((z.spread / noise(4.0).spread - 1.05).abs() < 1e-9, "{z:?}");
        assert!(z.ks_p_value < 1e-3, "{z:?}");
    }

    #[test]
    fn pixels_without_variance_are_left_out_if_equal_and_infinite_if_not() {
        let z = ZScores::new([(0.0, 0.0), (1.0, 1.0), (0.0, 0.0), (-1e-9, 0.0), (-3.0, 1.0)].into_iter());
        assert_eq!((z.tests, z.equal_without_variance, z.different_without_variance), (3, 2, 1));
        assert_eq!((z.mean, z.largest), (-1.0, f64::INFINITY));
        assert!((z.spread - 8f64.sqrt()).abs() < 1e-12);
        assert_eq!(z.tails.map(|tail| tail.fraction), [0.5, 0.0, 0.0], "3 is not beyond 3");
        let none = ZScores::new([(0.0, 0.0)].into_iter());
        assert_eq!((none.tests, none.mean, none.of_mean, none.spread, none.largest), (0, 0.0, 0.0, 0.0, 0.0));
        assert_eq!(ZScores::new([(1.0, 0.0)].into_iter()).of_mean, f64::INFINITY);
    }

    /// The numbers in the documentation of the module.
    #[test]
    fn few_samples_make_long_tails() {
        let pixels = 480_000;
        let bound = normal::two_sided_bound(sidak_p_value(0.01, pixels));
        assert!((bound - 5.6).abs() < 0.05, "{bound}");
        for (samples, expected) in [(8.0, 30.0), (64.0, 0.06)] {
            let t = StudentsT::new(0.0, 1.0, 2.0 * (samples - 1.0)).expect("valid");
            let beyond = 2.0 * t.cdf(-bound) * pixels as f64;
            assert!((beyond / expected - 1.0).abs() < 0.1, "{samples} samples: {beyond}");
        }
    }
}
