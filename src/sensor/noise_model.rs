//! The sensor's noise in closed form: what [`expose()`](super::expose()) does, foretold. It tells a renderer when Monte
//! Carlo noise is small beside it, and a raw file what its noise profile is.

use crate::units::{DigitalNumber, Electrons};

use super::converter::dnl_variance_dn2;
use super::{Converter, Exposure, SensorModel};

impl SensorModel {
    /// Variance of a pixel's temporal noise, referred to electrons ((e⁻)²), at a mean of `mean` photo-electrons:
    ///
    /// σ² = μ + μ_d + σ_read² + σ_reset² + σ_row² + σ_column² + σ_flicker² + σ_telegraph² + (1/12 + σ_DNL²)/K²
    ///
    /// shot noise of light and dark current, noise of the read-out, quantisation (the linear model of
    /// [Emva1288](crate::references#emva1288), whose σ_d² is all but the first and the last). Hot pixels and telegraph
    /// signals count with their part of all pixels. Fixed patterns are no temporal noise, and what transmission errors do
    /// has no useful variance. Valid below saturation, and for amplifiers that are nearly linear.
    pub fn noise_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        mean.0.max(0.0) + self.dark_variance(exposure)
    }

    /// The part of [`Self::noise_variance`] that is there without light, (e⁻)².
    fn dark_variance(&self, exposure: &Exposure) -> f64 {
        let noise = &self.noise;
        let (temperature, time) = (exposure.temperature, exposure.time);
        let dark = noise.dark_electrons(temperature, time).0;
        let hot = noise.defects.hot * noise.hot_electrons(temperature, time).0;
        let gaussian = [noise.read, noise.reset.standard_deviation(temperature), noise.row, noise.column];
        let gaussian: f64 = gaussian.iter().chain([&noise.flicker.noise]).map(|sigma| sigma.0 * sigma.0).sum();
        let quantisation = |converter: &Converter| {
            (1.0 / 12.0 + dnl_variance_dn2(converter.dnl_dn)) / converter.system_gain(exposure.gain).powi(2)
        };
        let before_merging = self.converter.dual_gain.as_ref().map_or(0.0, |dual| quantisation(&dual.high));
        dark + hot + gaussian + noise.telegraph.variance() + before_merging + quantisation(&self.converter)
    }

    /// Electrons at which a pixel saturates: the full well or the end of the converter's range, whichever comes first.
    pub fn saturation_capacity(&self, exposure: &Exposure) -> Electrons {
        let converter = &self.converter;
        let range = |converter: &Converter| {
            let range_dn = f64::from(converter.max_dn() - converter.black_level_dn);
            self.charge_for(range_dn / converter.system_gain(exposure.gain))
        };
        let before_merging = converter.dual_gain.as_ref().map_or(f64::INFINITY, |dual| range(&dual.low));
        Electrons(self.full_well.0.min(range(converter)).min(before_merging))
    }

    /// Smallest whole digital number at which a noise-free pixel is saturated, always above the black level.
    pub(super) fn white_level_dn(&self, exposure: &Exposure) -> u16 {
        let converter = &self.converter;
        let signal = self.amplified(self.saturation_capacity(exposure).0);
        let black = f64::from(converter.black_level_dn);
        let level = DigitalNumber(black + signal * converter.system_gain(exposure.gain) + 0.5);
        (level.0 as u16).clamp(converter.black_level_dn + 1, converter.max_dn())
    }

    /// The same noise as a raw file tells it: variance of the normalised signal x = (DN − black)/(white − black) is
    /// S·x + O (DNG 1.6 specification, NoiseProfile). With R = white − black in DN,
    ///
    /// S = K/R, O = K²·σ_0²/R²
    ///
    /// where σ_0² is the noise without light, in (e⁻)².
    pub(super) fn noise_profile(&self, exposure: &Exposure) -> [f64; 2] {
        let gain = self.converter.system_gain(exposure.gain);
        let range = f64::from(self.white_level_dn(exposure) - self.converter.black_level_dn);
        [gain / range, self.dark_variance(exposure) * (gain / range).powi(2)]
    }
}
