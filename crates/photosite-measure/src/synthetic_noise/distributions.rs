//! Random numbers of mean 0 and variance 1, and the factors of speckle.

use rand::{Rng, RngExt};
use rand_distr::{Exp1, Gamma, StandardNormal};

/// A symmetric distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Symmetric {
    /// Kurtosis 3.
    Normal,
    /// exp(−√2·|n|)/√2, kurtosis 6.
    Laplace,
    /// Uniform distribution from −√3 to √3, kurtosis 9/5.
    Uniform,
}

impl Symmetric {
    /// A number of mean 0 and variance 1.
    pub(super) fn sample(self, random: &mut impl Rng) -> f64 {
        match self {
            Self::Normal => random.sample(StandardNormal),
            Self::Laplace => {
                // An exponential number has the variance 1, and with a random sign the mean square 2.
                let size: f64 = random.sample(Exp1);
                let sign = if random.random::<bool>() { 1.0 } else { -1.0 };
                sign * size * std::f64::consts::FRAC_1_SQRT_2
            }
            Self::Uniform => 3f64.sqrt() * (2.0 * random.random::<f64>() - 1.0),
        }
    }
}

/// The distribution of intensities in speckle of a contrast C in (0, 1]: a gamma distribution of shape 1/C² and mean 1,
/// which for C = 1 is the exponential one of fully developed speckle ([Goodman07](photosite_core::references#goodman07)
/// §3.2, and §4.1 for sums of independent patterns). `None` without contrast.
pub(super) fn speckle(contrast: f64) -> Option<Gamma<f64>> {
    let looks = 1.0 / (contrast * contrast);
    Gamma::new(looks, 1.0 / looks).ok().filter(|_| contrast > 0.0 && looks.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use photosite_core::math::philox::Philox;

    const COUNT: usize = 200_000;

    /// Mean, and second to fourth central moment.
    fn moments(numbers: &[f64]) -> [f64; 4] {
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        let moment = |n: i32| numbers.iter().map(|x| (x - mean).powi(n)).sum::<f64>() / numbers.len() as f64;
        [mean, moment(2), moment(3), moment(4)]
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        // Moments m₄, m₆, m₈ of numbers of variance 1.
        for (distribution, [fourth, sixth, eighth]) in [
            (Symmetric::Normal, [3.0, 15.0, 105.0]),
            (Symmetric::Laplace, [6.0, 90.0, 2520.0]),
            (Symmetric::Uniform, [9.0 / 5.0, 27.0 / 7.0, 9.0]),
        ] {
            let numbers: Vec<f64> = (0..COUNT).map(|i| distribution.sample(&mut Philox::new(4, i as u64))).collect();
            let [mean, variance, skew, kurtosis] = moments(&numbers);
            // Standard errors √(⟨x²ⁿ⟩ − ⟨xⁿ⟩²)/√N, those of central moments no larger to this order; 5 of them.
            let within = |square: f64, moment: f64| 5.0 * ((square - moment * moment) / COUNT as f64).sqrt();
            assert!(mean.abs() < within(1.0, 0.0), "{distribution:?}: {mean}");
            assert!((variance - 1.0).abs() < within(fourth, 1.0), "{distribution:?}: {variance}");
            assert!(skew.abs() < within(sixth, 0.0), "{distribution:?}: {skew}");
            assert!((kurtosis - fourth).abs() < within(eighth, fourth), "{distribution:?}: {kurtosis}");
        }
    }

    #[test]
    fn speckle_has_the_mean_1_and_the_contrast_asked_for() {
        for contrast in [0.1, 0.5, 1.0] {
            let distribution = speckle(contrast).expect("a contrast");
            let numbers: Vec<f64> = (0..COUNT).map(|i| Philox::new(5, i as u64).sample(distribution)).collect();
            let [mean, variance, third, _] = moments(&numbers);
            let c2 = contrast * contrast;
            assert!((mean - 1.0).abs() < 5.0 * contrast / (COUNT as f64).sqrt(), "{mean}");
            // The kurtosis of a gamma distribution is 3 + 6·C².
            let error = c2 * ((2.0 + 6.0 * c2) / COUNT as f64).sqrt();
            assert!((variance - c2).abs() < 5.0 * error, "{variance}");
            // Skewness 2·C.
            assert!((third - 2.0 * c2 * c2).abs() < 0.1 * c2, "{third}");
        }
        assert!(speckle(0.0).is_none() && speckle(1e-200).is_none());
    }
}
