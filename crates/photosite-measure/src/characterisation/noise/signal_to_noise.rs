//! Signal over noise, as textbooks define it.

use serde::Serialize;

use super::knowledge::Knowledge;
use crate::characterisation::Decibel;

/// Signal over noise: (μ − black)/σ, with σ the temporal noise where it is known, and what the plane leaves otherwise.
/// `None` where there is no signal or no noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SignalToNoise {
    /// (μ − black)/σ.
    pub ratio: Option<f64>,
    /// Ratio in decibels, 20·log₁₀ of the ratio.
    pub db: Option<f64>,
    /// Ratio in bits, log₂ of the ratio.
    pub bits: Option<f64>,
    /// Ratio at the noisiest pixel, (μ − black)/max σ: the worst case.
    pub worst_ratio: Option<f64>,
    /// Worst ratio in decibels, 20·log₁₀ of the ratio.
    pub worst_db: Option<f64>,
    /// Bits of an ideal converter of the same range and noise, log₂((white − black)/(σ·√12)).
    pub effective_bits: Option<f64>,
    /// Contrast of the image's structure against its noise.
    pub contrast: Option<Contrast>,
}

/// σ_s/σ of the standard deviation σ_s of the noise-free image
/// ([TruccoVerri98](photosite_core::references#truccoverri98) §2.3).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Contrast {
    /// σ_s, the root of the variance of the average image less what is left of the noise in it.
    pub signal_sigma: f64,
    /// σ_s/σ.
    pub ratio: f64,
    /// 10·log₁₀ of it, as Trucco and Verri have it.
    pub db_of_sigma: f64,
    /// Contrast in decibels, as for powers: 10·log₁₀(σ_s²/σ²).
    pub db: f64,
}

impl SignalToNoise {
    pub(super) fn new(
        known: &Knowledge,
        mean: f64,
        signal_variance: f64,
        sigma: f64,
        largest_sigma: Option<f64>,
    ) -> Self {
        let above_0 = |x: f64| Some(x).filter(|x| x.is_finite() && *x > 0.0);
        let ratio = above_0((mean - known.black) / sigma);
        let worst_ratio = largest_sigma.and_then(|largest| above_0((mean - known.black) / largest));
        let contrast = |ratio: f64| Contrast {
            signal_sigma: signal_variance.sqrt(),
            ratio,
            db_of_sigma: 10.0 * ratio.log10(),
            db: ratio.db(),
        };
        Self {
            ratio,
            db: ratio.map(Decibel::db),
            bits: ratio.map(Decibel::bits),
            worst_ratio,
            worst_db: worst_ratio.map(Decibel::db),
            effective_bits: known
                .white
                .and_then(|white| above_0((white - known.black) / (sigma * 12f64.sqrt())))
                .map(Decibel::bits),
            contrast: above_0(signal_variance.max(0.0).sqrt() / sigma).map(contrast),
        }
    }
}
