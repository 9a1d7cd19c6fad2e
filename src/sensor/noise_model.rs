//! The sensor's noise in closed form: what [`expose()`](super::expose()) does, foretold. It tells a renderer when Monte
//! Carlo noise is small beside it, and a raw file what its noise profile is.

use crate::units::{Decibels, DigitalNumber, Electrons};

use super::converter::{bow_dn, dnl_variance_dn2};
use super::{Converter, Exposure, SensorModel};

impl SensorModel {
    /// Variance of a pixel's temporal noise, referred to electrons ((e⁻)²), at a mean of `mean` photo-electrons:
    ///
    /// σ² = μ + μ_d + σ_read² + σ_reset² + σ_row² + σ_column² + σ_flicker² + σ_telegraph² + (1/12 + σ_DNL²)/K²
    ///
    /// shot noise of light and dark current, noise of the read-out, quantisation (the linear model of
    /// [Emva1288](crate::references#emva1288), whose σ_d² is all but the first and the last). Hot pixels and telegraph
    /// signals count with their part of all pixels; with two gains, σ_read is that of the one which counts. Fixed patterns
    /// are no temporal noise, and what transmission errors do has no useful variance. Valid below saturation, and for
    /// amplifiers that are nearly linear.
    pub fn noise_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        let quantisation = |converter: &Converter| {
            (1.0 / 12.0 + dnl_variance_dn2(converter.dnl_dn)) / converter.system_gain(exposure.gain).powi(2)
        };
        let before_merging = self.branch(mean, exposure.gain).map_or(0.0, |(converter, _)| quantisation(converter));
        self.signal_variance(mean, exposure) + before_merging + quantisation(&self.converter)
    }

    /// The part of it that is there before signals become numbers, (e⁻)².
    pub fn signal_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        let noise = &self.noise;
        let (temperature, time) = (exposure.temperature, exposure.time);
        let dark = noise.dark_electrons(temperature, time).0;
        let hot = noise.defects.hot * noise.hot_electrons(temperature, time).0;
        let read = self.branch(mean, exposure.gain).map_or(noise.read, |(_, read_noise)| read_noise);
        let gaussian =
            [read, noise.reset.standard_deviation(temperature), noise.row, noise.column, noise.flicker.noise];
        let gaussian: f64 = gaussian.iter().map(|sigma| sigma.0 * sigma.0).sum();
        mean.0.max(0.0) + dark + hot + gaussian + noise.telegraph.variance()
    }

    /// With two gains, the converter that counts for a charge, and its read noise.
    fn branch(&self, charge: Electrons, gain: Decibels) -> Option<(&Converter, Electrons)> {
        let dual = self.converter.dual_gain.as_deref()?;
        let low = dual.is_clipped(self.amplified(charge.0), gain);
        Some(if low { (&dual.low, dual.low_read_noise) } else { (&dual.high, self.noise.read) })
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

    /// Whether signal and noise are other than the linear model of [Emva1288](crate::references#emva1288) has them, in which
    /// signals lie on a line and K·signal is all of the light's noise: amplifiers and converters that bend, two gains.
    pub fn is_nonlinear(&self) -> bool {
        let converter = &self.converter;
        !converter.amplifier_nonlinearity.is_empty() || converter.inl_dn != 0.0 || converter.dual_gain.is_some()
    }

    /// The number that becomes of a charge with its noise, e⁻, without patterns of columns and of converters, DN.
    pub fn number(&self, charge: Electrons, gain: Decibels) -> f64 {
        let signal = self.amplified(charge.0.min(self.full_well.0));
        let convert = |converter: &Converter, signal: f64| {
            let max = f64::from(converter.max_dn());
            let level = f64::from(converter.black_level_dn) + converter.system_gain(gain) * signal;
            (level + bow_dn(converter.inl_dn, level / max)).clamp(0.0, max).round()
        };
        let merged = self.branch(charge, gain).map_or(signal, |(converter, _)| {
            (convert(converter, signal) - f64::from(converter.black_level_dn)) / converter.system_gain(gain)
        });
        convert(&self.converter, merged)
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
        [gain / range, self.noise_variance(Electrons(0.0), exposure) * (gain / range).powi(2)]
    }
}
