//! The sensor's noise in closed form: what [`expose()`](crate::sensor::expose()) does, predicted. It tells a renderer
//! when Monte Carlo noise is small beside it, and a raw file what its noise profile is.

use photosite_core::units::{Decibels, DigitalNumber, Electrons};

use crate::sensor::stages::converter::{bow_dn, dnl_variance_dn2};
use crate::sensor::stages::digital_gain::rounding_variance_e2;
use crate::sensor::{Converter, Exposure, SensorModel};

impl SensorModel {
    /// Variance of a number's temporal noise, referred to electrons ((e⁻)²), at a mean of `mean` photo-electrons, both of the
    /// pixel that is read out (of a bin, of all its pixels together):
    ///
    /// σ² = μ + μ_d + (σ_read² + σ_reset² + σ_row² + σ_column² + σ_flicker² + σ_telegraph² + (1/12 + σ_DNL²)/K²)/s²
    ///
    /// shot noise of light and dark current, noise of the read-out, quantisation (the linear model of
    /// [Emva1288](photosite_core::references#emva1288), whose σ_d² is all but the first and the last), and the rounding
    /// that follows a digital gain and companding. The slope s is 1 but for logarithmic pixels. In a bin of n numbers, what
    /// each brings is there n times, and what they share n² times. Hot pixels and telegraph signals count with their part
    /// of all pixels. Fixed patterns are no temporal noise, and what transmission errors do has no
    /// useful variance. The steps of numbers behind a video curve are those at the signal. What the bandwidth of a video
    /// line takes of it, and what a frame grabber's interpolation does, is left out: they take as much of all other
    /// variance. Valid below saturation, and for amplifiers that are nearly linear.
    pub fn noise_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        let binning = exposure.region.binning;
        let charge = mean.0.max(0.0) + self.thermal_electrons(exposure) * binning.pixels() as f64;
        let slope = self.pixel_slope(charge / binning.pixels() as f64, exposure.time);
        let signal = self.signal(charge, exposure);
        let steps = self.companding_variance(signal, exposure) + self.curve_variance(signal, exposure);
        charge + (self.read_out_variance(exposure) + steps) / (slope * slope)
    }

    /// The noise-free signal of a charge behind the amplifiers, both of the pixel that is read out, e⁻.
    fn signal(&self, charge_e: f64, exposure: &Exposure) -> f64 {
        let [across, down] = exposure.region.binning.numbers();
        let numbers = (across * down) as f64;
        self.amplified(self.pixel_signal(charge_e / numbers, exposure.time)) * numbers
    }

    /// Standard deviation of the amplifiers' noise σ_read in the pixel that is read out: that of n pixels whose numbers
    /// are added, or averaged, is √n times that of one.
    pub fn read_noise(&self, exposure: &Exposure) -> Electrons {
        let [across, down] = exposure.region.binning.numbers();
        Electrons(self.noise.read.0 * ((across * down) as f64).sqrt())
    }

    /// Electrons that heat frees in a pixel on average, those of hot ones shared by all, which is their variance, too.
    fn thermal_electrons(&self, exposure: &Exposure) -> f64 {
        let (temperature, time) = (exposure.temperature, exposure.time);
        let noise = &self.noise;
        noise.dark_electrons(temperature, time).0 + noise.defects.hot * noise.hot_electrons(temperature, time).0
    }

    /// Variance of what the read-out adds, whatever the signal, (e⁻)² of the pixel that is read out.
    fn read_out_variance(&self, exposure: &Exposure) -> f64 {
        let noise = &self.noise;
        let [across, down] = exposure.region.binning.numbers().map(|n| n as f64);
        let pixel = self.pixel_variance(noise.read, exposure);
        // Pixels of a row share its noise, which all of them add.
        let shared = (across * noise.row.0).powi(2) * down + (down * noise.column.0).powi(2) * across;
        let quantisation = |converter: &Converter| {
            (1.0 / 12.0 + dnl_variance_dn2(converter.dnl_dn)) / converter.system_gain(exposure.gain).powi(2)
        };
        let before_merging = self.converter.dual_gain.as_ref().map_or(0.0, |dual| quantisation(&dual.high));
        let converted = (pixel + before_merging + quantisation(&self.converter)) * (across * down);
        converted + shared + rounding_variance_e2(self, exposure)
    }

    /// Variance of what each pixel's read-out adds by itself before the signal becomes a number, (e⁻)².
    fn pixel_variance(&self, read: Electrons, exposure: &Exposure) -> f64 {
        let noise = &self.noise;
        let gaussian = [read, noise.reset.standard_deviation(exposure.temperature), noise.flicker.noise];
        gaussian.iter().map(|sigma| sigma.0 * sigma.0).sum::<f64>() + noise.telegraph.variance()
    }

    /// Variance at a mean of `mean` photo-electrons before the signal becomes a number, (e⁻)², without binning; with
    /// two gains, σ_read is that of the one which counts.
    pub fn signal_variance(&self, mean: Electrons, exposure: &Exposure) -> f64 {
        let read = self.branch(mean, exposure.gain).map_or(self.noise.read, |(_, read_noise)| read_noise);
        let shared = self.noise.row.0.powi(2) + self.noise.column.0.powi(2);
        mean.0.max(0.0) + self.thermal_electrons(exposure) + self.pixel_variance(read, exposure) + shared
    }

    /// With two gains, the converter that counts for a charge, and its read noise.
    fn branch(&self, charge: Electrons, gain: Decibels) -> Option<(&Converter, Electrons)> {
        let dual = self.converter.dual_gain.as_deref()?;
        let low = dual.is_clipped(self.amplified(charge.0), gain);
        Some(if low { (&dual.low, dual.low_read_noise) } else { (&dual.high, self.noise.read) })
    }

    /// Variance of what companding takes from the precision of numbers, (e⁻)².
    fn companding_variance(&self, signal_e: f64, exposure: &Exposure) -> f64 {
        let gain = self.system_gain(exposure);
        let level = signal_e * gain;
        let step = self.step_dn((level + f64::from(self.converter.black_level_dn)) as u16);
        (step * step - 1.0) / 12.0 / (gain * gain)
    }

    /// Variance of the converter's steps behind a video curve at a signal, less that of steps of a straight line, (e⁻)².
    fn curve_variance(&self, signal_e: f64, exposure: &Exposure) -> f64 {
        let Some(curve) = self.video.curve else { return 0.0 };
        let gain = self.converter.system_gain(exposure.gain);
        let step = curve.step_dn(signal_e * gain);
        (step * step - 1.0) / 12.0 / (gain * gain)
    }

    /// Electrons at which the pixel that is read out saturates: the full well, the end of the converter's range, or the
    /// end of what a digital gain leaves of that, whichever comes first; of a bin, those of all its pixels together.
    pub fn saturation_capacity(&self, exposure: &Exposure) -> Electrons {
        let converter = &self.converter;
        let before_merging = converter.dual_gain.as_ref().map_or(f64::INFINITY, |dual| dual.low.range_e());
        let binning = exposure.region.binning;
        let [across, down] = binning.numbers();
        let numbers = (across * down) as f64;
        let digital = exposure.digital_gain.factor() * binning.weight() * numbers;
        // A digital gain leaves the start of what the curve has bent.
        let range = self.video.curve.map_or(converter.range_e() / digital, |curve| {
            curve.straightened(curve.range_dn / digital) / converter.conversion_gain_dn_per_e
        });
        let signal = before_merging.min(range) / exposure.gain.factor();
        let charge = self.pixel_charge(self.charge_for(signal), exposure.time) * numbers;
        Electrons((self.full_well.0 * binning.pixels() as f64).min(charge))
    }

    /// Electrons of each of the pixels that are read out as one at which they saturate: their part of
    /// [`saturation_capacity`](Self::saturation_capacity).
    pub fn pixel_saturation(&self, exposure: &Exposure) -> Electrons {
        Electrons(self.saturation_capacity(exposure).0 / exposure.region.binning.pixels() as f64)
    }

    /// Whether signal and noise are other than the linear model of [Emva1288](photosite_core::references#emva1288) has
    /// them, in which signals lie on a line and K·signal is all of the light's noise: amplifiers and converters that
    /// bend, two gains.
    pub fn is_nonlinear(&self) -> bool {
        let converter = &self.converter;
        !converter.amplifier_nonlinearity.is_empty() || converter.inl_dn != 0.0 || converter.dual_gain.is_some()
    }

    /// The number that becomes of a charge with its noise, e⁻, without digital gain, companding and the patterns of
    /// columns and converters, DN.
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

    /// Smallest whole linear number at which a noise-free pixel is saturated, always above the black level.
    pub(in crate::sensor) fn white_level_dn(&self, exposure: &Exposure) -> u16 {
        let linearisation = self.linearisation(exposure);
        linearisation
            .map_or_else(|| self.nonlinear_white_level_dn(exposure), |linearisation| linearisation.white_level_dn)
    }

    /// White level as the converter has it, before anything is made linear.
    pub(in crate::sensor) fn nonlinear_white_level_dn(&self, exposure: &Exposure) -> u16 {
        let converter = &self.converter;
        let signal = self.signal(self.saturation_capacity(exposure).0, exposure);
        let black = f64::from(converter.black_level_dn);
        let level = DigitalNumber(black + self.number_of_signal(signal, exposure) + 0.5);
        (level.0 as u16).clamp(converter.black_level_dn + 1, converter.max_dn())
    }

    /// Noise as a raw file states it: variance of the normalised signal x = (DN − black)/(white − black) is
    /// S·x + O (DNG 1.6 specification, NoiseProfile). With R = white − black in DN,
    ///
    /// S = K/R, O = K²·σ_0²/R²
    ///
    /// where σ_0² is the noise without light, in (e⁻)²; both times what a video line's bandwidth leaves of white noise. What companding adds has no place in it; the noise of logarithmic pixels
    /// and behind a video curve has another form, and `None` is said of it.
    pub(in crate::sensor) fn noise_profile(&self, exposure: &Exposure) -> Option<[f64; 2]> {
        let gain = self.system_gain(exposure);
        let range = f64::from(self.white_level_dn(exposure) - self.converter.black_level_dn);
        let pixels = exposure.region.binning.pixels() as f64;
        let dark = self.thermal_electrons(exposure) * pixels + self.read_out_variance(exposure);
        let left = self.video.low_pass.map_or(1.0, |low_pass| low_pass.noise_power());
        let is_straight = self.logarithmic.is_none() && self.video.curve.is_none();
        is_straight.then_some([left * gain / range, left * dark * (gain / range).powi(2)])
    }
}
