//! Per-pixel z-scores and how they are distributed.
//!
//! Two estimates a and b of the same quantity, with the variances of their means, give z = (a − b)/√(var a + var b).
//! Where both estimate the same quantity and are normally distributed, z follows N(0, 1): mean 0, spread 1,
//! 4.55 % beyond 2, 0.27 % beyond 3, 63 in a million beyond 4.
//!
//! **From few samples they do not.** A variance is estimated from the same n samples as its mean, so that z of normal
//! samples follows Student's t with 2·(n − 1) degrees of freedom: among 480 000 numbers, with the bound of
//! [`Verdict`](super::Verdict) at |z| = 5.6, one expects 30 beyond it from 8 samples a pixel on either side, 0.06 from
//! 64, and 0.01 from very many. Samples of light transport are skew besides: rare bright paths that have not come yet are
//! missing from the mean and from the variance alike, which makes tails longer. A stratified sampler's variance is too
//! large, since it is computed as if samples were independent, and the spread falls below 1
//! ([Jung20](crate::references#jung20) discuss all three).

use serde::Serialize;

use crate::math::normal;
use crate::math::statistics::{Moments, kolmogorov_smirnov, kolmogorov_smirnov_p_value};

/// How the z-scores of a channel are distributed. Mean, spread, tails and distance are those of the finite ones.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ZScores {
    /// z-scores, infinite ones included.
    pub tests: usize,
    /// Pixels left out: equal, without any variance.
    pub equal_without_variance: usize,
    /// Pixels with infinite z: different, without any variance.
    pub different_without_variance: usize,
    /// Mean, 0 if pictures agree.
    pub mean: f64,
    /// Standard deviation, 1 if pictures agree and their variances are right.
    pub spread: f64,
    /// What lies far out.
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
    /// Of the z-scores of pixels; `None` stands for pixels that are equal without any variance.
    pub(super) fn new(z_scores: impl Iterator<Item = Option<f64>>) -> Self {
        let mut equal_without_variance = 0;
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
        Self {
            tests: finite.len() + infinite.len(),
            equal_without_variance,
            different_without_variance: infinite.len(),
            mean: moments.mean(),
            spread: moments.variance().sqrt(),
            tails: [2.0, 3.0, 4.0].map(tail),
            largest: finite.iter().chain(&infinite).fold(0.0, |largest, z| z.abs().max(largest)),
            ks_distance,
            ks_p_value: kolmogorov_smirnov_p_value(ks_distance, finite.len()),
        }
    }
}
